/* `--method paper`: the analysis of sections 2 and 3.1 as printed, stage after stage.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_PAPER_H
#define OPENBTF_ENCODER_PAPER_PAPER_H

#include "cluster.h"
#include "fit.h"
#include "flow.h"
#include "refine.h"
#include "shadow.h"
#include "encoder/model/solution.h"
#include "encoder/model/trial.h"

typedef struct enc_paper_options {
    enc_fit_options fit;
    enc_flow_options flow;
    enc_refine_options refine;
    enc_cluster_options cluster;
    uint32_t effects; /* of shadow, shift, hidden; stages of the others do not run */
    bool choose;      /* leave out those of `effects` that do not pay; default false */
    bool fallback;    /* take the diffuse fit where that is better (diffuse_fallback.h); default false */
    double effect_tolerance, effect_tolerance_bytes; /* dB that an effect must gain; dB for each MB of it */
    uint32_t centres; /* k; 0: what the smallest legal atlas has room for (paper: 1984) */
} enc_paper_options;

typedef struct enc_paper_stats {
    enc_fit_stats fit;
    size_t hidden_before, hidden_after, hidden_total; /* table 1; zeros when shift and hidden do not run */
    enc_trial trials[ENC_MAX_TRIALS]; /* what options->choose and ->fallback tried, linear PSNR on a sample */
    int trials_count;
    bool diffuse; /* the diffuse fit was better, and is what is returned (options->fallback) */
} enc_paper_stats;

/* The paper's own settings. */
enc_paper_options enc_paper_options_default(void);

/* Runs fit, shadow, flow, refinement and clustering. out_occlusion may be NULL; it is set when flow ran.
 * Errors: those of the stages. On error *out_solution is zeroed. */
btf_result enc_paper(const enc_context *context, const enc_data *data, const enc_paper_options *options,
                     enc_solution *out_solution, enc_occlusion **out_occlusion, enc_paper_stats *out_stats);

#endif
