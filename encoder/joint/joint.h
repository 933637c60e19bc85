/* `--method joint`: sources, shifts, gains and the residual found together, by alternating least squares
 * and search.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_JOINT_H
#define OPENBTF_ENCODER_JOINT_JOINT_H

#include "cost.h"
#include "encoder/data/data.h"
#include "encoder/model/solution.h"
#include "options.h"

/* Analyses `data`: chooses effects, SBRDF and number of components that serve best within the budget, and
 * fits them. The same data and options give the same solution for any number of threads. out_stats may be
 * NULL. Errors: BTF_ERROR_USAGE (a budget that holds nothing), BTF_ERROR_MEMORY, BTF_ERROR_IO,
 * BTF_ERROR_INTERRUPTED. On error *out_solution is zeroed. */
btf_result enc_joint(const enc_context *context, const enc_data *data, const enc_joint_options *options,
                     enc_solution *out_solution, enc_joint_stats *out_stats);

/* The cost of enc_joint with these options, by stage; only the extent of `data` is looked at. Rounds
 * that end early, since nothing is gained any more, are counted in full. */
joint_costs joint_cost_run(const enc_data *data, const joint_extent *extent,
                           const enc_joint_options *options);

#endif
