/* Chooses the plan that the viewer draws by, and decides when to make another. Uses neither window nor GL.
 *
 * The directions that a picture needs change with every step of the camera, so plans are made for whole rings of
 * 7.5 degrees of elevation around them, all azimuths. The present plan is kept as long as it covers the directions
 * needed and two degrees more; the last few plans are kept, so that going back costs nothing. Once nothing moves, a
 * plan that is wider than needed by more than a ring gives way to a narrower one, and a light that is the same all
 * over the model is fixed in the plan; as soon as that light moves, the plan in which it is free is used again.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_PLANNER_H
#define OPENBTF_VIEW_PLANNER_H

#include <openbtf/plan.h>
#include <stdbool.h>

enum { PLANNER_SLOTS = 4 };

typedef struct planner_plan {
    btf_plan plan;
    btf_material *material; /* the plan's restriction; NULL: the slot is empty */
    uint64_t used;          /* the planner's clock when the plan was last taken */
    unsigned number;        /* of this plan, from 1 */
} planner_plan;

typedef struct planner {
    planner_plan slot[PLANNER_SLOTS];
    int current, pending; /* slots; -1: none */
    btf_scene target;     /* the scene of the pending plan */
    uint64_t clock;
    unsigned count;
} planner;

typedef enum planner_action {
    PLANNER_KEEP,   /* stay with the present plan */
    PLANNER_SWITCH, /* to the plan that `current` now names, which was made before */
    PLANNER_MAKE,   /* make the plan of slot `pending`: planner_make, then planner_take */
} planner_action;

planner planner_begin(void);
/* Closes all materials. */
void planner_clear(planner *p);

/* Returns the scene of the rings around the directions needed: every azimuth, nothing fixed, directions
 * interpolated. */
btf_scene planner_rings(const btf_scene *needed);

/* Decides what to do for a scene (plan_range_scene). at_rest: nothing moved for a while; folds: the scene's fixed
 * light is that of the whole model. A pending plan that does not cover the directions needed now is given up. */
planner_action planner_decide(planner *p, const btf_scene *needed, bool at_rest, bool folds);

/* Makes the pending plan and its restriction of `whole`, and closes the material that its slot held. After an error
 * no plan is pending. Errors: those of btf_plan_effects and btf_material_restrict. costs: as in btf_scene; the plan
 * keeps the pointer. */
btf_result planner_make(planner *p, const btf_material *whole, float tolerance, const btf_cost_model *costs,
                        const btf_log *log);
/* Makes the pending plan the present one. */
void planner_take(planner *p);
/* Gives up the pending plan. */
void planner_drop(planner *p);

#endif
