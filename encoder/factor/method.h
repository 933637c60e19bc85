/* Encodes a BTF as factors, with match and gain or without: from data to a solution.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_METHOD_H
#define OPENBTF_ENCODER_FACTOR_METHOD_H

#include "encoder/model/solution.h"
#include "encoder/model/trial.h"

enum {
    ENC_FACTORS_TRIALS = 5, /* the most encodes that a search for a quality adds to the first */
};

typedef struct enc_factors_settings {
    uint64_t budget; /* gpu bytes at most */
    double quality;  /* dB of sRGB-coded PSNR that is enough; 0: none is */
    int sweeps;      /* of the descent on codes */
    /* btf_effect bits. The residual is always there; with BTF_EFFECT_SHIFT texels take the profiles of
     * others, times a gain with BTF_EFFECT_GAIN; a file then holds both, and the gains are 1 without it. Not
     * read where `choose` is set. */
    uint32_t effects;
    bool
        choose; /* take shift and gain where a survey says that they may pay and an encode shows that they do
                    at the same bytes; else neither */
    double tolerance; /* dB that a tenth more bytes must gain at samples left out of the fit; 0: the budget
                         is filled */
} enc_factors_settings;

typedef struct enc_factors_stats {
    enc_trial trials[2 + ENC_FACTORS_TRIALS + 1]; /* in the order in which they were made; room for one of who goes on */
    int trials_count, encodes;
    enc_unspent unspent; /* of the last encode */
} enc_factors_stats;

/* Encodes `data`. Where the settings leave the choice, match and gain are kept where they gain at the bytes
 * that pay without them. With a quality, budgets are tried, from the components of the first encode, until the
 * fewest bytes that reach it are known to a hundredth, or ENC_FACTORS_TRIALS were; where the whole budget does
 * not reach it, that stays, with a warning. The same data and settings give the same solution for any number
 * of threads and ranks. Errors: as enc_factor_encode. On error *out_solution is zeroed. */
btf_result enc_factors_solve(const enc_context *context, const enc_data *data,
                             const enc_factors_settings *settings, enc_solution *out_solution,
                             enc_factors_stats *out_stats);

#endif
