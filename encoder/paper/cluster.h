/* Clusters of hidden points: k-means in every view (paper 2.3.3).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_CLUSTER_H
#define OPENBTF_ENCODER_PAPER_CLUSTER_H

#include "encoder/data/data.h"
#include "encoder/model/occlusion.h"
#include <stdbool.h>

/* Cluster centres as FORMAT.md stores them: code c means the radiance (c * scale)^2. */
typedef struct enc_centres {
    int k; /* 0 without hidden points */
    int n_lights;
    float scale;    /* the largest centre has code 255, within 2^-24 .. 2^24 */
    uint8_t *codes; /* [centre][light][R, G, B] */
} enc_centres;

/* Zero means the default beside the field. */
typedef struct enc_cluster_options {
    int iterations;   /* of Lloyd's algorithm at most; default 30, fewer when nothing moves */
    bool linear;      /* distances and means of radiance instead of its square root; default false */
    bool data_points; /* centres are the data points nearest to the centroids; default false: centroids */
    uint64_t seed;    /* of the start; default 1 */
} enc_cluster_options;

/* Shares k_total centres among views in proportion to hidden[n_views] by largest remainder (ties: the lower
 * view), each view with hidden points getting at least 1, and none more than distinct[n_views], its number
 * of different hidden points: out_shares adds up to min(k_total, sum of distinct) exactly. Where k_total is
 * below the number of views with hidden points, those with most of them get one each. Where one of these bounds
 * holds, the other centres are shared in proportion among the other views. */
void enc_cluster_shares(int n_views, const size_t *hidden, const size_t *distinct, size_t k_total,
                        size_t *out_shares);

/* Finds at most k_total centres for the points that `occlusion` calls hidden, and fills occlusion->centre:
 * the nearest of the view's centres as stored in codes (of all centres where the view has none), the lowest
 * index among equals; 0 where not hidden. A view of more than 4096 hidden points is clustered in parts
 * (cluster_split.h) that share its centres in proportion, so that time is linear in texels. Centres of a
 * view are consecutive, views in order. A view's points are rows of n_lights * 3; k-means starts far apart
 * (k-means++, Arthur and Vassilvitskii 2007) from a fixed seed; an empty cluster restarts at the point
 * farthest from its centre. Every centre has its own start, so that k is min(k_total, sum over views of
 * different points). Memory: one view's profiles a thread. The stage is called "cluster". The same result
 * for any number of threads. Errors: BTF_ERROR_USAGE (k_total 0 with hidden points, or above 65536),
 * BTF_ERROR_MEMORY, BTF_ERROR_IO (scratch file), BTF_ERROR_INTERRUPTED. */
btf_result enc_cluster(const enc_context *context, const enc_data *data, const enc_cluster_options *options,
                       int k_total, enc_occlusion *occlusion, enc_centres **out_centres);
void enc_centres_destroy(enc_centres **centres);

#endif
