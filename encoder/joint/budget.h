/* Bytes of layout `tight` (FORMAT.md section 3), and what a budget buys.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_BUDGET_H
#define OPENBTF_ENCODER_JOINT_BUDGET_H

#include "encoder/data/data.h"
#include "encoder/model/solution.h"

enum { JOINT_LAYER = 4 }; /* components of a texture layer */

/* The contents of a file, as far as bytes go. */
typedef struct joint_shape {
    uint32_t effects; /* btf_effect bits */
    size_t components, centres;
    int lobes; /* 0: no SBRDF */
    bool rgb, half;
} joint_shape;

joint_shape joint_solution_shape(const enc_solution *solution);

uint64_t joint_bytes(const enc_data *data, const joint_shape *shape);

/* Beyond 64x64 texels no more components than this, or than 64x64 texels get by the default budget: the
 * time of solves grows with their cube. */
enum { JOINT_MOST_BEYOND = 80 };

/* Components that fit `budget` beside the rest of `shape`: a multiple of 4 (the texels of a texture), at
 * most `limit`, and fewer beyond 64x64 texels (above). */
size_t joint_components_for(const enc_data *data, const joint_shape *shape, uint64_t budget, size_t limit);

/* The bytes that layout `paper` takes for this data: 64 W H + 4 AW AH, by the formula of FORMAT.md section
 * 5; where it has no legal atlas, 64 W H + 4 * 1.6 * T W H; never less than maps and four components take.
 */
uint64_t joint_default_budget(const enc_data *data);

#endif
