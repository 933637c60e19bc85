/* The list of devices, and dispatch to their providers.
 *
 * SPDX-License-Identifier: MIT
 */
#include "context.h"

#include "context_egl.h"
#include "context_glfw.h"
#include "context_osmesa.h"
#include <stdio.h>
#include <stdlib.h>

struct context {
    const context_provider *provider;
    void *self;
};

const context_device context_devices[] = {
    {"osmesa", &context_osmesa, {0, 4, 5}, "llvmpipe", "450 core", 0},
    {"osmesa-330", &context_osmesa, {0, 3, 3}, "llvmpipe", "330 core", 0},
    {"osmesa-330-precise", &context_osmesa, {0, 3, 3}, "llvmpipe", "330 core", 1},
    {"softpipe", &context_osmesa, {0, 3, 3}, "softpipe", "330 core", 0},
    {"egl", &context_egl, {0, 4, 5}, NULL, "450 core", 0},
    {"egl-es300", &context_egl, {1, 3, 0}, NULL, "300 es", 0},
    {"egl-es310", &context_egl, {1, 3, 1}, NULL, "310 es", 0},
    {"egl-es320", &context_egl, {1, 3, 2}, NULL, "320 es", 0},
    {"glfw", &context_glfw, {0, 3, 3}, NULL, "330 core", 0},
    {0},
};

void context_prepare(const context_device *device) {
    if (device->gallium_driver) {
        setenv("GALLIUM_DRIVER", device->gallium_driver, 1);
    }
}

context *context_create(const context_device *device, char *why, size_t why_size) {
    context *c = malloc(sizeof *c);
    if (!c) {
        snprintf(why, why_size, "out of memory");
        return NULL;
    }
    c->provider = device->provider;
    if (!c->provider->create) {
        snprintf(why, why_size, "this program was built without %s", c->provider->name);
        free(c);
        return NULL;
    }
    c->self = c->provider->create(&device->request, why, why_size);
    if (!c->self) {
        free(c);
        return NULL;
    }
    return c;
}

void context_destroy(context **c) {
    if (!c || !*c) {
        return;
    }
    (*c)->provider->destroy((*c)->self);
    free(*c);
    *c = NULL;
}

btf_gl_function context_get_proc_address(void *c, const char *name) {
    const context *self = c;
    return self->provider->get_proc_address(self->self, name);
}
