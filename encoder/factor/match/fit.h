/* Sources, gains and factors found in turn.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_MATCH_FIT_H
#define OPENBTF_ENCODER_FACTOR_MATCH_FIT_H

#include "locate.h"

enum { ENC_MATCH_ROUNDS = 3, ENC_MATCH_CODE_ROUNDS = 4 };

/* Rounds of search and descent on unrounded factors, from the components of a plan. *io_components become
 * those of the factors found, by falling energy, and io_plan that of the least error within the budget,
 * which is for the factors alone. *out_share: the share of the squared error of the components alone that
 * one round and another search leave, in the leading directions of profiles; where it is more than `most`,
 * nothing follows, and components and plan stay. So it is where the first search leaves so much that `most`
 * is out of reach: *out_share is then what that leaves. `matrix` must have no match. The same bits for any
 * number of threads. Errors: BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_match_fit(const enc_factor_matrix *matrix, uint64_t budget, const enc_match_bases *bases,
                         double most, enc_match *io_match,
                         enc_components io_components[ENC_FACTOR_CHANNELS], enc_factor_plan *io_plan,
                         double *out_share);

/* Makes `rounds` rounds of search and descent on codes that enc_factor_round has begun. More than
 * ENC_MATCH_CODE_ROUNDS gain little. */
btf_result enc_match_round(const enc_factor_matrix *matrix, const enc_match_bases *bases, int rounds,
                           enc_match *io_match, enc_factor_codes *io_codes);

#endif
