/* Values of texels in a view: shifts, gains, the SBRDF, shadow, residual (FORMAT.md sections 3, 4 and 9).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EVALUATE_SOURCE_H
#define OPENBTF_EVALUATE_SOURCE_H

#include "kernels.h"

#pragma GCC visibility push(hidden)

/* Texels of a level, in each neighbouring view. */
typedef struct btfi_points {
    int count; /* 1 .. BTFI_MOST_POINTS */
    uint32_t column[BTFI_MOST_POINTS], row[BTFI_MOST_POINTS];
} btfi_points;

/* L of section 9, or y where the blend is of roots, of each point in each neighbouring view, [view][point]. points[a]
 * may be the same for all views. */
void btfi_view_values(const btf_evaluator *evaluator, const btfi_level *level, const btfi_way *way,
                      const btfi_situation *situation, const btfi_points *const points[3],
                      float out_values[3][BTFI_MOST_POINTS][3]);

#pragma GCC visibility pop

#endif
