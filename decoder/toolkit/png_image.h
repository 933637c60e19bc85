/* PNG images through libpng: writing RGB, and reading every kind.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_PNG_IMAGE_H
#define OPENBTF_TOOLS_PNG_IMAGE_H

#include "decoder/pixels/image_info.h"

#include <openbtf/result.h>
#include <stddef.h>

/* Writes rgb[row][column][3], row 0 at the top, values as they shall be seen (sRGB-coded: the file says
 * so). The file is whole or absent (output.h). Thread-safe. Errors, named on log: BTF_ERROR_IO,
 * BTF_ERROR_MEMORY. */
btf_result png_image_write8(const char *path, int width, int height, const unsigned char *rgb, btf_log log);

/* The same with 16 bits a channel. */
btf_result png_image_write16(const char *path, int width, int height, const unsigned short *rgb,
                             btf_log log);

/* Decodes a PNG held in memory: pixels[row][column][channels], row 0 at the top, as coded (no gamma is applied), of
 * unsigned char (*out_depth 8) or unsigned short (16). Palettes and grey of less than 8 bits are expanded, alpha is
 * dropped; channels is 1 or 3. *info takes what cICP, iCCP, sRGB, or gAMA and cHRM say of the colours, and notes. A
 * truncated or damaged file is an error. At most max_pixels pixels. *out_pixels is malloc'ed, the caller frees. On
 * failure message[message_size] says what was wrong. Errors: BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (size, an
 * EXIF orientation other than 1), BTF_ERROR_MEMORY. */
btf_result png_image_read(const void *data, size_t size, size_t max_pixels, int *out_width, int *out_height,
                          int *out_channels, int *out_depth, void **out_pixels, image_info *info,
                          char *message, size_t message_size);

#endif
