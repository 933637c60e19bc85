/* Levels of detail: the area filter against sums over a common subdivision; the fits of both methods against the
 * filtered data and against point samples of level 0; the same result for any number of threads; file and report; the
 * maps of levels in files of version 1.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/job/levels.h"
#include "encoder/job/settings.h"
#include "encoder/report/metrics.h"
#include "encoder/model/pack.h"
#include "encoder/model/decode_samples.h"
#include "encoder/report/report.h"
#include "encoder/model/unpack.h"
#include "tests/sample/sample.h"
#include "tests/support/test.h"

static const enc_context one_thread = {.threads = 1};
static const enc_context two_threads = {.threads = 2};

enum { VIEWS = 2, LIGHTS = 3, STRIDE = VIEWS * 3 * LIGHTS };

/* Noise of known seed, width x height texels. */
static enc_data *noise(int width, int height) {
    enc_direction views[VIEWS], lights[LIGHTS];
    enc_data *data = NULL;
    uint64_t state = 88172645463325252u;
    for (int i = 0; i < LIGHTS; i++) {
        lights[i] = enc_direction_from_angles(20.0 * i, 0.0);
    }
    for (int i = 0; i < VIEWS; i++) {
        views[i] = enc_direction_from_angles(30.0 * i, 0.0);
    }
    assert_int_equal(enc_data_create(&one_thread, width, height, VIEWS, views, LIGHTS, lights, &data),
                     BTF_OK);
    for (int i = 0; i < width * height * STRIDE; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        data->samples[i] = (float)(state >> 40) * 0x1p-20f; /* 0 .. 16 */
    }
    return data;
}

/* The mean over texel (c, r) of a w x h level from a subdivision that both grids share. */
static double by_subdivision(const enc_data *from, int w, int h, int c, int r, int sample) {
    double sum = 0;
    for (int y = r * from->height; y < (r + 1) * from->height; y++) {
        for (int x = c * from->width; x < (c + 1) * from->width; x++) {
            sum +=
                (double)from->samples[((size_t)(y / h) * (size_t)from->width + (size_t)(x / w)) * STRIDE +
                                      (size_t)sample];
        }
    }
    return sum / ((double)from->width * from->height);
}

static double mean(const enc_data *data) {
    const size_t n = enc_data_texel_count(data) * STRIDE;
    double sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum += (double)data->samples[i];
    }
    return sum / (double)n;
}

TEST(test_filter) {
    static const int sizes[][4] = {{7, 5, 3, 2}, {8, 6, 4, 3}, {5, 9, 2, 1},
                                   {9, 9, 1, 1}, {4, 3, 4, 3}, {1, 7, 1, 3}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        const int w = sizes[i][2], h = sizes[i][3];
        enc_data *from = noise(sizes[i][0], sizes[i][1]), *to = NULL;
        assert_int_equal(enc_level_filter(&two_threads, from, w, h, &to), BTF_OK);
        assert_int_equal(to->width, w);
        assert_int_equal(to->height, h);
        assert_memory_equal(to->lights, from->lights, LIGHTS * sizeof *to->lights);
        for (int t = 0; t < w * h; t++) {
            for (int s = 0; s < STRIDE; s++) {
                const double expected = by_subdivision(from, w, h, t % w, t / w, s);
                assert_true(fabs((double)to->samples[t * STRIDE + s] - expected) <= 1e-6 * expected);
            }
        }
        assert_true(fabs(mean(to) - mean(from)) <= 1e-6 * mean(from));
        enc_data_destroy(&to);
        enc_data_destroy(&from);
    }
}

/* A scratch file holds what memory would. */
TEST(test_filter_scratch) {
    enc_data *from = noise(7, 5), *to = NULL;
    const enc_context little = {.threads = 2, .memory = 64};
    float texel[STRIDE];
    const float *samples;
    assert_int_equal(enc_level_filter(&little, from, 3, 2, &to), BTF_OK);
    assert_null(to->samples);
    for (int t = 0; t < 6; t++) {
        assert_int_equal(enc_data_texels(&little, to, (size_t)t, 1, texel, &samples), BTF_OK);
        for (int s = 0; s < STRIDE; s++) {
            assert_true(fabs((double)samples[s] - by_subdivision(from, 3, 2, t % 3, t / 3, s)) <= 1e-5);
        }
    }
    enc_data_destroy(&to);
    enc_data_destroy(&from);
}

/* Visits every level: sizes, the filter of each, constants. */
typedef struct visit {
    const enc_data *base;
    int levels;
} visit;

static btf_result visit_level(void *user, int level, const enc_data *data) {
    visit *v = user;
    assert_int_equal(level, ++v->levels);
    assert_int_equal(data->width, enc_level_side(v->base->width, level));
    assert_int_equal(data->height, enc_level_side(v->base->height, level));
    for (int t = 0; t < data->width * data->height; t++) {
        for (int s = 0; s < STRIDE; s++) {
            const double expected =
                by_subdivision(v->base, data->width, data->height, t % data->width, t / data->width, s);
            assert_true(fabs((double)data->samples[t * STRIDE + s] - expected) <= 1e-6 * expected);
        }
    }
    return BTF_OK;
}

TEST(test_each) {
    assert_int_equal(enc_level_count(64, 64), 7);
    assert_int_equal(enc_level_count(5, 3), 3);
    assert_int_equal(enc_level_count(1, 1), 1);
    enc_data *data = noise(13, 6);
    visit v = {.base = data};
    assert_int_equal(enc_level_each(&two_threads, data, enc_level_count(13, 6), visit_level, &v), BTF_OK);
    assert_int_equal(v.levels, 3);
    enc_data_destroy(&data);
}

/* A sample material with few directions. */
static enc_data *sample(relief_kind relief, int size) {
    static const int ring[] = {1, 6, 9};
    enc_direction list[16];
    enc_data *data = NULL;
    int count = 0;
    for (int r = 0; r < 3; r++) {
        for (int i = 0; i < ring[r]; i++) {
            list[count++] = enc_direction_from_angles(30.0 * r, 360.0 * i / ring[r]);
        }
    }
    const sample_options options = {.context = &two_threads,
                                    .relief = relief,
                                    .width = size,
                                    .height = size,
                                    .grid = 256, /* a relief of few cells, which is made faster */
                                    .views = list,
                                    .n_views = count,
                                    .lights = list,
                                    .n_lights = count};
    assert_int_equal(sample_render(&options, &data, NULL), BTF_OK);
    return data;
}

/* Images as a renderer without levels shows them at a lower resolution: one texel of level 0 for each block. */
typedef struct points {
    enc_image_source images;
    int width, height, w, h, lights;
} points;

static btf_result point_view(const void *user, int view, float *out) {
    const points *p = user;
    const size_t image = (size_t)p->width * (size_t)p->height * 3;
    float *all = malloc((size_t)p->lights * image * sizeof *all);
    assert_non_null(all);
    assert_int_equal(p->images.view(p->images.user, view, all), BTF_OK);
    for (int l = 0; l < p->lights; l++) {
        for (int r = 0; r < p->h; r++) {
            for (int c = 0; c < p->w; c++) {
                const size_t x = (size_t)((2 * c + 1) * p->width / (2 * p->w)),
                             y = (size_t)((2 * r + 1) * p->height / (2 * p->h));
                memcpy(out + 3 * (((size_t)l * (size_t)p->h + (size_t)r) * (size_t)p->w + (size_t)c),
                       all + (size_t)l * image + 3 * (y * (size_t)p->width + x), 3 * sizeof(float));
            }
        }
    }
    free(all);
    return BTF_OK;
}

typedef struct compare_pass {
    const enc_data *base;
    const enc_sample_decoder *decoder;
    double psnr[8]; /* of point samples, by level */
} compare_pass;

static btf_result compare_points(void *user, int level, const enc_data *data) {
    compare_pass *pass = user;
    const enc_decoded_samples played = {.decoder = pass->decoder, .effects = BTF_EFFECT_ALL};
    const points p = {enc_decoded_images(&played),
                      pass->base->width,
                      pass->base->height,
                      data->width,
                      data->height,
                      data->n_lights};
    enc_metrics metrics;
    assert_int_equal(enc_metrics_compare(&one_thread, data, enc_data_images(data),
                                         (enc_image_source){.view = point_view, .user = &p}, false,
                                         &metrics),
                     BTF_OK);
    pass->psnr[level] = enc_psnr_linear(&metrics.total);
    return BTF_OK;
}

/* Every level must show the filtered data better than point samples of level 0 do, by `margin` dB, and no
 * worse than `least`. */
static void check_levels(const char *name, const enc_data *data, const enc_solution *base,
                         const enc_levels *levels, double margin, double least) {
    enc_metrics metrics[8];
    compare_pass pass = {.base = data};
    enc_sample_decoder *decoder = NULL;
    assert_int_equal(enc_sample_decoder_create(&one_thread, data, base, &decoder), BTF_OK);
    pass.decoder = decoder;
    assert_int_equal(enc_levels_measure(&one_thread, data, levels, metrics), BTF_OK);
    assert_int_equal(enc_level_each(&one_thread, data, levels->count, compare_points, &pass), BTF_OK);
    for (int i = 1; i < levels->count; i++) {
        const double psnr = enc_psnr_linear(&metrics[i - 1].total);
        printf("%s, level %d: %.2f dB, point samples of level 0 %.2f dB\n", name, i, psnr, pass.psnr[i]);
        assert_true(psnr >= least);
        assert_true(psnr >= pass.psnr[i] + margin);
    }
    enc_sample_decoder_destroy(&decoder);
}

static void same(const void *a, const void *b, size_t size) {
    assert_int_equal(a != NULL, b != NULL);
    if (a) {
        assert_memory_equal(a, b, size);
    }
}

/* Packs a solution, writes it to a file in memory and reads it back: every map is unchanged. */
static void check_round_trip(const enc_data *data, const enc_solution *base, const enc_levels *levels) {
    const btf_level_error errors[] = {{0, 30, 29, 1000}, {1, 31, 30, 250}};
    const enc_pack_options options = {.layout = BTF_LAYOUT_TIGHT,
                                      .levels = levels->count,
                                      .level = levels->level,
                                      .level_errors = errors,
                                      .level_error_count = 2};
    btf_material *made = NULL, *read = NULL;
    enc_solution back;
    enc_levels found;
    void *file = NULL;
    size_t size, count;
    assert_int_equal(enc_pack(&one_thread, data, base, &options, &made), BTF_OK);
    assert_int_equal(btf_material_save_memory(made, NULL, &file, &size), BTF_OK);
    assert_int_equal(btf_material_open_memory(file, size, NULL, &read), BTF_OK);
    assert_int_equal(enc_unpack(&one_thread, read, &back), BTF_OK);
    assert_int_equal(enc_levels_unpack(&one_thread, read, &back, &found), BTF_OK);
    assert_int_equal(found.count, levels->count);
    const btf_level_error *stored = btf_material_level_errors(read, &count);
    assert_int_equal(count, 2);
    assert_memory_equal(stored, errors, sizeof errors);
    for (int i = 0; i + 1 < found.count; i++) {
        const enc_solution *a = &levels->level[i], *b = &found.level[i];
        const size_t texels = enc_solution_texels(a), points = texels * (size_t)a->n_views;
        assert_int_equal(enc_solution_texels(b), texels);
        same(a->shadow, b->shadow, texels * (size_t)a->n_lights);
        same(a->residual_texels, b->residual_texels, texels * a->n_components);
        same(a->factors.texels, b->factors.texels, 16 * texels * a->factors.layers);
        assert_ptr_equal(b->residual_directions, back.residual_directions);
        assert_ptr_equal(b->factors.directions, back.factors.directions);
        assert_ptr_equal(b->centre_codes, back.centre_codes);
        assert_int_equal(a->sbrdf != NULL, b->sbrdf != NULL);
        if (a->sbrdf) {
            assert_memory_equal(a->sbrdf->values, b->sbrdf->values,
                                texels * enc_sbrdf_stride(a->sbrdf->lobes, a->sbrdf->rgb) * sizeof(float));
        }
        for (size_t p = 0; p < points; p++) {
            if (a->gain) {
                assert_int_equal(a->gain[p], b->gain[p]);
            }
            if (a->gain && a->gain[p] == 0) {
                assert_int_equal(a->centre[p], b->centre[p]);
            } else if (a->shift) {
                assert_memory_equal(a->shift + 2 * p, b->shift + 2 * p, 2);
            }
        }
    }
    same(base->centre_codes, back.centre_codes, (size_t)base->n_centres * (size_t)base->n_lights * 3);
    enc_levels_clear(&found);
    enc_solution_clear(&back);
    btf_material_close(&read);
    btf_material_close(&made);
    btf_free(file);
}

static void fit_joint(const enc_data *data, int count, const enc_context *context, enc_solution *base,
                      enc_levels *levels) {
    enc_job job = {.joint = enc_joint_options_default()};
    job.joint.preset = ENC_PRESET_FAST;
    job.joint.tolerance = 0;
    const enc_factors_settings settings =
        enc_settings_of_factors(&job, data->width, data->height, data->n_views, data->n_lights);
    enc_factors_stats stats;
    assert_int_equal(enc_factors_solve(context, data, &settings, base, &stats), BTF_OK);
    assert_int_equal(enc_levels_fit(context, data, count, NULL, NULL, base, levels), BTF_OK);
    assert_int_equal(levels->count, count);
}

TEST(test_joint) {
    static const struct {
        const char *name;
        relief_kind relief;
    } kinds[] = {{"bricks", RELIEF_BRICKS}, {"weave", RELIEF_WEAVE}};
    const bool light = getenv("BTF_TEST_LIGHT") != NULL;
    const int count = light ? 1 : 2;
    for (int i = 0; i < count; i++) {
        enc_data *data = sample(kinds[i].relief, light ? 12 : 24);
        enc_solution base;
        enc_levels levels;
        fit_joint(data, 4, &one_thread, &base, &levels);
        check_levels(kinds[i].name, data, &base, &levels, 12, 36);
        check_round_trip(data, &base, &levels);
        enc_levels_clear(&levels);
        enc_solution_clear(&base);
        enc_data_destroy(&data);
    }
}

/* The next codes of a sequence that is the same in every run. */
static void fill(void *to, size_t size, int low, int high) {
    static uint32_t state = 1;
    uint8_t *bytes = to;
    assert_non_null(to);
    for (size_t i = 0; i < size; i++) {
        state = state * 1664525u + 1013904223u;
        bytes[i] = (uint8_t)(low + (int)((state >> 16) % (uint32_t)(high - low + 1)));
    }
}

/* The maps that a level of version 1 has for itself: SBRDF times shadow, shifts, gains, texels of a residual
 * of low rank. */
static void fill_level(enc_solution *s) {
    const size_t texels = enc_solution_texels(s), points = texels * (size_t)s->n_views;
    assert_int_equal(enc_sbrdf_create(texels, 2, true, &s->sbrdf), BTF_OK);
    for (size_t i = 0; i < texels * enc_sbrdf_stride(2, true); i++) {
        s->sbrdf->values[i] = 0.125f * (float)(1 + i % 13);
    }
    s->shadow = malloc(texels * (size_t)s->n_lights);
    fill(s->shadow, texels * (size_t)s->n_lights, 0, 255);
    s->shift = malloc(2 * points);
    fill(s->shift, 2 * points, 0, 3);
    s->gain = malloc(points);
    fill(s->gain, points, 1, 255);
    s->residual_texels = malloc(texels * s->n_components);
    fill(s->residual_texels, texels * s->n_components, -127, 127);
}

/* Levels of version 1, which the encoder no longer writes, are still read back unchanged. */
TEST(test_version_1) {
    enum { COMPONENTS = 8, SIZE = 12 };
    enc_data *data = sample(RELIEF_BRICKS, SIZE);
    const size_t directions = (size_t)data->n_views * (size_t)data->n_lights * 3 * COMPONENTS;
    enc_levels levels = {.count = 3, .level = calloc(2, sizeof *levels.level)};
    enc_solution base = {.width = SIZE,
                         .height = SIZE,
                         .n_views = data->n_views,
                         .n_lights = data->n_lights,
                         .domain = BTF_DOMAIN_SQRT,
                         .effects =
                             BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL,
                         .radiance_scale = 1,
                         .shadow_scale = 1 / 255.0f,
                         .gain_scale = BTF_GAIN_SCALE,
                         .n_components = COMPONENTS,
                         .residual_directions = malloc(directions),
                         .residual_scales = malloc(COMPONENTS * sizeof(float))};
    assert_non_null(levels.level);
    fill(base.residual_directions, directions, -127, 127);
    for (int i = 0; i < COMPONENTS; i++) {
        base.residual_scales[i] = 0x1p-12f;
    }
    fill_level(&base);
    for (int i = 0; i < 2; i++) {
        levels.level[i] = enc_level_of(&base, SIZE >> (i + 1), SIZE >> (i + 1));
        fill_level(&levels.level[i]);
    }
    check_round_trip(data, &base, &levels);
    enc_levels_clear(&levels);
    enc_solution_clear(&base);
    enc_data_destroy(&data);
}

TEST(test_threads) {
    enc_data *data = sample(RELIEF_BUMPS, 11);
    enc_solution base[2];
    enc_levels levels[2];
    fit_joint(data, 4, &one_thread, &base[0], &levels[0]);
    fit_joint(data, 4, &two_threads, &base[1], &levels[1]);
    for (int l = 0; l < 3; l++) {
        const enc_solution *a = &levels[0].level[l], *b = &levels[1].level[l];
        const size_t texels = enc_solution_texels(a);
        assert_int_equal(texels, (11 >> (l + 1)) * (11 >> (l + 1)));
        assert_memory_equal(a->factors.texels, b->factors.texels, 16 * texels * a->factors.layers);
        if (a->shift) {
            assert_memory_equal(a->shift, b->shift, 2 * texels * (size_t)a->n_views);
        }
        if (a->gain) {
            assert_memory_equal(a->gain, b->gain, texels * (size_t)a->n_views);
        }
    }
    for (int i = 0; i < 2; i++) {
        enc_levels_clear(&levels[i]);
        enc_solution_clear(&base[i]);
    }
    enc_data_destroy(&data);
}

TEST(test_paper) {
    enc_data *data = sample(RELIEF_BRICKS, 24);
    enc_paper_options options = enc_paper_options_default();
    enc_paper_stats stats;
    enc_solution base;
    enc_levels levels;
    assert_int_equal(enc_paper(&one_thread, data, &options, &base, NULL, &stats), BTF_OK);
    assert_true(base.effects & BTF_EFFECT_HIDDEN);
    const uint32_t before = base.n_centres;
    assert_int_equal(enc_levels_fit(&one_thread, data, 4, &options, NULL, &base, &levels), BTF_OK);
    assert_true(base.n_centres > before);
    check_levels("bricks, paper", data, &base, &levels, 3, 24);
    check_round_trip(data, &base, &levels);
    for (int l = 0; l < 3; l++) {
        const enc_solution *s = &levels.level[l];
        assert_ptr_equal(s->centre_codes, base.centre_codes);
        assert_int_equal(s->n_centres, base.n_centres);
        size_t hidden = 0;
        for (size_t i = 0; i < enc_solution_texels(s) * (size_t)s->n_views; i++) {
            if (s->gain[i] == 0) {
                hidden++;
                assert_in_range(s->centre[i], before, base.n_centres - 1);
            }
        }
        printf("level %d: %zu hidden points\n", l + 1, hidden);
    }
    enc_levels_clear(&levels);
    enc_solution_clear(&base);
    enc_data_destroy(&data);
}

/* The report's table of levels, and the rows of the file that come from it. */
TEST(test_report) {
    enc_data *data = sample(RELIEF_BRICKS, 8);
    enc_solution base;
    enc_levels levels;
    btf_material *material = NULL;
    btf_level_error rows[BTF_MAX_LEVELS];
    enc_report *report = calloc(1, sizeof *report);
    assert_non_null(report);
    fit_joint(data, 3, &one_thread, &base, &levels);
    const enc_pack_options options = {
        .layout = BTF_LAYOUT_TIGHT, .levels = levels.count, .level = levels.level};
    assert_int_equal(enc_pack(&one_thread, data, &base, &options, &material), BTF_OK);
    assert_int_equal(enc_report_measure(&two_threads, data, &base, material, report), BTF_OK);
    assert_int_equal(enc_report_measure_levels(&two_threads, data, &levels, material, report), BTF_OK);
    assert_int_equal(enc_report_level_errors(report, rows), 3);
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    size_t bytes = 0;
    for (uint32_t i = 0; i < 3; i++) {
        assert_int_equal(rows[i].level, i);
        assert_int_equal(report->level[i].width, 8 >> i);
        assert_true(rows[i].psnr_linear > 20 && rows[i].psnr_linear < 100);
        bytes += report->level[i].gpu_bytes;
    }
    assert_int_equal(bytes, info.gpu_bytes);
    assert_int_equal(report->level[1].gpu_bytes, 4 * report->level[2].gpu_bytes);
    assert_true(report->level[0].psnr_linear ==
                enc_psnr_linear(&report->ladder[report->n_ladder - 1].metrics.total));
    btf_material_close(&material);
    enc_levels_clear(&levels);
    enc_solution_clear(&base);
    enc_data_destroy(&data);
    free(report);
}

RUN_TESTS(NULL, NULL)
