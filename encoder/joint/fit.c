/* The alternation: start, rounds and end of one fit (see fit.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "fit.h"

#include "choose.h"
#include "cost.h"
#include "encoder/base/stage.h"
#include "front_fit.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* A shift must lower a point's squared error by this part of the point's energy (60 dB below it). */
static const double shift_tolerance = 1e-6;

/* Variance of the noise over that of u, in errors a sample: more than 1, since u is drawn to 0 for what the
 * points of a source hardly determine alone. Measured: 1 to 10 make no difference to the error, and keep u
 * in range. */
static const double prior_strength = 3.0;

void joint_fit_clear(joint_fit *fit) {
    joint_codes_clear(&fit->codes);
    free(fit->centre_codes);
    joint_projection_clear(&fit->projection);
    joint_model_clear(&fit->model);
    *fit = (joint_fit){0};
}

joint_shape joint_fit_shape(const joint_fit *fit) {
    const joint_front *front = fit->model.front;
    return (joint_shape){.effects = fit->effects,
                         .components = fit->model.k,
                         .centres = fit->n_centres,
                         .lobes = front ? front->kind.lobes : 0,
                         .rgb = front && front->kind.rgb,
                         .half = front && front->kind.half};
}

/* Steps of the stage at work: what a part of a fit is predicted to cost. */
static void step(const joint_fit *fit, double (*cost)(const joint_extent *, const joint_shape *)) {
    const joint_extent extent = joint_extent_of(fit->rows->data);
    const joint_shape shape = joint_fit_shape(fit);
    enc_stage_step(fit->rows->context, joint_cost_steps(cost(&extent, &shape)));
}

void joint_fit_release(joint_fit *fit) {
    joint_projection_clear(&fit->projection);
}

/* Projects the data on the present v, and sets error and prior. */
static btf_result refresh(joint_fit *fit) {
    const joint_rows *rows = fit->rows;
    btf_result result = BTF_OK;
    if (!fit->projection.c)
        result = joint_projection_init(rows, &fit->model, &fit->projection);
    if (result == BTF_OK)
        result = joint_project(rows, &fit->model, &fit->projection);
    if (result == BTF_OK)
        result = joint_choose(rows, &fit->projection, false, 0.0, &fit->model, &fit->error);
    step(fit, joint_cost_refresh);
    fit->model.prior =
        prior_strength * fit->error / ((double)rows->texels * (double)rows->views * (double)rows->row);
    return result;
}

/* Uniform in -0.5 .. 0.5 (xorshift64*, Vigna 2016). */
static float random_unit(uint64_t *state) {
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (float)((double)((*state * 2685821657736338717u) >> 40) * 0x1p-24 - 0.5);
}

btf_result joint_fit_refine_plain(joint_fit *fit, int steps, double *energy) {
    btf_result result = BTF_OK;
    for (int i = 0; i < steps && result == BTF_OK; i++) {
        result = joint_solve_v(fit->rows, NULL, &fit->model);
        if (result == BTF_OK)
            result = refresh(fit);
        if (result == BTF_OK)
            result = joint_solve_u(fit->rows, &fit->projection, NULL, &fit->model);
        if (result == BTF_OK)
            result = joint_orthogonalise(fit->rows, &fit->model);
        step(fit, joint_cost_solve);
    }
    if (result == BTF_OK)
        result = joint_solve_v(fit->rows, NULL, &fit->model);
    if (result == BTF_OK)
        result = joint_principal_basis(fit->rows, &fit->model, energy);
    step(fit, joint_cost_solve);
    if (result == BTF_OK)
        result = refresh(fit);
    return result;
}

btf_result joint_fit_init(const joint_rows *rows, size_t k, uint32_t effects, joint_fit *out_fit) {
    *out_fit = (joint_fit){.rows = rows, .effects = effects};
    const btf_result result = joint_model_init(rows, k, &out_fit->model);
    out_fit->model.shift = effects & BTF_EFFECT_SHIFT;
    if (effects & BTF_EFFECT_GAIN) {
        out_fit->model.gains.low = 1;
        out_fit->model.gains.high = 255;
    }
    return result;
}

btf_result joint_fit_plain(const joint_rows *rows, size_t k, int steps, joint_fit *out_fit,
                           double *energy) {
    uint64_t state = 88172645463325252u;
    btf_result result = joint_fit_init(rows, k, BTF_EFFECT_RESIDUAL, out_fit);
    for (size_t i = 0; i < rows->texels * k && result == BTF_OK; i++)
        out_fit->model.u[i] = random_unit(&state);
    if (result == BTF_OK)
        result = joint_fit_refine_plain(out_fit, steps, energy);
    return result;
}

/* Centres, and the points that they show. */
static bool copy_centres(const joint_fit *from, joint_fit *to) {
    const size_t points = to->rows->texels * to->rows->views, size = from->n_centres * to->rows->row;
    joint_model *model = &to->model;
    to->n_centres = from->n_centres;
    to->centre_scale = from->centre_scale;
    to->centre_codes = malloc(size);
    model->centre = malloc(points * sizeof *model->centre);
    model->centre_error = malloc(points * sizeof *model->centre_error);
    if (!to->centre_codes || !model->centre || !model->centre_error)
        return false;
    memcpy(to->centre_codes, from->centre_codes, size);
    memcpy(model->centre, from->model.centre, points * sizeof *model->centre);
    memcpy(model->centre_error, from->model.centre_error, points * sizeof *model->centre_error);
    return true;
}

btf_result joint_fit_start(const joint_fit *from, size_t k, uint32_t effects, joint_fit *out_fit) {
    const joint_rows *rows = from->rows;
    const size_t points = rows->texels * rows->views;
    assert(k <= from->model.k);
    btf_result result = joint_fit_init(rows, k, effects, out_fit);
    if (result != BTF_OK)
        return result;
    joint_model *model = &out_fit->model;
    for (size_t s = 0; s < rows->texels; s++)
        memcpy(model->u + s * k, from->model.u + s * from->model.k, k * sizeof(float));
    for (size_t view = 0; view < rows->views; view++)
        memcpy(model->v + view * k * rows->row, from->model.v + view * from->model.k * rows->row,
               k * rows->row * sizeof(float));
    memcpy(model->match, from->model.match, points * sizeof *model->match);
    memcpy(model->gain, from->model.gain, points);
    if (from->n_centres > 0 && !copy_centres(from, out_fit))
        return enc_fail(rows->context, BTF_ERROR_MEMORY, "joint: out of memory for %zu centres",
                        from->n_centres);
    if (from->model.front)
        result = joint_front_copy(rows, from->model.front, &model->front);
    return result == BTF_OK ? refresh(out_fit) : result;
}

/* u, then v, for everything else as it is. */
static btf_result solve_residual(joint_fit *fit) {
    btf_result result = joint_solve_u(fit->rows, &fit->projection, NULL, &fit->model);
    if (result == BTF_OK)
        result = joint_orthogonalise(fit->rows, &fit->model);
    if (result == BTF_OK)
        result = joint_solve_v(fit->rows, NULL, &fit->model);
    step(fit, joint_cost_solve);
    if (result == BTF_OK)
        result = refresh(fit);
    return result;
}

btf_result joint_fit_add_front(joint_fit *fit, const joint_front_kind *kind, int starts, int steps) {
    btf_result result = joint_front_create(fit->rows, kind, &fit->model.front);
    joint_projection_clear(&fit->projection); /* has other dimensions from here on */
    if (result == BTF_OK)
        result = joint_front_fit(fit->rows, &fit->model, starts);
    step(fit, joint_cost_front_fit);
    if (kind->shadow)
        fit->effects |= BTF_EFFECT_SHADOW;
    if (result == BTF_OK)
        result = refresh(fit);
    for (int i = 0; i < steps && fit->model.k > 0 && result == BTF_OK; i++)
        result = solve_residual(fit);
    return result;
}

btf_result joint_fit_front_alone(const joint_rows *rows, uint32_t effects, const joint_front_kind *kind,
                                 int starts, joint_fit *out_fit) {
    const btf_result result = joint_fit_init(rows, 0, effects, out_fit);
    if (result != BTF_OK)
        return result;
    return joint_fit_add_front(out_fit, kind, starts, 0);
}

btf_result joint_fit_point_errors(joint_fit *fit) {
    fit->model.point_error = calloc(fit->rows->texels * fit->rows->views, sizeof(float));
    if (!fit->model.point_error)
        return enc_fail(fit->rows->context, BTF_ERROR_MEMORY, "joint: out of memory for %zu points",
                        fit->rows->texels * fit->rows->views);
    return fit->projection.c
               ? joint_choose(fit->rows, &fit->projection, false, 0.0, &fit->model, &fit->error)
               : refresh(fit);
}

btf_result joint_fit_round(joint_fit *fit) {
    joint_model *model = &fit->model;
    const bool refit = model->front && (model->k == 0 || fit->rounds % JOINT_FRONT_PERIOD == 0);
    btf_result result = fit->projection.c ? BTF_OK : refresh(fit);
    if (result == BTF_OK)
        result = joint_choose(fit->rows, &fit->projection, true, shift_tolerance, model, &fit->error);
    step(fit, joint_cost_search);
    if (result == BTF_OK && model->k > 0)
        result = joint_solve_u(fit->rows, &fit->projection, NULL, model);
    if (result == BTF_OK && model->k > 0)
        result = joint_choose(fit->rows, &fit->projection, false, 0.0, model, &fit->error);
    if (result == BTF_OK && refit) {
        result = joint_front_refit(fit->rows, model);
        step(fit, joint_cost_front_refit);
    }
    if (result == BTF_OK && model->k > 0)
        result = joint_orthogonalise(fit->rows, model);
    if (result == BTF_OK && model->k > 0)
        result = joint_solve_v(fit->rows, NULL, model);
    step(fit, joint_cost_solve);
    if (result == BTF_OK)
        result = refresh(fit);
    fit->rounds++;
    return result;
}

btf_result joint_fit_quantise(joint_fit *fit) {
    btf_result result = joint_codes_init(fit->rows, fit->model.k, &fit->codes);
    if (result == BTF_OK && !fit->projection.c)
        result = joint_projection_init(fit->rows, &fit->model, &fit->projection);
    if (result == BTF_OK)
        result = joint_quantise(fit->rows, &fit->projection, shift_tolerance, &fit->model, &fit->codes,
                                &fit->error);
    step(fit, joint_cost_quantise);
    return result;
}

/* Shifts and gain codes of all points. */
static void export_points(const joint_fit *fit, enc_solution *out) {
    const size_t texels = fit->rows->texels;
    const int width = fit->rows->data->width, height = fit->rows->data->height;
    if (out->gain)
        memcpy(out->gain, fit->model.gain, texels * fit->rows->views);
    for (size_t i = 0; i < texels * fit->rows->views && out->shift; i++) {
        int dx, dy;
        const bool fits = joint_shift(width, height, (uint32_t)(i % texels), fit->model.match[i], &dx, &dy);
        assert(fits);
        (void)fits;
        const bool hidden = fit->n_centres > 0 && fit->model.gain[i] == 0;
        out->shift[2 * i] = hidden ? 0 : (int8_t)dx;
        out->shift[2 * i + 1] = hidden ? 0 : (int8_t)dy;
    }
    if (out->centre) {
        memcpy(out->centre, fit->model.centre, texels * fit->rows->views * sizeof *out->centre);
        memcpy(out->centre_codes, fit->centre_codes, fit->n_centres * fit->rows->row);
    }
}

/* The front's parameters and shadow codes. */
static btf_result export_front(const joint_fit *fit, enc_solution *out) {
    const joint_front *front = fit->model.front;
    const size_t texels = fit->rows->texels, lights = fit->rows->row / 3;
    const size_t count = texels * enc_sbrdf_stride(front->kind.lobes, front->kind.rgb);
    if (enc_sbrdf_create(texels, front->kind.lobes, front->kind.rgb, &out->sbrdf) != BTF_OK)
        return BTF_ERROR_MEMORY;
    memcpy(out->sbrdf->values, front->sbrdf->values, count * sizeof(float));
    out->half_parameters = front->kind.half;
    if (!front->shadow)
        return BTF_OK;
    out->shadow_scale = front->shadow_scale;
    out->shadow = malloc(texels * lights);
    for (size_t i = 0; out->shadow && i < texels * lights; i++)
        out->shadow[i] = front->shadow[i % texels * lights + i / texels];
    return out->shadow ? BTF_OK : BTF_ERROR_MEMORY;
}

/* Codes and scales of the residual. */
static void export_residual(const joint_fit *fit, enc_solution *out) {
    const size_t views = fit->rows->views, row = fit->rows->row, k = fit->model.k, lights = row / 3;
    memcpy(out->residual_texels, fit->codes.u, fit->rows->texels * k);
    for (size_t j = 0; j < k; j++) {
        const double scale = fit->codes.u_step[j] * fit->codes.v_step[j];
        out->residual_scales[j] = scale >= 0x1p-24 ? (float)scale : 0.0f;
    }
    for (size_t view = 0; view < views; view++)
        for (size_t light = 0; light < lights; light++)
            for (size_t channel = 0; channel < 3; channel++)
                for (size_t j = 0; j < k; j++)
                    out->residual_directions[((view * lights + light) * 3 + channel) * k + j] =
                        fit->codes.v[(view * k + j) * row + channel * lights + light];
}

btf_result joint_fit_solution(const joint_fit *fit, enc_solution *out_solution) {
    const joint_rows *rows = fit->rows;
    const size_t points = rows->texels * rows->views, k = fit->model.k;
    *out_solution = (enc_solution){.width = rows->data->width,
                                   .height = rows->data->height,
                                   .n_views = rows->data->n_views,
                                   .n_lights = rows->data->n_lights,
                                   .domain = rows->root ? BTF_DOMAIN_SQRT : BTF_DOMAIN_LINEAR,
                                   .effects = fit->effects,
                                   .radiance_scale = rows->scale,
                                   .shadow_scale = 1.0f / 255.0f,
                                   .gain_scale = fit->model.gains.step,
                                   .centre_scale = 1.0f / 255.0f,
                                   .n_components = (uint32_t)k};
    bool ok = true;
    if (fit->effects & BTF_EFFECT_SHIFT)
        ok = (out_solution->shift = malloc(2 * points)) && ok;
    if (fit->effects & BTF_EFFECT_GAIN)
        ok = (out_solution->gain = malloc(points)) && ok;
    if (fit->effects & BTF_EFFECT_HIDDEN) {
        out_solution->n_centres = (uint32_t)fit->n_centres;
        out_solution->centre_scale = fit->centre_scale;
        ok = (out_solution->centre = malloc(points * sizeof *out_solution->centre)) && ok;
        ok = (out_solution->centre_codes = malloc(fit->n_centres * rows->row)) && ok;
    }
    if (fit->effects & BTF_EFFECT_RESIDUAL) {
        out_solution->residual_texels = malloc(rows->texels * k);
        out_solution->residual_directions = malloc(rows->views * rows->row * k);
        out_solution->residual_scales = malloc(k * sizeof(float));
        ok = ok && out_solution->residual_texels && out_solution->residual_directions &&
             out_solution->residual_scales;
    }
    if (fit->model.front)
        ok = ok && export_front(fit, out_solution) == BTF_OK;
    if (!ok) {
        enc_solution_clear(out_solution);
        return enc_fail(rows->context, BTF_ERROR_MEMORY, "joint: out of memory for the solution");
    }
    export_points(fit, out_solution);
    if (fit->effects & BTF_EFFECT_RESIDUAL)
        export_residual(fit, out_solution);
    return BTF_OK;
}
