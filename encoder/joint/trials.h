/* The trials of a run: which shapes of a model are tried, and the best of them.
 *
 * A shape is a set of effects, a front or none, and as many components as the bytes beside them allow. So
 * the shapes that have a residual take about the same bytes, and an effect has to bring more than the
 * components that its bytes could hold.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_TRIALS_H
#define OPENBTF_ENCODER_JOINT_TRIALS_H

#include "run.h"

enum {
    JOINT_MOST_TRIALS = 20,
    JOINT_FRONT_STEPS = 2, /* least squares of the residual when it gets a front */
};

/* The shapes that are tried, most promising first; needs what joint_run_prepare sets. Returns their
 * number. */
int joint_list_trials(const joint_run *r, joint_shape list[JOINT_MOST_TRIALS]);

/* Rounds of the best at most, where the first trial is of this shape. */
int joint_best_rounds(const joint_run *r, const joint_shape *first);
/* Rounds of a trial, where there are `count` of them and the best has so many `rounds`. */
int joint_trial_rounds(const joint_run *r, int count, int rounds);

/* Tries shapes and leaves the best in r->best, unfinished; it stays empty when none fits the budget. */
btf_result joint_try_shapes(joint_run *r);

/* An SBRDF alone, if a sample of texels says that this is enough: *out_done where it was. */
btf_result joint_try_plain_sbrdf(joint_run *r, enc_solution *out_solution, joint_error *out_error,
                                 bool *out_done);

#endif
