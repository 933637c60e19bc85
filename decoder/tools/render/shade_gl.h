/* GL devices.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_SHADE_GL_H
#define OPENBTF_RENDER_SHADE_GL_H

#include "shader_class.h"

extern const shader_class shader_class_gl;

#endif
