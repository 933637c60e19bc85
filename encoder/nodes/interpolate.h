/* Weights of samples in a direction between them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_INTERPOLATE_H
#define OPENBTF_ENCODER_INTERPOLATE_H

#include "encoder/data/data.h"

typedef enum enc_interpolation {
    ENC_INTERPOLATE_NEAREST = 0, /* the decoder's nearest mode */
    ENC_INTERPOLATE_LINEAR, /* barycentric: the decoder's triangles and integer weights (FORMAT.md, 6) */
    ENC_INTERPOLATE_SPLINE, /* a thin-plate spline through all samples, in the stereographic plane */
    ENC_INTERPOLATE_CUBIC,  /* the same of the kernel r^3, which is smoother */
} enc_interpolation;

/* Samples and their weights, which sum to 1. */
typedef struct enc_weights {
    int count;
    uint32_t index[ENC_MAX_DIRECTIONS];
    float weight[ENC_MAX_DIRECTIONS]; /* of a spline also below 0 and above 1 */
} enc_weights;

typedef struct enc_interpolator enc_interpolator;

/* Makes an interpolator for `count` distinct directions, 1 to ENC_MAX_DIRECTIONS; messages call them by
 * `name` ("views", "lights"). Errors, on the log: BTF_ERROR_UNSUPPORTED (a spline through two, or through
 * directions that lie in one line of the plane), those of btf_material_create, BTF_ERROR_MEMORY. */
btf_result enc_interpolator_create(const enc_context *context, const char *name,
                                   const enc_direction *directions, int count, enc_interpolation kind,
                                   enc_interpolator **out_interpolator);
void enc_interpolator_destroy(enc_interpolator **interpolator);

/* Finds the weights in direction `to`, a unit vector above the horizon. Thread-safe. */
void enc_interpolator_weights(const enc_interpolator *interpolator, const float to[3],
                              enc_weights *out_weights);

/* Degrees from `to` to the nearest of the directions. */
double enc_nearest_angle(const enc_direction *directions, int count, const float to[3]);

#endif
