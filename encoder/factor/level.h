/* Levels of detail of a material of factors.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_LEVEL_H
#define OPENBTF_ENCODER_FACTOR_LEVEL_H

#include "encoder/data/data.h"
#include "encoder/model/solution.h"

enum {
    ENC_FACTORS_FIT_SWEEPS = 12,  /* of the least squares */
    ENC_FACTORS_LEVEL_SWEEPS = 6, /* of the descent on codes */
};

/* Fits u of a level of detail to its data, with w and the scales of `base`, the solution of level 0: by
 * least squares, then by descent on the codes. *out_solution owns its texels alone (enc_level_clear).
 * Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED. */
btf_result enc_factors_level(const enc_context *context, const enc_data *data, const enc_solution *base,
                             enc_solution *out_solution);

#endif
