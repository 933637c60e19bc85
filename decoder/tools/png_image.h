/* Writing RGB images as PNG.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_PNG_IMAGE_H
#define OPENBTF_TOOLS_PNG_IMAGE_H

#include <openbtf/result.h>

/* Writes rgb[row][column][3], row 0 at the top, values as they shall be seen (sRGB-coded: the file says
 * so). The file is whole or absent (output.h). Thread-safe. Errors, named on log: BTF_ERROR_IO,
 * BTF_ERROR_MEMORY. */
btf_result png_image_write8(const char *path, int width, int height, const unsigned char *rgb, btf_log log);

/* The same with 16 bits a channel. */
btf_result png_image_write16(const char *path, int width, int height, const unsigned short *rgb,
                             btf_log log);

#endif
