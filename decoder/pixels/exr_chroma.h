/* Luminance and chroma of OpenEXR files to RGB.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_PIXELS_EXR_CHROMA_H
#define OPENBTF_PIXELS_EXR_CHROMA_H

#include <openbtf/result.h>

/* pixels[height][width][3] hold RY = (R - Y) / Y, Y and BY = (B - Y) / Y, the chroma at every x_step-th
 * column and y_step-th row alone (steps 1 or 2). It is filled in between, and the pixels become R, G, B, as
 * OpenEXR's RgbaInputFile does it: its filter of 27 taps with replicated edges, then less saturation where
 * a pixel has more than its neighbours. weights: the luminance of R, G and B; the sum is 1. Errors:
 * BTF_ERROR_MEMORY. */
btf_result exr_chroma_to_rgb(int width, int height, int x_step, int y_step, const float weights[3],
                             float *pixels);

#endif
