/* The part of an evaluation that depends on light and view alone (FORMAT.md sections 6 and 9).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EVALUATE_DIRECTIONS_H
#define OPENBTF_EVALUATE_DIRECTIONS_H

#include "way.h"

#pragma GCC visibility push(hidden)

/* The neighbours of a direction that have a weight, in their order; weights sum to 4096. The rest of the three is
 * the first of them again, with weight 0. */
typedef struct btfi_neighbours {
    int count;
    uint32_t index[3];
    int32_t weight[3];
    uint8_t place[3]; /* of each of the `count` among the three that were looked up; the nearest's is 0 */
} btfi_neighbours;

typedef struct btfi_situation {
    btfi_neighbours views;
    btfi_neighbours lights[3]; /* of each neighbouring view */
    float view[3];
    float product[3]; /* P */
    float cosine;     /* m */
    float horizon;    /* m_r; with factors */
} btfi_situation;

/* Returns whether anything is to be seen; where nothing is, *out_situation stays as it is. */
bool btfi_look_up(const btf_evaluator *evaluator, const btfi_way *way, const float light[3],
                  const float view[3], btfi_situation *out_situation);

#pragma GCC visibility pop

#endif
