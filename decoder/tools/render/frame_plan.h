/* Divides a sequence of frames into ranges that are decoded by one plan each.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_FRAME_PLAN_H
#define OPENBTF_RENDER_FRAME_PLAN_H

#include "plan_range.h"

/* What a plan for frames is to observe beside the directions and sizes that they show. */
typedef struct frame_wishes {
    float tolerance; /* dB */
    int interpolate; /* as in btf_scene */
    bool finest;     /* the level of detail is not for the plan to choose */
    const btf_cost_model *costs; /* as in btf_scene */
    uint32_t still_lights; /* the number of lights whose sum can be folded, 2 at least; 0: none */
    bool folds;        /* a fixed light or view will be folded where that pays */
    double samples;    /* shown in a frame, for a fold to pay; 0: it is made whether it pays or not */
    size_t fold_bytes; /* the most that a fold may take */
} frame_wishes;

/* The plan for frames first .. *out_end - 1 of `count`, of which seen[frame] is what each shows. Frames are
 * taken in for as long as a plan for all of them costs at most a quarter more, in relative time and bytes,
 * than the cheapest of their own plans (btf_plan.price). Errors: those of btf_plan_effects. */
btf_result frame_plan(const btf_material *material, const plan_range *seen, int first, int count,
                      const frame_wishes *wishes, int *out_end, btf_plan *out_plan);

#endif
