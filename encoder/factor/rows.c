/* Products of factors. See rows.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "rows.h"

#include "encoder/math/gemm.h"

#include <stdlib.h>

enum { DEPTH = 1024 };

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
