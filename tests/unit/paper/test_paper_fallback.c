/* The fallback of `--method paper` (encoder/paper/diffuse_fallback.h): when a diffuse fit replaces the model, what
 * error it leaves, and when it does not.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/paper/diffuse_fallback.h"
#include "encoder/paper/paper.h"
#include "tests/support/test.h"

#include <openbtf/material.h>

enum { SIDE = 4, TEXELS = SIDE * SIDE, DIRECTIONS = 13, PAIRS = DIRECTIONS * DIRECTIONS };

static const enc_context one_thread = {.threads = 1};

/* A plane of varying colour with a highlight; every `period`-th sample, where that is not 0, is `stray`. */
static double sample(int texel, const enc_direction *v, const enc_direction *l, int pair, int channel,
                     int period, double stray) {
    const double base =
        1.1 * (-(double)l->xyz[0] * (double)v->xyz[0] - (double)l->xyz[1] * (double)v->xyz[1]) +
        0.95 * (double)l->xyz[2] * (double)v->xyz[2];
    const double albedo = 0.2 + 0.1 * (texel % 4) + 0.05 * channel;
    return period > 0 && (31 * pair + 7 * texel) % period == 0
               ? stray
               : (double)l->xyz[2] * (albedo + 0.4 * pow(fmax(base, 0), 12));
}

static enc_data *make_data(const enc_context *context, int period, double stray) {
    enc_direction list[DIRECTIONS];
    enc_data *data = NULL;
    for (int i = 0; i < DIRECTIONS; i++) {
        list[i] = enc_direction_from_angles(i == 0 ? 0 : i < 7 ? 30 : 60, 60.0 * ((i + 5) % 6));
    }
    assert_int_equal(enc_data_create(context, SIDE, SIDE, DIRECTIONS, list, DIRECTIONS, list, &data),
                     BTF_OK);
    float *texel = malloc(enc_data_texel_stride(data) * sizeof *texel);
    assert_non_null(texel);
    for (int t = 0; t < TEXELS; t++) {
        for (int v = 0; v < DIRECTIONS; v++) {
            for (int c = 0; c < 3; c++) {
                for (int l = 0; l < DIRECTIONS; l++) {
                    texel[(v * 3 + c) * DIRECTIONS + l] =
                        (float)sample(t, list + v, list + l, v * DIRECTIONS + l, c, period, stray);
                }
            }
        }
        assert_int_equal(enc_data_store_texels(context, data, (size_t)t, 1, texel), BTF_OK);
    }
    free(texel);
    assert_int_equal(enc_data_complete(context, data, BTF_OK), BTF_OK);
    return data;
}

static enc_paper_options options_of(bool rgb, bool choose) {
    enc_paper_options options = enc_paper_options_default();
    options.fit.rgb = rgb;
    options.fit.starts = 2;
    options.choose = choose;
    options.fallback = true;
    return options;
}

/* The albedo that is nearest to the samples of a texel. */
static double albedo_of(const enc_data *data, int texel, int channel, int period, double stray) {
    double aa = 0, ab = 0;
    for (int v = 0; v < DIRECTIONS; v++) {
        for (int l = 0; l < DIRECTIONS; l++) {
            const double a = (double)data->lights[l].xyz[2];
            aa += a * a;
            ab += a * (double)(float)sample(texel, data->views + v, data->lights + l, v * DIRECTIONS + l,
                                            channel, period, stray);
        }
    }
    return ab / aa;
}

static void assert_diffuse(const enc_data *data, const enc_solution *s, int period, double stray) {
    const bool rgb = s->sbrdf->rgb;
    const size_t stride = enc_sbrdf_stride(s->sbrdf->lobes, rgb), head = rgb ? 3 : 4;
    for (int t = 0; t < TEXELS; t++) {
        const float *p = s->sbrdf->values + (size_t)t * stride;
        for (int c = 0; c < 3; c++) {
            const double seen = (double)p[c] * (rgb ? 1 : (double)p[3]);
            const double want = albedo_of(data, t, c, period, stray);
            assert_true(fabs(seen - want) <= 1e-6 * want);
        }
        for (size_t i = head; i < stride; i++) {
            assert_true(p[i] == 0);
        }
    }
}

typedef struct heard {
    int warnings;
    char text[500];
} heard;

static void hear(void *user, btf_log_level level, const char *text) {
    heard *h = user;
    if (level == BTF_LOG_WARNING) {
        h->warnings++;
        strncpy(h->text, text, sizeof h->text - 1);
    }
}

/* One sample in 97 is 65504, which makes the rejection count all dark samples as shadow. */
TEST(test_taken) {
    for (int rgb = 0; rgb < 2; rgb++) {
        heard h = {0};
        const enc_context context = {.threads = 1, .log = {hear, &h}};
        enc_data *data = make_data(&context, 97, 65504);
        const enc_paper_options options = options_of(rgb, true);
        enc_solution s;
        enc_paper_stats stats;
        assert_int_equal(enc_paper(&context, data, &options, &s, NULL, &stats), BTF_OK);
        assert_true(stats.diffuse);
        assert_int_equal(s.effects, 0);
        assert_null(s.shadow);
        assert_null(s.shift);
        assert_null(s.gain);
        assert_null(s.centre_codes);
        assert_int_equal(s.n_centres, 0);
        assert_diffuse(data, &s, 97, 65504);
        assert_string_equal(stats.trials[stats.trials_count - 1].verdict, "diffuse fit: taken");
        assert_int_equal(h.warnings, 1);
        assert_non_null(strstr(h.text, "diffuse fit"));
        enc_solution_clear(&s);
        enc_data_destroy(&data);
    }
}

/* Effects that were asked for stay in the file, with maps that have no effect. */
TEST(test_effects_asked_for) {
    enc_data *data = make_data(&one_thread, 97, 65504);
    enc_paper_options options = options_of(false, false);
    options.effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT;
    enc_solution s;
    enc_paper_stats stats;
    assert_int_equal(enc_paper(&one_thread, data, &options, &s, NULL, &stats), BTF_OK);
    assert_true(stats.diffuse);
    assert_int_equal(s.effects, BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT);
    assert_non_null(s.shadow);
    assert_non_null(s.shift);
    assert_non_null(s.gain);
    for (size_t i = 0; i < DIRECTIONS * TEXELS; i++) {
        assert_int_equal(s.shadow[i], 255);
        assert_int_equal(s.gain[i], BTF_GAIN_ONE);
        assert_int_equal(s.shift[2 * i] | s.shift[2 * i + 1], 0);
    }
    assert_diffuse(data, &s, 97, 65504);
    enc_solution_clear(&s);
    enc_data_destroy(&data);
}

/* A model whose lobes fit is not replaced. */
TEST(test_left_alone) {
    static const int periods[] = {0, 1999};
    for (int i = 0; i < 2; i++) {
        heard h = {0};
        const enc_context context = {.threads = 1, .log = {hear, &h}};
        enc_data *data = make_data(&context, periods[i], 1e5);
        const enc_paper_options options = options_of(false, true);
        enc_solution s;
        enc_paper_stats stats;
        assert_int_equal(enc_paper(&context, data, &options, &s, NULL, &stats), BTF_OK);
        assert_false(stats.diffuse);
        assert_int_equal(h.warnings, 0);
        bool lobe = false;
        for (int t = 0; t < TEXELS; t++) {
            lobe = lobe || s.sbrdf->values[(size_t)t * enc_sbrdf_stride(3, false) + 7] > 0;
        }
        assert_true(lobe);
        enc_solution_clear(&s);
        enc_data_destroy(&data);
    }
}

/* Stray samples are added to the data after the fit. The diffuse fit, which saw them, has a slightly smaller squared
 * error; but fewer than one stray sample in a thousand do not decide. */
TEST(test_few_strays) {
    static const int periods[] = {97, 1999};
    for (int i = 0; i < 2; i++) {
        enc_data *plain = make_data(&one_thread, 0, 0), *data = make_data(&one_thread, periods[i], 1e5);
        enc_paper_options options = options_of(false, true);
        options.effects = 0;
        enc_solution s;
        enc_paper_stats stats;
        assert_int_equal(enc_paper(&one_thread, plain, &options, &s, NULL, &stats), BTF_OK);
        assert_false(stats.diffuse);
        assert_int_equal(enc_paper_fallback(&one_thread, data, &options, &s, NULL, &stats), BTF_OK);
        assert_int_equal(stats.diffuse, periods[i] == 97);
        enc_solution_clear(&s);
        enc_data_destroy(&plain);
        enc_data_destroy(&data);
    }
}

/* The same bits by three threads and from a scratch file. */
TEST(test_same_bits) {
    const enc_context contexts[] = {{.threads = 1}, {.threads = 3}, {.threads = 2, .memory = 4096}};
    enc_solution s[3];
    for (int i = 0; i < 3; i++) {
        enc_data *data = make_data(&contexts[i], 97, 65504);
        assert_true(!data->samples == (i == 2));
        enc_paper_options options = options_of(false, true);
        options.effects = BTF_EFFECT_SHADOW;
        enc_paper_stats stats;
        assert_int_equal(enc_paper(&contexts[i], data, &options, &s[i], NULL, &stats), BTF_OK);
        assert_true(stats.diffuse);
        assert_memory_equal(s[i].sbrdf->values, s[0].sbrdf->values,
                            TEXELS * enc_sbrdf_stride(3, false) * sizeof(float));
        enc_data_destroy(&data);
    }
    for (int i = 0; i < 3; i++) {
        enc_solution_clear(&s[i]);
    }
}

RUN_TESTS(NULL, NULL)
