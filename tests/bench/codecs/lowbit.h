/* Peer: principal components of each axis of opponent colour, their factors in 8, 4 or 2 bits. The numbers
 * of components and their bits are allocated between axes and components at the least error for the bytes,
 * and the codes are rounded by coordinate descent on the error of the data. It searches nothing else: no
 * shifts, no gains, no reflectance model.
 *
 * value(x, v, l) = max(0, R [Y, C1, C2])^2, each channel a sum over its own components of u_j(x) w_j(v, l),
 * R the inverse of pca_axes.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_LOWBIT_H
#define OPENBTF_TESTS_BENCH_LOWBIT_H

#include "pca.h"

enum {
    LOWBIT_CLASSES = 9,     /* 8, 4 or 2 bits of w by 8, 4 or 2 bits of u */
    LOWBIT_MOST_RANK = 768, /* components an axis */
};

typedef struct lowbit_options {
    size_t budget;   /* bytes of codes and scales, at most */
    bool eight_only; /* every factor in 8 bits: split PCA without low bits */
    int sweeps;      /* rounds of descent on the codes of u and w; 0: rounded to the nearest */
} lowbit_options;

/* Rounded factors of one axis. */
typedef struct lowbit_plane {
    size_t rank;
    uint8_t *bits_u, *bits_w; /* [rank] 8, 4 or 2 */
    float *u;                 /* [rank][texel], as decoded */
    float *w;                 /* [rank][column], as decoded; column = view * n_lights + light */
} lowbit_plane;

typedef struct lowbit_codec {
    const enc_data *data;
    lowbit_plane plane[3];
    size_t bytes;
} lowbit_codec;

/* Encodes `data`, whose samples are in memory (clipped to [0, 1]). The same bits for any number of threads.
 * The working set is two matrices of texels by views by lights and the factors. Errors: BTF_ERROR_MEMORY,
 * also for samples that are not in memory; BTF_ERROR_USAGE, a budget that holds no component;
 * BTF_ERROR_INTERRUPTED. */
btf_result lowbit_encode(const enc_context *context, const enc_data *data, const lowbit_options *options,
                         lowbit_codec *out_codec);
void lowbit_codec_clear(lowbit_codec *codec);

/* Components of an axis, or of all of them for PCA_RGB. */
size_t lowbit_rank(const lowbit_codec *codec, pca_plane plane);

/* The decoded images; `codec` must outlive the source. */
enc_image_source lowbit_images(const lowbit_codec *codec);

#endif
