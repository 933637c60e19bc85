/* Reading data sets (encoder/reader.h): every naming and format, every refusal, scratch file, archives,
 * real data.
 *
 * SPDX-License-Identifier: MIT
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "decoder/tools/exr_image.h"
#include "decoder/tools/jpeg_image.h"
#include "decoder/tools/png_image.h"
#include "encoder/reader.h"
#include "image_files.h"

#include <archive.h>
#include <archive_entry.h>
#include <ftw.h>
#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { W = 5, H = 4, VIEWS = 4, LIGHTS = 5, PATH = 512 };
/* In paper order. */
static const double views[VIEWS][2] = {{0, 0}, {30, 0}, {30, 120}, {75, 240}};
static const double lights[LIGHTS][2] = {{0, 0}, {15, 90}, {15, 270}, {45, 7.5}, {75, 345}};

static char folder[256];
static char messages[8192];

static void keep_message(void *user, btf_log_level level, const char *text) {
    (void)user;
    const size_t used = strlen(messages);
    snprintf(messages + used, sizeof messages - used, "%d: %s\n", (int)level, text);
}
static enc_context context = {.log = {keep_message, NULL}, .threads = 2};
static const btf_log no_log = {NULL, NULL};

static int make_folder(void **state) {
    (void)state;
    const char *base = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/btf-reader-XXXXXX", base && *base ? base : "/tmp");
    messages[0] = '\0';
    context.memory = 0;
    context.threads = 2;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_entry(const char *path, const struct stat *status, int flag, struct FTW *ftw) {
    (void)status;
    (void)flag;
    (void)ftw;
    return remove(path);
}

static int remove_folder(void **state) {
    (void)state;
    return nftw(folder, remove_entry, 8, FTW_DEPTH | FTW_PHYS);
}

/* The 8-bit code of a sample. */
static unsigned char code(int v, int l, int row, int column, int c) {
    return (unsigned char)((v * 61 + l * 31 + row * 17 + column * 5 + c * 83) % 256);
}

static void make_codes(int v, int l, unsigned char codes[W * H * 3]) {
    for (int row = 0; row < H; row++)
        for (int column = 0; column < W; column++)
            for (int c = 0; c < 3; c++)
                codes[(row * W + column) * 3 + c] = code(v, l, row, column, c);
}

/* The name of an image in one of the customs, made anew for each call. */
typedef enum custom { UBO, UTIA, BONN, FOLDERS } custom;
static const char *name_of(custom naming, int v, int l, const char *extension) {
    static char path[PATH];
    char sub[300];
    const double tv = views[v][0], pv = views[v][1], tl = lights[l][0], pl = lights[l][1];
    sub[0] = '\0';
    switch (naming) {
    case UBO:
        snprintf(sub, sizeof sub, "%s/tv%03g_pv%03g", folder, tv, pv);
        snprintf(path, sizeof path, "%s/%05d tl%03g pl%03g tv%03g pv%03g.%s", sub, v * LIGHTS + l + 1, tl,
                 pl, tv, pv, extension);
        break;
    case UTIA:
        snprintf(path, sizeof path, "%s/tl%03g_pl%03g_tv%03g_pv%03g.%s", folder, tl, pl, tv, pv, extension);
        break;
    case BONN:
        snprintf(path, sizeof path, "%s/TV%g-PV%g-TL%g-PL%.2f.%s", folder, tv, pv, tl, pl, extension);
        break;
    case FOLDERS:
        snprintf(sub, sizeof sub, "%s/tv=%g pv=%g", folder, tv, pv);
        snprintf(path, sizeof path, "%s/pl%.1f tl%.1f.%s", sub, pl, tl, extension);
        break;
    }
    if (sub[0])
        mkdir(sub, 0777);
    return path;
}

static void write_png8(custom naming, int v, int l) {
    unsigned char codes[W * H * 3];
    make_codes(v, l, codes);
    assert_int_equal(png_image_write8(name_of(naming, v, l, "png"), W, H, codes, no_log), BTF_OK);
}

static void write_set(custom naming) {
    for (int v = 0; v < VIEWS; v++)
        for (int l = 0; l < LIGHTS; l++)
            write_png8(naming, v, l);
}

static enc_data *read_folder(const enc_read_options *options) {
    enc_data *data = NULL;
    const btf_result result = enc_read(&context, folder, options, &data);
    if (result != BTF_OK)
        fail_msg("%s", messages);
    return data;
}

/* Fails unless reading is refused with this result and a message that holds all of the words (up to a
 * NULL). */
static void expect_refused(const char *input, const enc_read_options *options, btf_result expected, ...) {
    enc_data *data = NULL;
    va_list words;
    messages[0] = '\0';
    assert_int_equal(enc_read(&context, input, options, &data), expected);
    assert_null(data);
    va_start(words, expected);
    for (const char *word; (word = va_arg(words, const char *));)
        if (!strstr(messages, word))
            fail_msg("\"%s\" does not say \"%s\"", messages, word);
    va_end(words);
}

static float sample(const enc_data *data, int v, int l, int row, int column, int c) {
    const size_t texel = (size_t)row * (size_t)data->width + (size_t)column;
    float *buffer = malloc(enc_data_texel_stride(data) * sizeof *buffer);
    const float *samples;
    assert_non_null(buffer);
    assert_int_equal(enc_data_texels(&context, data, texel, 1, buffer, &samples), BTF_OK);
    const float value = samples[(v * 3 + c) * data->n_lights + l];
    free(buffer);
    return value;
}

/* Directions in order, and each sample within `tolerance` of the linear value of its code. */
static void expect_set(const enc_data *data, double tolerance) {
    assert_int_equal(data->width, W);
    assert_int_equal(data->height, H);
    assert_int_equal(data->n_views, VIEWS);
    assert_int_equal(data->n_lights, LIGHTS);
    assert_int_equal(data->top_view, 0);
    for (int v = 0; v < VIEWS; v++)
        assert_true(data->views[v].theta == views[v][0] && data->views[v].phi == views[v][1]);
    for (int l = 0; l < LIGHTS; l++)
        assert_true(data->lights[l].theta == lights[l][0] && data->lights[l].phi == lights[l][1]);
    for (int row = 0; row < H; row++)
        for (int column = 0; column < W; column++)
            for (int v = 0; v < VIEWS; v++)
                for (int c = 0; c < 3; c++)
                    for (int l = 0; l < LIGHTS; l++) {
                        const double expected = enc_srgb_decode(code(v, l, row, column, c) / 255.0);
                        const double value = sample(data, v, l, row, column, c);
                        if (!(fabs(value - expected) <= tolerance))
                            fail_msg("view %d light %d row %d column %d channel %d: %g, not %g", v, l, row,
                                     column, c, value, expected);
                    }
}

static void test_names(void **state) {
    (void)state;
    const enc_read_options options = {0};
    for (int naming = UBO; naming <= FOLDERS; naming++) {
        char path[PATH];
        write_set((custom)naming);
        snprintf(path, sizeof path, "%s/readme.txt", folder);
        write_whole_file(path, "x", 1);
        snprintf(path, sizeof path, "%s/preview.png", folder);
        write_whole_file(path, "x", 1);
        enc_data *data = read_folder(&options);
        expect_set(data, 1e-7);
        assert_string_equal(data->source, folder);
        assert_true(data->negative == 0);
        assert_non_null(strstr(messages, "1 images are left out"));
        assert_non_null(strstr(messages, "preview.png"));
        enc_data_destroy(&data);
        assert_null(data);
        remove_folder(NULL);
        make_folder(NULL);
    }
}

static void test_png_16(void **state) {
    (void)state;
    const enc_read_options options = {0};
    for (int v = 0; v < VIEWS; v++)
        for (int l = 0; l < LIGHTS; l++) {
            unsigned char codes[W * H * 3];
            unsigned short wide[W * H * 3];
            make_codes(v, l, codes);
            for (int i = 0; i < W * H * 3; i++)
                wide[i] = (unsigned short)(codes[i] * 257);
            assert_int_equal(png_image_write16(name_of(UBO, v, l, "PNG"), W, H, wide, no_log), BTF_OK);
        }
    enc_data *data = read_folder(&options);
    expect_set(data, 1e-7);
    enc_data_destroy(&data);
}

static void test_jpeg(void **state) {
    (void)state;
    const enc_read_options options = {0};
    for (int v = 0; v < VIEWS; v++)
        for (int l = 0; l < LIGHTS; l++) {
            unsigned char flat[W * H * 3];
            memset(flat, v * 40 + l * 10 + 5, sizeof flat);
            assert_int_equal(jpeg_image_write(name_of(UBO, v, l, "jpg"), W, H, flat, 95, no_log), BTF_OK);
        }
    enc_data *data = read_folder(&options);
    for (int v = 0; v < VIEWS; v++)
        for (int l = 0; l < LIGHTS; l++)
            assert_float_equal(sample(data, v, l, 3, 2, 1), enc_srgb_decode((v * 40 + l * 10 + 5) / 255.0),
                               0.01);
    enc_data_destroy(&data);
}

/* Linear formats hold the linear value itself. */
static void test_float_formats(void **state) {
    (void)state;
    for (int half = 0; half < 2; half++) {
        for (int v = 0; v < VIEWS; v++)
            for (int l = 0; l < LIGHTS; l++) {
                unsigned char codes[W * H * 3];
                float linear[W * H * 3];
                make_codes(v, l, codes);
                for (int i = 0; i < W * H * 3; i++)
                    linear[i] = (float)enc_srgb_decode(codes[i] / 255.0);
                assert_int_equal(exr_image_write(name_of(UTIA, v, l, "exr"), W, H, linear, half, no_log),
                                 BTF_OK);
            }
        enc_data *data = read_folder(&(enc_read_options){0});
        expect_set(data, half ? 0.0005 : 1e-7);
        enc_data_destroy(&data);
    }
    remove_folder(NULL);
    make_folder(NULL);
    for (int v = 0; v < VIEWS; v++)
        for (int l = 0; l < LIGHTS; l++) {
            unsigned char codes[W * H * 3], rgbe[W * H * 4];
            make_codes(v, l, codes);
            for (int i = 0; i < W * H; i++) {
                rgbe[4 * i + 3] = 130; /* mantissa 1/64 */
                for (int c = 0; c < 3; c++)
                    rgbe[4 * i + c] = codes[3 * i + c];
            }
            write_hdr(name_of(UBO, v, l, "hdr"), W, H, rgbe, HDR_FLAT, "FORMAT=32-bit_rle_rgbe\n", false);
        }
    enc_data *data = read_folder(&(enc_read_options){0});
    assert_float_equal(sample(data, 2, 3, 1, 4, 2), code(2, 3, 1, 4, 2) / 64.0,
                       0); /* above 1, not clamped */
    enc_data_destroy(&data);
}

static void test_xyz(void **state) {
    (void)state;
    /* rows: what R, G and B of 1 are in XYZ (IEC 61966-2-1) */
    static const double matrix[3][3] = {{0.4123908, 0.2126390, 0.0193308},
                                        {0.3575843, 0.7151687, 0.1191948},
                                        {0.1804808, 0.0721923, 0.9505322}};
    for (int v = 0; v < VIEWS; v++)
        for (int l = 0; l < LIGHTS; l++) {
            float xyz[W * H * 3];
            for (int i = 0; i < W * H; i++)
                for (int k = 0; k < 3; k++) {
                    double sum = 0;
                    for (int c = 0; c < 3; c++)
                        sum += matrix[c][k] * enc_srgb_decode(code(v, l, i / W, i % W, c) / 255.0);
                    xyz[3 * i + k] = (float)sum;
                }
            assert_int_equal(exr_image_write(name_of(UTIA, v, l, "exr"), W, H, xyz, false, no_log), BTF_OK);
        }
    enc_data *data = read_folder(&(enc_read_options){.colour = ENC_COLOUR_XYZ});
    expect_set(data, 2e-5);
    enc_data_destroy(&data);

    /* files that say so themselves are not taken for RGB */
    float xyz[W * H * 3] = {0};
    write_exr_tiled(name_of(UTIA, 2, 2, "exr"), W, H, 3, "XYZ", xyz);
    expect_refused(folder, &(enc_read_options){0}, BTF_ERROR_BAD_FILE, "tl015_pl270_tv030_pv120.exr",
                   "--colour xyz", NULL);
}

static void test_transfer(void **state) {
    (void)state;
    write_set(UBO);
    enc_data *data = read_folder(&(enc_read_options){.transfer = ENC_TRANSFER_LINEAR});
    assert_float_equal(sample(data, 1, 2, 3, 4, 0), code(1, 2, 3, 4, 0) / 255.0, 1e-7);
    enc_data_destroy(&data);
    data = read_folder(&(enc_read_options){.transfer = ENC_TRANSFER_GAMMA, .gamma = 2.2});
    assert_float_equal(sample(data, 1, 2, 3, 4, 0), pow(code(1, 2, 3, 4, 0) / 255.0, 2.2), 1e-7);
    enc_data_destroy(&data);
    expect_refused(folder, &(enc_read_options){.transfer = ENC_TRANSFER_GAMMA}, BTF_ERROR_USAGE, "gamma 0",
                   NULL);
}

static void test_geometry(void **state) {
    (void)state;
    write_set(UBO);
    enc_data *data = read_folder(&(enc_read_options){.flip_v = true, .transfer = ENC_TRANSFER_LINEAR});
    assert_float_equal(sample(data, 1, 2, 0, 4, 0), code(1, 2, H - 1, 4, 0) / 255.0, 1e-7);
    enc_data_destroy(&data);

    data = read_folder(&(enc_read_options){.crop = {1, 2, 3, 2}, .transfer = ENC_TRANSFER_LINEAR});
    assert_int_equal(data->width, 3);
    assert_int_equal(data->height, 2);
    assert_float_equal(sample(data, 1, 2, 0, 0, 0), code(1, 2, 2, 1, 0) / 255.0, 1e-7);
    assert_float_equal(sample(data, 1, 2, 1, 2, 0), code(1, 2, 3, 3, 0) / 255.0, 1e-7);
    enc_data_destroy(&data);

    /* crop counts from the file's top, then flip, then the mean in linear light */
    data = read_folder(&(enc_read_options){.crop = {1, 0, 4, 4}, .flip_v = true, .size = {2, 2}});
    assert_int_equal(data->width, 2);
    double mean = 0;
    for (int row = 2; row < 4; row++)
        for (int column = 3; column < 5; column++)
            mean += enc_srgb_decode(code(3, 4, row, column, 1) / 255.0) / 4;
    assert_float_equal(sample(data, 3, 4, 0, 1, 1), mean, 1e-6);
    enc_data_destroy(&data);

    const enc_read_options outside[] = {{.crop = {3, 0, 3, 2}}, {.crop = {0, 0, 2, 5}},
                                        {.crop = {0, 0, 0, 5}}, {.size = {0, 5}},
                                        {.size = {16385, 1}},   {.size = {-1, -1}}};
    const char *words[] = {"5x4", "5x4", "crop", "size 0x5", "16385", "-1"};
    for (size_t i = 0; i < 6; i++)
        expect_refused(folder, &outside[i], BTF_ERROR_USAGE, words[i], NULL);
}

static void test_azimuths(void **state) {
    (void)state;
    write_set(UBO);
    enc_data *data = read_folder(&(enc_read_options){.azimuth_cw = true, .azimuth_offset = 30});
    /* theta 15: 90 and 270 become 300 and 120, which turns their order; theta 0 stays */
    const double expected[LIGHTS][2] = {{0, 0}, {15, 120}, {15, 300}, {45, 22.5}, {75, 45}};
    const int origin[LIGHTS] = {0, 2, 1, 3, 4};
    for (int l = 0; l < LIGHTS; l++) {
        assert_float_equal(data->lights[l].theta, expected[l][0], 0);
        assert_float_equal(data->lights[l].phi, expected[l][1], 1e-9);
        assert_float_equal(sample(data, 1, l, 2, 3, 1),
                           enc_srgb_decode(code(1, origin[l], 2, 3, 1) / 255.0), 1e-7);
    }
    assert_float_equal(data->views[1].phi, 30, 1e-9);
    assert_float_equal(data->views[2].phi, 270, 1e-9); /* 120 */
    enc_data_destroy(&data);
}

static void test_directions(void **state) {
    (void)state;
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

static void test_missing_and_duplicate(void **state) {
    (void)state;
    const enc_read_options options = {0};
    char path[PATH];
    write_set(UBO);
    assert_int_equal(unlink(name_of(UBO, 1, 3, "png")), 0);
    assert_int_equal(unlink(name_of(UBO, 2, 0, "png")), 0);
    assert_int_equal(unlink(name_of(UBO, 3, 4, "png")), 0);
    expect_refused(folder, &options, BTF_ERROR_BAD_FILE, "3 of 20 images are missing",
                   "first is view (30,0) light (45,7.5)", NULL);
    write_set(UBO);
    snprintf(path, sizeof path, "%s/copy tv75 pv240 tl15 pl90.png", folder);
    write_whole_file(path, "", 0);
    expect_refused(folder, &options, BTF_ERROR_BAD_FILE, "1 images repeat", "view (75,240) light (15,90)",
                   "copy tv75 pv240 tl15 pl90.png", "00017 tl015 pl090 tv075 pv240.png", NULL);
    unlink(path);
    /* 360 + 90 is 90 */
    snprintf(path, sizeof path, "%s/tv75 pv240 tl15 pl450.png", folder);
    write_whole_file(path, "", 0);
    expect_refused(folder, &options, BTF_ERROR_BAD_FILE, "1 images repeat", "pl450.png", NULL);
}

static void test_refused_directions(void **state) {
    (void)state;
    const enc_read_options options = {0};
    char path[PATH];
    expect_refused(folder, &options, BTF_ERROR_BAD_FILE, folder, "no JPEG, PNG, HDR or EXR image", NULL);
    snprintf(path, sizeof path, "%s/image.png", folder);
    write_whole_file(path, "", 0);
    expect_refused(folder, &options, BTF_ERROR_BAD_FILE, "of 1 images none", "image.png", NULL);
    snprintf(path, sizeof path, "%s/tl95 pl0 tv0 pv0.png", folder);
    write_whole_file(path, "", 0);
    expect_refused(folder, &options, BTF_ERROR_BAD_FILE, "theta 95 of the light", "tl95", NULL);
    unlink(path);
    snprintf(path, sizeof path, "%s/tl0 pl0 tv5.5 pv10.png", folder);
    write_whole_file(path, "", 0);
    expect_refused(folder, &options, BTF_ERROR_BAD_FILE, "no top view", "(5.5,10)", NULL);
    snprintf(path, sizeof path, "%s/tl0 pl0 tv0 pv10.png", folder);
    write_whole_file(path, "", 0);
    snprintf(path, sizeof path, "%s/tl0 pl0 tv0 pv20.png", folder);
    write_whole_file(path, "", 0);
    expect_refused(folder, &options, BTF_ERROR_BAD_FILE, "view directions (0,10) and (0,20) are one", NULL);
    for (int i = 0; i < 257; i++) {
        snprintf(path, sizeof path, "%s/tl40 pl%d tv0 pv10.png", folder, i);
        write_whole_file(path, "", 0);
    }
    unlink(path);
    snprintf(path, sizeof path, "%s/tl0 pl0 tv0 pv20.png", folder);
    unlink(path);
    expect_refused(folder, &options, BTF_ERROR_UNSUPPORTED, "257 light directions", NULL);
}

static void test_refused_images(void **state) {
    (void)state;
    const enc_read_options options = {0};
    write_set(UBO);
    /* truncated; damaged; another size */
    size_t size;
    void *data = read_whole_file(name_of(UBO, 1, 2, "png"), &size);
    write_whole_file(name_of(UBO, 1, 2, "png"), data, size - 5);
    free(data);
    expect_refused(folder, &options, BTF_ERROR_BAD_FILE, "00008 tl015 pl270 tv030 pv000.png", "PNG", NULL);
    write_png8(UBO, 1, 2);
    unsigned char codes[W * H * 3] = {0};
    assert_int_equal(png_image_write8(name_of(UBO, 3, 1, "png"), H, W, codes, no_log), BTF_OK);
    expect_refused(folder, &options, BTF_ERROR_BAD_FILE, "00017", "4x5 pixels, but the first image has 5x4",
                   NULL);
    write_png8(UBO, 3, 1);
    write_whole_file(name_of(UBO, 0, 0, "png"), "", 0);
    expect_refused(folder, &options, BTF_ERROR_BAD_FILE, "00001", "empty file", NULL);
    write_png8(UBO, 0, 0);
    assert_int_equal(unlink(name_of(UBO, 2, 2, "png")), 0);
    assert_int_equal(mkdir(name_of(UBO, 2, 2, "png"), 0777), 0);
    expect_refused(folder, &options, BTF_ERROR_BAD_FILE, "1 of 20 images are missing", NULL);
    expect_refused("/nowhere/at/all", &options, BTF_ERROR_IO, "/nowhere/at/all", "No such file", NULL);
}

static void test_refused_values(void **state) {
    (void)state;
    float rgb[W * H * 3];
    for (int v = 0; v < VIEWS; v++)
        for (int l = 0; l < LIGHTS; l++) {
            for (int i = 0; i < W * H * 3; i++)
                rgb[i] = 0.25f;
            if (v == 2 && l == 1)
                rgb[(3 * W + 1) * 3 + 2] = -0.5f;
            if (v == 2 && l == 2)
                rgb[0] = rgb[1] = -1e-6f;
            assert_int_equal(exr_image_write(name_of(UTIA, v, l, "exr"), W, H, rgb, false, no_log), BTF_OK);
        }
    enc_data *data = read_folder(&(enc_read_options){0});
    assert_true(data->negative == 3);
    assert_true(sample(data, 2, 1, 3, 1, 2) == 0.0f);
    assert_true(sample(data, 2, 1, 3, 1, 1) == 0.25f);
    assert_non_null(strstr(messages, "3 samples below 0 in 2 images"));
    assert_non_null(strstr(messages, "tl015_pl090_tv030_pv120.exr"));
    enc_data_destroy(&data);
    expect_refused(folder, &(enc_read_options){.strict = true}, BTF_ERROR_BAD_FILE,
                   "tl015_pl090_tv030_pv120.exr", "column 1, row 3, channel B is below 0 (-0.5)", NULL);

    const float bad[2] = {NAN, INFINITY};
    for (int k = 0; k < 2; k++) {
        rgb[(2 * W + 4) * 3 + 1] = bad[k];
        assert_int_equal(exr_image_write(name_of(UTIA, 3, 0, "exr"), W, H, rgb, false, no_log), BTF_OK);
        expect_refused(folder, &(enc_read_options){0}, BTF_ERROR_BAD_FILE, "tl000_pl000_tv075_pv240.exr",
                       "column 4, row 2, channel G is not a finite number", NULL);
        /* a part that leaves it out is fine */
        data = read_folder(&(enc_read_options){.crop = {0, 0, 4, 4}});
        enc_data_destroy(&data);
        expect_refused(folder, &(enc_read_options){.crop = {1, 1, 4, 3}}, BTF_ERROR_BAD_FILE,
                       "column 4, row 2", NULL);
    }
}

/* A different thread count, and a scratch file in blocks of one image, give the same samples. */
static void test_scratch_file(void **state) {
    (void)state;
    const enc_read_options options = {0};
    write_set(UBO);
    enc_data *memory = read_folder(&options);
    assert_non_null(memory->samples);
    context.threads = 1;
    enc_data *one = read_folder(&options);
    const size_t stride = enc_data_texel_stride(memory), texels = enc_data_texel_count(memory);
    assert_memory_equal(memory->samples, one->samples, stride * texels * sizeof(float));
    enc_data_destroy(&one);

    const size_t limits[] = {1, 1000, 3000};
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        context.memory = limits[i];
        context.threads = 1 + (int)i % 2;
        messages[0] = '\0';
        enc_data *scratch = read_folder(&options);
        assert_null(scratch->samples);
        assert_true(scratch->scratch_fd >= 0);
        assert_non_null(strstr(messages, "scratch file in"));
        struct stat status;
        assert_int_equal(fstat(scratch->scratch_fd, &status), 0);
        assert_int_equal(status.st_nlink, 0); /* nobody else sees it */
        float *buffer = malloc(stride * texels * sizeof *buffer);
        const float *samples;
        assert_int_equal(enc_data_texels(&context, scratch, 0, texels, buffer, &samples), BTF_OK);
        assert_memory_equal(memory->samples, samples, stride * texels * sizeof(float));
        free(buffer);

        float *a = malloc(texels * LIGHTS * 3 * sizeof *a), *b = malloc(texels * LIGHTS * 3 * sizeof *b);
        for (int v = 0; v < VIEWS; v++) {
            assert_int_equal(enc_data_view(&context, memory, v, a), BTF_OK);
            assert_int_equal(enc_data_view(&context, scratch, v, b), BTF_OK);
            assert_memory_equal(a, b, texels * LIGHTS * 3 * sizeof *a);
        }
        assert_true(a[(2 * texels + 7) * 3 + 1] == sample(memory, VIEWS - 1, 2, 1, 2, 1));
        free(a);
        free(b);
        enc_data_destroy(&scratch);
    }
    enc_data_destroy(&memory);
}

static void test_data(void **state) {
    (void)state;
    const enc_direction list[2] = {enc_direction_from_angles(0, 0), enc_direction_from_angles(30, 0)};
    float in[2 * 2 * 3 * 2], buffer[2 * 2 * 3 * 2];
    for (int i = 0; i < 24; i++)
        in[i] = (float)i;
    for (int k = 0; k < 2; k++) {
        enc_data *data;
        const float *out;
        context.memory = k ? 1 : 0;
        assert_int_equal(enc_data_create(&context, 3, 1, 2, list, 2, list, &data), BTF_OK);
        assert_int_equal(enc_data_store_texels(&context, data, 1, 2, in), BTF_OK);
        assert_int_equal(enc_data_texels(&context, data, 1, 2, buffer, &out), BTF_OK);
        assert_memory_equal(out, in, sizeof in);
        assert_int_equal(enc_data_texels(&context, data, 0, 1, buffer, &out), BTF_OK);
        for (int i = 0; i < 12; i++)
            assert_true(out[i] == 0.0f);
        enc_data_destroy(&data);
    }
    enc_data *data;
    context.memory = 1;
    assert_int_equal(enc_data_create(&context, 0, 1, 2, list, 2, list, &data), BTF_ERROR_USAGE);
    assert_int_equal(enc_data_create(&context, 1, 16385, 2, list, 2, list, &data), BTF_ERROR_USAGE);
    assert_int_equal(enc_data_create(&context, 1, 1, 257, list, 2, list, &data), BTF_ERROR_USAGE);
    enc_direction many[256];
    for (int i = 0; i < 256; i++)
        many[i] = list[i % 2];
    messages[0] = '\0';
    assert_int_equal(enc_data_create(&context, 16384, 16384, 256, many, 256, many, &data), BTF_ERROR_IO);
    assert_non_null(strstr(messages, "GB free"));
    const char *old = getenv("TMPDIR");
    char *kept = old ? strdup(old) : NULL;
    setenv("TMPDIR", "/nowhere/at/all", 1);
    assert_int_equal(enc_data_create(&context, 3, 1, 2, list, 2, list, &data), BTF_ERROR_IO);
    assert_non_null(strstr(messages, "/nowhere/at/all"));
    if (kept)
        setenv("TMPDIR", kept, 1);
    else
        unsetenv("TMPDIR");
    free(kept);
}

static void add_to_archive(struct archive *archive, const char *name, const void *data, size_t size) {
    struct archive_entry *entry = archive_entry_new();
    archive_entry_set_pathname(entry, name);
    archive_entry_set_size(entry, (la_int64_t)size);
    archive_entry_set_filetype(entry, AE_IFREG);
    archive_entry_set_perm(entry, 0644);
    assert_int_equal(archive_write_header(archive, entry), ARCHIVE_OK);
    assert_int_equal(archive_write_data(archive, data, size), (la_ssize_t)size);
    archive_entry_free(entry);
}

/* Packs the set into `path`: lights outside, views inside, and names that would leave a folder if
 * extracted. */
static void write_archive(const char *path, bool zip) {
    struct archive *archive = archive_write_new();
    if (zip) {
        archive_write_set_format_zip(archive);
    } else {
        archive_write_set_format_pax_restricted(archive);
        archive_write_add_filter_gzip(archive);
    }
    assert_int_equal(archive_write_open_filename(archive, path), ARCHIVE_OK);
    add_to_archive(archive, "readme.txt", "hello", 5);
    for (int l = 0; l < LIGHTS; l++)
        for (int v = 0; v < VIEWS; v++) {
            char name[PATH];
            size_t size;
            void *data = read_whole_file(name_of(UBO, v, l, "png"), &size);
            snprintf(name, sizeof name, "%s/tv%g_pv%g/tl%g pl%g.png", l % 2 ? "../../.." : "/absolute",
                     views[v][0], views[v][1], lights[l][0], lights[l][1]);
            add_to_archive(archive, name, data, size);
            free(data);
            snprintf(name, sizeof name, "__MACOSX/._tv%g_pv%g tl%g pl%g.png", views[v][0], views[v][1],
                     lights[l][0], lights[l][1]);
            add_to_archive(archive, name, "x", 1);
        }
    assert_int_equal(archive_write_free(archive), ARCHIVE_OK);
}

static void test_archives(void **state) {
    (void)state;
    const enc_read_options options = {0};
    write_set(UBO);
    for (int zip = 0; zip < 2; zip++) {
        char path[PATH];
        snprintf(path, sizeof path, "%s/set.%s", folder, zip ? "zip" : "tar.gz");
        write_archive(path, zip);
        for (size_t memory = 0; memory < 6000; memory += 2500) {
            enc_data *data = NULL;
            context.memory = memory;
            if (enc_read(&context, path, &options, &data) != BTF_OK)
                fail_msg("%s", messages);
            assert_true((data->samples == NULL) == (memory > 0));
            expect_set(data, 1e-7);
            enc_data_destroy(&data);
        }
        size_t size;
        size_t whole = 0;
        void *bytes = read_whole_file(path, &size);
        for (size_t n = 0; n < size; n += 97) {
            enc_data *data = NULL;
            messages[0] = '\0';
            write_whole_file(path, bytes, n);
            const btf_result result = enc_read(&context, path, &options, &data);
            if (result == BTF_OK) {
                expect_set(data, 1e-7); /* what is missing at the end held no image */
                enc_data_destroy(&data);
                whole++;
                continue;
            }
            assert_int_equal(result, BTF_ERROR_BAD_FILE);
            assert_non_null(strstr(messages, zip ? "set.zip" : "set.tar.gz"));
        }
        free(bytes);
        print_message("%s: %zu of %zu truncations left every image whole\n", path, whole, (size + 96) / 97);
        assert_true(whole < size / 97 / 2);
    }
    expect_refused("/dev/null", &options, BTF_ERROR_BAD_FILE, "/dev/null", NULL);
    expect_refused(name_of(UBO, 0, 0, "png"), &options, BTF_ERROR_BAD_FILE, "neither a directory nor a zip",
                   NULL);
}

/* The path of a file of the shared data, or NULL where it is absent. */
static const char *shared_file(const char *name) {
    static char path[4096];
    const char *shared = getenv("BTF_SHARED"), *root = getenv("BTF_SOURCE_ROOT");
    if (shared)
        snprintf(path, sizeof path, "%s/data/%s", shared, name);
    else
        snprintf(path, sizeof path, "%s/../shared/data/%s", root ? root : ".", name);
    if (access(path, R_OK) == 0)
        return path;
    print_message("skipped: %s is absent\n", path);
    return NULL;
}

static void test_bricks(void **state) {
    (void)state;
    const char *path = shared_file("BRICKS64.zip");
    if (!path)
        skip();
    enc_data *data = NULL;
    assert_int_equal(enc_read(&context, path, &(enc_read_options){0}, &data), BTF_OK);
    assert_int_equal(data->width, 64);
    assert_int_equal(data->height, 64);
    assert_int_equal(data->n_views, 81);
    assert_int_equal(data->n_lights, 81);
    assert_float_equal(data->lights[80].theta, 75, 0);
    assert_float_equal(data->lights[80].phi, 345, 0);
    /* an independent reader's values (Pillow) */
    assert_float_equal(sample(data, 0, 0, 0, 0, 0), 0.35640013f, 1e-7);
    assert_float_equal(sample(data, 5, 7, 10, 20, 1), 0.08021982f, 1e-7);
    assert_float_equal(sample(data, 80, 80, 63, 63, 2), 0.038204372f, 1e-7);
    assert_float_equal(sample(data, 40, 12, 33, 1, 0), 0.4072402f, 1e-7);
    const size_t count = 81 * 3 * (size_t)64 * 64;
    float *view = malloc(count * sizeof *view);
    assert_non_null(view);
    const double sums[2] = {120436.44909772754, 127598.78268555214};
    for (int i = 0; i < 2; i++) {
        double sum = 0;
        assert_int_equal(enc_data_view(&context, data, i * 80, view), BTF_OK);
        for (size_t k = 0; k < count; k++)
            sum += view[k];
        assert_float_equal(sum, sums[i], 1e-3);
    }
    free(view);
    enc_data_destroy(&data);
}

static void test_wallpaper(void **state) {
    (void)state;
    const char *path = shared_file("UBO_WALLPAPER256_top.zip");
    if (!path)
        skip();
    enc_data *data = NULL;
    assert_int_equal(enc_read(&context, path, &(enc_read_options){.size = {64, 64}}, &data), BTF_OK);
    assert_int_equal(data->width, 64);
    assert_int_equal(data->n_views, 1);
    assert_int_equal(data->n_lights, 81);
    assert_int_equal(data->top_view, 0);
    enc_data_destroy(&data);
}

int main(void) {
#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, make_folder, remove_folder)
    const struct CMUnitTest tests[] = {
        IN_FOLDER(test_names),
        IN_FOLDER(test_png_16),
        IN_FOLDER(test_jpeg),
        IN_FOLDER(test_float_formats),
        IN_FOLDER(test_xyz),
        IN_FOLDER(test_transfer),
        IN_FOLDER(test_geometry),
        IN_FOLDER(test_azimuths),
        cmocka_unit_test(test_directions),
        IN_FOLDER(test_missing_and_duplicate),
        IN_FOLDER(test_refused_directions),
        IN_FOLDER(test_refused_images),
        IN_FOLDER(test_refused_values),
        IN_FOLDER(test_scratch_file),
        IN_FOLDER(test_data),
        IN_FOLDER(test_archives),
        IN_FOLDER(test_bricks),
        IN_FOLDER(test_wallpaper),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
