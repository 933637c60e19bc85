/* Contexts of a hidden GLFW window.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_CONTEXT_GLFW_H
#define OPENBTF_TOOLS_CONTEXT_GLFW_H

#include "context_provider.h"

extern const context_provider context_glfw;

#endif
