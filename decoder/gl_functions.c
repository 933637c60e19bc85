/* Loads the functions of OpenGL that the library uses, and holds the steps with them that several of its files take.
 *
 * SPDX-License-Identifier: MIT
 */
#include "gl_functions.h"

#include "result.h"
#include <string.h>

btf_result btfi_gl_load(const btf_gl_options *options, const btf_log *log, btfi_gl_functions *out_gl) {
    memset(out_gl, 0, sizeof *out_gl);
    if (!options || options->struct_size < offsetof(btf_gl_options, shader) || !options->get_proc_address) {
        return btfi_fail(log, BTF_ERROR_USAGE, "gl: the options have no get_proc_address");
    }
#define LOAD(name, result, parameters)                                                                     \
    {                                                                                                      \
        btf_gl_function function = options->get_proc_address(options->user, "gl" #name);                   \
        if (!function)                                                                                     \
            return btfi_fail(log, BTF_ERROR_UNSUPPORTED, "gl: the context lacks the function gl" #name);   \
        out_gl->name = (result(BTFI_GL_CALL *) parameters)function;                                        \
    }
    BTFI_GL_FUNCTIONS(LOAD)
    const char *version = (const char *)out_gl->GetString(GL_VERSION);
    if (!version) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED, "gl: no context is current");
    }
    out_gl->is_es = strncmp(version, "OpenGL ES", 9) == 0;
    out_gl->GetIntegerv(GL_MAJOR_VERSION, &out_gl->major);
    out_gl->GetIntegerv(GL_MINOR_VERSION, &out_gl->minor);
    int have = 10 * out_gl->major + out_gl->minor, need = out_gl->is_es ? 30 : 33;
    if (have < need) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED, "gl: the context is \"%s\", but %s or later is needed",
                         version, out_gl->is_es ? "OpenGL ES 3.0" : "OpenGL 3.3");
    }
    if (!out_gl->is_es || have >= 32) {
        BTFI_GL_BUFFER_FUNCTIONS(LOAD)
    }
    if (out_gl->is_es) {
        return BTF_OK;
    }
    if (have >= 41) {
        BTFI_GL_VIEWPORT_FUNCTIONS(LOAD)
    }
    BTFI_GL_DESKTOP_FUNCTIONS(LOAD)
    int32_t profile = 0; /* some drivers say 0 of a context that was made the old way: not core either */
    out_gl->GetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
    out_gl->is_compatibility = !(profile & GL_CONTEXT_CORE_PROFILE_BIT);
    if (out_gl->is_compatibility) {
        BTFI_GL_COMPATIBILITY_FUNCTIONS(LOAD)
    }
#undef LOAD
    return BTF_OK;
}

uint32_t btfi_gl_errors(const btfi_gl_functions *gl) {
    enum { AT_MOST = 64 }; /* a lost context may report for ever */
    uint32_t first = GL_NO_ERROR;
    for (int i = 0; i < AT_MOST; ++i) {
        uint32_t error = gl->GetError();
        if (error == GL_NO_ERROR) {
            break;
        }
        if (first == GL_NO_ERROR) {
            first = error;
        }
    }
    return first;
}

/* The unpacking state; entry 0 is absent from OpenGL ES. */
static const uint32_t unpack_names[BTFI_UNPACK_COUNT] = {
    GL_UNPACK_SWAP_BYTES,  GL_UNPACK_ALIGNMENT,   GL_UNPACK_ROW_LENGTH,  GL_UNPACK_SKIP_ROWS,
    GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_IMAGES, GL_UNPACK_IMAGE_HEIGHT};

/* A compatibility context may change the texels of an upload by these, and does nothing with these values;
 * those behind the first nine belong to GL_ARB_imaging. */
enum { TRANSFERS_ALWAYS = 9 };
#define FOUR(name, neutral)                                                                                \
    {name, neutral}, {name + 1, neutral}, {name + 2, neutral}, {                                           \
        name + 3, neutral                                                                                  \
    }
static const struct {
    uint32_t name;
    float neutral;
} transfers[BTFI_TRANSFER_COUNT] = {
    {GL_MAP_COLOR, 0},
    {GL_RED_SCALE, 1},
    {GL_RED_BIAS, 0},
    {GL_GREEN_SCALE, 1},
    {GL_GREEN_BIAS, 0},
    {GL_BLUE_SCALE, 1},
    {GL_BLUE_BIAS, 0},
    {GL_ALPHA_SCALE, 1},
    {GL_ALPHA_BIAS, 0},
    FOUR(GL_POST_CONVOLUTION_RED_SCALE, 1),
    FOUR(GL_POST_CONVOLUTION_RED_BIAS, 0),
    FOUR(GL_POST_COLOR_MATRIX_RED_SCALE, 1),
    FOUR(GL_POST_COLOR_MATRIX_RED_BIAS, 0),
};
#undef FOUR
static const uint32_t imagings[BTFI_IMAGING_COUNT] = {
    GL_COLOR_TABLE,
    GL_POST_CONVOLUTION_COLOR_TABLE,
    GL_POST_COLOR_MATRIX_COLOR_TABLE,
    GL_CONVOLUTION_1D,
    GL_CONVOLUTION_2D,
    GL_SEPARABLE_2D,
    GL_HISTOGRAM,
    GL_MINMAX,
};

/* Of a compatibility context: glPixelTransfer and the imaging subset. */
static void save_transfer(const btfi_gl_functions *gl, btfi_gl_unpack *out) {
    const char *extensions = (const char *)gl->GetString(GL_EXTENSIONS);
    const int has_imaging = extensions && strstr(extensions, "GL_ARB_imaging");
    out->transfers = has_imaging ? BTFI_TRANSFER_COUNT : TRANSFERS_ALWAYS;
    out->imagings = has_imaging ? BTFI_IMAGING_COUNT : 0;
    for (int i = 0; i < out->transfers; ++i) {
        gl->GetFloatv(transfers[i].name, &out->transfer[i]);
        gl->PixelTransferf(transfers[i].name, transfers[i].neutral);
    }
    for (int i = 0; i < out->imagings; ++i) {
        out->imaging[i] = gl->IsEnabled(imagings[i]);
        gl->Disable(imagings[i]);
    }
    if (btfi_gl_errors(gl) != GL_NO_ERROR) { /* a context that did not say what it is, and is core */
        out->transfers = out->imagings = 0;
    }
}

static void restore_transfer(const btfi_gl_functions *gl, const btfi_gl_unpack *saved) {
    for (int i = 0; i < saved->transfers; ++i) {
        gl->PixelTransferf(transfers[i].name, saved->transfer[i]);
    }
    for (int i = 0; i < saved->imagings; ++i) {
        if (saved->imaging[i]) {
            gl->Enable(imagings[i]);
        }
    }
}

void btfi_gl_save_unpack(const btfi_gl_functions *gl, btfi_gl_unpack *out) {
    memset(out, 0, sizeof *out);
    gl->GetIntegerv(GL_PIXEL_UNPACK_BUFFER_BINDING, &out->buffer);
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    for (int i = gl->is_es; i < BTFI_UNPACK_COUNT; ++i) {
        gl->GetIntegerv(unpack_names[i], &out->value[i]);
        gl->PixelStorei(unpack_names[i], unpack_names[i] == GL_UNPACK_ALIGNMENT ? 1 : 0);
    }
    if (gl->is_compatibility) {
        save_transfer(gl, out);
    }
}

void btfi_gl_restore_unpack(const btfi_gl_functions *gl, const btfi_gl_unpack *saved) {
    for (int i = gl->is_es; i < BTFI_UNPACK_COUNT; ++i) {
        gl->PixelStorei(unpack_names[i], saved->value[i]);
    }
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, (uint32_t)saved->buffer);
    restore_transfer(gl, saved);
}
