/* Version 2 of the format in the library: shapes of factors, and what is refused when a material is made.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factors.h"
#include "tests/support/test.h"

static void assert_shape(btf_texture t, btf_format format, int is_array, uint32_t width, uint32_t height,
                         uint32_t layers) {
    assert_int_equal(t.format, format);
    assert_int_equal(t.is_array, is_array);
    assert_int_equal(t.width, width);
    assert_int_equal(t.height, height);
    assert_int_equal(t.layers, layers);
    assert_int_equal(t.size, 16 * (size_t)width * height * layers);
}

TEST(test_shapes) {
    random_state r = {1};
    btf_material_desc desc = factor_material_desc(WIDTH, HEIGHT, VIEWS, LIGHTS, BTF_LAYOUT_TIGHT,
                                                  BTF_EFFECT_SHIFT, factor_classes);
    desc.info.levels = 2;
    desc.info.half_float = 1;
    factor_material_fill(&r, &desc);
    btf_material *m = create_accepted(&desc);
    const btf_material_info info = accepted_info(m);
    assert_int_equal(info.version, 2);
    assert_int_equal(info.components, FACTOR_UNITS);
    assert_int_equal(info.store, BTF_STORE_FACTORS);
    assert_memory_equal(info.factor_classes, factor_classes, sizeof factor_classes);
    assert_shape(btf_material_texture(m, BTF_TEXTURE_FACTOR_TEXELS), BTF_FORMAT_RGBA32UI, 1, WIDTH, HEIGHT,
                 FACTOR_LAYERS);
    assert_shape(btf_material_texture(m, BTF_TEXTURE_FACTOR_DIRECTIONS), BTF_FORMAT_RGBA32UI, 1, LIGHTS,
                 VIEWS, FACTOR_UNITS);
    assert_shape(btf_material_texture(m, BTF_TEXTURE_FACTOR_SCALES), BTF_FORMAT_RGBA32F, 0, FACTOR_UNITS, 1,
                 1);
    assert_shape(btf_material_texture(m, BTF_TEXTURE_FACTOR_VIEWS), BTF_FORMAT_RGBA32F, 0, 3, VIEWS, 1);
    for (int id = BTF_TEXTURE_RESIDUAL_TEXELS; id <= BTF_TEXTURE_RESIDUAL_SCALES; id++) {
        assert_int_equal(btf_material_texture(m, (btf_texture_id)id).format, BTF_FORMAT_NONE);
    }
    assert_shape(btf_material_level_texture(m, 1, BTF_TEXTURE_FACTOR_TEXELS), BTF_FORMAT_RGBA32UI, 1, 2, 2,
                 FACTOR_LAYERS);
    for (int id = BTF_TEXTURE_FACTOR_DIRECTIONS; id <= BTF_TEXTURE_FACTOR_VIEWS; id++) {
        assert_int_equal(btf_material_level_texture(m, 1, (btf_texture_id)id).format, BTF_FORMAT_NONE);
    }
    /* a texel: four layers of halves, shifts of the views, the units */
    const size_t texel = 8 * 4 + 2 * VIEWS + 16 * FACTOR_LAYERS;
    assert_int_equal(btf_level_bytes(&info, 0),
                     texel * WIDTH * HEIGHT + (size_t)16 * LIGHTS * VIEWS * FACTOR_UNITS);
    assert_int_equal(btf_level_bytes(&info, 1), texel * 4);
    assert_int_equal(info.gpu_bytes, btf_level_bytes(&info, 0) + btf_level_bytes(&info, 1));
    assert_int_equal(info.table_bytes, btf_material_texture(m, BTF_TEXTURE_VIEW_TABLE).size +
                                           btf_material_texture(m, BTF_TEXTURE_LIGHT_TABLE).size +
                                           16 * (FACTOR_UNITS + 3 * VIEWS));
    assert_string_equal(btf_texture_name(BTF_TEXTURE_FACTOR_TEXELS), "factor_texels");
    assert_string_equal(btf_texture_name(BTF_TEXTURE_FACTOR_VIEWS), "factor_views");
    assert_int_equal(btf_format_size(BTF_FORMAT_RGBA32UI), 16);
    btf_material_close(&m);
    random_material_free(&desc);
}

/* A desc whose info is changed must be refused with the text. */
static void refused_info(const btf_material_info *info, const char *text) {
    btf_material_desc desc = make_desc(2, BTF_LAYOUT_TIGHT, 0);
    desc.info = *info;
    create_refused(&desc, text);
    random_material_free(&desc);
}

TEST(test_create_classes) {
    btf_material_desc desc = make_desc(2, BTF_LAYOUT_TIGHT, 0);
    const btf_material_info good = desc.info;
    btf_material *m = create_accepted(&desc);
    btf_material_close(&m);
    random_material_free(&desc);

    btf_material_info info = good;
    info.factor_classes[2][0] = 2;
    refused_info(&info, "factorClasses: the classes have 8 units in all, the residual has 9");
    info = good;
    info.factor_classes[4][0] = 257;
    refused_info(&info, "factorClasses: class 4 has 257 units (at most 256)");
    info = good;
    info.factor_classes[4][0] = UINT32_MAX;
    refused_info(&info, "factorClasses: class 4 has 4294967295 units");
    info = good;
    info.factor_classes[1][1] = 5;
    refused_info(&info, "factorClasses: class 1 has 1 units (at most 256) with 5 words of C1");
    info = good;
    info.factor_classes[1][2] = 4;
    refused_info(&info, "with 1 words of C1 and 4 of C2 (at most 4 a unit)");
    info.factor_classes[1][2] = UINT32_MAX;
    refused_info(&info, "with 1 words of C1 and 4294967295 of C2");
    info = good;
    memset(info.factor_classes, 0, sizeof info.factor_classes);
    info.factor_classes[3][0] = info.components = 129;
    refused_info(&info, "factorClasses: 258 layers of factor_texels, not 1 to 256");
    info = good;
    info.components = 257;
    refused_info(&info, "257");
    info = good;
    info.store = BTF_STORE_COMPONENTS;
    info.horizon_scale = 1;
    refused_info(&info, "factorClasses: the classes have 9 units in all, the residual has 0");
    info = good;
    info.store = (btf_store)2;
    refused_info(&info, "unknown store 2 of the residual");
    info = good;
    info.effects = 0;
    info.components = 0;
    refused_info(&info, "factors without the effect residual");
}

/* As many units and layers as may be. */
TEST(test_most_units) {
    static const uint32_t classes[2][BTF_FACTOR_CLASSES][3] = {
        {{0}, {128, 500, 12}}, {{100, 0, 400}, {0}, {56}, {0}, {100, 1, 399}}};
    static const uint32_t units[2] = {128, 256};
    for (int i = 0; i < 2; i++) {
        random_state r = {3};
        btf_material_desc desc = factor_material_desc(1, 1, 1, 1, BTF_LAYOUT_TIGHT, 0, classes[i]);
        factor_material_fill(&r, &desc);
        btf_material *m = create_accepted(&desc);
        assert_int_equal(accepted_info(m).components, units[i]);
        assert_int_equal(btf_material_texture(m, BTF_TEXTURE_FACTOR_TEXELS).layers, 256);
        btf_material_close(&m);
        random_material_free(&desc);
    }
}

TEST(test_create_numbers) {
    btf_material_desc desc = make_desc(4, BTF_LAYOUT_TIGHT, 0);
    const btf_material_info good = desc.info;
    static const float bad_horizon[] = {0.999f, -1, NAN, INFINITY, 0x1.000002p24f};
    for (size_t i = 0; i < sizeof bad_horizon / sizeof *bad_horizon; i++) {
        desc.info.horizon_scale = bad_horizon[i];
        create_refused(&desc, "is not within 1 to 2^24");
    }
    desc.info.horizon_scale = 0x1p24f;
    btf_material *m = create_accepted(&desc);
    btf_material_close(&m);
    desc.info.horizon_scale = 0; /* 0 in a desc means 1 */
    m = create_accepted(&desc);
    assert_true(accepted_info(m).horizon_scale == 1);
    btf_material_close(&m);
    desc.info = good;
    desc.info.domain = BTF_DOMAIN_LINEAR;
    m = create_accepted(&desc);
    btf_material_close(&m);
    desc.info.blend = BTF_BLEND_ROOTS;
    create_refused(&desc, "blend roots needs domain sqrt");
    desc.info.domain = BTF_DOMAIN_SQRT;
    desc.info.blend = (btf_blend)2;
    create_refused(&desc, "unknown blend 2");
    random_material_free(&desc);

    desc = random_material_desc(2, 2, 3, 3, BTF_LAYOUT_TIGHT, 0);
    random_state r = {5};
    random_material_fill(&r, &desc);
    desc.info.horizon_scale = 2;
    create_refused(&desc, "horizonScale is 2; without factors it must be 1");
    random_material_free(&desc);
}

TEST(test_create_codes) {
    btf_material_desc desc = make_desc(6, BTF_LAYOUT_TIGHT, 0);
    /* the second unit of class 0 is layer 1 of both; G of (3, 2), byte 2 */
    uint32_t *word =
        factor_words(&desc, BTF_TEXTURE_FACTOR_TEXELS) + 4 * ((1 * HEIGHT + 2) * WIDTH + 3) + 1;
    uint32_t kept = *word;
    *word = (*word & 0xFF00FFFFu) | 0x00800000u;
    create_refused(&desc, "factor_texels: unit 1 at (3, 2): byte 2 of channel G is -128");
    *word = kept;
    word = factor_words(&desc, BTF_TEXTURE_FACTOR_DIRECTIONS) + 4 * ((0 * VIEWS + 7) * LIGHTS + 6) + 3;
    kept = *word;
    *word = (*word & 0x00FFFFFFu) | 0x80000000u;
    create_refused(&desc, "factor_directions: unit 0 at (6, 7): byte 3 of channel A is -128");
    *word = kept;
    /* units of other classes than 0 may hold any byte */
    word = factor_words(&desc, BTF_TEXTURE_FACTOR_TEXELS) + 4 * (2 * HEIGHT * WIDTH);
    *word = 0x80808080u;
    word = factor_words(&desc, BTF_TEXTURE_FACTOR_DIRECTIONS) + 4 * (2 * VIEWS * LIGHTS);
    *word = 0x80808080u;
    btf_material *m = create_accepted(&desc);
    btf_material_close(&m);
    random_material_free(&desc);
}

TEST(test_create_scales) {
    static const float bad[] = {0x1.fffffep-25f, -0x1.000002p24f, NAN, -INFINITY, 1e-42f};
    btf_material_desc desc = make_desc(7, BTF_LAYOUT_TIGHT, 0);
    float *scales = factor_numbers(&desc, BTF_TEXTURE_FACTOR_SCALES),
          *views = factor_numbers(&desc, BTF_TEXTURE_FACTOR_VIEWS);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const float scale = scales[5], factor = views[4 * 4 + 1];
        scales[5] = bad[i];
        create_refused(&desc, "factorScales: number 5 is ");
        scales[5] = scale;
        views[4 * 4 + 1] = bad[i]; /* view 1, tier 1, C1: number 1 * 9 + 1 * 3 + 1 */
        create_refused(&desc, "factorViews: number 13 is ");
        views[4 * 4 + 1] = factor;
    }
    /* Those of classes 0, 1 and 3, and the first of class 4; all of class 2 are whole. */
    static const bool mixed[FACTOR_UNITS] = {1, 1, 1, 0, 0, 0, 1, 1, 0};
    for (int unit = 0; unit < FACTOR_UNITS; unit++) {
        for (int word = 0; word < 4; word++) {
            const float scale = scales[4 * unit + word];
            scales[4 * unit + word] = 3.5f;
            if (mixed[unit]) {
                btf_material *m = create_accepted(&desc);
                btf_material_close(&m);
            } else {
                create_refused(&desc, told("factorScales: unit %d, all of Y, has the scales", unit));
            }
            scales[4 * unit + word] = scale;
        }
    }
    views[3 + 4 * 7] = 1; /* view 2, tier 1 */
    create_refused(&desc, "factor_views: A of view 2, tier 1 is 1, not 0");
    views[3 + 4 * 7] = -0.0f;
    views[0] = -0.0f;
    scales[0] = -0.0f;
    btf_material *m = create_accepted(&desc);
    const float *made = btf_material_texture(m, BTF_TEXTURE_FACTOR_VIEWS).data;
    assert_false(signbit(made[3 + 4 * 7]));
    assert_false(signbit(made[0]));
    assert_false(signbit(*(const float *)btf_material_texture(m, BTF_TEXTURE_FACTOR_SCALES).data));
    btf_material_close(&m);
    random_material_free(&desc);
}

/* The limits themselves are no error. */
TEST(test_extreme_scales) {
    btf_material_desc desc = make_desc(8, BTF_LAYOUT_TIGHT, 0);
    float *scales = factor_numbers(&desc, BTF_TEXTURE_FACTOR_SCALES),
          *views = factor_numbers(&desc, BTF_TEXTURE_FACTOR_VIEWS);
    for (int i = 0; i < 4 * FACTOR_UNITS; i++) {
        scales[i] = i / 4 % 2 ? 0x1p24f : -0x1p-24f;
    }
    for (int i = 0; i < 12 * VIEWS; i++) {
        views[i] = i % 4 == 3 ? 0 : i % 2 ? -0x1p24f : 0x1p-24f;
    }
    btf_material *m = create_accepted(&desc);
    btf_material_close(&m);
    random_material_free(&desc);
}

RUN_TESTS(NULL, NULL)
