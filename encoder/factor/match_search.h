/* Search: for every point the source and the gain whose profile is nearest.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_MATCH_SEARCH_H
#define OPENBTF_ENCODER_FACTOR_MATCH_SEARCH_H

#include "codes.h"
#include "match_lists.h"

enum {
    ENC_MATCH_LEADING = 48, /* directions of a view's profiles in which distances are taken */
};

/* Orthonormal rows that span the leading directions of each view's profiles: [view][leading][channel,
 * light]. */
typedef struct enc_match_bases {
    size_t leading, length; /* length: channels times lights */
    float *basis;
} enc_match_bases;

/* Finds the bases from at most 512 texels, spread over the texture. Ranks share the views here and in the functions below, and all
 * meet in them, except where the context has no ranks. Errors: BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_match_find_bases(const enc_factor_matrix *matrix, enc_match_bases *out_bases);
void enc_match_bases_clear(enc_match_bases *bases);

/* Coordinates of the points of a block, or of its sources, in all views; there is room for them. Errors:
 * BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_match_locate_points(const enc_factor_matrix *matrix, const enc_match_bases *bases,
                                   const enc_match *match, enc_match_coordinates *io_coordinates);
btf_result enc_match_locate_sources(const enc_factor_matrix *matrix, const enc_factor_codes *codes,
                                    const enc_match_bases *bases, const enc_match *match,
                                    enc_match_coordinates *io_coordinates);

/* Finds sources and gains for the points of a block. A point changes its source only for a nearer one, its
 * gain being rounded; of equals the first wins. Up to 64x64 texels every point looks at all sources, else at
 * those that all points of its tile of 16x16 reach. Adds to *io_energy the squares of the samples, as far as
 * the leading directions tell. Users are not counted. The same bits for any number of threads and ranks. Errors:
 * BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_match_search(const enc_factor_matrix *matrix, const enc_match_coordinates *coordinates,
                            enc_match *io_match, double *io_energy);

#endif
