/* GL contexts for tools and tests: OSMesa, EGL without a surface, a hidden GLFW window. The library makes
 * none.
 *
 * Each provider is one file; one that was not built, or that the machine cannot give, says so by name. A
 * process holds one context at a time.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_CONTEXT_H
#define OPENBTF_TOOLS_CONTEXT_H

#include "context_provider.h"

typedef struct context context;

/* A named device: a provider, the context that it is asked for, and the environment it needs. */
typedef struct context_device {
    const char *name;
    const context_provider *provider;
    context_request request;
    const char *gallium_driver; /* value of GALLIUM_DRIVER; NULL: as the environment has it */
    const char *glsl;           /* the #version line's words */
    int enable_gpu_shader5;     /* have_precise through GL_ARB_gpu_shader5 */
} context_device;

/* The devices that tools and tests take by name; the list ends with a NULL name. Those of one driver differ in API and
 * language version, hence in how exactness is kept. */
extern const context_device context_devices[];

/* Sets the environment of a device; to be called before anything loads a GL driver. */
void context_prepare(const context_device *device);

/* Makes a context of the device, and makes it current. NULL with the reason in why[why_size]. */
context *context_create(const context_device *device, char *why, size_t why_size);
void context_destroy(context **c);

/* For btf_gl_options: user is the context. */
btf_gl_function context_get_proc_address(void *c, const char *name);

#endif
