/* OpenBTF as a WebAssembly module: what the module exports.
 *
 * Its only caller is openbtf/module.js beside this folder; users call openbtf/index.js. A pointer is an address in the
 * module's memory, a text ends with a 0 byte, arrays are those of material.h, shader.h and plan.h of the library. A
 * call that fails says why by btf_web_result() and btf_web_message() until the next call that can fail. Texts and
 * records that are returned belong to the module and last until the next call of the same function, but where it is
 * said otherwise. One thread.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WEB_EXPORTS_H
#define OPENBTF_WEB_EXPORTS_H

#include <openbtf/plan.h>

/** A function of the module, under its own name. */
#define BTF_WEB_EXPORT(name) __attribute__((export_name(#name)))

/** Number of this interface: the two sides refuse to work with another one's. */
#define BTF_WEB_INTERFACE 2

/** An open material and what was made of it. */
typedef struct btf_web_material btf_web_material;

/** How to decode: btf_shader_options, in words of 32 bits. */
typedef struct btf_web_options {
    uint32_t leave_out;                     /**< btf_effect bits */
    uint32_t components;                    /**< at most so many; 0: all */
    uint32_t interpolation;                 /**< btf_interpolation */
    uint32_t filter;                        /**< btf_filter */
    uint32_t math;                          /**< btf_math */
    uint32_t have_precise;                  /**< 0 or 1 */
    uint32_t fixed;                         /**< btf_fixed bits */
    float fixed_view[3];                    /**< unit, of the tangent frame */
    float fixed_light[3];                   /**< unit, of the tangent frame */
    uint32_t picks;                         /**< btf_picks */
    uint32_t language;                      /**< btf_language */
    uint32_t descriptor_set, first_binding; /**< of WGSL */
    const char *prefix;                     /**< of names; NULL: "btf" */
} btf_web_options;

/** btf_range in words of 32 bits. */
typedef struct btf_web_range {
    float theta[2], phi[2]; /**< degrees */
    uint32_t fixed;         /**< 1: `direction` alone */
    float direction[3];     /**< unit, of the tangent frame */
} btf_web_range;

/** A scene, and the tolerance of the plan for it in dB. */
typedef struct btf_web_scene {
    btf_web_range view, light; /**< directions to the viewer, and to the light */
    float pixels;              /**< side of a texel in pixels */
    uint32_t lights;           /**< evaluations a pixel */
    uint32_t interpolate;      /**< 1: never nearest directions */
    float tolerance;           /**< dB below the full decode */
} btf_web_scene;

/** Arguments of evaluations and how to decode, for btf_web_evaluate. */
typedef struct btf_web_evaluations {
    uint32_t count;      /**< evaluations */
    const float *uv;     /**< [count][2] */
    const float *lights; /**< [count][3]; [3] with BTF_FIXED_LIGHT in `fixed` */
    const float *views;  /**< [count][3]; [3] with BTF_FIXED_VIEW in `fixed` */
    uint32_t fixed;      /**< btf_fixed bits: directions that are given once */
    uint32_t level;      /**< of detail; beyond the last it is the last */
    /** 1: by the reference decoder, one by one; 0: by the library, faster. The bits are equal. */
    uint32_t reference;
    const uint32_t *random; /**< [count][3], where options pick; the reference alone picks */
    float *rgb;             /**< out: [count][3] */
} btf_web_evaluations;

/** A texture as it lies in the module's memory. */
typedef struct btf_web_texture {
    uint32_t format;                /**< btf_format; BTF_FORMAT_NONE: the material does not have it */
    uint32_t is_array;              /**< 1: a 2D array texture */
    uint32_t width, height, layers; /**< texels; of the residual, the layers that so many components need */
    const void *data;               /**< the material's, until it is closed */
    uint32_t size;                  /**< bytes of these layers */
} btf_web_texture;

/** @return BTF_WEB_INTERFACE. */
uint32_t btf_web_interface(void);

/** @return memory of @p size bytes, aligned to 16; NULL when there is none left. */
void *btf_web_allocate(uint32_t size);

/** Frees what btf_web_allocate() gave; NULL is accepted. */
void btf_web_release(void *memory);

/** @return the btf_result of the last call that can fail. */
uint32_t btf_web_result(void);

/** @return its message, without a newline; "" where it succeeded. */
const char *btf_web_message(void);

/** @return the static text of a btf_result, e.g. "bad file". */
const char *btf_web_result_text(uint32_t result);

/** Opens the file of @p size bytes at @p data, which are not needed afterwards: btf_material_open_memory(). NULL
 * where that fails. The material is closed by btf_web_close(). */
btf_web_material *btf_web_open(const void *data, uint32_t size);

/** Frees a material; NULL is accepted. */
void btf_web_close(btf_web_material *material);

/** @return all of btf_material_info, the errors that the encoder measured, and counts, as JSON. NULL: out of memory. */
const char *btf_web_info(const btf_web_material *material);

/** @return [count][3], the sampled directions: to the light where @p lights is 1, else to the viewer. They belong to the
 * material. */
const float *btf_web_directions(const btf_web_material *material, uint32_t lights);

/** @return a texture (a btf_texture_id) of a level of detail; of the residual as many layers as @p components of it
 * need (0: all). */
const btf_web_texture *btf_web_get_texture(const btf_web_material *material, uint32_t level, uint32_t id,
                                           uint32_t components);

/** @return the name of a texture, static; NULL beyond the last. */
const char *btf_web_texture_name(uint32_t id);

/** @return a bit (1 << btf_texture_id) for each texture that the shader of these options reads. */
uint32_t btf_web_textures_read(const btf_web_material *material, const btf_web_options *options);

/** @return the text of btf_shader_source(); NULL where that fails. It lasts until the next call. */
const char *btf_web_source(const btf_web_material *material, const btf_web_options *options);

/** @return the GLSL with `uint btf_self_test(uint zero)`, static. */
const char *btf_web_self_test_source(void);

/** @return the same in WGSL, with the zero at binding 23 of group 0; NULL where that fails. It lasts until the next call. */
const char *btf_web_self_test_wgsl(void);

/** @return the names of self-test bits, comma-separated. */
const char *btf_web_self_test_names(uint32_t failures);

/** @return the plan of btf_plan_effects() for a scene, as JSON; NULL where that fails. */
const char *btf_web_plan(const btf_web_material *material, const btf_web_scene *scene);

/** @return {"psnrLinear":, "psnrSrgb":}, what btf_plan_predict() says of this scene's plan decoded with other effects
 * and components; NULL where that fails. */
const char *btf_web_predict(const btf_web_material *material, const btf_web_scene *scene, uint32_t effects,
                            uint32_t components);

/** @return the material of btf_material_restrict() by the plan for a scene, closed by btf_web_close(); NULL where that
 * fails. */
btf_web_material *btf_web_restrict(const btf_web_material *material, const btf_web_scene *scene);

/** @return the material of btf_material_to_tight(), closed by btf_web_close(); NULL where that fails. */
btf_web_material *btf_web_to_tight(const btf_web_material *material);

/** Evaluates radiance. @return the btf_result. */
uint32_t btf_web_evaluate(btf_web_material *material, const btf_web_options *options,
                          const btf_web_evaluations *evaluations);

#endif
