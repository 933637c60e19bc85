/* One run of the joint method: what its parts share. Internal.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_RUN_H
#define OPENBTF_ENCODER_JOINT_RUN_H

#include "budget.h"
#include "cost.h"
#include "fit.h"
#include "measure.h"

/* What a preset stands for. */
typedef struct joint_preset_values {
    int start;        /* subspace iterations of the plain factorisation */
    int candidates;   /* shapes that are tried */
    int trial;        /* rounds of a trial */
    int rounds;       /* rounds of the best, trial included */
    int front;        /* the same where sources have no residual */
    double tolerance; /* relative decrease of the error that ends the rounds */
} joint_preset_values;

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

enum {
    JOINT_MOST_CANDIDATES = 20,
    JOINT_LAYER = 4,          /* components of a texture layer */
    JOINT_PROBED = 64,        /* texels that a plain SBRDF is tried on first */
    JOINT_FRONT_STEPS = 2,    /* least squares of the residual when it gets a front */
    JOINT_MOST_CENTRES = 512, /* the time of the clustering grows with their square */
    JOINT_REDUCE_ROUNDS = 3   /* after components were dropped for --quality */
};

/* A run before it begins: options, preset and budget for the extent of `data`, whose samples are not looked
 * at. */
joint_run joint_run_prepare(const enc_context *context, const enc_data *data,
                            const enc_joint_options *options);

/* The candidates that are tried, most promising first; needs what joint_run_prepare sets. Returns their
 * number. */
int joint_list_candidates(const joint_run *r, joint_shape list[JOINT_MOST_CANDIDATES]);

/* Rounds of the best at most, where the first candidate is this; and of a trial, where there are `count`
 * candidates. */
int joint_run_round_count(const joint_run *r, const joint_shape *first);
int joint_run_trial_count(const joint_run *r, int count, int rounds);

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

/* Tries shapes and leaves the best in r->best, unfinished; it stays empty when none fits the budget
 * (joint_candidates.c). */
btf_result joint_try_candidates(joint_run *r);

/* Hidden points and centres for r->best, where it has shift and gain: in the bytes that are left, or in
 * those of the last four components where that saves more (joint_hide.c). */
btf_result joint_try_centres(joint_run *r);

/* An SBRDF alone, if a sample of texels says that this is enough: *out_done where it was
 * (joint_candidates.c). */
btf_result joint_try_plain_sbrdf(joint_run *r, enc_solution *out_solution, joint_error *out_error,
                                 bool *out_done);

/* options->quality: replaces *solution by the fewest bytes that reach it, of the best fit and of the plain
 * one (joint_quality.c). */
btf_result joint_reach_quality(joint_run *r, enc_solution *solution, joint_error *error);

#endif
