/* SBRDF times shadow under least squares. See front_fit.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "front_fit.h"

#include "encoder/base/ranks.h"
#include "encoder/lafortune/texel_fit.h"
#include "encoder/model/solution.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

enum { BATCH_BYTES = 96 << 20 }; /* of the targets that one pass over the data gathers */

/* Maxima of Ceres' passes over a source's samples, for the first fit and for a refit. */
enum { FIRST_EVALUATIONS = 60, REFIT_EVALUATIONS = 12 };

static btf_result no_memory(const joint_rows *rows) {
    return enc_fail(rows->context, BTF_ERROR_MEMORY, "joint: out of memory for %zu sources", rows->texels);
}

/* Sources first .. first + count - 1: what refers to them, gathered in one pass. */
typedef struct batch {
    const joint_rows *rows;
    const joint_model *model;
    size_t first, count;
    float *target; /* [source][view][row] gain-weighted sum, then mean, of the rows that refer to it */
    float *weight; /* [source][view] sum of squared gains */
} batch;

/* Whether a point has a say in one of the batch's sources. */
static bool refers(void *user, size_t view, size_t texel) {
    const batch *b = user;
    const size_t point = view * b->model->texels + texel, source = b->model->match[point];
    return source >= b->first && source < b->first + b->count && b->model->gain[point] != 0;
}

static void gather_row(void *user, size_t view, size_t texel, const float *from) {
    const batch *b = user;
    const joint_model *model = b->model;
    const size_t row = model->row, point = view * model->texels + texel;
    const float gain = (float)model->gain[point] * model->gains.step;
    const size_t at = (model->match[point] - b->first) * model->views + view;
    float *restrict target = b->target + at * row;
    b->weight[at] += gain * gain;
    for (size_t p = 0; p < row; p++)
        target[p] += gain * from[p];
}

/* Scratch of one thread. */
typedef struct worker {
    float *row;
    float *planes; /* [8][view * light]: product x, y, z, multiplier, target R, G, B, weight */
    double *sums;  /* [2][light] */
    enc_fit_workspace *fit;
} worker;

static void worker_clear(worker *w) {
    free(w->row);
    free(w->planes);
    free(w->sums);
    enc_fit_workspace_destroy(&w->fit);
}

static btf_result worker_init(const joint_rows *rows, worker *w) {
    const size_t lights = rows->row / 3;
    *w = (worker){.row = malloc(rows->row * sizeof(float)),
                  .planes = malloc(8 * rows->views * lights * sizeof(float)),
                  .sums = malloc(2 * lights * sizeof(double))};
    if (!w->row || !w->planes || !w->sums)
        return no_memory(rows);
    return enc_fit_workspace_create(rows->views * lights, &w->fit);
}

/* Means of one source from its sums, less the residual unless `alone`. */
static void finish_target(const batch *b, size_t source, bool alone) {
    const joint_model *model = b->model;
    const size_t row = model->row, k = model->k;
    const float *u = model->u + source * k;
    for (size_t view = 0; view < model->views; view++) {
        const size_t at = (source - b->first) * model->views + view;
        float *restrict target = b->target + at * row;
        if (!(b->weight[at] > 0.0f))
            continue;
        const float inverse = 1.0f / b->weight[at];
        for (size_t p = 0; p < row; p++)
            target[p] *= inverse;
        for (size_t j = 0; j < k && !alone; j++) {
            const float *restrict v = model->v + (view * k + j) * row, factor = u[j];
            for (size_t p = 0; p < row; p++)
                target[p] -= factor * v[p];
        }
    }
}

/* Weighted squared distance of the front to the targets of one source. */
static double source_error(const batch *b, const joint_front *front, size_t source, worker *w) {
    const size_t row = b->model->row, views = b->model->views;
    double error = 0.0;
    for (size_t view = 0; view < views; view++) {
        const size_t at = (source - b->first) * views + view;
        const float *target = b->target + at * row;
        if (!(b->weight[at] > 0.0f))
            continue;
        double sum = 0.0;
        joint_front_row(b->rows, front, source, view, w->row);
        for (size_t p = 0; p < row; p++)
            sum += (double)(target[p] - w->row[p]) * (target[p] - w->row[p]);
        error += b->weight[at] * sum;
    }
    return error;
}

/* The least-squares shadow of every light: sum of weight * target * model over sum of weight * model^2. */
static void solve_shadow(const batch *b, joint_front *front, size_t source, worker *w) {
    const size_t row = b->model->row, lights = row / 3, views = b->model->views;
    double *above = w->sums, *below = above + lights;
    memset(w->sums, 0, 2 * lights * sizeof *w->sums);
    for (size_t view = 0; view < views; view++) {
        const size_t at = (source - b->first) * views + view;
        const double weight = b->weight[at];
        if (!(weight > 0.0))
            continue;
        joint_front_row_lit(b->rows, front, source, view, w->row);
        for (size_t p = 0; p < row; p++) {
            above[p % lights] += weight * b->target[at * row + p] * w->row[p];
            below[p % lights] += weight * (double)w->row[p] * w->row[p];
        }
    }
    for (size_t l = 0; l < lights; l++)
        if (below[l] > 1e-12) {
            const double code = rint(above[l] / below[l] / front->shadow_scale);
            front->shadow[source * lights + l] = (uint8_t)(code > JOINT_SHADOW_MAX ? JOINT_SHADOW_MAX
                                                           : code > 0.0            ? code
                                                                                   : 0.0);
        }
}

/* A parameter as a half texture holds it. */
static float rounded_to_half(float value) {
    const uint16_t bits = enc_half_from_float(value);
    if (!(bits & 0x7fff))
        return 0.0f;
    const float magnitude = ldexpf((float)(1024 + (bits & 1023)), (bits >> 10 & 31) - 25);
    return bits & 0x8000 ? -magnitude : magnitude;
}

/* Fits the SBRDF of one source: from `starts` fixed starts, or from where it is when 0. */
static btf_result fit_sbrdf(const batch *b, const joint_front *front, size_t source, int starts,
                            worker *w) {
    const joint_rows *rows = b->rows;
    const size_t views = rows->views, lights = rows->row / 3, plane = views * lights;
    const size_t stride = enc_sbrdf_stride(front->kind.lobes, front->kind.rgb);
    float parameters[3 + 7 * ENC_MAX_LOBES + 4], *present = front->sbrdf->values + source * stride;
    float *planes[8];
    size_t n = 0;
    for (int i = 0; i < 8; i++)
        planes[i] = w->planes + (size_t)i * plane;
    for (size_t view = 0; view < views; view++) {
        const size_t at = (source - b->first) * views + view;
        for (size_t l = 0; l < lights && b->weight[at] > 0.0f; l++, n++) {
            for (int axis = 0; axis < 3; axis++) {
                planes[axis][n] = front->light[axis][l] * rows->data->views[view].xyz[axis];
                planes[4 + axis][n] = b->target[at * rows->row + (size_t)axis * lights + l];
            }
            planes[3][n] =
                rows->multiplier[l] *
                (front->shadow ? (float)front->shadow[source * lights + l] * front->shadow_scale : 1.0f);
            planes[7][n] = b->weight[at];
        }
    }
    if (n == 0)
        return BTF_OK;
    const enc_fit_samples samples = {
        n, {planes[0], planes[1], planes[2]}, planes[3], {planes[4], planes[5], planes[6]}, planes[7]};
    enc_fit_options options = enc_fit_options_default();
    enc_fit_result fitted;
    options.lobes = front->kind.lobes;
    options.rgb = front->kind.rgb;
    options.square_root = rows->root;
    options.max_evaluations = starts > 0 ? FIRST_EVALUATIONS : REFIT_EVALUATIONS;
    const btf_result result =
        enc_fit_texel(w->fit, &samples, &options, starts > 0 ? NULL : present, starts, parameters, &fitted);
    for (size_t i = 0; i < stride && result == BTF_OK; i++)
        present[i] = front->kind.half ? rounded_to_half(parameters[i]) : parameters[i];
    return result;
}

/* Keeps what a step made of a source only where that lowers its error. */
typedef struct keeper {
    float parameters[3 + 7 * ENC_MAX_LOBES + 4];
    uint8_t shadow[ENC_MAX_DIRECTIONS];
    double error;
} keeper;

static void keep(const batch *b, const joint_front *front, size_t source, worker *w, keeper *kept) {
    const size_t stride = enc_sbrdf_stride(front->kind.lobes, front->kind.rgb), lights = b->rows->row / 3;
    memcpy(kept->parameters, front->sbrdf->values + source * stride, stride * sizeof(float));
    if (front->shadow)
        memcpy(kept->shadow, front->shadow + source * lights, lights);
    kept->error = source_error(b, front, source, w);
}

static void keep_better(const batch *b, joint_front *front, size_t source, worker *w, const keeper *kept) {
    const size_t stride = enc_sbrdf_stride(front->kind.lobes, front->kind.rgb), lights = b->rows->row / 3;
    if (source_error(b, front, source, w) <= kept->error)
        return;
    memcpy(front->sbrdf->values + source * stride, kept->parameters, stride * sizeof(float));
    if (front->shadow)
        memcpy(front->shadow + source * lights, kept->shadow, lights);
}

static btf_result first_fit(const batch *b, joint_front *front, size_t source, int starts, worker *w) {
    btf_result result = fit_sbrdf(b, front, source, starts, w);
    if (result == BTF_OK && front->shadow) {
        keeper kept;
        solve_shadow(b, front, source, w);
        keep(b, front, source, w, &kept);
        result = fit_sbrdf(b, front, source, 0, w);
        solve_shadow(b, front, source, w);
        keep_better(b, front, source, w, &kept);
    }
    return result;
}

static btf_result refit(const batch *b, joint_front *front, size_t source, worker *w) {
    keeper kept;
    keep(b, front, source, w, &kept);
    if (front->shadow) {
        solve_shadow(b, front, source, w);
        keep_better(b, front, source, w, &kept);
        keep(b, front, source, w, &kept);
    }
    const btf_result result = fit_sbrdf(b, front, source, 0, w);
    if (front->shadow)
        solve_shadow(b, front, source, w);
    keep_better(b, front, source, w, &kept);
    return result;
}

/* Gathers and solves one batch. */
static btf_result solve_batch(const batch *b, joint_front *front, int starts) {
    btf_result result = joint_rows_pick(b->rows, refers, gather_row, (void *)b);
    if (result != BTF_OK)
        return result;
#pragma omp parallel num_threads(b->rows->context->threads)
    {
        worker w;
        btf_result mine = worker_init(b->rows, &w);
#pragma omp for schedule(dynamic, 8)
        for (size_t source = b->first; source < b->first + b->count; source++) {
            if (mine == BTF_OK && enc_cancelled(b->rows->context))
                mine = BTF_ERROR_INTERRUPTED;
            if (mine == BTF_OK) {
                finish_target(b, source, starts > 0);
                mine = starts > 0 ? first_fit(b, front, source, starts, &w) : refit(b, front, source, &w);
            }
        }
        worker_clear(&w);
        if (mine != BTF_OK) {
#pragma omp critical(joint_front)
            result = mine;
        }
    }
    return result;
}

/* The sources that the ranks have solved, to all. */
static btf_result share(const joint_rows *rows, joint_front *front, btf_result result) {
    const size_t stride = enc_sbrdf_stride(front->kind.lobes, front->kind.rgb);
    result =
        enc_ranks_gather(rows->context, result, front->sbrdf->values, stride * sizeof(float), rows->texels);
    if (front->shadow)
        result = enc_ranks_gather(rows->context, result, front->shadow, rows->row / 3, rows->texels);
    return result;
}

static btf_result solve_all(const joint_rows *rows, joint_model *model, int starts) {
    const size_t bytes = rows->views * (rows->row + 1) * sizeof(float);
    const size_t most = BATCH_BYTES / bytes > 0 ? BATCH_BYTES / bytes : 1;
    size_t first, end;
    enc_ranks_range(rows->context, rows->texels, &first, &end);
    const size_t size = most < end - first ? most : end - first;
    batch b = {.rows = rows,
               .model = model,
               .target = malloc((size * rows->views * rows->row + 1) * sizeof(float)),
               .weight = malloc((size * rows->views + 1) * sizeof(float))};
    btf_result result = b.target && b.weight ? BTF_OK : no_memory(rows);
    for (b.first = first; b.first < end && result == BTF_OK; b.first += size) {
        b.count = end - b.first < size ? end - b.first : size;
        memset(b.target, 0, b.count * rows->views * rows->row * sizeof(float));
        memset(b.weight, 0, b.count * rows->views * sizeof(float));
        result = solve_batch(&b, model->front, starts);
    }
    free(b.target);
    free(b.weight);
    return share(rows, model->front, result);
}

btf_result joint_front_fit(const joint_rows *rows, joint_model *model, int starts) {
    return solve_all(rows, model, starts);
}

btf_result joint_front_refit(const joint_rows *rows, joint_model *model) {
    return solve_all(rows, model, 0);
}

/* The SBRDF of one texel for itself, and what it leaves. */
static btf_result probe_one(const batch *b, joint_front *front, int starts, worker *w, float *texel,
                            double *out_error) {
    btf_result result = BTF_OK;
    for (size_t view = 0; view < b->rows->views && result == BTF_OK; view++) {
        b->weight[view] = 1.0f;
        result = joint_rows_one(b->rows, b->first, view, texel, b->target + view * b->rows->row);
    }
    if (result == BTF_OK)
        result = fit_sbrdf(b, front, b->first, starts, w);
    if (result == BTF_OK)
        *out_error = source_error(b, front, b->first, w);
    return result;
}

btf_result joint_front_probe(const joint_rows *rows, const joint_front_kind *kind, int starts, size_t count,
                             double *out_error) {
    const size_t texel = rows->views * rows->row;
    const joint_model model = {.texels = rows->texels, .views = rows->views, .row = rows->row};
    joint_front *front = NULL;
    count = count < rows->texels ? count : rows->texels;
    size_t begin, end;
    enc_ranks_range(rows->context, count, &begin, &end);
    double *errors = calloc(count, sizeof *errors);
    btf_result result = errors ? joint_front_create(rows, kind, &front) : no_memory(rows);
#pragma omp parallel num_threads(rows->context->threads)
    {
        worker w = {0};
        batch b = {.rows = rows,
                   .model = &model,
                   .count = 1,
                   .target = malloc(texel * sizeof(float)),
                   .weight = malloc(rows->views * sizeof(float))};
        float *buffer = malloc(texel * sizeof *buffer);
        btf_result mine = result;
        if (mine == BTF_OK)
            mine = worker_init(rows, &w);
        if (mine == BTF_OK && (!b.target || !b.weight || !buffer))
            mine = no_memory(rows);
#pragma omp for schedule(dynamic)
        for (size_t i = begin; i < end; i++) {
            b.first = i * rows->texels / count;
            if (mine == BTF_OK)
                mine = probe_one(&b, front, starts, &w, buffer, &errors[i]);
        }
        worker_clear(&w);
        free(b.target);
        free(b.weight);
        free(buffer);
        if (mine != BTF_OK) {
#pragma omp critical(joint_front)
            result = mine;
        }
    }
    result = enc_ranks_gather(rows->context, result, errors, sizeof *errors, count);
    *out_error = 0.0;
    for (size_t i = 0; i < count && result == BTF_OK; i++)
        *out_error += errors[i] / ((double)count * (double)texel);
    joint_front_destroy(&front);
    free(errors);
    return result;
}
