/* The sources of the joint method, with their fronts, and the source and gain that every point has chosen.
 *
 * A source is the profile that a texel x' offers to the points that refer to it,
 * source(x', v) = front(x', v) + sum over j < k of u[x'][j] * v[view][j], and a point is
 * gain * source(match). The front is SBRDF times shadow map, m(l) * SBRDF(x', l, v) * shadow(x', l); a
 * source may have none, or nothing else.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_SOURCES_H
#define OPENBTF_ENCODER_JOINT_SOURCES_H

#include "encoder/model/sbrdf.h"
#include "rows.h"
#include "search.h"

#include <stdint.h>

enum { JOINT_SHADOW_MAX = 255 }; /* the largest code of a shadow */

/* The make of a front. */
typedef struct joint_front_kind {
    int lobes; /* 1 .. ENC_MAX_LOBES */
    bool rgb;
    bool shadow; /* with shadow maps */
    bool half;   /* parameters are rounded to halves as they are found */
} joint_front_kind;

/* Parameters and shadow codes of every source. */
typedef struct joint_front {
    joint_front_kind kind;
    enc_sbrdf *sbrdf;
    uint8_t *shadow;    /* [texel][light] codes; NULL: none */
    float shadow_scale; /* shadow = code * shadow_scale */
    float *light[3];    /* [light] components of the directions */
} joint_front;

/* A front of zeros whose shadows are 1. Errors: BTF_ERROR_MEMORY. Free with joint_front_destroy. */
btf_result joint_front_create(const joint_rows *rows, const joint_front_kind *kind,
                              joint_front **out_front);
btf_result joint_front_copy(const joint_rows *rows, const joint_front *from, joint_front **out_front);
void joint_front_destroy(joint_front **front);

/* out [row] = m(l) * SBRDF * shadow of one source. */
void joint_front_row(const joint_rows *rows, const joint_front *front, size_t source, size_t view,
                     float *out);
/* The same without the shadow. */
void joint_front_row_lit(const joint_rows *rows, const joint_front *front, size_t source, size_t view,
                         float *out);

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
