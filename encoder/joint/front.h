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

struct joint_model;

/* What a front is made of. */
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

/* The mean squared error of a sample that SBRDFs of this kind, alone and each for its own texel, leave of
 * `count` texels evenly spaced. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO. */
btf_result joint_front_probe(const joint_rows *rows, const joint_front_kind *kind, int starts, size_t count,
                             double *out_error);

/* The first fit of model->front: every source's SBRDF to all samples that refer to it, the residual left
 * out, then its shadows, in closed form, and the SBRDF again. `starts` fixed starts are tried. */
btf_result joint_front_fit(const joint_rows *rows, struct joint_model *model, int starts);

/* One refit of model->front for the present choices and residual: shadows in closed form, then the SBRDF
 * from where it is, then the shadows again. What would raise a source's squared error is not taken, so that
 * the total never rises. Errors of both: BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED. */
btf_result joint_front_refit(const joint_rows *rows, struct joint_model *model);

#endif
