/* The reference decoder's stochastic decode: the mean over all choices is the blend, which this file puts together from
 * single neighbours. Compiled with the decoder's sources, whose names are hidden.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reference_assert.h"
#include "tests/support/reference_material.h"
#include "tests/support/test.h"

#include "reference/btf_reference_private.h"

enum { OLD_EFFECTS = BTF_REF_SHADOW | BTF_REF_SHIFT | BTF_REF_HIDDEN | BTF_REF_GAIN | BTF_REF_RESIDUAL };

/** The arguments of a decode. */
typedef struct point {
    float u, v, light[3], view[3];
} point;

static point random_point(uint32_t *random) {
    point p;
    p.u = random_float(random, 0, 1);
    p.v = random_float(random, 0, 1);
    random_direction(random, p.light);
    random_direction(random, p.view);
    return p;
}

static btf_ref_options linear(int filter) {
    return (btf_ref_options){UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, filter};
}

static void blend(const made_all *x, const btf_ref_options *o, int picks, const point *p, float out[3]) {
    btf_ref_evaluate_radiance_blend(&x->m, o, picks, p->u, p->v, p->light, p->view, out);
}

static void choose(const made_all *x, const btf_ref_options *o, int picks, const point *p, uint32_t r0,
                   uint32_t r1, uint32_t r2, float out[3]) {
    const uint32_t random[3] = {r0, r1, r2};
    btf_ref_evaluate_stochastic(&x->m, o, picks, p->u, p->v, p->light, p->view, random, out);
}

static void assert_same(const float rgb[3], const float expected[3]) {
    assert_rgb(rgb, expected[0], expected[1], expected[2]);
}

/** Compares a mean in double, of exact shares, with a result in floats. */
static void assert_mean(const double sum[3], double count, const float expected[3]) {
    for (int c = 0; c < 3; ++c) {
        const double mean = sum[c] / count;
        if (!(fabs(mean - (double)expected[c]) <= 2e-6 * (double)expected[c] + 1e-30)) {
            fail_msg("channel %d: mean %.9g, blend %.9g", c, mean, (double)expected[c]);
        }
    }
}

static void add(double sum[3], const float rgb[3]) {
    for (int c = 0; c < 3; ++c) {
        sum[c] += (double)rgb[c];
    }
}

/** Draws a point at which a single light has all the weight for every neighbouring view; false where it finds none near
 * the rim. */
static bool single_light(const made_all *x, const btf_ref_options *o, point *p, uint32_t *random) {
    for (int i = 0; i < 2000; ++i) {
        int32_t q[2];
        random_direction(random, p->light);
        p->light[2] *= 0.02f;
        const float length = sqrtf(p->light[0] * p->light[0] + p->light[1] * p->light[1]);
        for (int c = 0; c < 2; ++c) {
            p->light[c] /= length > 0.1f ? length : 0.1f;
        }
        btf_ref_project(p->light, q);
        btf_ref_neighbours n = btf_ref_lookup(x->m.light_table, x->m.light_grid, q);
        if ((n.weight[0] == 4096 || n.weight[1] == 4096 || n.weight[2] == 4096) && p->light[2] > 0x1p-20f) {
            return !(o->effects & x->m.effects & BTF_REF_GLOSS);
        }
    }
    return false;
}

/* --- the random numbers --- */

TEST(test_random) {
    static const uint32_t counters[3][3] = {{0, 0, 0}, {1, 2, 3}, {0xFFFFFFFF, 0x80000000, 12345}};
    static const uint32_t expected[3][3] = {{0x9BAFD7C6, 0xA8E88A6B, 0x3F15482C},
                                            {0xFA9F79A6, 0x48F2F44C, 0x596F5AB1},
                                            {0xAE605ACB, 0xC61ABBD5, 0x00D06099}};
    for (int i = 0; i < 3; ++i) {
        uint32_t r[3];
        btf_ref_random(counters[i], r);
        assert_memory_equal(r, expected[i], sizeof r);
    }
}

/* --- where nothing is to be chosen --- */

/** At sampled directions with one texel, and with nearest directions, every choice is the decode of section 9, bit for
 * bit. */
TEST(test_one_choice) {
    static made_all x;
    uint32_t random = 3;
    for (uint32_t seed = 1; seed <= 60; ++seed) {
        make_all(seed, 0, &x);
        for (int i = 0; i < 100; ++i) {
            point p = random_point(&random);
            btf_ref_options o = linear(BTF_REF_TEXEL);
            o.interpolation = BTF_REF_NEAREST;
            o.effects = random_below(&random, 2) ? UINT32_MAX : random_below(&random, 128);
            for (int picks = 1; picks <= 3; ++picks) {
                float all[3], one[3], mean[3];
                btf_ref_evaluate(&x.m, &o, p.u, p.v, p.light, p.view, all);
                choose(&x, &o, picks, &p, random_bits(&random), random_bits(&random), random_bits(&random),
                       one);
                blend(&x, &o, picks, &p, mean);
                assert_same(one, all);
                assert_same(mean, all);
            }
        }
    }
}

/** Below the horizon there is nothing. */
TEST(test_horizon) {
    static made_all x;
    uint32_t random = 5;
    make_all(1, 0, &x);
    point p = random_point(&random);
    p.view[2] = -p.view[2];
    const btf_ref_options o = linear(BTF_REF_TEXEL);
    float rgb[3] = {1, 1, 1};
    choose(&x, &o, 3, &p, 1, 2, 3, rgb);
    assert_rgb(rgb, 0, 0, 0);
    rgb[0] = 1;
    blend(&x, &o, 3, &p, rgb);
    assert_rgb(rgb, 0, 0, 0);
}

/* --- the blend, put together --- */

/** Without relief and gloss and with one texel, the blend is that of the radiance of single views and lights, which
 * another entry point decodes. */
TEST_OF_NUMBERS(test_blend_of_neighbours) {
    static made_all x;
    uint32_t random = 7;
    for (uint32_t seed = 1; seed <= 60; ++seed) {
        make_all(seed, 0, &x);
        for (int i = 0; i < 100; ++i) {
            point p = random_point(&random);
            btf_ref_options o = linear(BTF_REF_TEXEL);
            o.effects = random_below(&random, 2) ? OLD_EFFECTS : random_below(&random, 32);
            int32_t q[2];
            btf_ref_project(p.view, q);
            btf_ref_neighbours views = btf_ref_lookup(x.m.view_table, x.m.view_grid, q);
            btf_ref_project(p.light, q);
            btf_ref_neighbours lights = btf_ref_lookup(x.m.light_table, x.m.light_grid, q);
            const uint32_t column = btf_ref_coordinate(p.u, MADE_WIDTH) >> 18,
                           row = MADE_HEIGHT - 1 - (btf_ref_coordinate(p.v, MADE_HEIGHT) >> 18);
            float by_view[3] = {0, 0, 0}, by_both[3] = {0, 0, 0}, expected[3];
            for (int a = 0; a < 3; ++a) {
                const btf_ref_neighbours view = {{views.index[a], 0, 0}, {4096, 0, 0}};
                const float share = (float)views.weight[a] * 0x1p-12f;
                float lit[3] = {0, 0, 0};
                for (int b = 0; b < 3; ++b) {
                    const btf_ref_neighbours light = {{lights.index[b], 0, 0}, {4096, 0, 0}};
                    const float weight = (float)lights.weight[b] * 0x1p-12f;
                    btf_ref_evaluate_neighbours(&x.m, &o, column, row, &light, &view, p.light, p.view,
                                                expected);
                    for (int c = 0; c < 3; ++c) {
                        const float term = expected[c] * weight;
                        lit[c] = lit[c] + term;
                    }
                }
                btf_ref_evaluate_neighbours(&x.m, &o, column, row, &lights, &view, p.light, p.view,
                                            expected);
                for (int c = 0; c < 3; ++c) {
                    const float one = expected[c] * share, both = lit[c] * share;
                    by_view[c] = by_view[c] + one;
                    by_both[c] = by_both[c] + both;
                }
            }
            blend(&x, &o, BTF_REF_PICK_VIEW, &p, expected);
            assert_same(expected, by_view);
            blend(&x, &o, BTF_REF_PICK_LIGHT, &p, expected);
            assert_same(expected, by_both);
            blend(&x, &o, BTF_REF_PICK_ALL, &p, expected);
            assert_same(expected, by_both);
        }
    }
}

/** Where views are blended as radiance and only views are picked, the blend is the decode of section 9, with all
 * effects and filters, up to the order of additions. */
TEST_OF_NUMBERS(test_blend_of_radiance) {
    static made_all x;
    uint32_t random = 29;
    double worst = 0;
    int compared = 0;
    for (uint32_t seed = 1; seed <= 60; ++seed) {
        make_all(seed, 0, &x);
        for (int i = 0; i < 100 && x.m.blend == BTF_REF_BLEND_RADIANCE; ++i, ++compared) {
            const point p = random_point(&random);
            btf_ref_options o = linear(i % 3);
            o.interpolation = i % 5 == 0 ? BTF_REF_NEAREST : BTF_REF_LINEAR;
            float all[3], mean[3];
            btf_ref_evaluate(&x.m, &o, p.u, p.v, p.light, p.view, all);
            blend(&x, &o, BTF_REF_PICK_VIEW, &p, mean);
            for (int c = 0; c < 3; ++c) {
                worst = fmax(worst, fabs((double)mean[c] - (double)all[c]) / (0x1p-60 + (double)all[c]));
            }
        }
    }
    print_message("%d blends in another order: %.3g of the value\n", compared, worst);
    assert_true(compared >= 2000);
    assert_true(worst <= 1e-6); /* a dozen roundings */
}

/* --- the mean of all choices --- */

/** All 4096 numbers that pick a view. */
TEST_OF_NUMBERS(test_mean_over_views) {
    static made_all x;
    uint32_t random = 11;
    for (uint32_t seed = 1; seed <= 40; ++seed) {
        make_all(seed, 0, &x);
        for (int i = 0; i < 6; ++i) {
            const point p = random_point(&random);
            const btf_ref_options o = linear(i % 3);
            double sum[3] = {0, 0, 0};
            float rgb[3];
            for (uint32_t n = 0; n < 4096; ++n) {
                choose(&x, &o, BTF_REF_PICK_VIEW, &p, n << 20 | random_bits(&random) >> 12,
                       random_bits(&random), random_bits(&random), rgb);
                add(sum, rgb);
            }
            blend(&x, &o, BTF_REF_PICK_VIEW, &p, rgb);
            assert_mean(sum, 4096, rgb);
        }
    }
}

/** All numbers that pick a light, at a sampled view. */
TEST_OF_NUMBERS(test_mean_over_lights) {
    static made_all x;
    uint32_t random = 13;
    for (uint32_t seed = 1; seed <= 40; ++seed) {
        make_all(seed, 0, &x);
        for (int i = 0; i < 6; ++i) {
            point p = random_point(&random);
            const btf_ref_options o = linear(i % 3);
            memcpy(p.view, x.relief.view_vectors + 4 * random_below(&random, MADE_VIEWS), sizeof p.view);
            double sum[3] = {0, 0, 0};
            float rgb[3];
            for (uint32_t n = 0; n < 4096; ++n) {
                choose(&x, &o, BTF_REF_PICK_LIGHT, &p, random_bits(&random),
                       n << 20 | random_bits(&random) >> 12, random_bits(&random), rgb);
                add(sum, rgb);
            }
            blend(&x, &o, BTF_REF_PICK_LIGHT, &p, rgb);
            assert_mean(sum, 4096, rgb);
        }
    }
}

/** All numbers that pick a texel, under one light and at a sampled view; then all that pick a level, with one texel. */
TEST_OF_NUMBERS(test_mean_over_texels_and_levels) {
    static made_all x[2];
    uint32_t random = 17;
    int seen = 0;
    for (uint32_t seed = 1; seed <= 12; ++seed) {
        make_all(seed, 0, &x[0]);
        make_all(seed + 100, 0, &x[1]);
        point p = random_point(&random);
        btf_ref_options o = linear(1 + (int)seed % 2);
        o.effects &= ~(uint32_t)BTF_REF_GLOSS;
        memcpy(p.view, x[0].relief.view_vectors + 4 * random_below(&random, MADE_VIEWS), sizeof p.view);
        if (!single_light(&x[0], &o, &p, &random)) {
            continue;
        }
        ++seen;
        double sum[3] = {0, 0, 0};
        float rgb[3];
        for (uint32_t n = 0; n < 65536; ++n) {
            choose(&x[0], &o, BTF_REF_PICK_ALL, &p, random_bits(&random), random_bits(&random),
                   n << 16 | random_bits(&random) >> 16, rgb);
            add(sum, rgb);
        }
        blend(&x[0], &o, BTF_REF_PICK_ALL, &p, rgb);
        assert_mean(sum, 65536, rgb);

        const btf_ref_material levels[2] = {x[0].m, x[1].m};
        const float level = random_float(&random, 0, 1);
        o.filter = BTF_REF_TEXEL;
        o.interpolation = BTF_REF_NEAREST;
        sum[0] = sum[1] = sum[2] = 0;
        for (uint32_t n = 0; n < 256; ++n) {
            const uint32_t r[3] = {random_bits(&random), random_bits(&random),
                                   random_bits(&random) << 16 | n << 8 | random_below(&random, 256)};
            btf_ref_evaluate_stochastic_between(levels, 2, &o, BTF_REF_PICK_ALL, level, p.u, p.v, p.light,
                                                p.view, r, rgb);
            add(sum, rgb);
        }
        btf_ref_evaluate_radiance_blend_between(levels, 2, &o, BTF_REF_PICK_ALL, level, p.u, p.v, p.light,
                                                p.view, rgb);
        assert_mean(sum, 256, rgb);
    }
    assert_true(seen >= 6);
}

/** Everything picked at once, with random numbers of the hash: the mean is within 4 standard errors. */
TEST_OF_NUMBERS(test_mean_of_samples) {
    enum { SAMPLES = 20000 };
    static made_all x;
    uint32_t random = 19;
    double worst = 0;
    for (uint32_t seed = 1; seed <= 20; ++seed) {
        make_all(seed, 0, &x);
        const point p = random_point(&random);
        const btf_ref_options o = linear((int)seed % 3);
        const int picks = 2 + (int)seed / 3 % 2;
        double sum[3] = {0, 0, 0}, squares[3] = {0, 0, 0};
        float rgb[3];
        for (uint32_t n = 0; n < SAMPLES; ++n) {
            const uint32_t counter[3] = {seed, 7, n};
            uint32_t r[3];
            btf_ref_random(counter, r);
            choose(&x, &o, picks, &p, r[0], r[1], r[2], rgb);
            add(sum, rgb);
            for (int c = 0; c < 3; ++c) {
                squares[c] += (double)rgb[c] * (double)rgb[c];
            }
        }
        blend(&x, &o, picks, &p, rgb);
        for (int c = 0; c < 3; ++c) {
            const double mean = sum[c] / SAMPLES,
                         error = sqrt(fmax(squares[c] / SAMPLES - mean * mean, 0) / SAMPLES) + 2e-6 * mean +
                                 1e-30;
            worst = fmax(worst, fabs(mean - (double)rgb[c]) / error);
        }
    }
    print_message("means of %d: %.2f standard errors at most, of 60\n", SAMPLES, worst);
    assert_true(worst <= 4);
}

/* --- levels --- */

/** Levels that are NaN or negative, whole, or beyond the last. */
TEST(test_levels) {
    static made_all x[3];
    static const struct {
        float level;
        int is;
    } cases[] = {{0, 0},    {-0.0f, 0}, {-1, 0},       {1, 1},         {2, 2},      {2.5f, 2},
                 {1e9f, 2}, {NAN, 0},   {INFINITY, 2}, {-INFINITY, 0}, {1.003f, 1}, {0x1p-140f, 0}};
    uint32_t random = 23;
    for (uint32_t i = 0; i < 3; ++i) {
        make_all(i + 1, 0, &x[i]);
    }
    const btf_ref_material levels[3] = {x[0].m, x[1].m, x[2].m};
    const btf_ref_options o = linear(BTF_REF_BILINEAR);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const point p = random_point(&random);
        const uint32_t r[3] = {random_bits(&random), random_bits(&random), random_bits(&random)};
        float rgb[3], expected[3];
        btf_ref_evaluate_stochastic_between(levels, 3, &o, 3, cases[i].level, p.u, p.v, p.light, p.view, r,
                                            rgb);
        btf_ref_evaluate_stochastic(&levels[cases[i].is], &o, 3, p.u, p.v, p.light, p.view, r, expected);
        assert_same(rgb, expected);
        btf_ref_evaluate_radiance_blend_between(levels, 3, &o, 3, cases[i].level, p.u, p.v, p.light, p.view,
                                                rgb);
        btf_ref_evaluate_radiance_blend(&levels[cases[i].is], &o, 3, p.u, p.v, p.light, p.view, expected);
        assert_same(rgb, expected);
    }
}

RUN_TESTS(NULL, NULL)
