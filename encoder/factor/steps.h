/* The steps of the factor encoder that a checkpoint keeps: components with their plan, match after its search, and
 * each candidate.
 *
 * A search for a quality encodes several times: `number` tells the encodes apart. The ranks meet in every
 * function that takes a step (checkpoint.h).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_STEPS_H
#define OPENBTF_ENCODER_FACTOR_STEPS_H

#include "pack.h"

/* Takes the components of the three channels, and the plan for them, if the checkpoint has them, and
 * returns whether it does. If not, the outputs stay empty. */
bool enc_factor_take_components(const enc_factor_matrix *matrix, int number,
                                enc_components out_components[ENC_FACTOR_CHANNELS],
                                enc_factor_plan *out_plan, enc_unspent *out_unspent);
/* Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result enc_factor_keep_components(const enc_factor_matrix *matrix, int number,
                                      const enc_components components[ENC_FACTOR_CHANNELS],
                                      const enc_factor_plan *plan, const enc_unspent *unspent);

/* Takes sources and gains, the components and the plan that go with them, and the share of the error that
 * enc_match_fit found. io_match must be as enc_match_create makes it; where nothing is taken, all stay as
 * they were. */
bool enc_factor_take_match(const enc_factor_matrix *matrix, int number, enc_match *io_match,
                           enc_components io_components[ENC_FACTOR_CHANNELS], enc_factor_plan *io_plan,
                           double *out_share);
btf_result enc_factor_keep_match(const enc_factor_matrix *matrix, int number, const enc_match *match,
                                 const enc_components components[ENC_FACTOR_CHANNELS],
                                 const enc_factor_plan *plan, double share);

/* Takes a candidate, packed, or given up, in which case *out_factors is NULL. io_trial->match says which of
 * the two candidates is meant, that with match or that without. */
bool enc_factor_take_candidate(const enc_factor_matrix *matrix, int number, enc_factor_trial *io_trial,
                               enc_factors **out_factors);
btf_result enc_factor_keep_candidate(const enc_factor_matrix *matrix, int number,
                                     const enc_factor_trial *trial, const enc_factors *factors);

#endif
