/* Reading Radiance HDR images (RGBE; G. Ward, "Real Pixels", Graphics Gems II, 1991).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_IMAGE_HDR_H
#define OPENBTF_ENCODER_IMAGE_HDR_H

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>

/* Decodes an image held in memory: out_pixels[row][column][3], linear, row 0 at the top, values divided by
 * the header's EXPOSURE (all of them multiplied together). *out_xyz: the file is XYZE. Flat, old and new
 * run-length coded scan lines; resolution strings -Y H +X W and +Y H +X W. At most max_pixels pixels.
 * *out_pixels is malloc'ed, the caller frees. On failure message[message_size] says what was wrong. Errors:
 * BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (other orientations, size), BTF_ERROR_MEMORY. */
btf_result enc_image_hdr_read(const void *data, size_t size, size_t max_pixels, int *out_width,
                              int *out_height, bool *out_xyz, float **out_pixels, char *message,
                              size_t message_size);

#endif
