/* Search: for every point the source and the gain whose profile is nearest.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_MATCH_SEARCH_H
#define OPENBTF_ENCODER_FACTOR_MATCH_SEARCH_H

#include "lists.h"

/* Finds sources and gains for the points of a block. A point changes its source only for a nearer one, its
 * gain being rounded; of equals the first wins. Along an axis of up to 64 texels every point looks at all
 * sources, along a longer one at those that every point of its tile of 16x16 texels reaches. Adds to
 * *io_energy the squares of the samples, as far as the leading directions tell. Users are not counted. The
 * same bits for any number of threads and ranks. Errors: BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_match_search(const enc_factor_matrix *matrix, const enc_match_coordinates *coordinates,
                            enc_match *io_match, double *io_energy);

#endif
