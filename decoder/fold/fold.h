/* OpenBTF: the part of a material that a folded shader still reads.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_FOLD_INTERNAL_H
#define OPENBTF_FOLD_INTERNAL_H

#include <openbtf/fold.h>
#include <stdbool.h>
#include <stddef.h>

#pragma GCC visibility push(hidden)

/* The material as a shader that reads a fold sees it: no effect but relief, which acts on the folded
 * values. */
btf_material_info btfi_folded_info(const btf_material_info *info, btf_fold fold);

/* Whether the bytes of a fold of so many lights, or sums, can be counted by a size_t and allocated. */
bool btfi_fold_fits(const btf_material_info *info, btf_fold fold, uint32_t lights);

/* Fills in the members of a plan that describe its fold: none where its scene makes none. `views`, `lights`, `cost` and
 * `shader` are set. */
void btfi_fold_plan(const btf_material *material, btf_plan *plan);

/* The prices that a scene, of an older size too, names; NULL: none. */
static inline const btf_cost_model *btfi_costs_of(const btf_scene *scene) {
    return scene && scene->struct_size >= offsetof(btf_scene, still_lights) ? scene->costs : NULL;
}

#pragma GCC visibility pop

#endif
