/* One run of the joint method: the state and the steps that its parts share. Internal.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_RUN_H
#define OPENBTF_ENCODER_JOINT_RUN_H

#include "cost.h"
#include "fit.h"
#include "measure.h"
#include "options.h"

typedef struct joint_run {
    const enc_joint_options *options;
    joint_preset_values preset;
    uint64_t budget;
    double enough; /* error below which nothing more is sought */
    joint_rows rows;
    joint_fit plain; /* the plain factorisation, start and rival of the others */
    joint_fit best;  /* the best candidate; empty before there is one */
    double *energy;  /* [plain.model.k] of the plain components */
    enc_joint_stats *stats;
    double noted;      /* CPU time at the last note */
    joint_costs costs; /* predicted */
} joint_run;

enum { JOINT_REDUCE_ROUNDS = 3 }; /* after components were dropped for --quality */

/* A run before it begins: options, preset and budget for the extent of `data`, whose samples are not looked
 * at. */
joint_run joint_run_prepare(const enc_context *context, const enc_data *data,
                            const enc_joint_options *options);

/* Begins a stage of the run that is predicted to cost so much. */
void joint_run_stage(const joint_run *r, const char *name, double cost);

/* Components that `shape` may have. */
size_t joint_run_components(const joint_run *r, const joint_shape *shape);

/* Replaces *fit, its history and rounds by what a checkpoint holds of them; false when it holds nothing.
 * *out_over says whether the rounds had come to their end. */
bool joint_run_take(const joint_run *r, const char *step, joint_fit *fit, double *history, int *out_rounds,
                    bool *out_over);

/* Rounds until `count` are done, it is enough, or *io_over: a round gains nothing; history receives the
 * errors. `step` names what a checkpoint keeps of it after every round; NULL: nothing. */
btf_result joint_run_rounds(joint_run *r, joint_fit *fit, int count, const char *step, double *history,
                            int *io_rounds, bool *io_over);

/* Rounds a fit off and measures its codes. */
btf_result joint_run_finish(joint_run *r, joint_fit *fit, enc_solution *out_solution,
                            joint_error *out_error);

/* Finishes the first k components of a fit in its principal basis, after a few rounds or iterations where
 * that leaves some out. */
btf_result joint_run_finish_part(joint_run *r, const joint_fit *from, size_t k, enc_solution *out_solution,
                                 joint_error *out_error);

/* Notes a candidate in stats and log; psnr in the fitted domain, CPU time since the one before. */
void joint_run_note(joint_run *r, const joint_shape *shape, double error, const char *verdict);

#endif
