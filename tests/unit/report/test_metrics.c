/* PSNR, SSIM, rings and sRGB coding against values computed by hand.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/report/metrics.h"
#include "encoder/math/srgb.h"
#include "encoder/report/ssim.h"
#include "tests/support/test.h"

static const enc_context context = {.threads = 2};

/* A BTF of 4 x 4 texels, views at theta 0, 30, 30, lights at 0, 60, with every sample `value`. */
static enc_data *constant(float value) {
    const enc_direction views[3] = {enc_direction_from_angles(0, 0), enc_direction_from_angles(30, 0),
                                    enc_direction_from_angles(30, 180)};
    const enc_direction lights[2] = {enc_direction_from_angles(0, 0), enc_direction_from_angles(60, 90)};
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(&context, 4, 4, 3, views, 2, lights, &data), BTF_OK);
    for (size_t i = 0; i < enc_data_texel_count(data) * enc_data_texel_stride(data); i++) {
        data->samples[i] = value;
    }
    return data;
}

static enc_metrics compare(const enc_data *a, const enc_data *b) {
    enc_metrics metrics;
    assert_int_equal(
        enc_metrics_compare(&context, a, enc_data_images(a), enc_data_images(b), true, &metrics), BTF_OK);
    return metrics;
}

TEST(test_srgb) {
    for (int i = 0; i <= 100000; i++) {
        const double x = i / 100000.0;
        const double coded = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
        assert_true(fabs(enc_srgb_encode((float)x) - coded) < 1e-6);
    }
    assert_true(enc_srgb_encode(-1) == 0 && fabsf(enc_srgb_encode(7) - 1) < 1e-6f &&
                enc_srgb_encode(NAN) == 0);
}

TEST(test_constant_difference) {
    enc_data *a = constant(0.5f), *b = constant(0.6f);
    const enc_metrics m = compare(a, b);
    assert_true(fabs(enc_psnr_linear(&m.total) - 20.0) < 1e-4);
    const double coded = (1.055 * pow(0.6, 1 / 2.4)) - (1.055 * pow(0.5, 1 / 2.4));
    assert_true(fabs(enc_psnr_srgb(&m.total) + 20 * log10(coded)) < 1e-3);
    assert_true(m.total.count == 4 * 4 * 3 * 3 * 2);
    enc_data_destroy(&a);
    enc_data_destroy(&b);
}

TEST(test_equal_and_clipped) {
    enc_data *a = constant(1.5f), *b = constant(4.0f);
    const enc_metrics m = compare(a, b);
    assert_true(enc_psnr_linear(&m.total) == 100 && enc_psnr_srgb(&m.total) == 100);
    assert_true(fabs(m.ssim - 1) < 1e-5);
    enc_data_destroy(&a);
    enc_data_destroy(&b);
}

/* An error in one view and one light shows up in their rings only. */
TEST(test_rings) {
    enc_data *a = constant(0.5f), *b = constant(0.5f);
    const size_t stride = enc_data_texel_stride(b);
    for (size_t t = 0; t < enc_data_texel_count(b); t++) {
        for (size_t channel = 0; channel < 3; channel++) {
            b->samples[t * stride + (2 * 3 + channel) * 2 + 1] = 0.4f; /* view 2, light 1 */
        }
    }
    const enc_metrics m = compare(a, b);
    assert_int_equal(m.n_view_rings, 2);
    assert_int_equal(m.n_light_rings, 2);
    assert_true(m.view_ring_theta[1] == 30 && m.light_ring_theta[1] == 60);
    assert_true(enc_psnr_linear(&m.view_ring[0]) == 100 && enc_psnr_linear(&m.light_ring[0]) == 100);
    assert_true(fabs(enc_psnr_linear(&m.view_ring[1]) - (20 + 10 * log10(4))) < 1e-4);
    assert_true(fabs(enc_psnr_linear(&m.light_ring[1]) - (20 + 10 * log10(3))) < 1e-4);
    enc_data_destroy(&a);
    enc_data_destroy(&b);
}

/* Constant images a and b: SSIM = (2ab + c1) / (a^2 + b^2 + c1). */
TEST(test_ssim) {
    float a[20 * 12 * 3], b[20 * 12 * 3];
    for (int i = 0; i < 20 * 12 * 3; i++) {
        a[i] = 0.5f;
        b[i] = 0.7f;
    }
    enc_ssim *ssim = enc_ssim_create(20, 12);
    assert_non_null(ssim);
    const double expected = (2 * 0.5 * 0.7 + 1e-4) / (0.25 + 0.49 + 1e-4);
    assert_true(fabs(enc_ssim_images(ssim, a, b) - expected) < 1e-3);
    for (int i = 0; i < 20 * 12; i++) { /* structure against its negative: far below zero */
        const float wave = (i % 20) / 2 % 2 ? 0.3f : -0.3f;
        for (int channel = 0; channel < 3; channel++) {
            a[3 * i + channel] = 0.5f + wave;
            b[3 * i + channel] = 0.5f - wave;
        }
    }
    assert_true(enc_ssim_images(ssim, a, b) < -0.5);
    assert_true(fabs(enc_ssim_images(ssim, a, a) - 1) < 1e-5);
    enc_ssim_destroy(&ssim);
}

RUN_TESTS(NULL, NULL)
