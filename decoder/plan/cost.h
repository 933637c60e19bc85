/* OpenBTF: the cost of decoding a scene (openbtf/plan.h), of a part of a material too.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_PLAN_COST_H
#define OPENBTF_PLAN_COST_H

#include <openbtf/plan.h>

#pragma GCC visibility push(hidden)

/* btf_plan_cost() of a shader that reads a material of `info`, with the directions of `material`. */
float btfi_plan_cost(const btf_material *material, const btf_material_info *info,
                     const btf_shader_options *options, const btf_scene *scene);

#pragma GCC visibility pop

#endif
