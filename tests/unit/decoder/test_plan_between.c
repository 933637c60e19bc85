/* Plans where the table of errors between the samples has relief, gloss and levels: which effects a plan leaves out,
 * and which errors it predicts.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/scene_option.h"
#include "tests/support/random_material.h"
#include "tests/support/test.h"

#include <openbtf/plan.h>
#include <stdbool.h>
#include <string.h>

enum {
    GLOSS = BTF_EFFECT_GLOSS,
    RELIEF = BTF_EFFECT_RELIEF,
    ALL = BTF_EFFECT_RESIDUAL | RELIEF | GLOSS,
};

/* One band of views and one of lights. Rows: effects, components, directions, level, bytes, two errors. */
/* clang-format off */
static const float errors[] = {
    1, 1, 0, 90, 0, 90,
    ALL, 8, 0, 0, 0, 0.001f, 0.001f,
    ALL, 4, 0, 0, 0, 0.002f, 0.002f,
    ALL & ~GLOSS, 8, 0, 0, 0, 0.0004f, 0.0004f,
    ALL, 8, 0, 1, 0, 0.001f, 0.001f,
    ALL, 4, 0, 1, 0, 0.0019f, 0.0019f,
};

/* Rows: what is left out (7 without relief, 11 without gloss; 16 more at level 1), four means, two errors. */
static const float between[] = {
    1, 1, 0, 90, 0, 90,
    3, 0, 0, 0, 0, 0.01f, 0.01f,
    7, 0, 0, 0, 0, 0.0104f, 0.0104f,
    11, 0, 0, 0, 0, 0.0105f, 0.0105f,
    16 + 3, 0, 0, 0, 0, 0.02f, 0.02f,
    16 + 7, 0, 0, 0, 0, 0.03f, 0.03f,
    16 + 11, 0, 0, 0, 0, 0.0204f, 0.0204f,
};
/* clang-format on */

/* A material of two levels, with the first `rows` of the table of errors between the samples. */
static btf_material *make(size_t rows) {
    random_state r = {4};
    btf_material_desc desc = random_material_desc(8, 8, 19, 19, BTF_LAYOUT_TIGHT, ALL);
    btf_material *material = NULL;
    desc.info.colour = BTF_COLOUR_NONE;
    desc.info.lobes = 0;
    desc.info.components = 8;
    desc.info.levels = 2;
    desc.effect_errors = errors;
    desc.effect_error_count = sizeof errors / sizeof *errors;
    desc.between_errors = between;
    desc.between_error_count = 6 + 7 * rows;
    random_material_fill(&r, &desc);
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    random_material_free(&desc);
    return material;
}

static bool is_near(float psnr, double mse) {
    return fabs((double)psnr + 10 * log10(mse)) < 1e-3;
}

static btf_plan plan_of(const btf_material *material, float pixels, float tolerance) {
    const btf_scene scene = {.struct_size = sizeof scene, .pixels = pixels};
    btf_plan plan;
    assert_int_equal(btf_plan_effects(material, &scene, tolerance, &plan), BTF_OK);
    return plan;
}

/* A plan counts half of the errors' growth that the table gives, and adds up that of both effects: 0.02 without relief,
 * 0.025 without gloss. */
TEST(what_is_worth_less_is_left_out) {
    btf_material *material = make(6), *silent = make(1);
    const struct {
        float tolerance;
        uint32_t effects; /* 0: either one is left out */
    } cases[] = {{0, ALL},   {0.08f, ALL}, {0.09f, GLOSS | BTF_EFFECT_RESIDUAL},
                 {0.11f, 0}, {0.19f, 0},   {0.2f, BTF_EFFECT_RESIDUAL}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const btf_plan plan = plan_of(material, 1, cases[i].tolerance);
        const uint32_t lacks = ALL & ~plan.effects;
        if (cases[i].effects) {
            assert_int_equal(plan.effects, cases[i].effects);
        } else {
            assert_true(lacks == RELIEF || lacks == GLOSS);
        }
        const double growth = (lacks & RELIEF ? 0.02 : 0) + (lacks & GLOSS ? 0.025 : 0);
        assert_true(is_near(plan.between_psnr_linear, 0.01 * (1 + growth / 2)));
        assert_true(is_near(plan.full_between_psnr_linear, 0.01) && plan.components == 8);
        assert_true((lacks == 0) == !(plan.cost < plan.full_cost));
        assert_int_equal(plan_of(silent, 1, cases[i].tolerance).effects, ALL); /* not known: stay */
    }
    btf_material_close(&material);
    btf_material_close(&silent);
}

/* The worth that a plan states of an effect is the growth that its tolerance counts, at its level and for its
 * directions. */
TEST(worth_is_what_tolerances_count) {
    btf_material *material = make(6), *silent = make(1);
    const struct {
        float pixels; /* 0.5: level 1 */
        btf_effect effect;
        double growth;
    } cases[] = {{1, BTF_EFFECT_RELIEF, 0.02},
                 {1, BTF_EFFECT_GLOSS, 0.025},
                 {0.5f, BTF_EFFECT_RELIEF, 0.25},
                 {0.5f, BTF_EFFECT_GLOSS, 0.01}};
    float linear, srgb;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        btf_plan plan = plan_of(material, cases[i].pixels, 0);
        assert_int_equal(plan.level, cases[i].pixels < 1);
        assert_int_equal(btf_plan_worth(material, &plan, cases[i].effect, &linear, &srgb), BTF_OK);
        assert_true(fabs((double)linear - 10 * log10(1 + cases[i].growth)) < 1e-4 && srgb == linear);
        const float below = linear - 0.002f, above = linear + 0.002f;
        const uint32_t kept = plan_of(material, cases[i].pixels, below).effects,
                       left = plan_of(material, cases[i].pixels, above).effects;
        assert_true(kept & cases[i].effect && !(left == ALL));
        assert_int_equal(btf_plan_worth(silent, &plan, cases[i].effect, &linear, &srgb),
                         BTF_ERROR_UNSUPPORTED);
        assert_true(linear == 0 && srgb == 0);
        plan.scene.view = (btf_range){.fixed = 1};
        memcpy(plan.scene.view.direction, btf_material_views(material).xyz,
               sizeof plan.scene.view.direction);
        assert_int_equal(btf_plan_worth(material, &plan, cases[i].effect, &linear, &srgb), BTF_OK);
        assert_true(linear == 0 && srgb == 0); /* a view that is a sample */
    }
    const btf_plan plan = plan_of(material, 1, 0);
    assert_int_equal(btf_plan_worth(material, &plan, BTF_EFFECT_RESIDUAL, &linear, &srgb),
                     BTF_ERROR_UNSUPPORTED);
    btf_material_close(&material);
    btf_material_close(&silent);
}

/* The reasons that btf-info --plan and btf-view print state the same numbers. */
TEST(reasons_tell_what_plans_count) {
    btf_material *material = make(6), *silent = make(1);
    char text[80];
    const btf_plan near = plan_of(material, 1, 0), far = plan_of(material, 0.5f, 0),
                   loose = plan_of(material, 1, 0.5f), unknown = plan_of(silent, 1, 0);
    const struct {
        const btf_material *material;
        const btf_plan *plan;
        int index;
        const char *text;
    } cases[] = {{material, &near, 5, "on, worth +0.1/+0.1 dB between the samples"},
                 {material, &far, 5, "on, worth +1.0/+1.0 dB between the samples"},
                 {material, &far, 6, "on, worth +0.0/+0.0 dB between the samples"},
                 {material, &loose, 6, "off, worth +0.1/+0.1 dB between the samples"},
                 {silent, &unknown, 6, "on, acts between the samples"}};
    assert_true(RELIEF == 1 << 5 && GLOSS == 1 << 6);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_string_equal(
            scene_plan_reason(cases[i].material, cases[i].plan, cases[i].index, text, sizeof text),
            cases[i].text);
    }
    btf_material_close(&material);
    btf_material_close(&silent);
}

/* For variants that were not measured, the error against interpolated data is predicted to change without gloss as that
 * of the full decode does. */
TEST(errors_without_gloss_are_foretold) {
    btf_material *material = make(6);
    const btf_plan plan = plan_of(material, 1, 0);
    float linear, srgb;
    assert_int_equal(btf_plan_predict(material, &plan, ALL & ~GLOSS, 8, &linear, &srgb), BTF_OK);
    assert_true(is_near(linear, 0.0004) && is_near(srgb, 0.0004));
    assert_int_equal(btf_plan_predict(material, &plan, ALL & ~GLOSS, 4, &linear, &srgb), BTF_OK);
    assert_true(is_near(linear, 0.0014) && is_near(srgb, 0.0014));
    assert_int_equal(btf_plan_predict(material, &plan, ALL & ~RELIEF, 8, &linear, &srgb),
                     BTF_ERROR_UNSUPPORTED);
    assert_true(linear == 0 && srgb == 0);
    btf_material_close(&material);
}

/* At a coarser level the tolerance is relative to that level's error between the samples: 0.0009 more beside 0.01,
 * which is half of 0.02, and 0.01 of these without gloss. Where the file does not have that error, it is relative to
 * the error against the data. */
TEST(levels_have_errors_of_their_own) {
    btf_material *material = make(6), *silent = make(3);
    btf_plan plan = plan_of(material, 0.5f, 0.5f);
    assert_true(plan.level == 1 && plan.components == 4);
    assert_int_equal(plan.effects, ALL & ~GLOSS);
    assert_true(is_near(plan.full_between_psnr_linear, 0.02));
    assert_true(is_near(plan.between_psnr_srgb, 0.02 * 1.005 + 0.0009));
    plan = plan_of(material, 0.5f, 0.38f); /* 0.0009, but not 0.0001 more */
    assert_true(plan.components == 4 && plan.effects == ALL);
    plan = plan_of(silent, 0.5f, 0.5f);
    assert_true(plan.level == 1 && plan.components == 8 && plan.effects == ALL);
    assert_true(plan.full_between_psnr_linear == 0 && plan.between_psnr_linear == 0);
    btf_material_close(&material);
    btf_material_close(&silent);
}

RUN_TESTS(NULL, NULL)
