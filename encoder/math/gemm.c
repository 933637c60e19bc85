/* Matrix product tiles (see gemm.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "gemm.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__)
#include <immintrin.h>

__attribute__((target("avx512f"))) static void tile_avx512(size_t k, const float *a, const float *b,
                                                           float *tile) {
    __m512 sum[ENC_GEMM_M][2];
#pragma GCC unroll 12
    for (int m = 0; m < ENC_GEMM_M; m++) {
        sum[m][0] = _mm512_setzero_ps();
        sum[m][1] = _mm512_setzero_ps();
    }
    for (size_t p = 0; p < k; p++) {
        const __m512 b0 = _mm512_load_ps(b), b1 = _mm512_load_ps(b + 16);
#pragma GCC unroll 12
        for (int m = 0; m < ENC_GEMM_M; m++) {
            const __m512 x = _mm512_set1_ps(a[m]);
            sum[m][0] = _mm512_fmadd_ps(x, b0, sum[m][0]);
            sum[m][1] = _mm512_fmadd_ps(x, b1, sum[m][1]);
        }
        a += ENC_GEMM_M;
        b += ENC_GEMM_N;
    }
#pragma GCC unroll 12
    for (int m = 0; m < ENC_GEMM_M; m++) {
        _mm512_storeu_ps(tile + m * ENC_GEMM_N, sum[m][0]);
        _mm512_storeu_ps(tile + m * ENC_GEMM_N + 16, sum[m][1]);
    }
}

/* Six rows by sixteen columns, which fit 16 registers. */
__attribute__((target("avx2,fma"))) static void part_avx2(size_t k, const float *a, const float *b,
                                                          float *tile) {
    __m256 sum[6][2];
#pragma GCC unroll 6
    for (int m = 0; m < 6; m++) {
        sum[m][0] = _mm256_setzero_ps();
        sum[m][1] = _mm256_setzero_ps();
    }
    for (size_t p = 0; p < k; p++) {
        const __m256 b0 = _mm256_load_ps(b), b1 = _mm256_load_ps(b + 8);
#pragma GCC unroll 6
        for (int m = 0; m < 6; m++) {
            const __m256 x = _mm256_broadcast_ss(a + m);
            sum[m][0] = _mm256_fmadd_ps(x, b0, sum[m][0]);
            sum[m][1] = _mm256_fmadd_ps(x, b1, sum[m][1]);
        }
        a += ENC_GEMM_M;
        b += ENC_GEMM_N;
    }
#pragma GCC unroll 6
    for (int m = 0; m < 6; m++) {
        _mm256_storeu_ps(tile + m * ENC_GEMM_N, sum[m][0]);
        _mm256_storeu_ps(tile + m * ENC_GEMM_N + 8, sum[m][1]);
    }
}

__attribute__((target("avx2,fma"))) static void tile_avx2(size_t k, const float *a, const float *b,
                                                          float *tile) {
    for (int n = 0; n < ENC_GEMM_N; n += 16) {
        for (int m = 0; m < ENC_GEMM_M; m += 6) {
            part_avx2(k, a + m, b + n, tile + m * ENC_GEMM_N + n);
        }
    }
}
#endif

static void tile_plain(size_t k, const float *a, const float *b, float *tile) {
    memset(tile, 0, ENC_GEMM_M * ENC_GEMM_N * sizeof *tile);
    for (size_t p = 0; p < k; p++) {
        for (int m = 0; m < ENC_GEMM_M; m++) {
            for (int n = 0; n < ENC_GEMM_N; n++) {
                tile[m * ENC_GEMM_N + n] += a[p * ENC_GEMM_M + m] * b[p * ENC_GEMM_N + n];
            }
        }
    }
}

enc_gemm_tile enc_gemm_select(void) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f")) {
        return tile_avx512;
    }
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
        return tile_avx2;
    }
#endif
    return tile_plain;
}

/* Packs a run of the columns of up to `width` rows. */
static inline __attribute__((always_inline)) void pack_run(size_t count, size_t run, const float *source,
                                                           size_t pitch, size_t width,
                                                           float *restrict packed) {
    for (size_t i = 0; i < count; i++) {
        const float *row = source + i * pitch;
        for (size_t p = 0; p < run; p++) {
            packed[p * width + i] = row[p];
        }
    }
    for (size_t i = count; i < width; i++) {
        for (size_t p = 0; p < run; p++) {
            packed[p * width + i] = 0.0f;
        }
    }
}

void enc_gemm_pack_rows(size_t rows, size_t k, const float *source, size_t pitch, size_t width,
                        float *packed) {
    enum { RUN = 32 }; /* columns whose panel stays in the first cache until all rows are in it */
    for (size_t first = 0; first < rows; first += width) {
        const size_t count = rows - first < width ? rows - first : width;
        for (size_t p = 0; p < k; p += RUN) {
            const float *from = source + first * pitch + p;
            if (k - p >= RUN && width == ENC_GEMM_N) {
                pack_run(count, RUN, from, pitch, ENC_GEMM_N, packed + p * ENC_GEMM_N);
            } else if (k - p >= RUN && width == ENC_GEMM_M) {
                pack_run(count, RUN, from, pitch, ENC_GEMM_M, packed + p * ENC_GEMM_M);
            } else {
                pack_run(count, k - p < RUN ? k - p : RUN, from, pitch, width, packed + p * width);
            }
        }
        packed += k * width;
    }
}

void enc_gemm_pack_columns(size_t rows, size_t k, const float *source, size_t pitch, size_t width,
                           float *packed) {
    for (size_t first = 0; first < rows; first += width) {
        const size_t count = rows - first < width ? rows - first : width;
        for (size_t p = 0; p < k; p++) {
            const float *column = source + p * pitch + first;
            for (size_t i = 0; i < count; i++) {
                packed[p * width + i] = column[i];
            }
            for (size_t i = count; i < width; i++) {
                packed[p * width + i] = 0.0f;
            }
        }
        packed += k * width;
    }
}

void enc_gemm_multiply(enc_gemm_tile tile, size_t rows, size_t columns, size_t k, const float *a,
                       const float *b, float *out, size_t pitch, int accumulate) {
    _Alignas(64) float block[ENC_GEMM_M * ENC_GEMM_N];
    for (size_t n0 = 0; n0 < columns; n0 += ENC_GEMM_N) {
        const float *panel = b + n0 * k;
        const size_t width = columns - n0 < ENC_GEMM_N ? columns - n0 : ENC_GEMM_N;
        for (size_t m0 = 0; m0 < rows; m0 += ENC_GEMM_M) {
            const size_t height = rows - m0 < ENC_GEMM_M ? rows - m0 : ENC_GEMM_M;
            tile(k, a + m0 * k, panel, block);
            for (size_t m = 0; m < height; m++) {
                float *row = out + (m0 + m) * pitch + n0;
                const float *from = block + m * ENC_GEMM_N;
                if (accumulate) {
                    for (size_t n = 0; n < width; n++) {
                        row[n] += from[n];
                    } } else {
                    memcpy(row, from, width * sizeof *row);
                }
            }
        }
    }
}

float *enc_gemm_alloc(size_t count) {
    if (count > SIZE_MAX / sizeof(float) - 64) {
        return NULL;
    }
    const size_t bytes = (count * sizeof(float) + 63) / 64 * 64;
    return aligned_alloc(64, bytes ? bytes : 64);
}
