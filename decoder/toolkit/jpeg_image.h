/* JPEG images through libjpeg: writing, and reading that takes no damaged file for a good one.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_JPEG_IMAGE_H
#define OPENBTF_TOOLS_JPEG_IMAGE_H

#include "decoder/pixels/image_info.h"

#include <openbtf/result.h>
#include <stddef.h>

/* Decodes a JPEG held in memory: pixels[row][column][channels], row 0 at the top, channels 1 (grey) or 3
 * (RGB) as coded; baseline, progressive or arithmetic-coded. Damage that libjpeg would paint over with grey
 * (a truncated file, a bad code) is an error; a header that breaks a rule without harm to the pixels, and a
 * colour profile that is not sRGB, leave a note in *info. At most max_pixels pixels. *out_pixels is malloc'ed, the
 * caller frees. On failure message[message_size] says what was wrong. Errors: BTF_ERROR_BAD_FILE,
 * BTF_ERROR_UNSUPPORTED (CMYK, an EXIF orientation other than 1, size), BTF_ERROR_MEMORY. */
btf_result jpeg_image_read(const void *data, size_t size, size_t max_pixels, int *out_width,
                           int *out_height, int *out_channels, unsigned char **out_pixels, image_info *info,
                           char *message, size_t message_size);

/* Writes rgb[row][column][3], sRGB-coded, at `quality` 1..100, chroma not subsampled. The file is whole or
 * absent (output.h). Thread-safe. Errors, named on log: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result jpeg_image_write(const char *path, int width, int height, const unsigned char *rgb, int quality,
                            btf_log log);

#endif
