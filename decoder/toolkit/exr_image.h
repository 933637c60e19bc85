/* RGB images in OpenEXR files through OpenEXRCore.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_EXR_IMAGE_H
#define OPENBTF_TOOLS_EXR_IMAGE_H

#include "decoder/pixels/image_info.h"

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>

/* A decoded image: pixels[row][column][channel], linear, row 0 at the top. */
typedef struct exr_image {
    int width, height;
    int channels;  /* 1 (grey) or 3 */
    bool xyz;      /* the channels are named X, Y, Z instead of R, G, B */
    bool cube;     /* the file says that it holds the six faces of an environment map */
    float *pixels; /* malloc'ed, the caller frees */
} exr_image;

/* Decodes a picture of an EXR file held in memory: scan lines or the full level of tiles, of half, float or
 * integer samples; the data window. The channels are those of exr_choose.h: R, G, B; X, Y, Z; luminance and
 * chroma Y, RY, BY (sampled by 2 along either axis, exr_chroma.h), which come out as RGB; a spectrum, which
 * comes out as linear Rec. 709 (spectrum.h); or grey. `layer` may be NULL. The primaries that chromaticities
 * name are left to the caller, in *info, with the notes of what else was met. At most max_pixels pixels. On
 * failure message[message_size] says what was wrong. Errors: BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (deep
 * data, no plain choice of channels, other subsampling, B44 or DWA compression, an Orientation other than 1,
 * size), BTF_ERROR_MEMORY. */
btf_result exr_image_read(const void *data, size_t size, size_t max_pixels, const char *layer,
                          exr_image *out_image, image_info *info, char *message, size_t message_size);

/* Writes rgb[row][column][3] (linear, row 0 at the top) as channels R, G, B of float, or of half, where
 * values beyond +-65504 become that. Lossless ZIP. The file is whole or absent (output.h). Thread-safe.
 * Errors, named on log: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result exr_image_write(const char *path, int width, int height, const float *rgb, bool half,
                           btf_log log);

#endif
