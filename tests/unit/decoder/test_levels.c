/* Levels of detail: shapes, saving and opening, every refusal, and that the reference decodes a level as it decodes a
 * material made of that level alone.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/reference.h>
#include "decoder/toolkit/reference_view.h"
#include "tests/support/exr_edit.h"
#include "tests/support/random_material.h"
#include "tests/support/refusals.h"
#include "tests/support/same_material.h"
#include "tests/support/test.h"

static const btf_texture_id level_ids[5] = {BTF_TEXTURE_SBRDF, BTF_TEXTURE_SHADOW, BTF_TEXTURE_SHIFT,
                                            BTF_TEXTURE_GAIN, BTF_TEXTURE_RESIDUAL_TEXELS};

static bool has_texels(int id) {
    for (int i = 0; i < 5; i++) {
        if ((int)level_ids[i] == id) {
            return true;
        }
    }
    return false;
}

static btf_material_desc make_desc(random_state *r, uint32_t width, uint32_t height, uint32_t levels,
                                   uint32_t effects) {
    btf_material_desc desc = random_material_desc(width, height, 9, 7, BTF_LAYOUT_TIGHT, effects);
    desc.info.levels = levels;
    random_material_fill(r, &desc);
    return desc;
}

TEST(test_shapes) {
    btf_material_info info = {.struct_size = sizeof info,
                              .width = 5,
                              .height = 3,
                              .n_views = 9,
                              .n_lights = 7,
                              .layout = BTF_LAYOUT_TIGHT,
                              .lobes = 3,
                              .effects = BTF_EFFECT_VERSION_1,
                              .centres = 7,
                              .components = 5,
                              .levels = 3};
    static const uint32_t size[3][2] = {{5, 3}, {2, 1}, {1, 1}};
    static const uint32_t layers[5] = {4, 7, 9, 9, 2};
    static const size_t texel[5] = {16, 1, 2, 1, 4};
    for (uint32_t level = 0; level < 3; level++) {
        for (int i = 0; i < 5; i++) {
            btf_texture t = btf_material_level_shape(&info, level, level_ids[i]);
            assert_int_equal(t.width, size[level][0]);
            assert_int_equal(t.height, size[level][1]);
            assert_int_equal(t.layers, layers[i]);
            assert_int_equal(t.size, size[level][0] * size[level][1] * layers[i] * texel[i]);
            assert_true(t.is_array);
        }
    }
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        assert_int_equal(btf_material_level_shape(&info, 1, (btf_texture_id)id).format != BTF_FORMAT_NONE,
                         has_texels(id));
        assert_int_equal(btf_material_level_shape(&info, 3, (btf_texture_id)id).format, BTF_FORMAT_NONE);
    }
    assert_int_equal(btf_level_size(16384, 14), 1);
    assert_int_equal(btf_level_size(16383, 13), 1);
    assert_int_equal(btf_level_size(100, 3), 12);
    assert_int_equal(btf_level_size(7, 40), 1);
}

TEST(test_info) {
    random_state r = {41};
    btf_material_desc desc = make_desc(&r, 5, 3, 3, BTF_EFFECT_VERSION_1);
    btf_material *m = create_accepted(&desc);
    btf_material_info info = accepted_info(m);
    assert_int_equal(info.levels, 3);
    /* 64 of the SBRDF, 7 of shadows, 18 + 9 of shifts and gains, 8 of the residual, for 15 + 2 + 1 texels;
     * then 7 centres of 7 lights and 6 layers of 9 x 7 directions. */
    assert_int_equal(info.gpu_bytes, (64 + 7 + 18 + 9 + 8) * 18 + 4 * 7 * 7 + 4 * 9 * 7 * 6);
    assert_int_equal(btf_level_bytes(&info, 0), 106 * 15 + 4 * 7 * 7 + 4 * 9 * 7 * 6);
    assert_int_equal(btf_level_bytes(&info, 1), 106 * 2);
    assert_int_equal(btf_level_bytes(&info, 2), 106);
    assert_int_equal(btf_level_bytes(&info, 3), 0);
    btf_material_close(&m);
    random_material_free(&desc);

    desc = make_desc(&r, 5, 3, 0, 0);
    m = create_accepted(&desc);
    btf_material_get_info(m, &info);
    assert_int_equal(info.levels, 1);
    void *data;
    size_t size;
    assert_int_equal(btf_material_save_memory(m, NULL, &data, &size), BTF_OK);
    assert_null(memmem(data, size, "openbtf.level", 13)); /* one level: the same file as ever */
    btf_free(data);
    btf_material_close(&m);
    random_material_free(&desc);
}

TEST(test_round_trip) {
    static const struct {
        uint32_t width, height, levels;
    } cases[] = {{5, 3, 3}, {5, 3, 2}, {1, 1, 1}, {2, 1, 2}, {1, 13, 4}, {8, 8, 4}, {33, 6, 6}};
    random_state r = {42};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        for (uint32_t effects = 0; effects <= BTF_EFFECT_VERSION_1; effects += c < 2 ? 1 : 31) {
            btf_material_desc desc =
                random_material_desc(cases[c].width, cases[c].height, 9, 7, BTF_LAYOUT_TIGHT, effects);
            desc.info.levels = cases[c].levels;
            desc.info.half_float = effects & 1;
            desc.info.colour = effects & 2 ? BTF_COLOUR_RGB : BTF_COLOUR_MONO;
            if (effects == BTF_EFFECT_RESIDUAL) {
                desc.info.colour = BTF_COLOUR_NONE;
                desc.info.lobes = 0;
            }
            random_material_fill(&r, &desc);
            const btf_level_error errors[2] = {{0, 30, 28, 2000}, {cases[c].levels - 1, 31.5f, 29, 100}};
            desc.level_errors = errors;
            desc.level_error_count = cases[c].levels > 1 ? 2 : 0;
            round_trip(&desc);
            random_material_free(&desc);
        }
    }
}

TEST(test_create_refuses) {
    random_state r = {43};
    btf_material_desc good = make_desc(&r, 5, 3, 3, BTF_EFFECT_VERSION_1), bad = good;
    bad.info.levels = 4;
    create_refused(&bad, "levels 4 is not within 1 to 3 (size 5 x 3)");
    bad.info.levels = 2;
    create_refused(&bad, "level2.sbrdf: given");
    for (int i = 0; i < 5; i++) {
        bad = good;
        bad.level_texture[2][level_ids[i]] = NULL;
        create_refused(&bad, told("level2.%s: missing", btf_texture_name(level_ids[i])));
    }
    bad = good;
    bad.level_texture[1][BTF_TEXTURE_CENTRES] = good.texture[BTF_TEXTURE_CENTRES];
    create_refused(&bad, "level1.centres: given");
    bad = good;
    bad.level_error_count = 1;
    create_refused(&bad, "level errors: 1 rows");
    btf_level_error errors[2] = {{1, 20, 20, 100}, {1, 20, 20, 100}};
    bad.level_errors = errors;
    bad.level_error_count = 2;
    create_refused(&bad, "level errors: row 1 is of level 1; levels must rise and be below 3");
    errors[1].level = 3;
    create_refused(&bad, "level errors: row 1 is of level 3; levels must rise and be below 3");
    errors[1] = (btf_level_error){2, 20, 20, -1};
    create_refused(&bad, "level errors: row 1 is");

    uint8_t *gain = (uint8_t *)(uintptr_t)good.level_texture[1][BTF_TEXTURE_GAIN];
    uint8_t *shift = (uint8_t *)(uintptr_t)good.level_texture[1][BTF_TEXTURE_SHIFT];
    gain[3] = 0;
    shift[6] = 7; /* texel 1 of 2, view 1 */
    shift[7] = 0;
    create_refused(&good, "level1.gain: view 1, texel (1, 0) names centre 7 of 7");
    gain[3] = 128;
    float *sbrdf = (float *)(uintptr_t)good.level_texture[2][BTF_TEXTURE_SBRDF];
    const float kept = sbrdf[3];
    sbrdf[3] = 0x1p-25f;
    create_refused(&good, "level2.sbrdf: channel rho_d at (0, 0) holds");
    sbrdf[3] = kept;
    int8_t *residual = (int8_t *)(uintptr_t)good.level_texture[2][BTF_TEXTURE_RESIDUAL_TEXELS];
    residual[1] = -128;
    create_refused(&good, "level2.residual_texels: component 1 at (0, 0) holds -128");
    random_material_free(&good);

    good = random_material_desc(5, 3, 9, 7, BTF_LAYOUT_PAPER, 0);
    random_material_fill(&r, &good);
    good.info.levels = 2;
    create_refused(&good, "levels is 2; layout paper has one");
    random_material_free(&good);
}

/* A saved material of 5 x 3, 2 x 1 and 1 x 1. */
static edit_file *take_levels(void) {
    random_state r = {44};
    btf_material_desc desc = make_desc(&r, 5, 3, 3, BTF_EFFECT_VERSION_1);
    const btf_level_error errors[3] = {{0, 30, 28, 2}, {1, 31, 28, 1}, {2, 32, 28, 1}};
    desc.level_errors = errors;
    desc.level_error_count = 3;
    btf_material *m = create_accepted(&desc);
    saved s = save_material(m);
    edit_file *file = take(&s);
    btf_free(s.data);
    btf_material_close(&m);
    random_material_free(&desc);
    return file;
}

TEST(test_file_parts) {
    for (int i = 0; i < 5; i++) {
        char part[40];
        snprintf(part, sizeof part, "level1.%s", btf_texture_name(level_ids[i]));
        EDIT_REFUSED(take_levels(), edit_remove_part(e, part), told("part %s: missing", part));
        /* the size of level 0 */
        EDIT_REFUSED(take_levels(), edit_resize(edit_find_part(e, part), 15, 9),
                     told("part %s: data window (0,0)-(14,8)", part));
        edit_file *e = take_levels();
        snprintf(part, sizeof part, "level3.%s", btf_texture_name(level_ids[i]));
        edit_copy_part(e, btf_texture_name(level_ids[i]), part);
        refused_as(e, BTF_ERROR_BAD_FILE,
                   told("part %s: unknown, or not in a material of these effects and levels", part));
    }
    static const char *const superfluous[] = {"level1.centres", "level1.residual_directions",
                                              "level0.shadow", "level01.shadow", "level1"};
    for (size_t i = 0; i < sizeof superfluous / sizeof *superfluous; i++) {
        EDIT_REFUSED(take_levels(), edit_copy_part(e, "shadow", superfluous[i]), superfluous[i]);
    }
    edit_file *e = take_levels();
    uint16_t half = 0x3800;
    memcpy(edit_find_channel(e, "level2.shadow", "Y")->data, &half, 2);
    refused_as(e, BTF_ERROR_BAD_FILE, "part level2.shadow: channel Y at (0, 0) holds half 0x3800");
    e = take_levels();
    for (int c = 0; c < edit_find_part(e, "level1.sbrdf")->channel_count; c++) {
        edit_find_part(e, "level1.sbrdf")->channels[c].type = EXR_PIXEL_HALF;
    }
    refused_as(e, BTF_ERROR_BAD_FILE, "part level1.sbrdf: channel "); /* all FLOAT or all HALF */
    e = take_levels();
    edit_copy_part(e, "level1.shadow", "x-level1.shadow");
    file_accepted(e);
}

TEST(test_file_attributes) {
    /* without the attribute there is one level: the errors of level 1 are a contradiction */
    EDIT_REFUSED(take_levels(), edit_remove_attribute(e, "openbtf.levels"),
                 "level errors: row 1 is of level 1; levels must rise and be below 1");
    edit_file *e = take_levels();
    edit_remove_attribute(e, "openbtf.levels");
    edit_remove_attribute(e, "openbtf.levelErrors");
    refused_as(e, BTF_ERROR_BAD_FILE, "part level1.");
    e = take_levels();
    edit_remove_attribute(e, "openbtf.levelErrors");
    file_accepted(e);
    EDIT_REFUSED(take_levels(), edit_find_attribute(e, "openbtf.levels")->i = 4,
                 "levels 4 is not within 1 to 3");
    EDIT_REFUSED(take_levels(), edit_find_attribute(e, "openbtf.levels")->i = 16,
                 "attribute openbtf.levels is 16, not within 1 to 15");
    EDIT_REFUSED(take_levels(), edit_find_attribute(e, "openbtf.levels")->type = EXR_ATTR_DOUBLE,
                 "attribute openbtf.levels is of type double");
    static const float bad[] = {0.5f, -1, 15, 2};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        EDIT_REFUSED(take_levels(), edit_find_attribute(e, "openbtf.levelErrors")->values[4] = bad[i],
                     i < 3 ? "attribute openbtf.levelErrors: row 1 is of level"
                           : "level errors: row 2 is of level 2; levels must rise and be below 3");
    }
}

/* A material made of one level's textures and what all levels share. */
static btf_material *alone(const btf_material_desc *desc, uint32_t level) {
    btf_material_desc one = *desc;
    memset(one.level_texture, 0, sizeof one.level_texture);
    one.info.levels = 1;
    one.info.width = btf_level_size(desc->info.width, level);
    one.info.height = btf_level_size(desc->info.height, level);
    for (int id = 0; id < BTF_TEXTURE_COUNT && level > 0; id++) {
        if (has_texels(id)) {
            one.texture[id] = desc->level_texture[level][id];
        }
    }
    return create_accepted(&one);
}

TEST(test_reference) {
    random_state r = {45};
    btf_material_desc desc = make_desc(&r, 13, 6, 4, BTF_EFFECT_VERSION_1);
    btf_material *m = create_accepted(&desc);
    btf_ref_material first;
    reference_view(m, 0, &first);
    for (uint32_t level = 0; level < 4; level++) {
        btf_material *single = alone(&desc, level);
        btf_ref_material a, b;
        reference_view(m, level, &a);
        reference_view(single, 0, &b);
        assert_int_equal(a.width, 13u >> level);
        assert_int_equal(a.height, level < 3 ? 6u >> level : 1);
        int unlike_first = 0;
        for (int i = 0; i < 2000; i++) {
            float l[3], v[3], one[3], other[3], of_first[3];
            random_directions(&r, 1, 89, l);
            random_directions(&r, 1, 89, v);
            const float uv[2] = {(float)(4 * random_unit(&r) - 2), (float)(4 * random_unit(&r) - 2)};
            const btf_ref_options options = {BTF_EFFECT_ALL, UINT32_MAX, i & 1, i >> 1 & 1};
            btf_ref_evaluate(&a, &options, uv[0], uv[1], l, v, one);
            btf_ref_evaluate(&b, &options, uv[0], uv[1], l, v, other);
            btf_ref_evaluate(&first, &options, uv[0], uv[1], l, v, of_first);
            assert_memory_equal(one, other, sizeof one);
            unlike_first += memcmp(one, of_first, sizeof one) != 0;
        }
        assert_true(level == 0 ? unlike_first == 0 : unlike_first > 1000);
        btf_material_close(&single);
    }
    btf_material_close(&m);
    random_material_free(&desc);
}

RUN_TESTS(NULL, NULL)
