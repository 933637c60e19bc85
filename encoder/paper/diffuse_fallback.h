/* The last line of defence of method paper: a result no worse than the diffuse fit.
 *
 * Rejection leaves bright outliers in the fit and takes the dark samples around them for shadow; lobes,
 * shadow map, shifts and clusters that follow from such a fit can be worse than none at all.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_DIFFUSE_FALLBACK_H
#define OPENBTF_ENCODER_PAPER_DIFFUSE_FALLBACK_H

#include "encoder/model/solution.h"
#include "options.h"

/* Compares what was found (SBRDF, shadow map, centre codes of `solution`, shifts and hidden points of
 * `occlusion`, NULL: none) with the diffuse fit: of each texel the model without lobes that leaves the
 * least squared error over all its samples, and no other effect. Where what was found has the larger
 * squared error over the texels of enc_paper_sample, beyond rounding, every texel becomes its diffuse fit,
 * and the effects become none; without options->choose they stay as asked for, with maps that change
 * nothing: white shadows, no shift, no point hidden. Radiance is clipped to the power of two above 99.9 %
 * of the samples, 1 to 2^24, so that a few stray samples decide nothing. stats->diffuse tells, and so do a
 * warning and stats->trials. The same bits for any number of threads and ranks. Errors: BTF_ERROR_MEMORY,
 * BTF_ERROR_IO, BTF_ERROR_INTERRUPTED. */
btf_result enc_paper_fallback(const enc_context *context, const enc_data *data,
                              const enc_paper_options *options, enc_solution *solution,
                              enc_occlusion *occlusion, enc_paper_stats *stats);

#endif
