/* Chooses the plan that the viewer draws by. See planner.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "planner.h"

#include "decoder/tools/render/plan_range.h"
#include <string.h>

static const float ring = 7.5f, slack = 2; /* degrees, see planner.h */

planner planner_begin(void) {
    return (planner){.current = -1, .pending = -1};
}

void planner_clear(planner *p) {
    for (int i = 0; i < PLANNER_SLOTS; i++) {
        btf_material_close(&p->slot[i].material);
    }
    *p = planner_begin();
}

btf_scene planner_rings(const btf_scene *needed) {
    return (btf_scene){.struct_size = sizeof(btf_scene),
                       .view = plan_range_widen(&needed->view, ring),
                       .light = plan_range_widen(&needed->light, ring),
                       .pixels = needed->pixels,
                       .interpolate = 1};
}

static bool same_range(const btf_range *a, const btf_range *b) {
    return a->fixed == b->fixed && (a->fixed ? memcmp(a->direction, b->direction, sizeof a->direction) == 0
                                             : a->theta[0] == b->theta[0] && a->theta[1] == b->theta[1] &&
                                                   a->phi[0] == b->phi[0] && a->phi[1] == b->phi[1]);
}

static bool same_scene(const btf_scene *a, const btf_scene *b) {
    return same_range(&a->view, &b->view) && same_range(&a->light, &b->light) && a->pixels == b->pixels &&
           !a->no_fold == !b->no_fold;
}

/* Whether a plan for `scene` can draw all of `needed`, in a range that is wider by `more` degrees. */
static bool holds(const btf_scene *scene, const btf_scene *needed, float more) {
    return scene->pixels >= needed->pixels && plan_range_covers(&scene->view, &needed->view, more) &&
           plan_range_covers(&scene->light, &needed->light, more);
}

/* Whether a plan for `scene` is wider, by more than a ring, or finer than the one that would be made now. */
static bool is_wasteful(const btf_scene *scene, const btf_scene *rings) {
    const btf_range view = plan_range_widen(&rings->view, ring),
                    light = plan_range_widen(&rings->light, ring);
    return scene->pixels > rings->pixels || !plan_range_covers(&view, &scene->view, 0) ||
           !(scene->light.fixed || plan_range_covers(&light, &scene->light, 0));
}

/* The slot with the plan for just this scene; -1: none. */
static int find(const planner *p, const btf_scene *scene) {
    for (int i = 0; i < PLANNER_SLOTS; i++) {
        if (p->slot[i].material && i != p->pending && same_scene(&p->slot[i].plan.scene, scene)) {
            return i;
        }
    }
    return -1;
}

/* The slot whose plan was not used for longest; never the present one. */
static int oldest(const planner *p) {
    int slot = -1;
    for (int i = 0; i < PLANNER_SLOTS; i++) {
        if (i != p->current && (slot < 0 || p->slot[i].used < p->slot[slot].used)) {
            slot = i;
        }
    }
    return slot;
}

/* Takes the plan for this scene from its slot, or sets it pending to be made. */
static planner_action want(planner *p, const btf_scene *scene) {
    const int there = find(p, scene);
    if (there >= 0) {
        p->pending = -1;
        p->current = there;
        p->slot[there].used = ++p->clock;
        return PLANNER_SWITCH;
    }
    p->target = *scene;
    p->pending = oldest(p);
    return PLANNER_MAKE;
}

planner_action planner_decide(planner *p, const btf_scene *needed, bool at_rest, bool folds) {
    if (p->pending >= 0 && holds(&p->target, needed, 0)) {
        return PLANNER_KEEP;
    }
    if (p->pending >= 0) {
        planner_drop(p);
    }
    const btf_scene rings = planner_rings(needed);
    const btf_scene *now = p->current >= 0 ? &p->slot[p->current].plan.scene : NULL;
    if (!now || !holds(now, needed, slack)) {
        /* a plan that was made before and holds what is needed costs nothing */
        for (int i = 0; i < PLANNER_SLOTS; i++) {
            if (p->slot[i].material && !p->slot[i].plan.scene.light.fixed &&
                holds(&p->slot[i].plan.scene, needed, slack)) {
                return want(p, &p->slot[i].plan.scene);
            }
        }
        return want(p, &rings);
    }
    if (!at_rest) {
        return PLANNER_KEEP;
    }
    if (is_wasteful(now, &rings)) {
        return want(p, &rings);
    }
    if (folds && needed->light.fixed && (!now->light.fixed || !now->no_fold != !needed->no_fold)) {
        btf_scene folded = *now;
        folded.light = needed->light;
        folded.no_fold = needed->no_fold;
        return want(p, &folded);
    }
    return PLANNER_KEEP;
}

btf_result planner_make(planner *p, const btf_material *whole, float tolerance, const btf_cost_model *costs,
                        const btf_log *log) {
    planner_plan *made = &p->slot[p->pending];
    p->target.costs = costs;
    btf_material_close(&made->material);
    btf_result result = btf_plan_effects(whole, &p->target, tolerance, &made->plan);
    if (!result) {
        result = btf_material_restrict(whole, &made->plan, log, &made->material);
    }
    made->number = ++p->count;
    if (result) {
        planner_drop(p);
    }
    return result;
}

void planner_take(planner *p) {
    p->current = p->pending;
    p->pending = -1;
    p->slot[p->current].used = ++p->clock;
}

void planner_drop(planner *p) {
    btf_material_close(&p->slot[p->pending].material);
    p->slot[p->pending].used = 0;
    p->pending = -1;
}
