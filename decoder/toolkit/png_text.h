/* Texts of PNG files, and the EXIF blocks and colour profiles that programs older than PNG's chunks for them
 * keep there.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_PNG_TEXT_H
#define OPENBTF_TOOLS_PNG_TEXT_H

#include <stddef.h>

/* Finds the text under a keyword, in a chunk tEXt, zTXt or iTXt anywhere in the file data[size], and returns at
 * most its first 256 KiB, *out_size bytes, to be freed with free; NULL where there is none, or no memory. */
unsigned char *png_text_find(const unsigned char *data, size_t size, const char *keyword, size_t *out_size);

/* Returns, in the same way, the bytes that the text "Raw profile type KIND" spells in hexadecimal digits, as
 * ImageMagick and ExifTool write EXIF ("exif", "APP1") and profiles ("icc"). */
unsigned char *png_text_raw_profile(const unsigned char *data, size_t size, const char *kind,
                                    size_t *out_size);

#endif
