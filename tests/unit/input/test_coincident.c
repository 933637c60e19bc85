/* Lights that had to stand beside the camera where light and view coincide (encoder/input/light_positions.h): the table
 * and its refusals, the fit with its positions, and the separate report of their error.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/input/light_positions.h"
#include "encoder/paper/fit.h"
#include "encoder/report/metrics.h"
#include "tests/support/image_files.h"
#include "tests/support/messages.h"
#include "tests/support/temporary.h"
#include "tests/support/test.h"

#include <unistd.h>

enum { DIRECTIONS = 13 };

static const enc_context context = {.log = {keep_message, NULL}, .threads = 1};

static void write_table(const char *text) {
    write_whole_file(temporary_file, text, strlen(text));
}

/* One texel; views and lights at the pole and on rings of 6 at 30 and 60 degrees. */
static enc_data *make_data(void) {
    enc_direction list[DIRECTIONS] = {enc_direction_from_angles(0, 0)};
    for (int i = 0; i < 12; i++) {
        list[1 + i] = enc_direction_from_angles(i < 6 ? 30 : 60, 60 * (i % 6));
    }
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(&context, 1, 1, DIRECTIONS, list, DIRECTIONS, list, &data), BTF_OK);
    return data;
}

TEST_WITH(test_table, make_temporary_file, remove_temporary_file) {
    const enc_read_options options = {0}, turned = {.azimuth_offset = 60};
    enc_data *data = make_data();
    write_table("# number theta phi, light\n 0 0 0 5 90\n\n2 30 60 33.5 61 # a note\r\n60 -60 55 301\n");
    assert_int_equal(enc_coincident_read(&context, temporary_file, &options, data), BTF_OK);
    assert_float_equal(enc_data_light(data, 0, 0)->theta, 5, 0);
    assert_float_equal(enc_data_light(data, 0, 0)->phi, 90, 0);
    assert_float_equal(enc_data_light(data, 2, 2)->theta, 33.5, 0);
    assert_float_equal(enc_data_light(data, 12, 12)->phi, 301, 0);
    assert_ptr_equal(enc_data_light(data, 2, 1), &data->lights[1]); /* other pairs stay */
    assert_ptr_equal(enc_data_light(data, 1, 2), &data->lights[2]);
    assert_ptr_equal(enc_data_light(data, 3, 3), &data->lights[3]);
    enc_data *copy = make_data();
    assert_int_equal(enc_data_copy_lights(data, copy), BTF_OK);
    enc_data_destroy(&data);
    assert_float_equal(enc_data_light(copy, 2, 2)->theta, 33.5, 0);
    enc_data_destroy(&copy);
    data = make_data();
    write_table("30 0 33 1\n");
    assert_int_equal(enc_coincident_read(&context, temporary_file, &turned, data), BTF_OK);
    assert_float_equal(enc_data_light(data, 2, 2)->phi, 61, 1e-9);
    enc_data_destroy(&data);
}

TEST_WITH(test_refusals, make_temporary_file, remove_temporary_file) {
    static const struct {
        const char *text, *words;
    } cases[] = {
        {"0 0 5\n", "line 1: expected"},
        {"0 0 5 90 1 2\n", "line 1: expected"},
        {"0 0 5 x\n", "line 1: expected"},
        {"0 0 5 90 x\n", "line 1: expected"},
        {"0 0 5 90x\n", "line 1: expected"},
        {"1 0 0 5 90 2\n", "line 1: expected"},
        {"0 0 nan 0\n", "line 1: expected"},
        {"\n0 0 90 0\n", "line 2: theta 90 of the light"},
        {"15 0 16 0\n", "line 1: (15,0) is not a view of "},
        {"30 60 33 60\n30 420 34 60\n", "line 2: the view (30,420) is listed a second time"},
        {"", "the table holds no direction"},
        {"theta phi theta_l phi_l\n# 0 0 5 90\n", "the table holds no direction"},
    };
    const enc_read_options options = {0};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        enc_data *data = make_data();
        write_table(cases[i].text);
        last_message[0] = '\0';
        assert_int_equal(enc_coincident_read(&context, temporary_file, &options, data), BTF_ERROR_BAD_FILE);
        if (!strstr(last_message, cases[i].words)) {
            fail_msg("\"%s\" lacks \"%s\"", last_message, cases[i].words);
        }
        enc_data_destroy(&data);
    }
    enc_data *data = make_data();
    char text[6000];
    snprintf(text, sizeof text, "#%0400d\n0 0 5 90\n", 0); /* a comment is one line, however long */
    write_table(text);
    assert_int_equal(enc_coincident_read(&context, temporary_file, &options, data), BTF_OK);
    assert_float_equal(enc_data_light(data, 0, 0)->theta, 5, 0);
    enc_data_destroy(&data);
    data = make_data();
    snprintf(text, sizeof text, "\n#%05000d\n0 0 5 90\n", 0);
    write_table(text);
    assert_int_equal(enc_coincident_read(&context, temporary_file, &options, data), BTF_OK);
    enc_data_destroy(&data);
    data = make_data();
    assert_int_equal(enc_coincident_read(&context, "/nonexistent/table", &options, data), BTF_ERROR_IO);
    enc_data_destroy(&data);
}

/* A retro-reflecting lobe, sharpest where light and view coincide; for these pairs the light stood 15 degrees aside.
 * With the table the fit explains every sample; without it the fit cannot. */
TEST_WITH(test_fit, make_temporary_file, remove_temporary_file) {
    const enc_read_options options = {0};
    double error[2];
    for (int with = 0; with < 2; with++) {
        enc_data *data = make_data();
        char table[2048] = "";
        for (int d = 0; d < DIRECTIONS; d++) {
            const enc_direction *n = &data->views[d];
            snprintf(table + strlen(table), sizeof table - strlen(table), "%g %g %g %g\n", n->theta, n->phi,
                     n->theta + 15, n->phi + 5);
        }
        write_table(table);
        assert_int_equal(enc_coincident_read(&context, temporary_file, &options, data), BTF_OK);
        for (size_t v = 0; v < DIRECTIONS; v++) {
            for (size_t l = 0; l < DIRECTIONS; l++) {
                const float *w = data->views[v].xyz, *i = enc_data_light(data, v, l)->xyz;
                const double cosine = (double)w[0] * i[0] + (double)w[1] * i[1] + (double)w[2] * i[2];
                for (size_t c = 0; c < 3; c++) {
                    data->samples[(v * 3 + c) * DIRECTIONS + l] =
                        (float)((0.2 + 0.7 * pow(fmax(cosine, 0), 30)) * (double)i[2]);
                }
            }
        }
        if (!with) {
            free(data->moved_light);
            data->moved_light = NULL;
        }
        enc_sbrdf *sbrdf = NULL;
        enc_fit_options fit = enc_fit_options_default();
        fit.rounds = 0;
        assert_int_equal(enc_fit(&context, data, &fit, &sbrdf, NULL), BTF_OK);
        error[with] = 0;
        for (size_t v = 0; v < DIRECTIONS; v++) {
            float light[3][DIRECTIONS], value[3 * DIRECTIONS];
            for (size_t l = 0; l < DIRECTIONS; l++) {
                for (int k = 0; k < 3; k++) {
                    light[k][l] = enc_data_light(data, v, l)->xyz[k];
                }
            }
            enc_sbrdf_evaluate(sbrdf, 0, data->views[v].xyz, DIRECTIONS, light[0], light[1], light[2],
                               value);
            for (size_t l = 0; l < DIRECTIONS; l++) {
                error[with] += pow((double)value[l] * (double)light[2][l] -
                                       (double)data->samples[v * 3 * DIRECTIONS + l],
                                   2);
            }
        }
        enc_sbrdf_destroy(&sbrdf);
        enc_data_destroy(&data);
    }
    if (!(error[1] < 0.05 * error[0])) {
        fail_msg("squared error %g with the table, %g without", error[1], error[0]);
    }
}

TEST(test_error_apart) {
    enc_data *a = make_data(), *b = make_data();
    for (size_t v = 0; v < DIRECTIONS; v++) {
        for (size_t c = 0; c < 3; c++) {
            b->samples[(v * 3 + c) * DIRECTIONS + v] = 0.1f;
        }
    }
    enc_metrics metrics;
    assert_int_equal(
        enc_metrics_compare(&context, a, enc_data_images(a), enc_data_images(b), false, &metrics), BTF_OK);
    assert_float_equal(metrics.coincident.count, 3 * DIRECTIONS, 0);
    assert_float_equal(enc_psnr_linear(&metrics.coincident), 20, 1e-4);
    assert_float_equal(enc_psnr_linear(&metrics.total), 20 + 10 * log10(DIRECTIONS), 1e-4);
    enc_data_destroy(&a);
    enc_data_destroy(&b);
}

RUN_TESTS(NULL, NULL)
