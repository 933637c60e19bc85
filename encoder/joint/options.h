/* The options of the joint method, and the record of a run.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_OPTIONS_H
#define OPENBTF_ENCODER_JOINT_OPTIONS_H

#include "encoder/model/trial.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum enc_joint_preset {
    ENC_JOINT_FAST = 0,
    ENC_JOINT_MEDIUM = 1,
    ENC_JOINT_THOROUGH = 2,
    ENC_JOINT_EXHAUSTIVE = 3,
} enc_joint_preset;

typedef enum enc_joint_metric {
    ENC_JOINT_BALANCED = 0, /* square-root domain: near the best of both */
    /* the same: an sRGB-coded domain gained nothing in its own figure (prototype, low-rank sources: 29.4
     * against 29.4 dB on BRICKS64, 36.9 against 37.0 on IMPALLA64) */
    ENC_JOINT_SRGB = 1,
    ENC_JOINT_LINEAR = 2, /* linear domain */
} enc_joint_metric;

typedef struct enc_joint_options {
    int preset;       /* enc_joint_preset; default medium */
    int metric;       /* enc_joint_metric; default balanced */
    uint32_t effects; /* btf_effect bits; default all */
    bool choose;      /* default: those of `effects` are used that pay; false: all of them, in any case */
    /* dB in the fitted domain that an effect must bring against the components that its bytes could hold;
     * default 0.05. The second counts for each MB more, default 0. */
    double effect_tolerance, effect_tolerance_bytes;
    double front_tolerance; /* dB that an SBRDF in front of the residual may cost; default 0.1 */
    uint64_t
        budget; /* gpu bytes at most; 0: what layout `paper` takes (2.36 MB for 64x64, 81 directions) */
    double
        quality; /* dB of sRGB-coded PSNR that is enough; 0: 55 dB in the fitted domain, where codes end */
    int rounds;  /* rounds at most; 0: as the preset says */
    double
        tolerance;  /* a round that lowers the error by less than this part is the last; 0: the preset's */
    int components; /* residual components at most; 0: as many as the budget allows */
} enc_joint_options;

/* The defaults above. */
enc_joint_options enc_joint_options_default(void);

enum {
    ENC_JOINT_MAX_ROUNDS = 1000,
    ENC_JOINT_MOST_COMPONENTS = 128, /* more would make the solves of every source dominate */
};

/* The course of a fit and its result. */
typedef struct enc_joint_stats {
    int rounds; /* rounds of the chosen shape */
    double
        history[ENC_JOINT_MAX_ROUNDS]; /* its error after each round: sum of squares in the fitted domain */
    double error;                      /* the same for the codes of the file */
    double psnr_fitted;                /* dB, peak 1 in the fitted domain, of the codes */
    double psnr_linear, psnr_srgb;     /* dB over all samples clipped to [0, 1], of the codes */
    uint64_t gpu_bytes;                /* of layout `tight` */
    size_t moved;                      /* points (texel, view) with a shift */
    enc_trial trials[ENC_MAX_TRIALS];  /* in the order in which they were tried */
    int trials_count;
} enc_joint_stats;

/* The figures that a preset stands for. */
typedef struct joint_preset_values {
    int start;        /* subspace iterations of the plain factorisation */
    int trials;       /* shapes that are tried */
    int trial_rounds; /* rounds of a trial */
    int rounds;       /* rounds of the best, trial included */
    int front;        /* the same where sources have no residual */
    double tolerance; /* relative decrease of the error that ends the rounds */
} joint_preset_values;

/* The figures of options->preset. */
joint_preset_values joint_preset_of(const enc_joint_options *options);

#endif
