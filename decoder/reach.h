/* OpenBTF: which sampled directions a range of directions needs, and the look-up of one direction.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_REACH_H
#define OPENBTF_REACH_H

#include "directions.h"
#include <openbtf/plan.h>

#pragma GCC visibility push(hidden)

/* The uses of a record of FORMAT.md section 6, as bits. */
enum {
    BTFI_REACH_RECORD = 1,
    BTFI_REACH_CORNER = 2
}; /* a triangle or an edge's strip; the cone at its end */
enum { BTFI_MOST_RECORDS = 4 * BTF_MAX_DIRECTIONS };

typedef struct btfi_reach {
    uint8_t record[BTFI_MOST_RECORDS];
    bool keep[BTF_MAX_DIRECTIONS];
    uint32_t count; /* of those kept, at least 1 */
} btfi_reach;

/* True when the range is one: numbers in order and within bounds. */
bool btfi_range_is_legal(const btf_range *range);
/* The records that accept some direction of the range, and the directions that they and their tests name.
 * Too many rather than too few: borders count with a margin of two units of the plane. */
void btfi_reach_range(const btfi_directions *directions, const btf_range *range, btfi_reach *out);
/* A unit vector above the horizon. */
bool btfi_direction_is_legal(const float direction[3]);

/* Neighbours of weight above 0 first, `count` of them, in the order of the look-up. */
typedef struct btfi_neighbours {
    uint32_t count, index[3], weight[3];
} btfi_neighbours;

btfi_neighbours btfi_neighbours_of(const btfi_directions *directions, const float direction[3],
                                   bool nearest);
/* The look-up of FORMAT.md section 6; returns the record, UINT32_MAX when none accepts. */
uint32_t btfi_lookup(const btfi_directions *directions, const float direction[3], uint32_t out_index[3],
                     uint32_t out_weight[3]);

#pragma GCC visibility pop

#endif
