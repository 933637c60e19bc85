/* The plan by which the viewer draws: it is kept within its range and replaced beyond it, without flipping to and fro,
 * and folded while the picture is at rest.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/tools/view/planner.h"
#include "tests/support/random_material.h"
#include "tests/support/test.h"

static btf_material *make_material(void) {
    random_state r = {5};
    btf_material_desc desc =
        random_material_desc(8, 8, 81, 81, BTF_LAYOUT_TIGHT, BTF_EFFECT_SHIFT | BTF_EFFECT_RESIDUAL);
    btf_material *material = NULL;
    desc.info.levels = 3;
    random_material_fill(&r, &desc);
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    random_material_free(&desc);
    return material;
}

/* A flat model seen under these elevations, lit from one direction. */
static btf_scene flat(float low, float high, float light_theta) {
    const float t = light_theta * (float)M_PI / 180;
    return (btf_scene){.struct_size = sizeof(btf_scene),
                       .view = {.theta = {low, high}, .phi = {10, 60}},
                       .light = {.fixed = 1, .direction = {sinf(t), 0, cosf(t)}},
                       .pixels = 1};
}

/* Asks the planner for its decision, and makes the plan if one is to be made. */
static planner_action go(planner *p, const btf_material *whole, btf_scene needed, bool at_rest) {
    const planner_action action = planner_decide(p, &needed, at_rest, at_rest);
    if (action == PLANNER_MAKE) {
        assert_true(p->pending >= 0 && p->pending != p->current);
        assert_int_equal(planner_decide(p, &needed, at_rest, at_rest), PLANNER_KEEP); /* while it is made */
        assert_int_equal(planner_make(p, whole, 0.5f, NULL, NULL), BTF_OK);
        planner_take(p);
    }
    assert_true(p->current >= 0 && p->slot[p->current].material);
    return action;
}

static const btf_scene *scene_of(const planner *p) {
    return &p->slot[p->current].plan.scene;
}

TEST(plans_follow_the_camera) {
    btf_material *whole = make_material();
    planner p = planner_begin();
    assert_int_equal(go(&p, whole, flat(20, 30, 30), false), PLANNER_MAKE);
    assert_true(scene_of(&p)->view.theta[0] == 7.5f && scene_of(&p)->view.theta[1] == 37.5f);
    assert_true(scene_of(&p)->interpolate && !scene_of(&p)->light.fixed);
    const unsigned first = p.slot[p.current].number;
    for (int step = 0; step < 5; step++) { /* within the margin less two degrees */
        assert_int_equal(go(&p, whole, flat(20 + (float)step, 31 + (float)step, 30), false), PLANNER_KEEP);
    }
    assert_int_equal(go(&p, whole, flat(26, 36, 30), false), PLANNER_MAKE); /* two degrees before the end */
    assert_true(scene_of(&p)->view.theta[1] == 45);
    for (int i = 0; i < 10; i++) { /* to and fro over the border: no flipping */
        assert_int_equal(go(&p, whole, flat(i % 2 ? 24 : 26, i % 2 ? 34 : 36, 30), false), PLANNER_KEEP);
    }
    assert_int_equal(go(&p, whole, flat(14, 24, 30), false), PLANNER_SWITCH); /* back: it is still there */
    assert_int_equal(p.slot[p.current].number, first);
    btf_scene near = flat(20, 30, 30);
    near.pixels = 0.25f; /* far away: a coarser level is enough, but only at rest */
    assert_int_equal(go(&p, whole, near, false), PLANNER_KEEP);
    assert_int_equal(go(&p, whole, near, true), PLANNER_MAKE);
    assert_int_equal(p.slot[p.current].plan.level, 2);
    near.pixels = 1; /* finer is needed, at once */
    assert_int_equal(go(&p, whole, near, false), PLANNER_SWITCH);
    assert_int_equal(p.slot[p.current].plan.level, 0);
    planner_clear(&p);
    btf_material_close(&whole);
}

TEST(light_at_rest_is_folded) {
    btf_material *whole = make_material();
    planner p = planner_begin();
    assert_int_equal(go(&p, whole, flat(20, 30, 30), false), PLANNER_MAKE);
    assert_int_equal(go(&p, whole, flat(20, 30, 30), true), PLANNER_MAKE);
    assert_true(scene_of(&p)->light.fixed && p.slot[p.current].plan.shader.fixed == BTF_FIXED_LIGHT);
    assert_true(p.slot[p.current].plan.lights <= 3);
    assert_int_equal(go(&p, whole, flat(20, 30, 30), true), PLANNER_KEEP);
    assert_int_equal(go(&p, whole, flat(22, 32, 30), false), PLANNER_KEEP); /* the camera alone */
    assert_int_equal(go(&p, whole, flat(22, 32, 31), false),
                     PLANNER_SWITCH); /* the light: no frozen frame */
    assert_false(scene_of(&p)->light.fixed);
    assert_int_equal(go(&p, whole, flat(22, 32, 31), true), PLANNER_MAKE);
    assert_int_equal(go(&p, whole, flat(22, 32, 30), true), PLANNER_SWITCH);
    assert_int_equal(go(&p, whole, flat(22, 32, 30), true),
                     PLANNER_SWITCH); /* the first fold is still there */
    assert_true(scene_of(&p)->light.fixed);
    /* A fold that is abandoned while it is made leaves nothing behind. */
    btf_scene needed = flat(22, 32, 50), moved = flat(22, 32, 60);
    assert_int_equal(go(&p, whole, needed, false), PLANNER_MAKE); /* rings around 50 */
    assert_int_equal(planner_decide(&p, &needed, true, true), PLANNER_MAKE);
    const int given_up = p.pending;
    assert_int_equal(planner_make(&p, whole, 0.5f, NULL, NULL), BTF_OK);
    assert_int_equal(planner_decide(&p, &moved, false, false), PLANNER_MAKE);
    assert_true(p.slot[given_up].material == NULL);
    planner_clear(&p);
    btf_material_close(&whole);
}

RUN_TESTS(NULL, NULL)
