/* Relief: where each neighbouring view is read, and how much it weighs (FORMAT.md section 9).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EVALUATE_RELIEF_H
#define OPENBTF_EVALUATE_RELIEF_H

#include "directions.h"

#pragma GCC visibility push(hidden)

/* The slopes of an evaluation's view and of its neighbours, which all texels share. */
typedef struct btfi_slopes {
    int32_t share; /* e */
    int32_t own[2], of_view[3][2];
} btfi_slopes;

void btfi_relief_slopes(const btf_evaluator *evaluator, const btfi_situation *situation,
                        btfi_slopes *out_slopes);

/* x_a of each neighbouring view for the point that is seen at `position`, in 1/256 of a texel, v upwards,
 * and the weights; those of the situation where no occlusion is wanted. */
void btfi_relief(const btf_evaluator *evaluator, const btfi_level *level, const btfi_situation *situation,
                 const btfi_slopes *slopes, bool occlusion, const int32_t position[2],
                 int32_t out_positions[3][2], int32_t out_weights[3]);

#pragma GCC visibility pop

#endif
