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

enum { ENC_FACTOR_SWEEPS = 6 };

typedef struct enc_factor_options {
    uint64_t budget; /* bytes on the GPU, at most: texels of u and w, scales and views' factors */
    int sweeps;      /* rounds of descent; 0: none. ENC_FACTOR_SWEEPS is where more gain little */
    bool match, gain; /* texels take the profiles of others, times a gain; samples must be in memory */
    bool survey;      /* whether match and gain may pay is wanted; without match */
    bool measure;    /* the error at the samples is wanted: one more pass over them */
} enc_factor_options;

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
    int8_t *shift;    /* [view][texel][2], as version 1 stores it; NULL without match */
    uint8_t *gain;    /* [view][texel] codes; NULL without match */
    float gain_scale; /* of a code */
    uint64_t match_bytes; /* of `bytes`: lists and indices of match, as a packed store would take */
    double survey;    /* enc_match_survey; 1 where not asked for, or samples are not in memory */
    uint64_t bytes;                                            /* of the budget */
    enc_factor_error error;                                    /* 0 where not asked for */
} enc_factors;

/* Encodes a BTF. The same bits for any number of threads. Samples are read in passes, each of them once a
 * pass, and not kept; enc_factor_memory says what it takes. Every rank does all of it. Stages "factorise",
 * "round factors" and "measure factors". Errors: BTF_ERROR_USAGE (a budget that holds no unit),
 * BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED; *out_factors is NULL then. */
btf_result enc_factor_encode(const enc_context *context, const enc_data *data,
                             const enc_factor_options *options, enc_factors **out_factors);
void enc_factors_destroy(enc_factors **factors);

/* The fewest bytes that hold factors: one unit. */
uint64_t enc_factor_least_budget(int width, int height, int n_views, int n_lights);

/* Bytes that an encode takes at most beside the samples. */
uint64_t enc_factor_memory(int width, int height, int n_views, int n_lights, uint64_t budget, int threads);

#endif
