/* OpenBTF: the views or lights that a restriction keeps.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RESTRICT_SUBSET_H
#define OPENBTF_RESTRICT_SUBSET_H

#include "decoder/directions.h"
#include <openbtf/plan.h>

#pragma GCC visibility push(hidden)

/* Directions of a whole list, in its order. */
typedef struct btfi_subset {
    uint32_t count;
    uint16_t number[BTF_MAX_DIRECTIONS]; /* in the whole list */
    float xyz[BTF_MAX_DIRECTIONS][3];
} btfi_subset;

void btfi_subset_all(const btfi_directions *whole, btfi_subset *out_subset);

/* Chooses the directions that are neighbours of any in the range; all where the triangulation of fewer would give other
 * neighbours or weights. Errors: BTF_ERROR_MEMORY. */
btf_result btfi_subset_choose(const btfi_directions *whole, const btf_range *range, const btf_log *log,
                              btfi_subset *out_subset);

#pragma GCC visibility pop

#endif
