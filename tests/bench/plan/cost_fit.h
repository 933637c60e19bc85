/* Fits the prices of a cost model (openbtf/cost.h) to measured times.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_COST_FIT_H
#define OPENBTF_TESTS_BENCH_COST_FIT_H

#include "encoder/base/context.h"

#include <openbtf/cost.h>

/* A decode: its counts, and the nanoseconds a pixel that it took, above 0. */
typedef struct cost_sample {
    btf_decode_counts counts;
    double ns;
} cost_sample;

/* The deviation of predictions from measured times, relative to the latter. */
typedef struct cost_deviation {
    double mean, worst;
    int count; /* of samples */
} cost_deviation;

/* The prices, none below 0, for which the sum of squared relative errors is least. A count that no sample has gets the
 * price 0. */
cost_deviation cost_fit(const cost_sample *samples, int count, btf_cost_model *out_model);

/* Writes the file that btf_cost_model_open reads. Errors, on the log: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result cost_write(const enc_context *context, const char *path, const btf_cost_model *model,
                      const cost_deviation *deviation);

#endif
