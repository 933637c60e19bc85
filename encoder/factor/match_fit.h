/* Sources, gains and factors found in turn.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_MATCH_FIT_H
#define OPENBTF_ENCODER_FACTOR_MATCH_FIT_H

#include "match_search.h"

enum { ENC_MATCH_ROUNDS = 3, ENC_MATCH_CODE_ROUNDS = 4, ENC_MATCH_SURVEYED = 8 };

/* Rounds of search and descent on unrounded factors, from the components of a plan. *io_components become those of the
 * factors found, by falling energy, and io_plan that of the least error within the budget, which is for the factors
 * alone. matrix has no match. The same bits for any number of threads. Errors: BTF_ERROR_MEMORY,
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_match_fit(const enc_factor_matrix *matrix, uint64_t budget, const enc_match_bases *bases,
                         enc_match *io_match, enc_components io_components[ENC_FACTOR_CHANNELS],
                         enc_factor_plan *io_plan);

/* Whether a match may pay: a search of every ENC_MATCH_SURVEYED-th view with what the components found hold of a plan
 * that leaves room for the points. *out_ratio: the squared error that is thought to be left, over that of the whole
 * budget without a match. Errors: as enc_match_fit. */
btf_result enc_match_survey(const enc_factor_matrix *matrix, const enc_components components[ENC_FACTOR_CHANNELS],
                            uint64_t budget, bool gains, double *out_ratio);

/* Rounds of search and descent on codes, that enc_factor_round has begun. */
btf_result enc_match_round(const enc_factor_matrix *matrix, const enc_match_bases *bases, enc_match *io_match,
                           enc_factor_codes *io_codes);

#endif
