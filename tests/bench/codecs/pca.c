/* Factorisation of the BTF matrix. See pca.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "pca.h"

#include "encoder/math/gemm.h"
#include "encoder/math/linear.h"
#include "encoder/math/srgb.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    BLOCK = 96,      /* texels that a product handles at a time */
    OVERSAMPLE = 10, /* extra columns of the random subspace */
    POWER_STEPS = 3,
    GRAM_ROWS = 16,  /* rows of a Gram matrix that one thread does at a time */
    SOLVE_ROWS = 32, /* rows that are orthogonalised at a time */
};

static btf_result no_memory(const enc_context *context, size_t rank) {
    return enc_fail(context, BTF_ERROR_MEMORY, "pca: out of memory for %zu components", rank);
}

const float pca_axes[3][3] = {{0.57735027f, 0.57735027f, 0.57735027f},
                              {0.70710678f, 0, -0.70710678f},
                              {0.40824829f, -0.81649658f, 0.40824829f}};

static float encode_value(pca_coding coding, float value) {
    const float x = value < 1 ? value : 1.0f;
    return coding == PCA_LINEAR ? x : coding == PCA_SQRT ? sqrtf(x) : enc_srgb_encode(x);
}

void pca_encode_samples(const enc_data *data, pca_coding coding, pca_plane plane, const float *samples,
                        float *out) {
    const size_t lights = (size_t)data->n_lights, views = (size_t)data->n_views;
    if (plane == PCA_RGB) {
        for (size_t i = 0; i < 3 * views * lights; i++) {
            out[i] = encode_value(coding, samples[i]);
        }
        return;
    }
    const float *axis = pca_axes[plane];
    for (size_t view = 0; view < views; view++) {
        const float *channel = samples + view * 3 * lights;
        for (size_t light = 0; light < lights; light++) {
            out[view * lights + light] = axis[0] * encode_value(coding, channel[light]) +
                                         axis[1] * encode_value(coding, channel[lights + light]) +
                                         axis[2] * encode_value(coding, channel[2 * lights + light]);
        }
    }
}

/* The coded data, read block by block, and the products of a subspace iteration. */
typedef struct matrix {
    const enc_context *context;
    const enc_data *data;
    const uint32_t *list;
    pca_coding coding;
    pca_plane plane;
    size_t texels, columns, width; /* width of the subspace */
    enc_gemm_tile tile;
    float *buffer, *block, *packed_block, *packed_small, *packed_large;
} matrix;

static void matrix_clear(matrix *m) {
    free(m->buffer);
    free(m->block);
    free(m->packed_block);
    free(m->packed_small);
    free(m->packed_large);
}

static bool matrix_init(matrix *m) {
    const size_t lanes = enc_gemm_panels(m->width, ENC_GEMM_N) * ENC_GEMM_N;
    m->buffer = enc_gemm_alloc(m->data->samples ? 1 : BLOCK * enc_data_texel_stride(m->data));
    m->block = enc_gemm_alloc(BLOCK * m->columns);
    m->packed_block = enc_gemm_alloc(BLOCK * (m->columns + ENC_GEMM_M));
    m->packed_small = enc_gemm_alloc(BLOCK * lanes);
    m->packed_large = enc_gemm_alloc(lanes * m->columns);
    return m->buffer && m->block && m->packed_block && m->packed_small && m->packed_large;
}

static btf_result matrix_load(matrix *m, size_t first, size_t *out_count) {
    const size_t count = m->texels - first < BLOCK ? m->texels - first : BLOCK;
    btf_result result = enc_cancelled(m->context) ? BTF_ERROR_INTERRUPTED : BTF_OK;
    *out_count = count;
#pragma omp parallel for num_threads(m->context->threads)
    for (size_t i = 0; i < count; i++) {
        const size_t texel = m->list ? m->list[first + i] : first + i;
        float *buffer = m->buffer + (m->data->samples ? 0 : i * enc_data_texel_stride(m->data));
        const float *samples;
        const btf_result got = enc_data_texels(m->context, m->data, texel, 1, buffer, &samples);
        if (got == BTF_OK) {
            pca_encode_samples(m->data, m->coding, m->plane, samples, m->block + i * m->columns);
        } else {
            enc_keep_worse(&result, got);
        }
    }
    return result;
}

/* y [texel][width] = data * z, z [column][width]. */
static btf_result times(matrix *m, const float *z, float *y) {
    enc_gemm_pack_columns(m->width, m->columns, z, m->width, ENC_GEMM_N, m->packed_large);
    for (size_t first = 0; first < m->texels; first += BLOCK) {
        size_t count;
        const btf_result result = matrix_load(m, first, &count);
        if (result != BTF_OK) {
            return result;
        }
        const size_t panels = enc_gemm_panels(m->width, ENC_GEMM_N);
        enc_gemm_pack_rows(count, m->columns, m->block, m->columns, ENC_GEMM_M, m->packed_block);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads)
        for (size_t j = 0; j < panels; j++) {
            const size_t at = j * ENC_GEMM_N,
                         lanes = m->width - at < ENC_GEMM_N ? m->width - at : ENC_GEMM_N;
            enc_gemm_multiply(m->tile, count, lanes, m->columns, m->packed_block,
                              m->packed_large + at * m->columns, y + first * m->width + at, m->width, 0);
        }
    }
    return BTF_OK;
}

/* z [column][width] = data^T * y. */
static btf_result transposed_times(matrix *m, const float *y, float *z) {
    memset(z, 0, m->columns * m->width * sizeof *z);
    for (size_t first = 0; first < m->texels; first += BLOCK) {
        size_t count;
        const btf_result result = matrix_load(m, first, &count);
        if (result != BTF_OK) {
            return result;
        }
        enc_gemm_pack_columns(m->width, count, y + first * m->width, m->width, ENC_GEMM_N, m->packed_small);
#pragma omp parallel for num_threads(m->context->threads)
        for (size_t j = 0; j < m->columns; j += ENC_GEMM_M) {
            const size_t rows = m->columns - j < ENC_GEMM_M ? m->columns - j : ENC_GEMM_M;
            enc_gemm_pack_columns(rows, count, m->block + j, m->columns, ENC_GEMM_M,
                                  m->packed_block + j * BLOCK);
            enc_gemm_multiply(m->tile, rows, m->width, count, m->packed_block + j * BLOCK, m->packed_small,
                              z + j * m->width, m->width, 1);
        }
    }
    return BTF_OK;
}

/* a [n][n] = x^T x of x [rows][n], summed in the order of rows. */
static void gram(int threads, size_t rows, size_t n, const float *x, double *a) {
    memset(a, 0, n * n * sizeof *a);
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (size_t first = 0; first < n; first += GRAM_ROWS) {
        const size_t end = first + GRAM_ROWS < n ? first + GRAM_ROWS : n;
        for (size_t i = 0; i < rows; i++) {
            for (size_t p = first; p < end; p++) {
                const double factor = x[i * n + p];
                for (size_t q = 0; q <= p; q++) {
                    a[p * n + q] += factor * x[i * n + q];
                }
            }
        }
    }
    for (size_t p = 0; p < n; p++) {
        for (size_t q = p + 1; q < n; q++) {
            a[p * n + q] = a[q * n + p];
        }
    }
}

/* Orthonormal columns of y [rows][n], by two rounds of Cholesky QR; a [n][n] and x [threads][n][SOLVE_ROWS]
 * are scratch. */
static void orthonormalise(int threads, size_t rows, size_t n, float *y, double *a, double *x) {
    for (int round = 0; round < 2; round++) {
        double trace = 0;
        gram(threads, rows, n, y, a);
        for (size_t p = 0; p < n; p++) {
            trace += a[p * n + p];
        }
        for (size_t p = 0; p < n; p++) {
            a[p * n + p] += 1e-11 * trace + 1e-30;
        }
        const bool solved = enc_cholesky(n, a);
        assert(solved); /* a Gram matrix plus a positive diagonal is positive definite */
        (void)solved;
#pragma omp parallel for num_threads(threads)
        for (size_t first = 0; first < rows; first += SOLVE_ROWS) {
            const size_t count = rows - first < SOLVE_ROWS ? rows - first : SOLVE_ROWS;
            double *column = x + enc_thread_index() * n * SOLVE_ROWS;
            for (size_t i = 0; i < count; i++) {
                for (size_t p = 0; p < n; p++) {
                    column[p * count + i] = y[(first + i) * n + p];
                }
            }
            enc_lower_solve(n, a, column, count);
            for (size_t i = 0; i < count; i++) {
                for (size_t p = 0; p < n; p++) {
                    y[(first + i) * n + p] = (float)column[p * count + i];
                }
            }
        }
    }
}

/* Makes u and v of y (orthonormal) and z = data^T y, by rotating both with the eigenvectors of z^T z. Scratch: a
 * [2][n][n], values [n]. */
static bool finish(const matrix *m, const float *y, const float *z, double *a, double *values,
                   pca_factors *f) {
    const size_t n = m->width, rank = f->rank;
    double *vectors = a + n * n;
    float *turn = malloc(rank * n * sizeof *turn);
    float *left = enc_gemm_alloc((rank + ENC_GEMM_M) * n);
    float *right = enc_gemm_alloc((size_t)m->context->threads * ENC_GEMM_N * n);
    const bool room = turn && left && right;
    if (room) {
        gram(m->context->threads, m->columns, n, z, a);
        enc_eigen(n, a, values, vectors);
        for (size_t j = 0; j < rank; j++) {
            values[j] = values[j] > 0 ? sqrt(values[j]) : 0;
            for (size_t p = 0; p < n; p++) {
                turn[j * n + p] = values[j] > 0 ? (float)(vectors[j * n + p] / values[j]) : 0.0f;
            }
        }
        enc_gemm_pack_rows(rank, n, turn, n, ENC_GEMM_M, left);
#pragma omp parallel for num_threads(m->context->threads)
        for (size_t i = 0; i < m->columns; i += ENC_GEMM_N) {
            const size_t count = m->columns - i < ENC_GEMM_N ? m->columns - i : ENC_GEMM_N;
            float *panel = right + enc_thread_index() * ENC_GEMM_N * n;
            enc_gemm_pack_rows(count, n, z + i * n, n, ENC_GEMM_N, panel);
            enc_gemm_multiply(m->tile, rank, count, n, left, panel, f->v + i, m->columns, 0);
        }
#pragma omp parallel for num_threads(m->context->threads)
        for (size_t i = 0; i < m->texels; i++) {
            for (size_t j = 0; j < rank; j++) {
                double sum = 0;
                for (size_t p = 0; p < n; p++) {
                    sum += y[i * n + p] * vectors[j * n + p];
                }
                f->u[i * rank + j] = (float)(sum * values[j]);
            }
        }
    }
    free(turn);
    free(left);
    free(right);
    return room;
}

/* Uniform in [-0.5, 0.5): xorshift64*, Vigna 2016. */
static void fill_random(size_t count, float *out) {
    uint64_t state = 88172645463325252u;
    for (size_t i = 0; i < count; i++) {
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        out[i] = (float)((double)((state * 2685821657736338717u) >> 40) * 0x1p-24 - 0.5);
    }
}

/* Factorises the texels of `list` (NULL: all) on the columns of `plane`. */
static btf_result factorise(const enc_context *context, const enc_data *data, const uint32_t *list,
                            size_t count, pca_plane plane, pca_coding coding, size_t rank,
                            pca_factors *out_factors) {
    const size_t texels = list ? count : enc_data_texel_count(data),
                 columns = enc_data_texel_stride(data) / (plane == PCA_RGB ? 1 : 3);
    const size_t most = texels < columns ? texels : columns;
    const int threads = context->threads;
    rank = rank < most ? rank : most;
    const size_t width = rank + OVERSAMPLE < most ? rank + OVERSAMPLE : most;
    matrix m = {.context = context,
                .data = data,
                .list = list,
                .coding = coding,
                .plane = plane,
                .texels = texels,
                .columns = columns,
                .width = width,
                .tile = enc_gemm_select()};
    *out_factors = (pca_factors){data, coding, plane, texels, columns, rank, NULL, NULL};
    float *y = enc_gemm_alloc(texels * width), *z = enc_gemm_alloc(columns * width);
    double *a = malloc((2 * width + 1 + SOLVE_ROWS * (size_t)threads) * width * sizeof *a);
    double *values = a + 2 * width * width, *x = values + width;
    out_factors->u = malloc((texels * rank + 1) * sizeof(float));
    out_factors->v = malloc((rank * columns + 1) * sizeof(float));
    const bool room = matrix_init(&m) && y && z && a && out_factors->u && out_factors->v;
    btf_result result = room ? BTF_OK : no_memory(context, rank);
    if (room) {
        fill_random(texels * width, y);
    }
    for (int step = 0; step < POWER_STEPS && result == BTF_OK; step++) {
        orthonormalise(threads, texels, width, y, a, x);
        result = transposed_times(&m, y, z);
        if (result == BTF_OK) {
            result = times(&m, z, y);
        }
    }
    if (result == BTF_OK) {
        orthonormalise(threads, texels, width, y, a, x);
        result = transposed_times(&m, y, z);
    }
    if (result == BTF_OK && !finish(&m, y, z, a, values, out_factors)) {
        result = no_memory(context, rank);
    }
    free(y);
    free(z);
    free(a);
    matrix_clear(&m);
    if (result != BTF_OK) {
        pca_factors_clear(out_factors);
    }
    return result;
}

btf_result pca_factorise(const enc_context *context, const enc_data *data, pca_coding coding, size_t rank,
                         pca_factors *out_factors) {
    return factorise(context, data, NULL, 0, PCA_RGB, coding, rank, out_factors);
}

btf_result pca_factorise_texels(const enc_context *context, const enc_data *data, const uint32_t *list,
                                size_t count, pca_coding coding, size_t rank, pca_factors *out_factors) {
    return factorise(context, data, list, count, PCA_RGB, coding, rank, out_factors);
}

btf_result pca_factorise_plane(const enc_context *context, const enc_data *data, pca_plane plane,
                               pca_coding coding, size_t rank, pca_factors *out_factors) {
    return factorise(context, data, NULL, 0, plane, coding, rank, out_factors);
}

void pca_factors_clear(pca_factors *factors) {
    free(factors->u);
    free(factors->v);
    *factors = (pca_factors){0};
}
