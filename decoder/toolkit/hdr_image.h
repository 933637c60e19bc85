/* Reading Radiance HDR images (RGBE; G. Ward, "Real Pixels", Graphics Gems II, 1991).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_HDR_IMAGE_H
#define OPENBTF_TOOLS_HDR_IMAGE_H

#include "decoder/pixels/image_info.h"

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>

/* Decodes an image held in memory: out_pixels[row][column][3], linear, row 0 at the top, values divided by
 * the header's EXPOSURE and COLORCORR (all of them multiplied together; 0 is 1). *out_xyz: the file is XYZE.
 * Flat, old and new run-length coded scan lines; all eight orders of the axes, of which "+X W -Y H" is that of
 * ATRIUM's files (rows from the bottom) where the scan lines have W pixels or both sides are the same. Header
 * lines of any length, with blanks at their ends. The primaries that PRIMARIES names are left to the caller,
 * in *info, with notes of GAMMA, PIXASPECT and what else was met. At most max_pixels pixels. *out_pixels is
 * malloc'ed, the caller frees. On failure message[message_size] says what was wrong, and in which line.
 * Errors: BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (resolution line, size), BTF_ERROR_MEMORY. */
btf_result hdr_image_read(const void *data, size_t size, size_t max_pixels, int *out_width, int *out_height,
                          bool *out_xyz, float **out_pixels, image_info *info, char *message,
                          size_t message_size);

#endif
