/* Refinement of hidden points against a brute-force search that was written independently.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/paper/norms.h"
#include "encoder/data/profiles.h"
#include "encoder/paper/refine.h"
#include "encoder/math/simd.h"
#include "tests/support/test.h"
#include "tests/support/uniform.h"

static const enc_context context = {.threads = 2};
static const enc_context one_thread = {.threads = 1};

static uint32_t random_state;

/* A BTF of noise, a model of noise, shadows of noise. */
typedef struct scene {
    enc_data *data;
    enc_sbrdf *sbrdf;
    uint8_t *shadow;
    enc_occlusion *occlusion;
} scene;

static scene make_scene(const enc_context *with, int width, int height, int n_views, int n_lights) {
    scene s = {0};
    random_state = 99;
    enc_direction views[8], lights[40];
    for (int v = 0; v < n_views; v++) {
        views[v] = enc_direction_from_angles(v == 0 ? 0 : 50, 40.0 * v);
    }
    for (int l = 0; l < n_lights; l++) {
        lights[l] = enc_direction_from_angles(l == 0 ? 0 : 10 + 70.0 * l / n_lights, 47.0 * l);
    }
    assert_int_equal(enc_data_create(with, width, height, n_views, views, n_lights, lights, &s.data),
                     BTF_OK);
    const size_t texels = enc_data_texel_count(s.data), stride = enc_data_texel_stride(s.data);
    float *samples = malloc(texels * stride * sizeof *samples);
    s.shadow = malloc(texels * (size_t)n_lights);
    assert_true(samples && s.shadow);
    const size_t profile = 3 * (size_t)n_lights;
    for (size_t i = 0; i < texels * stride;
         i += profile) { /* one profile in three is too bright to match */
        const float scale = uniform(&random_state) < 0.33f ? 2.5f : 1;
        for (size_t k = 0; k < profile; k++) {
            samples[i + k] = scale * uniform(&random_state);
        }
    }
    assert_int_equal(enc_data_store_texels(with, s.data, 0, texels, samples), BTF_OK);
    free(samples);
    assert_int_equal(enc_sbrdf_create(texels, 1, false, &s.sbrdf), BTF_OK);
    for (size_t t = 0; t < texels; t++) {
        float *p = s.sbrdf->values + t * enc_sbrdf_stride(1, false);
        p[0] = 1;
        for (int k = 1; k < 4; k++) {
            p[k] = 0.25f + 0.75f * uniform(&random_state);
        }
        p[4] = p[5] = -1;
        p[6] = 1;
        p[7] = 1 + 4 * uniform(&random_state);
    }
    for (size_t i = 0; i < texels * (size_t)n_lights; i++) {
        s.shadow[i] = (uint8_t)(uniform(&random_state) * 256);
    }
    assert_int_equal(enc_occlusion_create(n_views, texels, &s.occlusion), BTF_OK);
    for (size_t i = 0; i < (size_t)n_views * texels; i++) {
        s.occlusion->hidden[i] = i >= texels && uniform(&random_state) < 0.6f;
        s.occlusion->shift[2 * i] = (int8_t)(uniform(&random_state) * 5 - 2);
        s.occlusion->shift[2 * i + 1] = (int8_t)(uniform(&random_state) * 5 - 2);
    }
    return s;
}

static void free_scene(scene *s) {
    enc_occlusion_destroy(&s->occlusion);
    enc_sbrdf_destroy(&s->sbrdf);
    enc_data_destroy(&s->data);
    free(s->shadow);
}

/* STVS by the formula of sbrdf.h, in double. */
static double stvs(const scene *s, size_t texel, int view, int light, int channel) {
    const float *p = s->sbrdf->values + texel * enc_sbrdf_stride(1, false);
    const float *l = s->data->lights[light].xyz, *v = s->data->views[view].xyz;
    double base = 0;
    for (int k = 0; k < 3; k++) {
        base += (double)p[4 + k] * (double)l[k] * (double)v[k];
    }
    const double lobe = base > 0 ? pow(base, (double)p[7]) : 0;
    const double shadow = s->shadow[(size_t)light * s->sbrdf->n_texels + texel] / 255.0;
    return fmax((double)l[2], 0) * (double)p[channel] * ((double)p[3] + lobe) * shadow;
}

static double distance(const scene *s, size_t texel, int view, size_t source) {
    const int n = s->data->n_lights;
    const float *profile =
        s->data->samples + texel * enc_data_texel_stride(s->data) + (size_t)(view * 3 * n);
    double sum = 0;
    for (int l = 0; l < n; l++) {
        double square = 0;
        for (int c = 0; c < 3; c++) {
            const double d = (double)profile[c * n + l] - stvs(s, source, view, l, c);
            square += d * d;
        }
        sum += sqrt(square);
    }
    return sum;
}

TEST(test_against_brute_force) {
    enum { WIDTH = 9, HEIGHT = 7, TEXELS = WIDTH * HEIGHT, VIEWS = 3, LIGHTS = 21 };
    for (int size = 0; size < 3; size++) { /* whole tile, window 3 x 5, window 4 x 1 */
        static const int windows[3][2] = {{0, 0}, {3, 5}, {4, 1}};
        scene s = make_scene(&context, WIDTH, HEIGHT, VIEWS, LIGHTS);
        scene before = make_scene(&context, WIDTH, HEIGHT, VIEWS, LIGHTS);
        const enc_refine_options options = {.columns = windows[size][0], .rows = windows[size][1]};
        float thresholds[VIEWS];
        assert_int_equal(
            enc_refine(&context, s.data, s.sbrdf, s.shadow, 1 / 255.0f, &options, s.occlusion, thresholds),
            BTF_OK);
        int elevated = 0, kept = 0;
        for (int v = 0; v < VIEWS; v++) {
            double mean = 0;
            int n = 0;
            for (size_t t = 0; t < TEXELS; t++) {
                const size_t i = (size_t)(v * TEXELS) + t;
                const int8_t *shift = before.occlusion->shift + 2 * i;
                if (!before.occlusion->hidden[i]) {
                    mean += distance(&s, t, v, enc_occlusion_source(WIDTH, HEIGHT, t, shift[0], shift[1]));
                    n++;
                    assert_memory_equal(shift, s.occlusion->shift + 2 * i, 2);
                    assert_int_equal(s.occlusion->hidden[i], 0);
                }
            }
            mean /= n;
            assert_true(fabs(mean - (double)thresholds[v]) < 1e-5 * mean);
            for (size_t t = 0; t < TEXELS; t++) {
                const size_t i = (size_t)(v * TEXELS) + t;
                if (!before.occlusion->hidden[i]) {
                    continue;
                }
                const int w = size == 0 ? WIDTH : windows[size][0],
                          h = size == 0 ? HEIGHT : windows[size][1];
                double least = INFINITY;
                int best[2] = {0, 0};
                for (int y = -((h - 1) / 2); y <= h / 2; y++) {
                    for (int x = -((w - 1) / 2); x <= w / 2; x++) {
                        const double d = distance(&s, t, v, enc_occlusion_source(WIDTH, HEIGHT, t, x, y));
                        if (d < least) {
                            least = d;
                            best[0] = x;
                            best[1] = y;
                        }
                    }
                }
                assert_true(fabs(least - mean) > 1e-5); /* otherwise the case would test nothing */
                assert_int_equal(s.occlusion->hidden[i], least >= mean);
                const int8_t *shift = s.occlusion->shift + 2 * i;
                assert_int_equal(shift[0], best[0]);
                assert_int_equal(shift[1], best[1]);
                elevated += least < mean;
                kept += least >= mean;
            }
        }
        assert_true(elevated > 10);
        assert_true(size == 0 || kept > 10);
        free_scene(&s);
        free_scene(&before);
    }
}

/* Some hidden points have exactly the profile that the model gives at another texel. */
TEST(test_known_points_are_elevated) {
    enum { WIDTH = 12, HEIGHT = 10, TEXELS = 120, VIEWS = 2, LIGHTS = 20 };
    scene s = make_scene(&context, WIDTH, HEIGHT, VIEWS, LIGHTS);
    const int view = 1;
    memset(s.occlusion->hidden, 0, VIEWS * TEXELS);
    memset(s.occlusion->shift, 0, 2 * VIEWS * TEXELS);
    for (size_t t = 0; t < TEXELS; t++) {
        float *profile = s.data->samples + t * enc_data_texel_stride(s.data) + (size_t)view * 3 * LIGHTS;
        const bool known = t % 7 == 3, strange = t % 7 == 5;
        s.occlusion->hidden[TEXELS + t] = known || strange;
        const size_t source = enc_occlusion_source(WIDTH, HEIGHT, t, known ? 4 : 0, known ? -3 : 0);
        for (int l = 0; l < LIGHTS; l++) {
            for (int c = 0; c < 3; c++) {
                profile[c * LIGHTS + l] = strange ? 5
                                                  : (float)stvs(&s, source, view, l, c) +
                                                        (known ? 0 : 0.02f * uniform(&random_state));
            }
        }
    }
    assert_int_equal(enc_refine(&context, s.data, s.sbrdf, s.shadow, 1 / 255.0f, NULL, s.occlusion, NULL),
                     BTF_OK);
    for (size_t t = 0; t < TEXELS; t++) {
        const int8_t *shift = s.occlusion->shift + 2 * (TEXELS + t);
        assert_int_equal(s.occlusion->hidden[TEXELS + t], t % 7 == 5);
        if (t % 7 != 5) {
            assert_int_equal(shift[0], t % 7 == 3 ? 4 : 0);
            assert_int_equal(shift[1], t % 7 == 3 ? -3 : 0);
        }
    }
    free_scene(&s);
}

/* Beyond 64x64 texels the default window lies around the voted shift: a source 4 columns and 3 rows off a
 * vote is found, also where the centred window of 64x64 would not reach it. */
TEST(test_window_follows_the_vote) {
    enum { WIDTH = 90, HEIGHT = 80, TEXELS = WIDTH * HEIGHT, LIGHTS = 8 };
    static const int8_t vote[2] = {36, -34};
    scene s = make_scene(&context, WIDTH, HEIGHT, 2, LIGHTS);
    memset(s.occlusion->hidden, 0, 2 * TEXELS);
    memset(s.occlusion->shift, 0, 4 * TEXELS);
    for (size_t t = 3; t < TEXELS; t += 97) {
        float *profile = s.data->samples + t * enc_data_texel_stride(s.data) + 3 * LIGHTS;
        const size_t source = enc_occlusion_source(WIDTH, HEIGHT, t, vote[0] + 4, vote[1] - 3);
        s.occlusion->hidden[TEXELS + t] = 1;
        memcpy(s.occlusion->shift + 2 * (TEXELS + t), vote, 2);
        for (int l = 0; l < LIGHTS; l++) {
            for (int c = 0; c < 3; c++) {
                profile[c * LIGHTS + l] = (float)stvs(&s, source, 1, l, c);
            }
        }
    }
    assert_int_equal(enc_refine(&context, s.data, s.sbrdf, s.shadow, 1 / 255.0f, NULL, s.occlusion, NULL),
                     BTF_OK);
    for (size_t t = 3; t < TEXELS; t += 97) {
        const int8_t *shift = s.occlusion->shift + 2 * (TEXELS + t);
        assert_int_equal(s.occlusion->hidden[TEXELS + t], 0);
        assert_int_equal(shift[0], vote[0] + 4);
        assert_int_equal(shift[1], vote[1] - 3);
    }
    free_scene(&s);
}

TEST(test_view_without_known_points) {
    scene s = make_scene(&context, 6, 6, 2, 8);
    memset(s.occlusion->hidden + 36, 1, 36);
    float thresholds[2];
    assert_int_equal(
        enc_refine(&context, s.data, s.sbrdf, s.shadow, 1 / 255.0f, NULL, s.occlusion, thresholds), BTF_OK);
    assert_int_equal(enc_occlusion_hidden_count(s.occlusion, 1), 36);
    assert_true(thresholds[1] == 0);
    free_scene(&s);
}

TEST(test_ties_prefer_short_shifts) {
    enum { TEXELS = 64 };
    scene s = make_scene(&context, 8, 8, 2, 8);
    memset(s.sbrdf->values, 0, TEXELS * enc_sbrdf_stride(1, false) * sizeof(float));
    /* all sources are black, so all alike; one point that is not hidden is brighter than all others */
    for (size_t t = 0; t < TEXELS; t++) {
        s.occlusion->hidden[TEXELS + t] = t != 5;
        for (int k = 0; k < 24; k++) {
            s.data->samples[t * enc_data_texel_stride(s.data) + 24 + (size_t)k] = t == 5 ? 1 : 0.1f;
        }
    }
    assert_int_equal(enc_refine(&context, s.data, s.sbrdf, s.shadow, 1 / 255.0f, NULL, s.occlusion, NULL),
                     BTF_OK);
    assert_int_equal(enc_occlusion_hidden_count(s.occlusion, 1), 0);
    for (size_t t = 0; t < TEXELS; t++) {
        if (t != 5) {
            assert_true(s.occlusion->shift[2 * (TEXELS + t)] == 0 &&
                        s.occlusion->shift[2 * (TEXELS + t) + 1] == 0);
        }
    }
    free_scene(&s);
}

TEST(test_wide_tiles) {
    scene s = make_scene(&context, 300, 1, 2, 3);
    memset(s.occlusion->shift, 0, 2 * 2 * 300);
    assert_int_equal(enc_refine(&context, s.data, s.sbrdf, s.shadow, 1 / 255.0f, NULL, s.occlusion, NULL),
                     BTF_OK);
    int least = 0, most = 0;
    for (size_t t = 0; t < 300; t++) {
        const int shift = s.occlusion->shift[2 * (300 + t)];
        least = shift < least ? shift : least;
        most = shift > most ? shift : most;
        assert_int_equal(s.occlusion->shift[2 * (300 + t) + 1], 0);
    }
    assert_true(least < -100 && most > 100);
    free_scene(&s);
    s = make_scene(&context, 4, 4, 2, 3);
    const enc_refine_options wrong = {.columns = -1};
    assert_int_equal(enc_refine(&context, s.data, s.sbrdf, s.shadow, 1, &wrong, s.occlusion, NULL),
                     BTF_ERROR_USAGE);
    free_scene(&s);
}

/* Threads, instruction sets and where the samples lie change nothing. */
TEST(test_same_result_everywhere) {
    const enc_context tight = {.threads = 2, .memory = 1};
    scene first = make_scene(&one_thread, 16, 11, 3, 33);
    assert_int_equal(enc_refine(&one_thread, first.data, first.sbrdf, first.shadow, 1 / 255.0f, NULL,
                                first.occlusion, NULL),
                     BTF_OK);
    assert_true(enc_occlusion_hidden_count(first.occlusion, -1) > 0);
    for (int k = 0; k < 4; k++) {
        const enc_context *with = k == 3 ? &tight : &context;
        enc_isa_limit(k == 0 ? ENC_ISA_BASE : k == 1 ? ENC_ISA_AVX2 : ENC_ISA_AVX512);
        scene s = make_scene(with, 16, 11, 3, 33);
        assert_int_equal(enc_refine(with, s.data, s.sbrdf, s.shadow, 1 / 255.0f, NULL, s.occlusion, NULL),
                         BTF_OK);
        assert_memory_equal(s.occlusion->shift, first.occlusion->shift, 2 * 3 * 176);
        assert_memory_equal(s.occlusion->hidden, first.occlusion->hidden, 3 * 176);
        free_scene(&s);
    }
    free_scene(&first);
}

TEST(test_norms) {
    enum { LANES = 48 };
    random_state = 5;
    static float a[3 * LANES], b[3 * LANES];
    float base = -1;
    for (int i = 0; i < 3 * LANES; i++) {
        a[i] = uniform(&random_state) * 3;
        b[i] = uniform(&random_state);
    }
    double sum = 0, first = 0;
    for (int i = 0; i < LANES; i++) {
        double square = 0;
        for (int c = 0; c < 3; c++) {
            square += pow((double)a[c * LANES + i] - (double)b[c * LANES + i], 2);
        }
        sum += sqrt(square);
    }
    for (int i = 0; i < 16; i++) {
        first += sqrt(pow((double)a[i] - (double)b[i], 2) + pow((double)a[16 + i] - (double)b[16 + i], 2) +
                      pow((double)a[32 + i] - (double)b[32 + i], 2));
    }
    for (int isa = ENC_ISA_BASE; isa <= ENC_ISA_AVX512; isa++) {
        enc_isa_limit((enc_isa)isa);
        const enc_norms norms = enc_norms_choose();
        const float d = norms.distance(a, b, LANES);
        float bound[3];
        norms.bounds(a, b, 3, bound);
        assert_true(fabs((double)d - sum) < 1e-5 * sum);
        assert_true(fabs((double)bound[0] - first) < 1e-5 * first);
        assert_true(base < 0 || d == base);
        base = d;
        assert_true(norms.distance(a, a, LANES) == 0);
    }
}

RUN_TESTS(NULL, NULL)
