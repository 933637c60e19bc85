/* The iterative fit (encoder/paper/fit.h): rejection finds shadowed samples, keeps all samples where nearly all look
 * shadowed, and gives the same bits on any number of threads; options are checked.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/paper/fit.h"
#include "encoder/math/simd.h"
#include "tests/support/fit_data.h"
#include "tests/support/test.h"

static const enc_context context = {.threads = 2};

/* A row of `texels` texels with random lobes under 81 directions; in each texel a fifth of the lights is shadowed to 5
 * %. */
static enc_data *make_data(const enc_context *with, int texels, bool *out_shadow) {
    enc_direction directions[DIRECTIONS];
    fit_directions(directions);
    enc_data *data;
    assert_int_equal(
        enc_data_create(with, texels, 1, DIRECTIONS, directions, DIRECTIONS, directions, &data), BTF_OK);
    float *samples = malloc(enc_data_texel_stride(data) * sizeof *samples);
    assert_non_null(samples);
    fit_random_state = 77;
    for (int t = 0; t < texels; t++) {
        float parameters[8] = {1, 0.8f, 0.6f, 0.3f + 0.3f * fit_random(), -0.7f, -0.7f, 0.7f, 5};
        for (int l = 0; l < DIRECTIONS; l++) {
            const bool shadow = fit_random() < 0.2f;
            if (out_shadow != NULL) {
                out_shadow[t * DIRECTIONS + l] = shadow;
            }
            for (int v = 0; v < DIRECTIONS; v++) {
                double product[3];
                for (int k = 0; k < 3; k++) {
                    product[k] = (double)directions[l].xyz[k] * (double)directions[v].xyz[k];
                }
                for (int c = 0; c < 3; c++) {
                    const double value =
                        (double)directions[l].xyz[2] * fit_model_value(parameters, 1, false, product, c);
                    samples[(v * 3 + c) * DIRECTIONS + l] = (float)(shadow ? 0.05 * value : value);
                }
            }
        }
        assert_int_equal(enc_data_store_texels(with, data, (size_t)t, 1, samples), BTF_OK);
    }
    free(samples);
    return data;
}

/* Rejection finds the shadows and gives back the unshadowed material. */
TEST(test_rejection) {
    enum { TEXELS = 8 };
    bool shadow[TEXELS * DIRECTIONS];
    enc_data *data = make_data(&context, TEXELS, shadow);
    size_t shadowed = 0;
    for (int i = 0; i < TEXELS * DIRECTIONS; i++) {
        shadowed += shadow[i];
    }
    enc_sbrdf *sbrdf;
    enc_fit_stats stats;
    enc_fit_options options = enc_fit_options_default();
    options.lobes = 1;
    assert_int_equal(enc_fit(&context, data, &options, &sbrdf, &stats), BTF_OK);
    assert_int_equal(stats.texels, TEXELS);
    assert_int_equal(stats.samples, TEXELS * PAIRS);
    assert_true(fabs((double)stats.rejected / TEXELS / PAIRS - (double)shadowed / TEXELS / DIRECTIONS) <
                0.002);
    assert_true(stats.solves >= 2 * TEXELS && stats.solves <= 4 * TEXELS);
    assert_true(stats.cost / (double)(stats.samples - stats.rejected) < 1e-6);
    enc_sbrdf_destroy(&sbrdf);

    options.rounds = 0;
    enc_fit_stats plain;
    assert_int_equal(enc_fit(&context, data, &options, &sbrdf, &plain), BTF_OK);
    assert_int_equal(plain.rejected, 0);
    assert_int_equal(plain.solves, TEXELS);
    assert_true(plain.cost > 100 * stats.cost);
    enc_sbrdf_destroy(&sbrdf);
    enc_data_destroy(&data);
}

/* When nearly everything looks shadowed, everything is kept. */
TEST(test_all_rejected) {
    enc_data *data = make_data(&context, 2, NULL);
    for (size_t i = 0; i < 2 * enc_data_texel_stride(data); i++) {
        data->samples[i] = i % 50 == 0 ? 20.0f : 1e-3f * fit_random();
    }
    enc_fit_options options = enc_fit_options_default();
    enc_sbrdf *sbrdf;
    enc_fit_stats stats;
    assert_int_equal(enc_fit(&context, data, &options, &sbrdf, &stats), BTF_OK);
    assert_true(stats.rejected <= stats.samples * 9 / 10);
    fit_assert_storable(sbrdf->values, 2 * enc_sbrdf_stride(3, false));
    enc_sbrdf_destroy(&sbrdf);

    memset(data->samples, 0, 2 * enc_data_texel_stride(data) * sizeof(float));
    assert_int_equal(enc_fit(&context, data, &options, &sbrdf, &stats), BTF_OK);
    assert_int_equal(stats.black, 2);
    assert_int_equal(stats.solves, 0);
    for (size_t i = 0; i < 2 * enc_sbrdf_stride(3, false); i++) {
        assert_true(sbrdf->values[i] == 0);
    }
    enc_sbrdf_destroy(&sbrdf);
    enc_data_destroy(&data);
}

/* The same bits for one thread and two, from memory and from a scratch file, from every instruction set;
 * and the square-root domain models the root. */
TEST(test_same_bits) {
    enum { TEXELS = 20 };
    const enc_context small = {.threads = 1, .memory = 1 << 20};
    enc_data *data = make_data(&context, TEXELS, NULL), *scratch = make_data(&small, TEXELS, NULL);
    assert_null(scratch->samples);
    for (int variant = 0; variant < 3; variant++) {
        enc_fit_options options = enc_fit_options_default();
        options.rgb = variant == 1;
        options.square_root = variant == 2;
        options.rounds = 1;
        options.lobes = 2;
        const size_t bytes = TEXELS * enc_sbrdf_stride(2, options.rgb) * sizeof(float);
        enc_sbrdf *two, *one;
        enc_fit_stats stats_two, stats_one;
        assert_int_equal(enc_fit(&context, data, &options, &two, &stats_two), BTF_OK);
        enc_isa_limit(ENC_ISA_BASE);
        assert_int_equal(enc_fit(&small, scratch, &options, &one, &stats_one), BTF_OK);
        enc_isa_limit(ENC_ISA_AVX512);
        assert_memory_equal(one->values, two->values, bytes);
        assert_true(stats_one.cost == stats_two.cost);
        assert_int_equal(stats_one.evaluations, stats_two.evaluations);
        if (options.square_root) {
            const float up[3] = {0, 0, 1}, light[3] = {0, 0, 1};
            float value[3];
            enc_sbrdf_evaluate(two, 0, up, 1, &light[0], &light[1], &light[2], value);
            assert_true(value[0] > 0.5f && value[0] < 1.2f); /* root of 0.3..0.6 + 0.7^5 */
        }
        enc_sbrdf_destroy(&one);
        enc_sbrdf_destroy(&two);
    }
    enc_data_destroy(&data);
    enc_data_destroy(&scratch);
}

TEST(test_options) {
    enc_data *data = make_data(&context, 1, NULL);
    for (int i = 0; i < 7; i++) {
        enc_fit_options options = enc_fit_options_default();
        options.lobes = i == 0 ? 0 : i == 1 ? 5 : 3;
        options.starts = i == 2 ? 0 : i == 3 ? 5 : 1;
        options.rounds = i == 4 ? -1 : 0;
        options.t_error = i == 5 ? -1.0f : 0.3f;
        options.tolerance = i == 6 ? NAN : 1e-3;
        enc_sbrdf *sbrdf;
        assert_int_equal(enc_fit(&context, data, &options, &sbrdf, NULL), BTF_ERROR_USAGE);
        assert_null(sbrdf);
    }
    enc_fit_workspace *workspace;
    assert_int_equal(enc_fit_workspace_create(0, &workspace), BTF_ERROR_USAGE);
    assert_int_equal(enc_fit_workspace_create(SIZE_MAX, &workspace), BTF_ERROR_USAGE);
    enc_data_destroy(&data);
}

RUN_TESTS(NULL, NULL)
