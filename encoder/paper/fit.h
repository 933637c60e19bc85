/* The iterative Lafortune fit with shadow rejection (paper 2.1; Lafortune et al. 1997; McAllister et al.
 * 2002), made of fits of single texels (encoder/lafortune/texel_fit.h).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_FIT_H
#define OPENBTF_ENCODER_PAPER_FIT_H

#include "encoder/data/data.h"
#include "encoder/lafortune/texel_fit.h"
#include "encoder/model/sbrdf.h"

typedef struct enc_fit_stats {
    double cost;         /* sum of squared residuals over the kept samples, in the fitted domain */
    double core_seconds; /* thread CPU time of all fits and tests */
    uint64_t texels;
    uint64_t solves;      /* fits of one texel, all starts of it counted as one */
    uint64_t evaluations; /* passes over the samples of a texel */
    uint64_t samples;     /* texel, view, light triples */
    uint64_t rejected;    /* of them, left out of the last fit */
    uint64_t fallbacks;   /* texels that kept the diffuse fit, since their lobes did not pay */
    uint64_t dead_lobes;  /* lobes of other texels set to 0 because they did not pay */
    uint64_t black;       /* texels without any light */
} enc_fit_stats;

/* Fits every texel of `data`. Round r leaves out the samples that the model of round r - 1 calls shadowed,
 *   SBRDF * m(l) - BTF > t_error * BTF  and  BTF < t_btf      (luminances)
 * and starts from its solution; a texel stops early when nothing changes or when less than 10 % would be
 * kept. Parameters come normalised (sbrdf.h), never NaN. out_stats may be NULL.
 * The same bits for any context->threads and instruction set; between machines only as far as libm's exp,
 * log and pow agree, of which glibc has versions by CPU type. Errors: BTF_ERROR_USAGE (an option),
 * BTF_ERROR_MEMORY, BTF_ERROR_IO (scratch file), BTF_ERROR_INTERRUPTED. */
btf_result enc_fit(const enc_context *context, const enc_data *data, const enc_fit_options *options,
                   enc_sbrdf **out_sbrdf, enc_fit_stats *out_stats);

#endif
