/* Optical flow between two images of one light: the step that the vote repeats.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FLOW_PAIR_H
#define OPENBTF_ENCODER_FLOW_PAIR_H

#include "opencv_bridge.h"
#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* An image made ready: black when it holds no light. */
typedef struct enc_flow_image {
    float *relative;     /* [texel] luminance over its mean */
    float *root;         /* [texel] square root of luminance, of mean 100 */
    unsigned char *grey; /* `root` enlarged and continued periodically, as OpenCV takes it */
    bool black;
} enc_flow_image;

/* What one thread needs for pairs of one size. */
typedef struct enc_flow_worker {
    int width, height, padding;
    int scale; /* enlargement before the flow, 1 or 2 */
    int padded_width, padded_height;
    enc_cv_flow *dis;
    unsigned char *warped; /* [padded row][padded column] */
    float *field;          /* [padded row][padded column][2] */
    float *back;           /* [texel][2] */
    float *plane;          /* [texel] */
    float *tall, *wide;    /* enlarged by rows, and by both */
} enc_flow_worker;

/* `padding` texels of continuation on each side. On failure the worker is still to be cleared.
 * Errors: BTF_ERROR_MEMORY. */
btf_result enc_flow_worker_create(int width, int height, int padding, int scale,
                                  enc_flow_worker *out_worker);
void enc_flow_worker_clear(enc_flow_worker *worker);

/* From luminance[texel] >= 0. On failure the image is still to be cleared. Errors: BTF_ERROR_MEMORY. */
btf_result enc_flow_image_create(enc_flow_worker *worker, const float *luminance,
                                 enc_flow_image *out_image);
void enc_flow_image_clear(enc_flow_image *image);

/* Flow of a pair: out_flow[texel][2] = (columns, rows), target(x) ~ top(x + flow(x)), not wrapped. With a
 * first estimate (forward and backward[texel][2], see flow_prior.h, else NULL), the flow is that of the
 * target towards the top image warped by it, and the estimate is added.
 * out_hidden[texel] = 1 where forward and backward flow miss by more than `miss` texels, or relative
 * luminances differ by more than `difference` of the larger one. A black image gives zeros.
 * Errors: BTF_ERROR_INTERNAL (OpenCV). */
btf_result enc_flow_pair_compute(enc_flow_worker *worker, const enc_flow_image *target,
                                 const enc_flow_image *top, const float *forward, const float *backward,
                                 float miss, float difference, float *out_flow, uint8_t *out_hidden);

#endif
