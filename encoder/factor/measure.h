/* The error of rounded factors at the samples.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_MEASURE_H
#define OPENBTF_ENCODER_FACTOR_MEASURE_H

#include "codes.h"

/* Mean squared errors of values clipped to [0, 1], over all samples and channels. */
typedef struct enc_factor_error {
    double linear;
    double srgb; /* of values with the sRGB curve */
} enc_factor_error;

/* Measures the codes in one pass over the samples. The same bits for any number of threads and ranks, which
 * share it. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED. */
btf_result enc_factor_measure(const enc_factor_matrix *matrix, const enc_factor_codes *codes,
                              enc_factor_error *out_error);

#endif
