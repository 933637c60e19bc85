/* The CPU as a device, with the bits of the reference decoder.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_SHADE_REFERENCE_H
#define OPENBTF_RENDER_SHADE_REFERENCE_H

#include "shader_class.h"

extern const shader_class shader_class_reference;

#endif
