/* `--method factors`: a BTF as factors alone, from data to a solution.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_METHOD_H
#define OPENBTF_ENCODER_FACTOR_METHOD_H

#include "encoder/model/solution.h"
#include "encoder/model/trial.h"

enum {
    ENC_FACTORS_TRIALS = 5, /* encodes that a search for a quality takes beside the first, at most */
};

typedef struct enc_factors_settings {
    uint64_t budget; /* gpu bytes at most */
    double quality;  /* dB of sRGB-coded PSNR that is enough; 0: none is */
    int sweeps;      /* of the descent on codes */
    double tolerance; /* dB that a tenth more bytes must gain at samples left out of the fit; 0: the budget
                         is filled */
} enc_factors_settings;

typedef struct enc_factors_stats {
    enc_trial trials[1 + ENC_FACTORS_TRIALS]; /* in the order in which they were made */
    int trials_count;
    enc_unspent unspent; /* of the last encode */
} enc_factors_stats;

/* Encodes `data`. With a quality, budgets are tried until the fewest bytes that reach it are known to a
 * hundredth, or ENC_FACTORS_TRIALS were; where the whole budget does not reach it, that stays, with a
 * warning. The same data and settings give the same solution for any number of threads. Errors: as
 * enc_factor_encode. On error *out_solution is zeroed. */
btf_result enc_factors_solve(const enc_context *context, const enc_data *data,
                             const enc_factors_settings *settings, enc_solution *out_solution,
                             enc_factors_stats *out_stats);

#endif
