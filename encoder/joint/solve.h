/* The least squares of sources: given the choices and the front, the squared error is quadratic in u and
 * in v; each step solves one of them exactly.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_SOLVE_H
#define OPENBTF_ENCODER_JOINT_SOLVE_H

#include "projection.h"

/* Rounding to codes that a solve ends with: the solution becomes code * step, times m(l) for v. The codes
 * are chosen together, each absorbing what the rounding of others costs. */
typedef struct joint_rounding {
    const double *step; /* [k] */
    int8_t *codes;      /* u: [texel][k]; v: [view][k][row] */
} joint_rounding;

/* Both leave the front as it is. Points of gain 0 have no say.
 *
 * Solves u, source by source, for the choices and v behind `projection`. Sources nobody refers to keep u.
 * rounding may be NULL. */
btf_result joint_solve_u(const joint_rows *rows, const joint_projection *projection,
                         const joint_rounding *rounding, joint_model *model);
/* Solves v, view by view, for the choices and u: one pass over the data. rounding may be NULL. */
btf_result joint_solve_v(const joint_rows *rows, const joint_rounding *rounding, joint_model *model);

#endif
