/* Sums of lights under a view that moves (BTF_FOLD_SUM), made on the CPU: their texels against the reference's values, and
 * what a pixel reads against the sum over lights in double precision.
 *
 * SPDX-License-Identifier: MIT
 */
#include "folds.h"
#include "tests/conformance/cases.h"
#include "tests/conformance/check.h"
#include "tests/conformance/variant.h"
#include "decoder/toolkit/reference_view.h"
#include "tests/support/test.h"

#include <math.h>
#include <openbtf/fold.h>
#include <stdlib.h>

enum { LIGHTS = 7, NO_PARTNER = 1023 };

/* A sum of lights that was made of a material, and what it was made from. */
typedef struct summed {
    btf_material *material;
    btf_material_info info;
    btf_shader_options shader;
    btf_ref_options options;
    float light[LIGHTS][3], weight[LIGHTS][3];
    uint32_t *texels;
} summed;

static void sum_up(const synthetic_spec *spec, summed *s) {
    random_state r = {spec->seed};
    *s = (summed){.info = {.struct_size = sizeof s->info},
                  .shader = {.struct_size = sizeof s->shader,
                             .leave_out = check_fold_left_out(BTF_FOLD_SUM),
                             .fold = BTF_FOLD_SUM}};
    s->options = variant_reference_options(&s->shader);
    assert_int_equal(synthetic_create(spec, &folds_log, &s->material), BTF_OK);
    btf_material_get_info(s->material, &s->info);
    const btf_directions lights = btf_material_lights(s->material);
    for (int i = 0; i < LIGHTS; ++i) {
        case_direction(&r, &lights, s->light[i]);
        for (int c = 0; c < 3; ++c) {
            s->weight[i][c] = (float)random_between(&r, 0, 3);
        }
    }
    assert_int_equal(btf_material_fold_sum(s->material, &s->shader, LIGHTS, s->light[0], s->weight[0],
                                           &folds_log, &s->texels),
                     BTF_OK);
}

static void clear(summed *s) {
    btf_free(s->texels);
    btf_material_close(&s->material);
}

static uint32_t layers_of(const summed *s) {
    return s->info.n_views * (s->info.blend == BTF_BLEND_ROOTS ? 4 : 1);
}

/* A level of the texture. */
static const uint32_t *level_of(const summed *s, uint32_t level) {
    size_t texels = 0;
    for (uint32_t i = 0; i < level; ++i) {
        texels += (size_t)btf_level_size(s->info.width, i) * btf_level_size(s->info.height, i);
    }
    return s->texels + 4 * texels * layers_of(s);
}

/* Whether a direction is a unit vector above the horizon: cases are not all. */
static bool is_unit(const float d[3]) {
    return fabsf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1) < 1e-5f && d[2] > 1e-6f;
}

/* What stands for the product of two roots (openbtf/fold.h), rounded as single precision is. */
static float product(float a, float b) {
    a = fabsf(a) < 0x1p-30f ? 0 : a;
    b = fabsf(b) < 0x1p-30f ? 0 : b;
    if (fmaxf(a, b) <= 0) {
        return 0;
    }
    if (fminf(a, b) >= 0) {
        return a * b;
    }
    const float positive = fmaxf(a, b), negative = fmaxf(fminf(a, b), -positive);
    return negative * (positive + negative / 2);
}

/* Likewise, but not rounded. */
static double exact_product(double a, double b) {
    const double mean = fmax((a + b) / 2, 0), squares = fmax(a, 0) * fmax(a, 0) + fmax(b, 0) * fmax(b, 0);
    return 2 * mean * mean - squares / 2;
}

/* The views whose roots a layer multiplies; false where it is empty. */
static bool views_of(const summed *s, const uint32_t *own_texels, size_t words, uint32_t layer,
                     uint32_t views[2]) {
    if (s->info.blend != BTF_BLEND_ROOTS) {
        views[0] = views[1] = layer;
        return true;
    }
    const uint32_t code = own_texels[words * (layer - layer % 4) + 3];
    views[0] = views[1] = layer / 4;
    if (layer % 4 > 0) {
        views[1] = code >> 10 * (layer % 4 - 1) & NO_PARTNER;
    }
    return views[1] != NO_PARTNER;
}

/* Compares all layers of all levels with sums of the reference's values, to the bit. */
static void check_texels(const summed *s) {
    for (uint32_t at = 0; at < s->info.levels; ++at) {
        btf_ref_material m;
        reference_view(s->material, at, &m);
        const uint32_t *level = level_of(s, at);
        const size_t words = (size_t)4 * m.width * m.height;
        float *values[LIGHTS], *sum = malloc(words * sizeof *sum);
        for (int l = 0; l < LIGHTS; ++l) {
            values[l] = folds_reference(&m, &s->options, BTF_REF_FOLD_LIGHT, s->light[l], NULL);
            assert_non_null(values[l]);
        }
        for (uint32_t layer = 0; layer < layers_of(s); ++layer) {
            uint32_t views[2];
            const bool there = views_of(s, level, words, layer, views);
            memset(sum, 0, words * sizeof *sum);
            for (int l = 0; l < LIGHTS && there; ++l) {
                for (size_t w = 0; w < words; ++w) {
                    const float a = values[l][words * views[0] + w], b = values[l][words * views[1] + w];
                    const float value = s->info.blend == BTF_BLEND_ROOTS ? product(a, b) : a;
                    const float term = w % 4 < 3 ? value * s->weight[l][w % 4] : 0;
                    sum[w] = sum[w] + term;
                }
            }
            for (size_t w = 0; w < words; w += 4) {
                const uint32_t *texel = level + words * layer + w;
                assert_memory_equal(texel, sum + w, 3 * sizeof *texel);
                assert_int_equal(texel[3], s->info.blend == BTF_BLEND_ROOTS && layer % 4 == 0
                                               ? level[words * layer + 3]
                                               : 0);
            }
        }
        for (int l = 0; l < LIGHTS; ++l) {
            free(values[l]);
        }
        free(sum);
    }
}

/* What a texel should show, in double precision. */
typedef struct expected {
    double sum[3];     /* over lights of squares multiplied out, as a fold keeps them */
    double decoder[3]; /* over lights of what the decoder makes of the same values */
    double size[3];    /* over lights of what it would make of their magnitudes */
} expected;

static expected expect(const summed *s, const btf_ref_material *m, float *const values[LIGHTS],
                       const btf_ref_neighbours *views, size_t texel) {
    const size_t layer = (size_t)4 * m->width * m->height;
    const bool roots = s->info.blend == BTF_BLEND_ROOTS;
    expected out = {0};
    for (size_t c = 0; c < 3; ++c) {
        for (int l = 0; l < LIGHTS; ++l) {
            double blend = 0, size = 0, squares = 0;
            for (int a = 0; a < 3; ++a) {
                const double value = values[l][layer * views->index[a] + 4 * texel + c],
                             share = views->weight[a] / 4096.0;
                blend += share * value;
                size += share * fabs(value);
                for (int b = 0; b < 3; ++b) {
                    const double other = values[l][layer * views->index[b] + 4 * texel + c];
                    squares += share * views->weight[b] / 4096.0 * exact_product(value, other);
                }
            }
            const double weight = (double)s->weight[l][c] * (double)m->radiance_scale;
            out.decoder[c] += weight * (!roots ? blend : blend > 0 ? blend * blend : 0);
            out.sum[c] += weight * (roots ? squares : blend);
            out.size[c] += weight * (roots ? size * size : size);
        }
        out.sum[c] = fmax(out.sum[c], 0);
    }
    return out;
}

/* A view halfway between two neighbours that come up in turn, in the plane of the triangulation; there are two at least. */
static void halfway(const btf_directions *list, int i, float out[3]) {
    const uint16_t *of = list->triangle_count > 0 ? list->triangles : list->hull;
    const int side = list->triangle_count > 0 ? i % (int)(3 * list->triangle_count) : 0,
              next = side % 3 == 2 ? side - 2 : side + 1;
    double p[2], square = 0;
    for (int k = 0; k < 2; ++k) {
        p[k] = (list->vertices[2 * of[side] + k] + list->vertices[2 * of[next] + k]) / 2.0 / 8192 - 1;
        square += p[k] * p[k];
    }
    out[0] = (float)(2 * p[0] / (1 + square));
    out[1] = (float)(2 * p[1] / (1 + square));
    out[2] = (float)((1 - square) / (1 + square));
}

enum { ANYWHERE, SAMPLES, HALFWAY };

/* How far what pixels read is from what they should, at random texels and views. */
typedef struct distances {
    double rounding;       /* the most from the sum, in shares of its size */
    double decoder;        /* likewise from the decoder's */
    double squares, total; /* of all: of the distance from the decoder's, and of it */
    size_t pairs, halves;  /* views of two neighbours at least; of two that weigh the same */
} distances;

static distances measure(const summed *s, int where) {
    enum { COUNT = 4000 };
    random_state r = {99};
    distances d = {0};
    btf_ref_material m;
    float *values[LIGHTS];
    reference_view(s->material, 0, &m);
    const btf_directions list = btf_material_views(s->material);
    const btf_ref_folded folded = {BTF_REF_FOLD_SUM, (const float *)s->texels};
    for (int l = 0; l < LIGHTS; ++l) {
        values[l] = folds_reference(&m, &s->options, BTF_REF_FOLD_LIGHT, s->light[l], NULL);
        assert_non_null(values[l]);
    }
    for (int i = 0; i < COUNT; ++i) {
        static const float top[3] = {0, 0, 1};
        float view[3], rgb[3];
        int32_t q[2];
        const uint32_t column = (uint32_t)random_between(&r, 0, m.width - 0.01),
                       row = (uint32_t)random_between(&r, 0, m.height - 0.01);
        case_direction(&r, &list, view);
        if (where == SAMPLES) {
            memcpy(view, list.xyz + 3 * (size_t)(i % (int)list.count), sizeof view);
        } else if (where == HALFWAY && list.count > 1) {
            halfway(&list, i, view);
        }
        if (!is_unit(view)) {
            continue;
        }
        btf_ref_project(view, q);
        const btf_ref_neighbours views = btf_ref_lookup(m.view_table, m.view_grid, q);
        const bool half =
            (views.weight[0] == 2048) + (views.weight[1] == 2048) + (views.weight[2] == 2048) == 2;
        if (where == HALFWAY && !half) { /* vertices that are not a whole number apart */
            continue;
        }
        btf_ref_evaluate_folded(&m, &s->options, &folded, ((float)column + 0.5f) / (float)m.width,
                                1 - ((float)row + 0.5f) / (float)m.height, top, view, rgb);
        const expected e = expect(s, &m, values, &views, (size_t)row * m.width + column);
        d.pairs += views.weight[0] < 4096 && views.weight[1] < 4096 && views.weight[2] < 4096;
        d.halves += half;
        for (int c = 0; c < 3; ++c) {
            const double size = fmax(e.size[c], 1e-30), apart = fabs((double)rgb[c] - e.decoder[c]);
            d.rounding = fmax(d.rounding, fabs((double)rgb[c] - e.sum[c]) / size);
            d.decoder = fmax(d.decoder, apart / size);
            d.squares += apart * apart;
            d.total += e.decoder[c] * e.decoder[c];
        }
    }
    for (int l = 0; l < LIGHTS; ++l) {
        free(values[l]);
    }
    return d;
}

static const double bound = (LIGHTS + 12) * 0x1p-24; /* openbtf/fold.h */

enum { ONE_VIEW = 3, TWO_VIEWS, RADIANCE, SPECS };

static const synthetic_spec *specs(int i) {
    static synthetic_spec all[SPECS];
    for (int k = 0; k < SPECS; ++k) {
        all[k] = folds_of_roots;
        all[k].effects = BTF_EFFECT_RESIDUAL;
        all[k].seed = 50 + (uint64_t)k;
    }
    all[1].n_views = 81;
    all[1].directions = SYNTHETIC_RINGS;
    all[2].directions = SYNTHETIC_COLLINEAR;
    all[ONE_VIEW].n_views = 1;
    all[TWO_VIEWS].n_views = 2; /* without a triangle */
    all[RADIANCE].blend = BTF_BLEND_RADIANCE;
    return &all[i];
}

TEST(texels_are_sums_of_the_reference_s_values) {
    for (int i = 0; i < SPECS; ++i) {
        summed s;
        sum_up(specs(i), &s);
        assert_int_equal(btf_fold_layers(&s.info, BTF_FOLD_SUM, 1), layers_of(&s));
        check_texels(&s);
        clear(&s);
    }
}

/* Whatever two views a look-up gives together, one of them names the other, once. */
TEST(neighbouring_views_are_partners_once) {
    for (int i = 0; i < RADIANCE; ++i) {
        summed s;
        btf_ref_material m;
        random_state r = {5};
        size_t met = 0;
        sum_up(specs(i), &s);
        reference_view(s.material, 0, &m);
        const btf_directions list = btf_material_views(s.material);
        const size_t words = (size_t)4 * m.width * m.height;
        for (int k = 0; k < 20000; ++k) {
            float view[3];
            int32_t q[2];
            case_direction(&r, &list, view);
            if (!is_unit(view)) {
                continue;
            }
            btf_ref_project(view, q);
            const btf_ref_neighbours n = btf_ref_lookup(m.view_table, m.view_grid, q);
            for (int a = 0; a < 3; ++a) {
                const int b = (a + 1) % 3;
                if (n.weight[a] == 0 || n.weight[b] == 0) {
                    continue;
                }
                int times = 0;
                for (uint32_t layer = 0; layer < layers_of(&s); ++layer) {
                    uint32_t of[2];
                    times += layer % 4 > 0 && views_of(&s, s.texels, words, layer, of) &&
                             ((of[0] == n.index[a] && of[1] == n.index[b]) ||
                              (of[0] == n.index[b] && of[1] == n.index[a]));
                }
                assert_int_equal(times, 1);
                met++;
            }
        }
        print_message("%u views: %zu pairs met\n", (unsigned)s.info.n_views, met);
        assert_true(i == ONE_VIEW ? met == 0 : met > 1000);
        clear(&s);
    }
}

TEST(pixels_are_the_sum_over_lights) {
    for (int i = 0; i < SPECS; ++i) {
        summed s;
        sum_up(specs(i), &s);
        const distances any = measure(&s, ANYWHERE), at = measure(&s, SAMPLES), half = measure(&s, HALFWAY);
        print_message(
            "blend %d, %u views: rounding %.3g, bound %.3g; from the decoder's %.3g, all %.3g; at samples "
            "%.3g, halfway %.3g (%zu)\n",
            (int)s.info.blend, (unsigned)s.info.n_views, any.rounding, bound, any.decoder,
            sqrt(any.squares / any.total), at.decoder, half.decoder, half.halves);
        assert_true(any.rounding < bound && at.rounding < bound && half.rounding < bound);
        assert_true(at.decoder < bound && half.decoder < bound);
        if (s.info.blend != BTF_BLEND_ROOTS || s.info.n_views == 1) {
            assert_true(any.decoder < bound);
        }
        assert_true(i == ONE_VIEW || any.pairs > 300);
        assert_true(i == ONE_VIEW || i == TWO_VIEWS || half.halves > 300);
        clear(&s);
    }
}

/* Rows in pieces are those of the whole; calls that are wrong, each in one thing. */
TEST(rows_and_refusals) {
    static uint32_t level[4 * 13 * 7 * 9 * 4];
    summed s;
    sum_up(specs(0), &s);
    btf_evaluator *evaluator = NULL;
    assert_int_equal(btf_evaluator_create(s.material, &folds_log, &evaluator), BTF_OK);
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(btf_fold_sum_rows(evaluator, &s.shader, LIGHTS, s.light[0], s.weight[0], 0,
                                           i ? 0 : 4, i ? 4 : 3, level),
                         BTF_OK);
    }
    assert_memory_equal(level, s.texels, sizeof level);
    const struct {
        uint32_t lights, level, first, rows;
        int missing;
    } wrong[] = {{0, 0, 0, 1, 0}, {1, 3, 0, 1, 0}, {1, 0, 8, 0, 0}, {1, 0, 3, 5, 0},
                 {1, 0, 0, 1, 1}, {1, 0, 0, 1, 2}, {1, 0, 0, 1, 3}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        const int missing = wrong[i].missing;
        assert_int_equal(btf_fold_sum_rows(evaluator, &s.shader, wrong[i].lights,
                                           missing == 1 ? NULL : s.light[0],
                                           missing == 2 ? NULL : s.weight[0], wrong[i].level,
                                           wrong[i].first, wrong[i].rows, missing == 3 ? NULL : level),
                         BTF_ERROR_USAGE);
    }
    uint32_t *texels = NULL;
    assert_int_equal(btf_fold_rows(evaluator, &s.shader, s.light[0], NULL, 0, 0, 0, 1, level),
                     BTF_ERROR_USAGE);
    assert_int_equal(btf_material_fold(s.material, &s.shader, 1, s.light[0], NULL, &folds_log, &texels),
                     BTF_ERROR_USAGE);
    assert_int_equal(
        btf_material_fold_sum(s.material, &s.shader, 0, s.light[0], s.weight[0], &folds_log, &texels),
        BTF_ERROR_USAGE);
    s.shader.fold = BTF_FOLD_LIGHT;
    assert_int_equal(btf_fold_sum_rows(evaluator, &s.shader, 1, s.light[0], s.weight[0], 0, 0, 1, level),
                     BTF_ERROR_USAGE);
    assert_memory_equal(level, s.texels, sizeof level); /* nothing was written */
    btf_evaluator_destroy(&evaluator);
    clear(&s);
    const struct {
        uint32_t effects;
        btf_colour colour;
        const char *reason;
    } refused[] = {{BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF, BTF_COLOUR_NONE, "relief"},
                   {BTF_EFFECT_RESIDUAL | BTF_EFFECT_GLOSS, BTF_COLOUR_NONE, "gloss"},
                   {BTF_EFFECT_RESIDUAL, BTF_COLOUR_RGB, "SBRDF"}};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; ++i) {
        synthetic_spec spec = folds_of_roots;
        spec.effects = refused[i].effects;
        spec.colour = refused[i].colour;
        spec.lobes = spec.colour == BTF_COLOUR_NONE ? 0 : 1;
        btf_material *material = NULL;
        btf_material_info info = {.struct_size = sizeof info};
        btf_ref_material m;
        const btf_shader_options shader = {.struct_size = sizeof shader, .fold = BTF_FOLD_SUM};
        const btf_ref_options options = variant_reference_options(&shader);
        const float top[3] = {0, 0, 1};
        assert_int_equal(synthetic_create(&spec, &folds_log, &material), BTF_OK);
        btf_material_get_info(material, &info);
        reference_view(material, 0, &m);
        assert_int_equal(btf_material_fold_sum(material, &shader, 1, top, top, &folds_log, &texels),
                         BTF_ERROR_UNSUPPORTED);
        assert_null(texels);
        assert_non_null(strstr(folds_said, refused[i].reason));
        assert_int_equal(btf_fold_best_sum(&info, &shader, 0), BTF_FOLD_NONE);
        assert_false(btf_ref_can_fold(&m, &options, BTF_REF_FOLD_SUM));
        btf_material_close(&material);
    }
    btf_material_info many = {
        .struct_size = sizeof many, .colour = BTF_COLOUR_NONE, .n_views = 1024, .blend = BTF_BLEND_ROOTS};
    const btf_shader_options sum = {.struct_size = sizeof sum, .fold = BTF_FOLD_SUM};
    assert_int_equal(btf_fold_check(&many, &sum, &folds_log), BTF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(folds_said, "1024 views"));
    many.n_views = 1023;
    assert_int_equal(btf_fold_check(&many, &sum, &folds_log), BTF_OK);
}

RUN_TESTS(NULL, NULL)
