/* The scene for which a picture is planned, and frames that share a plan.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/tools/render/frame_plan.h"
#include "tests/support/random_material.h"
#include "tests/support/test.h"

/* A plane straight before a camera, parallel or not, under lights. */
static plan_range see(double fov, double view_theta, double view_phi, const light *lights, size_t count,
                      const char *mesh_name) {
    mesh *m = NULL;
    assert_int_equal(mesh_make(mesh_name, NULL, &m), BTF_OK);
    bvh *b = bvh_create(m);
    assert_non_null(b);
    const light_list list = {(light *)(uintptr_t)lights, count};
    const render_scene scene = {.table = {.mesh = m,
                                          .bvh = b,
                                          .camera = {view_theta, view_phi, fov, 1},
                                          .repeat = {1, 1},
                                          .texels = {16, 16},
                                          .levels = 1,
                                          .threads = 1},
                                .lights = &list,
                                .width = 24,
                                .height = 24,
                                .samples = 1};
    plan_range range = {0};
    assert_int_equal(plan_range_add(&scene, &range), BTF_OK);
    bvh_destroy(&b);
    mesh_destroy(&m);
    return range;
}

static light far_away(double theta, double phi) {
    return (light){.at = vec_from_angles(theta, phi), .colour = {1, 1, 1}};
}

TEST(pictures_are_scenes) {
    const light lights[2] = {far_away(30, 40), far_away(50, 100)};
    plan_range range = see(0, 20, 60, lights, 1, "plane");
    btf_scene scene = plan_range_scene(&range);
    assert_true(scene.view.fixed && scene.light.fixed);
    assert_true(fabs(acos((double)scene.view.direction[2]) * 180 / M_PI - 20) < 1e-3);
    assert_true(
        fabs(atan2((double)scene.light.direction[1], (double)scene.light.direction[0]) * 180 / M_PI - 40) <
        1e-3);
    range = see(0, 20, 60, lights, 2, "plane"); /* two lights */
    scene = plan_range_scene(&range);
    assert_true(scene.view.fixed && !scene.light.fixed);
    assert_true(scene.light.theta[0] > 29 && scene.light.theta[0] <= 30 && scene.light.theta[1] >= 50 &&
                scene.light.theta[1] < 51);
    assert_true(scene.light.phi[0] > 34 && scene.light.phi[0] <= 40 && scene.light.phi[1] >= 100 &&
                scene.light.phi[1] < 106);
    range = see(30, 40, -170, lights, 1, "plane"); /* perspective, azimuths on both sides of 180 */
    scene = plan_range_scene(&range);
    assert_true(!scene.view.fixed && scene.light.fixed);
    assert_true(scene.view.theta[0] > 20 && scene.view.theta[0] < 40 && scene.view.theta[1] > 40 &&
                scene.view.theta[1] < 60);
    const btf_range ahead = {.fixed = 1, .direction = {-0.633f, -0.1116f, 0.766f}};
    assert_true(plan_range_covers(&scene.view, &ahead, 1));
    const btf_range behind = {.fixed = 1, .direction = {0.633f, 0.1116f, 0.766f}};
    assert_false(plan_range_covers(&scene.view, &behind, 0));
    range = see(30, 0, 0, lights, 1, "sphere"); /* nearly everything */
    scene = plan_range_scene(&range);
    assert_true(!scene.view.fixed && !scene.light.fixed && scene.view.theta[0] < 5 &&
                scene.view.theta[1] > 60);
    assert_true(scene.view.phi[0] == scene.view.phi[1]);
}

TEST(ranges_are_widened) {
    const btf_range inner = {.theta = {31, 44}, .phi = {170, 190}};
    const btf_range rings = plan_range_widen(&inner, 10);
    assert_true(rings.theta[0] == 20 && rings.theta[1] == 60 && rings.phi[0] == rings.phi[1]);
    assert_true(plan_range_covers(&rings, &inner, 10.9f));
    assert_false(plan_range_covers(&rings, &inner, 11.1f));
    const btf_range outer = {.theta = {20, 60}, .phi = {160, 200}};
    assert_true(plan_range_covers(&outer, &inner, 9.9f));
    assert_false(plan_range_covers(&outer, &inner, 10.1f)); /* azimuth */
    const btf_range low = {.theta = {25, 70}, .phi = {170, 190}};
    assert_false(plan_range_covers(&outer, &low, 0));
    const btf_range across = {.theta = {31, 44}, .phi = {-200, -155}};
    assert_false(plan_range_covers(&outer, &across, 0));
    const btf_range same = {.theta = {31, 44}, .phi = {-195, -165}};
    assert_true(plan_range_covers(&outer, &same, 0));
    const btf_range pole = {.fixed = 1, .direction = {0, 0, 1}};
    const btf_range cap = plan_range_widen(&pole, 10);
    assert_true(cap.theta[0] == 0 && cap.theta[1] == 10 && cap.phi[0] == cap.phi[1]);
    assert_true(plan_range_covers(&cap, &pole, 9));
    assert_true(plan_range_covers(&pole, &pole, 5)); /* the same single direction */
    assert_false(plan_range_covers(&pole, &cap, 0));
    const btf_range all = {0};
    assert_true(plan_range_covers(&all, &low, 30));
    assert_false(plan_range_covers(&low, &all, 0));
}

/* Three frames from the top, three from low down: two plans; a step of the camera alone: one. */
TEST(frames_share_plans) {
    random_state r = {3};
    btf_material_desc desc = random_material_desc(16, 16, 81, 81, BTF_LAYOUT_TIGHT, BTF_EFFECT_RESIDUAL);
    desc.info.colour = BTF_COLOUR_NONE;
    desc.info.lobes = 0;
    desc.info.components = 8;
    random_ubo2003((float(*)[3])(uintptr_t)desc.views);
    random_ubo2003((float(*)[3])(uintptr_t)desc.lights);
    random_material_fill(&r, &desc);
    btf_material *material = NULL;
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    random_material_free(&desc);
    const light lights[2] = {far_away(10, 40), far_away(70, -100)};
    const frame_wishes wishes = {.tolerance = 0.5f, .interpolate = 1};
    plan_range seen[6];
    for (int i = 0; i < 6; i++) {
        seen[i] = see(0, i < 3 ? 2 + i : 60 + i, i < 3 ? 4 * i : 180 + 4 * i, lights, 2, "plane");
    }
    btf_plan plan;
    int end = 0;
    assert_int_equal(frame_plan(material, seen, 0, 6, &wishes, &end, &plan), BTF_OK);
    assert_int_equal(end, 3);
    assert_true(plan.scene.interpolate && !plan.scene.light.fixed && !plan.scene.view.fixed);
    assert_true(plan.scene.view.theta[1] < 5);
    assert_int_equal(frame_plan(material, seen, 3, 6, &wishes, &end, &plan), BTF_OK);
    assert_int_equal(end, 6);
    assert_true(plan.scene.view.theta[0] > 60 && plan.scene.view.theta[1] < 66);
    assert_int_equal(frame_plan(material, seen, 5, 6, &wishes, &end, &plan), BTF_OK);
    assert_int_equal(end, 6);
    assert_true(plan.shader.fixed == BTF_FIXED_VIEW);
    /* Where light or view stand still, folds follow --fold, and their cost is spread over the samples of all frames. */
    plan_range still[3];
    for (int i = 0; i < 3; i++) {
        still[i] = see(0, 30, 40, lights, 1, "plane");
    }
    frame_wishes folding = wishes;
    assert_int_equal(frame_plan(material, still, 0, 3, &folding, &end, &plan), BTF_OK);
    assert_true(end == 3 && plan.shader.fixed == (BTF_FIXED_VIEW | BTF_FIXED_LIGHT) &&
                plan.fold == BTF_FOLD_NONE);
    folding.folds = true;
    assert_int_equal(frame_plan(material, still, 0, 3, &folding, &end, &plan), BTF_OK);
    assert_true(plan.fold == BTF_FOLD_BOTH && plan.fold_pixels > 0);
    folding.samples = plan.fold_pixels / 2;
    assert_int_equal(frame_plan(material, still, 0, 3, &folding, &end, &plan), BTF_OK);
    assert_true(end == 3 && plan.fold == BTF_FOLD_BOTH);
    assert_int_equal(frame_plan(material, still, 2, 3, &folding, &end, &plan), BTF_OK);
    assert_true(plan.fold == BTF_FOLD_NONE);
    btf_material_close(&material);
}

RUN_TESTS(NULL, NULL)
