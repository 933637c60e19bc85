/* OpenBTF: the GLSL or WGSL that decodes a material.
 *
 * The text is a library: no #version, no main, no uniform but its samplers (and, without `precise`, one
 * uint that stays 0). Put it behind your #version and #extension lines and in front of everything else of
 * yours, macros above all: one that is named like a parameter or a variable of the text, `#define l` say,
 * would rewrite it. In front of it belong only the BTF_ macros that its opening comments explain. Then call
 *
 *     vec3 btf_evaluate(vec2 uv, vec3 l, vec3 v)
 *
 * uv: texture coordinates, (0, 0) the lower left corner of the image, repeated beyond [0, 1); l and v: unit
 * vectors to the light and to the viewer in the tangent frame (x along +u, y along +v, z the normal). The
 * result is linear radiance, Rec. 709, cosine included, where the light's irradiance at normal incidence is
 * pi (a white Lambertian surface gives l.z); 0 where l or v is below the horizon.
 *
 * Or, where a surface is seen from afar and the material has levels of detail,
 *
 *     vec3 btf_evaluate_level(vec2 uv, vec3 l, vec3 v, int level)
 *
 * with, say, int(btf_level(dFdx(uv), dFdy(uv)) + 0.5) for the level: 0 is the finest, and a number beyond
 * the last is the last.
 *
 * Or, where frames are accumulated (TAA, a path tracer), one of the neighbours in place of all of them, picked with its
 * weight (btf_shader_options.picks says which are picked):
 *
 *     vec3 btf_evaluate_stochastic(vec2 uv, vec3 l, vec3 v, uvec3 random)
 *
 * with btf_random(uvec3(pixel, frame)) or blue noise of your own for the random numbers; the mean is
 * btf_evaluate_radiance_blend(uv, l, v). Both take a level as well, and _between takes btf_level() as it is.
 *
 * It works in GLSL 330 core to 460, ESSL 300 (WebGL2) to 320, and Vulkan GLSL. For WebGPU, with BTF_LANGUAGE_WGSL, it
 * is the same text in WGSL, made of the GLSL, with the same functions: fn btf_evaluate(uv: vec2f, l: vec3f, v: vec3f)
 * -> vec3f. It needs no entry point, no extension and no order among your own declarations. Code that a compiler finds
 * unused costs nothing: an effect that is left out leaves no code and no fetch behind.
 *
 * No function here makes a GL call or compiles anything (gl.h uploads the textures).
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

/** How sampled directions are combined for a direction between them. */
typedef enum btf_interpolation {
    BTF_INTERPOLATION_LINEAR = 0,  /**< three neighbouring views and three lights, blended */
    BTF_INTERPOLATION_NEAREST = 1, /**< the nearest sampled view and light */
} btf_interpolation;

/** How texels are combined for a texture coordinate between their centres. */
typedef enum btf_filter {
    BTF_FILTER_TEXEL = 0,    /**< the texel that holds uv */
    BTF_FILTER_BILINEAR = 1, /**< four decoded texels, blended */
    BTF_FILTER_STEEP = 2,    /**< likewise, with weights that leave a texel's middle half to itself */
} btf_filter;

/** The arithmetic of the shader. */
typedef enum btf_math {
    BTF_MATH_EXACT = 0, /**< that of FORMAT.md: the same bits on every device */
    BTF_MATH_FAST = 1,  /**< the device's own log2 and exp2, in any order of operations */
} btf_math;

/** How samplers are declared. */
typedef enum btf_bindings {
    BTF_BINDINGS_NONE = 0,   /**< `uniform`: set them with btf_gl_bind or glUniform1i */
    BTF_BINDINGS_GL = 1,     /**< `layout(binding = n) uniform`: GLSL 420, ESSL 310 */
    BTF_BINDINGS_VULKAN = 2, /**< `layout(set = s, binding = n) uniform` */
} btf_bindings;

/** The language of the text. */
typedef enum btf_language {
    BTF_LANGUAGE_GLSL = 0, /**< GLSL, ESSL and Vulkan GLSL */
    /** WebGPU's. Textures are `@group(descriptor_set) @binding(first_binding + id)`, read by textureLoad alone; with
     * exact math `var<uniform> btf_zero: u32` has binding first_binding + BTF_TEXTURE_COUNT + 3: a buffer of 16 bytes,
     * all 0, for WGSL has no `precise`. Members `bindings` and `have_precise` have no meaning. */
    BTF_LANGUAGE_WGSL = 1,
} btf_language;

/** Directions that never change, a bit mask. The shader fetches no table for them: their neighbours are constants.
 * The direction handed to btf_evaluate must then be the fixed one, bit for bit. Where gloss is decoded, each view has
 * lights of its own, and a fixed light is looked up like any other. */
typedef enum btf_fixed {
    BTF_FIXED_VIEW = 1,  /**< the direction to the viewer, btf_shader_options.fixed_view */
    BTF_FIXED_LIGHT = 2, /**< the direction to the light, btf_shader_options.fixed_light */
} btf_fixed;

/** The part of decoding that is done once, into texture `folded` (openbtf/fold.h), which the shader then reads. */
typedef enum btf_fold {
    BTF_FOLD_NONE = 0,  /**< nothing */
    BTF_FOLD_LIGHT = 1, /**< a light that never changes */
    BTF_FOLD_BOTH = 2,  /**< a light and a view: radiance, where relief is not decoded */
    /** a light and a view, where relief is decoded: what the views around it show, which the shader blends as ever */
    BTF_FOLD_NEIGHBOURS = 3,
    /** the sum of lights that never change, under a view that does; it rounds and clamps otherwise than the decoder
     * (openbtf/fold.h) */
    BTF_FOLD_SUM = 4,
} btf_fold;

/** The neighbours of which a stochastic decode picks one, with its weight, in place of blending all. The mean over
 * random numbers is btf_evaluate_radiance_blend, which decodes each neighbour to radiance before it blends: where views
 * or lights are blended as roots, that is brighter than btf_evaluate. */
typedef enum btf_picks {
    BTF_PICK_NONE = 0,  /**< blend all: btf_evaluate and its kin */
    BTF_PICK_VIEW = 1,  /**< the view: little noise */
    BTF_PICK_LIGHT = 2, /**< the view and the light */
    BTF_PICK_ALL = 3,   /**< the view, the light and the texel of the filter: the quickest */
} btf_picks;

/** How to decode. All zeros is a good default; a null pointer means that too. */
typedef struct btf_shader_options {
    size_t struct_size; /**< sizeof(btf_shader_options) */
    uint32_t leave_out; /**< btf_effect bits not to decode; default 0: decode all that the file has */
    /** At most so many components of the residual, or units, where its store is factors; default 0: all. */
    uint32_t components;
    btf_interpolation interpolation; /**< of directions; default linear */
    btf_filter filter;               /**< of texels; default the texel that holds uv */
    btf_math math;                   /**< default exact */
    /** 1: your shader enables GL_ARB_gpu_shader5 or GL_EXT_gpu_shader5, so that `precise` can be used below GLSL 400
     * and ESSL 320; default 0: __VERSION__ decides. */
    int have_precise;
    btf_bindings bindings;   /**< how samplers are declared; default without a binding */
    uint32_t first_binding;  /**< the binding of texture id i is first_binding + i; default 0 */
    uint32_t descriptor_set; /**< for Vulkan; default 0 */
    /** The prefix of all names, so that two materials fit one program; default "btf". Lower-case letters, digits and
     * single underscores, at most 32; the first a letter, the last no underscore. Macros get it in upper case. */
    const char *prefix;
    uint32_t fixed;       /**< btf_fixed bits; default 0 */
    float fixed_view[3];  /**< unit, of the tangent frame; read with BTF_FIXED_VIEW */
    float fixed_light[3]; /**< unit, of the tangent frame; read with BTF_FIXED_LIGHT */
    /** Other than none: btf_evaluate_stochastic and btf_evaluate_radiance_blend stand in place of btf_evaluate; default
     * BTF_PICK_NONE. */
    btf_picks picks;
    /** The fold that was made; default BTF_FOLD_NONE. The shader reads texture `folded`, bound to first_binding +
     * BTF_TEXTURE_COUNT, and of the material's textures only those that say which texels of it to read. The directions
     * handed to btf_evaluate must be those that were folded, bit for bit; with BTF_FOLD_SUM the light may be any above
     * the horizon. The neighbours of a fixed view are constants with BTF_FOLD_LIGHT, with BTF_FOLD_SUM and, where it is
     * the view that was folded, with BTF_FOLD_NEIGHBOURS; BTF_FOLD_BOTH ignores a fixed view, every fold a fixed light.
     * Cannot be combined with picks. */
    btf_fold fold;
    btf_language language; /**< default GLSL */
} btf_shader_options;

/** @return a bit (1 << btf_texture_id) for each texture that the shader of these options reads. @p options may be
 * NULL. */
uint32_t btf_shader_textures(const btf_material_info *info, const btf_shader_options *options);

/** Assembles the text for a material: its macros, then the library text, 0-terminated ASCII. *out_text is freed with
 * btf_free; NULL on error. @p options and @p log may be NULL. Errors: BTF_ERROR_USAGE (the prefix, the value of an
 * enum, a fixed direction that is not a unit vector above the horizon), BTF_ERROR_UNSUPPORTED (a fold that is not
 * defined: btf_fold_check), BTF_ERROR_MEMORY. */
btf_result btf_shader_source(const btf_material *material, const btf_shader_options *options,
                             const btf_log *log, char **out_text);

/** WGSL of GLSL: of a text of BTF_ macros, then btf_shader_library() or btf_shader_self_test(), and functions of yours
 * behind it in the part of GLSL that these are written in. The macro WGSL is defined, and ESSL 300 is assumed. A
 * uniform needs `layout(set = s, binding = n)`, which BTF_UNIFORM(n) gives those of the library. In the result names
 * that several functions share have the types of their parameters behind them (btf_mul_vec3f_f32); parameters that are
 * `out` or `inout` are pointers. Every other name stays, but for one that WGSL reserves or predeclares: it has __
 * behind it (filter__). Names that the translation adds have __ in them as well; as in GLSL, no name of @p glsl may
 * have it, nor be _ alone. An overloaded function whose name in WGSL would have __ in it, or be another name of the
 * text, is refused, too. *out_text is freed with btf_free; NULL on error. @p log may be NULL. Errors:
 * BTF_ERROR_UNSUPPORTED (something of GLSL that the decoder does not use, or such a name; macros that are expanded
 * through more than 2^22 = 4,194,304 tokens in all or are more than 200 deep in one another; an expression more than
 * 1000 operators and calls high, or brackets or statements more than 200 deep; the message names the place),
 * BTF_ERROR_MEMORY. */
btf_result btf_shader_wgsl(const char *glsl, const btf_log *log, char **out_text);

/** Random numbers of a counter, say column, row and frame of a pixel, the same as btf_random of the shader: PCG3D
 * (Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 9(3), 2020). */
void btf_random(const uint32_t counter[3], uint32_t out_random[3]);

/** @return the library text without the macros of a material, for use behind BTF_ macros of your own, which its
 * opening comments explain; static; installed as share/openbtf/openbtf.glsl. */
const char *btf_shader_library(void);

/** The rules of arithmetic that a device can break: identifier, bit, name, and how the device breaks it. */
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
      "materials of several levels of detail alone)")                                                      \
    X(BTF_SELF_TEST_FACTORS, 256, "factors",                                                               \
      "packed factors are multiplied, shifted or fetched otherwise (matters to materials whose "           \
      "residual is factors alone)")                                                                        \
    X(BTF_SELF_TEST_LISTS, 512, "lists",                                                                   \
      "a fetch takes another layer than a fetch before it named (matters to materials whose points lie "   \
      "in lists alone)")

/** The rules of BTF_SELF_TEST_LIST, a bit mask. */
typedef enum btf_self_test {
#define BTF_SELF_TEST_ENUM(id, bit, name, text) id = bit,
    BTF_SELF_TEST_LIST(BTF_SELF_TEST_ENUM)
#undef BTF_SELF_TEST_ENUM
} btf_self_test;

/** Writes the names of the bits in @p failures, comma-separated, "none" for 0, to a buffer of @p size bytes:
 * 0-terminated, cut where it is too small; nothing where @p size is 0. */
void btf_self_test_names(uint32_t failures, char *out_names, size_t size);

/** @return GLSL with the function `uint btf_self_test(uint zero)`. Called with a 0 that is known at run time only, it
 * gives the sum of the BTF_SELF_TEST bits that fail, but for LEVELS, LISTS and the fetches of FACTORS: these take
 * textures, and btf_gl_self_test alone tests them. The text is static and needs no other; it is for the same #version
 * as the decoder, and like it goes in front of your own macros. */
const char *btf_shader_self_test(void);

#ifdef __cplusplus
}
#endif
#endif
