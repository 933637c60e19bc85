/* The scene that a picture is: from where its samples are seen and lit, and how fine they are.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_PLAN_TABLE_H
#define OPENBTF_RENDER_PLAN_TABLE_H

#include "render.h"
#include <openbtf/plan.h>

/* What samples were met so far. Start with all zeros. */
typedef struct plan_range {
    bool any;
    float view_z[2], light_z[2]; /* least and greatest cosine */
    int level;                   /* the finest */
} plan_range;

/* Casts the picture and widens the range by its samples under all lights. Errors: BTF_ERROR_MEMORY. */
btf_result plan_range_add(const render_scene *scene, plan_range *range);

/* The range as a scene; elevations are widened by a hundredth of a degree. */
btf_scene plan_range_scene(const plan_range *range);

#endif
