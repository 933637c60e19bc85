/* OpenBTF: finds the cheapest way to decode a scene within a tolerance. See openbtf/plan.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cost.h"
#include "growth.h"
#include "table.h"

#include "decoder/fold/fold.h"
#include "decoder/material.h"
#include "decoder/reach.h"
#include "decoder/restrict.h"
#include "decoder/shape.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

static double psnr(double mse) {
    return mse > 1e-10 ? -10 * log10(mse) : 100;
}

/* Fills in the members that follow from the options: textures, bytes, cost, fold, price. */
static void fill_costs(const btf_material *material, uint32_t views, uint32_t lights, btf_plan *plan) {
    const btf_material_info *info = &material->info;
    /* With gloss any light may be a neighbour's. */
    const bool gloss = plan->effects & info->effects & BTF_EFFECT_GLOSS;
    const btf_material_info small = btfi_restricted_info(info, plan->effects, plan->components, plan->level,
                                                         views, gloss ? info->n_lights : lights);
    plan->views = views;
    plan->lights = small.n_lights;
    plan->shader.leave_out = info->effects & ~plan->effects;
    plan->shader.components = plan->components;
    plan->textures = btf_shader_textures(&small, &plan->shader);
    plan->gpu_bytes = btfi_gpu_bytes(&small);
    plan->cost = btfi_plan_cost(material, &small, &plan->shader, &plan->scene) *
                 (float)(plan->scene.lights ? plan->scene.lights : 1);
    btfi_fold_plan(material, plan);
    plan->price = fminf(plan->cost, plan->folded_cost) / plan->full_cost +
                  (float)plan->gpu_bytes / (float)plan->full_gpu_bytes;
}

/* 0 to 1e6; no NaN. */
static bool is_within_limit(float x) {
    return x >= 0 && x <= 1e6f;
}

/* Effects that change nothing at the samples. */
enum { BETWEEN = BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS };

/* Whether the view is fixed, and a sample. One beyond the outermost has the same neighbour, but is not. */
static bool view_is_sample(const btfi_directions *views, const btf_range *range) {
    if (!range->fixed) {
        return false;
    }
    const btfi_neighbours n = btfi_neighbours_of(views, range->direction, true);
    const float *sample = views->xyz + 3 * (size_t)n.index[0], *v = range->direction;
    return hypot(hypot((double)(v[0] - sample[0]), (double)(v[1] - sample[1])),
                 (double)(v[2] - sample[2])) < 1e-4;
}

/* The coarsest level whose texels are not larger than a pixel. */
static uint32_t level_for(const btf_material_info *info, float pixels) {
    uint32_t level = 0;
    while (level + 1 < info->levels && ldexpf(pixels, (int)level + 1) <= 1) {
        level++;
    }
    return level;
}

/* Effects that change nothing in a scene: relief and gloss at a sample, relief at a level where it has ended.
 * Elsewhere the table, which compares with the samples and what lies between them interpolated, cannot tell
 * what the two are worth: they stay. */
static uint32_t idle_effects(const btf_material *material, const btf_scene *scene, uint32_t level) {
    return (view_is_sample(&material->views, &scene->view) ? BETWEEN : 0u) |
           (btfi_relief_has_ended(&material->info, level) ? BTF_EFFECT_RELIEF : 0u);
}

/* The plan that decodes everything but idle effects. */
static void plan_all(const btf_material *material, const btf_scene *scene, uint32_t views, uint32_t lights,
                     btf_plan *plan) {
    const btf_material_info *info = &material->info;
    const float pixels = scene->pixels > 0 ? scene->pixels : 1;
    const uint32_t level = level_for(info, pixels);
    *plan = (btf_plan){.struct_size = sizeof *plan,
                       .scene = *scene,
                       .effects = info->effects & ~idle_effects(material, scene, level),
                       .components = info->components,
                       .level = level,
                       .full_gpu_bytes = info->gpu_bytes};
    plan->shader.struct_size = sizeof plan->shader;
    plan->shader.filter = pixels > 1.5f ? BTF_FILTER_BILINEAR : BTF_FILTER_TEXEL;
    plan->full_cost =
        btf_plan_cost(material, &plan->shader, scene) * (float)(scene->lights ? scene->lights : 1);
    plan->shader.fixed =
        (scene->view.fixed ? BTF_FIXED_VIEW : 0u) | (scene->light.fixed ? BTF_FIXED_LIGHT : 0u);
    memcpy(plan->shader.fixed_view, scene->view.direction, sizeof plan->shader.fixed_view);
    memcpy(plan->shader.fixed_light, scene->light.direction, sizeof plan->shader.fixed_light);
    fill_costs(material, views, lights, plan);
}

/* Squared errors of decoding and of interpolation add up. Without gloss the half of the error grows that
 * btfi_errors_to_tolerate takes for the true one. */
static void fill_between(const btf_material *material, const btfi_error_table *t, const btfi_way *chosen,
                         const double gloss[2], btf_plan *plan) {
    double mse[2], of_plan[2];
    if (plan->level > 0 || !btfi_find_between(material, &plan->scene, t, mse)) {
        return;
    }
    for (int i = 0; i < 2; i++) {
        of_plan[i] = mse[i] * (1 + gloss[i] / 2) + chosen->growth[i];
    }
    plan->full_between_psnr_linear = (float)psnr(mse[0]);
    plan->full_between_psnr_srgb = (float)psnr(mse[1]);
    plan->between_psnr_linear = (float)psnr(of_plan[0]);
    plan->between_psnr_srgb = (float)psnr(of_plan[1]);
}

/* Whether a way adds at most the tolerance, in dB, to these errors, which grow without gloss, too. */
static bool is_tolerated(const btfi_way *c, const double base[2], const double gloss[2], float tolerance) {
    const double most = pow(10, (double)tolerance / 10);
    for (int i = 0; i < 2; i++) {
        if (base[i] * (1 + gloss[i]) + c->growth[i] > base[i] * most) {
            return false;
        }
    }
    return true;
}

/* The directions that a plan without still ones is measured at. */
static btfi_row_kind row_kind(btf_interpolation interpolation) {
    return interpolation == BTF_INTERPOLATION_NEAREST ? BTFI_ROW_NEAREST : BTFI_ROW_BETWEEN;
}

btf_result btf_plan_predict(const btf_material *material, const btf_plan *plan, uint32_t effects,
                            uint32_t components, float *out_linear, float *out_srgb) {
    btfi_error_table t;
    *out_linear = *out_srgb = 0;
    if (btfi_relief_has_ended(&material->info, plan->level)) {
        effects |= BTF_EFFECT_RELIEF; /* as rows of the table have it, which are of the whole material */
    }
    btfi_error_table_open(material, &plan->scene, &t);
    const float *row =
        btfi_find_row(&t.errors, plan->level, effects, components, row_kind(plan->shader.interpolation));
    if (!row) {
        return BTF_ERROR_UNSUPPORTED;
    }
    const btfi_way way = btfi_read_way(&t, row);
    *out_linear = (float)psnr(way.mse[0]);
    *out_srgb = (float)psnr(way.mse[1]);
    return BTF_OK;
}

btf_result btf_plan_effects(const btf_material *material, const btf_scene *given, float tolerance,
                            btf_plan *plan) {
    const btf_material_info *info = &material->info;
    btf_scene scene = {.struct_size = sizeof scene};
    btfi_reach views, lights;
    if (given) {
        memcpy(&scene, given, given->struct_size < sizeof scene ? given->struct_size : sizeof scene);
    }
    scene.struct_size = sizeof scene; /* the plan's is whole */
    if (!is_within_limit(tolerance) || !is_within_limit(scene.pixels) || !(scene.folded_pixels >= 0) ||
        isinf(scene.folded_pixels) || !btfi_range_is_legal(&scene.view) ||
        !btfi_range_is_legal(&scene.light)) {
        return BTF_ERROR_USAGE;
    }
    btfi_reach_range(&material->views, &scene.view, &views);
    btfi_reach_range(&material->lights, &scene.light, &lights);
    plan_all(material, &scene, views.count, lights.count, plan);
    const uint32_t idle = idle_effects(material, &scene, plan->level);

    btfi_error_table t;
    btfi_error_table_open(material, &scene, &t);
    const float *full_row =
        btfi_find_row(&t.errors, plan->level, info->effects, info->components, BTFI_ROW_BETWEEN);
    if (!full_row) {
        return BTF_OK;
    }
    const btfi_way full = btfi_read_way(&t, full_row);
    btfi_way chosen = full;
    double base[2], gloss[2][2] = {{0, 0}, {0, 0}}; /* growth with it, without */
    const bool between = btfi_errors_to_tolerate(material, &scene, &t, plan->level, &full, base);
    plan->measured = 1;
    plan->psnr_linear = plan->full_psnr_linear = (float)psnr(full.mse[0]);
    plan->psnr_srgb = plan->full_psnr_srgb = (float)psnr(full.mse[1]);
    /* Without gloss a still light can be folded, whatever the view. */
    const bool may_fold = info->effects & BTF_EFFECT_GLOSS & ~idle && scene.light.fixed &&
                          !scene.view.fixed && !scene.no_fold && tolerance > 0 && plan->level == 0 &&
                          info->colour == BTF_COLOUR_NONE && /* an SBRDF depends on the view as well */
                          btfi_find_gloss(material, &scene, gloss[1]);
    const double *chosen_gloss = gloss[0];
    btf_plan best = *plan;
    for (uint32_t r = 0; r < t.errors.table.row_count; r++) {
        const float *row = t.errors.table.rows + (size_t)r * t.errors.table.row_stride;
        if (btfi_kind_of(row) >= BTFI_ROW_SAMPLES || btfi_level_of(row) != plan->level) {
            continue;
        }
        btfi_way c = btfi_read_way(&t, row);
        if (info->effects & BETWEEN & ~idle & ~c.effects) {
            continue;
        }
        if (scene.interpolate && c.interpolation == BTF_INTERPOLATION_NEAREST) {
            continue;
        }
        if (between) {
            btfi_find_growth(&t, row, full_row, &c);
        } else {
            for (int i = 0; i < 2; i++) {
                c.growth[i] = fmax(c.mse[i] - full.mse[i], 0);
            }
        }
        for (int without = 0; without <= may_fold; without++) {
            if (!is_tolerated(&c, base, gloss[without], tolerance)) {
                continue;
            }
            btf_plan tried = *plan;
            tried.effects = c.effects & ~idle & ~(without ? (uint32_t)BTF_EFFECT_GLOSS : 0);
            tried.components = c.components;
            tried.shader.interpolation = c.interpolation;
            tried.psnr_linear = (float)psnr(c.mse[0]);
            tried.psnr_srgb = (float)psnr(c.mse[1]);
            fill_costs(material, views.count, lights.count, &tried);
            if (without && !(tried.folded_cost < tried.cost)) {
                continue; /* gloss is left out for the fold alone */
            }
            if (tried.price < best.price) {
                best = tried;
                chosen = c;
                chosen_gloss = gloss[without];
            }
        }
    }
    *plan = best;
    fill_between(material, &t, &chosen, chosen_gloss, plan);
    return BTF_OK;
}
