/* `--method factors`: a BTF as factors alone, from data to a solution.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_METHOD_H
#define OPENBTF_ENCODER_FACTOR_METHOD_H

#include "encoder/model/solution.h"
#include "encoder/model/trial.h"

enum {
    ENC_FACTORS_TRIALS = 5, /* encodes that a search for a quality takes beside the first ones, at most */
    ENC_FACTORS_LEVEL_SWEEPS = 6,
};

typedef struct enc_factors_settings {
    uint64_t budget; /* gpu bytes at most */
    double quality;  /* dB of sRGB-coded PSNR that is enough; 0: none is */
    int sweeps;      /* of the descent on codes */
    uint32_t effects; /* btf_effect bits: residual; shift for match, and gain with it */
    bool choose;      /* of shift and gain, both or neither: both where a survey says that they may pay, and they do */
} enc_factors_settings;

typedef struct enc_factors_stats {
    enc_trial trials[2 + ENC_FACTORS_TRIALS]; /* in the order in which they were made */
    int trials_count;
} enc_factors_stats;

/* Encodes `data`. Where it is to choose, match and gain are tried at the same bytes, and kept where they gain at the
 * samples. With a quality, budgets are tried until the fewest bytes that reach it are known to a hundredth,
 * or ENC_FACTORS_TRIALS were; where the whole budget does not reach it, that stays, with a warning. The same data and
 * settings give the same solution for any number of threads. Errors: as enc_factor_encode. On error *out_solution is
 * zeroed. */
btf_result enc_factors_solve(const enc_context *context, const enc_data *data, const enc_factors_settings *settings,
                             enc_solution *out_solution, enc_factors_stats *out_stats);

/* Fits u of a level of detail to its data with what it shares with `base`, the solution of level 0: by least squares,
 * then by descent on the codes. *out_solution owns its texels alone (enc_level_clear). Errors: BTF_ERROR_MEMORY,
 * BTF_ERROR_IO, BTF_ERROR_INTERRUPTED. */
btf_result enc_factors_level(const enc_context *context, const enc_data *data, const enc_solution *base,
                             enc_solution *out_solution);

#endif
