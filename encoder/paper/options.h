/* The options of `--method paper`, and the record of a run.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_OPTIONS_H
#define OPENBTF_ENCODER_PAPER_OPTIONS_H

#include "cluster.h"
#include "encoder/model/trial.h"
#include "fit.h"
#include "flow.h"
#include "refine.h"
#include "shadow.h"

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
    /* Counts of points for the paper's table 1; zeros when shift and hidden do not run. */
    size_t hidden_before, hidden_after, hidden_total;
    enc_trial trials[ENC_MAX_TRIALS]; /* of options->choose and ->fallback; linear PSNR on a sample */
    int trials_count;
    bool diffuse; /* the diffuse fit was better and was taken (options->fallback) */
} enc_paper_stats;

/* The paper's own settings. */
enc_paper_options enc_paper_options_default(void);

#endif
