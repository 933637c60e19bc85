/* The joint method without a residual: sources are SBRDF times shadow map.
 *
 * A point is gain * m(l) * SBRDF(x', l, v) * shadow(x', l), x' = match(x, v). One round:
 *   1. every point chooses source and gain anew                           joint_search.c
 *   2. every source's shadow map is solved in closed form, range 0 .. 2
 *   3. every source's SBRDF is fitted to all samples that refer to it     fit.h
 * and the shadow maps once more. Each step minimises the one squared error over its unknowns.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_FRONT_H
#define OPENBTF_ENCODER_JOINT_FRONT_H

#include "joint.h"
#include "joint_rows.h"

typedef struct joint_front_options {
    uint32_t effects; /* of shadow, shift, gain */
    int lobes;
    bool rgb;
    int rounds;
    double tolerance; /* relative decrease of the error that ends the rounds */
} joint_front_options;

/* Fits and hands over. history [rounds + 1] receives the error before the rounds and after each; *out_count
 * how many. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED. On error *out_solution is
 * zeroed. */
btf_result joint_front_fit(const joint_rows *rows, const joint_front_options *options, double *history,
                           int *out_count, enc_solution *out_solution);

#endif
