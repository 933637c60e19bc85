/* The PCA peers of btf-bench: known factors come back, more components are never worse, bytes cost little,
 * and the number of threads does not matter.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/report/metrics.h"
#include "tests/bench/codecs/pca.h"
#include "tests/support/test.h"
#include "tests/support/uniform.h"

enum {
    SIDE = 12,
    VIEWS = 7,
    LIGHTS = 9,
    TEXELS = SIDE * SIDE,
    COLUMNS = VIEWS * 3 * LIGHTS,
    MAX_RANK = 16
};

static const enc_context one = {.threads = 1}, two = {.threads = 2};

static enc_data *empty(void) {
    enc_direction views[VIEWS], lights[LIGHTS];
    views[0] = lights[0] = enc_direction_from_angles(0, 0);
    for (int i = 1; i < VIEWS; i++) {
        views[i] = enc_direction_from_angles(45, (i - 1) * 360.0 / (VIEWS - 1));
    }
    for (int i = 1; i < LIGHTS; i++) {
        lights[i] = enc_direction_from_angles(60, (i - 1) * 360.0 / (LIGHTS - 1));
    }
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(&two, SIDE, SIDE, VIEWS, views, LIGHTS, lights, &data), BTF_OK);
    assert_int_equal(enc_data_texel_stride(data), COLUMNS);
    return data;
}

/* A sum of `rank` products of non-negative factors, each half as large as the one before; values are in [0, 1]. With
 * `halves` set, texels of the upper half have other factors than those of the lower. */
static enc_data *low_rank(size_t rank, bool halves) {
    enc_data *data = empty();
    uint32_t state = 7;
    static float u[TEXELS * MAX_RANK], v[2 * MAX_RANK * COLUMNS];
    for (size_t i = 0; i < TEXELS * MAX_RANK; i++) {
        u[i] = uniform(&state);
    }
    for (size_t i = 0; i < 2 * MAX_RANK * COLUMNS; i++) {
        v[i] = uniform(&state);
    }
    for (size_t t = 0; t < TEXELS; t++) {
        for (size_t p = 0; p < COLUMNS; p++) {
            float sum = 0;
            for (size_t j = 0; j < rank; j++) {
                const size_t row = halves && t >= TEXELS / 2 ? MAX_RANK + j : j;
                sum += ldexpf(u[t * MAX_RANK + j] * v[row * COLUMNS + p], -1 - (int)j);
            }
            data->samples[t * COLUMNS + p] = sum;
        }
    }
    return data;
}

/* Values without structure, some above 1. */
static enc_data *noise(void) {
    enc_data *data = empty();
    uint32_t state = 3;
    for (size_t i = 0; i < (size_t)TEXELS * COLUMNS; i++) {
        const float x = uniform(&state);
        data->samples[i] = 1.2f * x * x;
    }
    return data;
}

static enc_metrics measure(const enc_data *data, const pca_codec *codec) {
    enc_metrics m;
    assert_int_equal(enc_metrics_compare(&two, data, enc_data_images(data), pca_images(codec), false, &m),
                     BTF_OK);
    return m;
}

static enc_metrics encode_and_measure(const pca_factors *factors, pca_number number, size_t rank) {
    pca_codec codec;
    assert_int_equal(pca_encode(&two, factors, number, rank, &codec), BTF_OK);
    assert_int_equal(codec.bytes, pca_bytes(factors->data, number, 1, rank));
    const enc_metrics m = measure(factors->data, &codec);
    pca_codec_clear(&codec);
    return m;
}

static pca_factors factorise(const enc_context *context, const enc_data *data, pca_coding coding,
                             size_t rank) {
    pca_factors factors;
    assert_int_equal(pca_factorise(context, data, coding, rank, &factors), BTF_OK);
    return factors;
}

/* A matrix of rank 5 gives five components with orthonormal rows, and no others. */
TEST(test_recovers) {
    enc_data *data = low_rank(5, false);
    pca_factors f = factorise(&two, data, PCA_LINEAR, 8);
    assert_int_equal(f.rank, 8);
    double worst = 0;
    for (size_t t = 0; t < TEXELS; t++) {
        for (size_t p = 0; p < COLUMNS; p++) {
            double sum = 0;
            for (size_t j = 0; j < 5; j++) {
                sum += (double)f.u[t * f.rank + j] * f.v[j * COLUMNS + p];
            }
            worst = fmax(worst, fabs(sum - data->samples[t * COLUMNS + p]));
        }
    }
    assert_true(worst < 1e-5);
    double norm[8] = {0};
    for (size_t j = 0; j < 8; j++) {
        for (size_t t = 0; t < TEXELS; t++) {
            norm[j] += (double)f.u[t * f.rank + j] * f.u[t * f.rank + j];
        }
        assert_true(j == 0 || norm[j] <= norm[j - 1]);
    }
    assert_true(norm[4] > 1e-6 * norm[0] && norm[5] < 1e-9 * norm[0]);
    for (size_t i = 0; i < 5; i++) {
        for (size_t j = 0; j <= i; j++) {
            double dot = 0;
            for (size_t p = 0; p < COLUMNS; p++) {
                dot += (double)f.v[i * COLUMNS + p] * f.v[j * COLUMNS + p];
            }
            assert_true(fabs(dot - (i == j)) < 1e-4);
        }
    }
    pca_factors_clear(&f);
    enc_data_destroy(&data);
}

/* For every rank the squared error is the energy of the components left out (C. Eckart and G. Young, 1936), so it never
 * rises with the rank. */
TEST(test_ranks) {
    enc_data *data = noise();
    enc_data *clipped = noise();
    double energy = 0, last = HUGE_VAL;
    for (size_t i = 0; i < (size_t)TEXELS * COLUMNS; i++) {
        clipped->samples[i] = fminf(clipped->samples[i], 1);
        energy += (double)clipped->samples[i] * clipped->samples[i];
    }
    pca_factors f = factorise(&two, data, PCA_LINEAR, TEXELS);
    assert_int_equal(f.rank, TEXELS);
    for (size_t rank = 0; rank <= TEXELS; rank += 16) {
        double error = 0, kept = 0;
        for (size_t t = 0; t < TEXELS; t++) {
            for (size_t j = 0; j < rank; j++) {
                kept += (double)f.u[t * f.rank + j] * f.u[t * f.rank + j];
            }
            for (size_t p = 0; p < COLUMNS; p++) {
                double sum = 0;
                for (size_t j = 0; j < rank; j++) {
                    sum += (double)f.u[t * f.rank + j] * f.v[j * COLUMNS + p];
                }
                const double d = sum - clipped->samples[t * COLUMNS + p];
                error += d * d;
            }
        }
        assert_true(fabs(error - (energy - kept)) < 1e-4 * energy);
        assert_true(error < last);
        last = error;
    }
    assert_true(last < 1e-6 * energy);
    pca_factors_clear(&f);
    enc_data_destroy(&data);
    enc_data_destroy(&clipped);
}

/* Decoded PSNR rises with the rank, in every coding and in both kinds of numbers. */
TEST(test_psnr_rises) {
    enc_data *data = noise();
    for (int coding = PCA_LINEAR; coding <= PCA_SQRT; coding++) {
        pca_factors f = factorise(&two, data, (pca_coding)coding, 64);
        for (int number = PCA_HALF; number <= PCA_BYTE; number++) {
            double last = 0;
            for (size_t rank = 1; rank <= 64; rank *= 2) {
                const enc_metrics m = encode_and_measure(&f, (pca_number)number, rank);
                const double psnr =
                    coding == PCA_LINEAR ? enc_psnr_linear(&m.total) : enc_psnr_srgb(&m.total);
                assert_true(psnr > last);
                last = psnr;
            }
        }
        pca_factors_clear(&f);
    }
    enc_data_destroy(&data);
}

/* Where 48 of 144 components are kept, rounding to 8 bits costs less than 0.2 dB, and to halves less than
 * 0.01. */
TEST(test_rounding) {
    enc_data *data = noise();
    pca_factors f = factorise(&two, data, PCA_LINEAR, 48);
    double error = 0;
    for (size_t t = 0; t < TEXELS; t++) {
        for (size_t p = 0; p < COLUMNS; p++) {
            float sum = 0;
            for (size_t j = 0; j < 48; j++) {
                sum += f.u[t * f.rank + j] * f.v[j * COLUMNS + p];
            }
            const double d = fminf(fmaxf(sum, 0), 1) - fminf(data->samples[t * COLUMNS + p], 1);
            error += d * d;
        }
    }
    const double exact = 10 * log10((double)TEXELS * COLUMNS / error);
    const enc_metrics half = encode_and_measure(&f, PCA_HALF, 48),
                      byte = encode_and_measure(&f, PCA_BYTE, 48);
    assert_true(fabs(enc_psnr_linear(&half.total) - exact) < 0.01);
    assert_true(enc_psnr_linear(&byte.total) <= exact && enc_psnr_linear(&byte.total) > exact - 0.2);
    pca_factors_clear(&f);
    enc_data_destroy(&data);
    data = low_rank(5, false);
    f = factorise(&two, data, PCA_LINEAR, 5);
    const enc_metrics half_whole = encode_and_measure(&f, PCA_HALF, 5);
    const enc_metrics byte_whole = encode_and_measure(&f, PCA_BYTE, 5);
    assert_true(enc_psnr_linear(&half_whole.total) > 70);
    assert_true(enc_psnr_linear(&byte_whole.total) > 50 && enc_psnr_linear(&byte_whole.total) < 70);
    pca_factors_clear(&f);
    enc_data_destroy(&data);
}

/* Data from two subspaces of rank 3: two clusters of rank 3 represent them exactly, one does not. */
TEST(test_clusters) {
    enc_data *data = low_rank(3, true);
    pca_factors f = factorise(&two, data, PCA_LINEAR, 12);
    pca_codec codec;
    assert_int_equal(pca_encode_clusters(&two, &f, PCA_HALF, 2, 3, &codec), BTF_OK);
    assert_int_equal(codec.first[2], TEXELS);
    assert_int_equal(codec.bytes, 2 * 3 * (TEXELS + 2 * COLUMNS) + TEXELS);
    const enc_metrics clustered = measure(data, &codec), whole = encode_and_measure(&f, PCA_HALF, 3);
    assert_true(enc_psnr_linear(&clustered.total) > 60);
    assert_true(enc_psnr_linear(&whole.total) < 40);
    pca_codec_clear(&codec);
    assert_int_equal(pca_encode_clusters(&two, &f, PCA_HALF, 257, 3, &codec), BTF_ERROR_USAGE);
    pca_factors_clear(&f);
    enc_data_destroy(&data);
}

/* Half floats: 2 bytes a number. Bytes: one, and a float scale for each column of u and row of v. */
TEST(test_bytes) {
    enc_data *data = empty();
    assert_int_equal(pca_bytes(data, PCA_HALF, 1, 10), 10 * 2 * (TEXELS + COLUMNS));
    assert_int_equal(pca_bytes(data, PCA_BYTE, 1, 10), 10 * (TEXELS + COLUMNS) + 10 * 2 * 4);
    assert_int_equal(pca_bytes(data, PCA_BYTE, 4, 2), 2 * (TEXELS + 4 * COLUMNS) + 2 * 5 * 4 + TEXELS);
    const size_t budget = pca_bytes(data, PCA_BYTE, 1, 10);
    assert_int_equal(pca_rank_for(data, PCA_BYTE, 1, budget), 10);
    assert_int_equal(pca_rank_for(data, PCA_BYTE, 1, budget - 1), 9);
    assert_int_equal(pca_rank_for(data, PCA_HALF, 1, 100), 0);
    enc_data_destroy(&data);
}

/* The same bits from one thread and from two. */
TEST(test_threads) {
    enc_data *data = noise();
    pca_factors a = factorise(&one, data, PCA_SRGB, 40), b = factorise(&two, data, PCA_SRGB, 40);
    assert_memory_equal(a.u, b.u, TEXELS * a.rank * sizeof *a.u);
    assert_memory_equal(a.v, b.v, COLUMNS * a.rank * sizeof *a.v);
    pca_codec c, d;
    assert_int_equal(pca_encode_clusters(&one, &a, PCA_BYTE, 4, 6, &c), BTF_OK);
    assert_int_equal(pca_encode_clusters(&two, &b, PCA_BYTE, 4, 6, &d), BTF_OK);
    assert_memory_equal(c.order, d.order, TEXELS * sizeof *c.order);
    assert_memory_equal(c.u, d.u, TEXELS * c.rank * sizeof *c.u);
    assert_memory_equal(c.v, d.v, 4 * COLUMNS * c.rank * sizeof *c.v);
    pca_codec_clear(&c);
    pca_codec_clear(&d);
    pca_factors_clear(&a);
    pca_factors_clear(&b);
    enc_data_destroy(&data);
}

/* Data that have no more than rank 1, and a rank beyond the number of texels. */
TEST(test_degenerate) {
    enc_data *data = empty();
    pca_factors f = factorise(&two, data, PCA_SRGB, 1000);
    assert_int_equal(f.rank, TEXELS);
    enc_metrics m = encode_and_measure(&f, PCA_BYTE, 3);
    assert_true(enc_psnr_linear(&m.total) == 100);
    pca_factors_clear(&f);
    for (size_t i = 0; i < (size_t)TEXELS * COLUMNS; i++) {
        data->samples[i] = 0.5f;
    }
    f = factorise(&two, data, PCA_LINEAR, 4);
    m = encode_and_measure(&f, PCA_BYTE, 4);
    assert_true(enc_psnr_linear(&m.total) > 80);
    pca_factors_clear(&f);
    enc_data_destroy(&data);
}

RUN_TESTS(NULL, NULL)
