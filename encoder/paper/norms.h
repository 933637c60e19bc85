/* Sums of Euclidean norms over light profiles: the distance of paper 2.3.2 and its lower bound.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_NORMS_H
#define OPENBTF_ENCODER_PAPER_NORMS_H

#include <stddef.h>

enum { ENC_NORM_LANES = 16 };

/* The loops for the instruction set in use; all of them give the same bits. */
typedef struct enc_norms {
    /* sum_i || a_i - b_i ||, a and b holding three planes of `lanes` floats (a multiple of 16), so that a_i
     * is (a[i], a[lanes + i], a[2 * lanes + i]). */
    float (*distance)(const float *a, const float *b, size_t lanes);
    /* The distance of `query`, of 16 lanes, to each of `count` consecutive candidates: out[count]. */
    void (*bounds)(const float *query, const float *candidates, size_t count, float *out);
} enc_norms;

enc_norms enc_norms_choose(void);

#endif
