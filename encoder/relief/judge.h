/* Judges a surface: views left out are predicted from the others with it and without, and compared in
 * radiance.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RELIEF_JUDGE_H
#define OPENBTF_ENCODER_RELIEF_JUDGE_H

#include "seen.h"

/* Images of all views under some lights, spread over the list, as roots in 8 bits. */
typedef struct enc_judged {
    int width, height, n_views, lights;
    uint8_t *roots; /* [view][texel][light][3] */
} enc_judged;

/* Bytes that such images take at most. */
uint64_t enc_judged_bytes(int width, int height, int n_views);

/* Makes the images of a level of detail, each texel the mean, in linear radiance, of those that it covers;
 * level 0: the samples as they are. Stage steps: the level's texels. The same bits for any number of
 * threads. Errors: those of the data, BTF_ERROR_MEMORY (not logged), BTF_ERROR_INTERRUPTED. */
btf_result enc_judged_create(const enc_context *context, const enc_data *data, int level,
                             enc_judged *out_judged);
void enc_judged_clear(enc_judged *judged);

/* Mean squared errors of values clipped to [0, 1]. */
typedef struct enc_judged_error {
    double linear, srgb;
} enc_judged_error;

/* dB, mean of linear and sRGB-coded, that b gains over a. */
double enc_judged_gain(enc_judged_error a, enc_judged_error b);

/* Finds the error of each view left out, out [seen->count], at drawn texels. Roots are blended, and whole
 * texels fetched, by which relief gains less than by filtered fetches. The same bits for any number of
 * threads. */
void enc_judge_surface(const enc_context *context, const enc_judged *judged, const enc_seen *seen,
                       const enc_warp *warp, enc_judged_error *out);

#endif
