/* A data set with fitted values at its nodes in the place of its samples.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NODES_APPLY_H
#define OPENBTF_ENCODER_NODES_APPLY_H

#include "encoder/data/data.h"

/* Weights of the samples at the nodes, fit.h. */
typedef struct enc_node_tables {
    int n_views, n_lights;
    float *views;  /* [n_views][n_views] */
    float *lights; /* [n_lights][n_lights] */
    bool roots;    /* what decoders blend: roots of radiance, or radiance */
} enc_node_tables;

/* views F lights^T of each texel's F, roots or radiance by view and light, as a new data set that leaves the
 * old one as it is. Roots may come out negative: such samples hold minus their square, and who takes roots
 * of them gives these their sign; radiance below 0 becomes 0. Samples lie in memory where the allowed memory
 * holds both sets, else in a scratch file; texels go through one at a time. Ranks share the work; the bits
 * are the same for any number of them and of threads. out_data->original is `data`, which must outlive it.
 * Stage "fit nodes". Errors: those of enc_data_create and of the data, BTF_ERROR_INTERRUPTED. */
btf_result enc_node_apply(const enc_context *context, const enc_node_tables *tables, const enc_data *data,
                          enc_data **out_data);

#endif
