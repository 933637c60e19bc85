/* Scenes to plan for. See plan_scenes.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "plan_scenes.h"

#include "decoder/toolkit/reference_view.h"
#include "encoder/report/effect_errors.h"
#include "encoder/job/levels.h"
#include "encoder/math/srgb.h"
#include "encoder/model/pack.h"
#include "tests/conformance/random.h"

#include <math.h>
#include <stdlib.h>

#define DEGREE (3.14159265358979323846 / 180)

/* cos and sin of 45 degrees; 0.353.. and 0.612.. are their products with sin and cos of 30. */
const plan_scene plan_scenes[PLAN_SCENES] = {
    {"everything", {.struct_size = sizeof(btf_scene)}},
    {"top-down", {.struct_size = sizeof(btf_scene), .view = {.theta = {0, 20}}}},
    {"grazing", {.struct_size = sizeof(btf_scene), .view = {.theta = {55, 75}}}},
    {"frontal light", {.struct_size = sizeof(btf_scene), .light = {.theta = {0, 15}}}},
    {"orbit",
     {.struct_size = sizeof(btf_scene), .view = {.theta = {15, 60}}, .light = {.theta = {20, 60}}}},
    {"still light",
     {.struct_size = sizeof(btf_scene),
      .light = {.fixed = 1, .direction = {0.61237246f, 0.35355338f, 0.70710677f}}}},
    {"still view", {.struct_size = sizeof(btf_scene), .view = {.fixed = 1, .direction = {0, 0, 1}}}},
    {"both still",
     {.struct_size = sizeof(btf_scene),
      .view = {.fixed = 1, .direction = {0, 0, 1}},
      .light = {.fixed = 1, .direction = {0.61237246f, 0.35355338f, 0.70710677f}}}},
    {"far", {.struct_size = sizeof(btf_scene), .pixels = 0.25f}},
};

double plan_psnr(double mse) {
    return mse > 1e-10 ? -10 * log10(mse) : 100;
}

btf_result plan_pack(const enc_context *context, const enc_data *data, enc_solution *solution,
                     btf_layout layout, int levels, btf_material **out_material) {
    enc_levels fitted = {0};
    enc_effect_tables effects = {0};
    enc_pack_options options = {.layout = layout, .method = "", .options = "", .source = ""};
    btf_result result = BTF_OK;
    if (levels > 1) {
        result = enc_levels_fit(context, data, levels, NULL, NULL, solution, &fitted);
    }
    options.levels = fitted.count;
    options.level = fitted.level;
    if (result == BTF_OK) {
        result = enc_pack(context, data, solution, &options, out_material);
    }
    if (result == BTF_OK) {
        result = enc_effect_errors(context, data, *out_material, &effects);
    }
    if (result == BTF_OK) {
        options.effect_errors = effects.errors;
        options.effect_error_count = effects.error_count;
        options.effect_differences = effects.differences;
        options.effect_difference_count = effects.difference_count;
        btf_material_close(out_material);
        result = enc_pack(context, data, solution, &options, out_material);
    }
    enc_effect_tables_clear(&effects);
    enc_levels_clear(&fitted);
    return result;
}

/* Uniform over the solid angle of a range, no lower than the outermost sampled ring. */
static void pick(random_state *r, const btf_range *range, double outermost, float out[3]) {
    if (range->fixed) {
        memcpy(out, range->direction, 3 * sizeof *out);
        return;
    }
    const bool all = range->theta[0] == 0 && range->theta[1] == 0;
    const double high = fmin(all ? 90 : (double)range->theta[1], outermost);
    double turn = fmod((double)range->phi[1] - (double)range->phi[0] + 720, 360);
    turn = turn > 0 ? turn : 360;
    const double z = random_between(r, cos(high * DEGREE), cos((double)range->theta[0] * DEGREE)),
                 s = sqrt(1 - z * z);
    const double phi = ((double)range->phi[0] + random_between(r, 0, turn)) * DEGREE;
    out[0] = (float)(s * cos(phi));
    out[1] = (float)(s * sin(phi));
    out[2] = (float)z;
}

/* The direction in a range at a share of its solid angle from the pole (`rise`) and of its azimuths (`turn`). */
static void place(const btf_range *range, double outermost, double rise, double turn, float out[3]) {
    if (range->fixed) {
        memcpy(out, range->direction, 3 * sizeof *out);
        return;
    }
    const bool all = range->theta[0] == 0 && range->theta[1] == 0;
    const double low = cos((double)range->theta[0] * DEGREE),
                 high = cos(fmin(all ? 90 : (double)range->theta[1], outermost) * DEGREE);
    double all_turn = fmod((double)range->phi[1] - (double)range->phi[0] + 720, 360);
    all_turn = all_turn > 0 ? all_turn : 360;
    const double z = low + (high - low) * rise, s = sqrt(1 - z * z),
                 phi = ((double)range->phi[0] + turn * all_turn) * DEGREE;
    out[0] = (float)(s * cos(phi));
    out[1] = (float)(s * sin(phi));
    out[2] = (float)z;
}

void plan_arguments(const btf_plan *plan, const enc_data *data, size_t side, uint32_t *out) {
    const double view = data->views[data->n_views - 1].theta,
                 light = data->lights[data->n_lights - 1].theta;
    const float pixels = plan->scene.pixels > 0 ? plan->scene.pixels : 1;
    for (size_t i = 0; i < side * side; i++) {
        const double x = ((double)(i % side) + 0.5) / (double)side,
                     y = ((double)(i / side) + 0.5) / (double)side;
        float f[8] = {(float)(x * (double)side / data->width) / pixels,
                      (float)(y * (double)side / data->height) / pixels};
        place(&plan->scene.light, light, y, x, f + 2);
        place(&plan->scene.view, view, x, y, f + 5);
        memcpy(out + 8 * i, f, sizeof f);
    }
}

static btf_ref_neighbours look_up(const uint16_t *table, uint32_t grid, const float direction[3]) {
    int32_t q[2];
    btf_ref_project(direction, q);
    return btf_ref_lookup(table, grid, q);
}

static double clip(double x) {
    return x > 0 ? (x < 1 ? x : 1) : 0;
}

void plan_add_errors(const double truth[3], const float rgb[3], double sum[2]) {
    for (int c = 0; c < 3; c++) {
        const double linear = clip(truth[c]) - clip((double)rgb[c]);
        const double srgb = (double)enc_srgb_encode((float)truth[c]) - (double)enc_srgb_encode(rgb[c]);
        sum[0] += linear * linear / 3;
        sum[1] += srgb * srgb / 3;
    }
}

btf_ref_options plan_reference_options(const btf_plan *plan) {
    return (btf_ref_options){.effects = plan->effects,
                             .components = plan->components ? plan->components : UINT32_MAX,
                             .interpolation = plan->shader.interpolation == BTF_INTERPOLATION_NEAREST
                                                  ? BTF_REF_NEAREST
                                                  : BTF_REF_LINEAR,
                             .filter = BTF_REF_TEXEL};
}

btf_result plan_measure(const enc_context *context, const enc_data *original, const btf_material *whole,
                        const btf_material *small, const btf_plan *plan, double planned[2],
                        double full[2]) {
    enum { SAMPLES = 20000, PAIRS = 5 };
    enc_data *filtered = NULL;
    btf_ref_material a, b;
    reference_view(whole, plan->level, &a);
    reference_view(small, 0, &b);
    btf_result result = BTF_OK;
    if (plan->level > 0) {
        result = enc_level_filter(context, original, (int)a.width, (int)a.height, &filtered);
    }
    const enc_data *data = filtered ? filtered : original;
    float *buffer = malloc(enc_data_texel_stride(data) * sizeof *buffer);
    const btf_ref_options everything = {BTF_EFFECT_ALL, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
    const btf_ref_options chosen = plan_reference_options(plan);
    const size_t n = (size_t)data->n_lights;
    random_state r = {99};
    planned[0] = planned[1] = full[0] = full[1] = 0;
    if (result == BTF_OK && !buffer) {
        result = BTF_ERROR_MEMORY;
    }
    for (int i = 0; i < SAMPLES / PAIRS && result == BTF_OK; i++) {
        /* evenly over texels, of which some err far more than others */
        const size_t texel = (size_t)i * enc_data_texel_count(data) / (SAMPLES / PAIRS);
        const uint32_t column = (uint32_t)texel % a.width, row = (uint32_t)texel / a.width;
        const float *samples;
        result = enc_data_texels(context, data, texel, 1, buffer, &samples);
        for (int p = 0; p < PAIRS && result == BTF_OK; p++) {
            float light[3], view[3], rgb[3];
            double truth[3] = {0};
            pick(&r, &plan->scene.view, data->views[data->n_views - 1].theta, view);
            pick(&r, &plan->scene.light, data->lights[data->n_lights - 1].theta, light);
            const btf_ref_neighbours views = look_up(a.view_table, a.view_grid, view);
            const btf_ref_neighbours lights = look_up(a.light_table, a.light_grid, light);
            for (int k = 0; k < 27; k++) {
                truth[k % 3] +=
                    0x1p-24 * views.weight[k / 9] * lights.weight[k / 3 % 3] *
                    (double)samples[(views.index[k / 9] * 3 + (size_t)k % 3) * n + lights.index[k / 3 % 3]];
            }
            btf_ref_evaluate_texel(&a, &everything, column, row, light, view, rgb);
            plan_add_errors(truth, rgb, full);
            btf_ref_evaluate_texel(&b, &chosen, column, row, light, view, rgb);
            plan_add_errors(truth, rgb, planned);
        }
    }
    for (int i = 0; i < 2; i++) {
        planned[i] /= SAMPLES;
        full[i] /= SAMPLES;
    }
    free(buffer);
    enc_data_destroy(&filtered);
    return result;
}
