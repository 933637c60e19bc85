/* Codes in the layout of format 2 (FORMAT.md).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_PACK_H
#define OPENBTF_ENCODER_FACTOR_PACK_H

#include "measure.h"
#include "stop.h"

/* Why a candidate was not encoded. */
typedef enum enc_factor_omission {
    ENC_FACTOR_ENCODED = 0,
    ENC_FACTOR_SURVEYED,  /* a survey says that it cannot pay */
    ENC_FACTOR_NO_MEMORY, /* not tried: the samples, or the search beside them, do not fit the memory allowed */
    ENC_FACTOR_NO_BYTES,  /* not tried: the bytes do not hold the lists of match and one unit */
    ENC_FACTOR_OMISSIONS
} enc_factor_omission;

/* A candidate that was encoded, or left out. */
typedef struct enc_factor_trial {
    bool match, kept;
    enc_factor_omission omitted; /* not 0: the rest is 0 but for core_seconds */
    int n_units;
    uint64_t bytes;         /* of the budget */
    enc_factor_error error; /* 0 where it was not measured */
    double core_seconds;
} enc_factor_trial;

typedef struct enc_factors {
    int width, height, n_views, n_lights;
    int n_units;                                               /* texels of w a (view, light) */
    int n_u_texels;                                            /* texels of u a texel */
    uint32_t classes[ENC_FACTOR_CLASSES][ENC_FACTOR_CHANNELS]; /* units, C1 words, C2 words */
    uint32_t *texels;                                          /* [n_u_texels][height][width][4] */
    uint32_t *directions;                                      /* [n_units][n_views][n_lights][4] */
    float *scales;                                             /* [n_units][4] */
    float *views;                                              /* [n_views][tier][Y, C1, C2] */
    size_t components[ENC_FACTOR_CHANNELS];                    /* kept of Y, C1, C2 */
    int8_t *shift;                  /* [view][texel][2]: columns, rows, -32 .. 31; NULL without match */
    uint8_t *gain;                  /* [view][texel]: codes 0 .. 15; NULL without match */
    float gain_base, gain_step;     /* a code says base + code * step */
    int point_entries;              /* distinct pairs of shift and gain that a texel has at most; 0: any number */
    uint64_t match_bytes;           /* of `bytes`: lists and indices, or a pair a point */
    enc_factor_trial trials[2];     /* in the order in which they were made */
    int n_trials;
    uint64_t bytes;                                            /* of the budget */
    enc_unspent unspent;                                       /* why not all of it */
    enc_factor_error error;                                    /* 0 where not asked for */
} enc_factors;

void enc_factors_destroy(enc_factors **factors);

/* Packs codes into texels [u texel][texel][4] and directions [unit][column][4], which the caller zeroes,
 * and scales [unit][4], which are those of red, green and blue along the axis of the word's channel. */
void enc_factor_pack(const enc_context *context, const enc_factor_codes *codes, uint32_t *texels,
                     uint32_t *directions, float *scales);

#endif
