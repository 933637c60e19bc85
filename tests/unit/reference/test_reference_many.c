/* The reference decoder, many evaluations: made-up materials against a model in double precision and against each
 * other; hostile ones for what FORMAT.md promises of every result.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reference_assert.h"
#include "tests/support/reference_material.h"
#include "tests/support/test.h"

#define ALL_EFFECTS (BTF_REF_SHADOW | BTF_REF_SHIFT | BTF_REF_HIDDEN | BTF_REF_GAIN | BTF_REF_RESIDUAL)

/** The same radiance in double precision, with libm, for layout tight and floats; formulas as FORMAT.md
 * states them in words. */
static void model_in_double(const btf_ref_material *m, uint32_t column, uint32_t row,
                            const btf_ref_neighbours *lights, const btf_ref_neighbours *views,
                            const float l[3], const float v[3], double out_rgb[3]) {
    const float *sbrdf = m->sbrdf;
    size_t texels = (size_t)m->width * m->height;
    for (int c = 0; c < 3; ++c) {
        out_rgb[c] = 0;
        for (int a = 0; a < 3; ++a) {
            size_t view = views->index[a], texel = row * m->width + column;
            uint8_t code = m->gain[view * texels + texel];
            const uint8_t *bytes = m->shift + 2 * (view * texels + texel);
            double value = 0;
            if (code == 0) {
                for (int b = 0; b < 3; ++b) {
                    value += lights->weight[b] / 4096.0 * (double)m->centre_scale *
                             m->centre[4 * ((size_t)bytes[0] * m->n_lights + lights->index[b]) + (size_t)c];
                }
                out_rgb[c] += value * value * views->weight[a] / 4096.0 * (double)m->radiance_scale;
                continue;
            }
            uint32_t x = (column + 7 * 128 + (uint32_t)(int32_t)(int8_t)bytes[0]) % m->width;
            uint32_t y = (row + 5 * 128 + (uint32_t)(int32_t)(int8_t)bytes[1]) % m->height;
            texel = y * m->width + x;
            size_t first_lobe = m->colour == BTF_REF_MONO ? 1 : (3 * (1 + m->lobes) + 3) / 4;
            const float *factors[5];
            for (size_t i = 0; i < 5; ++i) {
                factors[i] = sbrdf + 4 * (i * texels + texel);
            }
            size_t at = (size_t)c;
            double diffuse = (double)(m->colour == BTF_REF_MONO ? factors[0][3] : factors[0][c]);
            double f = diffuse;
            for (uint32_t j = 0; j < m->lobes; ++j) {
                const float *lobe = sbrdf + 4 * ((first_lobe + j) * texels + texel);
                double base = 0;
                for (int i = 0; i < 3; ++i) {
                    base += (double)lobe[i] * (double)l[i] * (double)v[i];
                }
                at += 3;
                double weight = m->colour == BTF_REF_MONO ? 1 : (double)factors[at / 4][at % 4];
                f += weight * (base > 0 ? pow(base, (double)lobe[3]) : 0);
            }
            if (m->colour == BTF_REF_MONO) {
                f *= (double)factors[0][c];
            }
            double shadow = 0, residual = 0;
            for (int b = 0; b < 3; ++b) {
                shadow += lights->weight[b] / 4096.0 * m->shadow[lights->index[b] * texels + texel];
                for (uint32_t j = 0; j < m->components; ++j) {
                    size_t direction = (3 * (j / 4) + (uint32_t)c) * m->n_views + view;
                    residual +=
                        lights->weight[b] / 4096.0 * (double)m->residual_scales[j] *
                        m->residual_texels[4 * (j / 4 * texels + texel) + j % 4] *
                        m->residual_directions[4 * (direction * m->n_lights + lights->index[b]) + j % 4];
                }
            }
            value = f * shadow * (double)m->shadow_scale + residual;
            value *= (m->domain_sqrt ? sqrt((double)l[2]) : (double)l[2]) * code * (double)m->gain_scale;
            value = value > 0 ? value : 0;
            value = m->domain_sqrt ? value * value : value;
            out_rgb[c] += value * views->weight[a] / 4096.0 * (double)m->radiance_scale;
        }
    }
}

/** Copies what layout tight holds into an atlas. */
static void copy_to_atlas(const btf_ref_material *tight, made_storage *s, btf_ref_material *out_paper) {
    *out_paper = *tight;
    out_paper->layout_tight = 0;
    uint32_t x, y;
    for (uint32_t tile = 0; tile < MADE_VIEWS; ++tile) {
        for (uint32_t texel = 0; texel < MADE_TEXELS; ++texel) {
            btf_ref_tile(out_paper, tile, texel % MADE_WIDTH, texel / MADE_WIDTH, &x, &y);
            uint8_t *map = s->maps + 4 * (y * MADE_ATLAS + x);
            map[0] = tile < MADE_LIGHTS ? s->shadow[tile * MADE_TEXELS + texel] : 0;
            map[1] = s->gain[tile * MADE_TEXELS + texel];
            memcpy(map + 2, s->shift + 2 * (tile * MADE_TEXELS + texel), 2);
        }
    }
    for (uint32_t centre = 0; centre < MADE_CENTRES; ++centre) {
        for (uint32_t light = 0; light < MADE_LIGHTS; ++light) {
            btf_ref_centre(out_paper, centre, light, &x, &y);
            memcpy(s->maps + 4 * (y * MADE_ATLAS + x), s->centre + 4 * (centre * MADE_LIGHTS + light), 3);
        }
    }
}

TEST(test_against_double) {
    static made_storage storage;
    btf_ref_material m;
    btf_ref_options options = {UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
    uint32_t random = 21;
    double worst = 0;
    for (uint32_t round = 0; round < 200; ++round) {
        uint32_t kind =
            1 + 2 * (round % 2) + 8 * (round / 2 % 2); /* tight, float; both domains, mono and RGB */
        make_material(round, kind, ALL_EFFECTS, 0, &storage, &m);
        m.centres = MADE_CENTRES;
        for (int i = 0; i < 100; ++i) {
            float l[3], v[3], rgb[3];
            int32_t ql[2], qv[2];
            double truth[3];
            random_direction(&random, l);
            random_direction(&random, v);
            uint32_t column = random_below(&random, MADE_WIDTH), row = random_below(&random, MADE_HEIGHT);
            btf_ref_project(l, ql);
            btf_ref_project(v, qv);
            btf_ref_neighbours lights = btf_ref_lookup(m.light_table, m.light_grid, ql);
            btf_ref_neighbours views = btf_ref_lookup(m.view_table, m.view_grid, qv);
            btf_ref_evaluate_texel(&m, &options, column, row, l, v, rgb);
            model_in_double(&m, column, row, &lights, &views, l, v, truth);
            for (int c = 0; c < 3; ++c) {
                double error = fabs((double)rgb[c] - truth[c]) / (1 + fabs(truth[c]));
                if (error > 2e-5) {
                    fail_msg("round %u, %d, channel %d: %.9g, in double %.9g", round, i, c, (double)rgb[c],
                             truth[c]);
                }
                worst = fmax(worst, error);
            }
        }
    }
    print_message("against double: %.3g\n", worst);
}

/** Both layouts of the same material, and all entry points, give the same bits. */
TEST(test_ways_agree) {
    static made_storage storage;
    btf_ref_material tight, paper;
    uint32_t random = 33;
    for (uint32_t round = 0; round < 48; ++round) {
        make_material(round, round | 1, round % 3 ? ALL_EFFECTS : round % 32, 0, &storage, &tight);
        copy_to_atlas(&tight, &storage, &paper);
        for (int i = 0; i < 200; ++i) {
            float l[3], v[3], rgb[4][3];
            random_direction(&random, l);
            random_direction(&random, v);
            uint32_t column = random_below(&random, MADE_WIDTH), row = random_below(&random, MADE_HEIGHT);
            btf_ref_options o = {.effects = random_bits(&random) >> 8, .components = (uint32_t)i % 10};
            o.interpolation = i & 1;
            int32_t ql[2], qv[2];
            btf_ref_project(l, ql);
            btf_ref_project(v, qv);
            btf_ref_neighbours lights = btf_ref_lookup(tight.light_table, tight.light_grid, ql);
            btf_ref_neighbours views = btf_ref_lookup(tight.view_table, tight.view_grid, qv);
            /* within the texel, away from its borders */
            float u = ((float)column + 0.4f) / MADE_WIDTH, w = 1 - ((float)row + 0.6f) / MADE_HEIGHT;
            btf_ref_evaluate_texel(&tight, &o, column, row, l, v, rgb[0]);
            btf_ref_evaluate_texel(&paper, &o, column, row, l, v, rgb[1]);
            btf_ref_evaluate(&paper, &o, u, w, l, v, rgb[2]);
            btf_ref_evaluate_neighbours(&tight, &o, column, row, &lights, &views, l, v, rgb[3]);
            for (int k = 1; k < 4; ++k) {
                for (int c = 0; c < 3; ++c) {
                    assert_bits(rgb[k][c], rgb[0][c]);
                }
            }
        }
    }
}

/** Legal files of extreme parameters, any bits as arguments: finite and not negative. */
TEST(test_finite) {
    static made_storage storage;
    btf_ref_material m;
    uint32_t random = 77, lit = 0, evaluations = 0;
    for (uint32_t round = 0; round < 250; ++round) {
        make_material(round, round, round % 2 ? ALL_EFFECTS : round / 2 % 32, round % 5 != 0, &storage, &m);
        if (round % 7 == 3) {
            make_points(round, round % 5 != 0, &storage, &m);
        }
        for (int i = 0; i < 4000; ++i) {
            float l[3], v[3], rgb[3];
            for (int k = 0; k < 3; ++k) {
                uint32_t a = random_bits(&random), b = random_bits(&random);
                if (i % 4 != 0) { /* magnitudes to 2; upwards */
                    a = (a & 0x80000000u) | (a & 0x7FFFFFFFu) % 0x40000001u;
                    b = (b & 0x80000000u) | (b & 0x7FFFFFFFu) % 0x40000001u;
                    if (k == 2) {
                        a = 0x33800000u + a % 0x0C800001u;
                        b = 0x33800000u + b % 0x0C800001u;
                    }
                }
                l[k] = float_of(a);
                v[k] = float_of(b);
            }
            btf_ref_options o = {.effects = UINT32_MAX, .components = UINT32_MAX};
            o.interpolation = i >> 2 & 1;
            o.filter = (i & 63) == 0 ? BTF_REF_BILINEAR : BTF_REF_TEXEL;
            uint32_t u = random_bits(&random), w = random_bits(&random);
            btf_ref_evaluate(&m, &o, float_of(u), float_of(w), l, v, rgb);
            ++evaluations;
            lit += rgb[0] > 0;
            for (int c = 0; c < 3; ++c) {
                uint32_t bits = bits_of(rgb[c]);
                if (bits >= 0x7F800000u || (bits != 0 && bits < 0x00800000u)) {
                    fail_msg("round %u, %d: channel %d is %08X", round, i, c, bits);
                }
            }
        }
    }
    print_message("%u of %u are lit\n", lit, evaluations);
    assert_int_equal(evaluations, 1000000);
    assert_true(lit > evaluations / 10);
}

RUN_TESTS(NULL, NULL)
