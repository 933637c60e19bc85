/* Match and gain: in each view a texel takes the profile of another one, its source, times a gain.
 *
 * value(x, v, l) = gain(x, v) * sum of u_j(source(x, v)) w_j(v, l). With sources and gains held, fitting u
 * and w is a weighted factorisation: the samples of all texels that have a source z in a view, each times
 * its gain, add up to a row of z, which has the weight of the sum of the gains' squares. enc_factor_matrix
 * (matrix.h) multiplies such rows where it is given a match.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_MATCH_H
#define OPENBTF_ENCODER_FACTOR_MATCH_H

#include "encoder/base/context.h"

#include <stdbool.h>
#include <stdint.h>

enum {
    ENC_MATCH_REACH = 32,  /* shifts of columns and rows are within -32 .. 31 */
    ENC_MATCH_GAINS = 16,  /* different gains that points may have */
    ENC_MATCH_TRIED = 112, /* gains that the first search may take, before the scale of ENC_MATCH_GAINS is fitted */
    /* A texel's list of pairs of source and gain, to which each of its points, (texel, view), has an index.
     * BRICKS64 at 2.36 MB: lists of 16 33.77 / 31.41 dB, of 8 33.5 / 31.2, pairs of their own for all
     * points 33.7 / 31.2, no match 33.2 / 31.1. More texels: allocation/BITS.md. */
    ENC_MATCH_ENTRIES = 16,
};

/* Gains in steps of `step` from `base`; `count` 1 and base 1 where there are none. */
typedef struct enc_match_gains {
    int count;
    float base, step;
} enc_match_gains;

typedef struct enc_match {
    int width, height;
    size_t texels, views;
    enc_match_gains gains;
    uint32_t *source; /* [view][texel] */
    uint8_t *gain;    /* [view][texel]: index of a gain */
    /* The users of a source in a view, as enc_match_count_users lists them: texels user[first[i]] .. user[first[i +
     * 1] - 1], i = source * views + view, and the sum of the squares of their gains. */
    uint32_t *first, *user;
    float *weight; /* [source][view] */
    bool whole;    /* a search holds the coordinates of the sources of the whole texture, not those that a block
                      of it reaches, which are found again for each block that they lie near; the same is found */
} enc_match;

static inline float enc_match_gain(const enc_match *match, size_t view, size_t texel) {
    return match->gains.base + match->gains.step * (float)match->gain[view * match->texels + texel];
}

/* Makes a match in which every texel is its own source. gains: whether the first search is to try gains.
 * Errors: BTF_ERROR_MEMORY. */
btf_result enc_match_create(const enc_context *context, int width, int height, size_t views, bool gains,
                            enc_match *out_match);
void enc_match_clear(enc_match *match);

/* Fills in first, user and weight. */
void enc_match_count_users(const enc_context *context, enc_match *match);

/* Makes a scale of ENC_MATCH_GAINS gains, from the 1st to the 99th percentile of those of the first search,
 * rounds these to it and counts the users anew. */
void enc_match_fit_gains(const enc_context *context, enc_match *match);

/* The number of pairs in a texel's list; 0 where views are so few that a pair for each takes no more
 * bytes. */
size_t enc_match_entries(size_t views);
/* Bytes that a file's store of shift and gain takes on the GPU: lists of two bytes a pair and indices of 4
 * bits, a byte for two views; or two bytes a point. */
uint64_t enc_match_bytes(size_t texels, size_t views);

/* Writes shifts and gain codes as packed points store them: shift [view][texel][2], gain [view][texel]. */
void enc_match_store(const enc_match *match, int8_t *out_shift, uint8_t *out_gain);

#endif
