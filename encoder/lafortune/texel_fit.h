/* The Lafortune fit of one texel to arbitrary weighted samples (Lafortune et al. 1997).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_LAFORTUNE_TEXEL_FIT_H
#define OPENBTF_ENCODER_LAFORTUNE_TEXEL_FIT_H

#include "encoder/model/sbrdf.h"

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>

enum { ENC_FIT_MAX_STARTS = 4 };

/* Bounds of the search, in a scale where the largest target of the texel is about 1. In the file a lobe of
 * strength f has |C| of about f^(1/n): n >= 0.5 keeps dim lobes (f = 0.01, C = 1e-4) well above the
 * smallest number that can be stored, for 0.1 % of the cost against n >= 0.3. */
#define ENC_FIT_MIN_N 0.5
#define ENC_FIT_MAX_N 200.0
#define ENC_FIT_MAX_C 3.0

typedef struct enc_fit_options {
    int lobes;           /* 1 .. ENC_MAX_LOBES; default 3 */
    bool rgb;            /* RGB lobes instead of one colour; default false */
    bool square_root;    /* fit sqrt(value) with m(l) = sqrt(max(l.z, 0)); default false */
    int rounds;          /* shadow rejections, each followed by a new fit; default 3, 0: plain fit */
    float t_error;       /* threshold_error of paper 2.1; default 0.3 */
    float t_btf;         /* threshold_BTF of paper 2.1, on linear luminance; default 0.3 */
    int starts;          /* starts of a texel's first fit, 1 .. ENC_FIT_MAX_STARTS; default 4 */
    double tolerance;    /* stop after two steps that gain less than this share of the cost; default 1e-3 */
    int max_evaluations; /* passes over the samples from one start; default 60 */
} enc_fit_options;

/* The defaults above. */
enc_fit_options enc_fit_options_default(void);

/* Samples of one texel, planar. `product` is l * v by component. The model of a sample is multiplier *
 * colour model of sbrdf.h; multiplier holds m(l) and whatever else scales the sample (shadow, gain). A
 * weight of NULL counts as 1. Multipliers, targets and weights are finite and >= 0. */
typedef struct enc_fit_samples {
    size_t n;
    const float *product[3];
    const float *multiplier;
    const float *target[3]; /* R, G, B, in the domain of the multiplier */
    const float *weight;
} enc_fit_samples;

/* Scratch memory of one thread. */
typedef struct enc_fit_workspace enc_fit_workspace;

/* Room for max_samples samples. Errors: BTF_ERROR_USAGE, BTF_ERROR_MEMORY. */
btf_result enc_fit_workspace_create(size_t max_samples, enc_fit_workspace **out_workspace);
void enc_fit_workspace_destroy(enc_fit_workspace **workspace);

typedef struct enc_fit_result {
    double cost;     /* sum of weight * squared residual over the channels */
    int evaluations; /* passes over the samples */
    int dead_lobes;  /* lobes set to 0 */
    bool diffuse;    /* all lobes set to 0 */
} enc_fit_result;

/* Minimises sum of weight * |multiplier * model - target|^2 over one texel's parameters (lobes, rgb,
 * tolerance, max_evaluations of the options).
 * start: parameters in the layout of sbrdf.h to go on from, or NULL. `starts` fixed starts are tried too
 * (options->starts is not looked at; at least one of both must be there), and the best end is returned.
 * With a start, the cost at its end is never above the cost at the start, up to float rounding of the
 * parameters (about 1e-6 of the target's energy).
 * out_parameters: enc_sbrdf_stride(lobes, rgb) floats, normalised; all zeros when every target is 0. Never
 * a worse model than the best one without lobes, also where the limits of the file (2^-24 to 2^24) change a
 * parameter: then the cost is that of what is stored.
 * Errors: BTF_ERROR_MEMORY. */
btf_result enc_fit_texel(enc_fit_workspace *workspace, const enc_fit_samples *samples,
                         const enc_fit_options *options, const float *start, int starts,
                         float *out_parameters, enc_fit_result *out_result);

/* The fixed start `index` (0 .. ENC_FIT_MAX_STARTS - 1) with colour (1, 1, 1), in the layout of one colour:
 * 4 + 4 * lobes floats. */
void enc_fit_fixed_start(int index, int lobes, float *out_parameters);

#endif
