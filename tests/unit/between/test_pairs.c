/* Sets of images at arbitrary pairs of directions: when a folder is taken for one, how it is read, what is refused, and
 * the errors that are measured against it.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/exr_image.h"
#include "decoder/toolkit/reference_view.h"
#include "encoder/between/decode.h"
#include "encoder/between/pairs.h"
#include "encoder/report/between.h"
#include "tests/support/image_set.h"
#include "tests/support/random_material.h"
#include "tests/support/test.h"

enum { COUNT = 6 };
static const enc_read_options defaults;
static const double angles[COUNT][4] = {{12.5, 30, 40.25, 110},  {3.14, 359.9, 71.5, 0.5},
                                        {60, 10, 0, 0},          {22, 200, 33.75, 45},
                                        {74, 123.4, 10.01, 300}, {45, 45, 50, 250}};

/* An image of one value. */
static void write_image(const char *name, int width, int height, float value) {
    char path[2 * PATH];
    float *pixels = malloc(3 * (size_t)(width * height) * sizeof *pixels);
    for (int i = 0; i < 3 * width * height; i++) {
        pixels[i] = value;
    }
    snprintf(path, sizeof path, "%s/%s", temporary_folder, name);
    assert_int_equal(exr_image_write(path, width, height, pixels, false, set_no_log), BTF_OK);
    free(pixels);
}

static const char *name_of(const double a[4]) {
    static char name[PATH];
    snprintf(name, sizeof name, "tl%g_pl%g_tv%g_pv%g.exr", a[0], a[1], a[2], a[3]);
    return name;
}

static void write_pairs(void) {
    for (int i = 0; i < COUNT; i++) {
        write_image(name_of(angles[i]), W, H, 0.1f * (float)(i + 1));
    }
}

static void expect_set(enc_image_set expected) {
    enc_image_set set;
    assert_int_equal(enc_pairs_classify(&set_context, temporary_folder, &defaults, &set), BTF_OK);
    assert_int_equal(set, expected);
}

SET_TEST(test_what_a_set_is) {
    write_pairs();
    expect_set(ENC_SET_PAIRS);
}

SET_TEST(test_a_grid_is_a_grid) {
    char path[PATH];
    set_write(FOLDERS);
    expect_set(ENC_SET_GRID);
    /* a grid that lacks images is refused as damaged, and not taken for a set of pairs */
    snprintf(path, sizeof path, "%s", set_name_of(FOLDERS, 1, 2, "png"));
    assert_int_equal(remove(path), 0);
    expect_set(ENC_SET_GRID);
}

/* The light goes around under one view: a grid of 1 x 4, but without a view from the top it is no data set, so it is
 * read as pairs. */
SET_TEST(test_an_orbit_is_pairs) {
    for (int i = 0; i < 4; i++) {
        write_image(name_of((const double[4]){30, 90 * i, 40, 0}), W, H, 0.5f);
    }
    expect_set(ENC_SET_PAIRS);
}

static enc_pairs *open_pairs(const enc_read_options *options) {
    enc_pairs *pairs = NULL;
    if (enc_pairs_open(&set_context, temporary_folder, options, &pairs) != BTF_OK) {
        fail_msg("not opened: %s", all_messages);
    }
    return pairs;
}

SET_TEST(test_names_and_values) {
    float image[3 * W * H];
    write_pairs();
    enc_pairs *pairs = open_pairs(&defaults);
    assert_int_equal(pairs->count, COUNT);
    assert_int_equal(pairs->width, W);
    assert_int_equal(pairs->height, H);
    for (size_t p = 0; p < COUNT; p++) {
        int found = -1;
        for (int i = 0; i < COUNT; i++) {
            if (pairs->pair[p].light.theta == angles[i][0] && pairs->pair[p].light.phi == angles[i][1] &&
                pairs->pair[p].view.theta == angles[i][2] && pairs->pair[p].view.phi == angles[i][3]) {
                found = i;
            }
        }
        assert_true(found >= 0);
        assert_string_equal(pairs->pair[p].name, name_of(angles[found]));
        assert_true(fabs(pairs->pair[p].view.xyz[2] - cos(angles[found][2] * 3.14159265358979 / 180)) <
                    1e-6);
        assert_int_equal(enc_pairs_read(&set_context, pairs, p, image), BTF_OK);
        for (int i = 0; i < 3 * W * H; i++) {
            assert_true(image[i] == 0.1f * (float)(found + 1));
        }
    }
    enc_pairs_close(&pairs);
}

/* The options that change how a data set is read apply to pairs, too. */
SET_TEST(test_options) {
    const enc_read_options options = {.azimuth_cw = true,
                                      .azimuth_offset = 90,
                                      .crop = {1, 0, 4, 4},
                                      .size = {2, 2},
                                      .cosine = ENC_COSINE_MISSING};
    float image[3 * 2 * 2];
    write_image("tl60_pl30_tv20_pv200.exr", W, H, 0.5f);
    enc_pairs *pairs = open_pairs(&options);
    assert_true(pairs->pair[0].light.phi == 60 && pairs->pair[0].view.phi == 250);
    assert_true(pairs->width == 2 && pairs->height == 2);
    assert_int_equal(enc_pairs_read(&set_context, pairs, 0, image), BTF_OK);
    for (int i = 0; i < 3 * 2 * 2; i++) {
        assert_true(fabsf(image[i] - 0.25f) < 1e-6f);
    }
    enc_pairs_close(&pairs);
}

/* Opening the pairs, or reading one of them, must give `expected`, with a message that holds all of the words. */
static void expect_refused(const enc_read_options *options, btf_result expected, const char *word,
                           const char *other) {
    enc_pairs *pairs = NULL;
    float *image = malloc(3 * 64 * 64 * sizeof *image);
    all_messages[0] = '\0';
    btf_result result = enc_pairs_open(&set_context, temporary_folder, options, &pairs);
    for (size_t p = 0; result == BTF_OK && p < pairs->count; p++) {
        result = enc_pairs_read(&set_context, pairs, p, image);
    }
    assert_int_equal(result, expected);
    if (!strstr(all_messages, word) || !strstr(all_messages, other)) {
        fail_msg("neither '%s' nor '%s' may lack in: %s", word, other, all_messages);
    }
    enc_pairs_close(&pairs);
    free(image);
}

SET_TEST(test_refusals) {
    const enc_read_options components = {.components = 3};
    write_pairs();
    expect_refused(&components, BTF_ERROR_USAGE, "components", temporary_folder);
}

/* An image whose name holds no angles is left out with a warning, as in a data set. A set of such images is refused,
 * unless a table of names lies beside them. */
SET_TEST(test_names_that_say_nothing) {
    write_image("frame7.exr", W, H, 0.5f);
    expect_refused(&defaults, BTF_ERROR_BAD_FILE, "frame7.exr", "tl, pl, tv and pv");
    char path[2 * PATH];
    snprintf(path, sizeof path, "%s/directions.csv", temporary_folder);
    FILE *table = fopen(path, "w");
    assert_non_null(table);
    fputs("file,theta_v,phi_v,theta_l,phi_l\nframe7.exr,20.5,40,60,350\n", table);
    fclose(table);
    enc_pairs *pairs = open_pairs(&defaults);
    assert_int_equal(pairs->count, 1);
    assert_true(pairs->pair[0].view.theta == 20.5 && pairs->pair[0].light.phi == 350);
    enc_pairs_close(&pairs);
    expect_set(ENC_SET_PAIRS);
    write_pairs();
    all_messages[0] = '\0';
    pairs = open_pairs(&defaults);
    assert_int_equal(pairs->count, COUNT);
    assert_non_null(strstr(all_messages, "1 images are left out"));
    enc_pairs_close(&pairs);
}

SET_TEST(test_refused_values) {
    const enc_read_options strict = {.strict = true};
    write_pairs();
    write_image("tl1_pl2_tv3_pv4.exr", W, H, -0.5f);
    expect_refused(&strict, BTF_ERROR_BAD_FILE, "tl1_pl2_tv3_pv4.exr", "below 0 (-0.5)");
    expect_refused(&defaults, BTF_OK, "tl1_pl2_tv3_pv4.exr", "60 samples below 0 were set to 0");
    write_image("tl1_pl2_tv3_pv4.exr", W, H, NAN);
    expect_refused(&defaults, BTF_ERROR_BAD_FILE, "tl1_pl2_tv3_pv4.exr", "not a finite number");
    write_image("tl1_pl2_tv3_pv4.exr", W + 1, H, 0.5f);
    expect_refused(&defaults, BTF_ERROR_BAD_FILE, "pixels, but the first image has", "5x4");
}

SET_TEST(test_refused_directions) {
    write_pairs();
    write_image("again tl12.5 pl30 tv40.25 pv110.exr", W, H, 0.5f);
    expect_refused(&defaults, BTF_ERROR_BAD_FILE, "two images", "again tl12.5 pl30 tv40.25 pv110.exr");
    write_image("tl90_pl2_tv3_pv4.exr", W, H, 0.5f);
    expect_refused(&defaults, BTF_ERROR_BAD_FILE, "tl90_pl2_tv3_pv4.exr", "below 90");
}

/* A model whose images are the truth plus 0.01 times the pair's number, from 1; user: the pairs. */
static btf_result shifted(const enc_context *context, const void *user, const enc_pair *pairs, size_t count,
                          float *out) {
    (void)context;
    const enc_pairs *all = user;
    for (size_t p = 0; p < count; p++) {
        int i = 0;
        while (angles[i][0] != pairs[p].light.theta) {
            i++;
        }
        for (int k = 0; k < 3 * W * H; k++) {
            out[p * 3 * W * H + (size_t)k] =
                0.1f * (float)(i + 1) + 0.01f * (float)(&pairs[p] - all->pair + 1);
        }
    }
    return BTF_OK;
}

static enc_between *measure(const enc_pairs *pairs, size_t memory) {
    static const enc_direction samples[2] = {{.theta = 0, .xyz = {0, 0, 1}},
                                             {.theta = 90, .xyz = {1, 0, 0}}};
    const enc_context context = {.threads = 2, .memory = memory};
    const enc_pair_images model = {
        .images = shifted, .user = pairs, .views = samples, .lights = samples, .n_views = 1, .n_lights = 2};
    enc_between *between = NULL;
    assert_int_equal(enc_between_measure(&context, pairs, model, true, &between), BTF_OK);
    return between;
}

SET_TEST(test_measured_errors) {
    write_pairs();
    enc_pairs *pairs = open_pairs(&defaults);
    enc_between *b = measure(pairs, 0);
    double sum = 0;
    for (size_t p = 0; p < COUNT; p++) {
        const double step = 0.01 * (double)(p + 1);
        sum += step * step / COUNT;
        assert_true(fabs(enc_psnr_linear(&b->pair[p].error) + 20 * log10(step)) < 1e-3);
        assert_true(fabs(b->pair[p].view_gap - pairs->pair[p].view.theta) < 1e-4);
        assert_int_equal(b->worst[p], COUNT - 1 - p);
    }
    assert_true(fabs(enc_psnr_linear(&b->total) + 10 * log10(sum)) < 1e-3);
    for (int by = 0; by < ENC_BY_COUNT; by++) {
        size_t in_bands = 0;
        for (int i = 0; i < b->n_bands[by]; i++) {
            assert_true(b->band[by][i].pairs > 0 && b->band[by][i].ssim > 0.5);
            in_bands += b->band[by][i].pairs;
        }
        assert_int_equal(in_bands, COUNT);
    }
    assert_true(b->n_bands[ENC_BY_VIEW_THETA] == 4 && b->band[ENC_BY_VIEW_THETA][0].pairs == 2 &&
                b->band[ENC_BY_VIEW_THETA][1].low == 30);
    enc_between_destroy(&b);
    enc_pairs_close(&pairs);
}

/* Blocks of two pairs give the same errors as one block of all pairs. */
SET_TEST(test_blocks) {
    write_pairs();
    enc_pairs *pairs = open_pairs(&defaults);
    enc_between *whole = measure(pairs, 0);
    enc_pairs_close(&pairs);
    pairs = open_pairs(&defaults);
    enc_between *b = measure(pairs, 4 * 2 * 3 * sizeof(float) * W * H * 2);
    assert_true(whole->total.srgb > 0);
    assert_memory_equal(&b->total, &whole->total, sizeof b->total);
    assert_memory_equal(b->pair, whole->pair, COUNT * sizeof *b->pair);
    enc_between_destroy(&whole);
    enc_between_destroy(&b);
    enc_pairs_close(&pairs);
}

/* Decoded images are the reference's own, and need not lie on anything. */
TEST(test_decoded_pairs) {
    random_state r = {3};
    btf_material_desc desc =
        random_material_desc(W, H, 19, 19, BTF_LAYOUT_TIGHT, BTF_EFFECT_SHADOW | BTF_EFFECT_RESIDUAL);
    desc.info.components = 3;
    random_material_fill(&r, &desc);
    btf_material *material = NULL;
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    btf_ref_material reference;
    reference_view(material, 0, &reference);
    const btf_ref_options options = {
        .effects = BTF_EFFECT_ALL, .components = UINT32_MAX, .interpolation = BTF_REF_LINEAR};
    const enc_context context = {.threads = 2};
    enc_evaluator *evaluator = NULL;
    enc_pair pair[COUNT];
    float images[COUNT][3 * W * H];
    for (int i = 0; i < COUNT; i++) {
        pair[i] = (enc_pair){.light = enc_direction_from_angles(angles[i][0], angles[i][1]),
                             .view = enc_direction_from_angles(angles[i][2], angles[i][3])};
    }
    assert_int_equal(enc_evaluator_create(&context, material, 0, &evaluator), BTF_OK);
    assert_int_equal(enc_decode_pairs(&context, evaluator, &options, pair, COUNT, images[0]), BTF_OK);
    enc_evaluator_destroy(&evaluator);
    bool bright = false;
    for (int i = 0; i < COUNT; i++) {
        for (uint32_t t = 0; t < W * H; t++) {
            float rgb[3];
            btf_ref_evaluate_texel(&reference, &options, t % W, t / W, pair[i].light.xyz, pair[i].view.xyz,
                                   rgb);
            assert_memory_equal(rgb, images[i] + 3 * t, sizeof rgb);
            bright = bright || rgb[0] > 0;
        }
    }
    assert_true(bright);
    btf_material_close(&material);
    random_material_free(&desc);
}

RUN_TESTS(NULL, NULL)
