/* The counts of btf-bench: fetches, bytes and operations of a pixel, against counts by hand.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/bench/decode/decode_cost.h"
#include "tests/support/test.h"

static void expect(decode_cost cost, int fetches, int bytes, int integers, int floats) {
    assert_int_equal((int)cost.fetches, fetches);
    assert_int_equal((int)cost.bytes, bytes);
    assert_int_equal((int)cost.integers, integers);
    assert_int_equal((int)cost.floats, floats);
}

static btf_material_info components_info(uint32_t count) {
    return (btf_material_info){.layout = BTF_LAYOUT_PAPER,
                               .domain = BTF_DOMAIN_SQRT,
                               .colour = BTF_COLOUR_NONE,
                               .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL,
                               .components = count};
}

static btf_material_info factors_info(const uint32_t classes[BTF_FACTOR_CLASSES][3], uint32_t effects) {
    btf_material_info info = {.layout = BTF_LAYOUT_TIGHT,
                              .domain = BTF_DOMAIN_SQRT,
                              .colour = BTF_COLOUR_NONE,
                              .effects = BTF_EFFECT_RESIDUAL | effects,
                              .store = BTF_STORE_FACTORS};
    memcpy(info.factor_classes, classes, sizeof info.factor_classes);
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        info.components += classes[c][0];
    }
    return info;
}

/* 14 groups in 3 views: 9 texels of V, one of U and of the scales each; 3 texels of the maps. */
TEST(test_components) {
    const btf_material_info info = components_info(56);
    btf_shader_options shader = {0};
    expect(decode_cost_of(&info, &shader), 42 * 11 + 3, 42 * (9 * 4 + 16 + 4) + 3 * 4, 42 * 72, 42 * 48);
    expect(decode_cost_of(&info, &shader), 465, 2364, 3024, 2016);
    shader.components = 16;
    expect(decode_cost_of(&info, &shader), 135, 684, 864, 576);
    shader.components = 0;
    shader.interpolation = BTF_INTERPOLATION_NEAREST;
    expect(decode_cost_of(&info, &shader), 14 * 5 + 1, 14 * (3 * 4 + 16 + 4) + 4, 14 * 24, 14 * 48);
    shader.interpolation = BTF_INTERPOLATION_LINEAR;
    shader.fixed = BTF_FIXED_VIEW;
    expect(decode_cost_of(&info, &shader), 14 * 11 + 1, 14 * 56 + 4, 14 * 72, 14 * 48);
    shader.fixed = BTF_FIXED_LIGHT;
    expect(decode_cost_of(&info, &shader), 42 * 5 + 3, 42 * 32 + 12, 42 * 24, 42 * 48);
    shader.fixed = 0;
    shader.filter = BTF_FILTER_BILINEAR;
    expect(decode_cost_of(&info, &shader), 42 * 14 + 12, 42 * (36 + 16 + 16) + 48, 42 * 72,
           42 * (16 + 128));
    shader.leave_out = BTF_EFFECT_ALL;
    expect(decode_cost_of(&info, &shader), 0, 0, 0, 0);
}

/* One unit of Y in class 2: u takes 4 words of 19 operations and 5 more; a dot product 4 of 15 and 5. */
TEST(test_unit) {
    const uint32_t classes[BTF_FACTOR_CLASSES][3] = {[2] = {1, 0, 0}};
    const btf_material_info info = factors_info(classes, 0);
    btf_shader_options shader = {.interpolation = BTF_INTERPOLATION_NEAREST};
    expect(decode_cost_of(&info, &shader), 4, 64, 96 + 65 + 3, 1 + 3 + 6 + 6);
    shader.interpolation = BTF_INTERPOLATION_LINEAR;
    expect(decode_cost_of(&info, &shader), 9 + 1 + 1 + 3, 14 * 16, 96 + 3 * (3 * 65 + 7), 1 + 3 * 15);
    shader.filter = BTF_FILTER_BILINEAR;
    /* of 15 operations on a word 8 bring up the codes of w, which is done once for four texels */
    expect(decode_cost_of(&info, &shader), 9 + 4 + 1 + 3, 17 * 16, 9 * 32 + 4 * (96 + 3 * (3 * 33 + 7)),
           1 + 12 * 15);
}

/* One word of colour makes a unit be evaluated word by word: four sums, conversions and scales. */
TEST(test_mixed) {
    const uint32_t classes[BTF_FACTOR_CLASSES][3] = {[2] = {1, 1, 0}};
    const btf_material_info info = factors_info(classes, 0);
    const btf_shader_options shader = {0};
    expect(decode_cost_of(&info, &shader), 14, 14 * 16, 96 + 3 * (3 * 68 + 4 * 7), 4 + 3 * (12 + 12));
}

/* With relief u is read for each view, the scales once. There are four marches of 9 steps: the pixel's, and one for
 * each of the three views. */
TEST(test_relief) {
    const uint32_t classes[BTF_FACTOR_CLASSES][3] = {[2] = {1, 0, 0}};
    btf_material_info info = factors_info(classes, BTF_EFFECT_RELIEF);
    btf_shader_options shader = {0};
    info.relief_step = 900;
    info.relief_steps = 8;
    expect(decode_cost_of(&info, &shader), 9 + 3 + 1 + 3 + 3 + 36, 19 * 16 + 36,
           3 * (96 + 3 * 65 + 7) + 36 * 13, 1 + 3 * 15);
    shader.filter = BTF_FILTER_STEEP;
    expect(decode_cost_of(&info, &shader), 9 + 12 + 1 + 3 + 3 + 36, 28 * 16 + 36,
           9 * 32 + 12 * (96 + 3 * 33 + 7) + 36 * 13, 1 + 12 * 15);
    shader.filter = BTF_FILTER_TEXEL;
    shader.interpolation = BTF_INTERPOLATION_NEAREST;
    expect(decode_cost_of(&info, &shader), 5 + 9, 5 * 16 + 9, 96 + 65 + 3 + 9 * 13, 1 + 3 + 6 + 6);
    info.relief_step = 0;
    expect(decode_cost_of(&info, &shader), 5, 5 * 16, 96 + 65 + 3, 1 + 3 + 6 + 6);
}

/* Indices and shifts of points are read twice where all sources are found before a view is decoded. Gloss moves each
 * view's light, at 60 operations and a power; a fixed light then saves nothing. */
TEST(test_between) {
    const uint32_t classes[BTF_FACTOR_CLASSES][3] = {[2] = {1, 0, 0}};
    btf_material_info info = factors_info(classes, BTF_EFFECT_RELIEF | BTF_EFFECT_SHIFT);
    btf_shader_options shader = {0};
    info.point_store = BTF_POINTS_LISTS;
    expect(decode_cost_of(&info, &shader), 9 + 3 + 1 + 3 + 3 + 12, 19 * 16 + 18, 3 * (96 + 3 * 65 + 7), 1 + 3 * 15);
    info = factors_info(classes, BTF_EFFECT_GLOSS);
    shader.fixed = BTF_FIXED_LIGHT;
    expect(decode_cost_of(&info, &shader), 9 + 1 + 1 + 3 + 3, 17 * 16, 96 + 3 * (3 * 65 + 7) + 18,
           1 + 3 * 15 + 3 * 95);
}

/* Where each view has a source of its own, u and the scales are read for each, with a shift. */
TEST(test_shift) {
    const uint32_t classes[BTF_FACTOR_CLASSES][3] = {[2] = {1, 0, 0}};
    const btf_material_info info = factors_info(classes, BTF_EFFECT_SHIFT);
    btf_shader_options shader = {0};
    expect(decode_cost_of(&info, &shader), 9 + 3 + 3 + 3 + 3, 18 * 16 + 3 * 2, 3 * (96 + 3 * 65 + 7),
           3 + 3 * 15);
    /* Gain and shift of a view in one texel. */
    btf_material_info packed = factors_info(classes, BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN);
    expect(decode_cost_of(&packed, &shader), 24, 18 * 16 + 3 * 3, 3 * (96 + 3 * 65 + 7), 3 + 3 * 15);
    packed.point_store = BTF_POINTS_PACKED;
    expect(decode_cost_of(&packed, &shader), 21, 18 * 16 + 3 * 2, 3 * (96 + 3 * 65 + 7), 3 + 3 * 15);
    packed.point_store = BTF_POINTS_LISTS;
    expect(decode_cost_of(&packed, &shader), 24, 18 * 16 + 3 * 3, 3 * (96 + 3 * 65 + 7), 3 + 3 * 15);
    shader.leave_out = BTF_EFFECT_SHIFT;
    expect(decode_cost_of(&info, &shader), 14, 14 * 16, 96 + 3 * (3 * 65 + 7), 1 + 3 * 15);
}

/* 13 units: 117 texels of w, 15 of u, 13 of scales and 9 of the views' factors. Operations of integers: in
 * each view and light 917 of the dot products by class, 384 of the blend of lights, 1184 that expand u. */
TEST(test_units) {
    const uint32_t classes[BTF_FACTOR_CLASSES][3] = {{2, 2, 1}, {1, 0, 0}, {5, 0, 0}, {1, 0, 0}, {4, 0, 0}};
    const btf_material_info info = factors_info(classes, 0);
    btf_shader_options shader = {0};
    decode_cost cost = decode_cost_of(&info, &shader);
    assert_int_equal((int)cost.fetches, 117 + 15 + 13 + 9);
    assert_int_equal((int)cost.bytes, 16 * 154);
    assert_int_equal((int)cost.integers, 9 * (112 + 67 + 325 + 129 + 284) + 384 + 1184);
    assert_int_equal((int)cost.floats, 19 + 3 * (3 * 19 + 3 * 6 + 6));
    /* The first six units: classes 0 and 1, three of class 2, and two tiers. */
    shader.components = 6;
    cost = decode_cost_of(&info, &shader);
    assert_int_equal((int)cost.fetches, 54 + 7 + 6 + 6);
    /* Colour that is cut off with its unit does not count. */
    const uint32_t late[BTF_FACTOR_CLASSES][3] = {{1, 0, 0}, {0}, {2, 4, 1}, {0}, {0}},
                   early[BTF_FACTOR_CLASSES][3] = {{1, 0, 0}, {0}, {1, 4, 0}, {0}, {0}};
    const btf_material_info whole = factors_info(late, 0), cut = factors_info(early, 0);
    shader.components = 2;
    cost = decode_cost_of(&whole, &shader);
    const decode_cost same = decode_cost_of(&cut, &shader);
    assert_memory_equal(&cost, &same, sizeof cost);
}

/* Three lobes of mono: 4 texels of parameters, 3 lights' shadows; a power is 35 float operations,
 * natively 3. */
TEST(test_sbrdf) {
    const btf_material_info info = {
        .layout = BTF_LAYOUT_PAPER, .colour = BTF_COLOUR_MONO, .lobes = 3, .effects = BTF_EFFECT_SHADOW};
    btf_shader_options shader = {0};
    expect(decode_cost_of(&info, &shader), 3 * (4 + 3), 3 * (4 * 16 + 3 * 4), 3 * (3 * 6 + 6),
           3 * (3 * (35 + 6) + 3 + 5));
    shader.math = BTF_MATH_FAST;
    expect(decode_cost_of(&info, &shader), 21, 228, 3 * 6, 3 * (3 * (3 + 6) + 3 + 5));
    const btf_material_info rgb = {
        .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_RGB, .lobes = 2, .half_float = 1};
    shader.math = BTF_MATH_EXACT;
    expect(decode_cost_of(&rgb, &shader), 3 * 5, 3 * 5 * 8, 3 * 2 * 6, 3 * 2 * (35 + 11));
}

TEST(test_peers) {
    expect(decode_cost_pca(10), 3 * 29, 3 * (28 * 4 + 16), 0, 3 * 356);
    expect(decode_cost_lookup(), 9, 36, 0, 54);
}

RUN_TESTS(NULL, NULL)
