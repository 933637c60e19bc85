/* Version 2 of the format in the library: shapes, what is refused when a material is made or opened, the
 * way through a file, restriction.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/support/exr_edit.h"
#include "tests/support/factor_material.h"
#include "tests/support/refusals.h"
#include <math.h>
#include <openbtf/plan.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WIDTH = 5, HEIGHT = 4, VIEWS = 8, LIGHTS = 7 };

static btf_material_desc make_desc(uint64_t seed, btf_layout layout, uint32_t effects) {
    random_state r = {seed};
    btf_material_desc desc =
        factor_material_desc(WIDTH, HEIGHT, VIEWS, LIGHTS, layout, effects, factor_classes);
    factor_material_fill(&r, &desc);
    return desc;
}

/* Halves that differ from one another, and 0 in every fourth. */
static uint16_t *make_preview(uint32_t width, uint32_t height) {
    uint16_t *preview = malloc(8 * (size_t)width * height);
    assert_non_null(preview);
    for (size_t i = 0; i < 4 * (size_t)width * height; i++)
        preview[i] = i % 4 == 3 ? 0 : (uint16_t)(0x3000 + i);
    return preview;
}

static btf_material_info info_of(const btf_material *material) {
    btf_material_info info = {.struct_size = sizeof info};
    assert_int_equal(btf_material_get_info(material, &info), BTF_OK);
    return info;
}

static void assert_shape(btf_texture t, btf_format format, int is_array, uint32_t width, uint32_t height,
                         uint32_t layers) {
    assert_int_equal(t.format, format);
    assert_int_equal(t.is_array, is_array);
    assert_int_equal(t.width, width);
    assert_int_equal(t.height, height);
    assert_int_equal(t.layers, layers);
    assert_int_equal(t.size, 16 * (size_t)width * height * layers);
}

static void test_shapes(void **state) {
    (void)state;
    random_state r = {1};
    btf_material_desc desc = factor_material_desc(WIDTH, HEIGHT, VIEWS, LIGHTS, BTF_LAYOUT_TIGHT,
                                                  BTF_EFFECT_SHIFT, factor_classes);
    desc.info.levels = 2;
    desc.info.half_float = 1;
    factor_material_fill(&r, &desc);
    btf_material *m = create_accepted(&desc);
    const btf_material_info info = info_of(m);
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
    for (int id = BTF_TEXTURE_RESIDUAL_TEXELS; id <= BTF_TEXTURE_RESIDUAL_SCALES; id++)
        assert_int_equal(btf_material_texture(m, (btf_texture_id)id).format, BTF_FORMAT_NONE);
    assert_shape(btf_material_level_texture(m, 1, BTF_TEXTURE_FACTOR_TEXELS), BTF_FORMAT_RGBA32UI, 1, 2, 2,
                 FACTOR_LAYERS);
    for (int id = BTF_TEXTURE_FACTOR_DIRECTIONS; id <= BTF_TEXTURE_FACTOR_VIEWS; id++)
        assert_int_equal(btf_material_level_texture(m, 1, (btf_texture_id)id).format, BTF_FORMAT_NONE);
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

static void test_create_classes(void **state) {
    (void)state;
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
static void test_most_units(void **state) {
    (void)state;
    static const uint32_t classes[2][BTF_FACTOR_CLASSES][3] = {
        {{0}, {128, 500, 12}}, {{100, 0, 400}, {0}, {56}, {0}, {100, 1, 399}}};
    static const uint32_t units[2] = {128, 256};
    for (int i = 0; i < 2; i++) {
        random_state r = {3};
        btf_material_desc desc = factor_material_desc(1, 1, 1, 1, BTF_LAYOUT_TIGHT, 0, classes[i]);
        factor_material_fill(&r, &desc);
        btf_material *m = create_accepted(&desc);
        assert_int_equal(info_of(m).components, units[i]);
        assert_int_equal(btf_material_texture(m, BTF_TEXTURE_FACTOR_TEXELS).layers, 256);
        btf_material_close(&m);
        random_material_free(&desc);
    }
}

static void test_create_numbers(void **state) {
    (void)state;
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
    desc.info.horizon_scale = 0; /* as an input 1 */
    m = create_accepted(&desc);
    assert_true(info_of(m).horizon_scale == 1);
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

static void test_create_codes(void **state) {
    (void)state;
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

static void test_create_scales(void **state) {
    (void)state;
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
    for (int unit = 0; unit < FACTOR_UNITS; unit++)
        for (int word = 0; word < 4; word++) {
            const float scale = scales[4 * unit + word];
            scales[4 * unit + word] = 3.5f;
            if (mixed[unit]) {
                btf_material *m = create_accepted(&desc);
                btf_material_close(&m);
            } else {
                char text[64];
                snprintf(text, sizeof text, "factorScales: unit %d, all of Y, has the scales", unit);
                create_refused(&desc, text);
            }
            scales[4 * unit + word] = scale;
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
static void test_extreme_scales(void **state) {
    (void)state;
    btf_material_desc desc = make_desc(8, BTF_LAYOUT_TIGHT, 0);
    float *scales = factor_numbers(&desc, BTF_TEXTURE_FACTOR_SCALES),
          *views = factor_numbers(&desc, BTF_TEXTURE_FACTOR_VIEWS);
    for (int i = 0; i < 4 * FACTOR_UNITS; i++)
        scales[i] = i / 4 % 2 ? 0x1p24f : -0x1p-24f;
    for (int i = 0; i < 12 * VIEWS; i++)
        views[i] = i % 4 == 3 ? 0 : i % 2 ? -0x1p24f : 0x1p-24f;
    btf_material *m = create_accepted(&desc);
    btf_material_close(&m);
    random_material_free(&desc);
}

static void assert_same_material(const btf_material *a, const btf_material *b) {
    const btf_material_info ia = info_of(a), ib = info_of(b);
    assert_int_equal(ia.version, ib.version);
    assert_int_equal(ia.store, ib.store);
    assert_int_equal(ia.blend, ib.blend);
    assert_int_equal(ia.components, ib.components);
    assert_true(ia.horizon_scale == ib.horizon_scale);
    assert_memory_equal(ia.factor_classes, ib.factor_classes, sizeof ia.factor_classes);
    assert_int_equal(ia.levels, ib.levels);
    assert_int_equal(ia.gpu_bytes, ib.gpu_bytes);
    assert_int_equal(ia.table_bytes, ib.table_bytes);
    for (uint32_t level = 0; level < ia.levels; level++)
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            const btf_texture ta = btf_material_level_texture(a, level, (btf_texture_id)id),
                              tb = btf_material_level_texture(b, level, (btf_texture_id)id);
            assert_int_equal(ta.size, tb.size);
            if (ta.size)
                assert_memory_equal(ta.data, tb.data, ta.size);
        }
    const uint16_t *pa = btf_material_preview(a), *pb = btf_material_preview(b);
    assert_int_equal(pa != NULL, pb != NULL);
    if (pa)
        assert_memory_equal(pa, pb, 8 * (size_t)ia.width * ia.height);
}

/* Saved and opened it is the same, and saved again the same bytes. */
static void round_trip(const btf_material_desc *desc) {
    btf_material *m = create_accepted(desc), *opened;
    void *data, *again;
    size_t size, size_again;
    assert_int_equal(btf_material_save_memory(m, &log_keep, &data, &size), BTF_OK);
    if (btf_material_open_memory(data, size, &log_keep, &opened))
        fail_msg("%s", last_message);
    assert_same_material(m, opened);
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++)
        if (desc->texture[id])
            assert_memory_equal(btf_material_texture(opened, (btf_texture_id)id).data, desc->texture[id],
                                btf_material_texture(opened, (btf_texture_id)id).size);
    assert_int_equal(btf_material_save_memory(opened, &log_keep, &again, &size_again), BTF_OK);
    assert_int_equal(size, size_again);
    assert_memory_equal(data, again, size);
    btf_free(data);
    btf_free(again);
    btf_material_close(&m);
    btf_material_close(&opened);
}

static void test_round_trip(void **state) {
    (void)state;
    for (int i = 0; i < 16; i++) {
        const btf_layout layout = i & 1 ? BTF_LAYOUT_PAPER : BTF_LAYOUT_TIGHT;
        random_state r = {(uint64_t)i};
        btf_material_desc desc = factor_material_desc(WIDTH, HEIGHT, VIEWS, LIGHTS, layout,
                                                      i & 2 ? BTF_EFFECT_VERSION_1 : 0, factor_classes);
        desc.info.blend = i & 4 ? BTF_BLEND_ROOTS : BTF_BLEND_RADIANCE;
        desc.info.levels = layout == BTF_LAYOUT_TIGHT ? 3 : 1;
        if (!(i & 2)) {
            desc.info.colour = BTF_COLOUR_NONE;
            desc.info.lobes = 0;
        }
        factor_material_fill(&r, &desc);
        uint16_t *preview = make_preview(WIDTH, HEIGHT);
        desc.preview = i & 8 ? preview : NULL;
        round_trip(&desc);
        free(preview);
        random_material_free(&desc);
    }
}

/* Blend roots alone makes version 2, and nothing of factors is written. */
static void test_roots_without_factors(void **state) {
    (void)state;
    for (int residual = 0; residual < 2; residual++) {
        random_state r = {9};
        btf_material_desc desc = random_material_desc(3, 2, 4, 3, BTF_LAYOUT_TIGHT,
                                                      residual ? BTF_EFFECT_RESIDUAL : BTF_EFFECT_SHADOW);
        desc.info.domain = BTF_DOMAIN_SQRT;
        desc.info.blend = BTF_BLEND_ROOTS;
        random_material_fill(&r, &desc);
        uint16_t *preview = make_preview(3, 2);
        desc.preview = preview;
        round_trip(&desc);
        btf_material *m = create_accepted(&desc);
        assert_int_equal(info_of(m).version, 2);
        void *data;
        size_t size;
        assert_int_equal(btf_material_save_memory(m, NULL, &data, &size), BTF_OK);
        edit_file *e = edit_load(data, size);
        assert_int_equal(edit_find_attribute(e, "openbtf.version")->i, 2);
        assert_string_equal(edit_find_attribute(e, "openbtf.blend")->text, "roots");
        assert_string_equal(e->parts[0].name, "preview");
        for (int a = 0; a < e->attribute_count; a++) {
            assert_null(strstr(e->attributes[a].name, "factor"));
            assert_null(strstr(e->attributes[a].name, "horizon"));
        }
        edit_free(e);
        btf_free(data);
        btf_material_close(&m);
        free(preview);
        random_material_free(&desc);
    }
}

/* A file to be edited: of factors and every effect, with a picture. */
typedef struct saved {
    void *data;
    size_t size;
} saved;

static saved factor_file, plain_file;

static saved save(const btf_material_desc *desc) {
    btf_material *m = create_accepted(desc);
    saved s;
    assert_int_equal(btf_material_save_memory(m, NULL, &s.data, &s.size), BTF_OK);
    btf_material_close(&m);
    return s;
}

static int setup(void **state) {
    (void)state;
    btf_material_desc desc = make_desc(10, BTF_LAYOUT_TIGHT, BTF_EFFECT_VERSION_1);
    uint16_t *preview = make_preview(WIDTH, HEIGHT);
    desc.preview = preview;
    desc.info.blend = BTF_BLEND_ROOTS;
    factor_file = save(&desc);
    free(preview);
    random_material_free(&desc);
    random_state r = {11};
    desc = random_material_desc(WIDTH, HEIGHT, VIEWS, LIGHTS, BTF_LAYOUT_TIGHT, BTF_EFFECT_VERSION_1);
    desc.info.domain = BTF_DOMAIN_SQRT;
    random_material_fill(&r, &desc);
    plain_file = save(&desc);
    random_material_free(&desc);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    btf_free(factor_file.data);
    btf_free(plain_file.data);
    return 0;
}

static edit_file *take(const saved *s) {
    return edit_load(s->data, s->size);
}

/* The edited file must open; the material that it is. */
static btf_material *accepted(edit_file *file) {
    btf_material *m;
    if (open_edited(file, &m))
        fail_msg("refused: %s", last_message);
    return m;
}

static void test_file_parts(void **state) {
    (void)state;
    static const char *const names[] = {"factor_texels", "factor_directions", "preview"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const bool words = i < 2;
        char text[96];
        edit_file *e = take(&factor_file);
        edit_part *part = edit_find_part(e, names[i]);
        assert_int_equal(part->channel_count, words ? 4 : 3);
        for (int c = 0; c < part->channel_count; c++)
            assert_int_equal(part->channels[c].type, words ? EXR_PIXEL_UINT : EXR_PIXEL_HALF);
        if (words) {
            edit_remove_part(e, names[i]);
            snprintf(text, sizeof text, "part %s: missing", names[i]);
            file_refused(e, text);
        } else {
            edit_free(e);
        }
        e = take(&factor_file);
        edit_resize(edit_find_part(e, names[i]), 9, 3);
        snprintf(text, sizeof text, "part %s: data window (0,0)-(8,2)", names[i]);
        file_refused(e, text);
        for (int type = 0; type < 3; type++) {
            static const exr_pixel_type_t types[3] = {EXR_PIXEL_HALF, EXR_PIXEL_FLOAT, EXR_PIXEL_UINT};
            if (types[type] == (words ? EXR_PIXEL_UINT : EXR_PIXEL_HALF))
                continue;
            e = take(&factor_file);
            part = edit_find_part(e, names[i]);
            edit_remove_channel(part, "G");
            edit_add_channel(part, "G", types[type]);
            snprintf(text, sizeof text, "part %s: channel G is of type %d, not %d (%s)", names[i],
                     (int)types[type], words ? 0 : 1, words ? "UINT" : "HALF");
            file_refused(e, text);
        }
        e = take(&factor_file);
        edit_remove_channel(edit_find_part(e, names[i]), "B");
        snprintf(text, sizeof text, "part %s: channel B is missing", names[i]);
        file_refused(e, text);
        e = take(&factor_file);
        edit_add_channel(edit_find_part(e, names[i]), "Y", words ? EXR_PIXEL_UINT : EXR_PIXEL_HALF);
        snprintf(text, sizeof text, "part %s: unknown channel Y", names[i]);
        file_refused(e, text);
    }
    edit_file *e = take(&factor_file);
    edit_copy_part(e, "factor_texels", "residual_texels");
    file_refused(e, "part residual_texels: unknown");
    e = take(&factor_file);
    edit_copy_part(e, "factor_texels", "level1.factor_texels");
    file_refused(e, "part level1.factor_texels: unknown");
}

static void test_file_words(void **state) {
    (void)state;
    /* 11 layers of 5 x 4 in a sheet of 4 columns: the twelfth cell, from (15, 8) on, is empty */
    edit_file *e = take(&factor_file);
    edit_part *part = edit_find_part(e, "factor_texels");
    assert_int_equal(part->width, 20);
    assert_int_equal(part->height, 12);
    uint32_t word = 0x80000001u;
    memcpy(edit_find_channel(e, "factor_texels", "A")->data + 4 * (9 * 20 + 16), &word, 4);
    file_refused(e, "part factor_texels: channel A at (16, 9) holds 0x80000001 where no layer lies, not 0");
    e = take(&factor_file); /* layer 1 of class 0 begins at column 5 */
    word = 0x00800000u;
    memcpy(edit_find_channel(e, "factor_texels", "R")->data + 4 * (3 * 20 + 7), &word, 4);
    file_refused(e, "factor_texels: unit 1 at (2, 3): byte 2 of channel R is -128");
    e = take(&factor_file);
    word = 0xFFFFFF80u;
    memcpy(edit_find_channel(e, "factor_directions", "B")->data, &word, 4);
    file_refused(e, "factor_directions: unit 0 at (0, 0): byte 0 of channel B is -128");
}

/* Words come through every compression and order of rows. */
static void test_other_writers(void **state) {
    (void)state;
    static const exr_compression_t good[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE,
                                             EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_PIZ};
    btf_material *original;
    assert_int_equal(btf_material_open_memory(factor_file.data, factor_file.size, NULL, &original), BTF_OK);
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        edit_file *e = take(&factor_file);
        for (int p = 0; p < e->part_count; p++) {
            e->parts[p].compression = good[i];
            e->parts[p].order = i % 2 ? EXR_LINEORDER_DECREASING_Y : EXR_LINEORDER_INCREASING_Y;
        }
        btf_material *m = accepted(e);
        assert_same_material(m, original);
        btf_material_close(&m);
    }
    btf_material_close(&original);
}

/* The picture may be anything, and may be missing. */
static void test_preview(void **state) {
    (void)state;
    edit_file *e = take(&factor_file);
    assert_string_equal(e->parts[0].name, "preview");
    const uint16_t nan = 0x7E01, denormal = 0x0001;
    memcpy(edit_find_channel(e, "preview", "R")->data, &nan, 2);
    memcpy(edit_find_channel(e, "preview", "B")->data + 2 * (WIDTH * HEIGHT - 1), &denormal, 2);
    btf_material *m = accepted(e);
    assert_int_equal(btf_material_preview(m)[0], nan);
    assert_int_equal(btf_material_preview(m)[4 * (WIDTH * HEIGHT - 1) + 2], denormal);
    btf_material_close(&m);
    e = take(&factor_file);
    edit_remove_part(e, "preview");
    m = accepted(e);
    assert_null(btf_material_preview(m));
    btf_material_close(&m);
    e = take(&plain_file); /* version 1 knows no such part */
    edit_copy_part(e, "sbrdf", "preview");
    file_refused(e, "part preview: unknown");
    btf_material_desc desc = random_material_desc(2, 2, 3, 3, BTF_LAYOUT_TIGHT, 0);
    random_state r = {12};
    random_material_fill(&r, &desc);
    uint16_t *preview = make_preview(2, 2);
    desc.preview = preview;
    create_refused(&desc, "preview: given, but nothing else of the material needs version 2, and files of "
                          "version 1 have no preview");
    free(preview);
    random_material_free(&desc);
}

static edit_attribute *add_attribute(edit_file *e, const char *name, exr_attribute_type_t type) {
    assert_true(e->attribute_count < EDIT_ATTRIBUTES);
    edit_attribute *a = &e->attributes[e->attribute_count++];
    *a = (edit_attribute){.type = type};
    snprintf(a->name, sizeof a->name, "%s", name);
    return a;
}

static void add_floats(edit_file *e, const char *name, int count) {
    edit_attribute *a = add_attribute(e, name, EXR_ATTR_FLOAT_VECTOR);
    a->values = calloc((size_t)count, sizeof *a->values);
    assert_non_null(a->values);
    a->count = count;
}

static void test_file_attributes(void **state) {
    (void)state;
    static const char *const needed[] = {"factorScales", "factorViews", "horizonScale"};
    for (size_t i = 0; i < sizeof needed / sizeof *needed; i++) {
        char name[64], text[96];
        snprintf(name, sizeof name, "openbtf.%s", needed[i]);
        edit_file *e = take(&factor_file);
        edit_remove_attribute(e, name);
        snprintf(text, sizeof text, "attribute %s is missing", name);
        file_refused(e, text);
    }
    static const char *const typed[] = {"factorClasses", "factorScales", "factorViews", "horizonScale",
                                        "blend"};
    for (size_t i = 0; i < sizeof typed / sizeof *typed; i++) {
        char name[64], text[96];
        snprintf(name, sizeof name, "openbtf.%s", typed[i]);
        edit_file *e = take(&factor_file);
        edit_find_attribute(e, name)->type = EXR_ATTR_DOUBLE;
        snprintf(text, sizeof text, "attribute %s is of type double", name);
        file_refused(e, text);
    }
    edit_file *e = take(&factor_file); /* its store is another then */
    edit_remove_attribute(e, "openbtf.factorClasses");
    file_refused(e, "attribute openbtf.residualScales is missing");
    e = take(&factor_file);
    add_floats(e, "openbtf.residualScales", FACTOR_UNITS);
    file_refused(e, "attribute openbtf.residualScales is there, but there are no components of the residual");
    e = take(&factor_file);
    edit_find_attribute(e, "openbtf.residual")->i = 8;
    file_refused(e, "factorClasses: the classes have 9 units in all, the residual has 8");
    e = take(&factor_file);
    edit_find_attribute(e, "openbtf.version")->i = 1; /* nine components then */
    file_refused(e, "attribute openbtf.residualScales is missing");
    e = take(&factor_file); /* a file without a residual and with factors */
    edit_attribute *effects = edit_find_attribute(e, "openbtf.effects");
    free(effects->text);
    effects->text = strdup("shadow");
    edit_find_attribute(e, "openbtf.residual")->i = 0;
    edit_find_attribute(e, "openbtf.centres")->i = 0;
    file_refused(e, "factors without the effect residual");
}

/* Changes one number of a floatvector. */
static void refused_number(const char *name, int index, float value, const char *text) {
    char full[64];
    snprintf(full, sizeof full, "openbtf.%s", name);
    edit_file *e = take(&factor_file);
    edit_attribute *a = edit_find_attribute(e, full);
    assert_true(index < a->count);
    a->values[index] = value;
    file_refused(e, text);
}

static void refused_count(const char *name, int count, const char *text) {
    char full[64];
    snprintf(full, sizeof full, "openbtf.%s", name);
    edit_file *e = take(&factor_file);
    edit_attribute *a = edit_find_attribute(e, full);
    float *values = calloc((size_t)count, sizeof *values);
    assert_non_null(values);
    memcpy(values, a->values, (size_t)(count < a->count ? count : a->count) * sizeof *values);
    free(a->values);
    a->values = values;
    a->count = count;
    file_refused(e, text);
}

static void test_file_numbers(void **state) {
    (void)state;
    refused_number("factorClasses", 6, 2,
                   "factorClasses: the classes have 8 units in all, the residual has 9");
    refused_number("factorClasses", 0, 2.5f, "openbtf.factorClasses: number 0 is 2.5");
    refused_number("factorClasses", 4, -1, "openbtf.factorClasses: number 4 is -1");
    refused_number("factorClasses", 14, NAN, "openbtf.factorClasses: number 14 is ");
    refused_number("factorClasses", 6, 1025, "openbtf.factorClasses: number 6 is 1025");
    refused_number("factorClasses", 6, 257, "factorClasses: class 2 has 257 units");
    refused_number("factorClasses", 7, 13, "with 13 words of C1");
    /* Words of C1 in class 2 make its first two units mixed; the third stays whole. */
    edit_file *e = take(&factor_file);
    edit_find_attribute(e, "openbtf.factorClasses")->values[7] = 5;
    edit_find_attribute(e, "openbtf.factorScales")->values[4 * 4 + 1] = 0.125f;
    btf_material *m = accepted(e);
    assert_int_equal(info_of(m).factor_classes[2][1], 5);
    btf_material_close(&m);
    e = take(&factor_file);
    edit_find_attribute(e, "openbtf.factorClasses")->values[7] = 5;
    edit_find_attribute(e, "openbtf.factorScales")->values[4 * 5 + 1] = 0.125f;
    file_refused(e, "factorScales: unit 5, all of Y, has the scales");
}

static void test_file_counts(void **state) {
    (void)state;
    refused_count("factorClasses", 14, "openbtf.factorClasses holds 14 numbers");
    refused_count("factorClasses", 30, "openbtf.factorClasses holds 30 numbers");
    refused_count("factorScales", 35, "openbtf.factorScales holds 35 numbers");
    refused_count("factorScales", 40,
                  "openbtf.factorScales holds 40 numbers, which do not fit the 9 units of factors");
    refused_count("factorViews", 9 * VIEWS - 1, "openbtf.factorViews holds 71 numbers");
    refused_count("factorViews", 9 * VIEWS + 9,
                  "openbtf.factorViews holds 81 numbers, which do not fit the 8 views");
    refused_number("factorScales", 3, NAN, "factorScales: number 3 is nan");
    refused_number("factorScales", 30, 0x1p25f, "factorScales: number 30 is ");
    refused_number("factorScales", 15, 0.5f, "factorScales: unit 3, all of Y, has the scales");
    refused_number("factorViews", 9 * VIEWS - 1, 0x1p-25f, "factorViews: number 71 is ");
    static const float horizons[] = {0, 0.5f, NAN, INFINITY, 0x1p25f};
    for (size_t i = 0; i < sizeof horizons / sizeof *horizons; i++) {
        edit_file *e = take(&factor_file);
        edit_find_attribute(e, "openbtf.horizonScale")->f = horizons[i];
        file_refused(e, "horizonScale");
    }
    edit_file *e = take(&factor_file);
    edit_attribute *blend = edit_find_attribute(e, "openbtf.blend");
    free(blend->text);
    blend->text = strdup("root");
    file_refused(e, "openbtf.blend is \"root\", which is unknown");
    e = take(&factor_file);
    edit_attribute *domain = edit_find_attribute(e, "openbtf.domain");
    free(domain->text);
    domain->text = strdup("linear");
    file_refused(e, "blend roots needs domain sqrt");
    e = take(&factor_file);
    edit_remove_attribute(e, "openbtf.blend");
    btf_material *m = accepted(e);
    assert_int_equal(info_of(m).blend, BTF_BLEND_RADIANCE);
    btf_material_close(&m);
}

/* Attributes of version 2 say nothing in a file of version 1; a file that calls itself version 2 and holds
 * nothing of it is saved as version 1. */
static void test_versions(void **state) {
    (void)state;
    btf_material *plain, *m;
    assert_int_equal(btf_material_open_memory(plain_file.data, plain_file.size, NULL, &plain), BTF_OK);
    assert_int_equal(info_of(plain).version, 1);
    assert_true(info_of(plain).horizon_scale == 1);
    edit_file *e = take(&plain_file);
    add_floats(e, "openbtf.factorClasses", 15);
    add_floats(e, "openbtf.factorScales", 4);
    add_floats(e, "openbtf.factorViews", 9);
    add_attribute(e, "openbtf.horizonScale", EXR_ATTR_FLOAT)->f = -3;
    add_attribute(e, "openbtf.blend", EXR_ATTR_STRING)->text = strdup("roots");
    m = accepted(e);
    assert_same_material(m, plain);
    btf_material_close(&m);

    e = take(&plain_file);
    edit_find_attribute(e, "openbtf.version")->i = 2;
    edit_copy_part(e, "shadow", "preview");
    edit_resize(edit_find_part(e, "preview"), WIDTH, HEIGHT);
    edit_remove_channel(edit_find_part(e, "preview"), "Y");
    for (int c = 0; c < 3; c++)
        edit_add_channel(edit_find_part(e, "preview"), (const char[2]){"RGB"[c], 0}, EXR_PIXEL_HALF);
    m = accepted(e);
    assert_same_material(m, plain);
    void *data;
    size_t size;
    assert_int_equal(btf_material_save_memory(m, NULL, &data, &size), BTF_OK);
    assert_int_equal(size, plain_file.size);
    assert_memory_equal(data, plain_file.data, size);
    btf_free(data);
    btf_material_close(&m);

    e = take(&plain_file); /* the store is that of version 1 */
    edit_find_attribute(e, "openbtf.version")->i = 2;
    add_floats(e, "openbtf.factorScales", 4);
    file_refused(e, "attribute openbtf.factorScales is there, but there are no units of factors");
    e = take(&plain_file);
    edit_find_attribute(e, "openbtf.version")->i = 2;
    add_attribute(e, "openbtf.blend", EXR_ATTR_STRING)->text = strdup("roots");
    m = accepted(e);
    assert_int_equal(info_of(m).blend, BTF_BLEND_ROOTS);
    assert_int_equal(info_of(m).store, BTF_STORE_COMPONENTS);
    assert_int_equal(info_of(m).version, 2);
    btf_material_close(&m);
    btf_material_close(&plain);
}

static uint32_t number_of(const btf_directions *whole, const float xyz[3]) {
    for (uint32_t i = 0; i < whole->count; i++)
        if (memcmp(whole->xyz + 3 * (size_t)i, xyz, 3 * sizeof *xyz) == 0)
            return i;
    fail_msg("a direction that the whole material has not");
    return 0;
}

/* The first units, of the views and lights that are left. */
static void assert_first_units(const btf_material *whole, const btf_material *small, uint32_t level) {
    const btf_material_info info = info_of(whole), less = info_of(small);
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
            for (size_t unit = 0; unit < less.components; unit++)
                assert_memory_equal(of_small + 4 * ((unit * less.n_views + v) * less.n_lights + l),
                                    w + 4 * ((unit * info.n_views + view) * info.n_lights + light), 16);
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

static void test_restrict(void **state) {
    (void)state;
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
        const btf_material_info less = info_of(small);
        fewer += less.n_views < 37 && less.n_lights < 37;
        assert_int_equal(less.components, units);
        assert_int_equal(less.store, units ? BTF_STORE_FACTORS : BTF_STORE_COMPONENTS);
        assert_int_equal(less.blend, desc.info.blend);
        assert_true(less.horizon_scale == (units ? desc.info.horizon_scale : 1));
        assert_int_equal(less.version, units || desc.info.blend ? 2 : 1);
        assert_memory_equal(less.factor_classes, first_classes[units], sizeof less.factor_classes);
        assert_int_equal(btf_material_texture(small, BTF_TEXTURE_FACTOR_TEXELS).layers,
                         first_layers[units]);
        if (units)
            assert_first_units(whole, small, plan.level);
        assert_int_equal(btf_material_preview(small) != NULL, plan.level == 0 && less.version == 2);
        if (btf_material_preview(small))
            assert_memory_equal(btf_material_preview(small), preview, 9 * 6 * 8);
        void *data; /* a material like any */
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

static void test_to_tight(void **state) {
    (void)state;
    btf_material_desc desc = make_desc(14, BTF_LAYOUT_PAPER, BTF_EFFECT_VERSION_1);
    desc.info.blend = BTF_BLEND_ROOTS;
    btf_material *paper = create_accepted(&desc), *tight;
    assert_int_equal(btf_material_to_tight(paper, &log_keep, &tight), BTF_OK);
    const btf_material_info info = info_of(tight);
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
static void test_effect_errors(void **state) {
    (void)state;
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
    assert_int_equal(info_of(small).gpu_bytes, plan.gpu_bytes);
    const size_t layers = FACTOR_LAYERS - first_layers[4], units = FACTOR_UNITS - 4;
    assert_int_equal(plan.gpu_bytes,
                     plan.full_gpu_bytes - 16 * (layers * WIDTH * HEIGHT + units * VIEWS * LIGHTS));
    btf_material_close(&small);
    btf_material_close(&m);
    table[7] = FACTOR_UNITS + 1;
    create_refused(&desc, "effect errors: row 0 has 10 components");
    random_material_free(&desc);
}

/* More directions than layers: version 2 whatever else, where no texture has a layer for each. */
static void test_many_directions(void **state) {
    (void)state;
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
    assert_in_range(info_of(small).n_lights, 20, 400);
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
    assert_int_equal(info_of(m).version, 2);
    saved s = save(&desc);
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_shapes),
        cmocka_unit_test(test_create_classes),
        cmocka_unit_test(test_most_units),
        cmocka_unit_test(test_create_numbers),
        cmocka_unit_test(test_create_codes),
        cmocka_unit_test(test_create_scales),
        cmocka_unit_test(test_extreme_scales),
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_roots_without_factors),
        cmocka_unit_test(test_file_parts),
        cmocka_unit_test(test_file_words),
        cmocka_unit_test(test_other_writers),
        cmocka_unit_test(test_preview),
        cmocka_unit_test(test_file_attributes),
        cmocka_unit_test(test_file_numbers),
        cmocka_unit_test(test_file_counts),
        cmocka_unit_test(test_versions),
        cmocka_unit_test(test_restrict),
        cmocka_unit_test(test_to_tight),
        cmocka_unit_test(test_effect_errors),
        cmocka_unit_test(test_many_directions),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
