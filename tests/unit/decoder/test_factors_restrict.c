/* Parts of a material of version 2: restrictions, the other layout, effect errors by units, more directions than
 * layers.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factors.h"
#include "tests/support/test.h"
#include <openbtf/plan.h>

static uint32_t number_of(const btf_directions *whole, const float xyz[3]) {
    for (uint32_t i = 0; i < whole->count; i++) {
        if (memcmp(whole->xyz + 3 * (size_t)i, xyz, 3 * sizeof *xyz) == 0) {
            return i;
        }
    }
    fail_msg("a direction that the whole material has not");
    return 0;
}

/* `small` holds the first units of `whole`, for the views and lights that are left. */
static void assert_first_units(const btf_material *whole, const btf_material *small, uint32_t level) {
    const btf_material_info info = accepted_info(whole), less = accepted_info(small);
    const btf_directions views = btf_material_views(whole), lights = btf_material_lights(whole),
                         some_views = btf_material_views(small), some_lights = btf_material_lights(small);
    for (uint32_t i = 0; i < less.levels; i++) {
        const btf_texture a = btf_material_level_texture(whole, level + i, BTF_TEXTURE_FACTOR_TEXELS),
                          b = btf_material_level_texture(small, i, BTF_TEXTURE_FACTOR_TEXELS);
        assert_int_equal(a.width, b.width);
        assert_int_equal(a.height, b.height);
        assert_memory_equal(a.data, b.data, b.size);
    }
    const uint32_t *w = btf_material_texture(whole, BTF_TEXTURE_FACTOR_DIRECTIONS).data,
                   *of_small = btf_material_texture(small, BTF_TEXTURE_FACTOR_DIRECTIONS).data;
    const float *factors = btf_material_texture(whole, BTF_TEXTURE_FACTOR_VIEWS).data,
                *some_factors = btf_material_texture(small, BTF_TEXTURE_FACTOR_VIEWS).data;
    for (uint32_t v = 0; v < less.n_views; v++) {
        const size_t view = number_of(&views, some_views.xyz + 3 * (size_t)v);
        assert_memory_equal(some_factors + 12 * (size_t)v, factors + 12 * view, 12 * sizeof *factors);
        for (uint32_t l = 0; l < less.n_lights; l++) {
            const size_t light = number_of(&lights, some_lights.xyz + 3 * (size_t)l);
            for (size_t unit = 0; unit < less.components; unit++) {
                assert_memory_equal(of_small + 4 * ((unit * less.n_views + v) * less.n_lights + l),
                                    w + 4 * ((unit * info.n_views + view) * info.n_lights + light), 16);
            }
        }
    }
    assert_memory_equal(btf_material_texture(small, BTF_TEXTURE_FACTOR_SCALES).data,
                        btf_material_texture(whole, BTF_TEXTURE_FACTOR_SCALES).data, 16 * less.components);
}

/* Classes of the first 0 to 9 units, and their layers of factor_texels. */
static const uint32_t first_classes[FACTOR_UNITS + 1][BTF_FACTOR_CLASSES][3] = {
    {{0}},
    {{1, 3, 1}},
    {{2, 3, 2}},
    {{2, 3, 2}, {1, 1, 1}},
    {{2, 3, 2}, {1, 1, 1}, {1}},
    {{2, 3, 2}, {1, 1, 1}, {2}},
    {{2, 3, 2}, {1, 1, 1}, {3}},
    {{2, 3, 2}, {1, 1, 1}, {3}, {1, 2, 0}},
    {{2, 3, 2}, {1, 1, 1}, {3}, {1, 2, 0}, {1, 0, 1}},
    {{2, 3, 2}, {1, 1, 1}, {3}, {1, 2, 0}, {2, 0, 1}},
};
static const uint32_t first_layers[FACTOR_UNITS + 1] = {0, 1, 2, 4, 5, 6, 7, 9, 10, 11};

TEST(test_restrict) {
    random_state r = {13};
    int fewer = 0;
    for (int round = 0; round < 40; round++) {
        const btf_layout layout = round % 4 ? BTF_LAYOUT_TIGHT : BTF_LAYOUT_PAPER;
        btf_material_desc desc = factor_material_desc(9, 6, 37, 37, layout,
                                                      round & 1 ? BTF_EFFECT_VERSION_1 : 0, factor_classes);
        desc.info.levels = layout == BTF_LAYOUT_TIGHT ? 3 : 1;
        desc.info.blend = round & 2 ? BTF_BLEND_ROOTS : BTF_BLEND_RADIANCE;
        factor_material_fill(&r, &desc);
        uint16_t *preview = make_preview(9, 6);
        desc.preview = preview;
        btf_material *whole = create_accepted(&desc), *small;
        const uint32_t units = (uint32_t)round % (FACTOR_UNITS + 1);
        btf_plan plan = {.struct_size = sizeof plan,
                         .scene = {.struct_size = sizeof plan.scene,
                                   .view.theta = {0, 30},
                                   .light = {.fixed = round % 3 == 0, .direction = {0, 0.6f, 0.8f}}},
                         .effects = units ? desc.info.effects : BTF_EFFECT_SHADOW,
                         .components = units,
                         .level = desc.info.levels > 1 ? random_below(&r, 3) : 0};
        assert_int_equal(btf_material_restrict(whole, &plan, &log_keep, &small), BTF_OK);
        const btf_material_info less = accepted_info(small);
        fewer += less.n_views < 37 && less.n_lights < 37;
        assert_int_equal(less.components, units);
        assert_int_equal(less.store, units ? BTF_STORE_FACTORS : BTF_STORE_COMPONENTS);
        assert_int_equal(less.blend, desc.info.blend);
        assert_true(less.horizon_scale == (units ? desc.info.horizon_scale : 1));
        assert_int_equal(less.version, units || desc.info.blend ? 2 : 1);
        assert_memory_equal(less.factor_classes, first_classes[units], sizeof less.factor_classes);
        assert_int_equal(btf_material_texture(small, BTF_TEXTURE_FACTOR_TEXELS).layers,
                         first_layers[units]);
        if (units) {
            assert_first_units(whole, small, plan.level);
        }
        assert_int_equal(btf_material_preview(small) != NULL, plan.level == 0 && less.version == 2);
        if (btf_material_preview(small)) {
            assert_memory_equal(btf_material_preview(small), preview, 9 * 6 * 8);
        }
        void *data; /* a restriction can be saved like any material */
        size_t size;
        btf_material *back;
        assert_int_equal(btf_material_save_memory(small, NULL, &data, &size), BTF_OK);
        assert_int_equal(btf_material_open_memory(data, size, &log_keep, &back), BTF_OK);
        assert_same_material(small, back);
        btf_free(data);
        btf_material_close(&back);
        btf_material_close(&small);
        btf_material_close(&whole);
        free(preview);
        random_material_free(&desc);
    }
    assert_true(fewer > 5);
}

TEST(test_to_tight) {
    btf_material_desc desc = make_desc(14, BTF_LAYOUT_PAPER, BTF_EFFECT_VERSION_1);
    desc.info.blend = BTF_BLEND_ROOTS;
    btf_material *paper = create_accepted(&desc), *tight;
    assert_int_equal(btf_material_to_tight(paper, &log_keep, &tight), BTF_OK);
    const btf_material_info info = accepted_info(tight);
    assert_int_equal(info.layout, BTF_LAYOUT_TIGHT);
    assert_int_equal(info.blend, BTF_BLEND_ROOTS);
    assert_memory_equal(info.factor_classes, factor_classes, sizeof factor_classes);
    for (int id = BTF_TEXTURE_FACTOR_TEXELS; id <= BTF_TEXTURE_FACTOR_VIEWS; id++) {
        const btf_texture a = btf_material_texture(paper, (btf_texture_id)id),
                          b = btf_material_texture(tight, (btf_texture_id)id);
        assert_int_equal(a.size, b.size);
        assert_memory_equal(a.data, b.data, a.size);
    }
    btf_material_close(&tight);
    btf_material_close(&paper);
    random_material_free(&desc);
}

/* Rows count units: 0 to as many as there are. */
TEST(test_effect_errors) {
    const uint32_t effects = BTF_EFFECT_SHADOW | BTF_EFFECT_RESIDUAL;
    float table[] = {1,
                     1,
                     0,
                     75,
                     0,
                     75,
                     (float)effects,
                     FACTOR_UNITS,
                     0,
                     0,
                     1000,
                     0.01f,
                     0.02f,
                     (float)effects,
                     4,
                     0,
                     0,
                     900,
                     0.0101f,
                     0.0201f};
    btf_material_desc desc = make_desc(15, BTF_LAYOUT_TIGHT, BTF_EFFECT_SHADOW);
    desc.effect_errors = table;
    desc.effect_error_count = sizeof table / sizeof *table;
    btf_material *m = create_accepted(&desc), *small;
    btf_plan plan;
    const btf_scene scene = {.struct_size = sizeof scene};
    assert_int_equal(btf_plan_effects(m, &scene, 0.5f, &plan), BTF_OK);
    assert_true(plan.measured);
    assert_int_equal(plan.components, 4);
    assert_int_equal(plan.shader.components, 4);
    assert_int_equal(plan.textures >> BTF_TEXTURE_FACTOR_TEXELS, 15);
    assert_int_equal(plan.textures >> BTF_TEXTURE_RESIDUAL_TEXELS & 7, 0);
    assert_int_equal(btf_material_restrict(m, &plan, NULL, &small), BTF_OK);
    assert_int_equal(accepted_info(small).gpu_bytes, plan.gpu_bytes);
    const size_t layers = FACTOR_LAYERS - first_layers[4], units = FACTOR_UNITS - 4;
    assert_int_equal(plan.gpu_bytes,
                     plan.full_gpu_bytes - 16 * (layers * WIDTH * HEIGHT + units * VIEWS * LIGHTS));
    btf_material_close(&small);
    btf_material_close(&m);
    table[7] = FACTOR_UNITS + 1;
    create_refused(&desc, "effect errors: row 0 has 10 components");
    random_material_free(&desc);
}

/* More directions than the layers of a texture need version 2, and no texture with a layer for each of them. */
TEST(test_many_directions) {
    static const uint32_t classes[BTF_FACTOR_CLASSES][3] = {{0}, {0}, {1}};
    random_state r = {16};
    btf_material_desc desc =
        factor_material_desc(2, 2, 5, 1000, BTF_LAYOUT_TIGHT, BTF_EFFECT_SHIFT, classes);
    factor_material_fill(&r, &desc);
    round_trip(&desc);
    btf_material *whole = create_accepted(&desc), *small;
    const btf_plan plan = {.struct_size = sizeof plan,
                           .scene = {.struct_size = sizeof plan.scene, .light.theta = {0, 20}},
                           .effects = BTF_EFFECT_RESIDUAL};
    assert_int_equal(btf_material_restrict(whole, &plan, &log_keep, &small), BTF_OK);
    assert_in_range(accepted_info(small).n_lights, 20, 400);
    assert_first_units(whole, small, 0);
    btf_material_close(&small);
    btf_material_close(&whole);
    desc.info.effects |= BTF_EFFECT_SHADOW;
    create_refused(&desc, "1000 lights; with the effect shadow there are 1 to 256");
    random_material_free(&desc);

    desc = random_material_desc(2, 2, BTF_MAX_DIRECTIONS, 2, BTF_LAYOUT_PAPER, 0);
    random_material_fill(&r, &desc);
    round_trip(&desc);
    btf_material *m = create_accepted(&desc);
    assert_int_equal(accepted_info(m).version, 2);
    saved s = save_material(m);
    edit_file *e = take(&s);
    assert_int_equal(edit_find_attribute(e, "openbtf.version")->i, 2);
    edit_find_attribute(e, "openbtf.version")->i = 1;
    file_refused(e, "attribute openbtf.views holds 12288 numbers, which are not 1 to 256 groups of 3");
    btf_free(s.data);
    btf_material_close(&m);
    static const uint32_t layered[] = {BTF_EFFECT_SHIFT, BTF_EFFECT_HIDDEN, BTF_EFFECT_GAIN};
    for (size_t i = 0; i < sizeof layered / sizeof *layered; i++) {
        desc.info.effects = layered[i];
        create_refused(&desc, "4096 views; with the effect shift, hidden or gain there are 1 to 256");
    }
    desc.info.effects = 0;
    desc.info.n_views++;
    create_refused(&desc, "4097 views, not 1 to 4096");
    random_material_free(&desc);
}

RUN_TESTS(NULL, NULL)
