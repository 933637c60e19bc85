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

/* The points of a neighbouring view. */
typedef struct btfi_sources {
    btfi_seen seen;                                           /* sources; of a hidden point, any texel */
    uint32_t column[BTFI_MOST_POINTS], row[BTFI_MOST_POINTS]; /* of the sources */
    float gain[BTFI_MOST_POINTS];
    int32_t centre[BTFI_MOST_POINTS]; /* of a hidden point, else -1 */
} btfi_sources;

/* Prefetches the memory that btfi_find_sources() will read. */
void btfi_await_points(const btf_evaluator *evaluator, const btfi_level *level,
                       const btfi_situation *situation, const btfi_points *const points[3]);

/* Finds the sources of points in each neighbouring view, and prefetches their parameters.
 * points[a] may be the same for all views. */
void btfi_find_sources(const btf_evaluator *evaluator, const btfi_level *level, const btfi_way *way,
                       const btfi_situation *situation, const btfi_points *const points[3],
                       btfi_sources out[3]);

/* L of section 9, or y where the blend is of roots, of each point in each neighbouring view, [view][point]. */
void btfi_view_values(const btf_evaluator *evaluator, const btfi_level *level, const btfi_way *way,
                      const btfi_situation *situation, const btfi_sources sources[3],
                      float out_values[3][BTFI_MOST_POINTS][3]);

#pragma GCC visibility pop

#endif
