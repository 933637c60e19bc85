/* A first guess of heights: a plane sweep along the views (Collins 1996), and semi-global matching.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RELIEF_SWEEP_H
#define OPENBTF_ENCODER_RELIEF_SWEEP_H

#include "images.h"

/* Heights of the surface that the view from the top shows, out [texel] in texels of the images, within
 * -reach..reach. Views with a theta of 10 to 65 degrees are compared with the top one. The same bits for
 * any number of threads. Errors, not logged: BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_relief_sweep(const enc_context *context, const enc_relief_images *images,
                            const enc_direction *views, int top_view, int reach, float *out);

#endif
