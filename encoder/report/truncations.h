/* The accuracy of the first components of a residual alone, out of the table of effect errors.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_TRUNCATIONS_H
#define OPENBTF_ENCODER_TRUNCATIONS_H

#include "bands.h"
#include "metrics.h"

/* Errors at level 0 with all effects and the first `components` of the residual (units, where its store is
 * factors). Means of squared errors at directions drawn from each pair of bands, which counts by its
 * samples. */
typedef struct enc_truncation {
    uint32_t components;
    double gpu_bytes;
    enc_error_sum samples, between; /* count is 1 */
} enc_truncation;

enum { ENC_MOST_TRUNCATIONS = 16 };

/* Finds the truncations in the table [count] of enc_effect_errors, by falling components; out has room for
 * ENC_MOST_TRUNCATIONS. Returns how many: 0 where `effects` have no residual. */
size_t enc_truncations(const float *table, size_t count, const enc_data *data, uint32_t effects,
                       enc_truncation *out);

#endif
