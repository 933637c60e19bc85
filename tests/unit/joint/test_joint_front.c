/* SBRDF times shadow in front of a residual, and the choice among candidates: known truth is found, rounds
 * never raise the error, codes decode to what was measured, and no single choice is better.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/joint/joint.h"
#include "encoder/joint/cost.h"
#include "encoder/joint/choose.h"
#include "encoder/joint/fit.h"
#include "encoder/joint/front_fit.h"
#include "encoder/joint/measure.h"
#include "encoder/paper/paper.h"
#include "encoder/report/metrics.h"
#include "encoder/model/pack.h"
#include "encoder/model/decode_samples.h"
#include "encoder/model/unpack.h"
#include "tests/sample/sample.h"

#include <math.h>
#include <openbtf/material.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

static const enc_context one_thread = {.threads = 1};
static const enc_context two_threads = {.threads = 2};

static const uint32_t all_maps = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN;

static enc_data *sample(relief_kind relief, int size) {
    enc_direction views[7], lights[13];
    enc_data *data = NULL;
    for (int i = 0; i < 7; i++)
        views[i] = enc_direction_from_angles(i ? 50.0 : 0.0, i ? 60.0 * (i - 1) : 0.0);
    for (int i = 0; i < 13; i++)
        lights[i] = enc_direction_from_angles(i ? 60.0 : 0.0, i ? 30.0 * (i - 1) : 0.0);
    const sample_options options = {.context = &two_threads,
                                    .relief = relief,
                                    .width = size,
                                    .height = size,
                                    .views = views,
                                    .n_views = 7,
                                    .lights = lights,
                                    .n_lights = 13};
    assert_int_equal(sample_render(&options, &data, NULL), BTF_OK);
    return data;
}

static enc_joint_options fast(uint32_t effects, bool choose) {
    enc_joint_options options = enc_joint_options_default();
    options.preset = ENC_JOINT_FAST;
    options.effects = effects;
    options.choose = choose;
    return options;
}

/* A round never raises the error, whatever the front; refits come in some of them. */
static void test_monotone(void **unused) {
    static const joint_front_kind kinds[] = {{.lobes = 1, .half = true},
                                             {.lobes = 2, .shadow = true},
                                             {.lobes = 1, .rgb = true, .shadow = true, .half = true}};
    enc_data *data = sample(RELIEF_BRICKS, 10);
    (void)unused;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k <= 4; k += 4) {
            joint_rows rows;
            joint_fit plain = {0}, fit = {0};
            assert_int_equal(joint_rows_init(&two_threads, data, true, &rows), BTF_OK);
            if (k > 0) {
                assert_int_equal(joint_fit_plain(&rows, (size_t)k, 3, &plain, NULL), BTF_OK);
                assert_int_equal(joint_fit_start(&plain, (size_t)k, all_maps | BTF_EFFECT_RESIDUAL, &fit),
                                 BTF_OK);
                assert_int_equal(joint_fit_add_front(&fit, &kinds[i], 1, 1), BTF_OK);
            } else {
                assert_int_equal(joint_fit_front_alone(&rows, all_maps, &kinds[i], 1, &fit), BTF_OK);
            }
            double before = fit.error;
            const double first = before;
            for (int round = 0; round < 6; round++) {
                assert_int_equal(joint_fit_round(&fit), BTF_OK);
                assert_true(fit.error <= before * (1.0 + 1e-6));
                before = fit.error;
            }
            assert_true(before < 0.9 * first);
            joint_fit_clear(&plain);
            joint_fit_clear(&fit);
            joint_rows_clear(&rows);
        }
    enc_data_destroy(&data);
}

/* A refit alone never raises the error either, from parameters that are far off. */
static void test_refit(void **unused) {
    const joint_front_kind kind = {.lobes = 2, .shadow = true, .half = true};
    enc_data *data = sample(RELIEF_BUMPS, 8);
    joint_rows rows;
    joint_fit fit = {0};
    double before, after;
    (void)unused;
    assert_int_equal(joint_rows_init(&two_threads, data, true, &rows), BTF_OK);
    assert_int_equal(joint_fit_front_alone(&rows, 0, &kind, 1, &fit), BTF_OK);
    for (size_t t = 0; t < rows.texels; t++)
        fit.model.front->sbrdf->values[t * enc_sbrdf_stride(2, false) + 3] *= t % 2 ? 3.0f : 0.25f;
    joint_fit_release(&fit);
    assert_int_equal(joint_projection_init(&rows, &fit.model, &fit.projection), BTF_OK);
    assert_int_equal(joint_project(&rows, &fit.model, &fit.projection), BTF_OK);
    assert_int_equal(joint_choose(&rows, &fit.projection, false, 0.0, &fit.model, &before), BTF_OK);
    assert_true(before > 1.5 * fit.error);
    assert_int_equal(joint_front_refit(&rows, &fit.model), BTF_OK);
    assert_int_equal(joint_project(&rows, &fit.model, &fit.projection), BTF_OK);
    assert_int_equal(joint_choose(&rows, &fit.projection, false, 0.0, &fit.model, &after), BTF_OK);
    assert_true(after < 1.1 * fit.error);
    joint_fit_clear(&fit);
    joint_rows_clear(&rows);
    enc_data_destroy(&data);
}

/* sRGB-coded PSNR of what the packed material decodes to, by the reference. */
static double decoded_psnr(const enc_data *data, const enc_solution *solution, double *out_linear) {
    const enc_pack_options options = {.layout = BTF_LAYOUT_TIGHT, .method = "joint"};
    btf_material *material = NULL;
    enc_solution stored;
    enc_sample_decoder *decoder = NULL;
    enc_metrics metrics;
    assert_int_equal(enc_pack(&two_threads, data, solution, &options, &material), BTF_OK);
    assert_int_equal(enc_unpack(&two_threads, material, &stored), BTF_OK);
    assert_int_equal(enc_sample_decoder_create(&two_threads, data, &stored, &decoder), BTF_OK);
    const enc_decoded_samples decoded = {.decoder = decoder, .effects = stored.effects};
    assert_int_equal(enc_metrics_compare(&two_threads, data, enc_data_images(data),
                                         enc_decoded_images(&decoded), false, &metrics),
                     BTF_OK);
    enc_sample_decoder_destroy(&decoder);
    enc_solution_clear(&stored);
    btf_material_close(&material);
    *out_linear = enc_psnr_linear(&metrics.total);
    return enc_psnr_srgb(&metrics.total);
}

/* Everything in one file: what the stats say is what the reference decodes; halves are lossless. */
static void test_round_trip(void **unused) {
    const uint32_t effects = all_maps | BTF_EFFECT_SHADOW | BTF_EFFECT_RESIDUAL;
    enc_data *data = sample(RELIEF_BRICKS, 12);
    enc_joint_options options = fast(effects, false);
    enc_joint_stats stats;
    enc_solution solution;
    double linear;
    (void)unused;
    assert_int_equal(enc_joint(&two_threads, data, &options, &solution, &stats), BTF_OK);
    assert_int_equal(solution.effects, effects);
    assert_non_null(solution.sbrdf);
    assert_true(solution.half_parameters);
    assert_true(solution.n_components >= 4);
    assert_true(fabs(decoded_psnr(data, &solution, &linear) - stats.psnr_srgb) < 0.01);
    assert_true(fabs(linear - stats.psnr_linear) < 0.01);
    enc_solution_clear(&solution);
    enc_data_destroy(&data);
}

/* With the first components alone a file decodes to what they explain: the more, the better, and four come
 * within 1.5 dB of a file of four (helpers among the first four would cost 2). */
static void test_truncation(void **unused) {
    enc_data *data = sample(RELIEF_BRICKS, 12);
    enc_joint_options options = fast(BTF_EFFECT_RESIDUAL, false);
    enc_solution solution, four;
    double before = 0.0, four_linear, psnr[33];
    (void)unused;
    options.components = 32;
    assert_int_equal(enc_joint(&two_threads, data, &options, &solution, NULL), BTF_OK);
    assert_int_equal(solution.n_components, 32);
    for (uint32_t k = 1; k <= 32; k++) {
        enc_solution part = solution;
        double linear;
        part.n_components = k;
        part.residual_texels = malloc(144 * k);
        part.residual_directions = malloc((size_t)7 * 13 * 3 * k);
        for (size_t j = 0; j < 144 * k; j++)
            part.residual_texels[j] = solution.residual_texels[j / k * 32 + j % k];
        for (size_t j = 0; j < (size_t)7 * 13 * 3 * k; j++)
            part.residual_directions[j] = solution.residual_directions[j / k * 32 + j % k];
        psnr[k] = decoded_psnr(data, &part, &linear);
        assert_true(linear >= before - 0.05);
        before = linear;
        free(part.residual_texels);
        free(part.residual_directions);
    }
    options.components = 4;
    assert_int_equal(enc_joint(&two_threads, data, &options, &four, NULL), BTF_OK);
    const double best = decoded_psnr(data, &four, &four_linear);
    printf("components 4, 8, 16, 32: %.2f, %.2f, %.2f, %.2f dB; a file of 4 %.2f dB\n", psnr[4], psnr[8],
           psnr[16], psnr[32], best);
    assert_true(psnr[4] >= best - 1.5);
    enc_solution_clear(&four);
    enc_solution_clear(&solution);
    enc_data_destroy(&data);
}

static void test_threads(void **unused) {
    const uint32_t effects = all_maps | BTF_EFFECT_SHADOW | BTF_EFFECT_RESIDUAL;
    const enc_joint_options options = fast(effects, false);
    enc_data *data = sample(RELIEF_WEAVE, 9);
    enc_solution a, b;
    (void)unused;
    assert_int_equal(enc_joint(&one_thread, data, &options, &a, NULL), BTF_OK);
    assert_int_equal(enc_joint(&two_threads, data, &options, &b, NULL), BTF_OK);
    assert_int_equal(a.n_components, b.n_components);
    assert_memory_equal(a.sbrdf->values, b.sbrdf->values,
                        81 * enc_sbrdf_stride(a.sbrdf->lobes, a.sbrdf->rgb) * sizeof(float));
    assert_memory_equal(a.shadow, b.shadow, 81 * 13);
    assert_memory_equal(a.residual_texels, b.residual_texels, 81 * a.n_components);
    assert_memory_equal(a.residual_directions, b.residual_directions, 7 * 13 * 3 * a.n_components);
    assert_memory_equal(a.shift, b.shift, 81 * 7 * 2);
    assert_memory_equal(a.gain, b.gain, 81 * 7);
    enc_solution_clear(&a);
    enc_solution_clear(&b);
    enc_data_destroy(&data);
}

/* The choice is never worse than any single one that it could have made, nor than the paper's method, on
 * four materials: in the fitted domain, but for the tolerances by which it prefers fewer effects and a
 * front, and for what trials of one round cannot foresee (0.3 dB); up to where it is enough. */
static void test_never_worse(void **unused) {
    static const relief_kind reliefs[] = {RELIEF_BRICKS, RELIEF_FLAT, RELIEF_BUMPS, RELIEF_WEAVE};
    static const uint32_t corners[] = {0,
                                       BTF_EFFECT_SHADOW,
                                       BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN,
                                       BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN,
                                       BTF_EFFECT_RESIDUAL,
                                       BTF_EFFECT_RESIDUAL | BTF_EFFECT_SHIFT,
                                       BTF_EFFECT_RESIDUAL | BTF_EFFECT_GAIN,
                                       BTF_EFFECT_RESIDUAL | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN,
                                       BTF_EFFECT_RESIDUAL | BTF_EFFECT_SHADOW};
    (void)unused;
    const int count = getenv("BTF_TEST_LIGHT") ? 2 : 4;
    for (int i = 0; i < count; i++) {
        enc_data *data = sample(reliefs[i], 12);
        enc_joint_options options = fast(BTF_EFFECT_ALL, true);
        options.budget = 8000; /* with maps 8 components, without 16 */
        enc_joint_stats chosen, forced;
        enc_solution solution;
        enc_paper_stats paper_stats;
        double paper_linear;
        assert_int_equal(enc_joint(&two_threads, data, &options, &solution, &chosen), BTF_OK);
        printf("relief %d: effects %u, %u components, %d lobes: %.2f dB\n", i, solution.effects,
               solution.n_components, solution.sbrdf ? solution.sbrdf->lobes : 0, chosen.psnr_fitted);
        assert_true(chosen.trials_count > 0);
        if (reliefs[i] == RELIEF_FLAT) {
            assert_int_equal(solution.effects, 0);
            assert_non_null(solution.sbrdf);
        }
        enc_solution_clear(&solution);
        for (size_t c = 0; c < sizeof corners / sizeof *corners; c++) {
            options = fast(corners[c], false);
            options.budget = 8000;
            assert_int_equal(enc_joint(&two_threads, data, &options, &solution, &forced), BTF_OK);
            assert_int_equal(solution.effects, corners[c]);
            printf("  effects %2u: %.2f dB\n", corners[c], forced.psnr_fitted);
            assert_true(chosen.psnr_fitted >= fmin(forced.psnr_fitted - 0.3, 54.9));
            enc_solution_clear(&solution);
        }
        const enc_paper_options paper = enc_paper_options_default();
        assert_int_equal(enc_paper(&two_threads, data, &paper, &solution, NULL, &paper_stats), BTF_OK);
        const double paper_srgb = decoded_psnr(data, &solution, &paper_linear);
        printf("  paper: %.2f/%.2f dB, chosen %.2f/%.2f\n", paper_linear, paper_srgb, chosen.psnr_linear,
               chosen.psnr_srgb);
        assert_true(chosen.psnr_linear >= fmin(paper_linear, 50.0) &&
                    chosen.psnr_srgb >= fmin(paper_srgb, 50.0));
        enc_solution_clear(&solution);
        enc_data_destroy(&data);
    }
}

/* Points that no source can show, among those of a relief, become hidden: their centres are found, decode
 * as measured, and more than pay; without such points nothing is hidden. */
static void test_centres(void **unused) {
    (void)unused;
    for (int strange = 0; strange < 2; strange++) {
        enc_data *data = sample(RELIEF_BRICKS, 12);
        const size_t row = 3 * 13;
        uint32_t state = 12345;
        size_t count = 0, hidden = 0, right = 0;
        bool is_strange[7 * 144] = {false};
        for (size_t point = 0; strange && point < 7 * 144; point++) {
            state = state * 1664525u + 1013904223u;
            if (state >> 28)
                continue;
            float *samples = data->samples + (point % 144 * 7 + point / 144) * row;
            const uint32_t kind = state >> 20 & 3;
            is_strange[point] = true;
            count++;
            for (size_t p = 0; p < row; p++)
                samples[p] = (float)((p * (7 + 4 * kind) + 5 * kind * kind) % 17) / 17.0f;
        }
        enc_joint_options options = fast(BTF_EFFECT_ALL & ~(uint32_t)BTF_EFFECT_SHADOW, true);
        enc_joint_stats with, without;
        enc_solution solution;
        double linear;
        options.components = 4;
        options.budget = 6000; /* maps, four components and some centres */
        assert_int_equal(enc_joint(&two_threads, data, &options, &solution, &with), BTF_OK);
        assert_true(with.gpu_bytes <= options.budget);
        assert_true(fabs(decoded_psnr(data, &solution, &linear) - with.psnr_srgb) < 0.01);
        for (size_t point = 0; point < 7 * 144 && (solution.effects & BTF_EFFECT_HIDDEN); point++) {
            hidden += solution.gain[point] == 0;
            right += solution.gain[point] == 0 && is_strange[point];
            assert_true(solution.gain[point] > 0 || solution.centre[point] < solution.n_centres);
        }
        enc_solution_clear(&solution);
        options.effects &= ~(uint32_t)BTF_EFFECT_HIDDEN;
        assert_int_equal(enc_joint(&two_threads, data, &options, &solution, &without), BTF_OK);
        printf("%zu strange points: %zu hidden, %zu of them strange; %.2f dB, %.2f without\n", count,
               hidden, right, with.psnr_fitted, without.psnr_fitted);
        if (strange) {
            assert_true(right >= count * 9 / 10);
            assert_true(with.psnr_fitted > without.psnr_fitted + 1.0);
        } else {
            assert_true(with.psnr_fitted >= without.psnr_fitted - 0.05);
        }
        enc_solution_clear(&solution);
        enc_data_destroy(&data);
    }
}

/* --effects auto of the paper's method: all effects of a deep material, none of a flat one, whose flow is
 * not even made; the error that decides is that of what is decoded. */
static void test_paper_effects(void **unused) {
    static const relief_kind reliefs[] = {RELIEF_BRICKS, RELIEF_FLAT};
    (void)unused;
    for (int i = 0; i < 2; i++) {
        enc_data *data = sample(reliefs[i], 16);
        enc_paper_options options = enc_paper_options_default();
        enc_paper_stats stats;
        enc_solution solution;
        double linear;
        options.choose = true;
        options.effect_tolerance = 0.05;
        assert_int_equal(enc_paper(&two_threads, data, &options, &solution, NULL, &stats), BTF_OK);
        if (reliefs[i] == RELIEF_FLAT) {
            assert_int_equal(solution.effects, 0);
            assert_int_equal(stats.hidden_total, 0);
            assert_null(solution.shadow);
            assert_null(solution.shift);
        } else {
            assert_true(solution.effects & BTF_EFFECT_HIDDEN);
            assert_true(stats.hidden_total > 0);
        }
        decoded_psnr(data, &solution, &linear);
        bool found = false;
        for (int t = 0; t < stats.trials_count; t++)
            found = found || (stats.trials[t].effects == solution.effects &&
                              fabs(stats.trials[t].psnr - linear) < 0.01);
        assert_true(found);
        enc_solution_clear(&solution);
        enc_data_destroy(&data);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_monotone),   cmocka_unit_test(test_refit),
        cmocka_unit_test(test_round_trip), cmocka_unit_test(test_threads),
        cmocka_unit_test(test_truncation), cmocka_unit_test(test_paper_effects),
        cmocka_unit_test(test_centres),    cmocka_unit_test(test_never_worse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
