/* Optical flow between two images of one light: the step that the vote repeats.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_FLOW_PAIR_H
#define OPENBTF_ENCODER_PAPER_FLOW_PAIR_H

#include "encoder/base/opencv_bridge.h"
#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* An image made ready: black when it holds no light. */
typedef struct enc_flow_image {
    float *relative; /* [texel] luminance over its mean */
    float *root;     /* [texel] square root of luminance, of mean 100 */
    bool black;
    /* How it lies canonically: mirrored so that its left and its upper half are the brighter ones, then
     * transposed if rows differ more than columns. Depends on what it shows, not on how that lies. */
    bool flip_columns, flip_rows, transpose;
} enc_flow_image;

/* The scratch memory of one thread for pairs of one size. */
typedef struct enc_flow_worker {
    int width, height, padding;
    int scale; /* enlargement before the flow, 1 or 2 */
    enc_cv_flow *dis;
    unsigned char *grey[2]; /* [padded row][padded column]: a pair as OpenCV takes it */
    float *field;           /* [padded row][padded column][2] */
    float *back;            /* [texel][2] */
    float *plane;           /* [texel] */
    float *tall, *wide;     /* enlarged by rows, and by both */
} enc_flow_worker;

/* `padding` texels of continuation on each side. On failure the worker is still to be cleared.
 * Errors: BTF_ERROR_MEMORY. */
btf_result enc_flow_worker_create(int width, int height, int padding, int scale,
                                  enc_flow_worker *out_worker);
void enc_flow_worker_clear(enc_flow_worker *worker);

/* Makes an image for the flow from luminance[texel] >= 0. On failure the image is still to be cleared. Errors:
 * BTF_ERROR_MEMORY. */
btf_result enc_flow_image_create(int width, int height, const float *luminance, enc_flow_image *out_image);
void enc_flow_image_clear(enc_flow_image *image);

/* Finds the flow of a pair: out_flow[texel][2] = (columns, rows), target(x) ~ top(x + flow(x)), not
 * wrapped. With a first estimate (forward and backward[texel][2], see flow_prior.h, else NULL), the flow is
 * that of the target towards the top image warped by it, and the estimate is added. out_hidden[texel] = 1
 * where forward and backward flow miss by more than `miss` texels, or relative luminances differ by more
 * than `difference` of the larger one. A black image gives zeros. OpenCV's flow goes through an image from
 * its top left, and finds something else in the same pair mirrored or turned. So every pair is first turned
 * to the canonical orientation of its target: if a pair is mirrored, turned by quarters or transposed, so
 * is its flow, but for rounding. Errors: BTF_ERROR_INTERNAL (OpenCV). */
btf_result enc_flow_pair_compute(enc_flow_worker *worker, const enc_flow_image *target,
                                 const enc_flow_image *top, const float *forward, const float *backward,
                                 float miss, float difference, float *out_flow, uint8_t *out_hidden);

#endif
