/* OpenBTF: upload of a material to OpenGL 3.3+ or OpenGL ES 3.0+.
 *
 * The caller makes the context, keeps it current during every call here, and hands over how to find GL's
 * functions; nothing is linked. Every call restores the GL state that it touches, but for what its comment
 * says it sets. No state of yours changes what is uploaded: pixel storage, a bound unpack buffer and, in
 * compatibility contexts, pixel transfer (scale, bias, colour maps, the imaging subset but for its colour
 * matrix) are set aside and put back. GL errors that were pending before btf_gl_upload and
 * btf_gl_self_test are taken off GL's queue. Not to be called while a display list is compiled, transform
 * feedback runs, or rendering is conditional.
 *
 * The library makes no context, window, thread, program, framebuffer, sampler object or draw
 * call (the self-test makes some and deletes them), and keeps no copy of the material. Levels of detail are
 * uploaded as mip levels of the same textures; none are made here, and nothing filters: the decoder fetches
 * single texels.
 *
 * Thread rule: a btf_gl belongs to the context it was made in, and is used by one thread at a time.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_GL_H
#define OPENBTF_GL_H

#include <openbtf/shader.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A function of OpenGL, to be cast to its type. */
typedef void (*btf_gl_function)(void);

/** Finds a GL function by its name; glfwGetProcAddress, eglGetProcAddress and the like, wrapped. */
typedef btf_gl_function (*btf_gl_get_proc_address)(void *user, const char *name);

/** How to reach OpenGL, and what to upload. */
typedef struct btf_gl_options {
    size_t struct_size;                       /**< sizeof(btf_gl_options) */
    btf_gl_get_proc_address get_proc_address; /**< must be given */
    void *user;                               /**< handed to get_proc_address */
    const btf_shader_options *shader; /**< only textures that this variant reads are uploaded; NULL: all */
} btf_gl_options;

/** The textures of a material in a GL context, which one thread at a time may use. */
typedef struct btf_gl btf_gl;

/** Sets *out_fits to 1 when every texture that btf_gl_upload would make is within GL_MAX_TEXTURE_SIZE and
 * GL_MAX_ARRAY_TEXTURE_LAYERS, else to 0: a material of layout `paper` may fit after btf_material_to_tight.
 * Errors: BTF_ERROR_USAGE (no get_proc_address), BTF_ERROR_UNSUPPORTED (a function is missing; the context
 * is too old). */
btf_result btf_gl_fits(const btf_material *material, const btf_gl_options *options, const btf_log *log,
                       int *out_fits);

/** Uploads the textures of a material, all its levels of detail; the material may be closed afterwards.
 * *out_gl is freed with btf_gl_destroy. Errors: BTF_ERROR_USAGE (no get_proc_address),
 * BTF_ERROR_UNSUPPORTED (a function is missing; the context is too old; a texture exceeds GL_MAX_TEXTURE_SIZE or
 * GL_MAX_ARRAY_TEXTURE_LAYERS: the message has both numbers), BTF_ERROR_MEMORY (also GL's own). On error
 * *out_gl is NULL and nothing is left behind. @p log may be NULL, as in all calls here. */
btf_result btf_gl_upload(const btf_material *material, const btf_gl_options *options, const btf_log *log,
                         btf_gl **out_gl);

/** Points the samplers of a linked program at the textures. Sets: the uniforms, and the texture bindings of
 * units first_unit .. first_unit + *out_units - 1, where they stay until you bind others (sampler objects
 * of these units are unbound). *out_units, which may be NULL, gets how many units that are: those of the
 * textures that the program reads. @p prefix as in btf_shader_options, NULL for "btf". Errors:
 * BTF_ERROR_USAGE when the program reads a texture that was not uploaded. */
btf_result btf_gl_bind(btf_gl *gl, uint32_t program, uint32_t first_unit, const char *prefix,
                       const btf_log *log, uint32_t *out_units);

/** @return the GL name of a texture, 0 when it was not uploaded. It stays with the btf_gl. */
uint32_t btf_gl_texture(const btf_gl *gl, btf_texture_id id);

/** @return bytes of all texels uploaded, of all levels. */
size_t btf_gl_bytes(const btf_gl *gl);

/** Deletes the textures and sets *gl to NULL. NULL and a pointer to NULL are accepted. */
void btf_gl_destroy(btf_gl **gl);

/** Runs the self-test on the current context, in the newest GLSL that it claims, with `precise` (where
 * there is one) and without: *out_failures gets the BTF_SELF_TEST bits that fail in either. 0: exact
 * decoding works here; with BTF_SELF_TEST_LEVELS, BTF_SELF_TEST_FACTORS or BTF_SELF_TEST_LISTS and no other: of
 * materials of one level of detail, without factors, or without lists of points. Errors:
 * BTF_ERROR_USAGE (no get_proc_address), BTF_ERROR_UNSUPPORTED (missing functions, a shader or framebuffer
 * that GL refuses). */
btf_result btf_gl_self_test(const btf_gl_options *options, const btf_log *log, uint32_t *out_failures);

#ifdef __cplusplus
}
#endif
#endif
