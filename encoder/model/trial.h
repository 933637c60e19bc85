/* A choice of effects that a method of analysis has tried, for log and report.
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
    double core_seconds; /* what the trial took, of all threads */
    const char *verdict;
} enc_trial;

enum { ENC_MAX_TRIALS = 32 };

#endif
