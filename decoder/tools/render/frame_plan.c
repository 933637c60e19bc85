/* Plans for ranges of frames. See frame_plan.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "frame_plan.h"

#include <math.h>

static float price(const btf_plan *plan) {
    return plan->cost / plan->full_cost + (float)plan->gpu_bytes / (float)plan->full_gpu_bytes;
}

static btf_result make(const btf_material *material, const plan_range *range, const frame_wishes *wishes,
                       btf_plan *plan) {
    btf_scene scene = plan_range_scene(range);
    scene.interpolate = wishes->interpolate;
    scene.costs = wishes->costs;
    if (wishes->finest) {
        scene.pixels = 1;
    }
    return btf_plan_effects(material, &scene, wishes->tolerance, plan);
}

btf_result frame_plan(const btf_material *material, const plan_range *seen, int first, int count,
                      const frame_wishes *wishes, int *out_end, btf_plan *out_plan) {
    plan_range together = seen[first];
    btf_result result = make(material, &together, wishes, out_plan);
    float cheapest = price(out_plan);
    *out_end = first + 1;
    while (!result && *out_end < count) {
        plan_range more = together;
        btf_plan one, all;
        plan_range_join(&more, &seen[*out_end]);
        result = make(material, &seen[*out_end], wishes, &one);
        if (!result) {
            result = make(material, &more, wishes, &all);
        }
        if (result || price(&all) > 1.25f * fminf(cheapest, price(&one))) {
            break;
        }
        cheapest = fminf(cheapest, price(&one));
        together = more;
        *out_plan = all;
        ++*out_end;
    }
    return result;
}
