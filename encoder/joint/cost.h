/* The costs of a model of the joint method: bytes of layout `tight` (FORMAT.md section 3), with the model
 * that a budget holds, and core seconds.
 *
 * Seconds are those of one core of an AMD EPYC (Zen 4) when it is alone: sums over loops, whose constants
 * were fitted to measured core times of 32x32 and 64x64 texels with 25, 81 and 151 directions. Ratios hold
 * elsewhere; the scale is what progress and prediction measure.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_COST_H
#define OPENBTF_ENCODER_JOINT_COST_H

#include "encoder/data/data.h"
#include "encoder/model/solution.h"

enum { JOINT_LAYER = 4 }; /* components of a texture layer */

/* A model, as far as costs go. */
typedef struct joint_shape {
    uint32_t effects; /* btf_effect bits */
    size_t components, centres;
    int lobes; /* 0: no SBRDF */
    bool rgb, half;
} joint_shape;

joint_shape joint_solution_shape(const enc_solution *solution);

/* GPU bytes of such a model. */
uint64_t joint_bytes(const enc_data *data, const joint_shape *shape);

/* Beyond 64x64 texels no more components than this, or than 64x64 texels get by the default budget: the
 * time of solves grows with their cube. */
enum { JOINT_MOST_BEYOND = 80 };

/* Components that fit `budget` beside the rest of `shape`: a multiple of 4 (the texels of a texture), at
 * most `limit`, and fewer beyond 64x64 texels (above). */
size_t joint_components_for(const enc_data *data, const joint_shape *shape, uint64_t budget, size_t limit);

/* The bytes that layout `paper` takes for this data: 64 W H + 4 AW AH, by the formula of FORMAT.md section
 * 5; where it has no legal atlas, 64 W H + 4 * 1.6 * T W H; never less than maps and four components take.
 */
uint64_t joint_default_budget(const enc_data *data);

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
    double survey; /* scale, energies, a probe of SBRDFs */
    double start;  /* the plain factorisation */
    double trials; /* 0 where there is but one */
    double rounds; /* of the best, or of the only one */
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
