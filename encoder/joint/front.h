/* The front of a source: SBRDF times shadow map, m(l) * SBRDF(x', l, v) * shadow(x', l), what a source of
 * the joint method holds before its residual, or alone.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_FRONT_H
#define OPENBTF_ENCODER_JOINT_FRONT_H

#include "rows.h"
#include "encoder/model/sbrdf.h"

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

#endif
