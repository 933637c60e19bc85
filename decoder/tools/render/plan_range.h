/* The scene that a picture is: from where its samples are seen and lit, and how fine they are.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_PLAN_RANGE_H
#define OPENBTF_RENDER_PLAN_RANGE_H

#include "render.h"
#include <openbtf/plan.h>

enum { PLAN_SECTORS = 72 }; /* of azimuth, 5 degrees each */

/* The directions that were met: elevations, sectors of azimuth, and whether they are one alone. */
typedef struct plan_directions {
    bool any, varies;
    float z[2]; /* least and greatest cosine */
    bool sector[PLAN_SECTORS];
    float first[3];
} plan_directions;

/* The range of the samples met so far. Start with all zeros. */
typedef struct plan_range {
    plan_directions view, light;
    int level; /* the finest */
} plan_range;

/* Casts the picture and widens the range by its samples under all lights. Errors: BTF_ERROR_MEMORY. */
btf_result plan_range_add(const render_scene *scene, plan_range *range);

/* Widens a range by another. */
void plan_range_join(plan_range *range, const plan_range *other);

/* The range as a scene. Theta is widened by a hundredth of a degree; azimuths are widened to whole sectors, or to all
 * of them where no two neighbouring sectors are empty. A direction that is the same in all samples, bit for bit, is
 * fixed: the light of a flat mesh under one light far away; the view of a flat mesh in parallel projection. */
btf_scene plan_range_scene(const plan_range *range);

/* The range of a camera or light that moves: theta widened by `degrees` and then outward to multiples of them, every
 * azimuth, nothing fixed. */
btf_range plan_range_widen(const btf_range *range, float degrees);

/* Whether every direction of `inner` is in `outer`, and stays in it when inner grows by `slack` degrees. */
bool plan_range_covers(const btf_range *outer, const btf_range *inner, float slack);

#endif
