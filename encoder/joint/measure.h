/* The error of a solution of the joint method, decoded at the sampled directions, against the data.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_MEASURE_H
#define OPENBTF_ENCODER_JOINT_MEASURE_H

#include "encoder/model/solution.h"
#include "rows.h"

/* Sums of squared errors over all samples. */
typedef struct joint_error {
    double fitted; /* y, as the rounds minimise it */
    double linear; /* radiance clipped to [0, 1] */
    double srgb;   /* the same, sRGB-coded */
} joint_error;

/* Decodes every sample from the codes (FORMAT.md section 9, at the sampled directions; in float, but for
 * the order of the sum over components) in one pass over the data. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO,
 * BTF_ERROR_INTERRUPTED. */
btf_result joint_measure(const joint_rows *rows, const enc_solution *solution, joint_error *out_error);

/* dB, peak 1; 100 for an error of zero. */
double joint_psnr(const joint_rows *rows, double squares);

#endif
