/* A reflectance model alone in the place of factors: a plane without relief, of paint or print, needs no more.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOB_REFLECTANCE_H
#define OPENBTF_ENCODER_JOB_REFLECTANCE_H

#include "encoder/report/metrics.h"
#include "settings.h"

enum {
    ENC_REFLECTANCE_BYTES = 16,  /* a texel: one lobe of one colour, in halves (FORMAT.md, section 4) */
    ENC_REFLECTANCE_TEXELS = 64, /* of the survey, at most */
};

/* What a model is weighed by. */
typedef struct enc_reflectance_weights {
    uint64_t model_bytes, factor_bytes;
    double tolerance; /* dB that a tenth more bytes must gain */
    double quality;   /* dB of sRGB-coded PSNR that is enough; 0: none is */
} enc_reflectance_weights;

/* Whether a model of no more bytes than the factors is to be taken: where it has the quality that is asked for, and not where
 * they alone have it; else where the factors gain less over it than a tolerance for each tenth of their further bytes, in the
 * mean of the dB of linear and of sRGB-coded values, of which 100 are as good as more. */
bool enc_reflectance_pays(const enc_reflectance_weights *weights, const enc_error_sum *model, const enc_error_sum *factors);

/* Fits a model to a few texels, and where it leaves little there, to all. Where it pays by the error at the samples of
 * `data`, it takes the place of *io_solution, the factors that enc_factors_solve found, as a solution of one lobe and no
 * effect, and *out_taken is true. Tried, it is the last of the trials, taken or not. Nothing is tried where the job does
 * not leave the effects open. The same for any number of threads and ranks. Stage "reflectance". Errors: those of enc_paper,
 * enc_pack and enc_metrics_compare; *out_taken is false then. */
btf_result enc_reflectance_try(const enc_context *context, const enc_job *job, const enc_data *data,
                               enc_solution *io_solution, enc_factors_stats *io_stats, bool *out_taken);

/* The options that a model is fitted with: of level 0, and of further levels. */
enc_paper_options enc_reflectance_options(void);

#endif
