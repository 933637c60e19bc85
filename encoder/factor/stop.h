/* Where more bytes stop paying at samples that are left out of the fit.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_STOP_H
#define OPENBTF_ENCODER_FACTOR_STOP_H

#include "encoder/allocation/allocate.h"
#include "encoder/model/trial.h"
#include "signal.h"

#define ENC_STOP_MORE 1.1 /* so many times the bytes must gain the tolerance to pay */

/* Makes the plan of the most bytes within `budget` of which the last tenth still gains `tolerance` dB at
 * left-out samples, as `signal` predicts. Its bytes are then given to components by their energies in all
 * samples, which are what a user compares. Returns false where not one unit fits, or out of memory. */
bool enc_stop_allocate(const enc_factor_energies *energies, const enc_signal *signal, size_t texels,
                       size_t n_views, size_t n_lights, uint64_t budget, double tolerance,
                       enc_factor_plan *out_plan, enc_unspent *out_unspent);

#endif
