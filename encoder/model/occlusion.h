/* The findings of the occlusion analysis for every (view, texel): its shift, whether it is hidden, its
 * cluster centre (paper 2.3). Made by flow.h, changed by refine.h and cluster.h, read by the packer.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_OCCLUSION_H
#define OPENBTF_ENCODER_MODEL_OCCLUSION_H

#include <openbtf/result.h>
#include <stddef.h>
#include <stdint.h>

/* All arrays are [view][texel], texel = row * width + column, row 0 at the top. A point x of view v that is
 * not hidden shows the surface point that the top view shows at x' = x + shift(x, v), wrapped over the
 * tile: motionVector of the paper, in whole texels. A hidden point keeps the best shift that was found (by
 * the vote, later by the refinement's search), for pictures and for files without hidden points. */
typedef struct enc_occlusion {
    int n_views;
    size_t n_texels;
    int8_t *shift;         /* [view][texel][2] = (columns, rows) */
    uint8_t *hidden;       /* 1: hidden, shown by a cluster centre; 0: shown by the shifted source */
    uint8_t *hidden_voted; /* `hidden` as the vote left it, before refinement (figure 11a) */
    float *ratio;          /* HiddenRatio, 0..1: share of the voted lights whose flow calls it hidden */
    uint16_t *centre;      /* global index of its cluster centre; valid where hidden, else 0 */
} enc_occlusion;

/* Makes one in which everything is 0: no shift, nothing hidden. Errors: BTF_ERROR_USAGE (sizes),
 * BTF_ERROR_MEMORY. */
btf_result enc_occlusion_create(int n_views, size_t n_texels, enc_occlusion **out_occlusion);
void enc_occlusion_destroy(enc_occlusion **occlusion);

/* Counts the hidden points of one view, or of all views when view < 0. */
size_t enc_occlusion_hidden_count(const enc_occlusion *occlusion, int view);

/* i modulo n, 0 .. n - 1 for negative i too. */
static inline int enc_occlusion_modulo(int i, int n) {
    const int r = i % n;
    return r < 0 ? r + n : r;
}

/* Texel index of `texel` moved by (columns, rows), wrapped. Any shift. */
size_t enc_occlusion_source(int width, int height, size_t texel, int columns, int rows);

/* The representative of `delta` modulo `size` of least magnitude, so within -128..127 for sizes up to
 * 256; of two equal magnitudes the positive one, unless it is 128. Larger sizes: the caller keeps
 * |delta| <= 127. */
int enc_occlusion_wrap(int delta, int size);

/* -1, 0, 1: shift a is preferred to b where nothing else decides: the shorter one, then the smaller row,
 * then the smaller column. */
int enc_occlusion_compare_shift(const int8_t a[2], const int8_t b[2]);

#endif
