/* The share of the half vector that each neighbouring view's lights keep, chosen by views and lights left
 * out.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RELIEF_GLOSS_H
#define OPENBTF_ENCODER_RELIEF_GLOSS_H

#include "judge.h"

enum { ENC_GLOSS_SHARES = 5 }; /* 0, 1/4, ... 1 */

typedef struct enc_gloss_choice {
    bool judged;
    enc_judged_error error[ENC_GLOSS_SHARES];
    double best;  /* share, between the five by a parabola */
    int quarters; /* chosen: one more as long as linear and sRGB-coded values each gain ENC_GLOSS_MARGIN by
                     it, so that neither pays for the other; 2 at most, since samples left out are twice as
                     far from the others as in use */
} enc_gloss_choice;

#define ENC_GLOSS_MARGIN 0.2 /* dB that each quarter must gain */

/* The direction around which neighbour `near` of a view looks up lights (FORMAT.md section 9, Gloss). */
void enc_gloss_light(const float near[3], const float view[3], const float light[3], float share,
                     float out[3]);

/* Judges the shares by views and lights left out. Views whose bit in `relief_views` is set are shifted
 * along the surface `warp`; NULL: no view is. Errors: those of the data and of enc_left_out_make,
 * BTF_ERROR_MEMORY. */
btf_result enc_gloss_choose(const enc_context *context, const enc_data *data, const enc_seen *seen,
                            const enc_warp *warp, const uint8_t *relief_views,
                            enc_gloss_choice *out_choice);

#endif
