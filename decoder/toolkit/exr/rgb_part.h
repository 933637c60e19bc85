/* Writes the one part of an RGB picture through OpenEXRCore.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_EXR_RGB_PART_H
#define OPENBTF_TOOLS_EXR_RGB_PART_H

#include <openexr.h>
#include <stdbool.h>

/* Adds to a file that exr_start_write() has begun its header and all scan lines of rgb[row][column][3], row 0 at
 * the top, as channels R, G, B of float, or of half, whose range the values must not leave; lossless ZIP. */
exr_result_t exr_rgb_part_write(exr_context_t context, int width, int height, const float *rgb, bool half);

#endif
