/* The vectorised evaluation of the Lafortune fit: one pass over the samples gives every dot product that
 * cost, gradient and Gauss-Newton matrix are made of.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_LAFORTUNE_GRAM_H
#define OPENBTF_ENCODER_LAFORTUNE_GRAM_H

#include "encoder/model/sbrdf.h"

/* Samples come in blocks; the last is filled up with zeros. */
enum { ENC_GRAM_BLOCK = 256, ENC_GRAM_MAX_COLUMNS = 4 * (1 + ENC_MAX_LOBES) };

/* Below this base a lobe counts as 0 while fitting: there the derivatives run off to infinity. */
#define ENC_GRAM_MIN_BASE 1e-4f

/* Planar samples, each array aligned to 64 bytes and padded to a multiple of ENC_GRAM_BLOCK; in the padding
 * multiplier and target are 0 and product anything finite. */
typedef struct enc_gram_samples {
    size_t n;                /* samples, without the padding */
    const float *product[3]; /* lx vx, ly vy, lz vz */
    const float *multiplier; /* sqrt(weight) * m(l) [* shadow * gain], >= 0 */
    const float *target[3];  /* sqrt(weight) * value, R, G, B */
} enc_gram_samples;

/* A point in parameter space: the shapes of the lobes, and the colours that the residuals are taken at. */
typedef struct enc_gram_point {
    float shape[ENC_MAX_LOBES][4];      /* (Cx, Cy, Cz, n) a lobe */
    float colour[3][1 + ENC_MAX_LOBES]; /* [channel]: diffuse term, then the weight of each lobe */
} enc_gram_point;

static inline int enc_gram_columns(int lobes) {
    return 4 * (1 + lobes);
}

/* out_gram[a * columns + b] = sum over samples of column_a * column_b, symmetric, with the columns
 *   0        multiplier
 *   1..3     residual R, G, B: multiplier * (colour_0 + sum_j colour_j p_j) - target
 *   4+4j..   multiplier * base^(n-1) * (lx vx, ly vy, lz vz), multiplier * p_j * ln(base)   of lobe j
 * where base = Cx lx vx + Cy ly vy + Cz lz vz and p_j = base^n = (Cx, Cy, Cz) . (the first three over the
 * multiplier), both 0 below ENC_GRAM_MIN_BASE. So dp/dC = n * the first three, dp/dn = the fourth, and the
 * model itself lies in the span of the columns (Lafortune et al. 1997, eq. 8, and its derivatives).
 *
 * Sums are 16 float lanes over a block, then double, in an order that depends neither on the instruction
 * set nor on threads. */
void enc_gram_accumulate(const enc_gram_samples *samples, int lobes, const enc_gram_point *point,
                         double *out_gram);

/* The largest base Cx lx vx + Cy ly vy + Cz lz vz of the samples, at least ENC_GRAM_MIN_BASE. */
float enc_gram_peak(const enc_gram_samples *samples, const float c[3]);

#endif
