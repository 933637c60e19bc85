/* The reference decoder, factors of version 2: codes packed from levels by a table of places, against sums
 * in double precision over the levels; bounds, truncation, the horizon and blended roots by hand.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reference_assert.h"
#include "tests/support/reference_material.h"
#include "tests/support/test.h"

enum {
    CLASSES = 5,
    WORDS = 4,
    COMPONENTS = 16,
    LEVELS_OF_U = MADE_TEXELS,
    PAIRS = MADE_VIEWS * MADE_LIGHTS
};

/** FORMAT.md section 3, place by place: the lowest bit of component i, of u with 100 for the second texel. */
static const struct {
    int components, texels, tier;
    int w_bits, u_bits;
    int place[COMPONENTS];
} layout[CLASSES] = {
    {4, 1, 0, 8, 8, {0, 8, 16, 24}},
    {8, 2, 1, 4, 8, {16, 24, 116, 124, 0, 8, 100, 108}},
    {8, 1, 1, 4, 4, {16, 20, 24, 28, 0, 4, 8, 12}},
    {16, 2, 2, 2, 4, {16, 20, 24, 28, 116, 120, 124, 128, 0, 4, 8, 12, 100, 104, 108, 112}},
    {16, 1, 2, 2, 2, {24, 26, 28, 30, 16, 18, 20, 22, 8, 10, 12, 14, 0, 2, 4, 6}},
};

/** Levels before they are packed. */
typedef struct unpacked {
    made_factors packed;
    int w[MADE_UNITS][WORDS][COMPONENTS][PAIRS];
    int u[MADE_UNITS][WORDS][COMPONENTS][LEVELS_OF_U];
    int class_of[MADE_UNITS], number[MADE_UNITS];
} unpacked;

static unpacked made;
static made_storage storage;

/** The code of a level, and a random level. */
static uint32_t code_of(int class_index, int level, int bits) {
    return class_index == 0 ? (uint32_t)level & 255u : (uint32_t)(level + (1 << bits) - 1) / 2;
}

static int random_level(uint32_t *state, int class_index, int bits) {
    if (class_index == 0) {
        return (int)random_below(state, 255) - 127;
    }
    return 2 * (int)random_below(state, 1u << bits) - ((1 << bits) - 1);
}

static void pack_unit(uint32_t *random, int unit, int layer) {
    const int c = made.class_of[unit];
    for (int word = 0; word < WORDS; ++word) {
        for (int i = 0; i < layout[c].components; ++i) {
            for (int pair = 0; pair < PAIRS; ++pair) {
                const int level = random_level(random, c, layout[c].w_bits);
                made.w[unit][word][i][pair] = level;
                made.packed.directions[4 * (unit * PAIRS + pair) + word] |=
                    code_of(c, level, layout[c].w_bits) << (layout[c].w_bits * i);
            }
            const int bit = layout[c].place[i] % 100, at = layer + layout[c].place[i] / 100;
            for (int texel = 0; texel < MADE_TEXELS; ++texel) {
                const int level = random_level(random, c, layout[c].u_bits);
                made.u[unit][word][i][texel] = level;
                made.packed.texels[4 * (at * MADE_TEXELS + texel) + word] |=
                    code_of(c, level, layout[c].u_bits) << bit;
            }
        }
    }
}

/** A material of nothing but factors and shifts, in layout tight, of random classes. */
static void make_packed(uint32_t seed, btf_ref_material *m) {
    uint32_t random = seed + 99;
    int layer = 0;
    make_material(seed, 1 + 16 + 2 * (seed % 2), BTF_REF_SHIFT | BTF_REF_GAIN | BTF_REF_RESIDUAL, 0,
                  &storage, m);
    make_factors(seed, 0, &made.packed, m);
    memset(made.packed.texels, 0, sizeof made.packed.texels);
    memset(made.packed.directions, 0, sizeof made.packed.directions);
    for (int c = 0, unit = 0; c < CLASSES; ++c) {
        for (int number = 0; number < (int)m->factor_classes[c][0]; ++number, ++unit) {
            made.class_of[unit] = c;
            made.number[unit] = number;
            pack_unit(&random, unit, layer);
            layer += layout[c].texels;
            for (int word = 1; word < WORDS && c > 0 &&
                               4 * number >= (int)(m->factor_classes[c][1] + m->factor_classes[c][2]);
                 ++word) {
                made.packed.scales[4 * unit + word] = made.packed.scales[4 * unit];
            }
        }
    }
}

/** The residual in double precision, of the first units. */
static void factors_in_double(const btf_ref_material *m, uint32_t units, int texel, uint32_t view,
                              const btf_ref_neighbours *lights, double out_r[3]) {
    double channels[3] = {0, 0, 0};
    for (uint32_t unit = 0; unit < units && unit < m->components; ++unit) {
        const int c = made.class_of[unit];
        for (int word = 0; word < WORDS; ++word) {
            const uint32_t k = (uint32_t)(4 * made.number[unit] + word), *counts = m->factor_classes[c];
            const int channel = k < counts[1] ? 1 : k < counts[1] + counts[2] ? 2 : 0;
            double sum = 0;
            for (int b = 0; b < 3; ++b) {
                for (int i = 0; i < layout[c].components; ++i) {
                    sum += lights->weight[b] / 4096.0 * made.u[unit][word][i][texel] *
                           made.w[unit][word][i][view * MADE_LIGHTS + lights->index[b]];
                }
            }
            channels[channel] +=
                sum * (double)made.packed.scales[4 * unit + (uint32_t)word] *
                (double)made.packed.views[4 * (3 * view + (uint32_t)layout[c].tier) + (uint32_t)channel];
        }
    }
    out_r[0] = channels[0] + channels[1] + channels[2];
    out_r[1] = channels[0] - 2 * channels[2];
    out_r[2] = channels[0] - channels[1] + channels[2];
}

/** Radiance in double precision, of a material of make_packed(). */
static void radiance_in_double(const btf_ref_material *m, uint32_t units, uint32_t column, uint32_t row,
                               const btf_ref_neighbours *lights, const btf_ref_neighbours *views,
                               double cosine, double out_rgb[3]) {
    const double q = fmin(cosine * (double)m->horizon_scale, 1), horizon = m->domain_sqrt ? sqrt(q) : q;
    double sum[3] = {0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        const uint32_t view = views->index[a];
        const size_t at = view * MADE_TEXELS + row * MADE_WIDTH + column;
        const uint32_t x = (column + 7 * 128 + (uint32_t)(int8_t)m->shift[2 * at]) % MADE_WIDTH;
        const uint32_t y = (row + 5 * 128 + (uint32_t)(int8_t)m->shift[2 * at + 1]) % MADE_HEIGHT;
        double r[3];
        factors_in_double(m, units, (int)(y * MADE_WIDTH + x), view, lights, r);
        for (int c = 0; c < 3; ++c) {
            double value = r[c] * horizon * m->gain[at] * (double)m->gain_scale;
            if (m->blend == BTF_REF_BLEND_RADIANCE) {
                value = fmax(value, 0);
                value = m->domain_sqrt ? value * value : value;
            }
            sum[c] += value * views->weight[a] / 4096.0;
        }
    }
    for (int c = 0; c < 3; ++c) {
        if (m->blend == BTF_REF_BLEND_ROOTS) {
            sum[c] = sum[c] > 0 ? sum[c] * sum[c] : 0;
        }
        out_rgb[c] = sum[c] * (double)m->radiance_scale;
    }
}

TEST(test_against_double) {
    btf_ref_material m;
    uint32_t random = 41, lit = 0, blended = 0;
    double worst = 0;
    for (uint32_t round = 0; round < 150; ++round) {
        make_packed(round, &m);
        blended += m.blend == BTF_REF_BLEND_ROOTS;
        for (int i = 0; i < 40; ++i) {
            float l[3], v[3], rgb[3];
            int32_t ql[2], qv[2];
            double truth[3];
            random_direction(&random, l);
            random_direction(&random, v);
            const uint32_t column = random_below(&random, MADE_WIDTH),
                           row = random_below(&random, MADE_HEIGHT);
            const uint32_t units = i % 2 ? random_below(&random, MADE_UNITS) : UINT32_MAX;
            btf_ref_options options = {UINT32_MAX, units, BTF_REF_LINEAR, BTF_REF_TEXEL};
            btf_ref_project(l, ql);
            btf_ref_project(v, qv);
            btf_ref_neighbours lights = btf_ref_lookup(m.light_table, m.light_grid, ql);
            btf_ref_neighbours views = btf_ref_lookup(m.view_table, m.view_grid, qv);
            btf_ref_evaluate_texel(&m, &options, column, row, l, v, rgb);
            radiance_in_double(&m, units, column, row, &lights, &views, (double)l[2], truth);
            for (int c = 0; c < 3; ++c) {
                /* e >> s leaves out less than 2^s of sums of 1e4 to 1e8 */
                const double error = fabs((double)rgb[c] - truth[c]) / (1 + fabs(truth[c]));
                if (error > 1e-4) {
                    fail_msg("round %u, %d, channel %d: %.9g, in double %.9g", round, i, c, (double)rgb[c],
                             truth[c]);
                }
                worst = fmax(worst, error);
                lit += truth[c] > 0.1;
            }
        }
    }
    print_message("against double: %.3g; %u channels lit, %u of 150 rounds blend roots\n", worst, lit,
                  blended);
    assert_true(lit > 2000 && blended > 20);
}

/** A material of one class with one unit of Y, by hand: codes the same in all words of all texels and
 * directions. */
static void make_uniform(int class_index, uint32_t w, uint32_t u, float scale, btf_ref_material *m) {
    make_material(3, 1 + 16, BTF_REF_RESIDUAL, 0, &storage, m);
    make_factors(3, 0, &made.packed, m);
    memset(m->factor_classes, 0, sizeof m->factor_classes);
    m->factor_classes[class_index][0] = 1;
    m->components = 1;
    m->horizon_scale = m->radiance_scale = 1.0f;
    for (size_t i = 0; i < sizeof made.packed.texels / sizeof *made.packed.texels; ++i) {
        made.packed.texels[i] = u;
    }
    for (size_t i = 0; i < sizeof made.packed.directions / sizeof *made.packed.directions; ++i) {
        made.packed.directions[i] = w;
    }
    for (size_t i = 0; i < sizeof made.packed.scales / sizeof *made.packed.scales; ++i) {
        made.packed.scales[i] = scale;
    }
    for (size_t i = 0; i < sizeof made.packed.views / sizeof *made.packed.views; ++i) {
        made.packed.views[i] = i % 4 == 3 ? 0.0f : 1.0f;
    }
}

static const float pole[3] = {0, 0, 1};

/** Y alone of a texel. */
static float luma(const btf_ref_material *m, const float light[3]) {
    btf_ref_options options = {UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
    float rgb[3];
    btf_ref_evaluate_texel(m, &options, 2, 3, light, pole, rgb);
    assert_bits(rgb[1], rgb[0]);
    assert_bits(rgb[2], rgb[0]);
    return rgb[0];
}

/** The largest sums that FORMAT.md states come out, and are exact in spite of the conversion to float. */
TEST(test_bounds) {
    static const struct {
        uint32_t largest, smallest; /* words of nothing but such codes */
        int32_t dot;                /* of a unit, where both are the largest */
        float stated;
    } of[CLASSES] = {
        {0x7F7F7F7Fu, 0x81818181u, 16 * 127 * 127, 4 * 2.65e8f},
        {0xFFFFFFFFu, 0, 32 * 15 * 255, 5.02e8f},
        {0xFFFFFFFFu, 0, 32 * 15 * 15, 2.95e7f},
        {0xFFFFFFFFu, 0, 64 * 3 * 15, 1.18e7f},
        {0xFFFFFFFFu, 0, 64 * 3 * 3, 2.36e6f},
    };
    for (int c = 0; c < CLASSES; ++c) {
        const float dot = (float)of[c].dot;
        btf_ref_material m;
        assert_true(dot * 4096 <= of[c].stated && dot * 4096 > 0.99f * of[c].stated);
        make_uniform(c, of[c].largest, of[c].largest, 1.0f, &m);
        assert_bits(luma(&m, pole), dot);
        make_uniform(c, of[c].smallest, of[c].smallest, 1.0f, &m);
        assert_bits(luma(&m, pole), dot);
        make_uniform(c, of[c].smallest, of[c].largest, -1.0f,
                     &m); /* a negative sum: all shifts are exact here */
        assert_bits(luma(&m, pole), dot);
        make_uniform(c, of[c].smallest, of[c].largest, 1.0f, &m);
        assert_bits(luma(&m, pole), 0.0f);
    }
}

/** Shifts round down, of negative sums too. */
TEST(test_shift) {
    btf_ref_material m;
    /* class 0, component 0 of word 0 alone: 1 * 3, weighted 4096 * 3 = 12288 of one light, or 1365 * 3 =
     * 4095 */
    btf_ref_neighbours lights = {{0, 1, 2}, {1365, 1365, 1366}}, views = {{0, 0, 0}, {4096, 0, 0}};
    btf_ref_options options = {UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
    float rgb[3];
    for (int sign = -1; sign <= 1; sign += 2) {
        make_uniform(0, 0, 0, (float)sign, &m);
        for (uint32_t texel = 0; texel < MADE_TEXELS; ++texel) {
            made.packed.texels[4 * texel] = 3;
        }
        made.packed.directions[0] = sign < 0 ? 0xFFu : 1u; /* view 0, light 0: -1 or 1 */
        btf_ref_evaluate_neighbours(&m, &options, 0, 0, &lights, &views, pole, pole, rgb);
        /* e = +-4095; e >> 4 is 255, or -256; steps of 2^-8 */
        assert_bits(rgb[0], sign < 0 ? 256 * 0x1p-8f : 255 * 0x1p-8f);
    }
}

/** Channels of the words of a unit, and from Y, C1, C2 to R, G, B. */
TEST(test_colour) {
    static const uint32_t counts[6][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {2, 1}, {1, 3}};
    btf_ref_options options = {UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
    for (int c = 0; c < CLASSES; ++c) {
        for (int k = 0; k < 6; ++k) {
            btf_ref_material m;
            make_uniform(c, c == 0 ? 0x01010101u : 0xFFFFFFFFu, c == 0 ? 0x01010101u : 0xFFFFFFFFu, 0x1p-4f,
                         &m);
            m.factor_classes[c][1] = counts[k][0];
            m.factor_classes[c][2] = counts[k][1];
            for (size_t i = 0; i < sizeof made.packed.views / sizeof *made.packed.views; ++i) {
                made.packed.views[i] = i % 4 == 0 ? 8.0f : i % 4 == 1 ? 2.0f : i % 4 == 2 ? 0.5f : 0.0f;
            }
            const float word =
                (float)(layout[c].components *
                        (c == 0 ? 1 : ((1 << layout[c].w_bits) - 1) * ((1 << layout[c].u_bits) - 1)));
            const float c1 = word / 16 * 2 * (float)counts[k][0],
                        c2 = word / 16 * 0.5f * (float)counts[k][1];
            const float y = word / 16 * 8 * (float)(4 - counts[k][0] - counts[k][1]);
            float rgb[3];
            btf_ref_evaluate_texel(&m, &options, 1, 1, pole, pole, rgb);
            assert_rgb(rgb, y + c1 + c2, fmaxf(y - 2 * c2, 0), fmaxf(y - c1 + c2, 0));
        }
    }
}

TEST(test_horizon) {
    btf_ref_material m;
    const float low[3] = {0.9f, 0.0f, 0.0625f}, high[3] = {0.9f, 0.0f, 0.25f};
    make_uniform(2, 0xFFFFFFFFu, 0xFFFFFFFFu, 0x1p-10f, &m);
    const float value = 32 * 225 * 0x1p-10f;
    m.horizon_scale = 4.0f;
    assert_bits(luma(&m, pole), value); /* no cosine: it is in the factors */
    assert_bits(luma(&m, high), value); /* the outermost light */
    assert_bits(luma(&m, low), value * 0.25f);
    m.domain_sqrt = 1;
    assert_bits(luma(&m, high), value * value);
    assert_bits(luma(&m, low), (value * 0.5f) * (value * 0.5f)); /* the root of a quarter */
    m.horizon_scale = 0x1p24f;
    const float last[3] = {1.0f, 0.0f, 0x1p-24f};
    assert_bits(luma(&m, last), value * value);
}

/** With a model: h fades with the cosine, r does not. */
TEST(test_model_and_factors) {
    btf_ref_material m;
    const float low[3] = {0.9f, 0.0f, 0.25f};
    make_uniform(4, 0xFFFFFFFFu, 0xFFFFFFFFu, 0x1p-10f, &m);
    const float r = 64 * 9 * 0x1p-10f;
    m.colour = BTF_REF_MONO;
    m.lobes = 0;
    for (size_t i = 0; i < (size_t)4 * MADE_TEXELS; ++i) {
        storage.sbrdf[i] = 1.0f;
    }
    m.sbrdf = storage.sbrdf;
    m.horizon_scale = 2.0f;
    assert_bits(luma(&m, low), 0.25f + r * 0.5f);
    m.effects = 0;
    assert_bits(luma(&m, low), 0.25f);
}

/** Where roots are blended, that of a single view may be negative, and hidden views take part. */
TEST(test_blended_roots) {
    btf_ref_material m;
    make_uniform(4, 0xFFFFFFFFu, 0xFFFFFFFFu, 0x1p-6f, &m);
    const float r = 64 * 9 * 0x1p-6f; /* 9 */
    btf_ref_neighbours lights = {{0, 0, 0}, {4096, 0, 0}}, views = {{0, 1, 2}, {2048, 1024, 1024}};
    btf_ref_options options = {UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
    float rgb[3];
    m.domain_sqrt = 1;
    m.radiance_scale = 2.0f;
    for (int t = 0; t < 3; ++t) {
        made.packed.views[4 * (3 * 1 + t)] = -0.5f;
    }
    m.blend = BTF_REF_BLEND_ROOTS;
    btf_ref_evaluate_neighbours(&m, &options, 0, 0, &lights, &views, pole, pole, rgb);
    float root = r * 0.5f - r * 0.125f + r * 0.25f;
    assert_bits(rgb[0], root * root * 2);
    m.blend = BTF_REF_BLEND_RADIANCE;
    btf_ref_evaluate_neighbours(&m, &options, 0, 0, &lights, &views, pole, pole, rgb);
    assert_bits(rgb[0], r * r * 0.75f * 2);

    m.blend = BTF_REF_BLEND_ROOTS; /* view 2 is hidden: its centre has 3 */
    m.effects |= BTF_REF_HIDDEN;
    m.centre_scale = 1.0f;
    memset(storage.gain, 128, sizeof storage.gain);
    memset(storage.shift, 0, sizeof storage.shift);
    storage.gain[2 * MADE_TEXELS] = 0;
    memset(storage.centre, 3, sizeof storage.centre);
    btf_ref_evaluate_neighbours(&m, &options, 0, 0, &lights, &views, pole, pole, rgb);
    root = r * 0.5f - r * 0.125f + 3 * 0.25f;
    assert_bits(rgb[0], root * root * 2);
    for (int t = 0; t < 3; ++t) {
        made.packed.views[4 * (3 * 0 + t)] = -1.0f;
    }
    btf_ref_evaluate_neighbours(&m, &options, 0, 0, &lights, &views, pole, pole, rgb);
    assert_bits(rgb[0], 0.0f);
}

/** Decoding the first units gives the same as a material that holds only those. */
TEST(test_truncation) {
    btf_ref_material m, shorter;
    uint32_t random = 5, different = 0;
    for (uint32_t round = 0; round < 60; ++round) {
        make_packed(round, &m);
        for (uint32_t units = 0; units <= m.components; ++units) {
            uint32_t left = units;
            shorter = m;
            shorter.components = units;
            for (int c = 0; c < CLASSES; ++c) {
                uint32_t *counts = shorter.factor_classes[c];
                counts[0] = counts[0] < left ? counts[0] : left;
                left -= counts[0];
            }
            float l[3], v[3], first[3], whole[3];
            random_direction(&random, l);
            random_direction(&random, v);
            btf_ref_options some = {UINT32_MAX, units, BTF_REF_LINEAR, BTF_REF_BILINEAR};
            btf_ref_options all = {UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_BILINEAR};
            btf_ref_evaluate(&m, &some, 0.3f, 0.6f, l, v, first);
            btf_ref_evaluate(&shorter, &all, 0.3f, 0.6f, l, v, whole);
            for (int c = 0; c < 3; ++c) {
                assert_bits(first[c], whole[c]);
            }
            if (units == 0) {
                assert_rgb(first, 0, 0, 0);
            }
            btf_ref_evaluate(&m, &all, 0.3f, 0.6f, l, v, whole);
            different += bits_of(whole[0]) != bits_of(first[0]);
        }
    }
    assert_true(different > 100);
}

/** Legal files of extreme parameters, roots blended too: finite and not negative. */
TEST(test_finite) {
    btf_ref_material m;
    uint32_t random = 78, lit = 0, evaluations = 0;
    for (uint32_t round = 0; round < 150; ++round) {
        make_material(round, round, round % 2 ? 31 : round / 2 % 32, round % 5 != 0, &storage, &m);
        make_factors(round, round % 5 != 0, &made.packed, &m);
        for (int i = 0; i < 300; ++i) {
            float l[3], v[3], rgb[3];
            random_direction(&random, l);
            random_direction(&random, v);
            if (i % 3 == 0) {
                l[2] = float_of(0x33800000u + random_below(&random, 0x0C800001u >> 8) * 256);
            }
            btf_ref_options o = {
                .effects = UINT32_MAX, .components = UINT32_MAX, .interpolation = i >> 2 & 1};
            btf_ref_evaluate_texel(&m, &o, random_below(&random, MADE_WIDTH),
                                   random_below(&random, MADE_HEIGHT), l, v, rgb);
            ++evaluations;
            for (int c = 0; c < 3; ++c) {
                const uint32_t bits = bits_of(rgb[c]);
                lit += bits != 0;
                if (bits >= 0x7F800000u || (bits != 0 && bits < 0x00800000u)) {
                    fail_msg("round %u, %d: channel %d is %08X", round, i, c, bits);
                }
            }
        }
    }
    assert_true(lit > evaluations / 2);
}

RUN_TESTS(NULL, NULL)
