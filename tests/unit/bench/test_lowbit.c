/* The low-bit peer of btf-bench: its factors have the levels that their bits can code, its bytes keep to the budget,
 * low bits and descent pay, and the number of threads does not matter.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/report/metrics.h"
#include "tests/bench/codecs/lowbit.h"
#include "tests/support/test.h"
#include "tests/support/uniform.h"

enum { SIDE = 16, VIEWS = 13, LIGHTS = 13, TEXELS = SIDE * SIDE, COLUMNS = VIEWS * LIGHTS, TERMS = 40 };

static const enc_context one = {.threads = 1}, two = {.threads = 2};

static enc_data *empty(void) {
    enc_direction directions[VIEWS];
    directions[0] = enc_direction_from_angles(0, 0);
    for (int i = 1; i < VIEWS; i++) {
        directions[i] = enc_direction_from_angles(45, (i - 1) * 360.0 / (VIEWS - 1));
    }
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(&two, SIDE, SIDE, VIEWS, directions, LIGHTS, directions, &data),
                     BTF_OK);
    return data;
}

/* Radiance whose square roots are sums of TERMS products. Their energies fall as slowly as those of measured materials;
 * `tint` is the share of a product that differs between channels. */
static enc_data *textured(float tint) {
    enc_data *data = empty();
    static float u[TERMS][TEXELS], w[TERMS][COLUMNS], colour[TERMS][3];
    uint32_t state = 11;
    for (size_t j = 0; j < TERMS; j++) {
        const float size = j == 0 ? 0.5f : 0.25f / (float)(j + 1);
        for (size_t i = 0; i < TEXELS; i++) {
            u[j][i] = size * (j == 0 ? 1 + 0.2f * uniform(&state) : 2 * uniform(&state) - 1);
        }
        for (size_t i = 0; i < COLUMNS; i++) {
            w[j][i] = j == 0 ? 0.8f + 0.4f * uniform(&state) : 2 * uniform(&state) - 1;
        }
        for (size_t c = 0; c < 3; c++) {
            colour[j][c] = 1 + tint * (2 * uniform(&state) - 1);
        }
    }
    for (size_t t = 0; t < TEXELS; t++) {
        for (size_t v = 0; v < VIEWS; v++) {
            for (size_t c = 0; c < 3; c++) {
                for (size_t l = 0; l < LIGHTS; l++) {
                    float root = 0;
                    for (size_t j = 0; j < TERMS; j++) {
                        root += colour[j][c] * u[j][t] * w[j][v * LIGHTS + l];
                    }
                    data->samples[((t * VIEWS + v) * 3 + c) * LIGHTS + l] = root > 0 ? root * root : 0;
                }
            }
        }
    }
    return data;
}

static lowbit_codec encode(const enc_context *context, const enc_data *data, size_t budget, bool eight_only,
                           int sweeps) {
    const lowbit_options options = {budget, eight_only, sweeps};
    lowbit_codec codec;
    assert_int_equal(lowbit_encode(context, data, &options, &codec), BTF_OK);
    assert_true(codec.bytes <= budget);
    return codec;
}

static double psnr_of(const enc_data *data, const lowbit_codec *codec) {
    enc_metrics m;
    assert_int_equal(
        enc_metrics_compare(&two, data, enc_data_images(data), lowbit_images(codec), false, &m), BTF_OK);
    return enc_psnr_linear(&m.total);
}

static double psnr(const enc_data *data, size_t budget, bool eight_only, int sweeps) {
    lowbit_codec codec = encode(&two, data, budget, eight_only, sweeps);
    const double result = psnr_of(data, &codec);
    lowbit_codec_clear(&codec);
    return result;
}

/* More bytes are better; at 4 times the bytes of every component in 8 bits nothing is lost but rounding. */
TEST(test_budgets) {
    enc_data *data = textured(0.1f);
    double last = 0;
    for (size_t budget = 2000; budget <= 32000; budget *= 2) {
        const double now = psnr(data, budget, false, 2);
        assert_true(now > last + 1);
        last = now;
    }
    assert_true(psnr(data, 4 * 3 * TERMS * (TEXELS + COLUMNS), false, 2) > 50);
    enc_data_destroy(&data);
}

/* At equal bytes low bits beat 8 bits, and each round of descent helps. */
TEST(test_low_bits_and_descent_pay) {
    enc_data *data = textured(0.1f);
    const size_t budget = 8000;
    const double eight = psnr(data, budget, true, 4), nearest = psnr(data, budget, false, 0),
                 once = psnr(data, budget, false, 1), often = psnr(data, budget, false, 4);
    assert_true(nearest > eight + 0.5);
    assert_true(once > nearest + 0.05);
    assert_true(often > once);
    enc_data_destroy(&data);
}

static int compare_floats(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static size_t distinct(const float *values, size_t count) {
    static float sorted[TEXELS > COLUMNS ? TEXELS : COLUMNS];
    memcpy(sorted, values, count * sizeof *values);
    qsort(sorted, count, sizeof *sorted, compare_floats);
    size_t found = 1;
    for (size_t i = 1; i < count; i++) {
        found += sorted[i] != sorted[i - 1];
    }
    return found;
}

/* A factor of b bits has at most 2^b levels (within one view of w, since each view has a step of its own). A number
 * takes b / 8 bytes; to these come two floats a component, and a byte a view for each number of bits that occurs. */
TEST(test_levels_and_bytes) {
    enc_data *data = textured(0.1f);
    lowbit_codec codec = encode(&two, data, 8000, false, 2);
    size_t bytes = 0, kinds = 0;
    for (int p = 0; p < 3; p++) {
        const lowbit_plane *plane = &codec.plane[p];
        bool seen[9] = {false};
        for (size_t j = 0; j < plane->rank; j++) {
            const int bits_u = plane->bits_u[j], bits_w = plane->bits_w[j];
            assert_true(distinct(plane->u + j * TEXELS, TEXELS) <= (size_t)1 << bits_u);
            for (size_t v = 0; v < VIEWS; v++) {
                assert_true(distinct(plane->w + j * COLUMNS + v * LIGHTS, LIGHTS) <= (size_t)1 << bits_w);
            }
            bytes += (TEXELS * (size_t)bits_u + COLUMNS * (size_t)bits_w + 7) / 8 + 8;
            kinds += bits_u < 8;
            bytes += seen[bits_w] ? 0 : VIEWS;
            seen[bits_w] = true;
        }
    }
    assert_int_equal(codec.bytes, bytes);
    assert_true(kinds > 0);
    lowbit_codec_clear(&codec);
    enc_data_destroy(&data);
}

/* Grey data take no component of colour; tinted ones do, fewer than of brightness. */
TEST(test_colour) {
    enc_data *data = textured(0);
    lowbit_codec codec = encode(&two, data, 8000, false, 1);
    assert_true(lowbit_rank(&codec, PCA_LUMA) > 0);
    assert_int_equal(lowbit_rank(&codec, PCA_RED_BLUE), 0);
    assert_int_equal(lowbit_rank(&codec, PCA_GREEN), 0);
    lowbit_codec_clear(&codec);
    enc_data_destroy(&data);
    data = textured(0.3f);
    codec = encode(&two, data, 8000, false, 1);
    assert_true(lowbit_rank(&codec, PCA_RED_BLUE) > 0);
    assert_true(lowbit_rank(&codec, PCA_LUMA) > lowbit_rank(&codec, PCA_RED_BLUE));
    assert_int_equal(lowbit_rank(&codec, PCA_RGB), lowbit_rank(&codec, PCA_LUMA) +
                                                       lowbit_rank(&codec, PCA_RED_BLUE) +
                                                       lowbit_rank(&codec, PCA_GREEN));
    lowbit_codec_clear(&codec);
    enc_data_destroy(&data);
}

/* The same bits from one thread and from two. */
TEST(test_threads) {
    enc_data *data = textured(0.1f);
    lowbit_codec a = encode(&one, data, 6000, false, 2), b = encode(&two, data, 6000, false, 2);
    for (int p = 0; p < 3; p++) {
        assert_int_equal(a.plane[p].rank, b.plane[p].rank);
        assert_memory_equal(a.plane[p].u, b.plane[p].u, a.plane[p].rank * TEXELS * sizeof(float));
        assert_memory_equal(a.plane[p].w, b.plane[p].w, a.plane[p].rank * COLUMNS * sizeof(float));
    }
    lowbit_codec_clear(&a);
    lowbit_codec_clear(&b);
    enc_data_destroy(&data);
}

/* Black data, data of one value, and budgets that hold nothing. */
TEST(test_degenerate) {
    enc_data *data = empty();
    const lowbit_options options = {.budget = 8000, .sweeps = 1}, small = {.budget = 100, .sweeps = 1};
    lowbit_codec codec;
    assert_int_equal(lowbit_encode(&two, data, &options, &codec),
                     BTF_ERROR_USAGE); /* black data: no component is worth its bytes */
    for (size_t i = 0; i < (size_t)TEXELS * 3 * COLUMNS; i++) {
        data->samples[i] = 0.25f;
    }
    codec = encode(&two, data, 8000, false, 1);
    assert_true(psnr_of(data, &codec) > 60);
    lowbit_codec_clear(&codec);
    assert_int_equal(lowbit_encode(&two, data, &small, &codec), BTF_ERROR_USAGE);
    enc_data_destroy(&data);
}

RUN_TESTS(NULL, NULL)
