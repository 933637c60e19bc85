/* The choice among plans of few units, by trial.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_CHOOSE_PLAN_H
#define OPENBTF_ENCODER_FACTOR_CHOOSE_PLAN_H

#include "components.h"
#include "encoder/allocation/allocate.h"

enum { ENC_CHOOSE_MOST_UNITS = 4 }; /* a plan of more units stays as it is */

/* Replaces a plan of at most ENC_CHOOSE_MOST_UNITS units by the one within `budget` that leaves the least
 * error of the components once they are rounded, with one round of descent, or none where `sweeps` is 0.
 * Trials read no samples. The same plan for any number of threads and ranks. Errors: BTF_ERROR_MEMORY,
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_choose_plan(const enc_factor_matrix *matrix,
                           const enc_components components[ENC_FACTOR_CHANNELS], uint64_t budget,
                           int sweeps, enc_factor_plan *io_plan);

#endif
