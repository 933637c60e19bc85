/* The reference decoder, whole evaluations of small materials worked out by hand: model, shadow, shift, views,
 * clamps, horizon (FORMAT.md, section 9).
 *
 * SPDX-License-Identifier: MIT
 */
#include "hand_material.h"
#include "reference_assert.h"
#include "tests/support/test.h"

TEST(test_lambertian) {
    float light[3] = {0.6f, 0.0f, 0.8f}, rgb[3];
    for (int tight = 0; tight < 2; ++tight) {
        hand_fixture *f = hand_material(tight, 0);
        hand_set_lambertian(f);
        float value = hand_albedo(3, 2) * 0.8f;
        btf_ref_evaluate_texel(&f->m, &f->o, 3, 2, light, hand_pole, rgb);
        assert_rgb(rgb, value, 0.5f * value, 0.25f * value);
        f->m.radiance_scale = 4.0f;
        btf_ref_evaluate_texel(&f->m, &f->o, 3, 2, light, hand_pole, rgb);
        assert_rgb(rgb, 4 * value, 2 * value, value);

        /* sqrt: y = albedo * sqrt(l.z), L = y * y; the root of 1/4 is exact */
        f->m.domain_sqrt = 1;
        f->m.radiance_scale = 1.0f;
        float low[3] = {0.9f, 0.0f, 0.25f}, y = hand_albedo(3, 2) * 0.5f;
        btf_ref_evaluate_texel(&f->m, &f->o, 3, 2, low, hand_pole, rgb);
        assert_rgb(rgb, y * y, 0.25f * (y * y), 0.0625f * (y * y));
    }
}

TEST(test_lobes) {
    float l[3] = {0.5f, 0.0f, 0.5f}, v[3] = {-0.5f, 0.25f, 1.0f}, rgb[3];
    hand_fixture *f = hand_material(1, 0);
    f->m.lobes = 2;
    float *colour = hand_parameter(f, 0, 0, 0), *first = hand_parameter(f, 1, 0, 0),
          *second = hand_parameter(f, 2, 0, 0);
    /* P = (-1/4, 0, 1/2): b = 1/4 + 0 + 1/4 = 1/2, cubed 1/8; the second is below the horizon */
    colour[0] = 1.0f, colour[1] = 2.0f, colour[2] = 3.0f, colour[3] = 0.5f;
    first[0] = -1.0f, first[1] = 7.0f, first[2] = 0.5f, first[3] = 3.0f;
    second[0] = 1.0f, second[1] = -1.0f, second[2] = 0.25f, second[3] = 2.0f;
    btf_ref_evaluate_texel(&f->m, &f->o, 0, 0, l, v, rgb);
    assert_rgb(rgb, 0.625f * 0.5f, 1.25f * 0.5f, 1.875f * 0.5f);

    /* the same lobes with colours: numbers 0..2 diffuse, 3..5 and 6..8 weights; lobes in layers 3 and 4 */
    f->m.colour = BTF_REF_RGB;
    memset(f->s.sbrdf, 0, sizeof f->s.sbrdf);
    static const float numbers[9] = {0.5f, 0.25f, 0.125f, 8.0f, 16.0f, 32.0f, 99.0f, 99.0f, 99.0f};
    for (uint32_t i = 0; i < 9; ++i) {
        hand_parameter(f, i / 4, 0, 0)[i % 4] = numbers[i];
    }
    first = hand_parameter(f, 3, 0, 0), second = hand_parameter(f, 4, 0, 0);
    first[0] = -1.0f, first[1] = 7.0f, first[2] = 0.5f, first[3] = 3.0f;
    second[0] = 1.0f, second[1] = -1.0f, second[2] = 0.25f, second[3] = 2.0f;
    btf_ref_evaluate_texel(&f->m, &f->o, 0, 0, l, v, rgb);
    assert_rgb(rgb, (0.5f + 1) * 0.5f, (0.25f + 2) * 0.5f, (0.125f + 4) * 0.5f);

    /* as halves */
    f->m.half_float = 1;
    f->m.sbrdf = f->s.sbrdf_half;
    memset(f->s.sbrdf_half, 0, sizeof f->s.sbrdf_half);
    f->s.sbrdf_half[0] = 0x3C00, f->s.sbrdf_half[1] = 0xBC00, f->s.sbrdf_half[2] = 1; /* 1, -1, 2^-24 */
    btf_ref_evaluate_texel(&f->m, &f->o, 0, 0, l, v, rgb);
    assert_rgb(rgb, 0.5f, 0.0f, 0x1p-25f);

    /* negative lobes and weights must not give radiance */
    f->m.half_float = 0;
    f->m.sbrdf = f->s.sbrdf;
    hand_parameter(f, 0, 0, 0)[3] = -1000.0f;
    btf_ref_evaluate_texel(&f->m, &f->o, 0, 0, l, v, rgb);
    assert_bits(rgb[0], 0.0f);
}

TEST(test_shadow) {
    float rgb[3];
    for (int tight = 0; tight < 2; ++tight) {
        hand_fixture *f = hand_material(tight, BTF_REF_SHADOW);
        hand_set_lambertian(f);
        f->m.shadow_scale = 0x1p-7f;
        hand_set_shadow(f, 4, 1, 0, 128);
        hand_set_shadow(f, 4, 1, 1, 64);
        hand_set_shadow(f, 4, 1, 2, 255);
        float albedo = hand_albedo(4, 1);
        hand_evaluate(f, 4, 1, 0, 0, hand_pole, hand_pole, rgb);
        assert_rgb(rgb, albedo, 0.5f * albedo, 0.25f * albedo);
        hand_evaluate(f, 4, 1, 1, 0, hand_pole, hand_pole, rgb);
        assert_bits(rgb[0], 0.5f * albedo);
        hand_evaluate(f, 4, 1, 3, 0, hand_pole, hand_pole, rgb);
        assert_bits(rgb[0], 0.0f);

        /* three lights: (1024 * 128 + 2048 * 64 + 1024 * 255) / 4096 = 127.75 */
        f->o.interpolation = BTF_REF_LINEAR;
        btf_ref_neighbours lights = {{0, 1, 2}, {1024, 2048, 1024}}, views = {{0, 0, 0}, {4096, 0, 0}};
        btf_ref_evaluate_neighbours(&f->m, &f->o, 4, 1, &lights, &views, hand_pole, hand_pole, rgb);
        assert_bits(rgb[0], albedo * 0.998046875f);
        f->o.interpolation = BTF_REF_NEAREST;
        btf_ref_evaluate_neighbours(&f->m, &f->o, 4, 1, &lights, &views, hand_pole, hand_pole, rgb);
        assert_bits(rgb[0], 0.5f * albedo);

        f->o.effects = 0;
        hand_evaluate(f, 4, 1, 3, 0, hand_pole, hand_pole, rgb);
        assert_bits(rgb[0], albedo);
    }
}

TEST(test_shift_and_gain) {
    float rgb[3];
    for (int tight = 0; tight < 2; ++tight) {
        hand_fixture *f = hand_material(tight, BTF_REF_SHIFT | BTF_REF_GAIN | BTF_REF_SHADOW);
        hand_set_lambertian(f);
        f->m.gain_scale = 0x1p-7f;
        f->m.shadow_scale = 0x1p-7f;
        for (uint32_t row = 0; row < MADE_HEIGHT; ++row) {
            for (uint32_t column = 0; column < MADE_WIDTH; ++column) {
                hand_set_shadow(f, column, row, 0, row == 3 ? 64 : 128);
            }
        }

        hand_set_view(f, 1, 1, 4, 128, 2, 1); /* + is to the right and down; the shadow is the source's */
        hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
        assert_bits(rgb[0], hand_albedo(3, 2));
        hand_set_view(f, 1, 1, 4, 192, 2, 2);
        hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
        assert_bits(rgb[0], hand_albedo(3, 3) * 0.5f * 1.5f);
        hand_set_view(f, 1, 1, 4, 1, 256 - 2, 256 - 3); /* wrapped: column 6, row 3 */
        hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
        assert_bits(rgb[0], hand_albedo(6, 3) * 0.5f * 0x1p-7f);
        hand_set_view(f, 1, 1, 4, 255, 127,
                      128); /* 1 + 127 = 128 = 18 * 7 + 2; 1 - 128 = -127 = -26 * 5 + 3 */
        hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
        assert_bits(rgb[0], hand_albedo(2, 3) * 0.5f * (255 * 0x1p-7f));

        f->o.effects = BTF_REF_SHADOW | BTF_REF_SHIFT; /* no gain */
        hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
        assert_bits(rgb[0], hand_albedo(2, 3) * 0.5f);
        f->o.effects = BTF_REF_GAIN | BTF_REF_SHADOW; /* no shift */
        hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
        assert_bits(rgb[0], hand_albedo(1, 1) * (255 * 0x1p-7f));
    }

    /* a file with shifts alone has no gain code: the byte is ignored */
    hand_fixture *f = hand_material(0, BTF_REF_SHIFT);
    hand_set_lambertian(f);
    hand_set_view(f, 1, 1, 4, 0, 2, 1);
    hand_evaluate(f, 1, 1, 0, 4, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], hand_albedo(3, 2));
}

TEST(test_two_views) {
    float rgb[3];
    hand_fixture *f = hand_material(0, BTF_REF_GAIN | BTF_REF_SHIFT | BTF_REF_HIDDEN);
    hand_set_lambertian(f);
    f->m.domain_sqrt = 1; /* each view is squared before they are blended */
    f->m.gain_scale = 0x1p-7f;
    f->m.centre_scale = 0x1p-8f;
    f->o.interpolation = BTF_REF_LINEAR;
    hand_set_view(f, 0, 0, 1, 64, 0, 0);  /* y = 1/2, L = 1/4 */
    hand_set_view(f, 0, 0, 2, 128, 0, 0); /* L = 1 */
    hand_set_view(f, 0, 0, 3, 0, 5, 0);
    hand_set_centre(f, 5, 0, 192, 0, 0); /* L = 9/16 */
    btf_ref_neighbours lights = {{0, 0, 0}, {4096, 0, 0}}, views = {{1, 2, 3}, {1024, 2048, 1024}};
    btf_ref_evaluate_neighbours(&f->m, &f->o, 0, 0, &lights, &views, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], 0.25f * 0.25f + 0.5f + 0.5625f * 0.25f);
}

TEST(test_clamps) {
    float rgb[3];
    hand_fixture *f = hand_material(1, BTF_REF_GAIN);
    float *p = hand_parameter(f, 0, 0, 0);
    hand_set_view(f, 0, 0, 0, 255, 0, 0);
    p[0] = 0x1p24f, p[1] = 0x1p-6f, p[2] = float_of(bits_of(0x1p-6f) - 1), p[3] = 0x1p-24f;
    f->o.effects = 0;
    hand_evaluate(f, 0, 0, 0, 0, hand_pole, hand_pole, rgb);
    assert_rgb(rgb, 1.0f, 0x1p-30f, 0.0f); /* 2^-30 is kept, less is not */
    p[3] = 0x1p24f;
    hand_evaluate(f, 0, 0, 0, 0, hand_pole, hand_pole, rgb);
    assert_rgb(rgb, 0x1p32f, 0x1p18f, float_of(bits_of(0x1p18f) - 1));
    f->m.domain_sqrt = 1;
    hand_evaluate(f, 0, 0, 0, 0, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], 0x1p64f);

    /* the largest of everything overflows before it is clamped */
    f->m.effects |= BTF_REF_SHADOW;
    f->o.effects = UINT32_MAX;
    f->m.lobes = 4;
    for (uint32_t layer = 1; layer <= 4; ++layer) {
        float *lobe = hand_parameter(f, layer, 0, 0);
        lobe[0] = lobe[1] = lobe[2] = lobe[3] = 0x1p24f;
    }
    hand_set_shadow(f, 0, 0, 0, 255);
    f->m.shadow_scale = f->m.gain_scale = f->m.radiance_scale = 0x1p24f;
    float two[3] = {2.0f, 2.0f, 2.0f};
    hand_evaluate(f, 0, 0, 0, 0, two, two, rgb);
    assert_bits(rgb[0], 0x1p88f);
}

TEST(test_horizon) {
    hand_fixture *f = hand_material(0, 0);
    hand_set_lambertian(f);
    static const uint32_t bad[] = {
        0x7FC00000u, 0xFFC00000u, 0x7F800001u, 0x7F800000u,
        0xFF800000u, 0x40000001u, 0xC0000001u, 0x7F7FFFFFu,
    };
    static const float low[] = {0.0f, -0.0f, -1.0f, -2.0f, 0x1p-149f, 0x1p-126f};
    const float below = float_of(0x337FFFFFu); /* the float below 2^-24 */
    for (int which = 0; which < 2; ++which) {
        for (int i = 0; i < 3; ++i) {
            for (size_t k = 0; k < sizeof bad / sizeof *bad + sizeof low / sizeof *low + 1; ++k) {
                float d[2][3] = {{0, 0, 1}, {0, 0, 1}}, rgb[3] = {7, 7, 7};
                size_t n_bad = sizeof bad / sizeof *bad;
                if (k < n_bad) {
                    d[which][i] = float_of(bad[k]);
                } else {
                    d[which][i] = k - n_bad < sizeof low / sizeof *low ? low[k - n_bad] : below;
                }
                btf_ref_evaluate_texel(&f->m, &f->o, 0, 0, d[0], d[1], rgb);
                bool dark = k < n_bad || i == 2;
                assert_bits(rgb[0], dark ? 0.0f : 1.0f);
                btf_ref_evaluate(&f->m, &f->o, 0.01f, 0.99f, d[0], d[1], rgb);
                assert_bits(rgb[0], dark ? 0.0f : 1.0f);
                hand_evaluate(f, 0, 0, 0, 0, d[0], d[1], rgb);
                assert_bits(rgb[0], dark ? 0.0f : 1.0f);
            }
        }
    }
    float rgb[3], grazing[3] = {-2.0f, 2.0f, 0x1p-24f};
    btf_ref_evaluate_texel(&f->m, &f->o, 0, 0, grazing, grazing, rgb);
    assert_bits(rgb[0], 0x1p-24f);
}

RUN_TESTS(NULL, NULL)
