/* The one dense kernel of the joint method: a fixed 12 x 32 tile of a float matrix product, and the two
 * packings that feed it.
 *
 * Every element is one sum over k in ascending order, so a product has the same bits for any number of
 * threads and any blocking of rows and columns; with FMA (AVX2, AVX-512) also for any vector width.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MATH_GEMM_H
#define OPENBTF_ENCODER_MATH_GEMM_H

#include <stddef.h>
#include <stdint.h>
#ifdef _OPENMP
#include <omp.h>
#endif

enum { ENC_GEMM_M = 12, ENC_GEMM_N = 32 };

/* tile[m][n] = sum over p < k of a[p][m] * b[p][n]; a is [k][12], b is [k][32], 64-byte aligned. */
typedef void (*enc_gemm_tile)(size_t k, const float *a, const float *b, float *tile);

/* The fastest tile of this machine. */
enc_gemm_tile enc_gemm_select(void);

/* The number of panels that `rows` rows take, and of floats in them. */
static inline size_t enc_gemm_panels(size_t rows, size_t width) {
    return (rows + width - 1) / width;
}

/* Packs row-major rows [rows][k] of pitch `pitch` as panels [panel][p][width], zero-padded; `width` is
 * ENC_GEMM_M for left operands and ENC_GEMM_N for right ones. */
void enc_gemm_pack_rows(size_t rows, size_t k, const float *source, size_t pitch, size_t width,
                        float *packed);
/* Packs rows from a source given column by column, [k][rows] of pitch `pitch`, as enc_gemm_pack_rows does. */
void enc_gemm_pack_columns(size_t rows, size_t k, const float *source, size_t pitch, size_t width,
                           float *packed);

/* out[m][n] (+)= sum over p of a[p][m] b[p][n] for m < rows, n < columns, from packed operands. */
void enc_gemm_multiply(enc_gemm_tile tile, size_t rows, size_t columns, size_t k, const float *a,
                       const float *b, float *out, size_t pitch, int accumulate);

/* Index of the calling OpenMP thread. */
static inline size_t enc_thread_index(void) {
#ifdef _OPENMP
    return (size_t)omp_get_thread_num();
#else
    return 0;
#endif
}

/* 64-byte aligned array of floats, not cleared; NULL when out of memory or too large. */
float *enc_gemm_alloc(size_t count);

/* The first 64-byte aligned address from `at` on, within such an array. */
static inline float *enc_gemm_aligned(float *at) {
    return (float *)(((uintptr_t)at + 63) / 64 * 64);
}

#endif
