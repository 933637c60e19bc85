/* Gram matrix of derivatives and residuals over blocks of samples.
 *
 * SPDX-License-Identifier: MIT
 */
#include "gram.h"
#include "encoder/math/simd.h"
#include <assert.h>
#include <string.h>

enum { VECTORS = ENC_GRAM_BLOCK / ENC_LANES };

/* All columns of one block: 20 KB at most, which stay in the first-level cache. */
typedef struct block_columns {
    enc_v16 column[ENC_GRAM_MAX_COLUMNS][VECTORS];
} block_columns;

/* Computes, for one vector of samples, the lobe's four columns from h = multiplier * base^(n-1); out_value
 * = h * base. */
ENC_INLINE void lobe_columns(const float shape[4], const enc_v16 *px, const enc_v16 *py, const enc_v16 *pz,
                             const enc_v16 *multiplier, enc_v16 *ex, enc_v16 *ey, enc_v16 *ez, enc_v16 *en,
                             enc_v16 *out_value) {
    const enc_v16 one = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    const enc_v16 base = (shape[0] * *px + shape[1] * *py) + shape[2] * *pz;
    enc_i16 off;
    enc_v16 safe, t, power;
    enc_v16_below(&base, ENC_GRAM_MIN_BASE, &off);
    enc_v16_select(&off, &one, &base, &safe);
    enc_v16_log2(&safe, &t);
    const enc_v16 e = (shape[3] - 1.0f) * t;
    enc_v16_exp2_clamped(&e, &power);
    const enc_v16 h = *multiplier * (enc_v16)(~off & (enc_i16)power);
    const enc_v16 value = h * safe;
    *ex = h * *px;
    *ey = h * *py;
    *ez = h * *pz;
    *en = value * (t * 0x1.62e43p-1f);
    *out_value = value;
}

ENC_INLINE void fill_columns(const enc_gram_samples *samples, size_t first, int lobes,
                             const enc_gram_point *point, block_columns *block) {
    for (int k = 0; k < VECTORS; k++) {
        const size_t at = first + (size_t)k * ENC_LANES;
        const enc_v16 px = *(const enc_v16 *)(samples->product[0] + at);
        const enc_v16 py = *(const enc_v16 *)(samples->product[1] + at);
        const enc_v16 pz = *(const enc_v16 *)(samples->product[2] + at);
        const enc_v16 multiplier = *(const enc_v16 *)(samples->multiplier + at);
        enc_v16 model[3];
        for (int c = 0; c < 3; c++) {
            model[c] = point->colour[c][0] * multiplier;
        }
        block->column[0][k] = multiplier;
        for (int j = 0; j < lobes; j++) {
            enc_v16(*column)[VECTORS] = block->column + 4 + 4 * j;
            enc_v16 value;
            lobe_columns(point->shape[j], &px, &py, &pz, &multiplier, &column[0][k], &column[1][k],
                         &column[2][k], &column[3][k], &value);
            for (int c = 0; c < 3; c++) {
                model[c] = model[c] + point->colour[c][1 + j] * value;
            }
        }
        for (int c = 0; c < 3; c++) {
            block->column[1 + c][k] = model[c] - *(const enc_v16 *)(samples->target[c] + at);
        }
    }
}

/* Multiplies four columns with four columns over one block, lane by lane, in 16 accumulators of 16 lanes:
 * for machines with 32 wide registers. */
ENC_INLINE void multiply_tile_wide(enc_v16 (*a)[VECTORS], enc_v16 (*b)[VECTORS], enc_v16 sum[16]) {
    enc_v16 s00 = {0}, s01 = s00, s02 = s00, s03 = s00, s10 = s00, s11 = s00, s12 = s00, s13 = s00;
    enc_v16 s20 = s00, s21 = s00, s22 = s00, s23 = s00, s30 = s00, s31 = s00, s32 = s00, s33 = s00;
    for (int k = 0; k < VECTORS; k++) {
        const enc_v16 b0 = b[0][k], b1 = b[1][k], b2 = b[2][k], b3 = b[3][k];
        const enc_v16 a0 = a[0][k], a1 = a[1][k], a2 = a[2][k], a3 = a[3][k];
        s00 = s00 + a0 * b0, s01 = s01 + a0 * b1, s02 = s02 + a0 * b2, s03 = s03 + a0 * b3;
        s10 = s10 + a1 * b0, s11 = s11 + a1 * b1, s12 = s12 + a1 * b2, s13 = s13 + a1 * b3;
        s20 = s20 + a2 * b0, s21 = s21 + a2 * b1, s22 = s22 + a2 * b2, s23 = s23 + a2 * b3;
        s30 = s30 + a3 * b0, s31 = s31 + a3 * b1, s32 = s32 + a3 * b2, s33 = s33 + a3 * b3;
    }
    sum[0] = s00, sum[1] = s01, sum[2] = s02, sum[3] = s03;
    sum[4] = s10, sum[5] = s11, sum[6] = s12, sum[7] = s13;
    sum[8] = s20, sum[9] = s21, sum[10] = s22, sum[11] = s23;
    sum[12] = s30, sum[13] = s31, sum[14] = s32, sum[15] = s33;
}

/* Adds the sums of multiply_tile_wide by eight accumulators of half the lanes at a time: for machines with
 * 16 registers. */
ENC_INLINE void multiply_tile_narrow(enc_v16 (*a)[VECTORS], enc_v16 (*b)[VECTORS], enc_v16 sum[16]) {
    typedef float v8 __attribute__((vector_size(32), may_alias));
    enum { STEP = 2 }; /* halves a vector */
    for (int row = 0; row < 4; row += 2) {
        for (int half = 0; half < STEP; half++) {
            const v8 *a0 = (const v8 *)a[row] + half, *a1 = (const v8 *)a[row + 1] + half;
            const v8 *b0 = (const v8 *)b[0] + half, *b1 = (const v8 *)b[1] + half;
            const v8 *b2 = (const v8 *)b[2] + half, *b3 = (const v8 *)b[3] + half;
            v8 s00 = {0}, s01 = s00, s02 = s00, s03 = s00, s10 = s00, s11 = s00, s12 = s00, s13 = s00;
            for (int k = 0; k < STEP * VECTORS; k += STEP) {
                s00 = s00 + a0[k] * b0[k], s01 = s01 + a0[k] * b1[k];
                s02 = s02 + a0[k] * b2[k], s03 = s03 + a0[k] * b3[k];
                s10 = s10 + a1[k] * b0[k], s11 = s11 + a1[k] * b1[k];
                s12 = s12 + a1[k] * b2[k], s13 = s13 + a1[k] * b3[k];
            }
            v8 *out = (v8 *)(sum + 4 * row) + half;
            out[0 * STEP] = s00, out[1 * STEP] = s01, out[2 * STEP] = s02, out[3 * STEP] = s03;
            out[4 * STEP] = s10, out[5 * STEP] = s11, out[6 * STEP] = s12, out[7 * STEP] = s13;
        }
    }
}

/* Adds the 16 lanes of each accumulator pairwise: lane i with lane i + 8, then 4, 2, 1. */
ENC_INLINE void add_lanes(const enc_v16 sum[16], double *gram, int columns) {
    for (int i = 0; i < 16; i++) {
        const float *lane = (const float *)&sum[i];
        float half[8];
        for (int k = 0; k < 8; k++) {
            half[k] = lane[k] + lane[k + 8];
        }
        for (int k = 0; k < 4; k++) {
            half[k] = half[k] + half[k + 4];
        }
        gram[(i >> 2) * columns + (i & 3)] += (double)((half[0] + half[2]) + (half[1] + half[3]));
    }
}

ENC_INLINE void accumulate_all(const enc_gram_samples *samples, int lobes, const enc_gram_point *point,
                               bool wide, double *gram) {
    const int columns = enc_gram_columns(lobes);
    block_columns block;
    for (size_t first = 0; first < samples->n; first += ENC_GRAM_BLOCK) {
        fill_columns(samples, first, lobes, point, &block);
        for (int i = 0; i < columns; i += 4) {
            for (int j = i; j < columns; j += 4) {
                enc_v16 sum[16];
                if (wide) {
                    multiply_tile_wide(block.column + i, block.column + j, sum);
                } else {
                    multiply_tile_narrow(block.column + i, block.column + j, sum);
                }
                add_lanes(sum, gram + i * columns + j, columns);
            }
        }
    }
}

#ifdef ENC_HAVE_X86_DISPATCH
ENC_TARGET_AVX512 static void accumulate_avx512(const enc_gram_samples *samples, int lobes,
                                                const enc_gram_point *point, double *gram) {
    accumulate_all(samples, lobes, point, true, gram);
}
ENC_TARGET_AVX2 static void accumulate_avx2(const enc_gram_samples *samples, int lobes,
                                            const enc_gram_point *point, double *gram) {
    accumulate_all(samples, lobes, point, false, gram);
}
#endif

static void accumulate(const enc_gram_samples *samples, int lobes, const enc_gram_point *point,
                       double *gram) {
#ifdef ENC_HAVE_X86_DISPATCH
    switch (enc_isa_current()) {
    case ENC_ISA_AVX512:
        accumulate_avx512(samples, lobes, point, gram);
        return;
    case ENC_ISA_AVX2:
        accumulate_avx2(samples, lobes, point, gram);
        return;
    case ENC_ISA_BASE:
        break;
    }
#endif
    accumulate_all(samples, lobes, point, false, gram);
}

void enc_gram_accumulate(const enc_gram_samples *samples, int lobes, const enc_gram_point *point,
                         double *out_gram) {
    assert(lobes >= 0 && lobes <= ENC_MAX_LOBES);
    const int columns = enc_gram_columns(lobes);
    memset(out_gram, 0, sizeof *out_gram * (size_t)(columns * columns));
    accumulate(samples, lobes, point, out_gram);
    for (int a = 0; a < columns; a++) {
        for (int b = 0; b < a; b++) {
            out_gram[a * columns + b] = out_gram[b * columns + a];
        }
    }
}

float enc_gram_peak(const enc_gram_samples *samples, const float c[3]) {
    const enc_v16 zero = {0};
    enc_v16 largest = zero + ENC_GRAM_MIN_BASE;
    for (size_t at = 0; at < samples->n; at += ENC_LANES) {
        const enc_v16 px = *(const enc_v16 *)(samples->product[0] + at);
        const enc_v16 py = *(const enc_v16 *)(samples->product[1] + at);
        const enc_v16 pz = *(const enc_v16 *)(samples->product[2] + at);
        const enc_v16 base = (c[0] * px + c[1] * py) + c[2] * pz;
        const enc_v16 room = largest - base;
        enc_i16 above;
        enc_v16_below(&room, 0.0f, &above);
        enc_v16_select(&above, &base, &largest, &largest);
    }
    const float *lane = (const float *)&largest;
    float peak = lane[0];
    for (int i = 1; i < ENC_LANES; i++) {
        peak = lane[i] > peak ? lane[i] : peak;
    }
    return peak;
}
