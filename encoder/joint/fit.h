/* One fit of the joint method: a model of given shape, its rounds, its codes.
 *
 * One round, given the per-view bases v of the sources:
 *   1. every point (texel, view) chooses source and gain anew       choose.c, search.c
 *   2. u: every source is solved for the points that chose it       solve.c
 *   3. gains are chosen again
 *   4. the front, in some rounds: every source's SBRDF and shadows  front_fit.c
 *   5. v: every view's basis is solved for all of its points, and gains chosen again
 * Each step minimises the one squared error over its unknowns and keeps the others, so that a round never
 * raises it.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_FIT_H
#define OPENBTF_ENCODER_JOINT_FIT_H

#include "cost.h"
#include "encoder/model/solution.h"
#include "quantise.h"

enum { JOINT_FRONT_PERIOD = 8 }; /* rounds from one refit of a front beside a residual to the next */

/* Free with joint_fit_clear in any case; all zeros is a valid empty fit. */
typedef struct joint_fit {
    const joint_rows *rows;
    uint32_t effects; /* btf_effect bits of the file this becomes */
    joint_model model;
    joint_projection projection; /* of model.v; freed by joint_fit_release */
    joint_codes codes;           /* after joint_fit_quantise */
    double error;                /* sum of squares in the fitted domain */
    int rounds;                  /* done so far */
    size_t n_centres;            /* with effect hidden */
    float centre_scale;
    uint8_t *centre_codes; /* [centre][light][3] */
} joint_fit;

void joint_fit_clear(joint_fit *fit);

/* A fit of zeros with k components, whose points may choose what the effects allow. Errors:
 * BTF_ERROR_MEMORY. */
btf_result joint_fit_init(const joint_rows *rows, size_t k, uint32_t effects, joint_fit *out_fit);

/* Effects, components, centres and front of a fit. */
joint_shape joint_fit_shape(const joint_fit *fit);

/* The plain factorisation of the data (every point its own source, gain 1): `steps` subspace iterations
 * from random u, then the principal basis. energy [k] (may be NULL) receives what each component explains;
 * the error of the first j is rows->total - sum over i < j of energy[i]. */
btf_result joint_fit_plain(const joint_rows *rows, size_t k, int steps, joint_fit *out_fit, double *energy);
/* `steps` more subspace iterations, then the principal basis. */
btf_result joint_fit_refine_plain(joint_fit *fit, int steps, double *energy);

/* Starts a fit with `effects` from the first k components of another one in a principal basis, its
 * choices and its front. */
btf_result joint_fit_start(const joint_fit *from, size_t k, uint32_t effects, joint_fit *out_fit);

/* Gives a fit without a front one of this kind: fitted to the data from `starts` fixed starts for the
 * present choices, then `steps` times the residual for what it leaves. */
btf_result joint_fit_add_front(joint_fit *fit, const joint_front_kind *kind, int starts, int steps);

/* Starts a fit of a front alone. */
btf_result joint_fit_front_alone(const joint_rows *rows, uint32_t effects, const joint_front_kind *kind,
                                 int starts, joint_fit *out_fit);

/* One round; fit->error is that after it. */
btf_result joint_fit_round(joint_fit *fit);

/* Fills fit->model.point_error for the present choices. */
btf_result joint_fit_point_errors(joint_fit *fit);

/* Frees what only rounds need; joint_fit_round makes it again. */
void joint_fit_release(joint_fit *fit);

/* Rounds the model to the codes of the file. */
btf_result joint_fit_quantise(joint_fit *fit);

/* Hands the codes over. Errors: BTF_ERROR_MEMORY. */
btf_result joint_fit_solution(const joint_fit *fit, enc_solution *out_solution);

#endif
