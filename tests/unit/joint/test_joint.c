/* The joint method on data of known truth: monotone rounds, codes that decode to what was measured,
 * budgets, effects, highlights, and the same result for any number of threads.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/joint/joint.h"
#include "encoder/joint/cost.h"
#include "encoder/joint/fit.h"
#include "encoder/joint/measure.h"

#include <math.h>
#include <openbtf/material.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum {
    WIDTH = 14,
    HEIGHT = 11,
    VIEWS = 7,
    LIGHTS = 13,
    TEXELS = WIDTH * HEIGHT,
    ROW = 3 * LIGHTS,
    RANK = 3
};

static uint64_t state;

/* Uniform in 0 .. 1 (xorshift64*, Vigna 2016). */
static float uniform(void) {
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (float)((double)((state * 2685821657736338717u) >> 40) * 0x1p-24);
}

static const enc_context one_thread = {.threads = 1};
static const enc_context two_threads = {.threads = 2};

static enc_data *make_data(void) {
    enc_direction views[VIEWS], lights[LIGHTS];
    enc_data *data = NULL;
    for (int i = 0; i < VIEWS; i++)
        views[i] = enc_direction_from_angles(i ? 40.0 : 0.0, i ? 60.0 * (i - 1) : 0.0);
    for (int i = 0; i < LIGHTS; i++)
        lights[i] = enc_direction_from_angles(i ? 60.0 : 0.0, i ? 30.0 * (i - 1) : 0.0);
    assert_int_equal(enc_data_create(&one_thread, WIDTH, HEIGHT, VIEWS, views, LIGHTS, lights, &data),
                     BTF_OK);
    return data;
}

static float *sample(enc_data *data, int texel, int view, int p) {
    return data->samples + ((size_t)texel * VIEWS + (size_t)view) * ROW + (size_t)p;
}

/* sqrt(L) = gain * sum of RANK positive products of the texel shifted by (3 view, -2 view), plus noise. */
static enc_data *shifted_data(float noise, float gain_range, float scale) {
    enc_data *data = make_data();
    float u[TEXELS][RANK], v[VIEWS][RANK][ROW];
    state = 88172645463325252u;
    for (int i = 0; i < TEXELS * RANK; i++)
        u[i / RANK][i % RANK] = uniform();
    for (int i = 0; i < VIEWS * RANK * ROW; i++)
        v[i / (RANK * ROW)][i / ROW % RANK][i % ROW] = 0.5f * uniform();
    for (int x = 0; x < TEXELS; x++)
        for (int view = 0; view < VIEWS; view++) {
            const int source =
                (x % WIDTH + 3 * view) % WIDTH + (x / WIDTH + 2 * HEIGHT - 2 * view) % HEIGHT * WIDTH;
            const float gain = 1.0f - gain_range * uniform();
            for (int p = 0; p < ROW; p++) {
                float y = noise * (uniform() - 0.5f);
                for (int j = 0; j < RANK; j++)
                    y += gain * u[source][j] * v[view][j][p];
                y = y > 0.0f ? y : 0.0f;
                *sample(data, x, view, p) = scale * y * y;
            }
        }
    return data;
}

/* Bytes that the shapes of this size take. */
static uint64_t bytes_for(const enc_data *data, uint32_t effects, size_t components) {
    const joint_shape shape = {.effects = effects, .components = components};
    return joint_bytes(data, &shape);
}

static enc_joint_options options_for(uint64_t budget) {
    enc_joint_options options = enc_joint_options_default();
    options.preset = ENC_JOINT_FAST;
    options.budget = budget;
    return options;
}

/* The value that FORMAT.md section 9 decodes at a sampled direction, straight from the codes: y before
 * squaring. */
static float decode(const enc_data *data, const enc_solution *s, int texel, int view, int p) {
    const size_t point = (size_t)view * TEXELS + (size_t)texel;
    int column = texel % WIDTH, row = texel / WIDTH;
    if (s->shift) {
        column = (column + s->shift[2 * point] + 20 * WIDTH) % WIDTH;
        row = (row + s->shift[2 * point + 1] + 20 * HEIGHT) % HEIGHT;
    }
    const size_t source = (size_t)(row * WIDTH + column), light = (size_t)(p % LIGHTS),
                 channel = (size_t)(p / LIGHTS);
    float y = 0.0f;
    for (size_t j = 0; j < s->n_components; j++)
        y += (float)s->residual_texels[source * s->n_components + j] * s->residual_scales[j] *
             (float)
                 s->residual_directions[(((size_t)view * LIGHTS + light) * 3 + channel) * s->n_components +
                                        j];
    y *= s->domain == BTF_DOMAIN_SQRT ? sqrtf(data->lights[light].xyz[2]) : data->lights[light].xyz[2];
    if (s->gain)
        y *= (float)s->gain[point] * s->gain_scale;
    return y > 0.0f ? y : 0.0f;
}

/* Sum of squares in the fitted domain, by `decode`. */
static double decoded_error(enc_data *data, const enc_solution *s) {
    double sum = 0.0;
    for (int x = 0; x < TEXELS; x++)
        for (int view = 0; view < VIEWS; view++)
            for (int p = 0; p < ROW; p++) {
                float truth = *sample(data, x, view, p) / s->radiance_scale;
                truth = truth < 1.0f ? truth : 1.0f;
                truth = s->domain == BTF_DOMAIN_SQRT ? sqrtf(truth) : truth;
                const double d = decode(data, s, x, view, p) - truth;
                sum += d * d;
            }
    return sum;
}

static void check_never_rises(const enc_joint_stats *stats) {
    for (int i = 1; i < stats->rounds; i++)
        assert_true(stats->history[i] <= stats->history[i - 1] * (1.0 + 1e-6));
}

/* Known shifts and gains: four components with maps decode almost exactly, without maps they cannot. */
static void test_recovers_shifts(void **unused) {
    (void)unused;
    enc_data *data = shifted_data(0.0f, 0.5f, 1.0f);
    const uint32_t effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL;
    enc_joint_options options = options_for(bytes_for(data, effects, 4));
    enc_joint_stats stats;
    enc_solution solution;
    options.rounds = 30;
    options.tolerance = 1e-3;
    assert_int_equal(enc_joint(&two_threads, data, &options, &solution, &stats), BTF_OK);
    assert_int_equal(solution.effects, effects);
    assert_true(stats.psnr_fitted > 35.0);
    assert_true(stats.moved > TEXELS * VIEWS / 2);
    assert_true(stats.gpu_bytes <= options.budget);
    check_never_rises(&stats);
    enc_solution_clear(&solution);

    options.effects = BTF_EFFECT_RESIDUAL;
    options.budget = bytes_for(data, BTF_EFFECT_RESIDUAL, 4);
    enc_joint_stats plain;
    assert_int_equal(enc_joint(&two_threads, data, &options, &solution, &plain), BTF_OK);
    assert_int_equal(solution.effects, BTF_EFFECT_RESIDUAL);
    assert_null(solution.shift);
    assert_null(solution.gain);
    assert_true(plain.psnr_fitted < stats.psnr_fitted - 10.0);
    enc_solution_clear(&solution);
    enc_data_destroy(&data);
}

/* A round never raises the error, on data that no model fits. */
static void test_monotone(void **unused) {
    (void)unused;
    enc_data *data = shifted_data(0.5f, 0.9f, 1.0f);
    for (uint32_t maps = 0; maps < 4; maps++) {
        const uint32_t effects =
            BTF_EFFECT_RESIDUAL | (maps & 1 ? BTF_EFFECT_SHIFT : 0) | (maps & 2 ? BTF_EFFECT_GAIN : 0);
        joint_rows rows;
        joint_fit plain, fit;
        assert_int_equal(joint_rows_init(&two_threads, data, true, &rows), BTF_OK);
        assert_int_equal(joint_fit_plain(&rows, 8, 3, &plain, NULL), BTF_OK);
        assert_int_equal(joint_fit_start(&plain, 4, effects, &fit), BTF_OK);
        double before = fit.error;
        const double first = before;
        for (int i = 0; i < 6; i++) {
            assert_int_equal(joint_fit_round(&fit), BTF_OK);
            assert_true(fit.error <= before * (1.0 + 1e-9));
            before = fit.error;
        }
        if (maps & 1)
            assert_true(before < 0.95 * first);
        joint_fit_clear(&plain);
        joint_fit_clear(&fit);
        joint_rows_clear(&rows);
    }
    enc_data_destroy(&data);
}

/* The codes decode to the error that was reported; rounding costs little. */
static void test_codes(void **unused) {
    (void)unused;
    enc_data *data = shifted_data(0.1f, 0.5f, 1.0f);
    for (int metric = ENC_JOINT_BALANCED; metric <= ENC_JOINT_LINEAR; metric++) {
        enc_joint_options options = options_for(bytes_for(data, BTF_EFFECT_ALL & ~4u, 8));
        enc_joint_stats stats;
        enc_solution solution;
        options.metric = metric;
        options.tolerance = 1e-4;
        options.effects &= ~(uint32_t)BTF_EFFECT_HIDDEN; /* which `decode` does not know */
        assert_int_equal(enc_joint(&two_threads, data, &options, &solution, &stats), BTF_OK);
        assert_int_equal(solution.domain, metric == ENC_JOINT_LINEAR ? BTF_DOMAIN_LINEAR : BTF_DOMAIN_SQRT);
        const double error = decoded_error(data, &solution);
        assert_true(fabs(error - stats.error) <= 1e-3 * error);
        assert_true(stats.error <= 1.05 * stats.history[stats.rounds - 1]);
        for (size_t i = 0; i < TEXELS * VIEWS; i++)
            assert_true(!solution.gain || solution.gain[i] > 0);
        enc_solution_clear(&solution);
    }
    enc_data_destroy(&data);
}

static void assert_same(const void *a, const void *b, size_t size) {
    assert_true(!a == !b);
    if (a)
        assert_memory_equal(a, b, size);
}

static void assert_same_solution(const enc_solution *a, const enc_solution *b) {
    assert_int_equal(a->effects, b->effects);
    assert_int_equal(a->n_components, b->n_components);
    assert_same(a->residual_texels, b->residual_texels, (size_t)TEXELS * a->n_components);
    assert_same(a->residual_directions, b->residual_directions, (size_t)VIEWS * ROW * a->n_components);
    assert_same(a->residual_scales, b->residual_scales, a->n_components * sizeof(float));
    assert_same(a->shift, b->shift, (size_t)TEXELS * VIEWS * 2);
    assert_same(a->gain, b->gain, (size_t)TEXELS * VIEWS);
}

/* Samples and projection in memory, and both in scratch files. */
static void test_memory(void **unused) {
    (void)unused;
    const enc_context little = {.threads = 2, .memory = 4096};
    enc_data *data = shifted_data(0.2f, 0.5f, 1.0f), *scratch = NULL;
    const enc_joint_options options = options_for(0);
    enc_solution a, b;
    assert_int_equal(
        enc_data_create(&little, WIDTH, HEIGHT, VIEWS, data->views, LIGHTS, data->lights, &scratch),
        BTF_OK);
    assert_null(scratch->samples);
    assert_int_equal(enc_data_store_texels(&little, scratch, 0, TEXELS, data->samples), BTF_OK);
    assert_int_equal(enc_joint(&one_thread, data, &options, &a, NULL), BTF_OK);
    assert_int_equal(enc_joint(&little, scratch, &options, &b, NULL), BTF_OK);
    assert_same_solution(&a, &b);
    enc_solution_clear(&a);
    enc_solution_clear(&b);
    enc_data_destroy(&data);
    enc_data_destroy(&scratch);
}

static void test_threads(void **unused) {
    (void)unused;
    enc_data *data = shifted_data(0.2f, 0.5f, 1.0f);
    const enc_joint_options options = options_for(0);
    enc_solution a, b;
    assert_int_equal(enc_joint(&one_thread, data, &options, &a, NULL), BTF_OK);
    assert_int_equal(enc_joint(&two_threads, data, &options, &b, NULL), BTF_OK);
    assert_same_solution(&a, &b);
    enc_solution_clear(&a);
    enc_solution_clear(&b);
    enc_data_destroy(&data);
}

/* A flat coloured Lambertian costs parameters alone: no map, no residual, no hidden point. */
static void test_flat(void **unused) {
    (void)unused;
    enc_data *data = make_data();
    for (int x = 0; x < TEXELS; x++)
        for (int view = 0; view < VIEWS; view++)
            for (int p = 0; p < ROW; p++)
                *sample(data, x, view, p) =
                    (0.2f + 0.1f * (float)(p / LIGHTS) + 0.3f * (float)(x % 5) / 5.0f) *
                    data->lights[p % LIGHTS].xyz[2];
    const enc_joint_options options = options_for(0);
    enc_joint_stats stats;
    enc_solution solution;
    assert_int_equal(enc_joint(&two_threads, data, &options, &solution, &stats), BTF_OK);
    assert_int_equal(solution.effects, 0);
    assert_int_equal(solution.sbrdf->lobes, 1);
    assert_int_equal(stats.moved, 0);
    assert_int_equal(stats.gpu_bytes, 16 * TEXELS);
    assert_true(stats.psnr_srgb > 50.0);
    enc_solution_clear(&solution);
    enc_data_destroy(&data);
}

/* --quality: reached, with fewer bytes than the budget; out of reach: the budget is used. */
static void test_quality(void **unused) {
    (void)unused;
    enc_data *data = shifted_data(0.05f, 0.5f, 1.0f);
    enc_joint_options options = options_for(bytes_for(data, BTF_EFFECT_ALL & ~4u, 32));
    enc_joint_stats low, high;
    enc_solution solution;
    options.quality = 20.0;
    assert_int_equal(enc_joint(&two_threads, data, &options, &solution, &low), BTF_OK);
    assert_true(low.psnr_srgb >= 20.0);
    assert_true(low.gpu_bytes < options.budget / 2);
    enc_solution_clear(&solution);
    options.quality = 90.0;
    assert_int_equal(enc_joint(&two_threads, data, &options, &solution, &high), BTF_OK);
    assert_true(high.psnr_srgb > low.psnr_srgb);
    assert_true(high.gpu_bytes <= options.budget);
    enc_solution_clear(&solution);
    enc_data_destroy(&data);
}

/* Highlights above 1: a scale keeps the bulk representable, and a few outliers do not swallow the fit. */
static void test_highlights(void **unused) {
    (void)unused;
    enc_data *data = shifted_data(0.0f, 0.5f, 4.0f);
    const enc_joint_options options = options_for(bytes_for(data, BTF_EFFECT_ALL & ~4u, 8));
    enc_joint_stats clean, spoiled;
    enc_solution a, b;
    assert_int_equal(enc_joint(&two_threads, data, &options, &a, &clean), BTF_OK);
    assert_true(a.radiance_scale > 1.0f);
    for (int i = 0; i < TEXELS * VIEWS * ROW; i += 4001)
        data->samples[i] = 1e6f;
    assert_int_equal(enc_joint(&two_threads, data, &options, &b, &spoiled), BTF_OK);
    assert_true(b.radiance_scale < 2.0f * a.radiance_scale);
    assert_true(spoiled.psnr_srgb > 25.0);
    enc_solution_clear(&a);
    enc_solution_clear(&b);
    enc_data_destroy(&data);
}

/* Bytes by hand: 64x64, 81 directions, and the paper's budget. */
static void test_bytes(void **unused) {
    (void)unused;
    enc_direction directions[81];
    for (int i = 0; i < 81; i++)
        directions[i] = enc_direction_from_angles(i ? 10.0 + i * 0.5 : 0.0, i);
    enc_data data = {.width = 64,
                     .height = 64,
                     .n_views = 81,
                     .n_lights = 81,
                     .views = directions,
                     .lights = directions};
    assert_int_equal(joint_default_budget(&data), 64 * 4096 + 4 * 1024 * 512);
    joint_shape shape = {.effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL,
                         .components = 56};
    assert_int_equal(joint_bytes(&data, &shape), 3 * 4096 * 81 + 56 * (4096 + 3 * 81 * 81));
    assert_int_equal(joint_components_for(&data, &shape, joint_default_budget(&data), 256), 56);
    shape.components = 5; /* a started layer counts whole */
    assert_int_equal(joint_bytes(&data, &shape), 3 * 4096 * 81 + 8 * (4096 + 3 * 81 * 81));
}

/* Without a residual: every subset of shadow, shift and gain over the SBRDF; each effect lowers the error,
 * and the rounds never raise it. */
static void test_without_residual(void **unused) {
    (void)unused;
    enc_data *data = shifted_data(0.0f, 0.5f, 1.0f);
    static const uint32_t subsets[] = {0, BTF_EFFECT_SHADOW, BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT,
                                       BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN};
    double before = HUGE_VAL;
    for (int i = 0; i < 4; i++) {
        enc_joint_options options = options_for(0);
        enc_joint_stats stats;
        enc_solution solution;
        options.effects = subsets[i];
        options.choose = false;
        assert_int_equal(enc_joint(&two_threads, data, &options, &solution, &stats), BTF_OK);
        assert_int_equal(solution.effects, subsets[i]);
        assert_int_equal(solution.n_components, 0);
        assert_non_null(solution.sbrdf);
        assert_true(!solution.shadow == !(subsets[i] & BTF_EFFECT_SHADOW));
        assert_true(!solution.shift == !(subsets[i] & BTF_EFFECT_SHIFT));
        assert_true(!solution.gain == !(subsets[i] & BTF_EFFECT_GAIN));
        check_never_rises(&stats);
        assert_true(fabs(stats.error - stats.history[stats.rounds - 1]) <= 1e-3 * stats.error);
        assert_true(stats.error < before);
        before = stats.error;
        enc_solution_clear(&solution);
    }
    enc_data_destroy(&data);
}

/* Impossible options are refused by name, and leave nothing behind. */
static void test_refusals(void **unused) {
    (void)unused;
    enc_data *data = shifted_data(0.1f, 0.5f, 1.0f);
    enc_joint_options options = options_for(100);
    enc_solution solution;
    assert_int_equal(enc_joint(&one_thread, data, &options, &solution, NULL), BTF_ERROR_USAGE);
    assert_null(solution.residual_texels);
    enc_data_destroy(&data);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_recovers_shifts), cmocka_unit_test(test_monotone),
        cmocka_unit_test(test_codes),           cmocka_unit_test(test_threads),
        cmocka_unit_test(test_memory),          cmocka_unit_test(test_flat),
        cmocka_unit_test(test_quality),         cmocka_unit_test(test_highlights),
        cmocka_unit_test(test_bytes),           cmocka_unit_test(test_without_residual),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
