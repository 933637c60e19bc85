/* The costs of the steps of the joint method, in core seconds on one core of an AMD EPYC (Zen 4) when it is
 * alone: sums over loops, whose constants were fitted to measured core times of 32x32 and 64x64 texels with
 * 25, 81 and 151 directions. Ratios hold elsewhere; the scale is what progress and prediction measure.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_COST_H
#define OPENBTF_ENCODER_JOINT_COST_H

#include "budget.h"

/* A data set, as far as costs go. */
typedef struct joint_extent {
    double texels, views, row; /* row: 3 * lights */
    double fetch; /* seconds a sample each time that samples are passed over, beside the pass */
} joint_extent;

/* fetch: what data that are not in memory take to be made or read again. */
joint_extent joint_extent_of(const enc_data *data);

/* A cost as steps of a stage: microseconds. */
static inline size_t joint_cost_steps(double cost) {
    return (size_t)(1e6 * cost);
}

/* Parts of a fit of this shape (its effects, components, lobes and rgb). */
double joint_cost_search(const joint_extent *e,
                         const joint_shape *shape); /* sources and gains of all points */
double joint_cost_solve(const joint_extent *e, const joint_shape *shape);    /* u, gains, v */
double joint_cost_refresh(const joint_extent *e, const joint_shape *shape);  /* projection on v, gains */
double joint_cost_residual(const joint_extent *e, const joint_shape *shape); /* both: u, v, all gains */
double joint_cost_survey(const joint_extent *e); /* scale, energies, a probe of SBRDFs */
double joint_cost_basis(const joint_extent *e,
                        const joint_shape *shape);              /* a change to an orthogonal one */
double joint_cost_cluster(const joint_extent *e, double count); /* of the points of so many centres */
double joint_cost_front_fit(const joint_extent *e, const joint_shape *shape);
double joint_cost_front_refit(const joint_extent *e, const joint_shape *shape);
double joint_cost_quantise(const joint_extent *e, const joint_shape *shape);
double joint_cost_measure(const joint_extent *e, const joint_shape *shape);

/* The parts of a run, by stage. */
typedef struct joint_costs {
    double survey;     /* scale, energies, a probe of SBRDFs */
    double start;      /* the plain factorisation */
    double trials;     /* 0 where there is but one */
    double rounds;     /* of the best, or of the only one */
    double centres;
    double codes; /* rounding off and measuring */
} joint_costs;

/* The names of the stages. */
#define JOINT_STAGE_SURVEY "joint: survey"
#define JOINT_STAGE_START "joint: start"
#define JOINT_STAGE_TRIALS "joint: candidates"
#define JOINT_STAGE_ROUNDS "joint: rounds"
#define JOINT_STAGE_CENTRES "joint: centres"
#define JOINT_STAGE_CODES "joint: codes"

#endif
