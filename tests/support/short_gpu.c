/* Preloaded into a tool under test, this simulates a GPU without memory for folds: it refuses, with GL_OUT_OF_MEMORY,
 * array textures of RGBA32UI of more than two layers that are made without texels. Only folds are made so.
 *
 * SPDX-License-Identifier: MIT
 */
#include <dlfcn.h>
#include <stdint.h>
#include <string.h>

typedef void (*function)(void);
typedef void (*make_image)(uint32_t target, int32_t level, int32_t internal, int32_t width, int32_t height,
                           int32_t depth, int32_t border, uint32_t format, uint32_t type,
                           const void *pixels);
typedef uint32_t (*get_error)(void);

static make_image next_make_image;
static get_error next_get_error;
static int refused;

static void refuse_folds(uint32_t target, int32_t level, int32_t internal, int32_t width, int32_t height,
                         int32_t depth, int32_t border, uint32_t format, uint32_t type,
                         const void *pixels) {
    enum { GL_RGBA32UI = 0x8D70 };
    if (internal == GL_RGBA32UI && depth > 2 && !pixels) {
        refused = 1;
    } else {
        next_make_image(target, level, internal, width, height, depth, border, format, type, pixels);
    }
}

static uint32_t tell(void) {
    enum { GL_OUT_OF_MEMORY = 0x0505 };
    const int was_refused = refused;
    refused = 0;
    return was_refused ? GL_OUT_OF_MEMORY : next_get_error();
}

/* Replaces the function of GL that this file fakes; the others stay. */
static function put_between(function found, const char *name) {
    if (strcmp(name, "glTexImage3D") == 0) {
        next_make_image = (make_image)found;
        return (function)refuse_folds;
    }
    if (strcmp(name, "glGetError") == 0) {
        next_get_error = (get_error)found;
        return (function)tell;
    }
    return found;
}

/* The function of the same name in the libraries after this one. */
#define NEXT(name) ((function(*)(const char *))(uintptr_t)dlsym(RTLD_NEXT, name))

function OSMesaGetProcAddress(const char *name);
function OSMesaGetProcAddress(const char *name) {
    return put_between(NEXT("OSMesaGetProcAddress")(name), name);
}

function glfwGetProcAddress(const char *name);
function glfwGetProcAddress(const char *name) {
    return put_between(NEXT("glfwGetProcAddress")(name), name);
}
