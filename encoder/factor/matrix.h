/* The samples of a BTF as three matrices, one a channel of opponent colour, and their products with
 * factors.
 *
 * A value is the square root of a sample of radiance, cosine included. Channels are Y = (r + g + b) / sqrt
 * 3, C1 = (r - b) / sqrt 2, C2 = (r - 2 g + b) / sqrt 6 of the roots, so that squared errors add up. Rows
 * are texels, columns are view * n_lights + light. No matrix is ever held: each product reads the samples
 * once and splits them block by block.
 *
 * Factors lie component by component: u [rank][texel], w [rank][column]. Ranks (encoder/base/ranks.h) share
 * each product, all of which meet in it: by texels, or where the result is one of columns, by columns, so
 * that no sum is split. Products have the same bits for any number of threads and ranks.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_MATRIX_H
#define OPENBTF_ENCODER_FACTOR_MATRIX_H

#include "encoder/allocation/allocate.h"
#include "encoder/data/data.h"
#include "encoder/math/gemm.h"
#include "encoder/factor/match/match.h"

#include <stdint.h>

typedef struct enc_factor_matrix {
    const enc_context *context;
    const enc_data *data;
    /* NULL, or: rows are those of sources, each the sum of the samples of the texels that refer to it,
     * times their gains. Samples must be in memory then. */
    const enc_match *match;
    size_t texels, columns;
    const uint32_t *list; /* [texels] of the data, where the rows are some of them; NULL: all */
    float most;           /* radiance above is clipped to this */
    enc_gemm_tile tile;
} enc_factor_matrix;

/* The matrix of all texels, with radiance as it is up to 2^24: no file holds the scales of larger roots. */
enc_factor_matrix enc_factor_matrix_of(const enc_context *context, const enc_data *data);

/* Clips samples far brighter than other highlights, which would take all components: io_matrix->most
 * becomes ENC_FACTOR_HIGHLIGHTS times the radiance that all but a thousandth of the samples of up to 512
 * texels keep below, or 1 where that is more. Every rank does the same. Errors: those of the data,
 * BTF_ERROR_MEMORY. */
enum { ENC_FACTOR_HIGHLIGHTS = 16 };
btf_result enc_factor_clip(enc_factor_matrix *io_matrix);

/* Factors of each channel: rank[channel] components at factor[channel]. */
typedef struct enc_factor_set {
    size_t rank[ENC_FACTOR_CHANNELS];
    float *factor[ENC_FACTOR_CHANNELS];
} enc_factor_set;

/* Computes out [rank][texel] = w A^T of each channel. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO,
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_factor_times_w(const enc_factor_matrix *matrix, const enc_factor_set *w,
                              const enc_factor_set *out);
/* Computes out [rank][column] = u A of each channel. Errors as above. */
btf_result enc_factor_times_u(const enc_factor_matrix *matrix, const enc_factor_set *u,
                              const enc_factor_set *out);

/* Sums the squares of the residual A - u w of each channel, over the columns where `of_columns` [column] is
 * not 0. Errors as above. */
btf_result enc_factor_residual(const enc_factor_matrix *matrix, const enc_factor_set *u,
                               const enc_factor_set *w, const uint8_t *of_columns,
                               double out_sums[ENC_FACTOR_CHANNELS]);

/* Splits the roots of a texel's samples in one view into channels: out[channel] [n_lights]. Samples must be
 * in memory. */
void enc_factor_split_profile(const enc_factor_matrix *matrix, size_t texel, size_t view,
                              float *const out[ENC_FACTOR_CHANNELS]);

/* Bytes that a product takes at most beside the factors and the result, for factors of `rank` components in
 * all. */
uint64_t enc_factor_product_memory(size_t columns, size_t rank, int threads);

#endif
