/* The report and the pictures: bytes by effects, rows of errors, the JSON file, and sources or folders that fail.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/report/canvas.h"
#include "encoder/report/metrics.h"
#include "encoder/report/montage.h"
#include "encoder/report/report.h"
#include "tests/support/messages.h"
#include "tests/support/test.h"

#include <unistd.h>

static const enc_context context = {.log = {keep_message, NULL}, .threads = 2};

static enc_data *make_data(int width, int height) {
    const enc_direction views[2] = {enc_direction_from_angles(0, 0), enc_direction_from_angles(40, 90)};
    const enc_direction lights[3] = {enc_direction_from_angles(10, 0), enc_direction_from_angles(40, 0),
                                     enc_direction_from_angles(40, 120)};
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(&context, width, height, 2, views, 3, lights, &data), BTF_OK);
    for (size_t i = 0; i < enc_data_texel_count(data) * enc_data_texel_stride(data); i++) {
        data->samples[i] = (float)(i * 37 % 101) / 100;
    }
    return data;
}

/* A source that fails on view 1. */
static btf_result failing_view(const void *user, int view, float *out) {
    const enc_data *data = user;
    memset(out, 0, enc_data_texel_count(data) * (size_t)data->n_lights * 3 * sizeof *out);
    return view == 1 ? BTF_ERROR_IO : BTF_OK;
}

TEST(test_bytes) {
    btf_material_info info = {
        .struct_size = sizeof info, .width = 64, .height = 64, .n_views = 81, .n_lights = 81};
    info.lobes = 3;
    info.centres = 1984;
    info.effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN;
    info.atlas_width = 1024;
    info.atlas_height = 512;
    const size_t sbrdf = 64 * 64 * 64, maps = 64 * 64 * 81;
    assert_int_equal(enc_report_gpu_bytes(&info, 0), sbrdf);
    assert_int_equal(enc_report_gpu_bytes(&info, BTF_EFFECT_SHADOW), sbrdf + maps);
    assert_int_equal(enc_report_gpu_bytes(&info, BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT), sbrdf + 3 * maps);
    assert_int_equal(enc_report_gpu_bytes(&info, info.effects), 2359296); /* 64 W H + 4 AW AH */
    assert_int_equal(enc_report_gpu_bytes(&info, BTF_EFFECT_ALL), 2359296);
}

static enc_report_step step_of(const char *name, uint32_t effects, double error) {
    enc_report_step step = {.name = name, .effects = effects, .gpu_bytes = 1000 + effects};
    step.metrics.total = (enc_error_sum){.linear = error, .srgb = error, .count = 1};
    return step;
}

/* With shadow as the only effect, "without shadow" is the same as the step SBRDF: one row, not two. */
TEST(test_rows) {
    enc_report *report = calloc(1, sizeof *report);
    assert_non_null(report);
    report->ladder[0] = step_of("sbrdf", 0, 0.01);
    report->ladder[1] = step_of("stvs", BTF_EFFECT_SHADOW, 0.001);
    report->ladder[2] = step_of("full", BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT, 0.0001);
    report->n_ladder = 3;
    report->without[0] = step_of("shift", BTF_EFFECT_SHADOW, 0.001);
    report->without[1] = step_of("shadow", BTF_EFFECT_SHIFT, 0.002);
    report->n_without = 2;
    btf_material_error rows[2 * ENC_REPORT_STEPS];
    assert_int_equal(enc_report_errors(report, rows), 4);
    assert_int_equal(rows[3].effects, BTF_EFFECT_SHIFT);
    assert_true(rows[0].psnr_linear == 20 && rows[2].psnr_srgb == 40 && rows[1].gpu_bytes == 1001);
    free(report);
}

/* The figures are the same bits for any --memory. */
TEST(test_memory) {
    enc_data *a = make_data(9, 4), *b = make_data(9, 4);
    for (size_t i = 0; i < enc_data_texel_count(b) * enc_data_texel_stride(b); i += 3) {
        b->samples[i] *= 0.75f;
    }
    enc_metrics *out = calloc(3, sizeof *out);
    assert_non_null(out);
    const size_t memory[3] = {0, 1, 4 * 9 * 4 * 3 * 3 * sizeof(float)};
    for (int i = 0; i < 3; i++) {
        enc_context with = context;
        with.memory = memory[i];
        assert_int_equal(
            enc_metrics_compare(&with, a, enc_data_images(a), enc_data_images(b), true, &out[i]), BTF_OK);
        assert_memory_equal(&out[i], &out[0], sizeof *out);
    }
    free(out);
    enc_data_destroy(&a);
    enc_data_destroy(&b);
}

TEST(test_failing_source) {
    char folder[] = "report-XXXXXX", path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/montage.png", folder);
    enc_data *data = make_data(3, 5);
    const enc_image_source failing = {.view = failing_view, .user = data};
    const enc_montage_column columns[2] = {{"original", enc_data_images(data)}, {"full", failing}};
    enc_metrics *metrics = calloc(1, sizeof *metrics);
    assert_non_null(metrics);
    assert_int_equal(enc_metrics_compare(&context, data, enc_data_images(data), failing, true, metrics),
                     BTF_ERROR_IO);
    last_message[0] = 0;
    assert_int_equal(enc_montage_write(&context, data, 2, columns, path), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, path));
    assert_int_equal(access(path, F_OK), -1);
    assert_int_equal(enc_montage_write(&context, data, 1, columns, path), BTF_OK);
    assert_int_equal(access(path, F_OK), 0);
    unlink(path);
    assert_int_equal(enc_montage_write(&context, data, 1, columns, "no/such/folder.png"), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "no/such/folder.png"));
    free(metrics);
    enc_data_destroy(&data);
    assert_int_equal(rmdir(folder), 0);
}

/* Drawing outside a canvas is cut off, on every side. */
TEST(test_canvas) {
    enc_canvas canvas;
    const float white[3] = {1, 1, 1}, black[4 * 3] = {0};
    assert_int_equal(enc_canvas_create(&context, 5, 4, &canvas), BTF_OK);
    enc_canvas_image(&canvas, -1, -1, 2, 2, 2, black); /* covers (0..2, 0..2) */
    enc_canvas_image(&canvas, 4, 3, 3, 2, 2, black);   /* its first pixel alone */
    for (int y = 0; y < 4; y++) {
        for (int x = 0; x < 5; x++) {
            const int dark = (x < 3 && y < 3) || (x == 4 && y == 3);
            assert_int_equal(canvas.rgb[3 * (y * 5 + x)], dark ? 0 : 255);
        }
    }
    enc_canvas_image(&canvas, 1, 1, 1, 1, 1, white);
    assert_int_equal(canvas.rgb[3 * (5 + 1) + 2], 255);
    enc_canvas_text(&canvas, -50, 100, "%s", "far away");
    enc_canvas_clear(&canvas);
    assert_null(canvas.rgb);
}

/* The rows and columns that a caption at (2, 20) reaches. */
static void caption_box(const char *text, int box[4]) {
    enum { WIDTH = 40, HEIGHT = 30 };
    enc_canvas canvas;
    assert_int_equal(enc_canvas_create(&context, WIDTH, HEIGHT, &canvas), BTF_OK);
    enc_canvas_text(&canvas, 2, 20, "%s", text);
    memcpy(box, (int[4]){WIDTH, HEIGHT, -1, -1}, 4 * sizeof *box);
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            if (canvas.rgb[3 * (y * WIDTH + x)] == 0) {
                box[0] = x < box[0] ? x : box[0];
                box[1] = y < box[1] ? y : box[1];
                box[2] = x > box[2] ? x : box[2];
                box[3] = y > box[3] ? y : box[3];
            }
        }
    }
    enc_canvas_clear(&canvas);
}

/* Capitals stand on the base line, tails of letters reach below it, letters follow each other. */
TEST(test_caption) {
    int box[4];
    caption_box("A", box);
    assert_int_equal(box[0], 2);
    assert_int_equal(box[1], 20 - ENC_CANVAS_LETTER_HEIGHT);
    assert_int_equal(box[2], 2 + ENC_CANVAS_LETTER_WIDTH - 3);
    assert_int_equal(box[3], 19);
    caption_box("g", box);
    assert_int_equal(box[3], 21);
    caption_box(" AA", box);
    assert_int_equal(box[0], 2 + ENC_CANVAS_LETTER_WIDTH);
    assert_int_equal(box[2], 2 + 3 * ENC_CANVAS_LETTER_WIDTH - 3);
}

RUN_TESTS(NULL, NULL)
