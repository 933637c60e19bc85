/* A choice of effects that a method of analysis has tried, and why a budget was not filled, for log and
 * report.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_TRIAL_H
#define OPENBTF_ENCODER_MODEL_TRIAL_H

#include <stdbool.h>
#include <stdint.h>

typedef struct enc_trial {
    uint32_t effects; /* btf_effect bits */
    int lobes;        /* 0: no SBRDF */
    bool rgb;
    int components, centres;
    uint64_t gpu_bytes;
    double psnr;         /* dB in the fitted domain: after the rounds of a trial, or on a probe's sample */
    double core_seconds; /* time of the trial, of all threads */
    const char *verdict;
} enc_trial;

/* Why a method did not fill its budget: more bytes gain too little at samples that were left out of the
 * fit. All 0 where the tolerance is 0, which fills the budget. */
typedef struct enc_unspent {
    uint64_t budget, bytes; /* bytes that were allowed, and bytes that pay */
    double more, tolerance; /* `more` times the bytes would have to gain `tolerance` dB */
    double gain;            /* dB that the whole budget is predicted to gain over `bytes` */
    uint64_t signal[3];     /* components of Y, C1 and C2 that are signal */
    bool ends[3];           /* components beyond `signal` are noise; else more of them may be signal */
} enc_unspent;

enum { ENC_MAX_TRIALS = 32 };

#endif
