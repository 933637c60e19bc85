/* The sRGB curve.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MATH_SRGB_H
#define OPENBTF_ENCODER_MATH_SRGB_H

/* sRGB coding of [0, 1], clipped, as pictures and sRGB errors use it. */
float enc_srgb_encode(float linear);

#endif
