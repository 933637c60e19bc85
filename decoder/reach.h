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
    BTFI_REACH_RECORD = 1, /* a triangle, or the strip of an edge */
    BTFI_REACH_CORNER = 2  /* the cone at the end of an edge */
};
enum { BTFI_MOST_RECORDS = 4 * BTF_MAX_DIRECTIONS };

typedef struct btfi_reach {
    uint8_t record[BTFI_MOST_RECORDS];
    bool keep[BTF_MAX_DIRECTIONS];
    uint32_t count; /* of those kept, at least 1 */
} btfi_reach;

/* True where the numbers of a range are in order and within bounds. */
bool btfi_range_is_legal(const btf_range *range);
/* Finds the records that accept some direction of the range, and the directions that these records and their tests
 * name; rather too many than too few, since a margin of two units of the plane around the range belongs to it. */
void btfi_reach_range(const btfi_directions *directions, const btf_range *range, btfi_reach *out);
/* True for a unit vector above the horizon. */
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
