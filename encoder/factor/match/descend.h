/* Descent on u and w of factors whose texels have sources in other texels.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_MATCH_DESCEND_H
#define OPENBTF_ENCODER_FACTOR_MATCH_DESCEND_H

#include "encoder/factor/codes.h"

/* Makes `sweeps` sweeps of coordinate descent on w and then on u of every channel, while matrix->match
 * stays. With `round` values move from level to level, else freely. Takes two passes over the samples. The
 * same bits for any number of threads and ranks. Errors: BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_match_descend(const enc_factor_matrix *matrix, enc_factor_codes *io_codes, bool round,
                             int sweeps);

#endif
