/* Contexts of a GLFW window that is never shown; needs a display server (Xvfb will do).
 *
 * SPDX-License-Identifier: MIT
 */
#include "context_glfw.h"

#include <stdio.h>
#include <stdlib.h>

#ifdef HAVE_GLFW
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

static void *create(const context_request *request, char *why, size_t why_size) {
    const char *reason = NULL;
    if (!glfwInit()) {
        glfwGetError(&reason);
        snprintf(why, why_size, "GLFW: %s", reason ? reason : "cannot start");
        return NULL;
    }
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    glfwWindowHint(GLFW_CLIENT_API, request->es ? GLFW_OPENGL_ES_API : GLFW_OPENGL_API);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, request->major);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, request->minor);
    if (!request->es) {
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    }
    GLFWwindow *window = glfwCreateWindow(16, 16, "OpenBTF", NULL, NULL);
    if (!window) {
        glfwGetError(&reason);
        snprintf(why, why_size, "GLFW: %s", reason ? reason : "no window");
        glfwTerminate();
        return NULL;
    }
    glfwMakeContextCurrent(window);
    return window;
}

static void destroy(void *window) {
    glfwDestroyWindow(window);
    glfwTerminate();
}

static btf_gl_function get_proc_address(void *self, const char *name) {
    (void)self;
    return (btf_gl_function)glfwGetProcAddress(name);
}

const context_provider context_glfw = {"glfw", create, destroy, get_proc_address};

#else

const context_provider context_glfw = {"glfw", NULL, NULL, NULL}; /* not built */

#endif
