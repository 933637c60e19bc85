/* Short lists: a texel takes its sources and gains, in all views, from a list of a few.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_MATCH_LISTS_H
#define OPENBTF_ENCODER_FACTOR_MATCH_LISTS_H

#include "match.h"
#include "matrix.h"

/* Where profiles lie in their view's leading directions, as a search leaves it. */
typedef struct enc_match_coordinates {
    size_t k;
    float *query, *source; /* [view][texel][k] of the samples, of what the factors say */
    float *norm;           /* [view][texel] squared lengths of sources */
} enc_match_coordinates;

/* Room for all views. Errors: BTF_ERROR_MEMORY. */
btf_result enc_match_coordinates_create(const enc_factor_matrix *matrix, size_t k,
                                        enc_match_coordinates *out_coordinates);
void enc_match_coordinates_clear(enc_match_coordinates *coordinates);

/* Chooses for each texel, among the pairs of source and gain that its views have, the `entries` that leave
 * the least error one after the other, and gives each view the best of them. Users are counted anew.
 * *out_error is what is left, as a search counts it. Errors: BTF_ERROR_MEMORY. */
btf_result enc_match_restrict(const enc_factor_matrix *matrix, const enc_match_coordinates *at,
                              size_t entries, enc_match *io_match, double *out_error);

#endif
