/* A data set with fitted values at its nodes in the place of its samples.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NODES_APPLY_H
#define OPENBTF_ENCODER_NODES_APPLY_H

#include "warp.h"

/* Weights of the samples at the nodes, fit.h. */
typedef struct enc_node_tables {
    int n_views, n_lights;
    float *views;  /* [n_views][n_views] */
    float *lights; /* [n_lights][n_lights] */
    bool roots;    /* decoders blend roots of radiance; false: radiance */
} enc_node_tables;

/* A surface along which views are shifted before they are blended. */
typedef struct enc_node_relief {
    const enc_warp *surface; /* of the data's size */
    const uint8_t *views;    /* [n_views] 1: the decoder shifts around this view, so that its values follow the shift */
} enc_node_relief;

/* Makes a new data set, in which each texel's F [view][light], of roots or of radiance, is replaced by
 * views F lights^T; the old one stays as it is. Roots may come out negative: such samples hold minus their
 * square, and readers that take roots restore the sign; radiance below 0 becomes 0. Samples lie in memory
 * where the allowed memory holds both sets, else in a scratch file; texels go through one at a time. Ranks
 * share the work; the bits are the same for any number of them and of threads. With `relief`, which may be
 * NULL and wants the samples in memory, a node around which the decoder shifts is fitted to views of the
 * same point: F'(x, a) = sum over b of W(a, b) o_b F(x_b, b) + (1 - sum W o) F(x, a), where view b shows at
 * x_b, by steep fetches, the point that view a shows at x, and o_b is the share of view b that a higher
 * point there leaves. Weights W below 0.01 are left out, and the others divided by their sum.
 * out_data->original is `data`, which must outlive it. Stage "fit nodes". Errors: those of enc_data_create
 * and of the data, BTF_ERROR_INTERRUPTED. */
btf_result enc_node_apply(const enc_context *context, const enc_node_tables *tables, const enc_node_relief *relief,
                          const enc_data *data, enc_data **out_data);

#endif
