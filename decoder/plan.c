/* OpenBTF: finds the cheapest way to decode a scene within a tolerance. See openbtf/plan.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/cost/counts.h"
#include "decoder/fold/fold.h"
#include "material.h"
#include "reach.h"
#include "restrict.h"
#include "shape.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#define DEGREE (3.14159265358979323846 / 180)

/* A set of effects and components, and the errors that the table predicts for it in a scene. */
typedef struct candidate {
    uint32_t effects, components;
    btf_interpolation interpolation;
    double mse[2];    /* linear, sRGB-coded */
    double growth[2]; /* of the full decode's error where the scene looks; find_growth() */
} candidate;

/* Neighbouring directions that a shader goes through, and how many of them have weight 0. */
static void count_directions(const btfi_directions *directions, const btf_shader_options *o, uint32_t fixed,
                             const float fixed_direction[3], const btf_range *range, uint32_t *out_all,
                             uint32_t *out_skipped) {
    const bool nearest = o->interpolation == BTF_INTERPOLATION_NEAREST;
    *out_all = nearest ? 1 : 3;
    *out_skipped = 0;
    if (o->fixed & fixed) {
        *out_all = btfi_neighbours_of(directions, fixed_direction, nearest).count;
    } else if (!nearest && range && range->fixed) {
        *out_skipped = 3 - btfi_neighbours_of(directions, range->direction, false).count;
    }
}

/* The counts of a shader that reads a material of `info`, with the directions of `material`. */
static btf_decode_counts counts_of(const btf_material *material, const btf_material_info *info,
                                   const btf_shader_options *o, const btf_scene *scene) {
    btfi_around around;
    uint32_t none;
    count_directions(&material->views, o, BTF_FIXED_VIEW, o->fixed_view, scene ? &scene->view : NULL,
                     &around.views, &around.skipped);
    /* With gloss a light that is fixed has neighbours that are not. */
    count_directions(&material->lights, o,
                     info->effects & ~o->leave_out & BTF_EFFECT_GLOSS ? 0 : BTF_FIXED_LIGHT, o->fixed_light,
                     NULL, &around.lights, &none);
    return btfi_count_decode(info, o, &around);
}

static float cost_of(const btf_material *material, const btf_material_info *info,
                     const btf_shader_options *o, const btf_scene *scene) {
    const btf_decode_counts counts = counts_of(material, info, o, scene);
    return (float)btf_cost_of(&counts, btfi_costs_of(scene));
}

btf_decode_counts btf_plan_counts(const btf_material *material, const btf_shader_options *options,
                                  const btf_scene *scene) {
    return counts_of(material, &material->info, options, scene);
}

float btf_plan_cost(const btf_material *material, const btf_shader_options *options,
                    const btf_scene *scene) {
    return cost_of(material, &material->info, options, scene);
}

/* The share of a range's solid angle that each band has; the outermost band goes on to the horizon, the
 * first to the pole. */
static void band_weights(const btf_range *range, uint32_t count, const float *limits,
                         double weight[BTF_MAX_BANDS]) {
    const bool all = range->theta[0] == 0 && range->theta[1] == 0;
    double low = all ? 0 : range->theta[0], high = all ? 90 : range->theta[1], sum = 0;
    if (range->fixed) {
        low = high = acos(fmin(range->direction[2], 1)) / DEGREE;
    }
    /* Beyond the outermost ring there is nothing to be measured by: it counts there too, but for no more.
     */
    low = fmin(low, limits[count]);
    high = fmax(fmin(high, limits[count]), low);
    for (uint32_t b = 0; b < count; b++) {
        const double from = fmax(low, b == 0 ? 0 : limits[b]), to = fmin(high, limits[b + 1]);
        weight[b] = to > from ? cos(from * DEGREE) - cos(to * DEGREE) : 0;
        sum += weight[b];
    }
    for (uint32_t b = 0; b < count; b++) {
        const bool here = (b == 0 || low >= limits[b]) && (low < limits[b + 1] || b + 1 == count);
        weight[b] = sum > 0 ? weight[b] / sum : here;
    }
}

/* The table of measured errors, and how much each of its bands counts in a scene. */
typedef struct error_table {
    btf_effect_errors rows, differences;
    double at_view, at_light; /* 0: between samples, 1: at a sample */
    double view[BTF_MAX_BANDS], light[BTF_MAX_BANDS];
} error_table;

static const float *row_at(const error_table *t, uint32_t index) {
    return t->rows.rows + (size_t)index * t->rows.row_stride;
}

/* How much a scene is one of two samples, a view that is a sample, a light that is one, neither: adds up to 1. */
static void find_shares(const error_table *t, double share[4]) {
    share[0] = t->at_view * t->at_light;
    share[1] = t->at_view * (1 - t->at_light);
    share[2] = (1 - t->at_view) * t->at_light;
    share[3] = (1 - t->at_view) * (1 - t->at_light);
}

/* Adds a row's errors, weighted by the bands. */
static void add_errors(const error_table *t, const float *row, double mse[2]) {
    const float *cell = row + 5;
    for (uint32_t v = 0; v < t->rows.view_bands; v++) {
        for (uint32_t l = 0; l < t->rows.light_bands; l++, cell += 2) {
            for (int i = 0; i < 2; i++) {
                mse[i] += t->view[v] * t->light[l] * (double)cell[i];
            }
        }
    }
}

/* The row of the effects and components of row `index`, measured where view, light or both are samples
 * (column 3: 3, 4, 2). */
static const float *row_of_kind(const error_table *t, uint32_t index, int kind) {
    const float *row = row_at(t, index);
    for (uint32_t r = 0; r < t->rows.row_count; r++) {
        const float *other = row_at(t, r);
        if (other[0] == row[0] && other[1] == row[1] && other[2] == (float)kind && other[3] == row[3]) {
            return other;
        }
    }
    return row;
}

/* Between samples the errors of up to nine samples average out, so that they are less than at the samples:
 * the geometric mean of what is measured for both, by how near view and light are to being samples. */
static candidate read_candidate(const error_table *t, uint32_t index) {
    const float *row = row_at(t, index);
    candidate c = {.effects = (uint32_t)row[0],
                   .components = (uint32_t)row[1],
                   .interpolation = row[2] == 0 ? BTF_INTERPOLATION_LINEAR : BTF_INTERPOLATION_NEAREST};
    add_errors(t, row, c.mse);
    if (t->at_view == 0 && t->at_light == 0) {
        return c;
    }
    double share[4];
    find_shares(t, share);
    static const int kinds[3] = {2, 3, 4};
    double mse[4][2] = {{0}};
    /* Nearest directions have no rows of their own where one is a sample: between the samples errors are no less. */
    for (int k = 0; k < 3; k++) {
        add_errors(t, k > 0 && row[2] == 1 ? row : row_of_kind(t, index, kinds[k]), mse[k]);
    }
    for (int i = 0; i < 2; i++) {
        double sum = 0;
        mse[3][i] = c.mse[i];
        for (int k = 0; k < 4; k++) {
            sum += share[k] * log(fmax(mse[k][i], 1e-12));
        }
        c.mse[i] = exp(sum);
    }
    return c;
}

static bool is_at_samples(const error_table *t, uint32_t index) {
    return row_at(t, index)[2] >= 2;
}

/* The sum of squared weights: 1 at a sample, 1/2 on the average over a triangle. */
static double concentration(const btfi_directions *d, const btf_range *range) {
    double sum = 0;
    if (!range->fixed) {
        return 0.5;
    }
    const btfi_neighbours n = btfi_neighbours_of(d, range->direction, false);
    for (uint32_t i = 0; i < n.count; i++) {
        sum += (double)n.weight[i] * n.weight[i] * 0x1p-24;
    }
    return sum;
}

static uint32_t level_of(const error_table *t, uint32_t index) {
    return (uint32_t)row_at(t, index)[3];
}

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
    plan->cost = cost_of(material, &small, &plan->shader, &plan->scene) *
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

static bool same_limits(uint32_t bands, const float *a, uint32_t other_bands, const float *b) {
    return bands == other_bands && memcmp(a, b, (bands + 1) * sizeof *a) == 0;
}

/* Whether both tables have the same bands: a file may hold two that have not. */
static bool same_bands(const btf_effect_errors *a, const btf_effect_errors *b) {
    return same_limits(a->view_bands, a->view_limits, b->view_bands, b->view_limits) &&
           same_limits(a->light_bands, a->light_limits, b->light_bands, b->light_limits);
}

/* The material's table, weighted for a scene. Differences of other bands, whose rows have another length, are passed
 * over. */
static error_table open_table(const btf_material *material, const btf_scene *scene) {
    error_table t = {.rows = btf_material_effect_errors(material),
                     .differences = btf_material_effect_differences(material)};
    if (t.rows.row_count == 0) {
        return t;
    }
    if (t.differences.row_count > 0 && !same_bands(&t.rows, &t.differences)) {
        t.differences.row_count = 0;
    }
    band_weights(&scene->view, t.rows.view_bands, t.rows.view_limits, t.view);
    band_weights(&scene->light, t.rows.light_bands, t.rows.light_limits, t.light);
    t.at_view = fmin(fmax(1 + log2(concentration(&material->views, &scene->view)), 0), 1);
    t.at_light = fmin(fmax(1 + log2(concentration(&material->lights, &scene->light)), 0), 1);
    return t;
}

/* Reads the errors that the table predicts for a level, effects and components; false where they were not
 * measured. */
static bool find_candidate(const error_table *t, uint32_t level, uint32_t effects, uint32_t components,
                           btf_interpolation interpolation, candidate *out, uint32_t *out_row) {
    for (uint32_t r = 0; r < t->rows.row_count; r++) {
        const float *row = row_at(t, r);
        if (!is_at_samples(t, r) && level_of(t, r) == level && row[0] == (float)effects &&
            row[1] == (float)components && (row[2] == 1) == (interpolation == BTF_INTERPOLATION_NEAREST)) {
            *out = read_candidate(t, r);
            *out_row = r;
            return true;
        }
    }
    return false;
}

/* The growth of the error against the data of the kind that stands at `k` of the shares: 0 at samples. */
static void growth_of_data(const error_table *t, uint32_t index, uint32_t full, int k, double growth[2]) {
    static const int kinds[3] = {2, 3, 4};
    double with[2] = {0, 0}, less[2] = {0, 0};
    const bool apart = k < 3 && (k == 0 || row_at(t, index)[2] == 0); /* as in read_candidate */
    add_errors(t, k < 3 ? row_of_kind(t, full, kinds[k]) : row_at(t, full), with);
    add_errors(t, apart ? row_of_kind(t, index, kinds[k]) : row_at(t, index), less);
    for (int i = 0; i < 2; i++) {
        growth[i] = fmax(less[i] - with[i], 0);
    }
}

/* The mean squared difference to the full decode of the kind at `k`; false where the file does not say. */
static bool find_difference(const error_table *t, uint32_t index, int k, double out[2]) {
    const float *row = row_at(t, index);
    const float kind = row[2] == 1 ? 1 : k == 1 ? 3 : k == 2 ? 4 : 0;
    for (uint32_t r = 0; r < t->differences.row_count; r++) {
        const float *other = t->differences.rows + (size_t)r * t->differences.row_stride;
        if (other[0] == row[0] && other[1] == row[1] && other[2] == kind && other[3] == row[3]) {
            out[0] = out[1] = 0;
            add_errors(t, other, out);
            return true;
        }
    }
    return false;
}

/* How much the full decode's error grows by decoding as row `index` says, against the truth. At samples the data are the
 * truth. Between them what is left out adds its own squared difference, since it knows nothing of the error that
 * interpolation makes there: against the data, interpolated, growth is too little where relief moves texels, for then
 * what is left out blurs, and so do these data. A file that has no differences: the mean of both growths, of which that at
 * samples is too much, or that against the data where it is more (nearest directions). */
static void find_growth(const error_table *t, uint32_t index, uint32_t full, candidate *c) {
    double share[4], at_samples[2], sum[2] = {0, 0};
    find_shares(t, share);
    growth_of_data(t, index, full, 0, at_samples);
    for (int k = 0; k < 4; k++) {
        double growth[2], difference[2];
        growth_of_data(t, index, full, k, growth);
        const bool known = k > 0 && find_difference(t, index, k, difference);
        for (int i = 0; i < 2; i++) {
            const double between = known ? difference[i] : fmax(growth[i], (growth[i] + at_samples[i]) / 2);
            sum[i] += share[k] * log(fmax(k == 0 ? at_samples[i] : between, 1e-12));
        }
    }
    for (int i = 0; i < 2; i++) {
        c->growth[i] = sum[i] > log(1.1e-12) ? exp(sum[i]) : 0;
    }
}

/* The error of a scene by a row of the table of errors between the samples; false where it says nothing. */
static bool find_row_between(const btf_material *material, const btf_scene *scene, float left_out,
                             double mse[2]) {
    const btf_between_errors b = btf_material_between_errors(material);
    double view[BTF_MAX_BANDS], light[BTF_MAX_BANDS], sum[2] = {0, 0}, weight = 0;
    uint32_t r = 0;
    while (r < b.row_count && b.rows[(size_t)r * b.row_stride] != left_out) {
        r++;
    }
    if (r == b.row_count) {
        return false;
    }
    band_weights(&scene->view, b.view_bands, b.view_limits, view);
    band_weights(&scene->light, b.light_bands, b.light_limits, light);
    const float *cell = b.rows + (size_t)r * b.row_stride + 5;
    for (uint32_t v = 0; v < b.view_bands; v++) {
        for (uint32_t l = 0; l < b.light_bands; l++, cell += 2) {
            if (cell[0] >= 0) {
                weight += view[v] * light[l];
                for (int i = 0; i < 2; i++) {
                    sum[i] += view[v] * light[l] * (double)cell[i];
                }
            }
        }
    }
    for (int i = 0; i < 2 && weight > 0; i++) {
        mse[i] = sum[i] / weight;
    }
    return weight > 0;
}

/* The same of the full decode. View or light that are samples are not left out. */
static bool find_between(const btf_material *material, const btf_scene *scene, const error_table *t,
                         double mse[2]) {
    return find_row_between(material, scene,
                            (t->at_view < 1 ? 1.0f : 0.0f) + (t->at_light < 1 ? 2.0f : 0.0f), mse);
}

/* Takes the share by which the error grows where gloss is not decoded; false where the table does not say. A view or light
 * that is left out stands at double the gap: there the error by which gloss moves highlights, which grows with the square of the
 * gap, is four times that between the samples, and the whole error twice (errors_to_tolerate), so that half of the growth
 * remains. BRICKS64, all directions: 1.07/0.34 dB left out, 0.62/0.09 dB in images between the samples, 0.57/0.17 by this. */
static bool find_gloss(const btf_material *material, const btf_scene *scene, double growth[2]) {
    enum {
        BOTH = 3,
        BOTH_WITHOUT_GLOSS = 11
    }; /* where the light is a sample, gloss only blurs it by others */
    double with[2], without[2];
    if (!find_row_between(material, scene, BOTH, with) ||
        !find_row_between(material, scene, BOTH_WITHOUT_GLOSS, without)) {
        return false;
    }
    for (int i = 0; i < 2; i++) {
        growth[i] = fmax(without[i] / fmax(with[i], 1e-10) - 1, 0) / 2;
    }
    return true;
}

/* Squared errors of decoding and of interpolation add up. Without gloss the half of the error grows that
 * errors_to_tolerate takes for the true one. */
static void fill_between(const btf_material *material, const error_table *t, const candidate *chosen,
                         const double gloss[2], btf_plan *plan) {
    double mse[2], of_plan[2];
    if (plan->level > 0 || !find_between(material, &plan->scene, t, mse)) {
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

/* The errors that the tolerance is a share of: those of the full decode where the scene looks. Returns whether that is
 * between the samples, by a file that says what is lost there. */
static bool errors_to_tolerate(const btf_material *material, const btf_scene *scene, const error_table *t,
                               uint32_t level, const candidate *full, double base[2]) {
    double between[2] = {0, 0};
    const bool known = level == 0 && find_between(material, scene, t, between);
    for (int i = 0; i < 2; i++) {
        base[i] = fmax(fmax(between[i] / 2, full->mse[i]), 1e-10);
    }
    return known;
}

/* Whether a candidate adds at most the tolerance, in dB, to these errors, which grow without gloss, too. */
static bool is_tolerated(const candidate *c, const double base[2], const double gloss[2], float tolerance) {
    const double most = pow(10, (double)tolerance / 10);
    for (int i = 0; i < 2; i++) {
        if (base[i] * (1 + gloss[i]) + c->growth[i] > base[i] * most) {
            return false;
        }
    }
    return true;
}

btf_result btf_plan_predict(const btf_material *material, const btf_plan *plan, uint32_t effects,
                            uint32_t components, float *out_linear, float *out_srgb) {
    const error_table t = open_table(material, &plan->scene);
    candidate c;
    uint32_t row;
    *out_linear = *out_srgb = 0;
    if (btfi_relief_has_ended(&material->info, plan->level)) {
        effects |= BTF_EFFECT_RELIEF; /* as rows of the table have it, which are of the whole material */
    }
    if (!find_candidate(&t, plan->level, effects, components, plan->shader.interpolation, &c, &row)) {
        return BTF_ERROR_UNSUPPORTED;
    }
    *out_linear = (float)psnr(c.mse[0]);
    *out_srgb = (float)psnr(c.mse[1]);
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

    const error_table t = open_table(material, &scene);
    candidate full, chosen;
    uint32_t full_row;
    if (!find_candidate(&t, plan->level, info->effects, info->components, BTF_INTERPOLATION_LINEAR, &full,
                        &full_row)) {
        return BTF_OK;
    }
    double base[2], gloss[2][2] = {{0, 0}, {0, 0}}; /* growth with it, without */
    const bool between = errors_to_tolerate(material, &scene, &t, plan->level, &full, base);
    plan->measured = 1;
    plan->psnr_linear = plan->full_psnr_linear = (float)psnr(full.mse[0]);
    plan->psnr_srgb = plan->full_psnr_srgb = (float)psnr(full.mse[1]);
    /* Without gloss a still light can be folded, whatever the view. */
    const bool may_fold = info->effects & BTF_EFFECT_GLOSS & ~idle && scene.light.fixed &&
                          !scene.view.fixed && !scene.no_fold && tolerance > 0 && plan->level == 0 &&
                          info->colour == BTF_COLOUR_NONE && /* an SBRDF depends on the view as well */
                          find_gloss(material, &scene, gloss[1]);
    const double *chosen_gloss = gloss[0];
    btf_plan best = *plan;
    chosen = full;
    for (uint32_t r = 0; r < t.rows.row_count; r++) {
        if (is_at_samples(&t, r) || level_of(&t, r) != plan->level) {
            continue;
        }
        candidate c = read_candidate(&t, r);
        if (info->effects & BETWEEN & ~idle & ~c.effects) {
            continue;
        }
        if (scene.interpolate && c.interpolation == BTF_INTERPOLATION_NEAREST) {
            continue;
        }
        if (between) {
            find_growth(&t, r, full_row, &c);
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
