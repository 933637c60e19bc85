/* The codes of the joint model. See quantise.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "quantise.h"

#include "choose.h"
#include "encoder/base/ranks.h"
#include "encoder/math/linear.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HELPERS = 4 }; /* components that get a second one to carry their rounding error */

btf_result joint_codes_init(const joint_rows *rows, size_t k, joint_codes *out_codes) {
    *out_codes = (joint_codes){.u = calloc(rows->texels, k + 1),
                               .v = calloc(rows->views * k + 1, rows->row),
                               .u_step = calloc(k + 1, sizeof(double)),
                               .v_step = calloc(k + 1, sizeof(double))};
    if (!out_codes->u || !out_codes->v || !out_codes->u_step || !out_codes->v_step)
        return enc_fail(rows->context, BTF_ERROR_MEMORY,
                        "joint: out of memory for the codes of %zu components", k);
    return BTF_OK;
}

void joint_codes_clear(joint_codes *codes) {
    free(codes->u);
    free(codes->v);
    free(codes->u_step);
    free(codes->v_step);
    *codes = (joint_codes){0};
}

/* u := u * t and v := t^-1 v, both given: t [k][k] acts on rows of u from the right, inverse on v from the
 * left. */
static btf_result change_basis(const joint_rows *rows, joint_model *model, const double *t,
                               const double *inverse) {
    const size_t k = model->k, row = model->row;
    size_t first, end;
    enc_ranks_range(rows->context, model->texels, &first, &end);
#pragma omp parallel for num_threads(rows->context->threads)
    for (size_t s = first; s < end; s++) {
        double x[JOINT_MAX_COMPONENTS] = {0};
        float *u = model->u + s * k;
        for (size_t i = 0; i < k; i++)
            for (size_t j = 0; j < k; j++)
                x[j] += u[i] * t[i * k + j];
        for (size_t j = 0; j < k; j++)
            u[j] = (float)x[j];
    }
    joint_rows_views(rows, &first, &end);
#pragma omp parallel for num_threads(rows->context->threads)
    for (size_t view = first; view < end; view++)
        for (size_t p = 0; p < row; p++) {
            double x[JOINT_MAX_COMPONENTS];
            float *v = model->v + view * k * row + p;
            for (size_t i = 0; i < k; i++) {
                x[i] = 0.0;
                for (size_t j = 0; j < k; j++)
                    x[i] += inverse[i * k + j] * v[j * row];
            }
            for (size_t i = 0; i < k; i++)
                v[i * row] = (float)x[i];
        }
    const btf_result result =
        enc_ranks_gather(rows->context, BTF_OK, model->u, k * sizeof *model->u, model->texels);
    return joint_rows_gather(rows, result, model->v, k * row * sizeof *model->v);
}

/* a [k][k] = sum over points of gain^2 u u^T / points. */
static void gram_of_u(const joint_model *model, double *a) {
    const size_t k = model->k, points = model->views * model->texels;
    double *weight = a + k * k; /* [texel], behind the matrix */
    memset(a, 0, (k * k + model->texels) * sizeof *a);
    for (size_t i = 0; i < points; i++) {
        const double gain = (double)model->gain[i] * model->gains.step;
        weight[model->match[i]] += gain * gain;
    }
    for (size_t s = 0; s < model->texels; s++)
        for (size_t i = 0; i < k; i++) {
            const double factor = weight[s] * model->u[s * k + i] / (double)points;
            for (size_t j = i; j < k; j++)
                a[i * k + j] += factor * model->u[s * k + j];
        }
}

static void gram_of_v(const joint_model *model, double *a) {
    const size_t k = model->k, row = model->row;
    memset(a, 0, k * k * sizeof *a);
    for (size_t view = 0; view < model->views; view++)
        for (size_t i = 0; i < k; i++)
            for (size_t j = 0; j <= i; j++) {
                const float *x = model->v + (view * k + i) * row, *y = model->v + (view * k + j) * row;
                double sum = 0.0;
                for (size_t p = 0; p < row; p++)
                    sum += (double)x[p] * y[p];
                a[i * k + j] += sum;
            }
    for (size_t i = 0; i < k; i++)
        for (size_t j = i + 1; j < k; j++)
            a[i * k + j] = a[j * k + i];
}

static btf_result no_memory(const joint_rows *rows, size_t k) {
    return enc_fail(rows->context, BTF_ERROR_MEMORY, "joint: out of memory for a basis of %zu components",
                    k);
}

/* u := u L^-T and v := L^T v, a = L L^T the Gram matrix of u, slightly regularised; a is destroyed, t and
 * inverse are scratch, all [k][k]. */
static btf_result whiten(const joint_rows *rows, joint_model *model, double *a, double *t,
                         double *inverse) {
    const size_t k = model->k;
    double trace = 0.0;
    for (size_t i = 0; i < k; i++)
        trace += a[i * k + i];
    for (size_t i = 0; i < k; i++)
        a[i * k + i] += 1e-10 * trace / (double)k + 1e-30;
    const bool solved = enc_cholesky(k, a);
    assert(solved); /* a Gram matrix with a positive diagonal added */
    (void)solved;
    memset(t, 0, k * k * sizeof *t);
    for (size_t i = 0; i < k; i++)
        t[i * k + i] = 1.0;
    enc_upper_solve(k, a, t, k);
    for (size_t i = 0; i < k; i++)
        for (size_t j = 0; j < k; j++)
            inverse[i * k + j] = j >= i ? a[i * k + j] : 0.0;
    return change_basis(rows, model, t, inverse);
}

btf_result joint_orthogonalise(const joint_rows *rows, joint_model *model) {
    const size_t k = model->k;
    double *a = calloc(3 * k * k, sizeof *a);
    if (!a)
        return no_memory(rows, k);
    for (size_t s = 0; s < model->texels; s++)
        for (size_t i = 0; i < k; i++)
            for (size_t j = i; j < k; j++)
                a[i * k + j] += (double)model->u[s * k + i] * model->u[s * k + j];
    for (size_t i = 0; i < k * k; i++)
        a[i] /= (double)model->texels;
    const btf_result result = whiten(rows, model, a, a + k * k, a + 2 * k * k);
    free(a);
    return result;
}

btf_result joint_principal_basis(const joint_rows *rows, joint_model *model, double *energy) {
    const size_t k = model->k;
    double *a = malloc((4 * k * k + k + model->texels) * sizeof *a);
    if (!a)
        return no_memory(rows, k);
    double *vectors = a + k * k + model->texels, *t = vectors + k * k, *inverse = t + k * k,
           *values = inverse + k * k;
    gram_of_u(model, a);
    btf_result result = whiten(rows, model, a, t, inverse);
    gram_of_v(model, a);
    enc_eigen(k, a, values, vectors);
    for (size_t j = 0; j < k && energy; j++)
        energy[j] = values[j] * (double)model->texels;
    for (size_t i = 0; i < k; i++)
        for (size_t j = 0; j < k; j++)
            t[i * k + j] = vectors[j * k + i];
    if (result == BTF_OK)
        result = change_basis(rows, model, t, vectors);
    free(a);
    return result;
}

/* Largest |v / m| of a component. */
static double range_of_v(const joint_rows *rows, const joint_model *model, size_t component) {
    double range = 0.0;
    for (size_t view = 0; view < model->views; view++)
        for (size_t p = 0; p < model->row; p++) {
            const double x =
                fabs(model->v[(view * model->k + component) * model->row + p] / rows->multiplier[p]);
            range = x > range ? x : range;
        }
    return range;
}

static double range_of_u(const joint_model *model, size_t component) {
    double range = 0.0;
    for (size_t s = 0; s < model->texels; s++) {
        const double x = fabs(model->u[s * model->k + component]);
        range = x > range ? x : range;
    }
    return range;
}

/* The strongest few components each get one of the weakest as a helper; the helpers stand right behind them
 * all: 0, 1, 2, 3, k - 1, k - 2, k - 3, k - 4, 4, 5, ... Then u_j += r u_i, v_i -= r v_j for each such
 * pair: one step of v_j moves the sum by much less than one of v_i along the strong component, and by
 * little along the weak; with r = sqrt(step_i / step_j) both come to sqrt(step_i step_j), where the strong
 * one alone had step_i. A decoder that stops before the helpers loses r u_i v_j, some 30 dB below component
 * i. */
static btf_result add_helpers(const joint_rows *rows, joint_model *model) {
    const size_t k = model->k, row = model->row;
    const size_t pairs = k / 4 < HELPERS ? k / 4 : HELPERS;
    double *t = calloc(2 * k * k, sizeof *t), *inverse = t + k * k;
    if (!t)
        return no_memory(rows, k);
    for (size_t to = 0; to < k; to++) {
        const size_t from = to >= 2 * pairs ? to - pairs : to >= pairs ? k - 1 - (to - pairs) : to;
        t[from * k + to] = inverse[to * k + from] = 1.0;
    }
    const btf_result result = change_basis(rows, model, t, inverse);
    free(t);
    for (size_t i = 0; i < pairs && result == BTF_OK; i++) {
        const size_t j = pairs + i;
        const double strong = range_of_v(rows, model, i), weak = range_of_v(rows, model, j);
        if (!(weak > 0.0) || strong < 4.0 * weak)
            continue;
        const double r = sqrt(strong / weak);
        for (size_t s = 0; s < model->texels; s++)
            model->u[s * k + j] += (float)(r * model->u[s * k + i]);
        for (size_t view = 0; view < model->views; view++)
            for (size_t p = 0; p < row; p++)
                model->v[(view * k + i) * row + p] -= (float)(r * model->v[(view * k + j) * row + p]);
    }
    return result;
}

/* Steps of u for ranges of at most `clip` times a component's root mean square; beyond it codes end. */
static void set_u_steps(const joint_model *model, double clip, double *step) {
    for (size_t j = 0; j < model->k; j++) {
        double sum = 0.0;
        for (size_t s = 0; s < model->texels; s++)
            sum += (double)model->u[s * model->k + j] * model->u[s * model->k + j];
        step[j] = fmin(range_of_u(model, j), clip * sqrt(sum / (double)model->texels)) / 127.0;
    }
}

/* Rounds u. A few texels reach many times as far as the rest, and would make the steps of all coarse: the
 * better of cutting them off and of keeping them. */
static btf_result round_u(const joint_rows *rows, const joint_projection *projection, joint_model *model,
                          joint_codes *codes) {
    static const double clips[2] = {8.0, 1e9};
    const size_t k = model->k, count = model->texels * k, points = model->texels * model->views;
    const joint_rounding rounding = {codes->u_step, codes->u};
    float *u = malloc(2 * count * sizeof *u), *best_u = u + count;
    int8_t *best_codes = malloc(count);
    uint8_t *gain = malloc(points);
    double *best_step = malloc(k * sizeof *best_step), error, best = HUGE_VAL;
    btf_result result = u && best_codes && gain && best_step ? BTF_OK : no_memory(rows, k);
    if (result == BTF_OK) {
        memcpy(u, model->u, count * sizeof *u);
        memcpy(gain, model->gain, points);
    }
    for (int i = 0; i < 2 && result == BTF_OK; i++) {
        memcpy(model->u, u, count * sizeof *u);
        memcpy(model->gain, gain, points);
        set_u_steps(model, clips[i], codes->u_step);
        result = joint_solve_u(rows, projection, &rounding, model);
        if (result == BTF_OK)
            result = joint_choose(rows, projection, false, 0.0, model, &error);
        if (result == BTF_OK && error < best) {
            best = error;
            memcpy(best_u, model->u, count * sizeof *u);
            memcpy(best_codes, codes->u, count);
            memcpy(best_step, codes->u_step, k * sizeof *best_step);
        }
    }
    if (result == BTF_OK) {
        memcpy(model->u, best_u, count * sizeof *u);
        memcpy(codes->u, best_codes, count);
        memcpy(codes->u_step, best_step, k * sizeof *best_step);
    }
    free(u);
    free(best_codes);
    free(gain);
    free(best_step);
    return result;
}

btf_result joint_quantise(const joint_rows *rows, joint_projection *projection, double tolerance,
                          joint_model *model, joint_codes *codes, double *out_error) {
    const size_t k = model->k;
    const joint_rounding round_v = {codes->v_step, codes->v};
    if (k == 0) {
        const btf_result projected = joint_project(rows, model, projection);
        return projected == BTF_OK ? joint_choose(rows, projection, false, tolerance, model, out_error)
                                   : projected;
    }
    btf_result result = joint_principal_basis(rows, model, NULL);
    if (result == BTF_OK)
        result = add_helpers(rows, model);
    for (size_t j = 0; j < k; j++)
        codes->v_step[j] = range_of_v(rows, model, j) / 127.0;
    if (result == BTF_OK)
        result = joint_solve_v(rows, &round_v, model);
    if (result == BTF_OK)
        result = joint_project(rows, model, projection);
    if (result == BTF_OK)
        result = joint_choose(rows, projection, true, tolerance, model, out_error);
    if (result == BTF_OK)
        result = joint_solve_u(rows, projection, NULL, model);
    if (result == BTF_OK)
        result = joint_choose(rows, projection, false, tolerance, model, out_error);
    if (result == BTF_OK)
        result = round_u(rows, projection, model, codes);
    if (result == BTF_OK)
        result = joint_choose(rows, projection, true, tolerance, model, out_error);
    return result;
}
