/* Sources of the joint method: what they are, which of them the points choose, and their least squares.
 *
 * A source is the profile that a texel x' offers to the points that refer to it,
 * source(x', v) = front(x', v) + sum over j < k of u[x'][j] * v[view][j], and a point is
 * gain * source(match). Given the choices and the front, the squared error is quadratic in u and in v; each
 * step solves one of them exactly.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_SOURCES_H
#define OPENBTF_ENCODER_JOINT_SOURCES_H

#include "front.h"
#include "coordinates.h"
#include "rows.h"
#include "search.h"

enum {
    JOINT_MAX_COMPONENTS = 256,
    JOINT_FRONT_DIMS = 12,     /* basis vectors for fronts beside a residual ... */
    JOINT_LONE_DIMS = 48,      /* ... and without one */
    JOINT_FRONT_SAMPLES = 128, /* fronts that the basis of a view is made from */
};

/* The model in floats, with the choices of all points. */
typedef struct joint_model {
    size_t texels, views, row, k;
    float *u;        /* [texel][k] */
    float *v;        /* [view][k][row], y domain, m(l) included */
    uint32_t *match; /* [view][texel] source of the point */
    uint8_t *gain;   /* [view][texel] code */
    joint_gains gains;
    bool shift;
    unsigned searches;   /* so far: moves the grid of sources that points look at */
    uint16_t *centre;    /* [view][texel] of the points of gain 0, which are hidden; NULL: none is */
    float *centre_error; /* [view][texel] squared distance of those points to their centre */
    float *point_error;  /* [view][texel] squared error of a point; joint_choose fills it unless NULL */
    joint_front *front;  /* NULL: none. k is 0 where the front is all of a source */
    double prior;        /* variance of the noise over that of u: weight of a pull of u towards 0 */
} joint_model;

/* Zeros, every point its own source with gain 1, neither free. Errors: BTF_ERROR_MEMORY. */
btf_result joint_model_init(const joint_rows *rows, size_t k, joint_model *out_model);
void joint_model_clear(joint_model *model);

/* Per view an orthonormal basis that begins with the span of v[view], v = lower * basis, and every row in
 * it. Without a front dims is k. With one, basis vectors follow that span most of what v leaves of the
 * fronts; the last is zero, where a source has the length of what it has beyond the basis. */
typedef struct joint_projection {
    size_t dims;
    float *basis;    /* [view][dims][row] */
    float *lower;    /* [view][k][k] lower triangular */
    joint_points *c; /* [view], [texel][dims] = basis * row */
} joint_projection;

btf_result joint_projection_init(const joint_rows *rows, const joint_model *model,
                                 joint_projection *out_projection);
void joint_projection_clear(joint_projection *projection);
/* Recomputes all three from model->v: one pass over the data. */
btf_result joint_project(const joint_rows *rows, const joint_model *model, joint_projection *projection);

/* Chooses sources (with `search`) and gains of all points for the present u, v and front; *out_error is the
 * sum of squares that remains. Never raises it. With a front the search is in the projection's basis, exact
 * but for the inner product beyond it, and its choice is taken where it is truly better than the present.
 */
btf_result joint_choose(const joint_rows *rows, const joint_projection *projection, bool search,
                        double tolerance, joint_model *model, double *out_error);

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
