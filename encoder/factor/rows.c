/* Products of factors. See rows.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "rows.h"

#include "encoder/math/gemm.h"

#include <stdlib.h>
#include <string.h>

enum {
    DEPTH = 1024,
    MESSAGE = 1 << 24, /* bytes of rows that go from rank to rank at a time, or one row if that is more */
};

bool enc_rows_dot(int threads, size_t n_a, const float *a, size_t n_b, const float *b, size_t count,
                  float *out) {
    const enc_gemm_tile tile = enc_gemm_select();
    const size_t panels = enc_gemm_panels(n_b, ENC_GEMM_N);
    float *left = enc_gemm_alloc((n_a + ENC_GEMM_M) * DEPTH);
    float *right = enc_gemm_alloc((size_t)threads * ENC_GEMM_N * DEPTH);
    const bool room = left && right;
    for (size_t at = 0; at < count && room; at += DEPTH) {
        const size_t depth = count - at < DEPTH ? count - at : DEPTH;
        enc_gemm_pack_rows(n_a, depth, a + at, count, ENC_GEMM_M, left);
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (size_t p = 0; p < panels; p++) {
            const size_t j = p * ENC_GEMM_N, n = n_b - j < ENC_GEMM_N ? n_b - j : ENC_GEMM_N;
            float *panel = right + enc_thread_index() * ENC_GEMM_N * DEPTH;
            enc_gemm_pack_rows(n, depth, b + j * count + at, count, ENC_GEMM_N, panel);
            enc_gemm_multiply(tile, n_a, n, depth, left, panel, out + j, n_b, at > 0);
        }
    }
    free(left);
    free(right);
    return room;
}

bool enc_rows_turn(int threads, size_t n_out, size_t n, const float *turn, size_t count, const float *x,
                   float *out) {
    const enc_gemm_tile tile = enc_gemm_select();
    float *left = enc_gemm_alloc((n_out + ENC_GEMM_M) * n);
    float *panels = enc_gemm_alloc((size_t)threads * ENC_GEMM_N * n);
    const bool room = left && panels;
    if (room) {
        enc_gemm_pack_rows(n_out, n, turn, n, ENC_GEMM_M, left);
#pragma omp parallel for schedule(dynamic, 4) num_threads(threads)
        for (size_t i = 0; i < count; i += ENC_GEMM_N) {
            const size_t columns = count - i < ENC_GEMM_N ? count - i : ENC_GEMM_N;
            float *panel = panels + enc_thread_index() * ENC_GEMM_N * n;
            enc_gemm_pack_columns(columns, n, x + i, count, ENC_GEMM_N, panel);
            enc_gemm_multiply(tile, n_out, columns, n, left, panel, out + i, count, 0);
        }
    }
    free(left);
    free(panels);
    return room;
}

/* Finds the columns that a rank computes. */
static void range_of(const enc_context *context, int rank, size_t count, size_t unit, size_t *out_first,
                     size_t *out_end) {
    enc_ranks_range_of(context, rank, (count + unit - 1) / unit, out_first, out_end);
    *out_first = *out_first * unit < count ? *out_first * unit : count;
    *out_end = *out_end * unit < count ? *out_end * unit : count;
}

void enc_rows_range(const enc_context *context, size_t count, size_t unit, size_t *out_first,
                    size_t *out_end) {
    range_of(context, enc_ranks_own(context), count, unit, out_first, out_end);
}

/* Copies a rank's columns of some rows to its part of a message, or back. */
static void copy_part(size_t n, size_t row_bytes, size_t first, size_t part_bytes, unsigned char *rows,
                      unsigned char *message, bool back) {
    for (size_t j = 0; j < n; j++) {
        unsigned char *part = message + j * part_bytes, *row = rows + j * row_bytes + first;
        memcpy(back ? row : part, back ? part : row, part_bytes);
    }
}

/* Completes some rows by one message, which has the columns of the first rank, of all these rows, then
 * those of the next rank. */
static btf_result complete_some(const enc_context *context, btf_result result, size_t n, size_t count,
                                size_t unit, size_t item_bytes, unsigned char *rows, size_t *bounds,
                                unsigned char *message) {
    const int own = enc_ranks_own(context);
    bounds[0] = 0;
    for (int r = 0; r < enc_ranks_count(context); r++) {
        size_t first, end;
        range_of(context, r, count, unit, &first, &end);
        bounds[r + 1] = n * end;
        if (r == own && result == BTF_OK) {
            copy_part(n, count * item_bytes, first * item_bytes, (end - first) * item_bytes, rows,
                      message + n * first * item_bytes, false);
        }
    }
    result = enc_ranks_gather_bounds(context, result, message, item_bytes, bounds);
    for (int r = 0; r < enc_ranks_count(context) && result == BTF_OK; r++) {
        size_t first, end;
        range_of(context, r, count, unit, &first, &end);
        if (r != own) {
            copy_part(n, count * item_bytes, first * item_bytes, (end - first) * item_bytes, rows,
                      message + n * first * item_bytes, true);
        }
    }
    return result;
}

btf_result enc_rows_complete(const enc_context *context, btf_result result, size_t n, size_t count,
                             size_t unit, size_t item_bytes, void *rows) {
    const size_t row_bytes = count * item_bytes, fit = row_bytes > 0 ? MESSAGE / row_bytes : 0;
    const size_t most = fit < 1 ? 1 : fit < n ? fit : n;
    if (enc_ranks_count(context) < 2) {
        return result;
    }
    unsigned char *message = malloc(most * row_bytes + 1);
    size_t *bounds = malloc(((size_t)enc_ranks_count(context) + 1) * sizeof *bounds);
    if (result == BTF_OK && (!message || !bounds)) {
        result = enc_fail(context, BTF_ERROR_MEMORY, "factors: out of memory for what ranks exchange");
    }
    if (!bounds) {
        result = enc_ranks_agree(context, result);
    }
    for (size_t j = 0; j < n && bounds; j += most) {
        const size_t some = n - j < most ? n - j : most;
        result = complete_some(context, result, some, count, unit, item_bytes,
                               (unsigned char *)rows + j * row_bytes, bounds, message);
    }
    free(message);
    free(bounds);
    return result;
}
