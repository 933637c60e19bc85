/* RGB images in OpenEXR files through OpenEXRCore.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_EXR_IMAGE_H
#define OPENBTF_TOOLS_EXR_IMAGE_H

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>

/* A decoded image: pixels[row][column][channel], linear, row 0 at the top. */
typedef struct exr_image {
    int width, height;
    int channels;  /* 1 (Y) or 3 */
    bool xyz;      /* the channels are named X, Y, Z instead of R, G, B */
    float *pixels; /* malloc'ed, the caller frees */
} exr_image;

/* Decodes the first part of an EXR file held in memory: scan lines or the full level of tiles; channels R,
 * G, B, or X, Y, Z, or luminance Y and chroma RY, BY, or Y alone, of half, float or integer samples; the
 * data window. Chroma may be sampled by 2 along either axis; other channels are ignored. At most max_pixels pixels. On failure message[message_size] says what was wrong. Errors:
 * BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (deep data, other channels, other subsampling, B44 or DWA
 * compression, size), BTF_ERROR_MEMORY. */
btf_result exr_image_read(const void *data, size_t size, size_t max_pixels, exr_image *out_image,
                          char *message, size_t message_size);

/* Writes rgb[row][column][3] (linear, row 0 at the top) as channels R, G, B of float, or of half, where
 * values beyond +-65504 become that. Lossless ZIP. The file is whole or absent (output.h). Thread-safe.
 * Errors, named on log: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result exr_image_write(const char *path, int width, int height, const float *rgb, bool half,
                           btf_log log);

#endif
