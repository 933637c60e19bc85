/* OpenBTF: the GLSL that decodes a material.
 *
 * The text is a library: no #version, no main, no uniform but its samplers (and, without `precise`, one
 * uint that stays 0). Put it behind your #version and #extension lines and call
 *
 *     vec3 btf_evaluate(vec2 uv, vec3 l, vec3 v)
 *
 * or, where a surface is seen from afar and the material has levels of detail,
 *
 *     vec3 btf_evaluate_level(vec2 uv, vec3 l, vec3 v, int level)
 *
 * with, say, int(btf_level(dFdx(uv), dFdy(uv)) + 0.5) for the level.
 *
 * It works in GLSL 330 core to 460, ESSL 300 (WebGL2) to 320, and Vulkan GLSL. What a compiler finds unused
 * costs nothing: an effect that is left out leaves no code and no fetch behind.
 *
 * What this does not do: it makes no GL call and compiles nothing (gl.h uploads the textures).
 *
 * Thread rule: every function is pure.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SHADER_H
#define OPENBTF_SHADER_H

#include <openbtf/material.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum btf_interpolation {
    BTF_INTERPOLATION_LINEAR = 0,  /**< three neighbouring views and three lights, blended */
    BTF_INTERPOLATION_NEAREST = 1, /**< the nearest sampled view and light */
} btf_interpolation;

typedef enum btf_filter {
    BTF_FILTER_TEXEL = 0,    /**< the texel that holds uv */
    BTF_FILTER_BILINEAR = 1, /**< four decoded texels, blended */
} btf_filter;

typedef enum btf_math {
    BTF_MATH_EXACT = 0, /**< the bits of FORMAT.md */
    BTF_MATH_FAST = 1,  /**< the device's own log2 and exp2, any order */
} btf_math;

typedef enum btf_bindings {
    BTF_BINDINGS_NONE = 0,   /**< `uniform`: set them with btf_gl_bind or glUniform1i */
    BTF_BINDINGS_GL = 1,     /**< `layout(binding = n) uniform`: GLSL 420, ESSL 310 */
    BTF_BINDINGS_VULKAN = 2, /**< `layout(set = s, binding = n) uniform` */
} btf_bindings;

/** Directions that never change. The shader fetches no table for them: their neighbours are constants. What
 * is handed to btf_evaluate must be this direction, bit for bit. */
typedef enum btf_fixed {
    BTF_FIXED_VIEW = 1,
    BTF_FIXED_LIGHT = 2,
} btf_fixed;

/** How to decode. All zeros is a good default; a null pointer means that too. */
typedef struct btf_shader_options {
    size_t struct_size;  /**< sizeof(btf_shader_options) */
    uint32_t leave_out;  /**< btf_effect bits not to decode; default 0: decode all that the file has */
    uint32_t components; /**< at most this many residual components; default 0: all */
    btf_interpolation interpolation;
    btf_filter filter;
    btf_math math;
    int have_precise; /**< 1: your shader enables GL_ARB_gpu_shader5 or GL_EXT_gpu_shader5, so that
                         `precise` can be used below GLSL 400 and ESSL 320; default 0: told from __VERSION__
                       */
    btf_bindings bindings;
    uint32_t first_binding;  /**< binding of texture id i is first_binding + i */
    uint32_t descriptor_set; /**< for Vulkan */
    const char *prefix;      /**< the names' prefix, so that two materials fit one program; default "btf".
                                  Lower-case letters, digits and single underscores, at most 32, first a letter,
                                  last no underscore; macros get the same in upper case. */
    uint32_t fixed;          /**< btf_fixed bits; default 0 */
    float fixed_view[3];     /**< unit, of the tangent frame; read where `fixed` says so */
    float fixed_light[3];
} btf_shader_options;

/** @return a bit (1 << btf_texture_id) for each texture that the shader of these options reads. */
uint32_t btf_shader_textures(const btf_material_info *info, const btf_shader_options *options);

/** Assembles the text for a material. *out_text is to be freed with btf_free; NULL on error.
 *  Errors: BTF_ERROR_USAGE (prefix, enum values), BTF_ERROR_MEMORY. */
btf_result btf_shader_source(const btf_material *material, const btf_shader_options *options,
                             const btf_log *log, char **out_text);

/** @return the library text (shaders/openbtf.glsl with its includes), for use with macros of your own. */
const char *btf_shader_library(void);

/** What a device can break. */
#define BTF_SELF_TEST_LIST(X)                                                                              \
    X(BTF_SELF_TEST_CONTRACTION, 1, "contraction", "a * b + c is rounded once")                            \
    X(BTF_SELF_TEST_REASSOCIATION, 2, "reassociation", "sums or products are regrouped or factored")       \
    X(BTF_SELF_TEST_ROUNDING, 4, "rounding", "sums or products are not rounded to nearest even")           \
    X(BTF_SELF_TEST_FLUSH, 8, "flush", "normal numbers are flushed to zero")                               \
    X(BTF_SELF_TEST_CONVERSION, 16, "conversion", "integers, floats and bits do not convert exactly")      \
    X(BTF_SELF_TEST_INTEGER, 32, "integer", "32-bit integers wrap, shift or divide otherwise")             \
    X(BTF_SELF_TEST_ELEMENTARY, 64, "elementary", "log2, exp2, pow or reciprocal give other bits")         \
    X(BTF_SELF_TEST_LEVELS, 128, "levels",                                                                 \
      "fetches from another mip level than asked for (matters to "                                         \
      "materials of several levels of detail alone)")

typedef enum btf_self_test {
#define BTF_SELF_TEST_ENUM(id, bit, name, text) id = bit,
    BTF_SELF_TEST_LIST(BTF_SELF_TEST_ENUM)
#undef BTF_SELF_TEST_ENUM
} btf_self_test;

/** Writes the names of the bits in @p failures, comma-separated, "none" for 0, to a buffer of @p size
 * bytes. */
void btf_self_test_names(uint32_t failures, char *out_names, size_t size);

/** @return text with `uint btf_self_test(uint zero)`, which gives the sum of the BTF_SELF_TEST bits that
 * fail when called with a zero that is known at run time only (LEVELS, which takes a texture, is tested by
 * btf_gl_self_test alone). Stands alone; for the same #version as the
 * decoder. */
const char *btf_shader_self_test(void);

#ifdef __cplusplus
}
#endif
#endif
