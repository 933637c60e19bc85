/* Relief and gloss in the library: shapes, what is refused when a material is made or opened, saving and opening,
 * levels, and that a plan's restriction decodes by the reference as the whole does, bit for bit.
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
enum { BOTH = BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS };

/* Relief acts on every view but the third. */
static btf_material_desc make_desc(uint64_t seed, uint32_t effects, uint32_t levels) {
    static uint8_t acts[VIEWS];
    random_state r = {seed};
    btf_material_desc desc = random_material_desc(WIDTH, HEIGHT, VIEWS, LIGHTS, BTF_LAYOUT_TIGHT, effects);
    desc.info.levels = levels;
    desc.info.domain = BTF_DOMAIN_SQRT;
    if (effects & BTF_EFFECT_RELIEF) {
        uint8_t *own = malloc(sizeof acts);
        assert_non_null(own);
        memset(own, 1, sizeof acts);
        own[2] = 0;
        desc.relief_views = own;
    }
    random_material_fill(&r, &desc);
    return desc;
}

TEST(test_shapes) {
    btf_material_desc desc = make_desc(1, BOTH, 3);
    btf_material *m = create_accepted(&desc);
    const btf_material_info info = accepted_info(m);
    assert_int_equal(info.version, 2);
    assert_int_equal(info.relief_base, -256);
    assert_int_equal(info.relief_step, 801);
    assert_int_equal(info.relief_steps, 7);
    assert_int_equal(info.relief_level, 0);
    assert_int_equal(info.gloss_share, 1);
    assert_string_equal(btf_texture_name(BTF_TEXTURE_HEIGHTS), "heights");
    assert_string_equal(btf_texture_name(BTF_TEXTURE_VIEW_VECTORS), "view_vectors");
    const btf_texture vectors = btf_material_texture(m, BTF_TEXTURE_VIEW_VECTORS);
    assert_int_equal(vectors.format, BTF_FORMAT_RGBA32F);
    assert_false(vectors.is_array);
    assert_true(vectors.width == VIEWS && vectors.height == 1 && vectors.layers == 1);
    assert_int_equal(vectors.size, 16 * VIEWS);
    const float *numbers = vectors.data;
    for (size_t v = 0; v < VIEWS; v++) {
        assert_memory_equal(numbers + 4 * v, desc.views + 3 * v, 3 * sizeof(float));
        assert_true(numbers[4 * v + 3] == (v == 2 ? 0 : 1));
    }
    assert_int_equal(btf_material_texture_shape(&info, BTF_TEXTURE_VIEW_VECTORS).format, BTF_FORMAT_NONE);
    size_t bytes = 0;
    for (uint32_t level = 0; level < 3; level++) {
        const btf_texture heights = btf_material_level_texture(m, level, BTF_TEXTURE_HEIGHTS);
        assert_int_equal(heights.format, BTF_FORMAT_R8UI);
        assert_false(heights.is_array);
        assert_int_equal(heights.width, WIDTH >> level);
        assert_int_equal(heights.height, HEIGHT >> level);
        assert_int_equal(heights.layers, 1);
        assert_int_equal(heights.size, (WIDTH >> level) * (HEIGHT >> level));
        assert_memory_equal(heights.data,
                            level ? desc.level_texture[level][BTF_TEXTURE_HEIGHTS]
                                  : desc.texture[BTF_TEXTURE_HEIGHTS],
                            heights.size);
        assert_int_equal(btf_material_level_texture(m, level, BTF_TEXTURE_VIEW_VECTORS).format,
                         level ? BTF_FORMAT_NONE : BTF_FORMAT_RGBA32F);
        bytes += heights.size + btf_material_level_texture(m, level, BTF_TEXTURE_SBRDF).size;
    }
    assert_int_equal(info.gpu_bytes, bytes);
    assert_int_equal(info.table_bytes, btf_material_texture(m, BTF_TEXTURE_VIEW_TABLE).size +
                                           btf_material_texture(m, BTF_TEXTURE_LIGHT_TABLE).size +
                                           vectors.size);
    btf_material_close(&m);
    random_material_free(&desc);
}

/* With relief, gloss, both or neither: the textures that there are, and the views that relief acts on. */
TEST(test_either) {
    for (int i = 0; i < 5; i++) {
        const uint32_t effects = i == 0   ? 0
                                 : i == 1 ? BTF_EFFECT_GLOSS
                                          : BTF_EFFECT_RELIEF | (i == 4 ? BTF_EFFECT_GLOSS : 0u);
        btf_material_desc desc = make_desc(2, effects, 2);
        const uint8_t *acts = desc.relief_views;
        if (i == 2) {
            desc.relief_views = NULL; /* all */
        }
        if (i == 3) { /* one height everywhere */
            desc.info.relief_step = 0;
            desc.info.relief_steps = 1;
            free((void *)(uintptr_t)desc.texture[BTF_TEXTURE_HEIGHTS]);
            free((void *)(uintptr_t)desc.level_texture[1][BTF_TEXTURE_HEIGHTS]);
            desc.texture[BTF_TEXTURE_HEIGHTS] = desc.level_texture[1][BTF_TEXTURE_HEIGHTS] = NULL;
        }
        btf_material *m = create_accepted(&desc);
        assert_int_equal(accepted_info(m).version, i == 0 ? 1 : 2);
        assert_int_equal(accepted_texture(m, BTF_TEXTURE_HEIGHTS), i == 2 || i == 4);
        assert_int_equal(accepted_texture(m, BTF_TEXTURE_VIEW_VECTORS), i > 0);
        const float *numbers = btf_material_texture(m, BTF_TEXTURE_VIEW_VECTORS).data;
        for (size_t v = 0; v < VIEWS && i > 0; v++) {
            assert_true(numbers[4 * v + 3] == (i == 1 ? 0 : i == 2 ? 1 : v != 2));
        }
        btf_material_close(&m);
        desc.relief_views = acts;
        random_material_free(&desc);
    }
}

/* The members of info that relief and gloss have, to be set by a table. */
typedef enum member { BASE, STEP, STEPS, LEVEL, SHARE } member;

static void set_member(btf_material_info *info, member which, int64_t value) {
    switch (which) {
    case BASE:
        info->relief_base = (int32_t)value;
        break;
    case STEP:
        info->relief_step = (int32_t)value;
        break;
    case STEPS:
        info->relief_steps = (uint32_t)value;
        break;
    case LEVEL:
        info->relief_level = (uint32_t)value;
        break;
    case SHARE:
        info->gloss_share = (uint32_t)value;
        break;
    }
}

TEST(test_create_refuses) {
    static const struct {
        uint32_t effects;
        member which;
        int64_t value;
        const char *text; /* NULL: accepted */
    } cases[] = {
        {BOTH, BASE, -32769, "reliefBase -32769 is not within -32768 to 32767"},
        {BOTH, BASE, -32768, NULL},
        {BOTH, BASE, 31970, NULL}, /* (255 * 801) >> 8 is 797 */
        {BOTH, BASE, 31971,
         "reliefBase 31971 and reliefStep 801: the greatest height is 32768, above 32767"},
        {BOTH, BASE, 32768, "reliefBase 32768 is not within"},
        {BOTH, STEP, -1, "reliefStep -1 is not within 0 to 32767"},
        {BOTH, STEP, 32767, NULL},
        {BOTH, STEP, 32768, "reliefStep 32768 is not within"},
        {BOTH, STEP, INT32_MAX, "reliefStep 2147483647 is not within"},
        {BOTH, STEP, 0, "reliefSteps is 7; it must be 1 where reliefStep is 0"},
        {BOTH, STEPS, 0, "reliefSteps 0 is not within 1 to 64"},
        {BOTH, STEPS, 1, NULL},
        {BOTH, STEPS, 64, NULL},
        {BOTH, STEPS, 65, "reliefSteps 65 is not within 1 to 64"},
        {BOTH, STEPS, UINT32_MAX, "reliefSteps 4294967295 is not within"},
        {BOTH, LEVEL, 13, NULL},
        {BOTH, LEVEL, 14, "reliefLevel 14 and levels 2 are more than 15 in all"},
        {BOTH, LEVEL, 15, "reliefLevel 15 is not within 0 to 14"},
        {BOTH, SHARE, 0, "glossShare 0 is not within 1 to 2"},
        {BOTH, SHARE, 2, NULL},
        {BOTH, SHARE, 3, "glossShare 3 is not within 1 to 2"},
        {BTF_EFFECT_GLOSS, BASE, 1, "reliefBase 1 without the effect relief"},
        {BTF_EFFECT_GLOSS, STEP, 1, "reliefStep 1 without the effect relief"},
        {BTF_EFFECT_GLOSS, STEPS, 1, "reliefSteps 1 without the effect relief"},
        {BTF_EFFECT_GLOSS, LEVEL, 1, "reliefLevel 1 without the effect relief"},
        {BTF_EFFECT_RELIEF, SHARE, 1, "glossShare 1 without the effect gloss"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        btf_material_desc desc = make_desc(3, cases[i].effects, 2);
        set_member(&desc.info, cases[i].which, cases[i].value);
        if (cases[i].text) {
            create_refused(&desc, cases[i].text);
        } else {
            btf_material *m = create_accepted(&desc);
            btf_material_close(&m);
        }
        random_material_free(&desc);
    }
}

TEST(test_create_refuses_others) {
    btf_material_desc good = make_desc(4, BOTH | BTF_EFFECT_RESIDUAL, 2), bad = good;
    const uint8_t acts[VIEWS] = {0, 1, 1, 0, 2}, *const own = good.relief_views;
    const float vectors[4 * VIEWS] = {0};
    bad.relief_views = acts;
    create_refused(&bad, "reliefViews: number 4 is 2, not 0 or 1");
    bad = good;
    bad.texture[BTF_TEXTURE_VIEW_VECTORS] = vectors;
    create_refused(&bad, "view_vectors: given, but the material has no such texture");
    bad = good;
    bad.texture[BTF_TEXTURE_HEIGHTS] = NULL;
    create_refused(&bad, "heights: missing; the material needs its 54 bytes");
    bad = good;
    bad.level_texture[1][BTF_TEXTURE_HEIGHTS] = NULL;
    create_refused(&bad, "level1.heights: missing; the material needs its 12 bytes");
    bad = good;
    bad.info.relief_step = 0;
    bad.info.relief_steps = 1;
    create_refused(&bad, "heights: given, but the material has no such texture");
    bad = good;
    bad.info.effects |= 128;
    create_refused(&bad, "effects 0xf0 has unknown bits");
    bad = good;
    bad.info.effects &= ~(uint32_t)BTF_EFFECT_RELIEF;
    bad.info.relief_base = bad.info.relief_step = 0;
    bad.info.relief_steps = 0;
    create_refused(&bad, "heights: given, but the material has no such texture");
    bad.texture[BTF_TEXTURE_HEIGHTS] = bad.level_texture[1][BTF_TEXTURE_HEIGHTS] = NULL;
    create_refused(&bad, "reliefViews: given without the effect relief");
    bad.relief_views = NULL;
    btf_material *m = create_accepted(&bad);
    btf_material_close(&m);
    good.relief_views = own;
    random_material_free(&good);

    for (int gloss = 0; gloss < 2; gloss++) {
        btf_material_desc paper = random_material_desc(4, 4, 3, 3, BTF_LAYOUT_PAPER, BTF_EFFECT_SHADOW);
        random_state r = {5};
        random_material_fill(&r, &paper);
        paper.info.effects |= gloss ? BTF_EFFECT_GLOSS : BTF_EFFECT_RELIEF;
        paper.info.gloss_share = gloss ? 1 : 0;
        paper.info.relief_steps = gloss ? 0 : 1;
        create_refused(&paper, gloss ? "the effect gloss needs layout tight"
                                     : "the effect relief needs layout tight");
        random_material_free(&paper);
    }
}

/* Every set of effects, and the most textures that a file may have. */
TEST(test_round_trip) {
    random_state r = {6};
    for (uint32_t effects = 32; effects <= BTF_EFFECT_ALL; effects++) {
        const bool most = effects == BTF_EFFECT_ALL;
        const uint32_t width = most ? 16384 : 5, height = most ? 1 : 4;
        btf_material_desc desc = random_material_desc(width, height, 3, 2, BTF_LAYOUT_TIGHT, effects);
        desc.info.levels = most ? BTF_MAX_LEVELS : 1 + random_below(&r, 3);
        random_material_relief(&r, &desc);
        if (most) { /* the most textures, of which the last is a map */
            desc.info.relief_base = 0;
            desc.info.relief_step = 400;
            desc.info.relief_steps = 3;
        }
        random_material_fill(&r, &desc);
        btf_material *m = create_accepted(&desc), *opened = through_a_file(m), *tight;
        assert_int_equal(btf_material_to_tight(m, NULL, &tight), BTF_OK);
        if (!(effects & BTF_EFFECT_HIDDEN)) { /* of whose centres those stay that are shown */
            assert_same_material(m, tight);
        }
        btf_material_close(&tight);
        btf_material_close(&m);
        btf_material_close(&opened);
        random_material_free(&desc);
    }
}

/* A file of two levels, to be edited. */
static saved file;

static int setup(void **state) {
    (void)state;
    btf_material_desc desc = make_desc(7, BOTH, 2);
    btf_material *m = create_accepted(&desc);
    file = save_material(m);
    btf_material_close(&m);
    random_material_free(&desc);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    btf_free(file.data);
    return 0;
}

TEST(test_file_parts) {
    file_accepted(take(&file));
    EDIT_REFUSED(take(&file), edit_remove_part(e, "heights"), "part heights: missing");
    EDIT_REFUSED(take(&file), edit_remove_part(e, "level1.heights"), "part level1.heights: missing");
    EDIT_REFUSED(take(&file), edit_copy_part(e, "heights", "view_vectors"), "part view_vectors: unknown");
    EDIT_REFUSED(take(&file), edit_add_channel(edit_find_part(e, "heights"), "A", EXR_PIXEL_HALF),
                 "part heights: unknown channel A");
    EDIT_REFUSED(take(&file), edit_resize(edit_find_part(e, "heights"), WIDTH, HEIGHT + 1),
                 "part heights: data window (0,0)-(8,6), not (0,0)-(8,5)");
    static const uint16_t bad[] = {0x5C00, 0x3800, 0xBC00, 0x7E00}; /* 256, a half, -1, no number */
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        EDIT_REFUSED(take(&file), memcpy(edit_find_channel(e, "level1.heights", "Y")->data + 2, &bad[i], 2),
                     told("part level1.heights: channel Y at (1, 0) holds half 0x%04x", bad[i]));
    }
    edit_file *e = take(&file);
    edit_find_attribute(e, "openbtf.reliefStep")->i = 0;
    edit_find_attribute(e, "openbtf.reliefSteps")->i = 1;
    file_refused(e, "heights: unknown, or not in a material of these effects");
}

TEST(test_file_attributes) {
    static const struct {
        const char *name;
        int value;
        const char *text;
    } cases[] = {
        {"reliefBase", -32769, "attribute openbtf.reliefBase is -32769, not within -32768 to 32767"},
        {"reliefBase", 32768, "attribute openbtf.reliefBase is 32768, not within"},
        {"reliefBase", 31971,
         "reliefBase 31971 and reliefStep 801: the greatest height is 32768, above 32767"},
        {"reliefStep", -1, "attribute openbtf.reliefStep is -1, not within 0 to 32767"},
        {"reliefStep", 32768, "attribute openbtf.reliefStep is 32768, not within"},
        {"reliefStep", 0, "reliefSteps is 7; it must be 1 where reliefStep is 0"},
        {"reliefSteps", 0, "attribute openbtf.reliefSteps is 0, not within 1 to 64"},
        {"reliefSteps", 65, "attribute openbtf.reliefSteps is 65, not within"},
        {"glossShare", 0, "attribute openbtf.glossShare is 0, not within 1 to 2"},
        {"glossShare", 3, "attribute openbtf.glossShare is 3, not within"},
    };
    char name[40], text[100];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        edit_file *e = take(&file);
        snprintf(name, sizeof name, "openbtf.%s", cases[i].name);
        edit_find_attribute(e, name)->i = cases[i].value;
        file_refused(e, cases[i].text);
    }
    static const char *const words[] = {"reliefBase", "reliefStep", "reliefSteps", "reliefViews",
                                        "glossShare"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        edit_file *e = take(&file);
        snprintf(name, sizeof name, "openbtf.%s", words[i]);
        edit_remove_attribute(e, name);
        file_refused(e, told("attribute %s is missing", name));
        EDIT_REFUSED(take(&file), edit_find_attribute(e, name)->type = EXR_ATTR_DOUBLE,
                     told("attribute %s is of type double", name));
        e = take(&file);
        edit_set_text(e, "openbtf.effects", i < 4 ? "gloss" : "relief");
        for (size_t k = 0; k < i && i < 4; k++) { /* those before would be refused first */
            snprintf(text, sizeof text, "openbtf.%s", words[k]);
            edit_remove_attribute(e, text);
        }
        if (i < 4) {
            edit_remove_part(e, "heights");
            edit_remove_part(e, "level1.heights");
        }
        if (i == 3) {
            file_refused(e, "attribute openbtf.reliefViews is there, but there are no views of relief");
        } else {
            file_refused(e, told("attribute %s without the effect %s", name, i < 3 ? "relief" : "gloss"));
        }
    }
}

/* Numbers of reliefViews, the words of effects, the version, and the level that only restrictions have. */
TEST(test_file_views) {
    static const float bad[] = {2, -1, 0.5f, NAN, INFINITY};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        EDIT_REFUSED(take(&file), edit_find_attribute(e, "openbtf.reliefViews")->values[5] = bad[i],
                     "attribute openbtf.reliefViews: number 5 is");
    }
    EDIT_REFUSED(take(&file), edit_find_attribute(e, "openbtf.reliefViews")->count = VIEWS - 1,
                 "attribute openbtf.reliefViews holds 18 numbers, which do not fit the 19 views of relief");
    edit_file *e = take(&file);
    edit_find_attribute(e, "openbtf.reliefViews")->values[5] = -0.0f;
    file_accepted(e);
    EDIT_REFUSED(take(&file), edit_set_text(e, "openbtf.effects", "gloss,relief"),
                 "attribute openbtf.effects is \"gloss,relief\": unknown, repeated or out of order");
    EDIT_REFUSED(take(&file), edit_find_attribute(e, "openbtf.version")->i = 1,
                 "attribute openbtf.effects is \"relief,gloss\": unknown, repeated or out of order");
    EDIT_REFUSED(take(&file), edit_set_text(e, "openbtf.layout", "paper"),
                 "attribute openbtf.atlasWidth is missing");
    static const struct {
        int level;
        const char *text;
    } levels[] = {{0, NULL},
                  {13, NULL},
                  {14, "reliefLevel 14 and levels 2 are more than 15 in all"},
                  {15, "attribute openbtf.reliefLevel is 15, not within 0 to 14"},
                  {-1, "attribute openbtf.reliefLevel is -1, not within"}};
    for (size_t i = 0; i < sizeof levels / sizeof *levels; i++) {
        e = take(&file);
        edit_attribute *added = &e->attributes[e->attribute_count++];
        *added =
            (edit_attribute){.name = "openbtf.reliefLevel", .type = EXR_ATTR_INT, .i = levels[i].level};
        if (levels[i].text) {
            file_refused(e, levels[i].text);
        } else {
            file_accepted(e);
        }
    }
}

static btf_range random_range(random_state *r) {
    btf_range range = {0};
    const uint32_t kind = random_below(r, 4);
    if (kind == 0) {
        range.fixed = 1;
        plan_angles(random_below(r, 3) ? 89 * random_unit(r) : 15.0 * random_below(r, 6),
                    random_below(r, 3) ? 360 * random_unit(r) : 60.0 * random_below(r, 6), range.direction);
    } else if (kind > 1) {
        range.theta[1] = (float)(20 + 70 * random_unit(r));
    }
    return range;
}

/* A restriction has the plan's effects alone, and the heights of the whole. */
static void assert_restricted(const btf_material *whole, const btf_material *small, const btf_plan *plan) {
    const btf_material_info a = accepted_info(whole), b = accepted_info(small);
    const bool ended = plan->level >= a.relief_end,
               relief = !ended && a.effects & plan->effects & BTF_EFFECT_RELIEF,
               gloss = a.effects & plan->effects & BTF_EFFECT_GLOSS;
    assert_int_equal(b.effects & BOTH, a.effects & plan->effects & (ended ? BTF_EFFECT_GLOSS : BOTH));
    assert_int_equal(b.relief_end, relief ? a.relief_end - plan->level : 0);
    assert_int_equal(b.relief_base, relief ? a.relief_base : 0);
    assert_int_equal(b.relief_step, relief ? a.relief_step : 0);
    assert_int_equal(b.relief_steps, relief ? a.relief_steps : 0);
    assert_int_equal(b.relief_level, relief ? a.relief_level + plan->level : 0);
    assert_int_equal(b.gloss_share, gloss ? a.gloss_share : 0);
    assert_true(!gloss || b.n_lights == a.n_lights);
    assert_int_equal(accepted_texture(small, BTF_TEXTURE_HEIGHTS), relief && a.relief_step > 0);
    assert_int_equal(accepted_texture(small, BTF_TEXTURE_VIEW_VECTORS), relief || gloss);
    const btf_texture in = btf_material_level_texture(whole, plan->level, BTF_TEXTURE_HEIGHTS),
                      out = btf_material_texture(small, BTF_TEXTURE_HEIGHTS);
    if (out.size) {
        assert_memory_equal(in.data, out.data, out.size);
    }
}

/* Any plan's restriction decodes to the same bits as the whole, also after saving and opening, and when restricted once
 * more. */
TEST(test_restrict) {
    enum { MATERIALS = 24, PLANS = 6, SAMPLES = 40 };
    random_state r = {8};
    int lit = 0, all_lit = 0, fewer = 0, coarser = 0;
    for (int round = 0; round < MATERIALS * PLANS; round++) {
        static btf_material *whole;
        static btf_material_info info;
        if (round % PLANS == 0) {
            const uint32_t both = BTF_EFFECT_RELIEF * (1 + random_below(&r, 3)),
                           others = random_below(&r, 32);
            btf_material_desc desc = random_material_desc(9, 6, 37, 19, BTF_LAYOUT_TIGHT, both | others);
            desc.info.domain = BTF_DOMAIN_SQRT;
            desc.info.levels = 1 + random_below(&r, 3);
            factor_material_choose(&r, &desc);
            random_material_relief(&r, &desc);
            factor_material_fill(&r, &desc);
            whole = create_accepted(&desc);
            info = accepted_info(whole);
            random_material_free(&desc);
        }
        btf_scene scene = {.struct_size = sizeof scene,
                           .view = random_range(&r),
                           .light = random_range(&r),
                           .pixels = random_below(&r, 2) ? 1 : 0.3f};
        btf_plan plan;
        assert_int_equal(btf_plan_effects(whole, &scene, 0.5f, &plan), BTF_OK);
        assert_int_equal(plan.lights == info.n_lights || !(plan.effects & BTF_EFFECT_GLOSS), 1);
        if (random_below(&r, 2)) {
            plan.effects = info.effects & (BTF_EFFECT_RELIEF * random_below(&r, 4) | random_below(&r, 32));
        }
        plan.components = plan.effects & BTF_EFFECT_RESIDUAL ? 1 + random_below(&r, info.components) : 0;
        plan.shader.leave_out = info.effects & ~plan.effects;
        plan.shader.components = plan.components;
        plan.shader.interpolation = (btf_interpolation)random_below(&r, 2);
        plan.shader.filter = (btf_filter)random_below(&r, 3);
        btf_material *small, *again;
        assert_int_equal(btf_material_restrict(whole, &plan, &log_keep, &small), BTF_OK);
        assert_restricted(whole, small, &plan);
        assert_int_equal(plan_differences(&r, whole, small, &plan, SAMPLES, &lit), 0);
        all_lit += lit;
        fewer += accepted_info(small).n_views < info.n_views;
        coarser += accepted_info(small).relief_level > 0;
        btf_material *back = through_a_file(small);
        plan.level = 0; /* counts from the first level that is left */
        assert_int_equal(btf_material_restrict(small, &plan, &log_keep, &again), BTF_OK);
        assert_same_material(small, again);
        btf_material_close(&again);
        btf_material_close(&back);
        btf_material_close(&small);
        if (round % PLANS == PLANS - 1) {
            btf_material_close(&whole);
        }
    }
    print_message("%d of %d samples lit, %d with fewer views, %d of a coarser level\n", all_lit,
                  MATERIALS * PLANS * SAMPLES, fewer, coarser);
    assert_true(all_lit > MATERIALS * PLANS * SAMPLES / 4 && fewer > MATERIALS && coarser > MATERIALS);
}

/* Each step of a march, each neighbour's look-up of lights, and sources of their own are counted. */
TEST(test_cost) {
    btf_material_desc desc = factor_material_desc(WIDTH, HEIGHT, VIEWS, LIGHTS, BTF_LAYOUT_TIGHT,
                                                  BOTH | BTF_EFFECT_RESIDUAL, factor_classes);
    random_state r = {9};
    factor_material_fill(&r, &desc);
    btf_material *m = create_accepted(&desc);
    const btf_shader_options all = {.struct_size = sizeof all};
    btf_shader_options no_gloss = all, no_relief = all, neither = all, nearest = all, one = all, lit = all;
    no_gloss.leave_out = BTF_EFFECT_GLOSS;
    no_relief.leave_out = BTF_EFFECT_RELIEF;
    neither.leave_out = BOTH;
    nearest.interpolation = BTF_INTERPOLATION_NEAREST;
    one.fixed = BTF_FIXED_LIGHT; /* changes nothing beside gloss */
    memcpy(one.fixed_light, desc.lights, sizeof one.fixed_light);
    lit.filter = BTF_FILTER_STEEP;
    const float cost = btf_plan_cost(m, &all, NULL);
    assert_true(btf_plan_cost(m, &neither, NULL) < btf_plan_cost(m, &no_gloss, NULL));
    assert_true(btf_plan_cost(m, &neither, NULL) < btf_plan_cost(m, &no_relief, NULL));
    assert_true(btf_plan_cost(m, &no_gloss, NULL) < cost && btf_plan_cost(m, &no_relief, NULL) < cost);
    assert_true(btf_plan_cost(m, &nearest, NULL) < cost && cost < btf_plan_cost(m, &lit, NULL));
    assert_true(btf_plan_cost(m, &one, NULL) == cost);
    one.leave_out = BTF_EFFECT_GLOSS;
    assert_true(btf_plan_cost(m, &one, NULL) < btf_plan_cost(m, &no_gloss, NULL));
    /* A step more is one for the pixel and for each of three neighbouring views. */
    btf_material_desc steps = desc;
    steps.info.relief_steps++;
    btf_material *more = create_accepted(&steps);
    assert_true(btf_plan_cost(more, &all, NULL) > cost);
    const btf_shader_options *const ways[] = {&nearest, &all, &lit};
    for (int i = 0; i < 3; i++) {
        assert_true(btf_plan_counts(more, ways[i], NULL).steps - btf_plan_counts(m, ways[i], NULL).steps ==
                    (i ? 4 : 1));
        assert_true(btf_plan_counts(m, ways[i], NULL).moves == (i ? 4 : 2));
    }
    btf_material_close(&more);
    btf_material_close(&m);
    random_material_free(&desc);
}

/* By this table of effect errors a decode without relief and gloss is cheaper and nearer to interpolated samples. A
 * plan keeps both all the same, except at a sample. */
TEST(test_plan) {
    const uint32_t all = BOTH | BTF_EFFECT_RESIDUAL | BTF_EFFECT_SHIFT;
    const float table[] = {1, 1, 0, 90,  0,       90,     (float)all,
                           5, 0, 0, 100, 0.01f,   0.01f,  (float)(all & ~(uint32_t)BOTH),
                           5, 0, 0, 90,  0.001f,  0.001f, (float)(all & ~(uint32_t)BTF_EFFECT_GLOSS),
                           5, 0, 0, 90,  0.001f,  0.001f, (float)(all & ~(uint32_t)BTF_EFFECT_SHIFT),
                           5, 0, 0, 90,  0.0101f, 0.0101f};
    btf_material_desc desc = make_desc(10, all, 1);
    desc.effect_errors = table;
    desc.effect_error_count = sizeof table / sizeof *table;
    btf_material *m = create_accepted(&desc);
    btf_scene scene = {.struct_size = sizeof scene};
    for (int i = 0; i < 5; i++) {
        const bool sample = i == 1;
        scene.view.fixed = i > 0;
        if (sample) {
            memcpy(scene.view.direction, desc.views + 3 * 9, sizeof scene.view.direction);
        } else if (i > 1) {
            plan_angles(i == 2 ? 50 : 88, i == 3 ? 0 : 7,
                        scene.view.direction); /* 88, 0: a sample's, but beyond */
        }
        btf_plan plan;
        assert_int_equal(btf_plan_effects(m, &scene, 0.5f, &plan), BTF_OK);
        assert_true(plan.measured);
        assert_int_equal(plan.effects, BTF_EFFECT_RESIDUAL | (sample ? 0 : BOTH));
        const uint32_t textures = 1u << BTF_TEXTURE_HEIGHTS | 1u << BTF_TEXTURE_VIEW_VECTORS;
        assert_int_equal(plan.textures & textures, sample ? 0 : textures);
        btf_material *small;
        assert_int_equal(btf_material_restrict(m, &plan, &log_keep, &small), BTF_OK);
        assert_int_equal(accepted_info(small).gpu_bytes, plan.gpu_bytes);
        assert_int_equal(accepted_info(small).n_lights, plan.lights);
        btf_material_close(&small);
    }
    btf_material_close(&m);
    random_material_free(&desc);
}

RUN_TESTS(setup, teardown)
