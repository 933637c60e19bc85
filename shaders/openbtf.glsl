/* OpenBTF shaders: everything a shader needs to decode a material. The macros that it takes are
 * explained below.
 *
 * No #version, no main, no uniform but the samplers and the run-time zero; every global name begins with btf_ or BTF_.
 * In ESSL the default precision is highp from here on.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef BTF_OPENBTF_GLSL
#define BTF_OPENBTF_GLSL
#include "options.glsl"
#include "interface.glsl"
#include "exact.glsl"
#include "elementary.glsl"
#include "directions.glsl"
#include "addressing.glsl"
#include "layout.glsl"
#include "shift.glsl"
#include "shadow.glsl"
#include "cluster.glsl"
#include "lafortune.glsl"
#include "residual.glsl"
#include "factors.glsl"
#include "relief.glsl"
#include "gloss.glsl"
#include "compose.glsl"
#include "evaluate.glsl"
#include "stochastic.glsl"
#include "sampling.glsl"
#endif
