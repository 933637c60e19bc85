/* Peers: principal components of the BTF matrix (rows texels, columns view x channel x light; no mean
 * removed), on linear, sRGB-coded or square-root values, in half floats or bytes, whole or cluster by
 * cluster.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_PCA_H
#define OPENBTF_TESTS_BENCH_PCA_H

#include "encoder/data/images.h"

typedef enum pca_coding { PCA_LINEAR = 0, PCA_SRGB = 1, PCA_SQRT = 2 } pca_coding;
typedef enum pca_number { PCA_HALF = 0, PCA_BYTE = 1 } pca_number;

/* The columns of a factorisation: all three colour channels, or one axis of opponent colour, on which
 * channels are turned by the orthonormal matrix pca_axes: brightness, red against blue, green against both. */
typedef enum pca_plane { PCA_RGB = -1, PCA_LUMA = 0, PCA_RED_BLUE = 1, PCA_GREEN = 2 } pca_plane;
extern const float pca_axes[3][3]; /* [axis][R, G, B] */

/* The best `rank` components of the data clipped to [0, 1] and coded: coded value = u * v. */
typedef struct pca_factors {
    const enc_data *data;
    pca_coding coding;
    pca_plane plane;
    size_t texels, columns, rank;
    float *u; /* [texel][rank], columns of falling norm */
    float *v; /* [rank][column], orthonormal rows; column = (view * 3 + channel) * n_lights + light, of one
                 axis view * n_lights + light */
} pca_factors;

/* By randomised subspace iteration with 3 power steps and a fixed seed (Halko, Martinsson and Tropp 2011,
 * algorithm 4.4). rank is lowered to what the data allow. The same bits for any number of threads. Errors:
 * BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED. */
btf_result pca_factorise(const enc_context *context, const enc_data *data, pca_coding coding, size_t rank,
                         pca_factors *out_factors);
/* Factorises some texels only: u[i] belongs to list[i], `data` texels in any order; NULL: all. */
btf_result pca_factorise_texels(const enc_context *context, const enc_data *data, const uint32_t *list,
                                size_t count, pca_coding coding, size_t rank, pca_factors *out_factors);
/* Factorises all texels on one axis of opponent colour. */
btf_result pca_factorise_plane(const enc_context *context, const enc_data *data, pca_plane plane,
                               pca_coding coding, size_t rank, pca_factors *out_factors);
void pca_factors_clear(pca_factors *factors);

/* One texel's samples, coded: out has the columns of `plane`. */
void pca_encode_samples(const enc_data *data, pca_coding coding, pca_plane plane, const float *samples,
                        float *out);

/* Rounded factors, one v a cluster: what a decoder would hold. */
typedef struct pca_codec {
    const enc_data *data;
    pca_coding coding;
    size_t columns, rank, clusters;
    uint32_t *order; /* [texel]: texels, cluster after cluster */
    size_t *first;   /* [clusters + 1]: where a cluster starts in order */
    float *u;        /* [position in order][rank] rounded */
    float *v;        /* [cluster][rank][column] rounded */
    size_t bytes;
} pca_codec;

/* GPU bytes of `rank` components a cluster: u and v; for bytes also a float scale for each column of u and
 * row of v; for clusters also a byte a texel. */
size_t pca_bytes(const enc_data *data, pca_number number, size_t clusters, size_t rank);
/* The largest rank that fits `budget`; 0: none. */
size_t pca_rank_for(const enc_data *data, pca_number number, size_t clusters, size_t budget);

/* The first `rank` components (at most those there are), rounded. Errors: BTF_ERROR_MEMORY. */
btf_result pca_encode(const enc_context *context, const pca_factors *factors, pca_number number,
                      size_t rank, pca_codec *out_codec);

/* Components cluster by cluster: `clusters` (1..256) groups of texels with `rank` components each. Texels
 * go where their reconstruction is best (vector-quantised PCA: Kambhatla and Leen 1997; for BTFs Mueller,
 * Meseth and Klein 2003), found in the space of the first 64 of `factors`; then each group is factorised in
 * full. Errors: BTF_ERROR_USAGE, those of pca_factorise. */
btf_result pca_encode_clusters(const enc_context *context, const pca_factors *factors, pca_number number,
                               size_t clusters, size_t rank, pca_codec *out_codec);
void pca_codec_clear(pca_codec *codec);

/* The decoded images; `codec` must outlive the source. */
enc_image_source pca_images(const pca_codec *codec);

#endif
