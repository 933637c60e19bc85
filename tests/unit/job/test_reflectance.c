/* When a reflectance model alone takes the place of factors.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/job/reflectance.h"
#include "tests/support/test.h"

static enc_error_sum of(double linear, double srgb) {
    return (enc_error_sum){pow(10, -linear / 10), pow(10, -srgb / 10), 1};
}

static const enc_reflectance_weights tenth = {.model_bytes = 1000, .factor_bytes = 1100, .tolerance = 0.05};

/* A tenth more bytes has to gain the tolerance, in the mean of both PSNR. */
TEST(test_tolerance) {
    const enc_error_sum model = of(50, 40), gains = of(50.06, 40.06), gains_less = of(50.04, 40.04), mean = of(50.15, 39.93);
    assert_false(enc_reflectance_pays(&tenth, &model, &gains));
    assert_true(enc_reflectance_pays(&tenth, &model, &gains_less));
    assert_true(enc_reflectance_pays(&tenth, &model, &mean));
    enc_reflectance_weights weights = tenth;
    weights.factor_bytes = 10000; /* 24 tenths: 1.2 dB */
    assert_true(enc_reflectance_pays(&weights, &model, &(enc_error_sum){of(51.1, 41.1).linear, of(51.1, 41.1).srgb, 1}));
    assert_false(enc_reflectance_pays(&weights, &model, &(enc_error_sum){of(51.3, 41.3).linear, of(51.3, 41.3).srgb, 1}));
    weights.tolerance = 0; /* bytes do not count then */
    assert_false(enc_reflectance_pays(&weights, &model, &gains_less));
    assert_true(enc_reflectance_pays(&weights, &gains_less, &model));
    assert_true(enc_reflectance_pays(&weights, &model, &model));
}

/* More bytes are never taken. */
TEST(test_bytes) {
    const enc_error_sum good = of(80, 80), bad = of(20, 20);
    enc_reflectance_weights weights = tenth;
    weights.model_bytes = 1101;
    assert_false(enc_reflectance_pays(&weights, &good, &bad));
    weights.model_bytes = 1100;
    assert_true(enc_reflectance_pays(&weights, &good, &bad));
}

/* Both are exact to the eye, and to the last bit. */
TEST(test_exact) {
    const enc_error_sum model = of(101, 102), factors = of(140, 150), none = {.count = 1};
    assert_true(enc_reflectance_pays(&tenth, &model, &factors));
    assert_true(enc_reflectance_pays(&tenth, &model, &none));
    assert_true(enc_reflectance_pays(&tenth, &none, &none));
}

/* A quality that the model has is enough; one that it lacks is no reason to take it for its bytes. */
TEST(test_quality) {
    const enc_error_sum model = of(50, 40), factors = of(50.04, 40.04);
    enc_reflectance_weights weights = tenth;
    weights.quality = 40;
    assert_true(enc_reflectance_pays(&weights, &model, &(enc_error_sum){0, 0, 1}));
    weights.quality = 41;
    assert_false(enc_reflectance_pays(&weights, &model, &factors));
    const enc_error_sum reaches = of(48, 41.5), misses = of(52, 40.5); /* the mean favours who misses it */
    assert_false(enc_reflectance_pays(&weights, &misses, &reaches));
    assert_true(enc_reflectance_pays(&weights, &reaches, &misses));
    assert_true(enc_reflectance_pays(&weights, &factors, &model));
}

RUN_TESTS(NULL, NULL)
