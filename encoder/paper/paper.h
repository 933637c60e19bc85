/* `--method paper`: the analysis of sections 2 and 3.1 as printed, stage after stage.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_PAPER_H
#define OPENBTF_ENCODER_PAPER_PAPER_H

#include "encoder/model/solution.h"
#include "options.h"

/* Runs fit, shadow, flow, refinement and clustering. out_occlusion may be NULL; it is set when flow ran.
 * Errors: those of the stages. On error *out_solution is zeroed. */
btf_result enc_paper(const enc_context *context, const enc_data *data, const enc_paper_options *options,
                     enc_solution *out_solution, enc_occlusion **out_occlusion, enc_paper_stats *out_stats);

#endif
