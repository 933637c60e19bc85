/* Contexts of EGL without window, surface or display server: OpenGL and OpenGL ES.
 *
 * Tried in order: the surfaceless platform of Mesa, then each EGL device (which is how NVIDIA's driver
 * works headless).
 *
 * SPDX-License-Identifier: MIT
 */
#include "context_egl.h"

#include <stdio.h>
#include <stdlib.h>

#ifdef HAVE_EGL
#include <EGL/egl.h>
#include <EGL/eglext.h>

typedef struct egl {
    EGLDisplay display;
    EGLContext context;
} egl;

/* Makes a context on an initialised display; EGL_NO_CONTEXT when it cannot. */
static EGLContext make_context(EGLDisplay display, const context_request *request) {
    const EGLint config_attributes[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE,
                                        request->es ? EGL_OPENGL_ES3_BIT : EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = EGL_NO_CONFIG_KHR;
    EGLint count = 0;
    if (!eglBindAPI(request->es ? EGL_OPENGL_ES_API : EGL_OPENGL_API) ||
        !eglChooseConfig(display, config_attributes, &config, 1, &count) || count < 1) {
        return EGL_NO_CONTEXT;
    }
    EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                           request->major,
                           EGL_CONTEXT_MINOR_VERSION,
                           request->minor,
                           request->es ? EGL_NONE : EGL_CONTEXT_OPENGL_PROFILE_MASK,
                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                           EGL_NONE};
    return eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
}

/* True when the display gave a context and made it current. */
static int try_display(egl *self, EGLDisplay display, const context_request *request) {
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL)) {
        return 0;
    }
    EGLContext context = make_context(display, request);
    if (context != EGL_NO_CONTEXT) {
        if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
            self->display = display;
            self->context = context;
            return 1;
        }
        eglDestroyContext(display, context);
    }
    eglTerminate(display);
    return 0;
}

static int try_devices(egl *self, const context_request *request) {
    enum { MAX_DEVICES = 16 };
    EGLDeviceEXT devices[MAX_DEVICES];
    EGLint count = 0;
    PFNEGLQUERYDEVICESEXTPROC query = (PFNEGLQUERYDEVICESEXTPROC)eglGetProcAddress("eglQueryDevicesEXT");
    PFNEGLGETPLATFORMDISPLAYEXTPROC get =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    if (!query || !get || !query(MAX_DEVICES, devices, &count)) {
        return 0;
    }
    for (EGLint i = 0; i < count; ++i) {
        if (try_display(self, get(EGL_PLATFORM_DEVICE_EXT, devices[i], NULL), request)) {
            return 1;
        }
    }
    return 0;
}

static void *create(const context_request *request, char *why, size_t why_size) {
    egl *self = calloc(1, sizeof *self);
    if (!self) {
        snprintf(why, why_size, "out of memory");
        return NULL;
    }
    EGLDisplay surfaceless =
        eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    /* BTF_EGL_DEVICE in the environment has EGL devices tried first, so that a GPU is found before Mesa's software. */
    int devices_first = getenv("BTF_EGL_DEVICE") != NULL;
    if ((devices_first && try_devices(self, request)) || try_display(self, surfaceless, request) ||
        (!devices_first && try_devices(self, request))) {
        return self;
    }
    snprintf(why, why_size, "EGL cannot create an OpenGL %s%d.%d context without a surface",
             request->es ? "ES " : "", request->major, request->minor);
    free(self);
    return NULL;
}

static void destroy(void *context) {
    egl *self = context;
    eglMakeCurrent(self->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(self->display, self->context);
    eglTerminate(self->display);
    free(self);
}

static btf_gl_function get_proc_address(void *self, const char *name) {
    (void)self;
    return (btf_gl_function)eglGetProcAddress(name);
}

const context_provider context_egl = {"egl", create, destroy, get_proc_address};

#else

const context_provider context_egl = {"egl", NULL, NULL, NULL}; /* not built */

#endif
