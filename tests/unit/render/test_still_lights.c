/* Several lights that are the same in every sample (decoder/tools/render/still_lights.h), and the fold of their sum,
 * which has the bits of the sum of single lights in single precision. Where --fold always cannot fold, a message says
 * why.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/tools/render/still_lights.h"
#include "decoder/toolkit/file.h"
#include "decoder/tools/render/shade_fold.h"
#include "tests/support/random_material.h"
#include "tests/support/test.h"

enum { SIZE = 20, SAMPLES = SIZE * SIZE, LIGHTS = 4 };

static btf_material *make(uint32_t width, uint32_t height, uint32_t effects, btf_colour colour) {
    random_state r = {7};
    btf_material_desc desc = random_material_desc(width, height, 81, 81, BTF_LAYOUT_TIGHT, effects);
    btf_material *material = NULL;
    desc.info.colour = colour;
    desc.info.lobes = colour == BTF_COLOUR_NONE ? 0 : desc.info.lobes;
    desc.info.components = effects & BTF_EFFECT_RESIDUAL ? 4 : 0;
    random_ubo2003((float(*)[3])(uintptr_t)desc.views);
    random_ubo2003((float(*)[3])(uintptr_t)desc.lights);
    random_material_fill(&r, &desc);
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    random_material_free(&desc);
    return material;
}

typedef struct place {
    mesh *mesh;
    bvh *bvh;
    light lights[LIGHTS];
    light_list list;
    render_scene scene;
} place;

/* Lights from three sides, and one from below the plane, which shows nothing. */
static void set_up(place *p, const char *mesh_name, double fov) {
    static const double at[LIGHTS][2] = {{20, 100}, {110, 0}, {50, 0}, {70, -120}};
    assert_int_equal(mesh_make(mesh_name, NULL, &p->mesh), BTF_OK);
    p->bvh = bvh_create(p->mesh);
    assert_non_null(p->bvh);
    for (int i = 0; i < LIGHTS; i++) {
        p->lights[i] = (light){.at = vec_from_angles(at[i][0], at[i][1]),
                               .colour = {0.3 * i + 0.1, 0.7, 1.0 / (i + 1)}};
    }
    p->list = (light_list){p->lights, LIGHTS};
    p->scene = (render_scene){.table = {.mesh = p->mesh,
                                        .bvh = p->bvh,
                                        .camera = {25, 60, fov, 1},
                                        .repeat = {1, 1},
                                        .width = SIZE,
                                        .height = SIZE,
                                        .texels = {8, 8},
                                        .levels = 1,
                                        .threads = 2},
                              .lights = &p->list,
                              .width = SIZE,
                              .height = SIZE,
                              .samples = 1};
}

static void tear_down(place *p) {
    bvh_destroy(&p->bvh);
    mesh_destroy(&p->mesh);
}

TEST(lights_on_a_plane_are_found) {
    place p;
    still_lights found;
    set_up(&p, "plane", 0);
    assert_int_equal(still_lights_find(&p.scene, &found), BTF_OK);
    assert_int_equal(found.count, LIGHTS - 1);
    assert_true(found.same_view);
    const vec3 last = vec_from_angles(70, -120); /* the plane's frame is the world's */
    assert_true(fabs((double)found.directions[6] - last.x) < 1e-6 &&
                fabs((double)found.directions[7] - last.y) < 1e-6 &&
                fabs((double)found.directions[8] - last.z) < 1e-6);
    assert_true(found.weights[6] == (float)p.lights[3].colour[0] &&
                found.weights[8] == (float)p.lights[3].colour[2]);
    assert_true(found.together.at.z == p.lights[0].at.z && found.together.colour[1] == 1);
    still_lights_clear(&found);
    p.list.count = 2; /* only one of the two is above the horizon: no sum */
    assert_int_equal(still_lights_find(&p.scene, &found), BTF_OK);
    assert_true(found.count == 0 && !found.directions);
    p.list.count = LIGHTS;
    p.scene.table.cast_shadows = true;
    assert_int_equal(still_lights_find(&p.scene, &found), BTF_OK);
    assert_int_equal(found.count, 0);
    p.scene.table.cast_shadows = false;
    p.lights[2].is_point = true;
    assert_int_equal(still_lights_find(&p.scene, &found), BTF_OK);
    assert_int_equal(found.count, 0);
    tear_down(&p);
    set_up(&p, "plane", 30); /* a perspective */
    assert_int_equal(still_lights_find(&p.scene, &found), BTF_OK);
    assert_int_equal(found.count, LIGHTS - 1);
    assert_false(found.same_view);
    still_lights_clear(&found);
    tear_down(&p);
    set_up(&p, "torus", 0);
    assert_int_equal(still_lights_find(&p.scene, &found), BTF_OK);
    assert_int_equal(found.count, 0);
    tear_down(&p);
}

static shader_request request_for(const btf_material *material, const still_lights *lights) {
    shader_request request = {.device = "reference",
                              .material = material,
                              .variants = 1,
                              .effects = {BTF_EFFECT_ALL},
                              .fixed = lights ? BTF_FIXED_VIEW : 0u,
                              .fold = SHADER_FOLD_ALWAYS,
                              .samples = SAMPLES,
                              .level = -1,
                              .threads = 2};
    if (lights) {
        memcpy(request.fixed_view, lights->view, sizeof request.fixed_view);
        request.lights = lights->count;
        request.light_directions = lights->directions;
        request.light_weights = lights->weights;
    }
    return request;
}

TEST(sums_have_the_bits_of_one_by_one) {
    place p;
    still_lights found;
    shader *summed = NULL, *single = NULL;
    static table_sample samples[SAMPLES];
    static float inputs[SAMPLES * TABLE_INPUTS], weights[3 * SAMPLES], sum[3 * SAMPLES], rgb[3 * SAMPLES],
        expected[3 * SAMPLES];
    btf_material *material = make(8, 8, BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT, BTF_COLOUR_RGB);
    set_up(&p, "plane", 0);
    assert_int_equal(still_lights_find(&p.scene, &found), BTF_OK);
    shader_request request = request_for(material, &found);
    assert_int_equal(shader_create(&request, NULL, &summed), BTF_OK);
    assert_true(shader_shows_sum(summed));
    assert_non_null(strstr(shader_folded(summed), "3 lights and view, "));
    request = request_for(material, NULL);
    assert_int_equal(shader_create(&request, NULL, &single), BTF_OK);
    assert_false(shader_shows_sum(single));
    table_cast(&p.scene.table, 0, SIZE, samples);
    table_light(&p.scene.table, &found.together, SAMPLES, samples, inputs, weights);
    assert_int_equal(shader_run(summed, 0, SIZE, SIZE, inputs, sum, NULL), BTF_OK);
    for (int i = 0; i < LIGHTS; i++) {
        table_light(&p.scene.table, &p.lights[i], SAMPLES, samples, inputs, weights);
        assert_int_equal(shader_run(single, 0, SIZE, SIZE, inputs, rgb, NULL), BTF_OK);
        for (int k = 0; k < 3 * SAMPLES; k++) {
            const float part = rgb[k] * weights[k];
            expected[k] = expected[k] + part;
        }
    }
    int lit = 0;
    for (int k = 0; k < 3 * SAMPLES; k++) {
        lit += sum[k] > 0;
    }
    print_message("%d of %d values are not black\n", lit, 3 * SAMPLES);
    assert_true(lit > SAMPLES / 2);
    assert_memory_equal(sum, expected, sizeof sum);
    shader_destroy(&summed);
    shader_destroy(&single);
    still_lights_clear(&found);
    tear_down(&p);
    btf_material_close(&material);
}

/* In a perspective the sum is folded where the request says that it may be other than to the bit. Under lights and views
 * whose roots are not negative it is the sum of one by one but for rounding. */
TEST(sums_under_a_moving_view_are_near_those_of_one_by_one) {
    place p;
    still_lights found;
    shader *summed = NULL, *single = NULL;
    static table_sample samples[SAMPLES];
    static float inputs[SAMPLES * TABLE_INPUTS], weights[3 * SAMPLES], sum[3 * SAMPLES], rgb[3 * SAMPLES];
    static double expected[3 * SAMPLES];
    btf_material *material = make(8, 8, BTF_EFFECT_RESIDUAL, BTF_COLOUR_NONE); /* blends radiance */
    set_up(&p, "plane", 30);
    assert_int_equal(still_lights_find(&p.scene, &found), BTF_OK);
    shader_request request = request_for(material, &found);
    request.fixed = 0;
    assert_int_equal(shader_create(&request, NULL, &summed), BTF_OK);
    assert_false(shader_shows_sum(summed));
    shader_destroy(&summed);
    request.sum_of_views = true;
    assert_int_equal(shader_create(&request, NULL, &summed), BTF_OK);
    assert_true(shader_shows_sum(summed));
    assert_string_equal(shader_folded(summed), "3 lights, 82944 bytes");
    request = request_for(material, NULL);
    assert_int_equal(shader_create(&request, NULL, &single), BTF_OK);
    table_cast(&p.scene.table, 0, SIZE, samples);
    table_light(&p.scene.table, &found.together, SAMPLES, samples, inputs, weights);
    assert_int_equal(shader_run(summed, 0, SIZE, SIZE, inputs, sum, NULL), BTF_OK);
    for (int i = 0; i < LIGHTS; i++) {
        table_light(&p.scene.table, &p.lights[i], SAMPLES, samples, inputs, weights);
        assert_int_equal(shader_run(single, 0, SIZE, SIZE, inputs, rgb, NULL), BTF_OK);
        for (int k = 0; k < 3 * SAMPLES; k++) {
            expected[k] += (double)rgb[k] * (double)weights[k];
        }
    }
    int lit = 0;
    for (int k = 0; k < 3 * SAMPLES; k++) {
        lit += sum[k] > 0;
        assert_true(fabs((double)sum[k] - expected[k]) <= 16 * 0x1p-24 * expected[k]);
    }
    assert_true(lit > SAMPLES / 4);
    shader_destroy(&summed);
    shader_destroy(&single);
    still_lights_clear(&found);
    tear_down(&p);
    btf_material_close(&material);
}

/* --fold always says why it is not followed; --fold auto keeps silent. */
TEST(folds_that_are_not_made_say_why) {
    file_kept said;
    const btf_log log = file_log_keep(&said);
    btf_material *large = make(900, 900, BTF_EFFECT_RESIDUAL, BTF_COLOUR_NONE);
    shader_request request = request_for(large, NULL);
    request.fixed = BTF_FIXED_LIGHT;
    request.fixed_light[2] = 1;
    btf_shader_options options = shade_fold_options(&request, 0, &log);
    assert_int_equal(options.fold, BTF_FOLD_NONE);
    assert_non_null(
        strstr(said.text, "option --fold always: a fold takes 1049760000 bytes, more than 1000000000"));
    said.text[0] = 0;
    request.fold = SHADER_FOLD_AUTO;
    request.device = "osmesa";
    options = shade_fold_options(&request, 0, &log);
    assert_true(options.fold == BTF_FOLD_NONE && said.text[0] == 0);
    request.fold = SHADER_FOLD_ALWAYS;
    request.fixed |= BTF_FIXED_VIEW; /* radiance takes less */
    request.fixed_view[2] = 1;
    options = shade_fold_options(&request, 0, &log);
    assert_true(options.fold == BTF_FOLD_BOTH && said.text[0] == 0);
    btf_material_close(&large);
    btf_material *material = make(8, 8, 0, BTF_COLOUR_RGB); /* an SBRDF */
    request = request_for(material, NULL);
    request.fixed = BTF_FIXED_LIGHT;
    request.fixed_light[2] = 1;
    options = shade_fold_options(&request, 0, &log);
    assert_int_equal(options.fold, BTF_FOLD_NONE);
    assert_non_null(strstr(said.text, "option --fold always: fold: the material has an SBRDF"));
    btf_material_close(&material);
}

RUN_TESTS(NULL, NULL)
