/* Projections of the data. See projection.h.
 *
 * Without a front, sources lie in the span of v, and everything is decided within a basis of it. A front
 * adds to each source what lies outside: the basis then also spans the directions in which fronts differ
 * most, and one coordinate more is the length of the rest, so that norms are exact.
 *
 * SPDX-License-Identifier: MIT
 */
#include "projection.h"

#include "encoder/base/ranks.h"
#include "encoder/base/scratch.h"
#include "encoder/math/gemm.h"
#include "encoder/math/linear.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct joint_coordinates {
    size_t floats, first; /* first: of the views held */
    float *values;        /* [view - first][floats]; with a scratch file [floats], of the view read last */
    int scratch;          /* -1: all in memory */
};

btf_result joint_coordinates_create(const enc_context *context, size_t views, size_t floats,
                                    joint_coordinates **out_points) {
    size_t first, end;
    enc_ranks_range(context, views, &first, &end);
    views = end - first;
    const uint64_t bytes = (uint64_t)views * floats * sizeof(float);
    const bool in_memory = context->memory == 0 || bytes <= context->memory / 4;
    joint_coordinates *points = malloc(sizeof *points);
    *out_points = points;
    if (!points)
        return BTF_ERROR_MEMORY;
    *points = (joint_coordinates){floats, first, enc_gemm_alloc(in_memory ? views * floats : floats), -1};
    btf_result result = points->values ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK && !in_memory)
        result = enc_scratch_open(context, "joint: projection", bytes, &points->scratch);
    if (result != BTF_OK)
        joint_coordinates_destroy(out_points);
    return result;
}

void joint_coordinates_destroy(joint_coordinates **points) {
    if (!*points)
        return;
    if ((*points)->scratch >= 0)
        close((*points)->scratch);
    free((*points)->values);
    free(*points);
    *points = NULL;
}

btf_result joint_coordinates_store(const enc_context *context, joint_coordinates *points, size_t view,
                                   size_t at, size_t count, const float *values) {
    const size_t first = (view - points->first) * points->floats + at;
    if (points->scratch >= 0)
        return enc_scratch_write(context, points->scratch, (uint64_t)first * sizeof(float),
                                 count * sizeof(float), values);
    memcpy(points->values + first, values, count * sizeof(float));
    return BTF_OK;
}

btf_result joint_coordinates_view(const enc_context *context, joint_coordinates *points, size_t view,
                                  const float **out_values) {
    const size_t first = (view - points->first) * points->floats;
    *out_values = points->values + (points->scratch < 0 ? first : 0);
    if (points->scratch < 0)
        return BTF_OK;
    return enc_scratch_read(context, points->scratch, (uint64_t)first * sizeof(float),
                            points->floats * sizeof(float), points->values);
}

static btf_result out_of_memory(const joint_rows *rows, size_t k) {
    return enc_fail(rows->context, BTF_ERROR_MEMORY,
                    "joint: out of memory for %zu dimensions of %zu points", k, rows->texels * rows->views);
}

/* Basis vectors for fronts. */
static size_t front_dims(const joint_rows *rows, const joint_model *model) {
    const size_t wanted = !model->front ? 0 : model->k > 0 ? JOINT_FRONT_DIMS : JOINT_FRONT_ALONE_DIMS;
    return model->k + wanted <= rows->row ? wanted : model->k < rows->row ? rows->row - model->k : 0;
}

btf_result joint_projection_init(const joint_rows *rows, const joint_model *model,
                                 joint_projection *out_projection) {
    const size_t k = model->k, dims = k + front_dims(rows, model) + (model->front ? 1 : 0);
    *out_projection = (joint_projection){.dims = dims,
                                         .basis = enc_gemm_alloc(rows->views * dims * rows->row),
                                         .lower = enc_gemm_alloc(rows->views * k * k)};
    btf_result result = out_projection->basis && out_projection->lower ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK)
        result =
            joint_coordinates_create(rows->context, rows->views, rows->texels * dims, &out_projection->c);
    return result == BTF_ERROR_MEMORY ? out_of_memory(rows, dims) : result;
}

void joint_projection_clear(joint_projection *projection) {
    free(projection->basis);
    free(projection->lower);
    joint_coordinates_destroy(&projection->c);
    *projection = (joint_projection){0};
}

/* The basis of one view: v first, then what a power step from a few fronts over a sample of them leaves
 * beyond v: directions in which fronts are large. The last vector is zero. */
static bool front_basis(const joint_rows *rows, const joint_model *model, size_t view, float *basis,
                        float *lower) {
    const size_t k = model->k, row = rows->row, extra = front_dims(rows, model), spanned = k + extra;
    const size_t count = rows->texels < JOINT_FRONT_SAMPLES ? rows->texels : JOINT_FRONT_SAMPLES;
    float *fronts = malloc((count + spanned) * row * sizeof *fronts), *vectors = fronts + count * row;
    float *factors = malloc((spanned * spanned + 1) * sizeof *factors);
    bool ok = fronts && factors;
    for (size_t i = 0; i < count && ok; i++)
        joint_front_row(rows, model->front, i * rows->texels / count, view, fronts + i * row);
    if (ok)
        memcpy(vectors, model->v + view * k * row, k * row * sizeof(float));
    for (size_t j = 0; j < extra && ok; j++) {
        const float *restrict direction = fronts + j * count / extra * row;
        float *restrict sum = vectors + (k + j) * row;
        memset(sum, 0, row * sizeof *sum);
        for (size_t i = 0; i < count; i++) {
            const float *restrict front = fronts + i * row;
            float dot = 0.0f;
            for (size_t p = 0; p < row; p++)
                dot += direction[p] * front[p];
            for (size_t p = 0; p < row; p++)
                sum[p] += dot * front[p];
        }
    }
    ok = ok && enc_orthonormal_rows(spanned, row, vectors, basis, factors);
    for (size_t i = 0; i < k && ok; i++)
        memcpy(lower + i * k, factors + i * spanned, k * sizeof(float));
    memset(basis + spanned * row, 0, row * sizeof *basis);
    free(fronts);
    free(factors);
    return ok;
}

/* The data of a projection pass. */
typedef struct project_pass {
    const joint_rows *rows;
    joint_projection *projection;
    size_t packed_pitch;
    float *packed;  /* [view] packed basis */
    float *scratch; /* [thread] packed rows, then coordinates */
    size_t scratch_pitch;
    btf_result result; /* of storing */
} project_pass;

static void project_block(void *user, size_t view, size_t first, size_t count, const float *block) {
    project_pass *pass = user;
    const size_t row = pass->rows->row, dims = pass->projection->dims;
    float *left = pass->scratch + enc_thread_index() * pass->scratch_pitch, *c = left + JOINT_BLOCK * row;
    enc_gemm_pack_rows(count, row, block, row, ENC_GEMM_M, left);
    enc_gemm_multiply(pass->rows->tile, count, dims, row, left, pass->packed + view * pass->packed_pitch, c,
                      dims, 0);
    const btf_result result = joint_coordinates_store(pass->rows->context, pass->projection->c, view,
                                                      first * dims, count * dims, c);
    if (result != BTF_OK) {
#pragma omp atomic write
        pass->result = result;
    }
}

btf_result joint_project(const joint_rows *rows, const joint_model *model, joint_projection *projection) {
    const size_t k = model->k, row = rows->row, dims = projection->dims;
    const size_t threads = (size_t)rows->context->threads;
    project_pass pass = {.rows = rows,
                         .projection = projection,
                         .packed_pitch = enc_gemm_panels(dims, ENC_GEMM_N) * ENC_GEMM_N * row,
                         .scratch_pitch = JOINT_BLOCK * (row + dims)};
    pass.packed = enc_gemm_alloc(rows->views * pass.packed_pitch);
    pass.scratch = enc_gemm_alloc(threads * pass.scratch_pitch);
    btf_result result = BTF_OK;
    size_t begin, end;
    joint_rows_views(rows, &begin, &end);
    bool ok = pass.packed && pass.scratch;
    if (ok)
#pragma omp parallel for schedule(dynamic) num_threads(rows->context->threads)
        for (size_t view = begin; view < end; view++) {
            float *basis = projection->basis + view * dims * row, *lower = projection->lower + view * k * k;
            const bool made = model->front
                                  ? front_basis(rows, model, view, basis, lower)
                                  : enc_orthonormal_rows(k, row, model->v + view * k * row, basis, lower);
            if (!made) {
#pragma omp atomic write
                ok = false;
            }
            enc_gemm_pack_rows(dims, row, basis, row, ENC_GEMM_N, pass.packed + view * pass.packed_pitch);
        }
    result = ok ? joint_rows_pass(rows, project_block, &pass) : out_of_memory(rows, dims);
    if (result == BTF_OK)
        result = pass.result;
    free(pass.packed);
    free(pass.scratch);
    return result;
}
