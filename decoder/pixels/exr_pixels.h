/* Samples of one part of an OpenEXR file, unpacked here: OpenEXRCore reads and decompresses chunks.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_PIXELS_EXR_PIXELS_H
#define OPENBTF_PIXELS_EXR_PIXELS_H

#include <openexr.h>
#include <stdbool.h>
#include <stddef.h>

/* Where the samples of one channel go. A channel sampled xs x ys has a sample at every xs-th column and
 * ys-th row; its sample (i, j), from the top left, goes to out[i * stride + j * pitch]. */
typedef struct exr_target {
    float *out; /* NULL: nowhere */
    size_t stride, pitch;
    const float *weights; /* NULL: stored; else three, and out[0..2] += weights[0..2] * sample */
    bool *below_one;      /* NULL, or set to true where a sample is below 1 */
} exr_target;

/* Whether a channel's sampling is at least 1 x 1 and divides the window, its corner and its size. */
bool exr_sampling_fits(const exr_attr_chlist_entry_t *channel, const exr_attr_box2i_t *window);

/* Reads every chunk of a part, scan lines or the full level of tiles, whose data window is `window`.
 * targets: one for each channel, in the file's order. The channels' sampling has to fit (above), and be 1 x
 * 1 in tiles. Fails with EXR_ERR_BAD_CHUNK_LEADER where a chunk is not of the size that its channels call
 * for. */
exr_result_t exr_read_pixels(exr_const_context_t context, int part, const exr_attr_box2i_t *window,
                             bool tiled, const exr_target *targets);

#endif
