/* OpenBTF: folding, which decodes once what is the same in every frame.
 *
 * Where a light never changes, all that a pixel does with it can be done beforehand: for each sampled view
 * and texel, the decoder's own value before views are blended is kept as three floats, with the bits that
 * it has. A pixel then reads one texel of 16 bytes for each neighbouring view (3; 12 with a bilinear
 * filter) in place of all that the material holds, and its radiance has the same bits. Where the view never
 * changes either, the radiance of each texel is kept: one texel (4), as of any textured surface.
 *
 *     btf_shader_options options = {.struct_size = sizeof options, .fold = BTF_FOLD_LIGHT};
 *     if (btf_fold_check(&info, &options, NULL) == BTF_OK) {
 *         btf_gl_fold_create(material, &(btf_gl_options){..., .shader = &options}, 1, log, &fold);
 *         btf_gl_fold_run(fold, textures, 0, 0, light, NULL, log);
 *     }
 *     ... btf_shader_source(material, &options, ...); btf_gl_bind(...);
 *     btf_gl_fold_bind(fold, program, unit, ...);
 *
 * Not every material can be folded for a light alone: an SBRDF depends on the viewer between the samples,
 * and with the effect `gloss` so do the lights of a view; such materials cannot be folded for a light alone.
 * Light and view together can be folded in every material: with the effect `relief`, which reads texels from
 * where the pixel stands between them, the values of the three neighbouring views are kept in place of
 * radiance (BTF_FOLD_NEIGHBOURS), and a pixel reads three texels (12) and marches as before. A view that
 * never changes cannot be folded under a light that does: the texture would have to keep the integer sums of
 * every light and unit, since the decoder rounds them after lights are blended, and these are the numbers
 * that the material holds already; a plan (openbtf/plan.h) cuts the material down to that view's neighbours
 * instead.
 *
 * Several lights are several folds in one texture: a shader adds up btf_evaluate_folded(uv, v, light,
 * level), weighted as it likes. Where light and view are folded to radiance they are added beforehand, too
 * (btf_gl_fold_run_lights, btf_fold_add), and a pixel reads one texel for all: one sum a texel, in the order
 * of the lights. It has the bits of the sum of unfolded radiance of whole texels; a filter, which rounds,
 * then blends sums.
 *
 * Where the view moves, several lights are added up by BTF_FOLD_SUM. Where views are blended as roots, radiance is the
 * square of what is blended: of the sum over the neighbouring views i of weight b_i times root r_il under light l. With
 * the light's weight w_l the sum over lights of these squares is, multiplied out,
 *
 *     sum_i b_i^2 S_ii + 2 sum_{i<j} b_i b_j S_ij,  S_ij = sum_l w_l r_il r_jl
 *
 * of which S_ii is kept for each sampled view and S_ij for every two that a look-up gives together: 4 layers a view, of
 * which a pixel reads 6 texels (24 with a bilinear filter) for any number of lights. Where views are blended as
 * radiance, the sum over lights is kept for each view, and a pixel reads 3.
 *
 * Unlike other folds this one does not have the bits of what it stands for. It rounds otherwise, by less than
 * (lights + 12) 2^-24 of the sum over l of w_l (sum_i b_i |r_il|)^2. And it clamps otherwise, where roots are negative:
 * the decoder takes 0 for a blend below 2^-30, which does not multiply out. S_ii takes 0 for a negative root, and S_ij
 * for a product, of a <= b and b > 0, with a' = max(a, -b) < 0, b' = b + a' / 2: a' b'; 0 where b < 0. So the sum is
 * the decoder's at every sampled view, halfway between two that are neighbours, and wherever no neighbouring view has a
 * negative root. decoder/README.md, Folding, says how far it is off elsewhere. It has the same bits on every device, on
 * the CPU and by GL.
 *
 * BTF_FOLD_SUM is defined where BTF_FOLD_LIGHT is and relief, by which each view shows other texels, is not decoded. It
 * is of lights that have one direction each in the tangent frame: those far away over a flat surface. Over a surface
 * that curves, however slowly, every pixel has other directions to the same lights, and no texture of sums is right for
 * more than one of them.
 *
 * A fold takes views * texels evaluations of one view, about a third of a pixel's each (btf_fold_cost): it
 * pays where the light stands still for more pixels than a third of that.
 *
 * Thread rule: those of material.h and gl.h.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_FOLD_H
#define OPENBTF_FOLD_H

#include <openbtf/evaluate.h>
#include <openbtf/gl.h>
#include <openbtf/plan.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Whether options->fold is defined for a material decoded by @p options (NULL: BTF_OK). Errors, on log,
 * which says why: BTF_ERROR_UNSUPPORTED. */
btf_result btf_fold_check(const btf_material_info *info, const btf_shader_options *options,
                          const btf_log *log);

/** @return the fold of which a pixel reads least, of those that are defined for a material decoded by @p options (their
 * `fold` is not read) where the light is still and, if @p view_is_still, the view too: BTF_FOLD_BOTH, _NEIGHBOURS,
 * _LIGHT; else BTF_FOLD_NONE. */
btf_fold btf_fold_best(const btf_material_info *info, const btf_shader_options *options, int view_is_still);

/** @return the fold of a sum of lights that are still and the same in every pixel, where it is defined for a material
 * decoded by @p options (their `fold` is not read): BTF_FOLD_BOTH if @p view_is_still, else BTF_FOLD_SUM; where it is
 * not, BTF_FOLD_NONE. */
btf_fold btf_fold_best_sum(const btf_material_info *info, const btf_shader_options *options,
                           int view_is_still);

/** The options of the shader that makes a fold for a shader of @p options: the same effects but relief, one
 * texel at a time, without a fold; its entry points are btf_fold_light, btf_fold_both and btf_fold_neighbour
 * (share/openbtf/openbtf.glsl). */
btf_shader_options btf_fold_pass(const btf_shader_options *options);

/** Layers of texture `folded` (RGBA32UI, W x H, mip levels as the material's), of each light in turn: its views, 1
 * where light and view are folded to radiance, 3 where they are folded to neighbouring views. Of BTF_FOLD_SUM,
 * @p lights counts sums: as many layers as views, or four times as many where views are blended as roots. */
uint32_t btf_fold_layers(const btf_material_info *info, btf_fold fold, uint32_t lights);

/** @return bytes of texture `folded`, of all levels. */
size_t btf_fold_bytes(const btf_material_info *info, btf_fold fold, uint32_t lights);

/** Price of a fold and time that it saves, in the unit of btf_plan_cost. */
typedef struct btf_fold_costs {
    double pass; /**< of one light; of level 0 alone, so a third too low where there are levels */
    float unfolded, folded; /**< of a pixel under one light */
    double pixels;          /**< that have to be shown before it pays: pass / (unfolded - folded) */
} btf_fold_costs;

/** Costs of options->fold for a material shown in @p scene (NULL: anything). */
btf_fold_costs btf_fold_cost(const btf_material *material, const btf_shader_options *options,
                             const btf_scene *scene);

/** Rows first_row .. first_row + rows - 1 of a layer of texture `folded`, made on the CPU for one light: @p options as
 * for the shader that reads it (`fold` says what is folded; filter, math, fixed directions and relief act on what is
 * read and do not matter), @p light and, where it is folded too, @p view (else it may be NULL) unit vectors of the
 * tangent frame, @p layer from 0, below btf_fold_layers() of one light. @p out_texels: [rows][column][4], row 0 the
 * top, the bits of the three floats R, G and B, then 0, as RGBA32UI takes them: those that btf_gl_fold_run() draws, on
 * every machine. Threads may fill rows of their own with one evaluator at the same time. Errors: BTF_ERROR_USAGE (a
 * null pointer, a fold, level, layer or row that is not there, BTF_FOLD_SUM), BTF_ERROR_UNSUPPORTED (btf_fold_check);
 * nothing is written then. */
btf_result btf_fold_rows(const btf_evaluator *evaluator, const btf_shader_options *options,
                         const float light[3], const float view[3], uint32_t level, uint32_t layer,
                         uint32_t first_row, uint32_t rows, uint32_t *out_texels);

/** Adds texels of light and view folded to radiance (BTF_FOLD_BOTH), [count][4] as btf_fold_rows makes them, to a sum
 * of several lights of the same shape, which begins with zeros: sum = sum + texel * weight by channel, each product and
 * each sum rounded to float; the fourth stays. @p weight [3]: irradiance / pi of the light by channel, finite, >= 0. */
void btf_fold_add(size_t count, const uint32_t *texels, const float weight[3], uint32_t *sum);

/** Rows first_row .. first_row + rows - 1 of every layer of a level of texture `folded`, made on the CPU for the sum of
 * several lights (options->fold is BTF_FOLD_SUM, else @p options as in btf_fold_rows). @p light [lights][3]: unit
 * vectors of the tangent frame; @p weight [lights][3]: irradiance / pi by channel, finite, >= 0. @p out_level: the
 * whole level, [layer][row][column][4], of which these rows are written, as RGBA32UI takes them: those that
 * btf_gl_fold_run_lights() draws, on every machine. Each sum is sum = sum + value * weight in the order of the lights,
 * rounded each time, value being what a texel shows in view `layer`; where views are blended as roots, layer 4 i is of
 * the squares of view i, and layers 4 i + 1 to 4 i + 3 are of its roots times those of up to three partners, which A of
 * layer 4 i names, in 10 bits each, the lowest first (1023: none, the layer is 0). Threads may fill rows of their own
 * with one evaluator at the same time. Errors: BTF_ERROR_USAGE (a null pointer, no light, another fold, a level or row
 * that is not there), BTF_ERROR_UNSUPPORTED (btf_fold_check), BTF_ERROR_MEMORY (W x views x 16 bytes); nothing is
 * written then. */
btf_result btf_fold_sum_rows(const btf_evaluator *evaluator, const btf_shader_options *options,
                             uint32_t lights, const float *light, const float *weight, uint32_t level,
                             uint32_t first_row, uint32_t rows, uint32_t *out_level);

/** The whole texture `folded` of one sum of lights, made on the CPU by one thread; arguments as in btf_fold_sum_rows,
 * result and errors as of btf_material_fold. */
btf_result btf_material_fold_sum(const btf_material *material, const btf_shader_options *options,
                                 uint32_t lights, const float *light, const float *weight,
                                 const btf_log *log, uint32_t **out_texels);

/** The whole texture `folded`, made on the CPU by one thread, for APIs other than GL to upload. @p light [lights][3]
 * and, where the view is folded too, @p view [lights][3], as in btf_fold_rows; else @p view may be NULL. *out_texels,
 * of btf_fold_bytes() bytes, is freed with btf_free: level by level, finest first; in a level light by
 * light; of a light layer by layer, each [row][column][4] as in btf_fold_rows. Errors: BTF_ERROR_USAGE (something is
 * missing), BTF_ERROR_UNSUPPORTED (btf_fold_check; a build that does not round as it should), BTF_ERROR_MEMORY;
 * *out_texels is NULL then. */
btf_result btf_material_fold(const btf_material *material, const btf_shader_options *options,
                             uint32_t lights, const float *light, const float *view, const btf_log *log,
                             uint32_t **out_texels);

/** A fold in the current GL context: a texture, and the program that fills it. */
typedef struct btf_gl_fold btf_gl_fold;

/** Makes texture and program for options->shader, whose `fold` says what is folded, of 1 or more lights.
 * Errors: BTF_ERROR_USAGE (no get_proc_address, no fold, no light), BTF_ERROR_UNSUPPORTED (btf_fold_check;
 * a missing function; a texture beyond GL's limits; GLSL refused), BTF_ERROR_MEMORY. On error *out_fold is
 * NULL and nothing is left behind. */
btf_result btf_gl_fold_create(const btf_material *material, const btf_gl_options *options, uint32_t lights,
                              const btf_log *log, btf_gl_fold **out_fold);

/** Folds one light, all levels of detail. @p textures: those of the material, at least what the shader of
 * btf_fold_pass() reads. @p number: of the light, from 0. @p light and, where it is folded too, @p view: unit vectors
 * of the tangent frame; below the horizon the radiance is 0. Shaders that read neighbouring views must be handed the
 * very same view, bit for bit. Sets the texture bindings of units first_unit onwards, as btf_gl_bind does; all other
 * state is as before. Errors: BTF_ERROR_USAGE (a light beyond those of btf_gl_fold_create; a texture that was not
 * uploaded), BTF_ERROR_UNSUPPORTED (GL refuses the framebuffer), BTF_ERROR_MEMORY. */
btf_result btf_gl_fold_run(btf_gl_fold *fold, btf_gl *textures, uint32_t first_unit, uint32_t number,
                           const float light[3], const float view[3], const btf_log *log);

/** Folds the sum of several lights, [count][3] directions at @p lights and weights by channel at @p weights, into what
 * shaders read as light @p number. Of BTF_FOLD_BOTH, seen from @p view, that is the sum over i, in this order, of the
 * radiance under light i times its weight, with the bits of btf_fold_add(); of BTF_FOLD_SUM, whose @p view may be NULL,
 * it has the bits of btf_fold_sum_rows(). Meanwhile textures of W x H x 16 bytes, of BTF_FOLD_SUM 2 views + 1 times as
 * many, a third more with levels, exist beside the fold's. All else is as of btf_gl_fold_run, but that the bindings
 * of up to two units more are set. Errors: likewise; BTF_ERROR_USAGE also for another fold, or no light. */
btf_result btf_gl_fold_run_lights(btf_gl_fold *fold, btf_gl *textures, uint32_t first_unit, uint32_t number,
                                  uint32_t count, const float *lights, const float *weights,
                                  const float view[3], const btf_log *log);

/** Points the sampler `folded` of a linked program, if it has one, at the texture, in unit @p unit;
 * @p prefix as in btf_gl_bind. Sets the uniform and that unit's binding. */
void btf_gl_fold_bind(btf_gl_fold *fold, uint32_t program, uint32_t unit, const char *prefix);

/** @return the GL name of the texture. */
uint32_t btf_gl_fold_texture(const btf_gl_fold *fold);

/** @return the bytes of the texture, of all levels. */
size_t btf_gl_fold_bytes(const btf_gl_fold *fold);

/** Deletes texture and program and sets *fold to NULL. NULL and a pointer to NULL are accepted. */
void btf_gl_fold_destroy(btf_gl_fold **fold);

#ifdef __cplusplus
}
#endif
#endif
