/* The reference decoder, sums worked out by hand: the residual, and the filter between texels.
 *
 * SPDX-License-Identifier: MIT
 */
#include "hand_material.h"
#include "reference_assert.h"
#include "tests/support/test.h"

/** Sets V_j(view, light) of all channels: v, 2 v, -v. */
static void set_v(hand_fixture *f, uint32_t j, uint32_t view, uint32_t light, int v) {
    static const int factors[3] = {1, 2, -1};
    for (uint32_t c = 0; c < 3; ++c) {
        uint32_t layer = 3 * (j / 4) + c;
        f->s.residual_directions[4 * ((layer * MADE_VIEWS + view) * MADE_LIGHTS + light) + j % 4] =
            (int8_t)(v * factors[c]);
    }
}

static void set_u(hand_fixture *f, uint32_t j, uint32_t column, uint32_t row, int u) {
    f->s.residual_texels[4 * ((j / 4 * MADE_HEIGHT + row) * MADE_WIDTH + column) + j % 4] = (int8_t)u;
}

TEST(test_residual) {
    float light[3] = {0.0f, 0.0f, 0.5f}, rgb[3];
    hand_fixture *f = hand_material(0, BTF_REF_RESIDUAL | BTF_REF_SHIFT);
    f->m.components = 6;
    f->s.residual_scales[0] = 0x1p-10f;
    f->s.residual_scales[5] = -0x1p-8f;
    hand_set_view(f, 1, 2, 6, 128, 1, 0); /* source (2, 2) */
    set_u(f, 0, 2, 2, 100);
    set_u(f, 5, 2, 2, -20);
    set_v(f, 0, 6, 4, 50);
    set_v(f, 5, 6, 4, 10);
    float *p = hand_parameter(f, 0, 2, 2);
    p[0] = p[1] = p[2] = 1.0f, p[3] = 1.0f;
    /* r = 100 * 50 / 1024 + 20 * 10 / 256 = 5000 / 1024 + 800 / 1024 = 5800 / 1024; cosine 1/2 */
    hand_evaluate(f, 1, 2, 4, 6, light, hand_pole, rgb);
    assert_rgb(rgb, (1 + 5800.0f / 1024) / 2, (1 + 11600.0f / 1024) / 2, 0.0f); /* 1 - 5800 / 1024 < 0 */
    f->o.components = 5;                                                        /* as many as are wanted */
    hand_evaluate(f, 1, 2, 4, 6, light, hand_pole, rgb);
    assert_bits(rgb[0], (1 + 5000.0f / 1024) / 2);
    f->o.components = 0;
    hand_evaluate(f, 1, 2, 4, 6, light, hand_pole, rgb);
    assert_rgb(rgb, 0.5f, 0.5f, 0.5f);
    f->o.components = UINT32_MAX;
    f->o.effects = BTF_REF_SHIFT;
    hand_evaluate(f, 1, 2, 4, 6, light, hand_pole, rgb);
    assert_rgb(rgb, 0.5f, 0.5f, 0.5f);

    /* two lights, 3/4 and 1/4; component 5 has light 4 alone */
    f->o.effects = UINT32_MAX;
    f->o.interpolation = BTF_REF_LINEAR;
    set_v(f, 0, 6, 1, 30);
    btf_ref_neighbours lights = {{4, 1, 0}, {3072, 1024, 0}}, views = {{6, 0, 0}, {4096, 0, 0}};
    btf_ref_evaluate_neighbours(&f->m, &f->o, 1, 2, &lights, &views, light, hand_pole, rgb);
    assert_bits(rgb[0], (1 + 4500.0f / 1024 + 600.0f / 1024) / 2);

    /* without an SBRDF: the residual alone, and nothing without it */
    f->m.colour = BTF_REF_NONE;
    f->m.sbrdf = NULL;
    f->m.lobes = 0;
    hand_evaluate(f, 1, 2, 4, 6, light, hand_pole, rgb);
    assert_rgb(rgb, 5800.0f / 2048, 11600.0f / 2048, 0.0f);
    f->o.effects = BTF_REF_SHIFT;
    hand_evaluate(f, 1, 2, 4, 6, light, hand_pole, rgb);
    assert_rgb(rgb, 0.0f, 0.0f, 0.0f);
}

TEST(test_filter) {
    hand_fixture *f = hand_material(0, 0);
    /* 4 x 4 of the 7 x 5: powers of two, so that u = (c + 0.5) / W is exact */
    f->m.width = f->m.height = 4;
    for (uint32_t i = 0; i < 16; ++i) {
        f->s.sbrdf[4 * i] = 1.0f, f->s.sbrdf[4 * i + 3] = (float)(1 + i * i);
    }
    float rgb[3], texel[3];
    for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) {
            float u = ((float)column + 0.5f) / 4, v = 1 - ((float)row + 0.5f) / 4;
            btf_ref_evaluate_texel(&f->m, &f->o, (uint32_t)column, (uint32_t)row, hand_pole, hand_pole,
                                   texel);
            assert_bits(texel[0], (float)(1 + (4 * row + column) * (4 * row + column)));
            for (int filter = 0; filter < 2; ++filter) {
                f->o.filter = filter;
                btf_ref_evaluate(&f->m, &f->o, u, v, hand_pole, hand_pole, rgb);
                assert_bits(rgb[0], texel[0]);
                btf_ref_evaluate(&f->m, &f->o, u - 3, v + 17, hand_pole, hand_pole, rgb);
                assert_bits(rgb[0], texel[0]);
            }
        }
    }
    /* a quarter of a texel right of (3, 0), half a texel up: wraps both ways. Texels 3, 0, 15, 12 */
    f->o.filter = BTF_REF_BILINEAR;
    btf_ref_evaluate(&f->m, &f->o, 3.75f / 4, 1.0f, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], (10 * 0.75f + 1 * 0.25f) / 2 + (226 * 0.75f + 145 * 0.25f) / 2);
    f->o.filter = BTF_REF_TEXEL;
    btf_ref_evaluate(&f->m, &f->o, 0.0f, 0.0f, hand_pole, hand_pole, rgb); /* the lower left corner */
    assert_bits(rgb[0], 145.0f);
    btf_ref_evaluate(&f->m, &f->o, NAN, INFINITY, hand_pole, hand_pole, rgb);
    assert_bits(rgb[0], 145.0f);
    btf_ref_evaluate(&f->m, &f->o, 0.0f, -1e-30f, hand_pole, hand_pole, rgb); /* just below: the top row */
    assert_bits(rgb[0], 1.0f);
}

RUN_TESTS(NULL, NULL)
