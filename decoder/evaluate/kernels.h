/* The loops that take most of the time, compiled for every machine and again for AVX2; both give the same
 * bits.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EVALUATE_KERNELS_H
#define OPENBTF_EVALUATE_KERNELS_H

#include "directions.h"

#pragma GCC visibility push(hidden)

/* Texels that share a view and its lights; powers: of all their lobes in all views. */
enum { BTFI_MOST_POINTS = 16, BTFI_MOST_POWERS = 3 * BTFI_MOST_POINTS * BTF_MAX_LOBES };

/* A view and its lights, and the texels that are seen there. */
typedef struct btfi_seen {
    uint32_t view;
    const btfi_neighbours *lights;
    int count; /* of texels, 1 .. BTFI_MOST_POINTS */
    size_t texel[BTFI_MOST_POINTS];
} btfi_seen;

typedef struct btfi_kernels {
    /* Section 9, Factors: r of the first `units` units. */
    void (*factors)(const btf_evaluator *evaluator, const btfi_level *level, uint32_t units,
                    const btfi_seen *seen, float out_r[][3]);
    /* Section 9, residual, of the first k components. */
    void (*components)(const btf_evaluator *evaluator, const btfi_level *level, uint32_t k,
                       const btfi_seen *seen, float out_r[][3]);
    /* values[i] = pow(values[i], exponents[i]); count is rounded up to a multiple of 8: both arrays must be that
     * long. */
    void (*powers)(int count, const float *exponents, float *values);
} btfi_kernels;

/* Instruction sets, in rising order. */
typedef enum btfi_isa { BTFI_ISA_BASE = 0, BTFI_ISA_AVX2 = 1 } btfi_isa;

/* The best that this machine has, at most `limit`. */
const btfi_kernels *btfi_kernels_of(btfi_isa limit);

#pragma GCC visibility pop

#endif
