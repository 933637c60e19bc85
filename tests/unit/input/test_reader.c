/* Reading data sets (encoder/input/reader.h): every naming and format, every refusal.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/exr_image.h"
#include "decoder/toolkit/jpeg_image.h"
#include "decoder/toolkit/png_image.h"
#include "tests/support/exr_bytes.h"
#include "tests/support/image_files.h"
#include "tests/support/image_set.h"
#include "tests/support/test.h"

#include <png.h>
#include <sys/stat.h>
#include <unistd.h>

static float one_green(int c, int x, int y) {
    (void)x;
    (void)y;
    return c == 1;
}

SET_TEST(test_names) {
    const enc_read_options options = {0};
    for (int naming = UBO; naming <= FOLDERS; naming++) {
        char path[PATH];
        set_write((custom)naming);
        snprintf(path, sizeof path, "%s/readme.txt", temporary_folder);
        write_whole_file(path, "x", 1);
        snprintf(path, sizeof path, "%s/preview.png", temporary_folder);
        write_whole_file(path, "x", 1);
        enc_data *data = set_read_folder(&options);
        set_expect(data, 1e-7);
        assert_string_equal(data->source, temporary_folder);
        assert_true(data->negative == 0);
        assert_non_null(strstr(all_messages, "1 images are left out"));
        assert_non_null(strstr(all_messages, "preview.png"));
        enc_data_destroy(&data);
        assert_null(data);
        remove_temporary_folder(NULL);
        set_make_folder(NULL);
    }
}

SET_TEST(test_png_16) {
    const enc_read_options options = {0};
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            unsigned char codes[W * H * 3];
            unsigned short wide[W * H * 3];
            set_make_codes(v, l, codes);
            for (int i = 0; i < W * H * 3; i++) {
                wide[i] = (unsigned short)(codes[i] * 257);
            }
            assert_int_equal(png_image_write16(set_name_of(UBO, v, l, "PNG"), W, H, wide, set_no_log),
                             BTF_OK);
        }
    }
    enc_data *data = set_read_folder(&options);
    set_expect(data, 1e-7);
    enc_data_destroy(&data);
}

SET_TEST(test_jpeg) {
    const enc_read_options options = {0};
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            unsigned char flat[W * H * 3];
            memset(flat, v * 40 + l * 10 + 5, sizeof flat);
            assert_int_equal(jpeg_image_write(set_name_of(UBO, v, l, "jpg"), W, H, flat, 95, set_no_log),
                             BTF_OK);
        }
    }
    enc_data *data = set_read_folder(&options);
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            assert_float_equal(set_sample(data, v, l, 3, 2, 1),
                               enc_srgb_decode((v * 40 + l * 10 + 5) / 255.0), 0.01);
        }
    }
    enc_data_destroy(&data);
}

/* Linear formats hold the linear value itself. */
SET_TEST(test_float_formats) {
    for (int half = 0; half < 2; half++) {
        for (int v = 0; v < VIEWS; v++) {
            for (int l = 0; l < LIGHTS; l++) {
                unsigned char codes[W * H * 3];
                float linear[W * H * 3];
                set_make_codes(v, l, codes);
                for (int i = 0; i < W * H * 3; i++) {
                    linear[i] = (float)enc_srgb_decode(codes[i] / 255.0);
                }
                assert_int_equal(
                    exr_image_write(set_name_of(UTIA, v, l, "exr"), W, H, linear, half, set_no_log),
                    BTF_OK);
            }
        }
        enc_data *data = set_read_folder(&(enc_read_options){0});
        set_expect(data, half ? 0.0005 : 1e-7);
        enc_data_destroy(&data);
    }
    remove_temporary_folder(NULL);
    set_make_folder(NULL);
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            unsigned char codes[W * H * 3], rgbe[W * H * 4];
            set_make_codes(v, l, codes);
            for (int i = 0; i < W * H; i++) {
                rgbe[4 * i + 3] = 130; /* mantissa 1/64 */
                for (int c = 0; c < 3; c++) {
                    rgbe[4 * i + c] = codes[3 * i + c];
                }
            }
            write_hdr(set_name_of(UBO, v, l, "hdr"), W, H, rgbe, HDR_FLAT, "FORMAT=32-bit_rle_rgbe\n",
                      false);
        }
    }
    enc_data *data = set_read_folder(&(enc_read_options){0});
    assert_float_equal(set_sample(data, 2, 3, 1, 4, 2), set_code(2, 3, 1, 4, 2) / 64.0,
                       0); /* above 1, not clamped */
    enc_data_destroy(&data);
}

SET_TEST(test_xyz) {
    /* rows: what R, G and B of 1 are in XYZ (IEC 61966-2-1) */
    static const double matrix[3][3] = {{0.4123908, 0.2126390, 0.0193308},
                                        {0.3575843, 0.7151687, 0.1191948},
                                        {0.1804808, 0.0721923, 0.9505322}};
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            float xyz[W * H * 3];
            for (int i = 0; i < W * H; i++) {
                for (int k = 0; k < 3; k++) {
                    double sum = 0;
                    for (int c = 0; c < 3; c++) {
                        sum += matrix[c][k] * enc_srgb_decode(set_code(v, l, i / W, i % W, c) / 255.0);
                    }
                    xyz[3 * i + k] = (float)sum;
                }
            }
            assert_int_equal(exr_image_write(set_name_of(UTIA, v, l, "exr"), W, H, xyz, false, set_no_log),
                             BTF_OK);
        }
    }
    enc_data *data = set_read_folder(&(enc_read_options){.colour = ENC_COLOUR_XYZ});
    set_expect(data, 2e-5);
    enc_data_destroy(&data);

    /* files whose own attributes say XYZ are not read as RGB */
    float xyz[W * H * 3] = {0};
    write_exr_tiled(set_name_of(UTIA, 2, 2, "exr"), W, H, 3, "XYZ", xyz);
    set_expect_refused(temporary_folder, &(enc_read_options){0}, BTF_ERROR_BAD_FILE,
                       "tl015_pl270_tv030_pv120.exr", "--colour xyz", "primaries xyz", NULL);
}

SET_TEST(test_transfer) {
    set_write(UBO);
    enc_data *data = set_read_folder(&(enc_read_options){.transfer = ENC_TRANSFER_LINEAR});
    assert_float_equal(set_sample(data, 1, 2, 3, 4, 0), set_code(1, 2, 3, 4, 0) / 255.0, 1e-7);
    enc_data_destroy(&data);
    data = set_read_folder(&(enc_read_options){.transfer = ENC_TRANSFER_GAMMA, .gamma = 2.2});
    assert_float_equal(set_sample(data, 1, 2, 3, 4, 0), pow(set_code(1, 2, 3, 4, 0) / 255.0, 2.2), 1e-7);
    enc_data_destroy(&data);
    set_expect_refused(temporary_folder, &(enc_read_options){.transfer = ENC_TRANSFER_GAMMA},
                       BTF_ERROR_USAGE, "gamma 0", NULL);
}

SET_TEST(test_geometry) {
    set_write(UBO);
    enc_data *data = set_read_folder(&(enc_read_options){.flip_v = true, .transfer = ENC_TRANSFER_LINEAR});
    assert_float_equal(set_sample(data, 1, 2, 0, 4, 0), set_code(1, 2, H - 1, 4, 0) / 255.0, 1e-7);
    enc_data_destroy(&data);

    data = set_read_folder(&(enc_read_options){.crop = {1, 2, 3, 2}, .transfer = ENC_TRANSFER_LINEAR});
    assert_int_equal(data->width, 3);
    assert_int_equal(data->height, 2);
    assert_float_equal(set_sample(data, 1, 2, 0, 0, 0), set_code(1, 2, 2, 1, 0) / 255.0, 1e-7);
    assert_float_equal(set_sample(data, 1, 2, 1, 2, 0), set_code(1, 2, 3, 3, 0) / 255.0, 1e-7);
    enc_data_destroy(&data);

    /* crop counts from the file's top, then flip, then the mean in linear light */
    data = set_read_folder(&(enc_read_options){.crop = {1, 0, 4, 4}, .flip_v = true, .size = {2, 2}});
    assert_int_equal(data->width, 2);
    double mean = 0;
    for (int row = 2; row < 4; row++) {
        for (int column = 3; column < 5; column++) {
            mean += enc_srgb_decode(set_code(3, 4, row, column, 1) / 255.0) / 4;
        }
    }
    assert_float_equal(set_sample(data, 3, 4, 0, 1, 1), mean, 1e-6);
    enc_data_destroy(&data);

    const enc_read_options outside[] = {{.crop = {3, 0, 3, 2}}, {.crop = {0, 0, 2, 5}},
                                        {.crop = {0, 0, 0, 5}}, {.size = {0, 5}},
                                        {.size = {16385, 1}},   {.size = {-1, -1}}};
    const char *words[] = {"5x4", "5x4", "crop", "size 0x5", "16385", "-1"};
    for (size_t i = 0; i < 6; i++) {
        set_expect_refused(temporary_folder, &outside[i], BTF_ERROR_USAGE, words[i], NULL);
    }
}

SET_TEST(test_azimuths) {
    set_write(UBO);
    enc_data *data = set_read_folder(&(enc_read_options){.azimuth_cw = true, .azimuth_offset = 30});
    /* theta 15: 90 and 270 become 300 and 120, which turns their order; theta 0 stays */
    const double expected[LIGHTS][2] = {{0, 0}, {15, 120}, {15, 300}, {45, 22.5}, {75, 45}};
    const int origin[LIGHTS] = {0, 2, 1, 3, 4};
    for (int l = 0; l < LIGHTS; l++) {
        assert_float_equal(data->lights[l].theta, expected[l][0], 0);
        assert_float_equal(data->lights[l].phi, expected[l][1], 1e-9);
        assert_float_equal(set_sample(data, 1, l, 2, 3, 1),
                           enc_srgb_decode(set_code(1, origin[l], 2, 3, 1) / 255.0), 1e-7);
    }
    assert_float_equal(data->views[1].phi, 30, 1e-9);
    assert_float_equal(data->views[2].phi, 270, 1e-9); /* 120 */
    enc_data_destroy(&data);
}

TEST(test_directions) {
    const enc_direction x = enc_direction_from_angles(90, 0), y = enc_direction_from_angles(90, 90);
    const enc_direction z = enc_direction_from_angles(0, 77), d = enc_direction_from_angles(60, 225);
    const float expected[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    assert_memory_equal(x.xyz, expected[0], sizeof x.xyz);
    assert_memory_equal(y.xyz, expected[1], sizeof y.xyz);
    assert_memory_equal(z.xyz, expected[2], sizeof z.xyz);
    assert_float_equal(d.xyz[0], -sqrt(3.0 / 8), 1e-7);
    assert_float_equal(d.xyz[1], -sqrt(3.0 / 8), 1e-7);
    assert_float_equal(d.xyz[2], 0.5, 1e-7);
}

SET_TEST(test_missing_and_duplicate) {
    const enc_read_options options = {0};
    char path[PATH];
    set_write(UBO);
    assert_int_equal(unlink(set_name_of(UBO, 1, 3, "png")), 0);
    assert_int_equal(unlink(set_name_of(UBO, 2, 0, "png")), 0);
    assert_int_equal(unlink(set_name_of(UBO, 3, 4, "png")), 0);
    set_expect_refused(temporary_folder, &options, BTF_ERROR_BAD_FILE, "3 of 20 images are missing",
                       "first is view (30,0) light (45,7.5)", NULL);
    set_write(UBO);
    snprintf(path, sizeof path, "%s/copy tv75 pv240 tl15 pl90.png", temporary_folder);
    write_whole_file(path, "", 0);
    set_expect_refused(temporary_folder, &options, BTF_ERROR_BAD_FILE, "1 images repeat",
                       "view (75,240) light (15,90)", "copy tv75 pv240 tl15 pl90.png",
                       "00017 tl015 pl090 tv075 pv240.png", NULL);
    unlink(path);
    /* 360 + 90 is 90 */
    snprintf(path, sizeof path, "%s/tv75 pv240 tl15 pl450.png", temporary_folder);
    write_whole_file(path, "", 0);
    set_expect_refused(temporary_folder, &options, BTF_ERROR_BAD_FILE, "1 images repeat", "pl450.png",
                       NULL);
}

SET_TEST(test_refused_directions) {
    const enc_read_options options = {0};
    char path[PATH];
    set_expect_refused(temporary_folder, &options, BTF_ERROR_BAD_FILE, temporary_folder,
                       "no JPEG, PNG, HDR or EXR image", NULL);
    snprintf(path, sizeof path, "%s/image.png", temporary_folder);
    write_whole_file(path, "", 0);
    set_expect_refused(temporary_folder, &options, BTF_ERROR_BAD_FILE, "of 1 images none", "image.png",
                       NULL);
    snprintf(path, sizeof path, "%s/tl95 pl0 tv0 pv0.png", temporary_folder);
    write_whole_file(path, "", 0);
    set_expect_refused(temporary_folder, &options, BTF_ERROR_BAD_FILE, "theta 95 of the light", "tl95",
                       NULL);
    unlink(path);
    snprintf(path, sizeof path, "%s/tl0 pl0 tv5.5 pv10.png", temporary_folder);
    write_whole_file(path, "", 0);
    set_expect_refused(temporary_folder, &options, BTF_ERROR_BAD_FILE, "no top view", "(5.5,10)", NULL);
    snprintf(path, sizeof path, "%s/tl0 pl0 tv0 pv10.png", temporary_folder);
    write_whole_file(path, "", 0);
    snprintf(path, sizeof path, "%s/tl0 pl0 tv0 pv20.png", temporary_folder);
    write_whole_file(path, "", 0);
    set_expect_refused(temporary_folder, &options, BTF_ERROR_BAD_FILE,
                       "view directions (0,10) and (0,20) are one", NULL);
    for (int i = 0; i < 257; i++) {
        snprintf(path, sizeof path, "%s/tl40 pl%d tv0 pv10.png", temporary_folder, i);
        write_whole_file(path, "", 0);
    }
    unlink(path);
    snprintf(path, sizeof path, "%s/tl0 pl0 tv0 pv20.png", temporary_folder);
    unlink(path);
    set_expect_refused(temporary_folder, &options, BTF_ERROR_UNSUPPORTED, "257 light directions", NULL);
}

SET_TEST(test_refused_images) {
    const enc_read_options options = {0};
    set_write(UBO);
    /* truncated; damaged; another size */
    size_t size;
    void *data = read_whole_file(set_name_of(UBO, 1, 2, "png"), &size);
    write_whole_file(set_name_of(UBO, 1, 2, "png"), data, size - 5);
    free(data);
    set_expect_refused(temporary_folder, &options, BTF_ERROR_BAD_FILE, "00008 tl015 pl270 tv030 pv000.png",
                       "PNG", NULL);
    set_write_png8(UBO, 1, 2);
    unsigned char codes[W * H * 3] = {0};
    assert_int_equal(png_image_write8(set_name_of(UBO, 3, 1, "png"), H, W, codes, set_no_log), BTF_OK);
    set_expect_refused(temporary_folder, &options, BTF_ERROR_BAD_FILE, "00017",
                       "4x5 pixels, but the first image has 5x4", NULL);
    set_write_png8(UBO, 3, 1);
    write_whole_file(set_name_of(UBO, 0, 0, "png"), "", 0);
    set_expect_refused(temporary_folder, &options, BTF_ERROR_BAD_FILE, "00001", "empty file", NULL);
    set_write_png8(UBO, 0, 0);
    assert_int_equal(unlink(set_name_of(UBO, 2, 2, "png")), 0);
    assert_int_equal(mkdir(set_name_of(UBO, 2, 2, "png"), 0777), 0);
    set_expect_refused(temporary_folder, &options, BTF_ERROR_BAD_FILE, "1 of 20 images are missing", NULL);
    set_expect_refused("/nowhere/at/all", &options, BTF_ERROR_IO, "/nowhere/at/all", "No such file", NULL);
}

SET_TEST(test_refused_values) {
    float rgb[W * H * 3];
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            for (int i = 0; i < W * H * 3; i++) {
                rgb[i] = 0.25f;
            }
            if (v == 2 && l == 1) {
                rgb[(3 * W + 1) * 3 + 2] = -0.5f;
            }
            if (v == 2 && l == 2) {
                rgb[0] = rgb[1] = -1e-6f;
            }
            assert_int_equal(exr_image_write(set_name_of(UTIA, v, l, "exr"), W, H, rgb, false, set_no_log),
                             BTF_OK);
        }
    }
    enc_data *data = set_read_folder(&(enc_read_options){0});
    assert_true(data->negative == 3);
    assert_true(set_sample(data, 2, 1, 3, 1, 2) == 0.0f);
    assert_true(set_sample(data, 2, 1, 3, 1, 1) == 0.25f);
    assert_non_null(strstr(all_messages, "3 samples below 0 in 2 images"));
    assert_non_null(strstr(all_messages, "tl015_pl090_tv030_pv120.exr"));
    enc_data_destroy(&data);
    set_expect_refused(temporary_folder, &(enc_read_options){.strict = true}, BTF_ERROR_BAD_FILE,
                       "tl015_pl090_tv030_pv120.exr", "column 1, row 3, channel B is below 0 (-0.5)", NULL);

    const float bad[2] = {NAN, INFINITY};
    for (int k = 0; k < 2; k++) {
        rgb[(2 * W + 4) * 3 + 1] = bad[k];
        assert_int_equal(exr_image_write(set_name_of(UTIA, 3, 0, "exr"), W, H, rgb, false, set_no_log),
                         BTF_OK);
        set_expect_refused(temporary_folder, &(enc_read_options){0}, BTF_ERROR_BAD_FILE,
                           "tl000_pl000_tv075_pv240.exr",
                           "column 4, row 2, channel G is not a finite number", NULL);
        /* a part that leaves it out is fine */
        data = set_read_folder(&(enc_read_options){.crop = {0, 0, 4, 4}});
        enc_data_destroy(&data);
        set_expect_refused(temporary_folder, &(enc_read_options){.crop = {1, 1, 4, 3}}, BTF_ERROR_BAD_FILE,
                           "column 4, row 2", NULL);
    }
}

/* Half of the images say that they are linear, and one has a profile: each fact gives one warning with a count, the
 * first file and its value. --transfer overrides both. */
SET_TEST(test_notes) {
    const enc_read_options options = {0};
    unsigned char codes[W * H * 3];
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            set_make_codes(v, l, codes);
            FILE *f = fopen(set_name_of(UBO, v, l, "png"), "wb");
            png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
            png_infop info = png_create_info_struct(png);
            assert_non_null(f);
            png_init_io(png, f);
            png_set_IHDR(png, info, W, H, 8, PNG_COLOR_TYPE_RGB, 0, 0, 0);
            if (l >= 2) {
                png_set_gAMA(png, info, l == 2 ? 1.0 : 0.5);
            }
            png_write_info(png, info);
            for (int row = 0; row < H; row++) {
                png_write_row(png, codes + (size_t)row * W * 3);
            }
            png_write_end(png, info);
            png_destroy_write_struct(&png, &info);
            assert_int_equal(fclose(f), 0);
        }
    }
    enc_data *data = set_read_folder(&options);
    for (int l = 0; l < LIGHTS; l++) {
        const double code = set_code(1, l, 2, 3, 1) / 255.0;
        const double want = l < 2 ? enc_srgb_decode(code) : l == 2 ? code : code * code;
        assert_true(fabs((double)set_sample(data, 1, l, 2, 3, 1) - want) < 1e-6);
    }
    enc_data_destroy(&data);
    assert_non_null(strstr(all_messages, "12 images, with other values too: "));
    assert_non_null(strstr(all_messages, ".png: PNG: gAMA 1 is applied"));
    all_messages[0] = '\0';
    data = set_read_folder(&(enc_read_options){.transfer = ENC_TRANSFER_SRGB});
    set_expect(data, 1e-7);
    enc_data_destroy(&data);
    assert_null(strstr(all_messages, "gAMA"));
}

/* Primaries named in a file are converted, unless --colour says what the values are. */
SET_TEST(test_primaries) {
    static const float p3[8] = {0.68f, 0.32f, 0.265f, 0.69f, 0.15f, 0.06f, 0.3127f, 0.329f};
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            bytes_part part = {
                .width = W,
                .height = H,
                .value = one_green,
                .channel_count = 3,
                .channels = {{"B", BYTES_FLOAT, 1, 1}, {"G", BYTES_FLOAT, 1, 1}, {"R", BYTES_FLOAT, 1, 1}},
                .attribute_count = 1,
                .attributes = {{"chromaticities", "chromaticities", p3, sizeof p3}}};
            size_t size;
            void *bytes = exr_bytes(&part, 1, &size);
            write_whole_file(set_name_of(UTIA, v, l, "exr"), bytes, size);
            free(bytes);
        }
    }
    enc_data *data = set_read_folder(&(enc_read_options){0});
    /* the green of Display P3 in Rec. 709: red below 0, which is clamped and counted */
    assert_true(fabs((double)set_sample(data, 1, 2, 1, 1, 1) - 1.0420) < 1e-3);
    assert_true(data->negative == VIEWS * LIGHTS * W * H * 2);
    enc_data_destroy(&data);
    assert_non_null(strstr(all_messages, "20 images: "));
    assert_non_null(strstr(all_messages, ".exr: EXR chromaticities red (0.68,0.32)"));
    assert_non_null(strstr(all_messages, "converted to Rec. 709"));
    all_messages[0] = '\0';
    data = set_read_folder(&(enc_read_options){.colour = ENC_COLOUR_RGB});
    assert_true(set_sample(data, 1, 2, 1, 1, 1) == 1.0f && data->negative == 0);
    enc_data_destroy(&data);
    assert_null(strstr(all_messages, "converted"));
}

RUN_TESTS(NULL, NULL)
