/* `--effects auto` of method paper: what each effect removes of the error, on a sample of texels.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_EFFECTS_H
#define OPENBTF_ENCODER_PAPER_EFFECTS_H

#include "method_paper.h"

enum { ENC_PAPER_PROBE_LIGHTS = 3 }; /* whose flows are the probe's */

/* Mean squared error, of radiance clipped to [0, 1], of SBRDF, shadow map, centre codes of `solution` and
 * shifts, hidden points of `occlusion` (NULL: none) when decoded with `effects`, over up to 256 texels
 * evenly spaced. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO. */
btf_result enc_paper_error(const enc_context *context, const enc_data *data, const enc_solution *solution,
                           const enc_occlusion *occlusion, uint32_t effects, double *out_error);

/* Whether shifts or hidden points promise to gain anything: flows of so few lights, which take a small part
 * of the time of all, as shifts on the sample, and the share of points that they hide. False where they
 * gain less than the tolerance and hide less than one point in a hundred. */
btf_result enc_paper_probe(const enc_context *context, const enc_data *data,
                           const enc_paper_options *options, const enc_solution *solution,
                           enc_paper_stats *stats, bool *out_promising);

/* Leaves out effects one by one, each time the one that costs least, while it costs less than the
 * tolerance: changes solution->effects alone. Notes every set that was tried in stats. */
btf_result enc_paper_choose(const enc_context *context, const enc_data *data,
                            const enc_paper_options *options, enc_solution *solution,
                            const enc_occlusion *occlusion, enc_paper_stats *stats);

#endif
