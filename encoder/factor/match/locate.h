/* Coordinates of profiles in the leading directions of their view, in which a search takes distances.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_MATCH_LOCATE_H
#define OPENBTF_ENCODER_FACTOR_MATCH_LOCATE_H

#include "encoder/factor/codes.h"
#include "lists.h"

enum {
    ENC_MATCH_LEADING = 48, /* directions of a view's profiles in which distances are taken */
};

/* Orthonormal rows that span the leading directions of each view's profiles: [view][leading][channel,
 * light]. */
typedef struct enc_match_bases {
    size_t leading, length; /* length: channels times lights */
    float *basis;
} enc_match_bases;

/* Finds the bases from at most 512 texels, spread over the texture. Ranks share the views here and in the
 * functions below, where all of them meet unless the context has no ranks. Errors: BTF_ERROR_MEMORY,
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_match_find_bases(const enc_factor_matrix *matrix, enc_match_bases *out_bases);
void enc_match_bases_clear(enc_match_bases *bases);

/* Find the coordinates of the points of a block, or of its sources, in all views, in the room that
 * enc_match_coordinates_create made. Errors: BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_match_locate_points(const enc_factor_matrix *matrix, const enc_match_bases *bases,
                                   const enc_match *match, enc_match_coordinates *io_coordinates);
btf_result enc_match_locate_sources(const enc_factor_matrix *matrix, const enc_factor_codes *codes,
                                    const enc_match_bases *bases, const enc_match *match,
                                    enc_match_coordinates *io_coordinates);

/* The result of a step of a search: BTF_ERROR_MEMORY, with a message, unless there was `room` for it;
 * BTF_ERROR_INTERRUPTED where the user wants to stop. */
btf_result enc_match_outcome(const enc_factor_matrix *matrix, bool room);

#endif
