/* Rounds components to levels so that the error at the samples is least.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_ROUND_H
#define OPENBTF_ENCODER_FACTOR_ROUND_H

#include "codes.h"

/* Rounds w to steps that fit it, one a group times a factor of the view, fits u to it and rounds that; then
 * rounds of coordinate descent on the codes of w and u in turn: each component goes to the level nearest to
 * its best value with the others held. In `sweeps` rounds the components that were found stand for the
 * samples, which costs a tenth; in half as many further rounds the samples are read, twice each. The
 * same bits for any number of threads and ranks. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED. */
btf_result enc_factor_round(const enc_factor_matrix *matrix,
                            const enc_components components[ENC_FACTOR_CHANNELS], int sweeps,
                            enc_factor_codes *io_codes);

/* Passes over the samples that enc_factor_round takes. */
int enc_factor_round_passes(int sweeps);

#endif
