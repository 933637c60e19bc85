/* Plans for ranges of frames. See frame_plan.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "frame_plan.h"

#include <math.h>

static btf_result make(const btf_material *material, const plan_range *range, int frames,
                       const frame_wishes *wishes, btf_plan *plan) {
    btf_scene scene = plan_range_scene(range);
    scene.interpolate = wishes->interpolate;
    scene.costs = wishes->costs;
    scene.still_lights = wishes->still_lights > 0;
    scene.lights = wishes->still_lights;
    scene.no_fold = !wishes->folds;
    scene.folded_pixels = wishes->samples * frames;
    scene.folded_bytes = wishes->fold_bytes;
    if (wishes->finest) {
        scene.pixels = 1;
    }
    return btf_plan_effects(material, &scene, wishes->tolerance, plan);
}

btf_result frame_plan(const btf_material *material, const plan_range *seen, int first, int count,
                      const frame_wishes *wishes, int *out_end, btf_plan *out_plan) {
    plan_range together = seen[first];
    btf_result result = make(material, &together, 1, wishes, out_plan);
    float cheapest = out_plan->price;
    *out_end = first + 1;
    while (!result && *out_end < count) {
        plan_range more = together;
        btf_plan one, all;
        plan_range_join(&more, &seen[*out_end]);
        result = make(material, &seen[*out_end], 1, wishes, &one);
        if (!result) {
            result = make(material, &more, *out_end + 1 - first, wishes, &all);
        }
        if (result || all.price > 1.25f * fminf(cheapest, one.price)) {
            break;
        }
        cheapest = fminf(cheapest, one.price);
        together = more;
        *out_plan = all;
        ++*out_end;
    }
    return result;
}
