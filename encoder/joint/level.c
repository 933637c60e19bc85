/* Levels of the joint method. See level.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "level.h"

#include "choose.h"
#include "fit.h"
#include "front_fit.h"
#include "solve.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    ROUNDS = 2, /* of search and least squares */
    STARTS = 2, /* of the SBRDF's first fit */
};

/* As for level 0 (fit.c). */
static const double shift_tolerance = 1e-6, prior_strength = 3.0;

/* Codes of component j of u count in units of the square root of their mean square in level 0, so that u
 * has variance 1, as the prior expects. */
static void find_steps(const enc_solution *base, double *step) {
    const size_t texels = enc_solution_texels(base), k = base->n_components;
    for (size_t j = 0; j < k; j++) {
        double sum = 0.0;
        for (size_t t = 0; t < texels; t++)
            sum += (double)base->residual_texels[t * k + j] * base->residual_texels[t * k + j];
        step[j] = sum > 0.0 ? sqrt((double)texels / sum) : 1.0;
    }
}

/* v = code * scale / step * m(l). */
static void load_v(const joint_rows *rows, const enc_solution *base, const double *step,
                   joint_model *model) {
    const size_t k = model->k, lights = rows->row / 3;
    for (size_t view = 0; view < rows->views; view++)
        for (size_t light = 0; light < lights; light++)
            for (size_t channel = 0; channel < 3; channel++) {
                const int8_t *code =
                    base->residual_directions + ((view * lights + light) * 3 + channel) * k;
                const size_t p = channel * lights + light;
                for (size_t j = 0; j < k; j++)
                    model->v[(view * k + j) * rows->row + p] =
                        (float)((double)code[j] * base->residual_scales[j] / step[j] * rows->multiplier[p]);
            }
}

/* U, sources and gains from the data; codes [texel][k]. */
static btf_result fit(const joint_rows *rows, joint_projection *projection, const double *step,
                      joint_model *model, int8_t *codes) {
    const joint_rounding rounding = {step, codes};
    double error = rows->total;
    btf_result result = BTF_OK;
    for (int i = 0; i <= ROUNDS && result == BTF_OK; i++) {
        if (i > 0)
            result = joint_choose(rows, projection, true, shift_tolerance, model, &error);
        if (result == BTF_OK)
            result = joint_solve_u(rows, projection, NULL, model);
        if (result == BTF_OK)
            result = joint_choose(rows, projection, false, 0.0, model, &error);
        if (result == BTF_OK && model->front) {
            result = joint_front_refit(rows, model);
            if (result == BTF_OK)
                result = joint_project(rows, model, projection);
        }
        model->prior =
            prior_strength * error / ((double)rows->texels * (double)rows->views * (double)rows->row);
    }
    if (result == BTF_OK)
        result = joint_solve_u(rows, projection, &rounding, model);
    if (result == BTF_OK)
        result = joint_choose(rows, projection, true, shift_tolerance, model, &error);
    return result;
}

static btf_result hand_over(const joint_rows *rows, joint_model *model, int8_t **codes, enc_solution *out) {
    const size_t points = rows->texels * rows->views;
    if (out->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN))
        out->shift = malloc(2 * points);
    if (out->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN))
        out->gain = malloc(points);
    if (out->effects & BTF_EFFECT_HIDDEN)
        out->centre = calloc(points, sizeof *out->centre);
    if ((out->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN) && !out->shift) ||
        (out->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN) && !out->gain) ||
        (out->effects & BTF_EFFECT_HIDDEN && !out->centre))
        return enc_fail(rows->context, BTF_ERROR_MEMORY, "levels: out of memory for %zu points", points);
    if (out->gain)
        memcpy(out->gain, model->gain, points);
    for (size_t i = 0; i < points && out->shift; i++) {
        int dx, dy;
        const bool fits =
            joint_shift(out->width, out->height, (uint32_t)(i % rows->texels), model->match[i], &dx, &dy);
        assert(fits);
        (void)fits;
        out->shift[2 * i] = (int8_t)dx;
        out->shift[2 * i + 1] = (int8_t)dy;
    }
    out->residual_texels = *codes;
    *codes = NULL;
    if (model->front) {
        const joint_front *front = model->front;
        const size_t texels = rows->texels, lights = rows->row / 3;
        out->shadow = front->shadow ? malloc(texels * lights) : NULL;
        if (front->shadow && !out->shadow)
            return enc_fail(rows->context, BTF_ERROR_MEMORY, "levels: out of memory for %zu shadows",
                            texels * lights);
        for (size_t i = 0; out->shadow && i < texels * lights; i++)
            out->shadow[i] = front->shadow[i % texels * lights + i / texels];
        out->sbrdf = model->front->sbrdf;
        model->front->sbrdf = NULL;
    }
    return BTF_OK;
}

static joint_front_kind front_of(const enc_solution *base) {
    return (joint_front_kind){.lobes = base->sbrdf->lobes,
                              .rgb = base->sbrdf->rgb,
                              .shadow = base->effects & BTF_EFFECT_SHADOW,
                              .half = base->half_parameters};
}

/* An SBRDF, and shadows, of the level's own in front of the residual. */
static btf_result fit_front_first(const joint_rows *rows, const enc_solution *base, joint_model *model) {
    const joint_front_kind kind = front_of(base);
    const btf_result result = joint_front_create(rows, &kind, &model->front);
    if (result != BTF_OK)
        return result;
    if (kind.shadow)
        model->front->shadow_scale = base->shadow_scale;
    return joint_front_fit(rows, model, STARTS);
}

/* U, shifts and gains for the V of `base`. */
static btf_result fit_residual(const joint_rows *rows, const enc_solution *base, enc_solution *out) {
    const size_t k = base->n_components;
    joint_model model = {0};
    joint_projection projection = {0};
    double *step = malloc(k * sizeof *step);
    int8_t *codes = malloc(rows->texels * k);
    btf_result result = step && codes ? joint_model_init(rows, k, &model)
                                      : enc_fail(rows->context, BTF_ERROR_MEMORY,
                                                 "levels: out of memory for %zu components", k);
    if (result == BTF_OK && base->sbrdf)
        result = fit_front_first(rows, base, &model);
    if (result == BTF_OK)
        result = joint_projection_init(rows, &model, &projection);
    if (result == BTF_OK) {
        find_steps(base, step);
        load_v(rows, base, step, &model);
        model.shift = base->effects & BTF_EFFECT_SHIFT;
        model.gains.step = base->gain_scale;
        if (base->effects & BTF_EFFECT_GAIN) {
            model.gains.low = 1;
            model.gains.high = 255;
        }
        result = joint_project(rows, &model, &projection);
    }
    if (result == BTF_OK)
        result = fit(rows, &projection, step, &model, codes);
    if (result == BTF_OK)
        result = hand_over(rows, &model, &codes, out);
    free(step);
    free(codes);
    joint_projection_clear(&projection);
    joint_model_clear(&model);
    return result;
}

/* SBRDF, shadow, shifts and gains, where there is no residual. */
static btf_result fit_front_alone(const joint_rows *rows, const enc_solution *base, enc_solution *out) {
    const joint_front_kind kind = front_of(base);
    joint_fit fit = {0};
    enc_solution found = {0};
    btf_result result = joint_fit_front_alone(rows, base->effects, &kind, STARTS, &fit);
    for (int i = 0; i < ROUNDS && result == BTF_OK; i++)
        result = joint_fit_round(&fit);
    if (result == BTF_OK)
        result = joint_fit_solution(&fit, &found);
    out->sbrdf = found.sbrdf;
    out->shadow = found.shadow;
    out->shift = found.shift;
    out->gain = found.gain;
    joint_fit_clear(&fit);
    return result;
}

btf_result enc_joint_level(const enc_context *context, const enc_data *data, const enc_solution *base,
                           enc_solution *out_solution) {
    joint_rows rows = {0};
    *out_solution = enc_level_of(base, data->width, data->height);
    btf_result result =
        joint_rows_init_scaled(context, data, base->domain == BTF_DOMAIN_SQRT, base->radiance_scale, &rows);
    if (result == BTF_OK)
        result = base->effects & BTF_EFFECT_RESIDUAL ? fit_residual(&rows, base, out_solution)
                                                     : fit_front_alone(&rows, base, out_solution);
    joint_rows_clear(&rows);
    if (result != BTF_OK)
        enc_level_clear(out_solution);
    return result;
}
