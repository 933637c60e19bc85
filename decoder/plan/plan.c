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

/* BETWEEN: the effects that change nothing at the samples. They have LACKS subsets, of which subset i is the mask
 * i * BTF_EFFECT_RELIEF. */
enum { BETWEEN = BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS, LACKS = 4 };

/* Some of these effects that a plan may do without, and the share by which the error grows for it. */
typedef struct lacking {
    uint32_t effects;
    bool known;
    double growth[2];
} lacking;

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

/* Effects that change nothing in a scene: relief and gloss at a sample, relief at a level where it has ended. */
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

/* Squared errors of decoding and of interpolation add up. Without relief or gloss only that half of the error grows
 * which btfi_errors_to_tolerate takes for the true one. */
static void fill_between(const btf_material *material, const btfi_error_table *t, const btfi_way *chosen,
                         const double lack[2], btf_plan *plan) {
    double mse[2], of_plan[2];
    if (!btfi_find_between(material, &plan->scene, t, plan->level, mse)) {
        return;
    }
    for (int i = 0; i < 2; i++) {
        of_plan[i] = mse[i] * (1 + lack[i] / 2) + chosen->growth[i];
    }
    plan->full_between_psnr_linear = (float)psnr(mse[0]);
    plan->full_between_psnr_srgb = (float)psnr(mse[1]);
    plan->between_psnr_linear = (float)psnr(of_plan[0]);
    plan->between_psnr_srgb = (float)psnr(of_plan[1]);
}

/* Whether a way adds at most the tolerance, in dB, to these errors, which grow without relief or gloss, too. */
static bool is_tolerated(const btfi_way *way, const double base[2], const double lack[2], float tolerance) {
    const double most = pow(10, (double)tolerance / 10);
    for (int i = 0; i < 2; i++) {
        if (base[i] * (1 + lack[i]) + way->growth[i] > base[i] * most) {
            return false;
        }
    }
    return true;
}

/* A search for a plan: what all ways are compared by. */
typedef struct search {
    const btf_material *material;
    const btf_plan *whole; /* that decodes everything but idle effects */
    float tolerance;
    uint32_t views, lights; /* within reach */
    btfi_error_table table;
    const float *full_row;
    btfi_way full;
    double base[2]; /* the error that the tolerance is a share of */
    bool between;   /* that is one between the samples */
    uint32_t idle;
    lacking lack[LACKS];
} search;

/* Fills in how much the error grows without relief, without gloss and without both, where the growths add up. It is
 * not known, and no such plan is tried, of an effect that the material lacks, that is idle, which every plan leaves out
 * anyway, or of which the tables tell nothing. */
static void find_lacks(const btf_material *material, const btf_scene *scene, const btfi_error_table *t,
                       uint32_t level, uint32_t idle, lacking lack[LACKS]) {
    const uint32_t acting = material->info.effects & BETWEEN & ~idle;
    lack[0] = (lacking){.known = true};
    for (uint32_t set = 1; set < LACKS - 1; set++) {
        const uint32_t effect = set * BTF_EFFECT_RELIEF;
        lack[set] = (lacking){.effects = effect};
        lack[set].known = acting & effect && btfi_find_without(material, scene, t, level, (btf_effect)effect,
                                                               lack[set].growth);
    }
    lack[3] = (lacking){.effects = BETWEEN, .known = lack[1].known && lack[2].known};
    for (int i = 0; i < 2; i++) {
        lack[3].growth[i] = lack[1].growth[i] + lack[2].growth[i];
    }
}

/* Turns mse[], the error against the data of a way that decodes relief and gloss, into that of the way without
 * `effects`: it changes by as much as the error of the full decode. Returns false where that was not measured. */
static bool leave_out(const btf_material *material, const btfi_error_table *t, uint32_t level,
                      const btfi_way *full, uint32_t effects, double mse[2]) {
    const btf_material_info *info = &material->info;
    const float *row =
        btfi_find_row(&t->errors, level, info->effects & ~effects, info->components, BTFI_ROW_BETWEEN);
    if (effects == 0 || !row) {
        return effects == 0;
    }
    const btfi_way without = btfi_read_way(t, row);
    for (int i = 0; i < 2; i++) {
        mse[i] = fmax(mse[i] + without.mse[i] - full->mse[i], 1e-10);
    }
    return true;
}

/* Tries the way of a row with relief and gloss, and without: *best becomes the cheapest plan within the tolerance,
 * *chosen its way and *lack what it does without. */
static void try_row(const search *s, const float *row, btf_plan *best, btfi_way *chosen,
                    const lacking **lack) {
    btfi_way way = btfi_read_way(&s->table, row);
    if (s->between) {
        btfi_find_growth(&s->table, row, s->full_row, &way);
    } else {
        for (int i = 0; i < 2; i++) {
            way.growth[i] = fmax(way.mse[i] - s->full.mse[i], 0);
        }
    }
    for (const lacking *l = s->lack; l < s->lack + LACKS; l++) {
        if (!l->known || (l->effects && !(s->between && s->tolerance > 0)) ||
            !is_tolerated(&way, s->base, l->growth, s->tolerance)) {
            continue;
        }
        btf_plan tried = *s->whole;
        double mse[2] = {way.mse[0], way.mse[1]};
        (void)leave_out(s->material, &s->table, tried.level, &s->full, l->effects, mse);
        tried.effects = way.effects & ~s->idle & ~l->effects;
        tried.components = way.components;
        tried.shader.interpolation = way.interpolation;
        tried.psnr_linear = (float)psnr(mse[0]);
        tried.psnr_srgb = (float)psnr(mse[1]);
        fill_costs(s->material, s->views, s->lights, &tried);
        if (tried.price < best->price) {
            *best = tried;
            *chosen = way;
            *lack = l;
        }
    }
}

btf_result btf_plan_predict(const btf_material *material, const btf_plan *plan, uint32_t effects,
                            uint32_t components, float *out_linear, float *out_srgb) {
    const btf_material_info *info = &material->info;
    btfi_error_table t;
    *out_linear = *out_srgb = 0;
    const btfi_row_kind kind =
        plan->shader.interpolation == BTF_INTERPOLATION_NEAREST ? BTFI_ROW_NEAREST : BTFI_ROW_BETWEEN;
    btfi_error_table_open(material, &plan->scene, &t);
    const float *row = btfi_find_row(&t.errors, plan->level, effects, components, kind),
                *full = btfi_find_row(&t.errors, plan->level, info->effects, info->components,
                                      BTFI_ROW_BETWEEN);
    /* Without such a row, that of the same way with relief and gloss counts. */
    const uint32_t lacks = row ? 0 : info->effects & BETWEEN & ~effects;
    row = row ? row : btfi_find_row(&t.errors, plan->level, effects | lacks, components, kind);
    if (!row || !full) {
        return BTF_ERROR_UNSUPPORTED;
    }
    const btfi_way everything = btfi_read_way(&t, full);
    btfi_way way = btfi_read_way(&t, row);
    if (!leave_out(material, &t, plan->level, &everything,
                   lacks & ~idle_effects(material, &plan->scene, plan->level), way.mse)) {
        return BTF_ERROR_UNSUPPORTED;
    }
    *out_linear = (float)psnr(way.mse[0]);
    *out_srgb = (float)psnr(way.mse[1]);
    return BTF_OK;
}

btf_result btf_plan_worth(const btf_material *material, const btf_plan *plan, btf_effect effect,
                          float *out_linear, float *out_srgb) {
    btfi_error_table t;
    double growth[2] = {0, 0};
    *out_linear = *out_srgb = 0;
    if (!(material->info.effects & BETWEEN & effect)) {
        return BTF_ERROR_UNSUPPORTED;
    }
    btfi_error_table_open(material, &plan->scene, &t);
    if (!(idle_effects(material, &plan->scene, plan->level) & effect) &&
        !btfi_find_without(material, &plan->scene, &t, plan->level, effect, growth)) {
        return BTF_ERROR_UNSUPPORTED;
    }
    *out_linear = (float)(10 * log10(1 + growth[0]));
    *out_srgb = (float)(10 * log10(1 + growth[1]));
    return BTF_OK;
}

static bool is_legal(const btf_scene *scene, float tolerance) {
    return is_within_limit(tolerance) && is_within_limit(scene->pixels) && scene->folded_pixels >= 0 &&
           !isinf(scene->folded_pixels) && btfi_range_is_legal(&scene->view) &&
           btfi_range_is_legal(&scene->light);
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
    if (!is_legal(&scene, tolerance)) {
        return BTF_ERROR_USAGE;
    }
    btfi_reach_range(&material->views, &scene.view, &views);
    btfi_reach_range(&material->lights, &scene.light, &lights);
    plan_all(material, &scene, views.count, lights.count, plan);

    search s = {.material = material,
                .tolerance = tolerance,
                .views = views.count,
                .lights = lights.count,
                .idle = idle_effects(material, &scene, plan->level)};
    btfi_error_table_open(material, &scene, &s.table);
    s.full_row =
        btfi_find_row(&s.table.errors, plan->level, info->effects, info->components, BTFI_ROW_BETWEEN);
    if (!s.full_row) {
        return BTF_OK;
    }
    s.full = btfi_read_way(&s.table, s.full_row);
    s.between = btfi_errors_to_tolerate(material, &scene, &s.table, plan->level, &s.full, s.base);
    find_lacks(material, &scene, &s.table, plan->level, s.idle, s.lack);
    plan->measured = 1;
    plan->psnr_linear = plan->full_psnr_linear = (float)psnr(s.full.mse[0]);
    plan->psnr_srgb = plan->full_psnr_srgb = (float)psnr(s.full.mse[1]);
    btf_plan best = *plan;
    btfi_way chosen = s.full;
    const lacking *lack = &s.lack[0];
    s.whole = plan;
    for (uint32_t r = 0; r < s.table.errors.table.row_count; r++) {
        const float *row = s.table.errors.table.rows + (size_t)r * s.table.errors.table.row_stride;
        const bool nearest = btfi_kind_of(row) == BTFI_ROW_NEAREST;
        if (btfi_kind_of(row) < BTFI_ROW_SAMPLES && btfi_level_of(row) == plan->level &&
            !(info->effects & BETWEEN & ~s.idle & ~(uint32_t)row[0]) && !(scene.interpolate && nearest)) {
            try_row(&s, row, &best, &chosen, &lack);
        }
    }
    *plan = best;
    fill_between(material, &s.table, &chosen, lack->growth, plan);
    return BTF_OK;
}
