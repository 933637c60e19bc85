/* The choice of sources. See choose.h.
 *
 * Without a front the basis of the projection holds all that a source is. With one, the inner product of a
 * point with what its source has beyond the basis is missing: it is made up for the winner and the present
 * choice in a pass over the data, which decides between them.
 *
 * SPDX-License-Identifier: MIT
 */
#include "choose.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

static btf_result out_of_memory(const joint_rows *rows, size_t k) {
    return enc_fail(rows->context, BTF_ERROR_MEMORY,
                    "joint: out of memory for %zu dimensions of %zu points", k, rows->texels * rows->views);
}
/* One candidate of a point: the source, its squared norm, and the inner product of the point with the
 * source's residual. */
typedef struct candidate {
    uint32_t source;
    float norm, dot;
} candidate;

/* The data and the scratch memory of a choice. */
typedef struct chooser {
    const joint_rows *rows;
    const joint_projection *projection;
    joint_model *model;
    joint_search search;
    float *z;              /* [texel][dims] sources of one view */
    float *residual;       /* [texel][k] what the residual contributes to z; with a front */
    float *packed_lower;   /* [k][k] */
    float *packed_basis;   /* [dims][row]; with a front */
    float *scratch;        /* [thread] */
    size_t scratch_pitch;  /* its floats */
    double *value;         /* [texel] of one view */
    uint8_t *hidden;       /* [texel] of one view: the point's gain is 0 */
    candidate *candidates; /* [view][texel][2]: the present choice and the search's; with a front */
    double *errors;        /* [view] */
} chooser;

static void chooser_clear(chooser *c) {
    free(c->z);
    free(c->residual);
    free(c->packed_lower);
    free(c->packed_basis);
    free(c->scratch);
    free(c->value);
    free(c->hidden);
    free(c->candidates);
    free(c->errors);
}

static btf_result chooser_init(const joint_rows *rows, const joint_projection *projection,
                               joint_model *model, double tolerance, chooser *c) {
    const size_t k = model->k, dims = projection->dims, texels = rows->texels, row = rows->row;
    const size_t threads = (size_t)rows->context->threads;
    const bool front = model->front;
    *c = (chooser){.rows = rows,
                   .projection = projection,
                   .model = model,
                   .search = {.width = rows->data->width,
                              .height = rows->data->height,
                              .k = dims,
                              .gains = model->gains,
                              .sources = JOINT_GRID_SOURCES,
                              .window = JOINT_WINDOW,
                              .phase = model->searches,
                              .tolerance = tolerance,
                              .tile = rows->tile,
                              .threads = rows->context->threads},
                   .z = enc_gemm_alloc(texels * dims),
                   .packed_lower = enc_gemm_alloc(enc_gemm_panels(k, ENC_GEMM_N) * ENC_GEMM_N * k),
                   .scratch_pitch = JOINT_BLOCK * (k + (front ? 2 * row + dims : 0)),
                   .value = malloc(texels * sizeof *c->value),
                   .hidden = malloc(texels)};
    c->scratch = enc_gemm_alloc(threads * c->scratch_pitch);
    if (front) {
        c->residual = enc_gemm_alloc(texels * k);
        c->packed_basis = enc_gemm_alloc(enc_gemm_panels(dims, ENC_GEMM_N) * ENC_GEMM_N * row);
        c->candidates = malloc(2 * rows->views * texels * sizeof *c->candidates);
    }
    c->errors = calloc(rows->views, sizeof *c->errors);
    const bool ok = c->z && c->packed_lower && c->value && c->hidden && c->scratch && c->errors &&
                    (!front || (c->residual && c->packed_basis && c->candidates));
    return ok ? BTF_OK : out_of_memory(rows, dims);
}

/* z[texel] += the front in the basis, for `count` texels; the last coordinate becomes the length of the
 * rest. scratch: JOINT_BLOCK * (2 * row + dims) floats. */
static void add_fronts(const chooser *c, size_t view, size_t first, size_t count, float *scratch) {
    const size_t row = c->rows->row, dims = c->projection->dims;
    float *fronts = scratch, *packed = fronts + JOINT_BLOCK * row, *within = packed + JOINT_BLOCK * row;
    for (size_t i = 0; i < count; i++)
        joint_front_row(c->rows, c->model->front, first + i, view, fronts + i * row);
    enc_gemm_pack_rows(count, row, fronts, row, ENC_GEMM_M, packed);
    enc_gemm_multiply(c->rows->tile, count, dims, row, packed, c->packed_basis, within, dims, 0);
    for (size_t i = 0; i < count; i++) {
        float *z = c->z + (first + i) * dims;
        double rest = 0.0;
        for (size_t p = 0; p < row; p++)
            rest += (double)fronts[i * row + p] * fronts[i * row + p];
        for (size_t j = 0; j + 1 < dims; j++) {
            rest -= (double)within[i * dims + j] * within[i * dims + j];
            z[j] += within[i * dims + j];
        }
        z[dims - 1] = rest > 0.0 ? (float)sqrt(rest) : 0.0f;
    }
}

/* z: the sources of one view in the basis of its projection. */
static void sources_of_view(const chooser *c, size_t view) {
    const size_t k = c->model->k, dims = c->projection->dims, texels = c->rows->texels, row = c->rows->row;
    enc_gemm_pack_columns(k, k, c->projection->lower + view * k * k, k, ENC_GEMM_N, c->packed_lower);
    if (c->model->front)
        enc_gemm_pack_rows(dims, row, c->projection->basis + view * dims * row, row, ENC_GEMM_N,
                           c->packed_basis);
#pragma omp parallel for num_threads(c->rows->context->threads)
    for (size_t first = 0; first < texels; first += JOINT_BLOCK) {
        const size_t count = texels - first < JOINT_BLOCK ? texels - first : JOINT_BLOCK;
        float *left = c->scratch + enc_thread_index() * c->scratch_pitch;
        float *z = c->z + first * dims;
        enc_gemm_pack_rows(count, k, c->model->u + first * k, k, ENC_GEMM_M, left);
        if (!c->model->front) {
            enc_gemm_multiply(c->rows->tile, count, k, k, left, c->packed_lower, z, dims, 0);
            continue;
        }
        float *residual = c->residual + first * k;
        enc_gemm_multiply(c->rows->tile, count, k, k, left, c->packed_lower, residual, k, 0);
        for (size_t i = 0; i < count; i++) {
            memset(z + i * dims, 0, dims * sizeof *z);
            memcpy(z + i * dims, residual + i * k, k * sizeof *z);
        }
        add_fronts(c, view, first, count, left + JOINT_BLOCK * k);
    }
}

/* point: the coordinates of what may choose it. */
static candidate make_candidate(const chooser *c, const float *point, uint32_t source) {
    const size_t k = c->model->k, dims = c->projection->dims;
    const float *z = c->z + source * dims, *residual = c->residual + source * k;
    double norm = 0.0, dot = 0.0;
    for (size_t j = 0; j < dims; j++)
        norm += (double)z[j] * z[j];
    for (size_t j = 0; j < k; j++)
        dot += (double)point[j] * residual[j];
    return (candidate){source, (float)norm, (float)dot};
}

/* Chooses within the basis, for one view. With a front both choices are kept for `decide`. */
static btf_result choose_view(chooser *c, size_t view, bool search) {
    const size_t texels = c->rows->texels, first = view * texels, dims = c->projection->dims;
    uint32_t *match = c->model->match + first;
    uint8_t *gain = c->model->gain + first;
    const float *points;
    candidate *candidates = c->candidates ? c->candidates + 2 * first : NULL;
    btf_result result = joint_coordinates_view(c->rows->context, c->projection->c, view, &points);
    if (result != BTF_OK)
        return result;
    sources_of_view(c, view);
    for (size_t x = 0; x < texels; x++)
        c->hidden[x] = gain[x] == 0;
#pragma omp parallel for num_threads(c->rows->context->threads)
    for (size_t x = 0; x < texels; x++)
        if (candidates)
            candidates[2 * x] = candidates[2 * x + 1] = make_candidate(c, points + x * dims, match[x]);
    if (search && c->model->shift)
        result =
            joint_search_view(&c->search, points, c->rows->energy + first, c->z, match, gain, c->value);
    else if (!candidates)
        joint_search_gains(&c->search, points, c->z, match, gain, c->value);
#pragma omp parallel for num_threads(c->rows->context->threads)
    for (size_t x = 0; x < texels; x++) {
        if (candidates && match[x] != candidates[2 * x].source)
            candidates[2 * x + 1] = make_candidate(c, points + x * dims, match[x]);
        if (c->hidden[x])
            gain[x] = 0;
    }
    return result == BTF_OK ? BTF_OK : out_of_memory(c->rows, dims);
}

/* Sum of squares that a hidden point leaves under its centre. */
static double hidden_error(const joint_model *model, size_t point) {
    return model->centre_error[point];
}

/* The true inner products decide between the two candidates of a point. */
static void decide(void *user, size_t view, size_t first, size_t count, const float *block) {
    const chooser *c = user;
    joint_model *model = c->model;
    const size_t row = c->rows->row;
    float front[3 * ENC_MAX_DIRECTIONS];
    for (size_t i = 0; i < count; i++) {
        const size_t point = view * c->rows->texels + first + i;
        const candidate *candidates = c->candidates + 2 * point;
        const float *y = block + i * row;
        double best = -HUGE_VAL;
        if (model->gain[point] == 0) {
            c->errors[view] += hidden_error(model, point);
            if (model->point_error)
                model->point_error[point] = (float)hidden_error(model, point);
            model->match[point] = candidates[0].source;
            continue;
        }
        for (int j = 0; j < 2; j++) {
            double dot = candidates[j].dot, value;
            if (j > 0 && candidates[j].source == candidates[0].source)
                break;
            joint_front_row(c->rows, model->front, candidates[j].source, view, front);
            for (size_t p = 0; p < row; p++)
                dot += (double)front[p] * y[p];
            const int code = joint_best_gain(&model->gains, dot, candidates[j].norm, &value);
            if (value > best) {
                best = value;
                model->match[point] = candidates[j].source;
                model->gain[point] = (uint8_t)code;
            }
        }
        if (model->point_error)
            model->point_error[point] = (float)(c->rows->energy[point] - best);
        c->errors[view] += c->rows->energy[point] - best;
    }
}

/* Adds the error that a view's choices within the basis leave. */
static void add_errors(chooser *c, size_t view) {
    const joint_rows *rows = c->rows;
    joint_model *model = c->model;
    for (size_t x = 0; x < rows->texels; x++) {
        const size_t point = view * rows->texels + x;
        const double left = c->hidden[x] ? hidden_error(model, point) : rows->energy[point] - c->value[x];
        if (model->point_error)
            model->point_error[point] = (float)left;
        c->errors[view] += left;
    }
}

/* Hands all ranks the choices that each has made for its views. Without a search the sources are as they
 * were. */
static btf_result share(const chooser *c, bool search, btf_result result) {
    const joint_rows *rows = c->rows;
    joint_model *model = c->model;
    result = joint_rows_gather(rows, result, c->errors, sizeof *c->errors);
    result = joint_rows_gather(rows, result, model->gain, rows->texels);
    if (search && model->shift)
        result = joint_rows_gather(rows, result, model->match, rows->texels * sizeof *model->match);
    if (model->point_error)
        result = joint_rows_gather(rows, result, model->point_error, rows->texels * sizeof(float));
    return result;
}

btf_result joint_choose(const joint_rows *rows, const joint_projection *projection, bool search,
                        double tolerance, joint_model *model, double *out_error) {
    chooser c;
    size_t begin, end;
    btf_result result = chooser_init(rows, projection, model, tolerance, &c);
    joint_rows_views(rows, &begin, &end);
    for (size_t view = begin; view < end && result == BTF_OK; view++) {
        if (enc_cancelled(rows->context)) {
            result = BTF_ERROR_INTERRUPTED;
            break;
        }
        result = choose_view(&c, view, search);
        if (result == BTF_OK && !model->front)
            add_errors(&c, view);
    }
    if (model->front && result == BTF_OK)
        result = joint_rows_pass(rows, decide, &c);
    result = share(&c, search, result);
    *out_error = 0.0;
    for (size_t view = 0; view < rows->views && result == BTF_OK; view++)
        *out_error += c.errors[view];
    model->searches += search;
    chooser_clear(&c);
    return result;
}
