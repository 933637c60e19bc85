/* The shadow test's formula at its edges, the 8-bit codes, and a relief-like material whose shadow masks
 * are known.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/paper/fit.h"
#include "encoder/paper/shadow.h"
#include "tests/support/test.h"

static const enc_context context = {.threads = 2};

TEST(test_formula) {
    /* Error > 0.3, strictly: here it equals the threshold */
    assert_false(enc_is_shadowed(1.25f, 1.0f, 0.25f, 2.0f));
    assert_true(enc_is_shadowed(1.2501f, 1.0f, 0.25f, 2.0f));
    /* BTF < threshold_BTF, strictly. */
    assert_false(enc_is_shadowed(1.0f, 0.25f, 0.3f, 0.25f));
    assert_true(enc_is_shadowed(1.0f, 0.2499f, 0.3f, 0.25f));
    /* samples brighter than the model are never shadow */
    assert_false(enc_is_shadowed(0.1f, 0.2f, 0.3f, 0.3f));
    /* BTF = 0 under a positive model is shadow, 0 under 0 is not. */
    assert_true(enc_is_shadowed(0.01f, 0.0f, 0.3f, 0.3f));
    assert_true(enc_is_shadowed(1e-30f, 0.0f, 0.3f, 0.3f));
    assert_false(enc_is_shadowed(0.0f, 0.0f, 0.3f, 0.3f));
    assert_false(enc_is_shadowed(NAN, 0.0f, 0.3f, 0.3f));

    assert_true(enc_shadow_ratio(0.4f, 0.1f, 0.3f, 0.3f) == 0.1f / 0.4f);
    assert_true(enc_shadow_ratio(0.11f, 0.1f, 0.3f, 0.3f) == 1.0f);
    assert_true(enc_shadow_ratio(2.0f, 0.4f, 0.3f, 0.3f) == 1.0f);
    assert_true(enc_shadow_ratio(0.5f, 0.0f, 0.3f, 0.3f) == 0.0f);
    assert_true(enc_shadow_ratio(0.0f, 0.0f, 0.3f, 0.3f) == 1.0f);
    assert_true(enc_shadow_ratio(1e-6f, 0.0f, 0.3f, 0.3f) == 1.0f); /* a model too dark to divide by */
    assert_true(enc_shadow_ratio(NAN, 0.0f, 0.3f, 0.3f) == 1.0f);
}

TEST(test_codes) {
    for (int code = 0; code < 256; code++) {
        const float ratio = (float)code / 255.0f;
        assert_int_equal(enc_shadow_code(ratio), code);
        assert_int_equal(enc_shadow_code(ratio + 0.49f / 255.0f), code);
        assert_int_equal(enc_shadow_code(ratio - 0.49f / 255.0f), code);
    }
    assert_int_equal(enc_shadow_code(-1.0f), 0);
    assert_int_equal(enc_shadow_code(1.5f), 255);
    assert_int_equal(enc_shadow_code(INFINITY), 255);
    assert_int_equal(enc_shadow_code(NAN), 0);
    assert_int_equal(enc_shadow_code(0.5f), 128); /* 127.5 rounds up */
}

enum { SIDE = 6, TEXELS = SIDE * SIDE, VIEWS = 19, LIGHTS = 37 };

/* A material of known shadows: Lambert with a lobe, a texel dark (`ambient` of it) where
 * mask[light][texel]. The top view is not the first one, so that an index mixed up is seen. */
static enc_data *make_data(const enc_context *with, float ambient, bool mask[LIGHTS * TEXELS]) {
    static const int count[4] = {1, 6, 12, 18};
    enc_direction lights[LIGHTS], views[VIEWS];
    for (int ring = 0, n = 0; ring < 4; ring++) {
        for (int i = 0; i < count[ring]; i++) {
            lights[n++] = enc_direction_from_angles(20.0 * ring, 360.0 * i / count[ring]);
        }
    }
    memcpy(views, lights + 1, sizeof views);
    views[3] = lights[0];
    enc_data *data;
    assert_int_equal(enc_data_create(with, SIDE, SIDE, VIEWS, views, LIGHTS, lights, &data), BTF_OK);
    data->top_view = 3;
    float *samples = malloc(enc_data_texel_stride(data) * sizeof *samples);
    assert_non_null(samples);
    uint32_t random = 5;
    for (size_t t = 0; t < TEXELS; t++) {
        const float albedo = 0.2f + 0.1f * (float)(t % 7);
        for (size_t l = 0; l < LIGHTS; l++) {
            random = random * 1664525u + 1013904223u;
            mask[l * TEXELS + t] = (random >> 24) < 50 && l > 0;
            for (size_t v = 0; v < VIEWS; v++) {
                const float *a = lights[l].xyz, *b = views[v].xyz;
                const float mirror = a[2] * b[2] - a[0] * b[0] - a[1] * b[1];
                const float lobe = mirror > 0 ? 0.2f * powf(mirror, 8) : 0;
                const float value = a[2] * (albedo + lobe) * (mask[l * TEXELS + t] ? ambient : 1);
                for (size_t c = 0; c < 3; c++) {
                    samples[(v * 3 + c) * LIGHTS + l] = value * (1 - 0.2f * (float)c);
                }
            }
        }
        assert_int_equal(enc_data_store_texels(with, data, t, 1, samples), BTF_OK);
    }
    free(samples);
    return data;
}

static double f1_of(const uint8_t *code, const bool *mask, bool inverted) {
    double both = 0, found = 0, there = 0;
    for (size_t i = 0; i < LIGHTS * TEXELS; i++) {
        const bool dark = (code[i] < 128) != inverted;
        both += dark && mask[i];
        found += dark;
        there += mask[i];
    }
    return 2 * both / (found + there);
}

TEST(test_known_masks) {
    static bool mask[LIGHTS * TEXELS];
    static uint8_t code[LIGHTS * TEXELS], again[LIGHTS * TEXELS];
    enc_fit_options fit = enc_fit_options_default();
    fit.lobes = 1;
    for (int variant = 0; variant < 2; variant++) {
        fit.square_root = variant == 1;
        enc_data *data = make_data(&context, 0.05f, mask);
        enc_sbrdf *sbrdf;
        assert_int_equal(enc_fit(&context, data, &fit, &sbrdf, NULL), BTF_OK);
        enc_shadow_options options = enc_shadow_options_default();
        options.square_root = fit.square_root;
        assert_int_equal(enc_top_view_shadow(&context, data, sbrdf, &options, code), BTF_OK);
        assert_true(f1_of(code, mask, false) > 0.97);
        assert_true(f1_of(code, mask, true) < 0.5);

        /* A ratio is the ambient part (or its root); lit points are untouched. */
        const int dark = (int)lround(255 * (variant == 1 ? sqrt(0.05) : 0.05));
        size_t near = 0, shadowed = 0;
        for (size_t i = 0; i < LIGHTS * TEXELS; i++) {
            shadowed += mask[i];
            near += mask[i] && abs(code[i] - dark) <= 2;
            assert_true(mask[i] || code[i] == 255);
        }
        assert_true((double)near > 0.95 * (double)shadowed);

        /* One thread and the scratch file: the same codes. */
        const enc_context small = {.threads = 1, .memory = 4096};
        enc_data *scratch = make_data(&small, 0.05f, mask);
        assert_null(scratch->samples);
        assert_int_equal(enc_top_view_shadow(&small, scratch, sbrdf, &options, again), BTF_OK);
        assert_memory_equal(code, again, sizeof code);
        enc_data_destroy(&scratch);

        /* Modelled light times the 6D ratio gives the data back in the shadows. */
        float buffer[6 * LIGHTS], ratio[LIGHTS];
        for (size_t t = 0; t < TEXELS; t++) {
            for (int v = 0; v < VIEWS; v++) {
                const float *samples = data->samples + (t * VIEWS + (size_t)v) * 3 * LIGHTS;
                enc_shadow_profile(data, sbrdf, &options, t, v, samples, buffer, ratio);
                for (size_t l = 0; l < LIGHTS; l++) {
                    assert_true(ratio[l] >= 0 && ratio[l] <= 1);
                    if (mask[l * TEXELS + t] && ratio[l] < 1) {
                        assert_true(fabs((double)ratio[l] - dark / 255.0) < 0.04);
                    }
                }
            }
        }
        enc_sbrdf_destroy(&sbrdf);
        enc_data_destroy(&data);
    }
}

TEST(test_errors) {
    static bool mask[LIGHTS * TEXELS];
    static uint8_t code[LIGHTS * TEXELS];
    enc_data *data = make_data(&context, 0, mask);
    enc_sbrdf *sbrdf;
    assert_int_equal(enc_sbrdf_create(TEXELS - 1, 1, false, &sbrdf), BTF_OK);
    enc_shadow_options options = enc_shadow_options_default();
    assert_int_equal(enc_top_view_shadow(&context, data, sbrdf, &options, code), BTF_ERROR_USAGE);
    enc_sbrdf_destroy(&sbrdf);

    /* A black model casts no shadow. */
    assert_int_equal(enc_sbrdf_create(TEXELS, 1, false, &sbrdf), BTF_OK);
    assert_int_equal(enc_top_view_shadow(&context, data, sbrdf, &options, code), BTF_OK);
    for (size_t i = 0; i < sizeof code; i++) {
        assert_int_equal(code[i], 255);
    }
    options.t_btf = NAN;
    assert_int_equal(enc_top_view_shadow(&context, data, sbrdf, &options, code), BTF_ERROR_USAGE);
    enc_sbrdf_destroy(&sbrdf);
    enc_data_destroy(&data);
}

RUN_TESTS(NULL, NULL)
