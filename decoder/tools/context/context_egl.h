/* Contexts of EGL.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_CONTEXT_EGL_H
#define OPENBTF_TOOLS_CONTEXT_EGL_H

#include "context_provider.h"

extern const context_provider context_egl;

#endif
