/* The sources of the joint method, and the source and gain that every point has chosen.
 *
 * A source is the profile that a texel x' offers to the points that refer to it,
 * source(x', v) = front(x', v) + sum over j < k of u[x'][j] * v[view][j], and a point is
 * gain * source(match).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_SOURCES_H
#define OPENBTF_ENCODER_JOINT_SOURCES_H

#include "front.h"
#include "rows.h"
#include "search.h"

enum { JOINT_MAX_COMPONENTS = 256 };

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

#endif
