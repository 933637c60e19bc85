/* A first estimate of the shifts of one view from all lights at once: where the flow of every light starts.
 *
 * A point at height h over the reference plane shows, in a view at (theta, phi), at
 *   x = P - h tan(theta) (cos phi, sin phi),
 * so its shift towards the top view lies on one line for the whole view, and one number a texel is to be
 * found. All lights share it (paper 2.3.1: "the surface point we look at will not be changed no matter where
 * the light is located"), and their shadows and colours together tell points apart that look alike in any
 * single pair of images. Semi-global matching (Hirschmüller 2008) on the periodic tile chooses the number.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_FLOW_PRIOR_H
#define OPENBTF_ENCODER_PAPER_FLOW_PRIOR_H

#include "encoder/data/data.h"

/* Images made comparable between views: [light][channel][texel], square roots over their mean. */
typedef struct enc_flow_planes {
    int width, height, n_lights;
    float *values;
} enc_flow_planes;

/* Makes the planes of one view from images[light][texel][3], as enc_data_view gives them, under the lights
 * `chosen`[n_chosen]. A black image becomes zeros. Errors: BTF_ERROR_MEMORY. */
btf_result enc_flow_planes_create(int width, int height, const float *images, int n_chosen,
                                  const int *chosen, enc_flow_planes *out_planes);
void enc_flow_planes_clear(enc_flow_planes *planes);

/* Finds, for every texel of the view, the shift along the view's line under which all its lights agree best
 * with the top view: out_forward[texel][2] = (columns, rows), target(x) ~ top(x + forward(x)); and the same
 * for every texel of the top view, out_backward: top(x) ~ target(x + backward(x)). Texels are taken as
 * square. Heights from `depth` below to `rise` above the plane are tried, in tiles (the longer side), as
 * far as shifts stay below half the tile and 127 texels. Not wrapped; fractions of a texel are by a
 * parabola. Where nothing but rounding tells shifts apart (no texture), it is the smallest. Any thread.
 * Errors: BTF_ERROR_MEMORY. */
btf_result enc_flow_prior(const enc_flow_planes *target, const enc_flow_planes *top,
                          const enc_direction *view, float depth, float rise, float *out_forward,
                          float *out_backward);

#endif
