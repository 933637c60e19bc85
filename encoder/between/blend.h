/* Images of a data set at directions between its samples: the best that any compression could reach by the same
 * interpolation.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_BLEND_H
#define OPENBTF_ENCODER_BLEND_H

#include "encoder/nodes/interpolate.h"
#include "pairs.h"

typedef struct enc_blend enc_blend;

/* The kinds nearest and linear blend radiance, views and lights each by three weights; the splines blend
 * square roots of radiance, over all views and all lights (a result below 0 is 0). `data` must outlive the
 * blend. Errors: those of enc_interpolator_create. */
btf_result enc_blend_create(const enc_context *context, const enc_data *data, enc_interpolation kind,
                            enc_blend **out_blend);
void enc_blend_destroy(enc_blend **blend);

/* The images of `count` pairs: out[pair][texel][3]. Every sample is touched once, whatever the count, so
 * many pairs at a time are cheaper. Deterministic for any number of threads. Errors: those of the data,
 * BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_blend_images(const enc_context *context, const enc_blend *blend, const enc_pair *pairs,
                            size_t count, float *out);

#endif
