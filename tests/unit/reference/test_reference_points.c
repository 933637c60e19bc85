/* The reference decoder, points worked out by hand: packed shifts and gains, lists of a texel, hidden points and
 * their centres.
 *
 * SPDX-License-Identifier: MIT
 */
#include "hand_material.h"
#include "reference_assert.h"
#include "tests/support/test.h"

/** Columns and rows from -32, a code of the gain, as section 3 packs them. */
static void set_point(hand_fixture *f, uint32_t column, uint32_t row, uint32_t view, int columns, int rows,
                      int code) {
    uint8_t *bytes = f->s.shift + 2 * ((view * MADE_HEIGHT + row) * MADE_WIDTH + column);
    int p = columns + 32 + 64 * (rows + 32) + 4096 * code;
    bytes[0] = (uint8_t)(p % 256);
    bytes[1] = (uint8_t)(p / 256);
}

TEST(test_packed_points) {
    float rgb[3];
    hand_fixture *f = hand_material(1, BTF_REF_SHIFT | BTF_REF_GAIN);
    hand_set_lambertian(f);
    make_points(1, 0, &f->s, &f->m);
    f->m.gain_base = 0.25f;
    f->m.gain_step = 0.125f;
    f->m.gain_scale = 77; /* not read */
    set_point(f, 1, 1, 4, 2, 1, 6);
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(3, 2));
    set_point(f, 1, 1, 4, -2, -3, 0); /* code 0 hides nothing; wrapped: column 6, row 3 */
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(6, 3) * 0.25f);
    set_point(f, 1, 1, 4, 31, -32, 15); /* 1 + 31 = 32 = 4 * 7 + 4; 1 - 32 = -31 = -7 * 5 + 4 */
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(4, 4) * 2.125f);
    set_point(f, 1, 1, 4, -32, 31, 15); /* -31 = -5 * 7 + 4; 32 = 6 * 5 + 2 */
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(4, 2) * 2.125f);

    f->o.effects = BTF_REF_SHIFT; /* no gain */
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(4, 2));
    f->o.effects = BTF_REF_GAIN; /* no shift */
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(1, 1) * 2.125f);
    f->o.effects = 0;
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(1, 1));

    /* one multiplication, then one addition, each rounded */
    f->o.effects = UINT32_MAX;
    f->m.gain_base = 1.0f;
    f->m.gain_step =
        0x1.555556p-26f; /* 3 of them are 2^-24 rounded, and more than that before: a tie, not 1 + 2^-23 */
    set_point(f, 1, 1, 4, 0, 0, 3);
    hand_parameter(f, 0, 1, 1)[3] = 1.0f;
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], 1.0f);
    f->m.gain_base = -1.0f; /* gains may be negative; the result is clamped as always */
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_rgb(rgb, 0, 0, 0);
}

/* A texel's list, and for each view half a byte that names an entry: the lower half for even views. */
TEST(test_lists) {
    static uint8_t indices[MADE_VIEWS * MADE_TEXELS];
    float rgb[3];
    hand_fixture *f = hand_material(1, BTF_REF_SHIFT | BTF_REF_GAIN);
    hand_set_lambertian(f);
    make_points(1, 0, &f->s, &f->m);
    make_lists(1, 1, &indices, &f->s, &f->m);
    f->m.gain_base = 0.25f;
    f->m.gain_step = 0.125f;
    const uint32_t texel = MADE_WIDTH + 1;
    for (int entry = 0; entry < 5; ++entry) { /* set_point's view is an entry here */
        set_point(f, 1, 1, (uint32_t)entry, entry - 1, entry == 4, 2 * entry);
    }
    indices[2 * MADE_TEXELS + texel] = 0x14; /* view 4 has entry 4, view 5 entry 1 */
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(4, 2) * 1.25f);
    hand_evaluate(f, 1, 1, 0, 5, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(1, 1) * 0.5f);
    indices[2 * MADE_TEXELS + texel] = 0x03;
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(3, 1));
    hand_evaluate(f, 1, 1, 0, 5, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(0, 1) * 0.25f);
    indices[2 * MADE_TEXELS + texel + 1] = 0xFF; /* another texel's indices have no effect here */
    f->o.effects = BTF_REF_SHIFT;
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(3, 1));
    f->o.effects = BTF_REF_GAIN;
    hand_evaluate(f, 1, 1, 0, 5, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(1, 1) * 0.25f);
}

TEST(test_hidden) {
    float light[3] = {0.0f, 0.0f, 0.5f}, rgb[3];
    for (int tight = 0; tight < 2; ++tight) {
        for (int domain = 0; domain < 2; ++domain) {
            hand_fixture *f = hand_material(tight, BTF_REF_SHIFT | BTF_REF_GAIN | BTF_REF_HIDDEN);
            hand_set_lambertian(f);
            f->m.domain_sqrt = domain;
            f->m.centre_scale = 0x1p-8f;
            f->m.gain_scale = 0x1p-7f;
            hand_set_centre(f, 120, 3, 128, 64, 255);
            hand_set_centre(f, 120, 4, 64, 64, 1);
            hand_set_view(f, 2, 4, 7, 0, 120, 0);
            hand_evaluate(f, 2, 4, 3, 7, light, hand_pole,
                          rgb); /* squared in both domains; no cosine, no gain */
            assert_rgb(rgb, 0.25f, 0.0625f, 255.0f / 256 * (255.0f / 256));
            f->o.interpolation = BTF_REF_LINEAR;
            btf_ref_neighbours lights = {{3, 4, 0}, {1024, 3072, 0}}, views = {{7, 0, 0}, {4096, 0, 0}};
            btf_ref_evaluate_neighbours(&f->m, &f->o, 2, 4, &lights, &views, light, hand_pole, rgb);
            assert_rgb(rgb, 80.0f / 256 * (80.0f / 256), 0.0625f, 64.5f / 256 * (64.5f / 256));

            /* without hidden: no shift, no gain, whatever the bytes say */
            f->o.effects = BTF_REF_SHIFT | BTF_REF_GAIN;
            float y = hand_albedo(2, 4) * btf_ref_pow(0.5f, domain ? 0.5f : 1.0f);
            hand_evaluate(f, 2, 4, 3, 7, light, hand_pole, rgb);
            assert_bits(rgb[0], domain ? y * y : y);
            f->o.effects = BTF_REF_SHIFT; /* the code still says hidden, so that 120 is no shift */
            hand_evaluate(f, 2, 4, 3, 7, light, hand_pole, rgb);
            assert_bits(rgb[0], domain ? y * y : y);
            f->o.effects = BTF_REF_HIDDEN;
            hand_evaluate(f, 2, 4, 3, 7, light, hand_pole, rgb);
            assert_bits(rgb[0], 0.25f);
        }
    }
}

/** Centre 259 is bytes 3 and 1, the low one first. */
TEST(test_centre_index) {
    static uint8_t centres[4 * 300 * MADE_LIGHTS]; /* one block of 300 rows */
    float rgb[3];
    hand_fixture *f = hand_material(1, BTF_REF_HIDDEN);
    f->m.centres = 300;
    f->m.centre = centres;
    centres[4 * (259 * MADE_LIGHTS + 2)] = 3;
    centres[4 * (259 * MADE_LIGHTS + 2) + 1] = 255;
    hand_set_view(f, 0, 0, 8, 0, 3, 1);
    hand_evaluate(f, 0, 0, 2, 8, hand_pole, hand_pole, rgb);
    assert_rgb(rgb, 9.0f, 65025.0f, 0.0f);
}

RUN_TESTS(NULL, NULL)
