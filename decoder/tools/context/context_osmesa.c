/* Contexts of OSMesa: Mesa's software rasterisers drawing to memory.
 *
 * SPDX-License-Identifier: MIT
 */
#include "context_osmesa.h"

#include <stdio.h>
#include <stdlib.h>

#ifdef HAVE_OSMESA
#include <GL/osmesa.h>

typedef struct osmesa {
    OSMesaContext context;
    unsigned char pixels[16 * 16 * 4]; /* the default framebuffer, which nothing draws to */
} osmesa;

static void *create(const context_request *request, char *why, size_t why_size) {
    if (request->es) {
        snprintf(why, why_size, "OSMesa does not offer OpenGL ES");
        return NULL;
    }
    osmesa *self = calloc(1, sizeof *self);
    if (!self) {
        snprintf(why, why_size, "out of memory");
        return NULL;
    }
    const int attributes[] = {OSMESA_FORMAT,
                              OSMESA_RGBA,
                              OSMESA_PROFILE,
                              OSMESA_CORE_PROFILE,
                              OSMESA_CONTEXT_MAJOR_VERSION,
                              request->major,
                              OSMESA_CONTEXT_MINOR_VERSION,
                              request->minor,
                              0};
    self->context = OSMesaCreateContextAttribs(attributes, NULL);
    if (!self->context || !OSMesaMakeCurrent(self->context, self->pixels, GL_UNSIGNED_BYTE, 16, 16)) {
        snprintf(why, why_size, "OSMesa cannot create an OpenGL %d.%d core context", request->major,
                 request->minor);
        if (self->context) {
            OSMesaDestroyContext(self->context);
        }
        free(self);
        return NULL;
    }
    return self;
}

static void destroy(void *context) {
    osmesa *self = context;
    OSMesaDestroyContext(self->context);
    free(self);
}

static btf_gl_function get_proc_address(void *self, const char *name) {
    (void)self;
    return (btf_gl_function)OSMesaGetProcAddress(name);
}

const context_provider context_osmesa = {"osmesa", create, destroy, get_proc_address};

#else

const context_provider context_osmesa = {"osmesa", NULL, NULL, NULL}; /* not built */

#endif
