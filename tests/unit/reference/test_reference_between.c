/* The reference decoder between the sampled directions: whole evaluations with relief, gloss and the filter
 * `steep`. Compiled with the decoder's sources, whose names are hidden.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reference_assert.h"
#include "tests/support/reference_material.h"
#include "tests/support/test.h"

#include "reference/btf_reference_private.h"

enum { OLD_EFFECTS = BTF_REF_SHADOW | BTF_REF_SHIFT | BTF_REF_HIDDEN | BTF_REF_GAIN | BTF_REF_RESIDUAL };

static btf_ref_options random_options(uint32_t *random) {
    btf_ref_options o = {.effects = UINT32_MAX, .components = UINT32_MAX};
    if (random_below(random, 2)) {
        o.effects = random_below(random, 128);
    }
    o.interpolation = (int)random_below(random, 2);
    o.filter = (int)random_below(random, 3);
    return o;
}

static btf_ref_neighbours neighbours_of(const uint16_t *table, uint32_t grid, const float direction[3]) {
    int32_t q[2];
    btf_ref_project(direction, q);
    return btf_ref_lookup(table, grid, q);
}

static void assert_same(const float rgb[3], const float expected[3]) {
    assert_rgb(rgb, expected[0], expected[1], expected[2]);
}

/* --- where nothing may change --- */

/** Heights of 0, of a map or of none, leave every texel as it is without relief; filters blend in another
 * order only. */
TEST(test_zero_heights) {
    static made_all x;
    uint32_t random = 3;
    double worst = 0;
    for (uint32_t seed = 1; seed <= 60; ++seed) {
        make_all(seed, seed % 5 == 0, &x);
        x.m.relief_base = 0;
        memset(x.relief.heights, 0, sizeof x.relief.heights);
        for (int i = 0; i < 300; ++i) {
            float l[3], v[3], with[3], without[3];
            btf_ref_options o = random_options(&random), plain = o;
            o.effects |= BTF_REF_RELIEF;
            plain.effects &= ~(uint32_t)BTF_REF_RELIEF;
            random_direction(&random, l);
            random_direction(&random, v);
            float u = random_float(&random, -2, 4), w = random_float(&random, -2, 4);
            btf_ref_evaluate(&x.m, &o, u, w, l, v, with);
            btf_ref_evaluate(&x.m, &plain, u, w, l, v, without);
            if (o.filter == BTF_REF_TEXEL) {
                assert_same(with, without);
            } else if (x.m.blend == BTF_REF_BLEND_RADIANCE) {
                for (int c = 0; c < 3; ++c) {
                    worst = fmax(worst, fabs((double)with[c] - (double)without[c]) /
                                            (0x1p-60 + (double)without[c]));
                }
            }
            uint32_t column = random_below(&random, MADE_WIDTH), row = random_below(&random, MADE_HEIGHT);
            btf_ref_evaluate_texel(&x.m, &o, column, row, l, v, with);
            btf_ref_evaluate_texel(&x.m, &plain, column, row, l, v, without);
            assert_same(with, without);
        }
    }
    print_message("filters in another order: %.3g of the value\n", worst);
    assert_true(worst <= 1e-6); /* a dozen roundings */
}

/** At the sampled views, whatever the heights, relief and gloss change nothing; nor do they where views
 * only differ by what a device may flush to zero. */
TEST(test_sampled_views) {
    static made_all x;
    uint32_t random = 5;
    for (uint32_t seed = 1; seed <= 60; ++seed) {
        make_all(seed, seed % 5 == 0, &x);
        for (int i = 0; i < 300; ++i) {
            float l[3], with[3], without[3];
            btf_ref_options o = random_options(&random), plain = o;
            o.filter = plain.filter = BTF_REF_TEXEL;
            o.effects |= BTF_REF_RELIEF | BTF_REF_GLOSS;
            plain.effects &= OLD_EFFECTS;
            random_direction(&random, l);
            const float *v = x.relief.view_vectors + 4 * random_below(&random, MADE_VIEWS);
            float u = random_float(&random, -2, 4), w = random_float(&random, -2, 4);
            btf_ref_evaluate(&x.m, &o, u, w, l, v, with);
            btf_ref_evaluate(&x.m, &plain, u, w, l, v, without);
            assert_same(with, without);
        }
    }
}

/** Where relief acts on no view, it changes nothing, whatever the heights. */
TEST(test_views_left_alone) {
    static made_all x;
    uint32_t random = 7;
    for (uint32_t seed = 1; seed <= 60; ++seed) {
        make_all(seed, 0, &x);
        for (int a = 0; a < MADE_VIEWS; ++a) {
            x.relief.view_vectors[4 * a + 3] = 0;
        }
        for (int i = 0; i < 100; ++i) {
            float l[3], v[3], with[3], without[3];
            btf_ref_options o = random_options(&random), plain;
            o.filter = BTF_REF_TEXEL;
            plain = o;
            plain.effects &= ~(uint32_t)BTF_REF_RELIEF;
            random_direction(&random, l);
            random_direction(&random, v);
            float u = random_float(&random, -2, 4), w = random_float(&random, -2, 4);
            btf_ref_evaluate(&x.m, &o, u, w, l, v, with);
            btf_ref_evaluate(&x.m, &plain, u, w, l, v, without);
            assert_same(with, without);
        }
    }
}

/* --- the parts put together in double --- */

/** The value of one texel in one view that is blended: radiance before its scale, or the root where roots are blended
 * and radiance is not 0; *out_known false where it may be negative. */
static void blended_value(const made_all *x, const btf_ref_options *o, uint32_t column, uint32_t row,
                          uint32_t view, const btf_ref_neighbours *lights, const float l[3],
                          const float v[3], bool *out_known, double out[3]) {
    btf_ref_neighbours alone = {{view, view, view}, {4096, 0, 0}};
    btf_ref_options plain = *o;
    float rgb[3];
    plain.effects &= OLD_EFFECTS;
    btf_ref_evaluate_neighbours(&x->m, &plain, column, row, lights, &alone, l, v, rgb);
    for (int c = 0; c < 3; ++c) {
        double value = (double)rgb[c] / (double)x->m.radiance_scale;
        bool roots = x->m.blend == BTF_REF_BLEND_ROOTS;
        *out_known = *out_known && !(roots && value == 0);
        out[c] = roots ? sqrt(value) : value;
    }
}

/** Each view with its own lights, at its own texels, blended over texels and then over views, is the
 * result. */
TEST(test_parts) {
    static made_all x;
    uint32_t random = 11, compared = 0, of_roots = 0;
    double worst = 0;
    for (uint32_t seed = 1; seed <= 120; ++seed) {
        make_all(seed, 0, &x);
        for (int i = 0; i < 150; ++i) {
            float l[3], v[3], rgb[3];
            btf_ref_options o = random_options(&random);
            o.effects |= BTF_REF_RELIEF | BTF_REF_GLOSS;
            random_direction(&random, l);
            random_direction(&random, v);
            float u = random_float(&random, -2, 4), w = random_float(&random, -2, 4);
            btf_ref_evaluate(&x.m, &o, u, w, l, v, rgb);

            bool known = true, linear = o.interpolation == BTF_REF_LINEAR;
            btf_ref_neighbours views = neighbours_of(x.m.view_table, x.m.view_grid, v);
            views = linear ? views : btf_ref_nearest(views);
            const int32_t at[2] = {(int32_t)(btf_ref_coordinate(u, MADE_WIDTH) >> 10),
                                   (int32_t)(btf_ref_coordinate(w, MADE_HEIGHT) >> 10)};
            int32_t positions[3][2];
            uint32_t weights[3];
            double sum[3] = {0, 0, 0};
            btf_ref_relief(&x.m, &views, v, linear, at, positions, weights);
            for (int a = 0; a < 3; ++a) {
                int32_t q[2];
                if (weights[a] == 0) {
                    continue;
                }
                btf_ref_gloss(&x.m, views.index[a], l, v, q);
                btf_ref_neighbours lights = btf_ref_lookup(x.m.light_table, x.m.light_grid, q);
                /* texels and weights by hand: centres are half a texel in */
                for (int corner = 0; corner < 4; ++corner) {
                    uint32_t cell[2];
                    double part = 1;
                    for (int k = 0; k < 2; ++k) {
                        double texels = positions[a][k] / 256.0 - (o.filter == BTF_REF_TEXEL ? 0 : 0.5);
                        double f = texels - floor(texels);
                        f = o.filter == BTF_REF_TEXEL   ? 0
                            : o.filter == BTF_REF_STEEP ? fmin(fmax(2 * f - 0.5, 0), 1)
                                                        : f;
                        int size = k == 0 ? MADE_WIDTH : MADE_HEIGHT, second = corner >> k & 1;
                        cell[k] = (uint32_t)(((int)floor(texels) + second + size) % size);
                        part *= second ? f : 1 - f;
                    }
                    double value[3];
                    if (part == 0) {
                        continue;
                    }
                    blended_value(&x, &o, cell[0], MADE_HEIGHT - 1 - cell[1], views.index[a], &lights, l, v,
                                  &known, value);
                    for (int c = 0; c < 3; ++c) {
                        sum[c] += value[c] * part * weights[a] / 4096.0;
                    }
                }
            }
            if (!known) {
                continue;
            }
            ++compared;
            of_roots += x.m.blend == BTF_REF_BLEND_ROOTS;
            for (int c = 0; c < 3; ++c) {
                double expected = x.m.blend == BTF_REF_BLEND_ROOTS ? sum[c] * sum[c] : sum[c];
                expected *= (double)x.m.radiance_scale;
                worst = fmax(worst, fabs((double)rgb[c] - expected) / (1e-6 + expected));
            }
        }
    }
    print_message("%u evaluations, %u of roots: %.3g of the value\n", compared, of_roots, worst);
    assert_true(worst <= 3e-6);
    assert_true(compared > 9000 && of_roots > 100);
}

/** The lights that gloss gives each of the neighbours `views`, whatever the interpolation. */
static void gloss_lights(const btf_ref_material *m, const btf_ref_neighbours *views, const float light[3],
                         const float view[3], btf_ref_neighbours out[3]) {
    for (int a = 0; a < 3; ++a) {
        int32_t q[2];
        btf_ref_gloss(m, views->index[a], light, view, q);
        out[a] = btf_ref_lookup(m->light_table, m->light_grid, q);
    }
}

/** Every entry point gives the same texel: relief starts at its centre. Where a caller hands in neighbours of lights,
 * gloss has no effect unless it hands in those of each view. */
TEST(test_ways_agree) {
    static made_all x;
    uint32_t random = 13;
    for (uint32_t seed = 1; seed <= 60; ++seed) {
        make_all(seed, seed % 5 == 0, &x);
        for (int i = 0; i < 200; ++i) {
            float l[3], v[3], rgb[4][3];
            btf_ref_options o = random_options(&random), no_gloss;
            o.effects |= BTF_REF_RELIEF;
            no_gloss = o;
            no_gloss.effects &= ~(uint32_t)BTF_REF_GLOSS;
            random_direction(&random, l);
            random_direction(&random, v);
            uint32_t column = random_below(&random, MADE_WIDTH), row = random_below(&random, MADE_HEIGHT);
            btf_ref_neighbours views = neighbours_of(x.m.view_table, x.m.view_grid, v),
                               lights = neighbours_of(x.m.light_table, x.m.light_grid, l);
            btf_ref_evaluate_neighbours(&x.m, &o, column, row, &lights, &views, l, v, rgb[0]);
            btf_ref_evaluate_texel(&x.m, &no_gloss, column, row, l, v, rgb[1]);
            assert_same(rgb[0], rgb[1]);
            btf_ref_evaluate_texel(&x.m, &o, column, row, l, v, rgb[2]);
            btf_ref_neighbours apart[3] = {lights, lights, lights};
            if (x.m.effects & o.effects & BTF_REF_GLOSS) {
                gloss_lights(&x.m, &views, l, v, apart);
            }
            btf_ref_evaluate_apart(&x.m, &o, column, row, apart, &views, l, v, rgb[3]);
            assert_same(rgb[3], rgb[2]);
            o.filter = BTF_REF_TEXEL;
            /* the centre, but for what a coordinate of 18 bits leaves: 1/256 of a texel is far more */
            float u = ((float)column + 0.501f) / MADE_WIDTH, w = 1 - ((float)row + 0.499f) / MADE_HEIGHT;
            btf_ref_evaluate(&x.m, &o, u, w, l, v, rgb[3]);
            assert_same(rgb[2], rgb[3]);
        }
    }
}

/* --- no jumps --- */

/** A plane without texture, at one height above that of the data. Views differ in brightness and lights differ; on some
 * views relief does not act. */
static void make_smooth(uint32_t seed, made_all *out) {
    make_material(1, 1, BTF_REF_SHADOW | BTF_REF_GAIN, 0, &out->storage, &out->m);
    make_relief(seed, 0, &out->relief, &out->m);
    out->m.lobes = 0;
    out->m.shadow_scale = 0x1p-8f;
    out->m.level = 0;
    out->m.relief_base = 700;
    out->m.relief_step = seed % 2 ? 100 : 0;
    memset(out->relief.heights, 0, sizeof out->relief.heights);
    for (uint32_t i = 0; i < MADE_TEXELS; ++i) {
        double phase = 6.283185307179586 *
                       ((double)(i % MADE_WIDTH) / MADE_WIDTH + (double)(i / MADE_WIDTH) / MADE_HEIGHT);
        float *p = out->storage.sbrdf + 4 * i;
        p[0] = p[1] = p[2] = 1;
        p[3] = 0.5f + 0.5f * (float)cos(phase);
        for (uint32_t a = 0; a < MADE_VIEWS; ++a) {
            out->storage.gain[a * MADE_TEXELS + i] = (uint8_t)(128 - 10 * a);
        }
        for (uint32_t b = 0; b < MADE_LIGHTS; ++b) {
            out->storage.shadow[b * MADE_TEXELS + i] = (uint8_t)(255 - 40 * b);
        }
    }
}

/** Moving the view along lines across all cells, past views on which relief acts and others, never makes the result
 * jump: relief fades in, and gloss moves look-ups continuously. */
TEST(test_no_jumps) {
    static made_all x;
    uint32_t random = 17;
    double worst = 0;
    enum { LINES = 60, STEPS = 4096 };
    for (uint32_t line = 0; line < LINES; ++line) {
        make_smooth(line, &x);
        btf_ref_options o = {
            .effects = UINT32_MAX, .interpolation = BTF_REF_LINEAR, .filter = BTF_REF_BILINEAR};
        float l[3], v[3], before = 0;
        random_direction(&random, l);
        l[2] = l[2] < 0.1f ? 0.1f : l[2];
        float u = random_float(&random, 0, 1), w = random_float(&random, 0, 1);
        double angle = (double)random_float(&random, 0, 6.28f),
               away = (double)random_float(&random, -0.7f, 1.4f);
        for (int i = 0; i <= STEPS; ++i) {
            double along = sqrt(1 - away * away) * (2.0 * i / STEPS - 1) * 0.98;
            double a = along * cos(angle) - away * sin(angle), b = along * sin(angle) + away * cos(angle),
                   r = a * a + b * b;
            v[0] = (float)(2 * a / (1 + r)), v[1] = (float)(2 * b / (1 + r)),
            v[2] = (float)((1 - r) / (1 + r));
            float rgb[3];
            btf_ref_evaluate(&x.m, &o, u, w, l, v, rgb);
            if (i > 0 && fabs((double)rgb[0] - (double)before) > worst) {
                worst = fabs((double)rgb[0] - (double)before);
            }
            before = rgb[0];
        }
    }
    print_message("for a step of 4 units of the plane values change by %.4f at most\n", worst);
    assert_true(worst <= 0.015);
}

/* --- any argument --- */

static float hard_component(uint32_t *random, const made_all *x, int k) {
    static const uint32_t hard[] = {0,          0x80000000, 1,          0x3F800000, 0xBF800000, 0x33800000,
                                    0x337FFFFF, 0x40000000, 0xC0000000, 0x3F7FFFFF, 0x7F800000, 0x7FC00000};
    uint32_t choice = random_below(random, 8);
    const float *vector = x->relief.view_vectors + 4 * random_below(random, MADE_VIEWS);
    if (choice == 0 && k < 2) {
        return float_of(hard[random_below(random, 12)]);
    }
    if (choice == 1) {
        return vector[k];
    }
    if (choice == 2 && k < 2) {
        return -vector[k];
    }
    if (choice == 3 && k == 2) { /* grazing */
        return float_of(0x33800000u + random_below(random, 16));
    }
    if (choice == 4 && k < 2) {
        return float_of(random_bits(random));
    }
    return k == 2 ? random_float(random, 0, 2) + 0x1p-24f : random_float(random, -2, 4);
}

/** Legal files of extreme parameters, any bits as arguments: finite, not negative, no denormal. */
TEST(test_finite) {
    static made_all x;
    uint32_t random = 19, lit = 0, evaluations = 0;
    for (uint32_t seed = 1; seed <= 200; ++seed) {
        make_all(seed, seed % 5 != 0, &x);
        for (int i = 0; i < 1500; ++i) {
            float l[3], v[3], rgb[3];
            for (int k = 0; k < 3; ++k) {
                l[k] = hard_component(&random, &x, k);
                v[k] = hard_component(&random, &x, k);
            }
            if (i % 16 == 0) { /* opposed */
                l[0] = -v[0], l[1] = -v[1];
            }
            btf_ref_options o = random_options(&random);
            btf_ref_evaluate(&x.m, &o, float_of(random_bits(&random)), random_float(&random, -2, 4), l, v,
                             rgb);
            ++evaluations;
            lit += rgb[0] > 0;
            for (int c = 0; c < 3; ++c) {
                uint32_t bits = bits_of(rgb[c]);
                if (bits >= 0x7F800000u || (bits != 0 && bits < 0x00800000u)) {
                    fail_msg("seed %u, %d: channel %d is %08X", seed, i, c, bits);
                }
            }
        }
    }
    print_message("%u of %u are lit\n", lit, evaluations);
    assert_true(lit > evaluations / 10);
}

RUN_TESTS(NULL, NULL)
