/* The alternation of the joint method (see joint.h).
 *
 * One round, given the per-view bases v of the sources:
 *   1. search:  every point (texel, view) chooses source and gain                  joint_search.c
 *   2. u:       every source is solved for the points that chose it               joint_sources.c
 *   3. gains:   chosen again
 *   4. v:       every view's basis is solved for all of its points
 * Each step minimises the one squared error over its unknowns and keeps the others, so that a round never
 * raises it. The start is the plain factorisation of the data (every point its own source, gain 1), by the
 * same steps without the search. Last, the model is rounded to the codes of the file (joint_quantise.c).
 *
 * SPDX-License-Identifier: MIT
 */
#include "joint.h"
#include "joint_budget.h"
#include "joint_quantise.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What a preset stands for. */
typedef struct preset_values {
    int start;        /* rounds of the plain factorisation */
    int rounds;       /* with search */
    double tolerance; /* relative decrease of the error that ends the rounds */
} preset_values;

static const preset_values presets[] = {
    [ENC_JOINT_FAST] = {3, 5, 2e-3},
    [ENC_JOINT_MEDIUM] = {4, 20, 5e-4},
    [ENC_JOINT_THOROUGH] = {4, 100, 1e-4},
    [ENC_JOINT_EXHAUSTIVE] = {6, ENC_JOINT_MAX_ROUNDS, 1e-6},
};

/* A shift must lower a point's squared error by this part of the point's energy (60 dB below it). */
static const double shift_tolerance = 1e-6;

enc_joint_options enc_joint_options_default(void) {
    return (enc_joint_options){.preset = ENC_JOINT_MEDIUM, .effects = BTF_EFFECT_ALL};
}

/* Everything a fit works on. */
typedef struct joint_fit {
    joint_rows rows;
    joint_model model;
    joint_projection projection;
    joint_codes codes;
    double samples;
} joint_fit;

static void fit_clear(joint_fit *fit) {
    joint_codes_clear(&fit->codes);
    joint_projection_clear(&fit->projection);
    joint_model_clear(&fit->model);
    joint_rows_clear(&fit->rows);
}

/* Uniform in -0.5 .. 0.5 (xorshift64*, Vigna 2016). */
static float random_unit(uint64_t *state) {
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (float)((double)((*state * 2685821657736338717u) >> 40) * 0x1p-24 - 0.5);
}

/* u and v of the plain factorisation: subspace iteration from random u. */
static btf_result factorise(joint_fit *fit, int rounds) {
    joint_model *model = &fit->model;
    uint64_t state = 88172645463325252u;
    double error = 0.0;
    btf_result result = BTF_OK;
    for (size_t i = 0; i < model->texels * model->k; i++)
        model->u[i] = random_unit(&state);
    for (int i = 0; i < rounds && result == BTF_OK; i++) {
        result = joint_solve_v(&fit->rows, NULL, model);
        if (result == BTF_OK)
            result = joint_project(&fit->rows, model, &fit->projection);
        if (result == BTF_OK)
            result = joint_solve_u(&fit->rows, &fit->projection, NULL, model);
        if (result == BTF_OK)
            result = joint_orthogonalise(&fit->rows, model);
        enc_stage_step(fit->rows.context, 1);
    }
    if (result == BTF_OK)
        result = joint_solve_v(&fit->rows, NULL, model);
    if (result == BTF_OK)
        result = joint_project(&fit->rows, model, &fit->projection);
    if (result == BTF_OK)
        result = joint_choose(&fit->rows, &fit->projection, false, 0.0, model, &error);
    model->prior = 3.0 * error / fit->samples;
    return result;
}

/* One round; *error before and after. Expects the projection of the present v and leaves that of the new.
 */
static btf_result alternate(joint_fit *fit, double *error) {
    joint_model *model = &fit->model;
    btf_result result = joint_choose(&fit->rows, &fit->projection, true, shift_tolerance, model, error);
    if (result == BTF_OK)
        result = joint_solve_u(&fit->rows, &fit->projection, NULL, model);
    if (result == BTF_OK)
        result = joint_choose(&fit->rows, &fit->projection, false, 0.0, model, error);
    if (result == BTF_OK)
        result = joint_orthogonalise(&fit->rows, model);
    if (result == BTF_OK)
        result = joint_solve_v(&fit->rows, NULL, model);
    if (result == BTF_OK)
        result = joint_project(&fit->rows, model, &fit->projection);
    if (result == BTF_OK)
        result = joint_choose(&fit->rows, &fit->projection, false, 0.0, model, error);
    model->prior = 3.0 * *error / fit->samples;
    enc_stage_step(fit->rows.context, 1);
    return result;
}

/* Hands the codes over. */
static btf_result make_solution(const joint_fit *fit, uint32_t effects, enc_solution *out) {
    const joint_rows *rows = &fit->rows;
    const joint_model *model = &fit->model;
    const size_t texels = rows->texels, views = rows->views, k = model->k, lights = rows->row / 3;
    *out = (enc_solution){.width = rows->data->width,
                          .height = rows->data->height,
                          .n_views = rows->data->n_views,
                          .n_lights = rows->data->n_lights,
                          .domain = rows->root ? BTF_DOMAIN_SQRT : BTF_DOMAIN_LINEAR,
                          .effects = effects,
                          .radiance_scale = rows->scale,
                          .shadow_scale = 1.0f / 255.0f,
                          .gain_scale = model->gains.step,
                          .centre_scale = 1.0f / 255.0f,
                          .n_components = (uint32_t)k};
    out->residual_texels = malloc(texels * k);
    out->residual_directions = malloc(views * rows->row * k);
    out->residual_scales = malloc(k * sizeof *out->residual_scales);
    out->shift = malloc(texels * views * 2);
    out->gain = malloc(texels * views);
    if (!out->residual_texels || !out->residual_directions || !out->residual_scales || !out->shift ||
        !out->gain)
        return enc_fail(rows->context, BTF_ERROR_MEMORY, "joint: out of memory for the solution");
    memcpy(out->residual_texels, fit->codes.u, texels * k);
    memcpy(out->gain, model->gain, texels * views);
    for (size_t j = 0; j < k; j++) {
        const double scale = fit->codes.u_step[j] * fit->codes.v_step[j];
        out->residual_scales[j] = scale >= 0x1p-24 ? (float)scale : 0.0f;
    }
    for (size_t view = 0; view < views; view++)
        for (size_t light = 0; light < lights; light++)
            for (size_t channel = 0; channel < 3; channel++)
                for (size_t j = 0; j < k; j++)
                    out->residual_directions[((view * lights + light) * 3 + channel) * k + j] =
                        fit->codes.v[(view * k + j) * rows->row + channel * lights + light];
    for (size_t i = 0; i < texels * views; i++) {
        int dx, dy;
        const bool fits = joint_shift(rows->data->width, rows->data->height, (uint32_t)(i % texels),
                                      model->match[i], &dx, &dy);
        assert(fits);
        (void)fits;
        out->shift[2 * i] = (int8_t)dx;
        out->shift[2 * i + 1] = (int8_t)dy;
    }
    return BTF_OK;
}

btf_result enc_joint(const enc_context *context, const enc_data *data, const enc_joint_options *options,
                     enc_solution *out_solution, enc_joint_stats *out_stats) {
    const preset_values *preset = &presets[options->preset];
    const int rounds = options->rounds > 0 ? options->rounds : preset->rounds;
    const double tolerance = options->tolerance > 0.0 ? options->tolerance : preset->tolerance;
    const uint64_t budget = options->budget ? options->budget : joint_default_budget(data);
    joint_shape shape = {options->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL), 0,
                         0};
    enc_joint_stats *stats = calloc(1, sizeof *stats);
    joint_fit fit = {0};
    double error = 0.0;
    btf_result result = BTF_OK;
    *out_solution = (enc_solution){0};
    if (!stats)
        return enc_fail(context, BTF_ERROR_MEMORY, "joint: out of memory");
    if (!(shape.effects & BTF_EFFECT_RESIDUAL)) {
        result = enc_fail(context, BTF_ERROR_USAGE, "joint: effect residual is needed");
        goto fail;
    }
    shape.components = joint_components_for(data, &shape, budget,
                                            options->components > 0 ? (size_t)options->components : 128);
    if (shape.components == 0) {
        result = enc_fail(context, BTF_ERROR_USAGE, "joint: budget of %llu bytes holds no component",
                          (unsigned long long)budget);
        goto fail;
    }
    enc_stage_begin(context, "joint", (size_t)(preset->start + rounds));
    result = joint_rows_init(context, data, options->metric != ENC_JOINT_LINEAR, &fit.rows);
    fit.samples = (double)fit.rows.texels * (double)fit.rows.views * (double)fit.rows.row;
    if (result == BTF_OK)
        result = joint_model_init(&fit.rows, shape.components, shape.effects & BTF_EFFECT_SHIFT, false,
                                  &fit.model);
    if (result == BTF_OK)
        result = joint_projection_init(&fit.rows, shape.components, &fit.projection);
    if (result == BTF_OK)
        result = joint_codes_init(&fit.rows, shape.components, &fit.codes);
    if (result == BTF_OK)
        result = factorise(&fit, preset->start);
    if (shape.effects & BTF_EFFECT_GAIN) {
        fit.model.gains.low = 1;
        fit.model.gains.high = 255;
    }
    for (int i = 0; i < rounds && result == BTF_OK; i++) {
        const double before = error;
        result = alternate(&fit, &error);
        stats->history[stats->rounds++] = error;
        if (i > 0 && before - error < tolerance * before)
            break;
    }
    if (result == BTF_OK)
        result =
            joint_quantise(&fit.rows, &fit.projection, shift_tolerance, &fit.model, &fit.codes, &error);
    if (result == BTF_OK)
        result = make_solution(&fit, shape.effects, out_solution);
    enc_stage_end(context);
    if (result == BTF_OK) {
        stats->rounded = error;
        stats->psnr = error > 0.0 ? -10.0 * log10(error / fit.samples) : 100.0;
        stats->gpu_bytes = joint_bytes(data, &shape);
        for (size_t i = 0; i < fit.rows.texels * fit.rows.views; i++)
            stats->moved += fit.model.match[i] != i % fit.rows.texels;
        if (out_stats)
            *out_stats = *stats;
    }
fail:
    if (result != BTF_OK)
        enc_solution_clear(out_solution);
    fit_clear(&fit);
    free(stats);
    return result;
}
