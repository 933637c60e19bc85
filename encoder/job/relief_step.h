/* Relief and gloss as a step of a checkpoint.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOB_RELIEF_STEP_H
#define OPENBTF_ENCODER_JOB_RELIEF_STEP_H

#include "encoder/data/checkpoint.h"
#include "encoder/relief/relief.h"

enum { ENC_RELIEF_REASON = 96 };

/* Takes the choice if the checkpoint has it: then *out_taken is true, and *out_choice and *out_store are
 * what enc_relief_choose gave, with out_choice->reason in `reason`; else they are empty. The ranks meet.
 * Errors, on the log: BTF_ERROR_USAGE (there is a relief, which the steps after it were found with, but the
 * samples no longer lie in memory). */
btf_result enc_relief_step_take(const enc_context *context, const enc_data *data, bool *out_taken,
                                enc_relief_choice *out_choice, char reason[ENC_RELIEF_REASON],
                                enc_relief_store *out_store);
/* Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result enc_relief_step_keep(const enc_context *context, const enc_data *data,
                                const enc_relief_choice *choice, const enc_relief_store *store);

#endif
