/* OpenBTF: only what a scene calls for.
 *
 * A scene says from where a material is seen and lit; a plan is the cheapest way to decode it there whose
 * error, as the encoder measured it (btf_material_effect_errors), stays within a tolerance of the full
 * decode; a restricted material holds what the plan reads and nothing else.
 *
 *     btf_scene scene = {.struct_size = sizeof scene, .view.theta = {0, 30}};
 *     btf_plan plan;
 *     btf_material *small;
 *     btf_plan_effects(material, &scene, 0.5f, &plan);
 *     btf_material_restrict(material, &plan, log, &small);
 *     ... btf_shader_source(small, &plan.shader, ...), btf_gl_upload(small, {.shader = &plan.shader}, ...)
 *
 * Thread rule: every function is pure.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_PLAN_H
#define OPENBTF_PLAN_H

#include <openbtf/cost.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Directions of the tangent frame, degrees (FORMAT.md section 1). All zeros: every direction. */
typedef struct btf_range {
    float theta[2]; /**< least and greatest, within 0..90; both 0: 0..90 */
    float phi[2];   /**< azimuths from phi[0] counter-clockwise to phi[1], within -360..360; equal: all */
    int fixed;      /**< 1: one direction alone, `direction`; theta and phi are not read */
    float direction[3]; /**< unit, z > 0; read with fixed */
} btf_range;

/** The scene that is to be shown. All zeros after struct_size: everything, one light, a texel a pixel. */
typedef struct btf_scene {
    size_t struct_size;    /**< sizeof(btf_scene) */
    btf_range view, light; /**< directions to the viewer, and to the light */
    float pixels;          /**< side of a texel on the screen in pixels, where it is largest; 0: 1 */
    uint32_t lights;       /**< evaluations a pixel; 0: 1 */
    int interpolate;       /**< 1: never nearest directions, which jump when view or light move */
    /** Of the device that shows it; NULL: those of llvmpipe. Read during the call; plan->scene keeps the pointer. */
    const btf_cost_model *costs;
    /** 1: the lights, wherever in their range, stand still and are the same in every pixel: their sum can be folded
     * (btf_gl_fold_run_lights), with a view that is fixed to radiance, else as BTF_FOLD_SUM. */
    int still_lights;
    int no_fold; /**< 1: nothing will be folded (openbtf/fold.h), and no plan counts on it */
    /** Pixels that are shown before what is fixed changes; a fold that needs more of them to pay is not made. 0: enough
     * for every fold. */
    double folded_pixels;
    size_t folded_bytes; /**< most bytes of a fold, a larger one is not made; 0: any */
} btf_scene;

/** How to decode a scene, and what that costs. Cost is in nanoseconds a pixel of the device that the
 * prices were fitted to (openbtf/cost.h): only ratios mean something. PSNR in dB as in btf_effect_errors, over
 * the directions of the scene, uniform in solid angle. */
typedef struct btf_plan {
    size_t struct_size; /**< sizeof(btf_plan) */
    btf_scene scene;    /**< the scene that the plan is for */
    /** For the material and for its restriction, a fixed view or light included. You may set bindings, prefix,
     * math and filter; the costs below are of the filter that the plan came with, btf_plan_cost() of another. */
    btf_shader_options shader;
    uint32_t effects;             /**< btf_effect bits decoded */
    uint32_t components;          /**< of the residual decoded; units, where its store is factors */
    uint32_t level;               /**< of detail; finer ones are not needed */
    uint32_t textures;            /**< a bit (1 << btf_texture_id) for each texture that the shader reads */
    uint32_t views, lights;       /**< sampled directions that the scene can reach */
    size_t gpu_bytes;             /**< of the restricted material, as in btf_material_info */
    size_t full_gpu_bytes;        /**< of the whole material */
    float cost, full_cost;        /**< of the plan, and of the full decode: btf_plan_cost */
    int measured;                 /**< 0: the file has no effect errors; everything is decoded, PSNR is 0 */
    float psnr_linear, psnr_srgb; /**< predicted for the plan */
    float full_psnr_linear, full_psnr_srgb; /**< predicted for the full decode of the same level */
    /** Estimated against the truth between the samples, of this plan and of the full decode: what the bands of
     * btf_between_errors say of the level that the scene meets, and what the plan adds to the full decode's error
     * there. The table overstates, so that this is a bound rather than a figure. 0 where the file says nothing of the
     * level, or view and light are samples, which have nothing between them. */
    float between_psnr_linear, between_psnr_srgb;
    float full_between_psnr_linear, full_between_psnr_srgb; /**< likewise, of the full decode */
    /** How the plan can be folded (openbtf/fold.h), where the light of the scene is fixed, or its lights stand still;
     * BTF_FOLD_NONE where it cannot, or where the scene makes no such fold. The view is folded as well where it is
     * fixed. fold_bytes is of one light: BTF_FOLD_BOTH and BTF_FOLD_SUM keep the sum of several lights in as many bytes
     * (btf_gl_fold_run_lights), the other folds take as much for each light. The error that BTF_FOLD_SUM makes by
     * clamping otherwise than the decoder does not count against the tolerance. */
    btf_fold fold;
    size_t fold_bytes;  /**< of the folded texture, beside gpu_bytes; else 0 */
    float folded_cost;  /**< of a pixel that reads folded textures, of all lights as `cost`; else `cost` */
    double fold_pixels; /**< pixels after which the fold has paid for itself; else 0 */
    /** The number by which plans of one material are compared, the less the better: time relative to the full decode's,
     * folded where that is less, plus bytes relative to its; 2 for the full decode itself. */
    float price;
} btf_plan;

/** Finds the plan of least price (btf_plan.price) whose PSNR, linear and sRGB-coded, is at most @p tolerance dB below
 * the full decode's where the scene looks:
 *
 *  - The candidates are the ways to decode that the table of effect errors has (btf_material_effect_errors). Their
 *    errors are averaged over the bands that the scene's ranges meet. A view or light that never changes counts by its
 *    distance from the nearest sample: errors are larger at samples than between them.
 *  - Where view or light lie between the samples, and the file tells what is lost there at the level
 *    (btf_between_errors), the full decode's error is half of that, 3 dB less, since the table is of samples left out,
 *    at double the gap. (On BRICKS64 the table is, ring by ring, 3.1 to 3.7 dB below what images between the samples
 *    show; no file keeps such truth.) Where view and light are samples, or the file has no such rows, the error against
 *    the data counts.
 *  - A plan adds its squared difference to the full decode (btf_material_effect_differences), since errors of decoding
 *    and of interpolation are independent. Where the file has no such row, the mean of two numbers takes its place: how
 *    much the error at the samples grows, which is too much, and how much the error against the interpolated data
 *    grows, which is too little where relief moves texels.
 *  - Relief and gloss are left out where they change nothing: where the view is fixed and a sample, and relief at
 *    levels where it has ended (btf_material_info.relief_end). Elsewhere the interpolated data cannot tell what they
 *    are worth: without one of them the error grows by half of what btf_between_errors say of the level (of relief rows
 *    3 and 7, under a light that is a sample 1 and 5; of gloss 3 and 11), which is at double the gap; without both by
 *    the sum. Files without these rows keep both. btf_plan_worth says what each counts.
 *  - The level is the coarsest whose texels are not larger than a pixel; the filter is bilinear where a texel is larger
 *    than a pixel and a half.
 *  - A plan that can be folded counts by its folded cost where the scene makes the fold; the bytes of the fold are not
 *    weighed. Gloss keeps a fixed light under a view that is not fixed from being folded.
 *
 * psnr_linear and psnr_srgb, against the data, are those without relief or gloss where the file has a row of effect
 * errors of that. Where it has none and a plan leaves either out, they ignore that: they are of the way with them.
 * Allocates no memory. Errors: BTF_ERROR_USAGE (a range that holds no direction, a negative or infinite number). */
btf_result btf_plan_effects(const btf_material *material, const btf_scene *scene, float tolerance,
                            btf_plan *out_plan);

/** Sets *out_linear and *out_srgb to the PSNR, in dB, that the file's table of effect errors predicts for the scene,
 * level and directions of a plan decoded another way: with the btf_effect bits @p effects and so many components or
 * units of the residual (0 without it). Without relief or gloss, where that was not measured, the error is that of the
 * way with them, and what leaving them out changes of the full decode's. Errors: BTF_ERROR_UNSUPPORTED (the encoder
 * measured neither; both are 0). */
btf_result btf_plan_predict(const btf_material *material, const btf_plan *plan, uint32_t effects,
                            uint32_t components, float *out_linear, float *out_srgb);

/** Sets *out_linear and *out_srgb to the dB by which @p effect, BTF_EFFECT_RELIEF or BTF_EFFECT_GLOSS, lessens the
 * error between the samples where the scene of a plan looks, at its level: what btf_plan_effects holds against the
 * tolerance to leave it out. 0 where it changes nothing there: where the view is a sample, and relief where it has
 * ended. Errors: BTF_ERROR_UNSUPPORTED (the material has no such effect, or the file does not say what it is worth;
 * both are 0). */
btf_result btf_plan_worth(const btf_material *material, const btf_plan *plan, btf_effect effect,
                          float *out_linear, float *out_srgb);

/** @return the counts of one evaluation by a shader of these options where @p scene is shown (NULL: anything), with the
 * neighbours that fixed directions really have. A neighbouring view of weight 0 is counted like the others but for the
 * components of a residual that has more than six groups of four, a loop, which a rasteriser that masks runs once and a
 * compiler that branches not at all. */
btf_decode_counts btf_plan_counts(const btf_material *material, const btf_shader_options *options,
                                  const btf_scene *scene);

/** @return the cost of one evaluation, in nanoseconds: btf_plan_counts by the prices of scene->costs. */
float btf_plan_cost(const btf_material *material, const btf_shader_options *options,
                    const btf_scene *scene);

/** Makes a material with only what a plan reads: views and lights that its ranges reach (all where the file's
 * triangulation cannot be kept otherwise), its effects, components, its level and coarser ones, centres in use; layout
 * `tight`. *out_material is closed with btf_material_close.
 *
 * Packed points of which a plan decodes the gain alone stay packed, with shifts of 0, since no other store holds their
 * gains; packed points of which it decodes the shift alone become the texture `shift`. Lists of points stay lists, of a
 * gain of 1 where the plan decodes the shift alone, unless so few views are kept that they take no fewer bytes than
 * packed points would. Heights are kept as they are, in texels of the material's level 0
 * (btf_material_info.relief_level), and go where relief has ended at the plan's level. Where gloss is decoded all
 * lights are kept, since any may be that of a neighbouring view.
 *
 * Inside the ranges the new material decodes, with plan->shader, bit for bit to what the whole material decodes to;
 * level plan->level of the whole is level 0 of the new one. Outside, a direction counts as the nearest one that was
 * kept (section 6). It can be saved and opened like any material. Errors: BTF_ERROR_USAGE (a plan that is not of this
 * material), BTF_ERROR_MEMORY. */
btf_result btf_material_restrict(const btf_material *material, const btf_plan *plan, const btf_log *log,
                                 btf_material **out_material);

#ifdef __cplusplus
}
#endif
#endif
