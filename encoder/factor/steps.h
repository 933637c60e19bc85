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

/* Components of the three channels, and the plan for them, if they are kept; whether they are. Nothing is
 * left in the outputs otherwise. */
bool enc_factor_take_components(const enc_factor_matrix *matrix, int number,
                                enc_components out_components[ENC_FACTOR_CHANNELS],
                                enc_factor_plan *out_plan, enc_unspent *out_unspent);
/* Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result enc_factor_keep_components(const enc_factor_matrix *matrix, int number,
                                      const enc_components components[ENC_FACTOR_CHANNELS],
                                      const enc_factor_plan *plan, const enc_unspent *unspent);

/* Sources and gains, the components and the plan that go with them, and the share of the error that
 * enc_match_fit says. io_match is as enc_match_create makes it; where nothing is taken, all are as they
 * were. */
bool enc_factor_take_match(const enc_factor_matrix *matrix, int number, enc_match *io_match,
                           enc_components io_components[ENC_FACTOR_CHANNELS], enc_factor_plan *io_plan,
                           double *out_share);
btf_result enc_factor_keep_match(const enc_factor_matrix *matrix, int number, const enc_match *match,
                                 const enc_components components[ENC_FACTOR_CHANNELS],
                                 const enc_factor_plan *plan, double share);

/* A candidate, packed, or given up: then *out_factors is NULL. out_trial->match says which of the two is
 * meant. */
bool enc_factor_take_candidate(const enc_factor_matrix *matrix, int number, enc_factor_trial *io_trial,
                               enc_factors **out_factors);
btf_result enc_factor_keep_candidate(const enc_factor_matrix *matrix, int number,
                                     const enc_factor_trial *trial, const enc_factors *factors);

#endif
