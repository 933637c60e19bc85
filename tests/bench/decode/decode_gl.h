/* Our own materials, decoded by shaders on one GL device.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_DECODE_GL_H
#define OPENBTF_TESTS_BENCH_DECODE_GL_H

#include "decoding.h"

/* Rows of a material in every way to decode it that is wanted on this device, and of its fetches alone. all:
 * every subset in every way, not those of --quick. Errors: those of decoding_estimate_material. */
btf_result decode_gl_material(decoding *d, decode_rig *rig, const char *device, const decode_material *m,
                              bool all);
/* Rows of smaller and smaller pictures. */
void decode_gl_sizes(decoding *d, decode_rig *rig, const char *device, const decode_material *m);

#endif
