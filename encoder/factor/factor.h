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

#include "pack.h"

enum { ENC_FACTOR_SWEEPS = 6 };

/* Whether texels take profiles from one another (match/match.h). */
typedef enum enc_factor_match {
    ENC_FACTOR_NO_MATCH,
    ENC_FACTOR_MATCH,
    ENC_FACTOR_CHOOSE_MATCH, /* both are tried, and match is kept where it gains at the same bytes */
} enc_factor_match;

typedef struct enc_factor_options {
    uint64_t budget; /* bytes on the GPU, at most: texels of u and w, scales, views' factors, lists of match */
    int sweeps;      /* rounds of descent; 0: none. More than ENC_FACTOR_SWEEPS gain little */
    enc_factor_match match; /* ENC_FACTOR_MATCH needs samples in memory; ENC_FACTOR_CHOOSE_MATCH does without
                               match where they are not */
    bool gain;              /* with match; else all gains are 1 */
    double tolerance; /* dB that a tenth more bytes must gain at samples left out of the fit; 0: the budget
                         is filled */
    bool measure;    /* the error at the samples is wanted: one more pass over them */
    int number;      /* of the encode, where one job makes several: in the names of its steps in a
                        checkpoint */
    /* NULL, or the components of all encodes of a job, [channel]: zeroed, they are found and stay here, for
     * the caller to clear; else they come from an encode of the same data by no smaller a budget, and are
     * not looked for again. With a tolerance of 0. */
    enc_components *basis;
} enc_factor_options;

/* Encodes a BTF. The same bits for any number of threads and ranks. Samples are read in passes, each of
 * them once a pass, and not kept; enc_factor_memory gives the bytes. Ranks (encoder/base/ranks.h) share all
 * the work on samples, the descent on codes, and the search of match; factors times factors, their Gram
 * matrices and eigenvectors, the allocation and the lists of a single block of match are done by every
 * rank. Stages "factorise", "match", "round factors" and "measure factors". Errors: BTF_ERROR_USAGE (a
 * budget that holds no unit), BTF_ERROR_UNSUPPORTED (match, and samples that are not in memory),
 * BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED; *out_factors is NULL then. */
btf_result enc_factor_encode(const enc_context *context, const enc_data *data,
                             const enc_factor_options *options, enc_factors **out_factors);

/* The fewest bytes that hold factors: one unit. */
uint64_t enc_factor_least_budget(int width, int height, int n_views, int n_lights);

/* Bytes that an encode without match takes at most beside the samples, and those that match adds. Where the
 * memory allowed does not hold both beside the samples, match is left out of the choice; where it holds
 * more, match takes the coordinates of the whole texture (match/match.h), which saves time. */
uint64_t enc_factor_match_memory(int width, int height, int n_views, uint64_t budget, bool whole);
uint64_t enc_factor_memory(int width, int height, int n_views, int n_lights, uint64_t budget, int threads);

#endif
