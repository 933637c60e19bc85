/* Chooses the plan that the viewer draws by, and when it makes another; without window or GL.
 *
 * The material that is needed changes with every step of the camera; plans are made for rings of 7.5
 * degrees around it, all azimuths. The present one is kept for as long as it holds what is needed and two
 * degrees more; the last few are kept, so that going back costs nothing. At rest a plan that is wider than
 * it must be by more than a ring gives way to a narrower one, and a light that is the same all over the
 * model is folded into the shader; as soon as it moves, the plan with that light free is there.
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
    btf_material *material; /* NULL: nothing here */
    uint64_t used;          /* when it was last taken */
    unsigned number;        /* of this plan, from 1 */
} planner_plan;

typedef struct planner {
    planner_plan slot[PLANNER_SLOTS];
    int current, pending; /* slots; -1: none */
    btf_scene target;     /* of the pending one */
    uint64_t clock;
    unsigned count;
} planner;

typedef enum planner_action {
    PLANNER_KEEP,   /* the present plan */
    PLANNER_SWITCH, /* `current` is another now, one that was there */
    PLANNER_MAKE,   /* `pending` is to be made: planner_make, then planner_take */
} planner_action;

planner planner_begin(void);
/* Closes all materials. */
void planner_clear(planner *p);

/* The scene of rings around what is needed: every azimuth, nothing fixed, directions interpolated. */
btf_scene planner_rings(const btf_scene *needed);

/* The step to take for a scene (plan_range_scene). at_rest: nothing moved for a while; folds: its fixed
 * light is that of the whole model. A pending plan is abandoned when it does not hold what is needed now.
 */
planner_action planner_decide(planner *p, const btf_scene *needed, bool at_rest, bool folds);

/* Plans and restricts the pending slot; what was there is closed. On an error nothing is pending. Errors:
 * those of btf_plan_effects and btf_material_restrict. costs: as in btf_scene; the plan keeps the pointer. */
btf_result planner_make(planner *p, const btf_material *whole, float tolerance, const btf_cost_model *costs,
                        const btf_log *log);
/* The pending plan becomes the present one. */
void planner_take(planner *p);
/* The pending plan is given up. */
void planner_drop(planner *p);

#endif
