/* OpenBTF: the cost of decoding a scene. See cost.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cost.h"
#include "decoder/cost/counts.h"
#include "decoder/fold/fold.h"
#include "decoder/material.h"
#include "decoder/reach.h"

#include <stdbool.h>

/* Neighbouring directions that a shader goes through, and how many of them have weight 0. */
static void count_directions(const btfi_directions *directions, const btf_shader_options *o, uint32_t fixed,
                             const float fixed_direction[3], const btf_range *range, uint32_t *out_all,
                             uint32_t *out_skipped) {
    const bool nearest = o->interpolation == BTF_INTERPOLATION_NEAREST;
    *out_all = nearest ? 1 : 3;
    *out_skipped = 0;
    if (o->fixed & fixed) {
        *out_all = btfi_neighbours_of(directions, fixed_direction, nearest).count;
    } else if (!nearest && range && range->fixed) {
        *out_skipped = 3 - btfi_neighbours_of(directions, range->direction, false).count;
    }
}

/* The counts of a shader that reads a material of `info`, with the directions of `material`. */
static btf_decode_counts counts_of(const btf_material *material, const btf_material_info *info,
                                   const btf_shader_options *o, const btf_scene *scene) {
    btfi_around around;
    uint32_t none;
    count_directions(&material->views, o, BTF_FIXED_VIEW, o->fixed_view, scene ? &scene->view : NULL,
                     &around.views, &around.skipped);
    /* With gloss each view looks up lights of its own, even where the light is fixed. */
    count_directions(&material->lights, o,
                     info->effects & ~o->leave_out & BTF_EFFECT_GLOSS ? 0 : BTF_FIXED_LIGHT, o->fixed_light,
                     NULL, &around.lights, &none);
    return btfi_count_decode(info, o, &around);
}

float btfi_plan_cost(const btf_material *material, const btf_material_info *info,
                     const btf_shader_options *o, const btf_scene *scene) {
    const btf_decode_counts counts = counts_of(material, info, o, scene);
    return (float)btf_cost_of(&counts, btfi_costs_of(scene));
}

btf_decode_counts btf_plan_counts(const btf_material *material, const btf_shader_options *options,
                                  const btf_scene *scene) {
    return counts_of(material, &material->info, options, scene);
}

float btf_plan_cost(const btf_material *material, const btf_shader_options *options,
                    const btf_scene *scene) {
    return btfi_plan_cost(material, &material->info, options, scene);
}
