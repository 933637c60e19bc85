/* Folds: the reference's folds against a decode without, which folds are defined, what a folded shader reads, and when
 * plans fold.
 *
 * SPDX-License-Identifier: MIT
 */
#include "folds.h"
#include "tests/conformance/cases.h"
#include "tests/conformance/check.h"
#include "tests/conformance/variant.h"
#include "decoder/toolkit/reference_view.h"
#include "tests/support/test.h"

#include <openbtf/fold.h>

static btf_material *make(const synthetic_spec *spec) {
    btf_material *material = NULL;
    assert_int_equal(synthetic_create(spec, &folds_log, &material), BTF_OK);
    return material;
}

/* Counts the evaluations that differ between a decode with a fold and one without. */
static uint64_t compare(const btf_material *material, const btf_ref_options *options, int fold,
                        uint64_t seed, uint64_t *evaluated) {
    enum { COUNT = 60 };
    random_state r = {seed};
    const btf_directions views = btf_material_views(material), lights = btf_material_lights(material);
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    uint64_t different = 0;
    for (uint32_t level = 0; level < info.levels; ++level) {
        btf_ref_material m;
        float light[3], view[3];
        reference_view(material, level, &m);
        case_direction(&r, &lights, light);
        case_direction(&r, &views, view);
        float *values = folds_reference(&m, options, fold, light, view);
        const btf_ref_folded folded = {fold, values};
        for (int i = 0; i < COUNT; ++i) {
            const float u = case_coordinate(&r, m.width), v = case_coordinate(&r, m.height);
            float rgb[3], kept[3];
            if (fold == BTF_REF_FOLD_LIGHT) {
                case_direction(&r, &views, view);
            }
            btf_ref_evaluate(&m, options, u, v, light, view, rgb);
            btf_ref_evaluate_folded(&m, options, &folded, u, v, light, view, kept);
            different += memcmp(rgb, kept, sizeof rgb) != 0;
        }
        *evaluated += COUNT;
        free(values);
    }
    return different;
}

/* Counts the texels of a fold that the library makes on the CPU that differ from the reference's. */
static uint64_t compare_texels(const btf_material *material, const btf_shader_options *shader,
                               const btf_ref_options *options, uint64_t seed, uint64_t *compared) {
    enum { LIGHTS = 2 };
    random_state r = {seed};
    const btf_directions views = btf_material_views(material), lights = btf_material_lights(material);
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    float light[LIGHTS][3], view[LIGHTS][3];
    for (int i = 0; i < LIGHTS; ++i) {
        case_direction(&r, &lights, light[i]);
        case_direction(&r, &views, view[i]);
    }
    uint32_t *texels = NULL;
    assert_int_equal(btf_material_fold(material, shader, LIGHTS, light[0], view[0], &folds_log, &texels),
                     BTF_OK);
    const uint32_t *at = texels;
    uint64_t different = 0;
    for (uint32_t level = 0; level < info.levels; ++level) {
        btf_ref_material m;
        reference_view(material, level, &m);
        const size_t words = (size_t)4 * m.width * m.height * folds_layers(&m, (int)shader->fold);
        for (int i = 0; i < LIGHTS; ++i, at += words) {
            float *values = folds_reference(&m, options, (int)shader->fold, light[i], view[i]);
            assert_non_null(values);
            for (size_t w = 0; w < words; w += 4) {
                different += memcmp(at + w, values + w, 4 * sizeof *at) != 0;
            }
            *compared += words / 4;
            free(values);
        }
    }
    assert_int_equal((size_t)(at - texels) * sizeof *at, btf_fold_bytes(&info, shader->fold, LIGHTS));
    btf_free(texels);
    return different;
}

TEST(folded_reference_has_the_same_bits) {
    static variant list[VARIANT_MAX];
    uint64_t evaluated[4] = {0}, compared = 0;
    const size_t count = variant_pairwise(3, list);
    for (size_t i = 0; i < count; ++i) {
        const synthetic_spec *s = &list[i].spec;
        btf_material *material = NULL;
        if ((uint64_t)s->n_views * s->width * s->height > 40000) {
            continue;
        }
        assert_int_equal(synthetic_create(s, &folds_log, &material), BTF_OK);
        for (int fold = BTF_REF_FOLD_LIGHT; fold <= BTF_REF_FOLD_NEIGHBOURS; ++fold) {
            btf_ref_options options = variant_reference_options(&list[i].shader);
            btf_ref_material m;
            reference_view(material, 0, &m);
            options.effects &= ~check_fold_left_out((btf_fold)fold);
            if (!btf_ref_can_fold(&m, &options, fold)) {
                continue;
            }
            btf_shader_options shader = list[i].shader;
            shader.fold = (btf_fold)fold;
            shader.leave_out |= check_fold_left_out(shader.fold);
            const uint64_t different = compare(material, &options, fold, s->seed, &evaluated[fold]),
                           texels = compare_texels(material, &shader, &options, s->seed, &compared);
            if (different || texels) {
                fprintf(stderr, "%s, fold %d: %llu evaluations, %llu texels differ\n", list[i].name, fold,
                        (unsigned long long)different, (unsigned long long)texels);
            }
            assert_true(different == 0 && texels == 0);
        }
        btf_material_close(&material);
    }
    printf("%llu evaluations of folded lights, %llu of both, %llu of neighbours\n",
           (unsigned long long)evaluated[1], (unsigned long long)evaluated[2],
           (unsigned long long)evaluated[3]);
    printf("%llu texels folded by the library\n", (unsigned long long)compared);
    assert_true(compared > 100000);
    assert_true(evaluated[1] > 1000 && evaluated[2] > 5000 && evaluated[3] > 5000);
}

/* The fold of a sum of lights is the sum of the radiances without a fold, for whole texels; the library's has the bits
 * of the reference's. */
TEST(sums_of_lights_are_exact) {
    enum { LIGHTS = 5, TEXELS = 13 * 7 };
    static float one[TEXELS][4], sum[TEXELS][4];
    static uint32_t texels[TEXELS][4], total[TEXELS][4];
    const float view[3] = {0.36f, 0.48f, 0.8f};
    const btf_shader_options shader = {
        .struct_size = sizeof shader, .leave_out = BTF_EFFECT_RELIEF, .fold = BTF_FOLD_BOTH};
    const btf_ref_options options = variant_reference_options(&shader);
    random_state r = {17};
    btf_material *material = make(&folds_of_roots);
    btf_evaluator *evaluator = NULL;
    const btf_directions lights = btf_material_lights(material);
    float light[LIGHTS][3], weight[LIGHTS][3];
    btf_ref_material m;
    reference_view(material, 0, &m);
    assert_int_equal(btf_evaluator_create(material, &folds_log, &evaluator), BTF_OK);
    for (int i = 0; i < LIGHTS; ++i) {
        case_direction(&r, &lights, light[i]);
        for (int c = 0; c < 3; ++c) {
            weight[i][c] = (float)random_between(&r, 0, 3);
        }
        btf_ref_fold_both(&m, &options, light[i], view, 0, m.height, one[0]);
        btf_ref_fold_add(TEXELS, one[0], weight[i], sum[0]);
        assert_int_equal(btf_fold_rows(evaluator, &shader, light[i], view, 0, 0, 0, m.height, texels[0]),
                         BTF_OK);
        btf_fold_add(TEXELS, texels[0], weight[i], total[0]);
    }
    assert_memory_equal(sum, total, sizeof sum);
    const btf_ref_folded folded = {BTF_REF_FOLD_BOTH, sum[0]};
    for (int i = 0; i < 300; ++i) {
        const float u = case_coordinate(&r, m.width), v = case_coordinate(&r, m.height), top[3] = {0, 0, 1};
        float expected[3] = {0, 0, 0}, rgb[3];
        for (int l = 0; l < LIGHTS; ++l) {
            btf_ref_evaluate(&m, &options, u, v, light[l], view, rgb);
            for (int c = 0; c < 3; ++c) {
                const float term = rgb[c] * weight[l][c];
                expected[c] = expected[c] + term;
            }
        }
        btf_ref_evaluate_folded(&m, &options, &folded, u, v, top, view, rgb);
        assert_memory_equal(rgb, expected, sizeof rgb);
    }
    btf_evaluator_destroy(&evaluator);
    btf_material_close(&material);
}

/* Library and reference agree on which folds are defined, and the library says why one is not. */
TEST(undefined_folds_are_refused) {
    static const struct {
        btf_colour colour;
        uint32_t effects;
        btf_fold fold;
        const char *reason; /* NULL: it is defined */
    } cases[] = {
        {BTF_COLOUR_NONE, BTF_EFFECT_RESIDUAL, BTF_FOLD_LIGHT, NULL},
        {BTF_COLOUR_NONE, BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF, BTF_FOLD_LIGHT, NULL},
        {BTF_COLOUR_NONE, BTF_EFFECT_RESIDUAL | BTF_EFFECT_GLOSS, BTF_FOLD_LIGHT, "gloss"},
        {BTF_COLOUR_RGB, BTF_EFFECT_RESIDUAL, BTF_FOLD_LIGHT, "SBRDF"},
        {BTF_COLOUR_RGB, BTF_EFFECT_RESIDUAL | BTF_EFFECT_GLOSS, BTF_FOLD_BOTH, NULL},
        {BTF_COLOUR_NONE, BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF, BTF_FOLD_BOTH, "relief"},
        {BTF_COLOUR_RGB, BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS, BTF_FOLD_NEIGHBOURS,
         NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const synthetic_spec spec = {.seed = i,
                                     .width = 4,
                                     .height = 3,
                                     .n_views = 7,
                                     .n_lights = 5,
                                     .layout = BTF_LAYOUT_TIGHT,
                                     .domain = BTF_DOMAIN_SQRT,
                                     .colour = cases[i].colour,
                                     .lobes = cases[i].colour == BTF_COLOUR_NONE ? 0 : 1,
                                     .effects = cases[i].effects,
                                     .components = 2,
                                     .relief = SYNTHETIC_GENTLE,
                                     .gloss_share = 1};
        const btf_shader_options shader = {.struct_size = sizeof shader, .fold = cases[i].fold};
        const btf_ref_options options = variant_reference_options(&shader);
        const btf_result expected = cases[i].reason ? BTF_ERROR_UNSUPPORTED : BTF_OK;
        btf_material *material = NULL;
        btf_ref_material m;
        char *text = NULL;
        assert_int_equal(synthetic_create(&spec, &folds_log, &material), BTF_OK);
        reference_view(material, 0, &m);
        folds_said[0] = 0;
        assert_int_equal(btf_shader_source(material, &shader, &folds_log, &text), expected);
        assert_int_equal(btf_ref_can_fold(&m, &options, (int)cases[i].fold), expected == BTF_OK);
        if (cases[i].reason && !strstr(folds_said, cases[i].reason)) {
            fail_msg("\"%s\" does not say %s", folds_said, cases[i].reason);
        }
        btf_free(text);
        btf_material_close(&material);
    }
}

/* A folded shader reads the textures that find a texel and its fold, and none that the fold has used up; the fold has
 * the size that is stated; and the decode costs less. */
TEST(a_folded_shader_reads_less) {
    btf_material *material = make(&folds_of_roots);
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    btf_shader_options shader = {
        .struct_size = sizeof shader, .leave_out = BTF_EFFECT_GLOSS, .fold = BTF_FOLD_LIGHT};
    assert_int_equal(btf_shader_textures(&info, &shader), 1u << BTF_TEXTURE_VIEW_TABLE |
                                                              1u << BTF_TEXTURE_HEIGHTS |
                                                              1u << BTF_TEXTURE_VIEW_VECTORS);
    assert_int_equal(btf_fold_layers(&info, BTF_FOLD_LIGHT, 2), 18);
    assert_int_equal(btf_fold_bytes(&info, BTF_FOLD_LIGHT, 2), 18 * 16 * (13 * 7 + 6 * 3 + 3 * 1));
    const btf_fold_costs light = btf_fold_cost(material, &shader, NULL);
    assert_true(light.folded < light.unfolded && light.pass > 0);
    assert_true(light.pixels > 0 && light.pixels < 2 * 13 * 7 * 9);
    shader.leave_out |= BTF_EFFECT_RELIEF;
    shader.fold = BTF_FOLD_BOTH;
    assert_int_equal(btf_shader_textures(&info, &shader), 0);
    assert_int_equal(btf_fold_layers(&info, BTF_FOLD_BOTH, 2), 2);
    const btf_fold_costs both = btf_fold_cost(material, &shader, NULL);
    assert_true(both.folded < light.folded && both.pixels < light.pixels);
    shader.leave_out = 0;
    shader.fold = BTF_FOLD_NEIGHBOURS;
    assert_int_equal(btf_shader_textures(&info, &shader), 1u << BTF_TEXTURE_VIEW_TABLE |
                                                              1u << BTF_TEXTURE_HEIGHTS |
                                                              1u << BTF_TEXTURE_VIEW_VECTORS);
    shader.fixed = BTF_FIXED_VIEW;
    shader.fixed_view[2] = 1;
    assert_int_equal(btf_shader_textures(&info, &shader),
                     1u << BTF_TEXTURE_HEIGHTS | 1u << BTF_TEXTURE_VIEW_VECTORS);
    assert_int_equal(btf_fold_layers(&info, BTF_FOLD_NEIGHBOURS, 2), 6);
    const btf_fold_costs neighbours = btf_fold_cost(material, &shader, NULL);
    assert_true(neighbours.folded < neighbours.unfolded && neighbours.pixels < light.pixels);
    btf_material_close(&material);
}

/* A plan says which fold its scene allows, and its restriction drops what the fold makes superfluous. */
TEST(plans_fold) {
    const btf_range still = {.fixed = 1, .direction = {0.6f, 0, 0.8f}}, top = {.theta = {0, 20}};
    synthetic_spec spec = folds_of_roots;
    btf_plan plan;
    btf_scene scene = {.struct_size = sizeof scene, .light = still};
    btf_material *glossy = make(&spec);
    spec.effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF;
    btf_material *raised = make(&spec);
    spec.effects = BTF_EFFECT_RESIDUAL;
    spec.n_views = 81;
    spec.directions = SYNTHETIC_RINGS;
    btf_material *flat = make(&spec);
    assert_int_equal(btf_plan_effects(glossy, &scene, 0, &plan), BTF_OK);
    assert_int_equal(plan.fold, BTF_FOLD_NONE);
    assert_true(plan.fold_bytes == 0 && plan.folded_cost == plan.cost);
    assert_int_equal(btf_plan_effects(raised, &scene, 0, &plan), BTF_OK);
    assert_int_equal(plan.fold, BTF_FOLD_LIGHT);
    assert_int_equal(plan.fold_bytes, 9 * 16 * (13 * 7 + 6 * 3 + 3 * 1));
    assert_true(plan.folded_cost < plan.cost && plan.fold_pixels > 0);
    assert_true(fabsf(plan.price - plan.folded_cost / plan.full_cost -
                      (float)plan.gpu_bytes / (float)plan.full_gpu_bytes) < 1e-6f);
    const float with_relief = plan.folded_cost;
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK);
    assert_int_equal(plan.fold, BTF_FOLD_LIGHT);
    assert_true(plan.folded_cost < with_relief && plan.views == 81);
    const double pixels = plan.fold_pixels;
    const size_t bytes = plan.fold_bytes;
    /* a fold is forbidden, is for too few samples, has too many bytes; then has just enough of either */
    for (int i = 0; i < 5; ++i) {
        btf_scene limited = scene;
        limited.no_fold = i == 0;
        limited.folded_pixels = i == 1 ? pixels * 0.99 : i == 3 ? pixels * 1.01 : 0;
        limited.folded_bytes = i == 2 ? bytes - 1 : i == 4 ? bytes : 0;
        assert_int_equal(btf_plan_effects(flat, &limited, 0, &plan), BTF_OK);
        assert_int_equal(plan.fold, i < 3 ? BTF_FOLD_NONE : BTF_FOLD_LIGHT);
        assert_true(i < 3 ? plan.folded_cost == plan.cost && plan.fold_bytes == 0 && plan.fold_pixels == 0
                          : plan.folded_cost < plan.cost && plan.fold_bytes == bytes);
    }
    scene.view = top; /* with fewer views a fold pays for fewer samples */
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK);
    assert_true(plan.views < 40 && plan.fold_bytes == (size_t)plan.views * 16 * (13 * 7 + 6 * 3 + 3 * 1));
    assert_true(fabs(plan.fold_pixels - pixels * plan.views / 81) < 0.01 * pixels);
    const float light_alone = plan.folded_cost;
    scene.lights = 3; /* the shader reads a fold of each light */
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK);
    assert_true(plan.fold == BTF_FOLD_LIGHT && fabsf(plan.folded_cost - 3 * light_alone) < 0.01f);
    scene.lights = 0;
    scene.view = still;
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK);
    assert_int_equal(plan.fold, BTF_FOLD_BOTH);
    assert_true(plan.folded_cost < light_alone && plan.fold_bytes == 16 * (13 * 7 + 6 * 3 + 3 * 1));
    const float both = plan.folded_cost;
    scene.lights = 3; /* the shader reads one fold of their sum */
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK);
    assert_true(plan.fold == BTF_FOLD_BOTH && plan.folded_cost == both);
    const btf_scene one = scene;
    scene.light = (btf_range){.theta = {0, 60}};
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK); /* lights that move */
    assert_int_equal(plan.fold, BTF_FOLD_NONE);
    scene.still_lights = 1;
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK);
    assert_true(plan.fold == BTF_FOLD_BOTH && plan.folded_cost == both);
    assert_int_equal(btf_plan_effects(raised, &scene, 0, &plan), BTF_OK); /* neighbours have no sums */
    assert_int_equal(plan.fold, BTF_FOLD_NONE);
    scene.view =
        top; /* a sum under a view that moves: of all lights in one, products of views with their neighbours */
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK);
    assert_int_equal(plan.fold, BTF_FOLD_SUM);
    assert_int_equal(plan.fold_bytes, (size_t)plan.views * 4 * 16 * (13 * 7 + 6 * 3 + 3 * 1));
    assert_true(plan.folded_cost > light_alone && plan.folded_cost < 3 * light_alone &&
                plan.fold_pixels > 0);
    const float sum = plan.folded_cost;
    const double sum_pixels = plan.fold_pixels;
    scene.lights = 300; /* cost a pixel no more, and are folded one by one */
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK);
    assert_true(plan.fold == BTF_FOLD_SUM && plan.folded_cost == sum && plan.cost > 50 * sum);
    assert_true(fabs(plan.fold_pixels / sum_pixels - 1) < 0.3);
    scene.folded_pixels = plan.fold_pixels / 2; /* does not pay */
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK);
    assert_int_equal(plan.fold, BTF_FOLD_NONE);
    scene.folded_pixels = 0;
    assert_int_equal(btf_plan_effects(raised, &scene, 0, &plan), BTF_OK); /* views show other texels */
    assert_int_equal(plan.fold, BTF_FOLD_NONE);
    scene = one;
    scene.lights = 0;
    for (int i = 0; i < 2; ++i) { /* with relief, and gloss too, neighbouring views */
        assert_int_equal(btf_plan_effects(i ? glossy : raised, &scene, 0, &plan), BTF_OK);
        assert_int_equal(plan.fold, BTF_FOLD_NEIGHBOURS);
        assert_true(plan.fold_bytes == 3 * 16 * (13 * 7 + 6 * 3 + 3 * 1) && plan.folded_cost < plan.cost);
    }
    scene.light = (btf_range){0};
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK); /* a still view alone is no fold */
    assert_int_equal(plan.fold, BTF_FOLD_NONE);
    btf_material_close(&glossy);
    btf_material_close(&raised);
    btf_material_close(&flat);
}

/* A still light is folded without gloss where, by the table of errors between the samples, gloss is worth less than the
 * tolerance: 0.11 dB here, half of the growth of the error where samples are left out. */
TEST(plans_weigh_gloss) {
    enum { EFFECTS = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS };
    static const float errors[] = {1, 1, 0, 90, 0, 90, EFFECTS, 2, 0, 0, 0, 0.001f, 0.001f};
    static const float between[] = {1,  1,    0,    90,   0,    90,                /* one band */
                                    3,  0.1f, 0.1f, 0.1f, 0.1f, 0.01f,   0.01f,    /* both left out */
                                    11, 0.1f, 0.1f, 0.1f, 0.1f, 0.0105f, 0.0105f}; /* without gloss */
    const btf_range still = {.fixed = 1, .direction = {0.6f, 0, 0.8f}};
    synthetic_spec spec = folds_of_roots;
    spec.effect_errors = errors;
    spec.effect_error_count = sizeof errors / sizeof *errors;
    btf_material *silent = make(&spec);
    spec.between_errors = between;
    spec.between_error_count = sizeof between / sizeof *between;
    btf_material *material = make(&spec);
    btf_scene scene = {.struct_size = sizeof scene, .light = still};
    btf_plan plan;
    assert_int_equal(btf_plan_effects(material, &scene, 0.5f, &plan), BTF_OK);
    assert_int_equal(plan.effects, EFFECTS & ~BTF_EFFECT_GLOSS);
    assert_int_equal(plan.shader.leave_out, BTF_EFFECT_GLOSS);
    assert_int_equal(plan.fold, BTF_FOLD_LIGHT);
    assert_true(plan.folded_cost < plan.cost && plan.cost < plan.full_cost);
    assert_true(fabs(plan.between_psnr_linear + 10 * log10(0.010125)) < 1e-3);
    assert_true(fabs(plan.full_between_psnr_linear - 20) < 1e-3);
    for (int i = 0; i < 3; ++i) { /* without a fold gloss is left out, too, which saves look-ups */
        btf_scene unfolded = scene;
        unfolded.no_fold = i == 0;
        unfolded.folded_pixels = i == 1 ? 1 : 0;
        unfolded.folded_bytes = i == 2 ? 1 : 0;
        assert_int_equal(btf_plan_effects(material, &unfolded, 0.5f, &plan), BTF_OK);
        assert_true(plan.effects == (EFFECTS & ~BTF_EFFECT_GLOSS) && plan.fold == BTF_FOLD_NONE);
        assert_true(plan.folded_cost == plan.cost && plan.cost < plan.full_cost);
    }
    assert_int_equal(btf_plan_effects(material, &scene, 0.11f, &plan), BTF_OK);
    assert_true(plan.fold == BTF_FOLD_LIGHT);
    static const float tighter[] = {0.1f, 0};
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(btf_plan_effects(material, &scene, tighter[i], &plan), BTF_OK);
        assert_true(plan.effects == EFFECTS && plan.fold == BTF_FOLD_NONE && plan.folded_cost == plan.cost);
    }
    /* without the table its worth is unknown */
    assert_int_equal(btf_plan_effects(silent, &scene, 0.5f, &plan), BTF_OK);
    assert_int_equal(plan.effects, EFFECTS);
    scene.view = still; /* with a still view the light is folded with gloss */
    assert_int_equal(btf_plan_effects(material, &scene, 0, &plan), BTF_OK);
    assert_true(plan.effects == EFFECTS && plan.fold == BTF_FOLD_NEIGHBOURS);
    scene = (btf_scene){.struct_size = sizeof scene, .view = still}; /* moving lights are not folded */
    assert_int_equal(btf_plan_effects(material, &scene, 0.5f, &plan), BTF_OK);
    assert_true(plan.fold == BTF_FOLD_NONE);
    btf_material_close(&material);
    btf_material_close(&silent);
}

RUN_TESTS(NULL, NULL)
