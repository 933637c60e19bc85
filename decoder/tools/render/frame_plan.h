/* Divides a sequence of frames into ranges that are decoded by one plan each.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_FRAME_PLAN_H
#define OPENBTF_RENDER_FRAME_PLAN_H

#include "plan_range.h"

/* Wishes beyond the directions and sizes that frames show. */
typedef struct frame_wishes {
    float tolerance; /* dB */
    int interpolate; /* as in btf_scene */
    bool finest;     /* the level of detail is not for the plan to choose */
    const btf_cost_model *costs; /* as in btf_scene */
} frame_wishes;

/* The plan for frames first .. *out_end - 1 of `count`, of which seen[frame] is what each shows. Frames are
 * taken in for as long as a plan for all of them costs at most a quarter more, in relative time and bytes,
 * than the cheapest of their own plans. Errors: those of btf_plan_effects. */
btf_result frame_plan(const btf_material *material, const plan_range *seen, int first, int count,
                      const frame_wishes *wishes, int *out_end, btf_plan *out_plan);

#endif
