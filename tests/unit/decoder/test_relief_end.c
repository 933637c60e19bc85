/* Relief that ends before the last level of detail: what is refused, saving and opening, how levels decode, and how
 * restrictions, plans and shaders treat it.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/reference_view.h"
#include "tests/support/exr_edit.h"
#include "tests/support/plan_decode.h"
#include "tests/support/refusals.h"
#include "tests/support/test.h"
#include <openbtf/plan.h>

enum { WIDTH = 12, HEIGHT = 9, VIEWS = 19, LIGHTS = 7, LEVELS = 3 };
enum { RELIEF = BTF_EFFECT_RELIEF, BOTH = BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS };

static btf_material_desc make_desc(uint32_t effects, uint32_t end) {
    random_state r = {1};
    btf_material_desc desc = random_material_desc(WIDTH, HEIGHT, VIEWS, LIGHTS, BTF_LAYOUT_TIGHT, effects);
    desc.info.levels = LEVELS;
    desc.info.domain = BTF_DOMAIN_SQRT;
    desc.info.blend = BTF_BLEND_ROOTS;
    desc.info.relief_end = end;
    random_material_fill(&r, &desc);
    return desc;
}

static btf_material *make(uint32_t effects, uint32_t end) {
    btf_material_desc desc = make_desc(effects, end);
    btf_material *m = create_accepted(&desc);
    random_material_free(&desc);
    return m;
}

TEST(test_create) {
    static const struct {
        uint32_t effects, end, becomes;
        const char *text; /* NULL: accepted */
    } cases[] = {
        {RELIEF, 0, LEVELS, NULL},
        {RELIEF, 1, 1, NULL},
        {BOTH, LEVELS, LEVELS, NULL},
        {RELIEF, LEVELS + 1, 0, "reliefEnd 4 is not within 1 to 3 (levels)"},
        {RELIEF, UINT32_MAX, 0, "reliefEnd 4294967295 is not within 1 to 3 (levels)"},
        {BTF_EFFECT_GLOSS, 0, 0, NULL},
        {BTF_EFFECT_GLOSS, 1, 0, "reliefEnd 1 without the effect relief"},
        {0, 3, 0, "reliefEnd 3 without the effect relief"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        btf_material_desc desc = make_desc(cases[i].effects, cases[i].end);
        if (cases[i].text) {
            create_refused(&desc, cases[i].text);
        } else {
            btf_material *m = create_accepted(&desc);
            assert_int_equal(accepted_info(m).relief_end, cases[i].becomes);
            btf_material_close(&m);
        }
        random_material_free(&desc);
    }
}

static void *save(const btf_material *m, size_t *size) {
    void *data;
    assert_int_equal(btf_material_save_memory(m, &log_keep, &data, size), BTF_OK);
    return data;
}

/* The attribute is not written where all levels have relief, so that such files are the same as before it existed. */
TEST(test_file) {
    for (uint32_t end = 1; end <= LEVELS; end++) {
        btf_material *m = make(BOTH, end), *opened;
        size_t size;
        void *data = save(m, &size);
        edit_file *e = edit_load(data, size);
        int32_t written = 0;
        for (int i = 0; i < e->attribute_count; i++) {
            if (strcmp(e->attributes[i].name, "openbtf.reliefEnd") == 0) {
                written = e->attributes[i].i;
            }
        }
        assert_int_equal(written, end < LEVELS ? end : 0);
        edit_free(e);
        assert_int_equal(btf_material_open_memory(data, size, &log_keep, &opened), BTF_OK);
        assert_int_equal(accepted_info(opened).relief_end, end);
        for (uint32_t level = 0; level < LEVELS; level++) { /* all have heights: mip chains are whole */
            assert_int_equal(btf_material_level_texture(opened, level, BTF_TEXTURE_HEIGHTS).size,
                             (WIDTH >> level) * (HEIGHT >> level));
        }
        btf_free(data);
        btf_material_close(&opened);
        btf_material_close(&m);
    }
}

TEST(test_file_refuses) {
    static const struct {
        int32_t end;
        const char *text;
    } cases[] = {{0, "attribute openbtf.reliefEnd is 0, not within 1 to 3"},
                 {-1, "attribute openbtf.reliefEnd is -1, not within 1 to 3"},
                 {4, "attribute openbtf.reliefEnd is 4, not within 1 to 3"}};
    btf_material *m = make(BOTH, 2);
    size_t size;
    void *data = save(m, &size);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        EDIT_REFUSED(edit_load(data, size), edit_find_attribute(e, "openbtf.reliefEnd")->i = cases[i].end,
                     cases[i].text);
    }
    EDIT_REFUSED(edit_load(data, size), edit_find_attribute(e, "openbtf.reliefEnd")->type = EXR_ATTR_DOUBLE,
                 "attribute openbtf.reliefEnd is of type double");
    /* the end is one of the levels that there are */
    EDIT_REFUSED(edit_load(data, size), edit_find_attribute(e, "openbtf.levels")->i = 1,
                 "attribute openbtf.reliefEnd is 2, not within 1 to 1");
    btf_free(data);
    btf_material_close(&m);
    m = make(BTF_EFFECT_GLOSS, 0);
    data = save(m, &size);
    edit_file *e = edit_load(data, size);
    e->attributes[e->attribute_count++] =
        (edit_attribute){.name = "openbtf.reliefEnd", .type = EXR_ATTR_INT, .i = 1};
    file_refused(e, "attribute openbtf.reliefEnd without the effect relief");
    btf_free(data);
    btf_material_close(&m);
}

/* Counts the radiances that differ between a level of `a` and that of `b`, decoded by effects_of_b, in 60 places. */
static int differences(const btf_material *a, const btf_material *b, uint32_t level,
                       uint32_t effects_of_b) {
    enum { SAMPLES = 60 };
    random_state r = {2};
    btf_ref_material one, other;
    int differ = 0, lit = 0;
    reference_view(a, level, &one);
    reference_view(b, level, &other);
    for (int i = 0; i < 6 * SAMPLES; i++) {
        const btf_ref_options of_a = {.effects = BTF_EFFECT_ALL,
                                      .components = UINT32_MAX,
                                      .interpolation = i & 1 ? BTF_REF_LINEAR : BTF_REF_NEAREST,
                                      .filter = i / 2 % 3};
        btf_ref_options of_b = of_a;
        float uv[2] = {(float)random_unit(&r), (float)random_unit(&r)}, l[3], v[3], p[3], q[3];
        of_b.effects = effects_of_b;
        plan_angles(80 * random_unit(&r), 360 * random_unit(&r), l);
        plan_angles(80 * random_unit(&r), 360 * random_unit(&r), v);
        btf_ref_evaluate(&one, &of_a, uv[0], uv[1], l, v, p);
        btf_ref_evaluate(&other, &of_b, uv[0], uv[1], l, v, q);
        differ += memcmp(p, q, sizeof p) != 0;
        lit += p[0] > 0 && p[0] < 0x1p30f;
    }
    assert_true(lit > SAMPLES);
    return differ;
}

/* From the end on levels decode as without relief, and before it as in a file without an end, bit for bit. */
TEST(test_levels_decode) {
    const uint32_t effects = BOTH | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN;
    btf_material *whole = make(effects, 0);
    for (uint32_t end = 1; end < LEVELS; end++) {
        btf_material *m = make(effects, end);
        for (uint32_t level = 0; level < LEVELS; level++) {
            const int off = differences(m, whole, level, BTF_EFFECT_ALL & ~(uint32_t)RELIEF),
                      on = differences(m, whole, level, BTF_EFFECT_ALL);
            assert_true(level < end ? on == 0 && off > 100 : off == 0 && on > 100);
        }
        btf_material_close(&m);
    }
    btf_material_close(&whole);
}

static btf_plan plan_of_level(const btf_material *m, uint32_t level) {
    const btf_scene scene = {.struct_size = sizeof scene,
                             .pixels = level == 0   ? 1
                                       : level == 1 ? 0.5f
                                                    : 0.25f};
    btf_plan plan;
    assert_int_equal(btf_plan_effects(m, &scene, 0.5f, &plan), BTF_OK);
    assert_int_equal(plan.level, level);
    return plan;
}

/* When a restriction drops the first levels, the end counts from the first one that is left; where none with relief is
 * left, relief is dropped. */
TEST(test_restrict) {
    random_state r = {3};
    int all_lit = 0;
    for (uint32_t end = 1; end <= LEVELS; end++) {
        for (uint32_t level = 0; level < LEVELS; level++) {
            for (int gloss = 0; gloss < 2; gloss++) {
                btf_material *whole = make(gloss ? BOTH : RELIEF, end), *small;
                btf_plan plan = plan_of_level(whole, level);
                int lit;
                plan.effects |= RELIEF; /* also in a plan that a caller changed by hand */
                plan.shader.leave_out = 0;
                plan.shader.filter = (btf_filter)(end % 3);
                assert_int_equal(btf_material_restrict(whole, &plan, &log_keep, &small), BTF_OK);
                const btf_material_info info = accepted_info(small);
                const bool relief = level < end;
                assert_int_equal(info.levels, LEVELS - level);
                assert_int_equal(info.effects, (relief ? RELIEF : 0) | (gloss ? BTF_EFFECT_GLOSS : 0));
                assert_int_equal(info.relief_end, relief ? end - level : 0);
                assert_int_equal(info.relief_level, relief ? level : 0);
                assert_int_equal(info.relief_steps, relief ? 7 : 0);
                assert_int_equal(accepted_texture(small, BTF_TEXTURE_HEIGHTS), relief);
                assert_int_equal(accepted_texture(small, BTF_TEXTURE_VIEW_VECTORS), relief || gloss);
                assert_int_equal(plan_differences(&r, whole, small, &plan, 60, &lit), 0);
                all_lit += lit;
                btf_material_close(&small);
                btf_material_close(&whole);
            }
        }
    }
    assert_true(all_lit > 18 * 60 / 4);
}

/* A plan drops relief where the scene's level has none, though its row of the table is of the file's
 * effects, and keeps it elsewhere. */
TEST(test_plan) {
    const float all = BOTH;
    const float table[] = {1, 1, 0, 90, 0,     90,    all, 0, 0, 0, 100, 0.01f, 0.01f, all,
                           0, 0, 1, 30, 0.02f, 0.02f, all, 0, 0, 2, 10,  0.04f, 0.04f};
    btf_material_desc desc = make_desc(BOTH, 1);
    desc.effect_errors = table;
    desc.effect_error_count = sizeof table / sizeof *table;
    btf_material *m = create_accepted(&desc);
    for (uint32_t level = 0; level < LEVELS; level++) {
        const btf_plan plan = plan_of_level(m, level);
        const bool relief = level == 0;
        float linear, srgb;
        assert_true(plan.measured);
        assert_int_equal(plan.effects, BTF_EFFECT_GLOSS | (relief ? RELIEF : 0));
        assert_int_equal(plan.shader.leave_out, relief ? 0 : RELIEF);
        assert_int_equal(plan.textures >> BTF_TEXTURE_HEIGHTS & 1, relief);
        assert_true((plan.cost < plan.full_cost) == !relief);
        /* The plan has the errors that the table gives for the level, with relief's bit or without. */
        assert_int_equal(btf_plan_predict(m, &plan, plan.effects, 0, &linear, &srgb), BTF_OK);
        assert_true(linear == plan.psnr_linear && srgb == plan.psnr_srgb);
        btf_material *small;
        assert_int_equal(btf_material_restrict(m, &plan, &log_keep, &small), BTF_OK);
        assert_int_equal(accepted_info(small).gpu_bytes, plan.gpu_bytes);
        btf_material_close(&small);
    }
    btf_material_close(&m);
    random_material_free(&desc);
}

/* A material whose levels all have relief gives a shader without a trace of the end. */
TEST(test_shader) {
    const btf_shader_options options = {.struct_size = sizeof options};
    for (uint32_t end = 1; end <= LEVELS; end++) {
        btf_material *m = make(RELIEF, end);
        char *text;
        assert_int_equal(btf_shader_source(m, &options, &log_keep, &text), BTF_OK);
        const char *found = strstr(text, "#define BTF_RELIEF_END");
        assert_int_equal(found != NULL, end < LEVELS);
        if (found) {
            assert_int_equal(
                strncmp(found, end == 1 ? "#define BTF_RELIEF_END (1)\n" : "#define BTF_RELIEF_END (2)\n",
                        27),
                0);
        }
        btf_free(text);
        btf_material_close(&m);
    }
}

RUN_TESTS(NULL, NULL)
