/* libopenbtf_input against the encoder's own reader: the same values from folders and Bonn files, by any number of
 * threads, with every option; refusals by name.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/input.h>

#include "tests/support/bonn_files.h"
#include "tests/support/image_set.h"
#include "tests/support/test.h"

#include <omp.h>
#include <unistd.h>

static btf_log set_log(void) {
    return set_context.log;
}

/* Every image of `input` is that of `data`, bit for bit. */
static void expect_same(btf_input *input, const enc_data *data) {
    btf_input_info info = {.struct_size = sizeof info};
    assert_int_equal(btf_input_get_info(input, &info), BTF_OK);
    assert_int_equal(info.width, data->width);
    assert_int_equal(info.height, data->height);
    assert_int_equal(info.n_views, data->n_views);
    assert_int_equal(info.n_lights, data->n_lights);
    for (int v = 0; v < info.n_views; v++) {
        assert_memory_equal(info.views + 3 * v, data->views[v].xyz, sizeof data->views[v].xyz);
        assert_true(info.view_angles[2 * v] == data->views[v].theta &&
                    info.view_angles[2 * v + 1] == data->views[v].phi);
    }
    for (int l = 0; l < info.n_lights; l++) {
        assert_memory_equal(info.lights + 3 * l, data->lights[l].xyz, sizeof data->lights[l].xyz);
    }
    const int images = info.n_views * info.n_lights;
    const size_t texels = enc_data_texel_count(data);
    int wrong = 0;
#pragma omp parallel for num_threads(4) reduction(+ : wrong)
    for (int i = 0; i < images; i++) {
        const int v = i / info.n_lights, l = i % info.n_lights;
        float *rgb = malloc(3 * texels * sizeof *rgb);
        wrong += !rgb || btf_input_image(input, v, l, NULL, rgb) != BTF_OK;
        for (size_t t = 0; t < texels && rgb; t++) {
            for (size_t c = 0; c < 3; c++) {
                wrong += memcmp(&rgb[3 * t + c],
                                &data->samples[((t * (size_t)data->n_views + (size_t)v) * 3 + c) *
                                                   (size_t)data->n_lights +
                                               (size_t)l],
                                sizeof *rgb) != 0;
            }
        }
        free(rgb);
    }
    assert_int_equal(wrong, 0);
}

static void compare(const char *path, const btf_input_options *options, const enc_read_options *same,
                    int lazy) {
    const btf_log log = set_log();
    btf_input *input = NULL;
    enc_data *data = NULL;
    btf_input_info info = {.struct_size = sizeof info};
    assert_int_equal(btf_input_open(path, options, &log, &input), BTF_OK);
    assert_int_equal(enc_read(&set_context, path, same, &data), BTF_OK);
    expect_same(input, data);
    assert_int_equal(btf_input_get_info(input, &info), BTF_OK);
    assert_int_equal(info.lazy, lazy);
    enc_data_destroy(&data);
    btf_input_close(&input);
    assert_null(input);
}

SET_TEST(test_a_folder) {
    set_write(UBO);
    compare(temporary_folder, NULL, &(enc_read_options){0}, 1);
}

SET_TEST(test_options) {
    set_write(FOLDERS);
    const btf_input_options one = {.struct_size = sizeof one,
                                   .transfer = BTF_TRANSFER_GAMMA,
                                   .gamma = 1.7,
                                   .flip_v = 1,
                                   .azimuth_cw = 1,
                                   .azimuth_offset = 20,
                                   .crop = {1, 1, 3, 2}};
    compare(temporary_folder, &one,
            &(enc_read_options){.transfer = ENC_TRANSFER_GAMMA,
                                .gamma = 1.7,
                                .flip_v = true,
                                .azimuth_cw = true,
                                .azimuth_offset = 20,
                                .crop = {1, 1, 3, 2}},
            1);
    const btf_input_options two = {.struct_size = sizeof two,
                                   .transfer = BTF_TRANSFER_LINEAR,
                                   .size = {2, 3},
                                   .cosine = BTF_COSINE_MISSING,
                                   .primaries = BTF_PRIMARIES_XYZ};
    compare(temporary_folder, &two,
            &(enc_read_options){.transfer = ENC_TRANSFER_LINEAR,
                                .size = {2, 3},
                                .cosine = ENC_COSINE_MISSING,
                                .colour = ENC_COLOUR_XYZ},
            1);
}

static double of_direction(int view, int light, int channel, unsigned k) {
    return 0.3 * view - 0.2 * light + 0.1 * channel - 0.5 * k;
}

static double of_texel(int x, int y, int channel, int view, unsigned k) {
    return k == 0 ? 1.0 : 0.1 * (x - y) + 0.05 * (channel + view);
}

SET_TEST(test_a_bonn_file) {
    static const double directions[3][2] = {{0, 0}, {40, 30}, {60, 200}};
    char path[PATH];
    bonn_spec spec = bonn_half_dfmf(8, 3, directions, 2);
    spec.direction = of_direction;
    spec.texel = of_texel;
    snprintf(path, sizeof path, "%s/set.btf", temporary_folder);
    assert_true(bonn_write(path, &spec));
    compare(path, NULL, &(enc_read_options){0}, 0);
    compare(path, &(btf_input_options){.struct_size = sizeof(btf_input_options), .memory = 4096},
            &(enc_read_options){0}, 0);
}

static void expect_refusal(const char *path, const btf_input_options *options, btf_result expected,
                           const char *word) {
    const btf_log log = set_log();
    btf_input *input = (btf_input *)1;
    all_messages[0] = '\0';
    assert_int_equal(btf_input_open(path, options, &log, &input), expected);
    assert_null(input);
    if (!strstr(all_messages, word)) {
        fail_msg("no \"%s\" in: %s", word, all_messages);
    }
}

SET_TEST(test_refusals) {
    set_write(UBO);
    const size_t size = sizeof(btf_input_options);
    expect_refusal("/none", NULL, BTF_ERROR_IO, "/none");
    expect_refusal(temporary_folder, &(btf_input_options){.struct_size = 8}, BTF_ERROR_USAGE, "");
    expect_refusal(temporary_folder, &(btf_input_options){.struct_size = size, .size = {3, 0}},
                   BTF_ERROR_USAGE, "3x0");
    expect_refusal(temporary_folder, &(btf_input_options){.struct_size = size, .cosine = (btf_cosine)7},
                   BTF_ERROR_USAGE, "cosine 7");
    expect_refusal(temporary_folder,
                   &(btf_input_options){.struct_size = size, .transfer = BTF_TRANSFER_GAMMA},
                   BTF_ERROR_USAGE, "gamma");
    assert_int_equal(btf_input_open(NULL, NULL, NULL, NULL), BTF_ERROR_USAGE);
    assert_int_equal(btf_input_get_info(NULL, NULL), BTF_ERROR_USAGE);
    btf_input *none = NULL;
    btf_input_close(&none);
    btf_input_close(NULL);
}

SET_TEST(test_images_that_are_refused) {
    const btf_log log = set_log();
    btf_input *input;
    float rgb[3 * W * H];
    btf_input_info small = {.struct_size = 8};
    set_write(UBO);
    assert_int_equal(btf_input_open(temporary_folder, NULL, &log, &input), BTF_OK);
    assert_int_equal(btf_input_get_info(input, &small), BTF_ERROR_USAGE);
    assert_int_equal(btf_input_image(input, VIEWS, 0, &log, rgb), BTF_ERROR_USAGE);
    assert_non_null(strstr(all_messages, "view 4"));
    assert_int_equal(btf_input_image(input, 0, -1, &log, rgb), BTF_ERROR_USAGE);
    assert_int_equal(btf_input_image(input, 0, 0, &log, NULL), BTF_ERROR_USAGE);
    /* An image is removed while the set is open. */
    const char *gone = set_name_of(UBO, 1, 2, "png");
    assert_int_equal(unlink(gone), 0);
    all_messages[0] = '\0';
    assert_int_equal(btf_input_image(input, 1, 2, &log, rgb), BTF_ERROR_IO);
    assert_non_null(strstr(all_messages, strrchr(gone, '/') + 1));
    btf_input_close(&input);
}

SET_TEST(test_writing) {
    const btf_log log = set_log();
    const float rgb[6] = {0, 1.5f, 2, 3e9f, 1e-9f, 0.25f};
    char path[PATH];
    snprintf(path, sizeof path, "%s/none/x.exr", temporary_folder);
    assert_int_equal(btf_input_write_image(path, 2, 1, rgb, &log), BTF_ERROR_IO);
    assert_int_equal(btf_input_write_image(path, 0, 1, rgb, &log), BTF_ERROR_USAGE);
    snprintf(path, sizeof path, "%s/tl000_pl000_tv000_pv000.exr", temporary_folder);
    assert_int_equal(btf_input_write_image(path, 2, 1, rgb, &log), BTF_OK);
    btf_input *input;
    float back[6];
    assert_int_equal(btf_input_open(temporary_folder, NULL, &log, &input), BTF_OK);
    assert_int_equal(btf_input_image(input, 0, 0, &log, back), BTF_OK);
    assert_memory_equal(back, rgb, sizeof rgb);
    btf_input_close(&input);
}

RUN_TESTS(NULL, NULL)
