/* Packed points and lists of them in the library: shapes, what is refused when a material is made or opened, saving and
 * opening, what a plan's restriction keeps of them, and the shader's textures.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/reference_view.h"
#include "tests/support/exr_edit.h"
#include "tests/support/factor_material.h"
#include "tests/support/plan_decode.h"
#include "tests/support/refusals.h"
#include "tests/support/same_material.h"
#include "tests/support/test.h"
#include <openbtf/plan.h>

enum { WIDTH = 9, HEIGHT = 6, VIEWS = 19, LIGHTS = 7 };
enum { BOTH = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN };

static btf_material_desc make_stored(uint64_t seed, uint32_t effects, uint32_t levels, uint32_t entries) {
    random_state r = {seed};
    btf_material_desc desc =
        random_material_desc(WIDTH, HEIGHT, VIEWS, LIGHTS, BTF_LAYOUT_TIGHT, BOTH | effects);
    desc.info.levels = levels;
    desc.info.domain = BTF_DOMAIN_SQRT;
    entries ? factor_material_list_points(&desc, entries) : factor_material_pack_points(&desc);
    random_material_fill(&r, &desc);
    return desc;
}

static btf_material_desc make_desc(uint64_t seed, uint32_t effects, uint32_t levels) {
    return make_stored(seed, effects, levels, 0);
}

TEST(test_shapes) {
    btf_material_desc desc = make_desc(1, 0, 2);
    btf_material *m = create_accepted(&desc);
    const btf_material_info info = accepted_info(m);
    assert_int_equal(info.version, 2);
    assert_int_equal(info.point_store, BTF_POINTS_PACKED);
    assert_true(info.gain_base == 0.3f && info.gain_step == 0.11f);
    assert_string_equal(btf_texture_name(BTF_TEXTURE_POINTS), "points");
    const btf_texture points = btf_material_texture(m, BTF_TEXTURE_POINTS),
                      level = btf_material_level_texture(m, 1, BTF_TEXTURE_POINTS);
    assert_int_equal(points.format, BTF_FORMAT_RG8UI);
    assert_true(points.is_array);
    assert_int_equal(points.width, WIDTH);
    assert_int_equal(points.height, HEIGHT);
    assert_int_equal(points.layers, VIEWS);
    assert_int_equal(points.size, 2 * WIDTH * HEIGHT * VIEWS);
    assert_int_equal(level.size, 2 * (WIDTH / 2) * (HEIGHT / 2) * VIEWS);
    assert_false(accepted_texture(m, BTF_TEXTURE_SHIFT) || accepted_texture(m, BTF_TEXTURE_GAIN));
    size_t others = 0;
    others += btf_material_texture(m, BTF_TEXTURE_SBRDF).size;
    others += btf_material_level_texture(m, 1, BTF_TEXTURE_SBRDF).size;
    assert_int_equal(info.gpu_bytes, points.size + level.size + others);
    btf_material_close(&m);
    random_material_free(&desc);
}

TEST(test_list_shapes) {
    btf_material_desc desc = make_stored(1, 0, 2, 5);
    btf_material *m = create_accepted(&desc);
    const btf_material_info info = accepted_info(m);
    assert_int_equal(info.version, 2);
    assert_int_equal(info.point_store, BTF_POINTS_LISTS);
    assert_int_equal(info.point_entries, 5);
    assert_string_equal(btf_texture_name(BTF_TEXTURE_POINT_LISTS), "point_lists");
    assert_string_equal(btf_texture_name(BTF_TEXTURE_POINT_INDICES), "point_indices");
    for (uint32_t level = 0; level < 2; level++) {
        const btf_texture lists = btf_material_level_texture(m, level, BTF_TEXTURE_POINT_LISTS),
                          indices = btf_material_level_texture(m, level, BTF_TEXTURE_POINT_INDICES);
        const uint32_t texels = (WIDTH >> level) * (HEIGHT >> level);
        assert_int_equal(lists.format, BTF_FORMAT_RG8UI);
        assert_int_equal(indices.format, BTF_FORMAT_R8UI);
        assert_true(lists.is_array && indices.is_array);
        assert_int_equal(lists.layers, 5);
        assert_int_equal(indices.layers, (VIEWS + 1) / 2);
        assert_int_equal(lists.width * lists.height, texels);
        assert_int_equal(lists.size, 10 * texels);
        assert_int_equal(indices.size, texels * (VIEWS + 1) / 2);
    }
    assert_false(accepted_texture(m, BTF_TEXTURE_SHIFT) || accepted_texture(m, BTF_TEXTURE_GAIN) ||
                 accepted_texture(m, BTF_TEXTURE_POINTS));
    btf_material_close(&m);
    random_material_free(&desc);
}

/* An index counts from 0 below the number of entries, and the half of a byte that no view has is 0. */
TEST(test_create_lists) {
    for (uint32_t level = 0; level < 2; level++) {
        btf_material_desc desc = make_stored(2, 0, 2, 9);
        const void *data = level ? desc.level_texture[1][BTF_TEXTURE_POINT_INDICES]
                                 : desc.texture[BTF_TEXTURE_POINT_INDICES];
        uint8_t *indices = (uint8_t *)(uintptr_t)data;
        const size_t w = WIDTH >> level, texels = w * (HEIGHT >> level), at = 3 * texels + w + 2,
                     last = 9 * texels + w;
        const uint8_t kept = indices[at];
        for (unsigned odd = 0; odd < 2; odd++) {
            const int fine = odd ? (kept & 0x0F) | 0x80 : (kept & 0xF0) | 8,
                      wrong = odd ? kept | 0xF0 : kept | 0x0F;
            indices[at] = (uint8_t)fine;
            btf_material *m = create_accepted(&desc);
            btf_material_close(&m);
            indices[at] = (uint8_t)wrong;
            create_refused(&desc, told("%spoint_indices: view %u, texel (2, 1) names entry 15 of 9",
                                       level ? "level1." : "", 6 + odd));
        }
        indices[at] = kept;
        indices[last] |= 0x30;
        create_refused(&desc,
                       told("%spoint_indices: texel (0, 1): the high bits of the last layer hold 3, not 0",
                            level ? "level1." : ""));
        random_material_free(&desc);
    }
    btf_material_desc desc = make_stored(2, 0, 1, 16);
    btf_material *m = create_accepted(&desc);
    btf_material_close(&m);
    desc.info.point_entries = 17;
    create_refused(&desc, "pointEntries 17 is not within 1 to 16");
    desc.info.point_entries = 0;
    create_refused(&desc, "pointEntries 0 is not within 1 to 16");
    desc.info.point_entries = 3;
    desc.info.point_store = BTF_POINTS_PACKED;
    create_refused(&desc, "pointEntries is 3, but only lists");
    desc.info.point_store = BTF_POINTS_LISTS;
    desc.info.effects = BTF_EFFECT_SHIFT;
    create_refused(&desc, "packed points need the effects shift and gain, and no effect hidden");
    desc.info.effects = BOTH;
    desc.info.layout = BTF_LAYOUT_PAPER;
    create_refused(&desc, "packed points need layout tight");
    random_material_free(&desc);
}

TEST(test_create) {
    btf_material_desc desc = make_desc(2, 0, 1);
    const btf_material_info good = desc.info;
    static const uint32_t missing[] = {BTF_EFFECT_SHIFT, BTF_EFFECT_GAIN, BOTH | BTF_EFFECT_HIDDEN};
    for (size_t i = 0; i < sizeof missing / sizeof *missing; i++) {
        desc.info.effects = missing[i];
        desc.info.centres = missing[i] & BTF_EFFECT_HIDDEN ? 3 : 0;
        create_refused(&desc, "packed points need the effects shift and gain, and no effect hidden");
    }
    desc.info = good;
    desc.info.layout = BTF_LAYOUT_PAPER;
    create_refused(&desc, "packed points need layout tight");
    desc.info = good;
    desc.info.point_store = (btf_point_store)3;
    create_refused(&desc, "unknown store 3 of shift and gain");
    desc.info.point_store = BTF_POINTS_SEPARATE;
    create_refused(&desc, "gainBase 0.3 and gainStep 0.11 are only for packed points");
    static const float bad[] = {NAN, INFINITY, 0x1p-25f, -0x1p25f};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        desc.info = good;
        desc.info.gain_base = bad[i];
        create_refused(&desc, "gainBase");
        desc.info = good;
        desc.info.gain_step = bad[i];
        create_refused(&desc, "gainStep");
    }
    static const float limits[] = {0, -0.0f, 0x1p-24f, -0x1p24f};
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        desc.info = good;
        desc.info.gain_base = desc.info.gain_step = limits[i];
        btf_material *m = create_accepted(&desc);
        assert_true(accepted_info(m).gain_base == limits[i]);
        assert_false(limits[i] == 0 &&
                     (signbit(accepted_info(m).gain_base) || signbit(accepted_info(m).gain_step)));
        btf_material_close(&m);
    }
    random_material_free(&desc);
}

TEST(test_round_trip) {
    static const uint32_t more[] = {0, BTF_EFFECT_SHADOW, BTF_EFFECT_RESIDUAL};
    for (uint32_t i = 0; i < 3; i++) {
        btf_material_desc desc = make_desc(3 + i, more[i], 1 + i);
        btf_material *m = create_accepted(&desc), *opened = through_a_file(m);
        assert_memory_equal(btf_material_texture(opened, BTF_TEXTURE_POINTS).data,
                            desc.texture[BTF_TEXTURE_POINTS], 2 * WIDTH * HEIGHT * VIEWS);
        btf_material_close(&m);
        btf_material_close(&opened);
        random_material_free(&desc);
    }
}

TEST(test_list_round_trip) {
    for (uint32_t entries = 1; entries <= BTF_MAX_POINT_ENTRIES; entries++) {
        btf_material_desc desc =
            make_stored(40 + entries, entries & 1 ? BTF_EFFECT_RESIDUAL : 0, 1 + entries % 3, entries);
        btf_material *m = create_accepted(&desc), *opened = through_a_file(m);
        assert_memory_equal(btf_material_texture(opened, BTF_TEXTURE_POINT_INDICES).data,
                            desc.texture[BTF_TEXTURE_POINT_INDICES], WIDTH * HEIGHT * (VIEWS + 1) / 2);
        btf_material_close(&m);
        btf_material_close(&opened);
        random_material_free(&desc);
    }
}

/* Files of packed points and of lists, to be edited. */
static saved file, lists;

static int setup(void **state) {
    (void)state;
    for (uint32_t entries = 0; entries <= 6; entries += 6) {
        btf_material_desc desc = make_stored(6, 0, 2, entries);
        btf_material *m = create_accepted(&desc);
        *(entries ? &lists : &file) = save_material(m);
        btf_material_close(&m);
        random_material_free(&desc);
    }
    return 0;
}

static int teardown(void **state) {
    (void)state;
    btf_free(file.data);
    btf_free(lists.data);
    return 0;
}

TEST(test_file) {
    EDIT_REFUSED(take(&file), edit_remove_part(e, "points"), "part points: missing");
    EDIT_REFUSED(take(&file), edit_remove_part(e, "level1.points"), "part level1.points: missing");
    EDIT_REFUSED(take(&file), edit_copy_part(e, "points", "shift"), "part shift: unknown");
    EDIT_REFUSED(take(&file), edit_remove_channel(edit_find_part(e, "points"), "G"),
                 "part points: channel G is missing");
    edit_file *e = take(&file);
    const uint16_t half = 0x5C00; /* 256 */
    memcpy(edit_find_channel(e, "points", "R")->data, &half, 2);
    file_refused(e, "part points: channel R at (0, 0) holds half 0x5c00, not an integer of its range");
    /* without the attribute points are separate */
    EDIT_REFUSED(take(&file), edit_remove_attribute(e, "openbtf.pointStore"),
                 "unknown, or not in a material of these effects");
    EDIT_REFUSED(take(&file), edit_set_text(e, "openbtf.pointStore", "dense"),
                 "attribute openbtf.pointStore is \"dense\", which is unknown");
    EDIT_REFUSED(take(&file), edit_find_attribute(e, "openbtf.pointStore")->type = EXR_ATTR_DOUBLE,
                 "attribute openbtf.pointStore is of type double");
    EDIT_REFUSED(take(&file), edit_set_text(e, "openbtf.effects", "shift"),
                 "packed points need the effects shift and gain");
    /* version 1 knows no such attribute */
    EDIT_REFUSED(take(&file), edit_find_attribute(e, "openbtf.version")->i = 1,
                 "unknown, or not in a material of these effects");
}

/* Sets the index pair of a texel in the contact sheet of level 0: ten layers stand in four columns. */
static void set_indices(edit_file *file, uint32_t layer, uint32_t column, uint32_t row, uint16_t half) {
    edit_channel *channel = edit_find_channel(file, "point_indices", "R");
    const size_t at = (layer / 4 * HEIGHT + row) * 4 * WIDTH + layer % 4 * WIDTH + column;
    memcpy((uint16_t *)channel->data + at, &half, sizeof half);
}

TEST(test_file_of_lists) {
    static const char *const names[] = {"point_lists", "point_indices", "level1.point_lists",
                                        "level1.point_indices"};
    for (int i = 0; i < 4; i++) {
        EDIT_REFUSED(take(&lists), edit_remove_part(e, names[i]), told("part %s: missing", names[i]));
    }
    EDIT_REFUSED(take(&lists), edit_copy_part(e, "point_lists", "points"), "part points: unknown");
    EDIT_REFUSED(take(&lists), edit_remove_channel(edit_find_part(e, "point_lists"), "G"),
                 "part point_lists: channel G is missing");
    EDIT_REFUSED(take(&lists), edit_remove_attribute(e, "openbtf.pointEntries"),
                 "attribute openbtf.pointEntries is missing");
    static const int bad[] = {0, 17, -1};
    for (int i = 0; i < 3; i++) {
        EDIT_REFUSED(take(&lists), edit_find_attribute(e, "openbtf.pointEntries")->i = bad[i],
                     "openbtf.pointEntries");
    }
    /* the sheet of six layers is not that of four */
    EDIT_REFUSED(take(&lists), edit_find_attribute(e, "openbtf.pointEntries")->i = 4,
                 "part point_lists: data window");
    EDIT_REFUSED(take(&lists), edit_set_text(e, "openbtf.pointStore", "packed"),
                 "unknown, or not in a material of these effects");
    EDIT_REFUSED(take(&lists), set_indices(e, 3, 2, 1, 0x4600 /* 6 */),
                 "point_indices: view 6, texel (2, 1) names entry 6 of 6");
    EDIT_REFUSED(take(&lists), set_indices(e, 3, 2, 1, 0x5600 /* 96 */),
                 "point_indices: view 7, texel (2, 1) names entry 6 of 6");
    EDIT_REFUSED(take(&lists), set_indices(e, 9, 8, 5, 0x4C00 /* 16 */),
                 "point_indices: texel (8, 5): the high bits of the last layer hold 1, not 0");
    EDIT_REFUSED(take(&lists), set_indices(e, 10, 0, 0, 0x3C00 /* 1 */),
                 "part point_indices: channel R at (18, 12) holds half 0x3c00");
}

TEST(test_file_gains) {
    static const char *const names[] = {"openbtf.gainBase", "openbtf.gainStep"};
    for (int i = 0; i < 2; i++) {
        EDIT_REFUSED(take(&file), edit_remove_attribute(e, names[i]),
                     told("attribute %s is missing", names[i]));
        EDIT_REFUSED(take(&file), edit_find_attribute(e, names[i])->f = 0x1p25f,
                     names[i] + strlen("openbtf."));
        EDIT_REFUSED(take(&file), edit_find_attribute(e, names[i])->f = NAN, names[i] + strlen("openbtf."));
        edit_file *e = take(&file);
        edit_find_attribute(e, names[i])->f = -0.0f;
        btf_material *m = open_accepted(e);
        const btf_material_info info = accepted_info(m);
        assert_false(signbit(i ? info.gain_step : info.gain_base));
        btf_material_close(&m);
    }
}

/* An attribute that says `separate` is allowed too, in version 2. */
TEST(test_separate) {
    random_state r = {7};
    btf_material_desc desc = random_material_desc(3, 2, 4, 3, BTF_LAYOUT_TIGHT, BOTH);
    desc.info.domain = BTF_DOMAIN_SQRT;
    desc.info.blend = BTF_BLEND_ROOTS;
    random_material_fill(&r, &desc);
    btf_material *m = create_accepted(&desc);
    saved whole = save_material(m);
    edit_file *e = take(&whole);
    for (int a = 0; a < e->attribute_count; a++) {
        assert_string_not_equal(e->attributes[a].name, "openbtf.pointStore");
        assert_string_not_equal(e->attributes[a].name, "openbtf.gainBase");
    }
    edit_attribute *store = &e->attributes[e->attribute_count++];
    *store =
        (edit_attribute){.name = "openbtf.pointStore", .type = EXR_ATTR_STRING, .text = strdup("separate")};
    btf_material *opened = open_accepted(e);
    assert_same_material(m, opened);
    btf_free(whole.data);
    btf_material_close(&m);
    btf_material_close(&opened);
    random_material_free(&desc);
}

/* A restriction keeps the parts of packed points that its plan decodes: both, the shift or the gain alone, or
 * neither. */
TEST(test_restrict) {
    random_state r = {8};
    static const uint32_t kept[] = {BOTH, BTF_EFFECT_SHIFT, BTF_EFFECT_GAIN, 0};
    int lit = 0, all_lit = 0, fewer = 0;
    for (int round = 0; round < 48; round++) {
        const uint32_t effects = kept[round % 4] | BTF_EFFECT_RESIDUAL;
        btf_material_desc desc = make_desc(20 + (uint64_t)round, BTF_EFFECT_RESIDUAL, 3);
        desc.info.blend = round & 4 ? BTF_BLEND_ROOTS : BTF_BLEND_RADIANCE;
        btf_material *whole = create_accepted(&desc), *small;
        btf_plan plan = {.struct_size = sizeof plan,
                         .scene = {.struct_size = sizeof plan.scene, .view.theta = {0, 35}},
                         .effects = effects,
                         .components = 5,
                         .level = random_below(&r, 3),
                         .shader = {.struct_size = sizeof plan.shader,
                                    .leave_out = desc.info.effects & ~effects,
                                    .components = 5}};
        assert_int_equal(btf_material_restrict(whole, &plan, &log_keep, &small), BTF_OK);
        const btf_material_info info = accepted_info(small);
        const bool packed = effects & BTF_EFFECT_GAIN;
        assert_int_equal(info.effects, packed ? effects | BTF_EFFECT_SHIFT : effects);
        assert_int_equal(info.point_store, packed ? BTF_POINTS_PACKED : BTF_POINTS_SEPARATE);
        assert_true(info.gain_step == (packed ? 0.11f : 0) && info.gain_base == (packed ? 0.3f : 0));
        assert_int_equal(accepted_texture(small, BTF_TEXTURE_POINTS), packed);
        assert_int_equal(accepted_texture(small, BTF_TEXTURE_SHIFT), !packed && effects & BTF_EFFECT_SHIFT);
        assert_false(accepted_texture(small, BTF_TEXTURE_GAIN));
        assert_int_equal(info.version, packed || desc.info.blend == BTF_BLEND_ROOTS ? 2 : 1);
        fewer += info.n_views < VIEWS;
        assert_int_equal(plan_differences(&r, whole, small, &plan, 100, &lit), 0);
        all_lit += lit;
        /* decoded with all its effects, the restriction gives the plan's result too */
        btf_material *back = through_a_file(small);
        if (round % 4 == 2) {
            const btf_texture points = btf_material_texture(small, BTF_TEXTURE_POINTS);
            const uint8_t *bytes = points.data;
            for (size_t i = 0; i < points.size; i += 2) {
                assert_int_equal((bytes[i] + 256 * bytes[i + 1]) % 4096, 32 * 65);
            }
        }
        btf_material_close(&back);
        btf_material_close(&small);
        btf_material_close(&whole);
        random_material_free(&desc);
    }
    assert_true(all_lit > 48 * 50);
    assert_true(fewer > 20);
}

/* Decoding a restriction with all its effects gives what the plan decodes of the whole: where the plan leaves an effect
 * out, shifts are 0 or gains 1. */
static void assert_decoded_whole(random_state *r, const btf_material *whole, const btf_material *small,
                                 const btf_plan *plan) {
    const btf_directions views = btf_material_views(whole), lights = btf_material_lights(whole);
    btf_ref_options by_plan = {.effects = plan->effects,
                               .components = plan->components,
                               .interpolation = BTF_REF_LINEAR},
                    all = by_plan;
    all.effects = BTF_EFFECT_ALL;
    btf_ref_material a, b;
    reference_view(whole, plan->level, &a);
    reference_view(small, 0, &b);
    for (int i = 0; i < 50; i++) {
        float view[3], light[3], rgb[2][3];
        plan_direction(r, &plan->scene.view, &views, view);
        plan_direction(r, &plan->scene.light, &lights, light);
        const float u = (float)random_unit(r), v = (float)random_unit(r);
        btf_ref_evaluate(&a, &by_plan, u, v, light, view, rgb[0]);
        btf_ref_evaluate(&b, &all, u, v, light, view, rgb[1]);
        assert_memory_equal(rgb[0], rgb[1], sizeof rgb[0]);
    }
}

/* A restriction keeps lists where they take fewer bytes, else it stores packed points. */
TEST(test_restrict_lists) {
    random_state r = {11};
    static const uint32_t kept[] = {BOTH, BTF_EFFECT_SHIFT, BTF_EFFECT_GAIN, 0};
    int lit = 0, all_lit = 0, lists = 0, dense = 0;
    for (int round = 0; round < 48; round++) {
        const uint32_t effects = kept[round % 4] | BTF_EFFECT_RESIDUAL;
        btf_material_desc desc =
            make_stored(120 + (uint64_t)round, BTF_EFFECT_RESIDUAL, 3, round & 4 ? 3 : 14);
        btf_material *whole = create_accepted(&desc), *small;
        btf_plan plan = {
            .struct_size = sizeof plan,
            .scene = {.struct_size = sizeof plan.scene, .view.theta = {0, round & 8 ? 90 : 35}},
            .effects = effects,
            .components = 5,
            .level = random_below(&r, 3),
            .shader = {.struct_size = sizeof plan.shader,
                       .leave_out = desc.info.effects & ~effects,
                       .components = 5}};
        assert_int_equal(btf_material_restrict(whole, &plan, &log_keep, &small), BTF_OK);
        const btf_material_info info = accepted_info(small);
        const uint32_t entries = desc.info.point_entries, n = info.n_views,
                       gain = effects & BTF_EFFECT_GAIN;
        const bool stays = effects & BOTH && 2 * entries + (n + 1) / 2 < 2 * n;
        assert_int_equal(info.point_store, stays  ? BTF_POINTS_LISTS
                                           : gain ? BTF_POINTS_PACKED
                                                  : BTF_POINTS_SEPARATE);
        assert_int_equal(info.point_entries, stays ? entries : 0);
        assert_int_equal(info.effects, stays || gain ? effects | BOTH : effects);
        assert_true(info.gain_base == (gain    ? 0.3f
                                       : stays ? 1
                                               : 0) &&
                    info.gain_step == (gain ? 0.11f : 0));
        assert_int_equal(accepted_texture(small, BTF_TEXTURE_SHIFT),
                         !stays && !gain && effects & BTF_EFFECT_SHIFT);
        lists += stays;
        dense += !stays && effects & BOTH;
        assert_int_equal(plan_differences(&r, whole, small, &plan, 100, &lit), 0);
        all_lit += lit;
        assert_decoded_whole(&r, whole, small, &plan);
        btf_material *back = through_a_file(small);
        btf_material_close(&back);
        btf_material_close(&small);
        btf_material_close(&whole);
        random_material_free(&desc);
    }
    assert_true(all_lit > 48 * 50);
    assert_true(lists > 12 && dense > 12);
}

/* The bytes of a plan are those of its restriction, and its textures those that the shader reads; the cost model counts
 * fetches of codes. */
TEST(test_plan) {
    static const uint32_t kept[] = {BOTH, BTF_EFFECT_SHIFT, BTF_EFFECT_GAIN, 0};
    for (int k = 0; k < 8; k++) {
        const int i = k / 2;
        const bool lists = k % 2;
        btf_material_desc desc = make_stored(9, BTF_EFFECT_RESIDUAL, 1, lists ? 4 : 0);
        const uint32_t effects = kept[i] | BTF_EFFECT_RESIDUAL;
        float table[] = {1, 1, 0, 75,   0,     75,    (float)desc.info.effects,
                         5, 0, 0, 1000, 0.01f, 0.02f, (float)effects,
                         5, 0, 0, 900,  0.01f, 0.02f};
        desc.effect_errors = table;
        desc.effect_error_count = sizeof table / sizeof *table;
        btf_material *m = create_accepted(&desc), *small;
        btf_plan plan;
        assert_int_equal(btf_plan_effects(m, NULL, 0.5f, &plan), BTF_OK);
        /* One of the two alone is as many bytes and fetches as both. */
        assert_int_equal(plan.effects, i < 3 ? desc.info.effects : effects);
        const uint32_t of_lists = 1u << BTF_TEXTURE_POINT_LISTS | 1u << BTF_TEXTURE_POINT_INDICES;
        const uint32_t points = plan.textures & (of_lists | 1u << BTF_TEXTURE_POINTS |
                                                 1u << BTF_TEXTURE_SHIFT | 1u << BTF_TEXTURE_GAIN);
        assert_int_equal(points, i == 3 ? 0 : lists ? of_lists : 1u << BTF_TEXTURE_POINTS);
        assert_int_equal(btf_material_restrict(m, &plan, NULL, &small), BTF_OK);
        assert_int_equal(accepted_info(small).gpu_bytes, plan.gpu_bytes);
        btf_material_close(&small);

        const btf_shader_options options = {.struct_size = sizeof options};
        btf_material_desc apart = desc;
        uint8_t *shift = calloc(2, WIDTH * HEIGHT * VIEWS), *gain = malloc(WIDTH * HEIGHT * VIEWS);
        assert_true(shift && gain);
        memset(gain, BTF_GAIN_ONE, WIDTH * HEIGHT * VIEWS);
        apart.info.point_store = BTF_POINTS_SEPARATE;
        apart.info.point_entries = 0;
        apart.info.gain_base = apart.info.gain_step = 0;
        apart.texture[BTF_TEXTURE_POINTS] = apart.texture[BTF_TEXTURE_POINT_LISTS] =
            apart.texture[BTF_TEXTURE_POINT_INDICES] = NULL;
        apart.texture[BTF_TEXTURE_SHIFT] = shift;
        apart.texture[BTF_TEXTURE_GAIN] = gain;
        btf_material *separate = create_accepted(&apart);
        /* three neighbouring views, one fetch less and a byte; lists have two again, of one byte and two */
        const btf_decode_counts two = btf_plan_counts(separate, &options, NULL),
                                one = btf_plan_counts(m, &options, NULL);
        assert_true(two.fetches - one.fetches == (lists ? 0 : 3) &&
                    two.bytes - one.bytes == (lists ? 0 : 3));
        free(shift);
        free(gain);
        btf_material_close(&separate);
        btf_material_close(&m);
        random_material_free(&desc);
    }
}

/* A shader declares the textures that it reads, and no others. */
TEST(test_shader) {
    btf_material_desc desc = make_desc(10, 0, 1);
    btf_material *m = create_accepted(&desc);
    for (uint32_t left = 0; left < 4; left++) {
        const btf_shader_options options = {.struct_size = sizeof options,
                                            .leave_out = (left & 1 ? BTF_EFFECT_SHIFT : 0u) |
                                                         (left & 2 ? BTF_EFFECT_GAIN : 0u),
                                            .bindings = BTF_BINDINGS_GL,
                                            .first_binding = 3};
        const btf_material_info info = accepted_info(m);
        const uint32_t textures = btf_shader_textures(&info, &options);
        assert_int_equal(textures >> BTF_TEXTURE_POINTS & 1, left != 3);
        assert_int_equal(textures & (1u << BTF_TEXTURE_SHIFT | 1u << BTF_TEXTURE_GAIN), 0);
        char *text;
        assert_int_equal(btf_shader_source(m, &options, NULL, &text), BTF_OK);
        assert_non_null(strstr(text, "#define BTF_POINTS 1\n"));
        assert_non_null(strstr(text, "#define BTF_GAIN_STEP uintBitsToFloat(0x3DE147AEu)\n"));
        assert_non_null(strstr(text, "#define BTF_BINDING_POINTS 18\n"));
        btf_free(text);
    }
    btf_material_close(&m);
    random_material_free(&desc);
}

TEST(test_shader_of_lists) {
    btf_material_desc desc = make_stored(10, 0, 1, 7);
    btf_material *m = create_accepted(&desc);
    const uint32_t both = 1u << BTF_TEXTURE_POINT_LISTS | 1u << BTF_TEXTURE_POINT_INDICES,
                   others = 1u << BTF_TEXTURE_POINTS | 1u << BTF_TEXTURE_SHIFT | 1u << BTF_TEXTURE_GAIN;
    for (uint32_t left = 0; left < 4; left++) {
        const btf_shader_options options = {.struct_size = sizeof options,
                                            .leave_out = (left & 1 ? BTF_EFFECT_SHIFT : 0u) |
                                                         (left & 2 ? BTF_EFFECT_GAIN : 0u),
                                            .bindings = BTF_BINDINGS_GL,
                                            .first_binding = 3};
        const btf_material_info info = accepted_info(m);
        assert_int_equal(btf_shader_textures(&info, &options) & (both | others), left == 3 ? 0 : both);
        char *text;
        assert_int_equal(btf_shader_source(m, &options, NULL, &text), BTF_OK);
        assert_non_null(strstr(text, "#define BTF_POINTS 2\n"));
        assert_non_null(strstr(text, "#define BTF_GAIN_STEP uintBitsToFloat(0x3DE147AEu)\n"));
        assert_non_null(strstr(text, "#define BTF_BINDING_POINT_LISTS 19\n"));
        assert_non_null(strstr(text, "#define BTF_BINDING_POINT_INDICES 20\n"));
        btf_free(text);
    }
    btf_material_close(&m);
    random_material_free(&desc);
}

RUN_TESTS(setup, teardown)
