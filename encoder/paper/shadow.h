/* Shadow test, shadow ratio and top-view shadow maps (paper 2.1 and 2.2).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_SHADOW_H
#define OPENBTF_ENCODER_PAPER_SHADOW_H

#include "encoder/data/data.h"
#include "encoder/model/sbrdf.h"

/* Below this modelled luminance there is nothing to divide by: the ratio is 1. */
#define ENC_SHADOW_MIN_MODEL 1e-5f

typedef struct enc_shadow_options {
    float t_error;    /* threshold_error; default 0.3 */
    float t_btf;      /* threshold_BTF; default 0.3 */
    bool square_root; /* the SBRDF models sqrt(value), ratios are of roots; default false */
} enc_shadow_options;

enc_shadow_options enc_shadow_options_default(void);

/* Paper 2.1 with the sign corrected and the division multiplied out:
 * (model - btf) / btf > t_error and btf < t_btf. Linear luminances, cosine included. btf = 0 below a
 * positive model is shadow, 0 below 0 is not. */
static inline bool enc_is_shadowed(float model, float btf, float t_error, float t_btf) {
    return model - btf > t_error * btf && btf < t_btf;
}

/* ShadowMap of paper 2.1 from linear luminances: btf / model where shadowed, else 1; in 0..1. */
static inline float enc_shadow_ratio(float model, float btf, float t_error, float t_btf) {
    if (!enc_is_shadowed(model, btf, t_error, t_btf) || !(model >= ENC_SHADOW_MIN_MODEL)) {
        return 1.0f;
    }
    const float ratio = btf / model;
    return ratio < 1.0f ? ratio : 1.0f;
}

/* 8-bit code of a ratio: round(255 * ratio), ratio clamped to 0..1 (NaN counts as 0). */
static inline uint8_t enc_shadow_code(float ratio) {
    const float clamped = ratio > 0.0f ? (ratio < 1.0f ? ratio : 1.0f) : 0.0f;
    return (uint8_t)(255.0f * clamped + 0.5f);
}

/* Finds the 6D shadow function of one texel under one view: out_ratio[light]. `samples` is the profile
 * [channel][light] of (texel, view), linear. buffer: 6 * n_lights floats of scratch memory. */
void enc_shadow_profile(const enc_data *data, const enc_sbrdf *sbrdf, const enc_shadow_options *options,
                        size_t texel, int view, const float *samples, float *buffer, float *out_ratio);

/* Makes the top-view shadow map (2.2): out[light][texel], codes of the ratios at data->top_view. Errors:
 * BTF_ERROR_USAGE (thresholds, texel count), BTF_ERROR_MEMORY, BTF_ERROR_IO (scratch file),
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_top_view_shadow(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                               const enc_shadow_options *options, uint8_t *out);

#endif
