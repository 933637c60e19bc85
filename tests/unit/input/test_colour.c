/* Transfer functions, XYZ, the area filter (encoder/input/colour.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/input/colour.h"
#include "tests/support/test.h"

TEST(test_srgb_curve) {
    assert_true(enc_srgb_decode(0.0) == 0.0);
    assert_float_equal(enc_srgb_decode(1.0), 1.0, 1e-15);
    assert_float_equal(enc_srgb_decode(0.04045), 0.0031308049535603713, 1e-15);
    assert_float_equal(enc_srgb_decode(0.5), 0.21404114048223255, 1e-14);
    assert_float_equal(enc_srgb_decode(128.0 / 255.0), 0.21586050011389926, 1e-14);
    assert_float_equal(enc_srgb_decode(-0.5), -enc_srgb_decode(0.5), 0.0);
    assert_true(enc_srgb_decode(2.0) > 4.9 && enc_srgb_decode(2.0) < 5.0);
}

/* Decodes one grey sample of each depth. */
static float decode_one(enc_transfer transfer, double gamma, int depth, double value) {
    unsigned char v8 = (unsigned char)value;
    unsigned short v16 = (unsigned short)value;
    float v32 = (float)value, out[3];
    enc_image image = {
        1, 1, 1, depth, false, depth == 8 ? (void *)&v8 : depth == 16 ? (void *)&v16 : (void *)&v32, {0}};
    enc_decoder *decoder = enc_decoder_create(transfer, gamma);
    assert_non_null(decoder);
    enc_decode_pixels(decoder, &image, (enc_rectangle){0, 0, 1, 1}, out);
    enc_decoder_destroy(&decoder);
    assert_null(decoder);
    assert_memory_equal(&out[0], &out[1], sizeof *out);
    assert_memory_equal(&out[1], &out[2], sizeof *out);
    return out[0];
}

TEST(test_transfer_by_depth) {
    assert_float_equal(decode_one(ENC_TRANSFER_AUTO, 0, 8, 128), 0.21586050f, 1e-7);
    assert_float_equal(decode_one(ENC_TRANSFER_AUTO, 0, 16, 32896), 0.21586050f, 1e-7); /* 128 * 257 */
    assert_float_equal(decode_one(ENC_TRANSFER_AUTO, 0, 32, 0.5), 0.5f, 0);
    assert_float_equal(decode_one(ENC_TRANSFER_SRGB, 0, 32, 0.5), 0.21404114f, 1e-7);
    assert_float_equal(decode_one(ENC_TRANSFER_LINEAR, 0, 8, 51), 0.2f, 1e-7);
    assert_float_equal(decode_one(ENC_TRANSFER_LINEAR, 0, 16, 13107), 0.2f, 1e-7);
    assert_float_equal(decode_one(ENC_TRANSFER_GAMMA, 2.0, 8, 51), 0.04f, 1e-7);
    assert_float_equal(decode_one(ENC_TRANSFER_GAMMA, 2.0, 32, -0.5), -0.25f, 1e-7);
    assert_true(decode_one(ENC_TRANSFER_AUTO, 0, 8, 255) == 1.0f);
    assert_true(decode_one(ENC_TRANSFER_AUTO, 0, 16, 65535) == 1.0f);
    assert_true(isnan(decode_one(ENC_TRANSFER_AUTO, 0, 32, NAN)));
}

TEST(test_crop_and_grey) {
    unsigned char grey[4 * 5], rgb[4 * 5 * 3];
    for (int i = 0; i < 20; i++) {
        grey[i] = (unsigned char)i;
    }
    for (int i = 0; i < 60; i++) {
        rgb[i] = (unsigned char)(3 * i);
    }
    enc_decoder *decoder = enc_decoder_create(ENC_TRANSFER_LINEAR, 0);
    float out[2 * 3 * 3];
    const enc_rectangle area = {1, 2, 3, 2};
    enc_image image = {5, 4, 1, 8, false, grey, {0}};
    enc_decode_pixels(decoder, &image, area, out);
    for (int row = 0; row < 2; row++) {
        for (int x = 0; x < 3; x++) {
            for (int c = 0; c < 3; c++) {
                assert_float_equal(out[(row * 3 + x) * 3 + c] * 255.0f, (row + 2) * 5 + x + 1, 1e-5);
            }
        }
    }
    image = (enc_image){5, 4, 3, 8, false, rgb, {0}};
    enc_decode_pixels(decoder, &image, area, out);
    for (int row = 0; row < 2; row++) {
        for (int x = 0; x < 3; x++) {
            for (int c = 0; c < 3; c++) {
                assert_float_equal(out[(row * 3 + x) * 3 + c] * 255.0f,
                                   3 * (((row + 2) * 5 + x + 1) * 3 + c), 1e-4);
            }
        }
    }
    enc_decoder_destroy(&decoder);
}

TEST(test_xyz) {
    /* the white point, and sRGB's primaries (IEC 61966-2-1) */
    float p[4][3] = {{0.95047f, 1.0f, 1.08883f},
                     {0.4124f, 0.2126f, 0.0193f},
                     {0.3576f, 0.7152f, 0.1192f},
                     {0.1805f, 0.0722f, 0.9505f}};
    const float expected[4][3] = {{1, 1, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    enc_xyz_to_rgb(&p[0][0], 4);
    for (int i = 0; i < 4; i++) {
        for (int c = 0; c < 3; c++) {
            assert_float_equal(p[i][c], expected[i][c], 5e-4);
        }
    }
}

TEST(test_flip) {
    for (int height = 1; height <= 4; height++) {
        float p[4 * 2 * 3];
        for (int i = 0; i < height * 6; i++) {
            p[i] = (float)i;
        }
        enc_flip_rows(p, 2, height);
        for (int i = 0; i < height * 6; i++) {
            assert_float_equal(p[i], (height - 1 - i / 6) * 6 + i % 6, 0);
        }
    }
}

TEST(test_resize_blocks) {
    float in[4 * 6 * 3], out[2 * 2 * 3];
    for (int row = 0; row < 4; row++) {
        for (int x = 0; x < 6; x++) {
            for (int c = 0; c < 3; c++) {
                in[(row * 6 + x) * 3 + c] = (float)(100 * row + 10 * x + c);
            }
        }
    }
    assert_int_equal(enc_resize_area(in, 6, 4, out, 2, 2), BTF_OK);
    for (int row = 0; row < 2; row++) {
        for (int x = 0; x < 2; x++) {
            for (int c = 0; c < 3; c++) {
                assert_float_equal(out[(row * 2 + x) * 3 + c], 100 * (2 * row + 0.5) + 10 * (3 * x + 1) + c,
                                   1e-4);
            }
        }
    }
}

TEST(test_resize_fractions) {
    /* 3 to 2: halves of the middle pixel go either way */
    const float in[9] = {1, 0, 3, 2, 6, 3, 4, 0, 9};
    float out[6];
    assert_int_equal(enc_resize_area(in, 3, 1, out, 2, 1), BTF_OK);
    assert_float_equal(out[0], (1 * 2 + 2) / 3.0, 1e-6);
    assert_float_equal(out[1], (0 * 2 + 6) / 3.0, 1e-6);
    assert_float_equal(out[3], (4 * 2 + 2) / 3.0, 1e-6);
    assert_float_equal(out[5], (9 * 2 + 3) / 3.0, 1e-6);
}

/* Any size to any: a constant stays itself, the mean is kept. */
TEST(test_resize_mean) {
    const int sizes[][4] = {{7, 5, 3, 4}, {5, 7, 11, 13}, {1, 1, 4, 3}, {16, 9, 1, 1}, {13, 1, 6, 1}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        const int w = sizes[s][0], h = sizes[s][1], ow = sizes[s][2], oh = sizes[s][3];
        float *in = malloc((size_t)(w * h * 3) * sizeof *in),
              *out = malloc((size_t)(ow * oh * 3) * sizeof *out);
        assert_non_null(in);
        assert_non_null(out);
        double mean_in = 0, mean_out = 0;
        for (int i = 0; i < w * h; i++) {
            in[3 * i] = 0.3f;
            in[3 * i + 1] = (float)((i * 37) % 101);
            in[3 * i + 2] = 0.0f;
            mean_in += in[3 * i + 1] / (double)(w * h);
        }
        assert_int_equal(enc_resize_area(in, w, h, out, ow, oh), BTF_OK);
        for (int i = 0; i < ow * oh; i++) {
            assert_true(out[3 * i] == 0.3f);
            assert_true(out[3 * i + 2] == 0.0f);
            mean_out += out[3 * i + 1] / (double)(ow * oh);
        }
        assert_float_equal(mean_in, mean_out, 1e-5 * mean_in + 1e-9);
        free(in);
        free(out);
    }
}

RUN_TESTS(NULL, NULL)
