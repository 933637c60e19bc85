/* A BTF as low-bit, colour-separated factors: the store "factors" of format 2 (FORMAT.md).
 *
 * The square root of a sample of radiance, cosine included, is a sum of products u_j(x) w_j(v, l) in each
 * of three channels of opponent colour. The leading components are found by a randomised range finder,
 * given 8, 4 or 2 bits a factor by Lagrange's multiplier, rounded by coordinate descent on the codes, and
 * packed.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_H
#define OPENBTF_ENCODER_FACTOR_H

#include "classes.h"
#include "measure.h"
#include "stop.h"

enum { ENC_FACTOR_SWEEPS = 6 };

/* Whether texels take profiles from one another (match.h). */
typedef enum enc_factor_match {
    ENC_FACTOR_NO_MATCH,
    ENC_FACTOR_MATCH,
    ENC_FACTOR_CHOOSE_MATCH, /* both are tried, and match is kept where it gains at the same bytes */
} enc_factor_match;

typedef struct enc_factor_options {
    uint64_t budget; /* bytes on the GPU, at most: texels of u and w, scales, views' factors, lists of match */
    int sweeps;      /* rounds of descent; 0: none. ENC_FACTOR_SWEEPS is where more gain little */
    enc_factor_match match; /* ENC_FACTOR_MATCH wants samples in memory; without them none is chosen */
    bool gain;              /* with match; else all gains are 1 */
    double tolerance; /* dB that a tenth more bytes must gain at samples left out of the fit; 0: the budget
                         is filled */
    bool measure;    /* the error at the samples is wanted: one more pass over them */
} enc_factor_options;

/* A candidate that was encoded. */
typedef struct enc_factor_trial {
    bool match, kept;
    bool given_up; /* after a survey: the rest is 0 but for core_seconds */
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

/* Encodes a BTF. The same bits for any number of threads and ranks. Samples are read in passes, each of them
 * once a pass, and not kept; enc_factor_memory says what it takes. Ranks (encoder/base/ranks.h) share all that
 * is done with samples, the descent on codes, and the search of match; factors times factors, their Gram
 * matrices and eigenvectors, the allocation and the lists of a single block of match are done by every rank.
 * Stages "factorise",
 * "match", "round factors" and "measure factors". Errors: BTF_ERROR_USAGE (a budget that holds no unit),
 * BTF_ERROR_UNSUPPORTED (match, and samples that are not in memory), BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED; *out_factors is NULL then. */
btf_result enc_factor_encode(const enc_context *context, const enc_data *data,
                             const enc_factor_options *options, enc_factors **out_factors);
void enc_factors_destroy(enc_factors **factors);

/* The fewest bytes that hold factors: one unit. */
uint64_t enc_factor_least_budget(int width, int height, int n_views, int n_lights);

/* Bytes that an encode takes at most beside the samples. */
uint64_t enc_factor_memory(int width, int height, int n_views, int n_lights, uint64_t budget, int threads);

#endif
