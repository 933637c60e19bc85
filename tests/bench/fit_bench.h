/* Compares our fit with a plain Ceres problem with automatic derivatives: time and final cost.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_FIT_BENCH_H
#define OPENBTF_TESTS_BENCH_FIT_BENCH_H

#include "encoder/data/data.h"
#include <stdio.h>

typedef struct bench_fit_summary {
    int texels;
    double ceres_seconds, ceres_cost;   /* Ceres from the first fixed start; sums over the texels */
    double single_seconds, single_cost; /* enc_fit_texel from the same start */
    double full_seconds, full_cost;     /* enc_fit_texel with the default number of starts */
    double worst_ratio;                 /* largest full cost over Ceres's of one texel */
} bench_fit_summary;

/* Fits `texels` texels, evenly spread over the data, with three lobes in one colour and no rejection: by
 * the automatically differentiated Ceres problem of ceres_bridge.h (tolerance 1e-6, Ceres's default; one
 * thread), and by enc_fit_texel. Seconds are CPU time of the calling thread, so that a busy machine matters
 * little; costs are sums of squared residuals. csv (may be NULL) receives a header and one row a texel.
 * About 0.2 s a texel. Errors: BTF_ERROR_USAGE (texels < 1), BTF_ERROR_MEMORY, BTF_ERROR_IO (scratch file),
 * BTF_ERROR_INTERNAL (Ceres failed), BTF_ERROR_INTERRUPTED. */
btf_result bench_fit(const enc_context *context, const enc_data *data, int texels, FILE *csv,
                     bench_fit_summary *out_summary);

#endif
