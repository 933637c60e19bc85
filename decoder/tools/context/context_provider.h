/* The providers of contexts: OSMesa, EGL, GLFW.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_CONTEXT_PROVIDER_H
#define OPENBTF_TOOLS_CONTEXT_PROVIDER_H

#include <openbtf/gl.h>
#include <stddef.h>

/* The context to make: OpenGL core (es = 0) or OpenGL ES, of at least this version. */
typedef struct context_request {
    int es, major, minor;
} context_request;

/* The functions of a provider; NULL where it was not built. */
typedef struct context_provider {
    const char *name; /* "osmesa", "egl", "glfw" */
    /* Makes a context current; NULL with the reason in why[why_size]. */
    void *(*create)(const context_request *request, char *why, size_t why_size);
    void (*destroy)(void *self);
    btf_gl_function (*get_proc_address)(void *self, const char *name);
} context_provider;

#endif
