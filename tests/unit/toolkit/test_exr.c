/* OpenEXR files of other programs (decoder/toolkit/exr_image.h): sampling of any kind, within the format and beyond it.
 * Valgrind runs this program too: tests/valgrind.sh.
 *
 * SPDX-License-Identifier: MIT
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "decoder/toolkit/exr_image.h"
#include "tests/support/exr_bytes.h"
#include "tests/support/image_files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char message[700];
static image_info info;

static const char *layer; /* to read */

/* Reads parts as a file in a buffer of just its size. */
static btf_result read_parts(const bytes_part *parts, int count, exr_image *out_image) {
    size_t size;
    void *data = exr_bytes(parts, count, &size), *just = malloc(size);
    assert_non_null(just);
    memcpy(just, data, size);
    free(data);
    const btf_result result = (info = (image_info){0}, exr_image_read(just, size, 1 << 24, layer, out_image, &info, message, sizeof message));
    free(just);
    return result;
}

static exr_image read_good(const bytes_part *parts, int count) {
    exr_image image = {0};
    if (read_parts(parts, count, &image) != BTF_OK)
        fail_msg("%s", message);
    return image;
}

static void expect_refused(const bytes_part *parts, int count, const char *words) {
    exr_image image = {0};
    const btf_result result = read_parts(parts, count, &image);
    free(image.pixels);
    if (result != BTF_ERROR_UNSUPPORTED && result != BTF_ERROR_BAD_FILE)
        fail_msg("%s: %d", words, result);
    if (!strstr(message, words))
        fail_msg("\"%s\" does not say \"%s\"", message, words);
}

/* A value of a half for each channel and place. */
static float some_value(int c, int x, int y) {
    return (float)(1 + (x * 7 + y * 13 + c * 31) % 1000) / 16;
}

/* Colours of little saturation that change along both axes. */
static void colour_at(int x, int y, float rgb[3]) {
    const float level = 0.5f + 0.2f * sinf((float)x * 0.2f) + 0.1f * cosf((float)y * 0.3f);
    rgb[0] = level * (1.0f + 0.2f * sinf((float)(x + y) * 0.05f));
    rgb[1] = level;
    rgb[2] = level * (1.0f - 0.2f * cosf((float)x * 0.04f));
}

static const float rec709[3] = {0.2126390f, 0.7151687f, 0.0721923f};
static const float *luma = rec709;

/* Channels A, BY, RY, Y; without A they begin at BY. */
static int first_channel;
static float chroma_value(int c, int x, int y) {
    float rgb[3];
    colour_at(x, y, rgb);
    const float luminance = luma[0] * rgb[0] + luma[1] * rgb[1] + luma[2] * rgb[2];
    switch (c + first_channel) {
    case 0:
        return 1.0f;
    case 1:
        return (rgb[2] - luminance) / luminance;
    case 2:
        return (rgb[0] - luminance) / luminance;
    default:
        return luminance;
    }
}

static bytes_part chroma_part(bool alpha, int type, int xs, int ys, int width, int height) {
    bytes_part p = {.width = width, .height = height, .value = chroma_value};
    first_channel = alpha ? 0 : 1;
    if (alpha)
        p.channels[p.channel_count++] = (bytes_channel){"A", type, 1, 1};
    p.channels[p.channel_count++] = (bytes_channel){"BY", type, xs, ys};
    p.channels[p.channel_count++] = (bytes_channel){"RY", type, xs, ys};
    p.channels[p.channel_count++] = (bytes_channel){"Y", type, 1, 1};
    return p;
}

static void expect_colours(const exr_image *image, double tolerance) {
    assert_int_equal(image->channels, 3);
    assert_false(image->xyz);
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            float rgb[3];
            colour_at(x, y, rgb);
            for (int c = 0; c < 3; c++) {
                const float *p = image->pixels + ((size_t)y * (size_t)image->width + (size_t)x) * 3;
                /* behind the last chroma sample the last one is repeated */
                const bool edge = x == image->width - 1 || y == image->height - 1;
                if (!(fabsf(p[c] - rgb[c]) <= tolerance * (edge ? 3 : 1)))
                    fail_msg("(%d,%d) channel %d: %g, not %g", x, y, c, (double)p[c], (double)rgb[c]);
            }
        }
}

/* Luminance and chroma, with and without alpha, half and float, chroma in every pixel or in every second one of a
 * line, a column, or both. */
static void test_chroma(void **state) {
    (void)state;
    for (int k = 0; k < 16; k++) {
        const bytes_part p = chroma_part(k & 1, k & 2 ? BYTES_HALF : BYTES_FLOAT, k & 4 ? 2 : 1, k & 8 ? 2 : 1, 64, 48);
        exr_image image = read_good(&p, 1);
        expect_colours(&image, 4e-3);
        free(image.pixels);
    }
}

/* The file's chromaticities say what the luminance is made of. */
static void test_chroma_primaries(void **state) {
    (void)state;
    static const float ap1[8] = {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f};
    static const float ap1_luma[3] = {0.2722287f, 0.6740818f, 0.0536895f};
    bytes_part p = chroma_part(false, BYTES_FLOAT, 2, 2, 32, 16);
    p.attributes[p.attribute_count++] = (bytes_attribute){"chromaticities", "chromaticities", ap1, sizeof ap1};
    luma = ap1_luma;
    exr_image image = read_good(&p, 1);
    luma = rec709;
    expect_colours(&image, 4e-3);
    free(image.pixels);
}

/* Each compression whose blocks OpenEXRCore can undo, with a window that does not begin at 0. */
static void test_chroma_compressed(void **state) {
    (void)state;
    static const int compressions[] = {0, 1, 2, 3, 4, 5}; /* none, RLE, ZIPS, ZIP, PIZ, PXR24 */
    char path[] = "/tmp/btf-exr-XXXXXX";
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    close(fd);
    for (int k = 0; k < 24; k++) {
        bytes_part p = chroma_part(k % 4 & 1, k % 4 & 2 ? BYTES_HALF : BYTES_FLOAT, 2, 2, 70, 74);
        p.compression = compressions[k / 4];
        p.x = -4;
        p.y = 6;
        exr_bytes_compressed(path, &p);
        size_t size;
        exr_image image = {0};
        void *data = read_whole_file(path, &size);
        if (exr_image_read(data, size, 1 << 20, NULL, &image, &info, message, sizeof message) != BTF_OK)
            fail_msg("compression %d: %s", p.compression, message);
        free(data);
        expect_colours(&image, 4e-3);
        free(image.pixels);
    }
    unlink(path);
}

/* One to five channels of halves, each sampled 1 x 1, 2 x 1, 1 x 2 or 2 x 2, of widths up to 200,000: what the picture
 * needs has its own values, whatever stands beside it; subsampled colour is refused. */
static void test_sampling(void **state) {
    (void)state;
    static const char *const sets[] = {"Y", "AY", "BGR", "ABGR", "ABGRZ", "BGY", "ABYZ", "ABUYZ", "XYZ"};
    static const int widths[] = {2, 4, 6, 14, 34, 100, 4094, 200000};
    for (size_t s = 0; s < sizeof sets / sizeof sets[0]; s++)
        for (size_t w = 0; w < sizeof widths / sizeof widths[0]; w++)
            for (int which = 0; which < 1 << (strlen(sets[s])); which++) {
                char names[5][2] = {{0}};
                bytes_part p = {.width = widths[w], .height = 2, .value = some_value};
                if (widths[w] > 100 && which % 5 != 3 && which != 1)
                    continue; /* wide ones: a few of each */
                bool colour = false;
                const char *wanted = strstr(sets[s], "BGR") ? "RGB" : strstr(sets[s], "XYZ") ? "XYZ" : "Y";
                for (int c = 0; sets[s][c]; c++) {
                    const bool sub = which >> c & 1;
                    names[c][0] = sets[s][c];
                    p.channels[p.channel_count++] = (bytes_channel){
                        names[c], BYTES_HALF, sub && (which + c) % 3 != 1 ? 2 : 1, sub && (which + c) % 3 != 2 ? 2 : 1};
                    colour = colour || (sub && strchr(wanted, sets[s][c]));
                }
                if (colour) {
                    expect_refused(&p, 1, "sampled");
                    continue;
                }
                exr_image image = read_good(&p, 1);
                const int n = image.channels;
                for (int i = 0; i < n * image.width * image.height; i++) {
                    const int c = (int)(strchr(sets[s], wanted[i % n]) - sets[s]);
                    assert_true(image.pixels[i] == some_value(c, i / n % image.width, i / n / image.width));
                }
                free(image.pixels);
            }
}

/* The chroma of narrow, flat and wide images: every place is written. */
static void test_chroma_sizes(void **state) {
    (void)state;
    static const int sizes[][2] = {{2, 2}, {4, 2}, {2, 4}, {6, 30}, {30, 6}, {200000, 2}, {2, 20000}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
        for (int alpha = 0; alpha < 2; alpha++) {
            const bytes_part p = chroma_part(alpha, BYTES_HALF, 2, 2, sizes[i][0], sizes[i][1]);
            exr_image image = read_good(&p, 1);
            assert_int_equal(image.width, sizes[i][0]);
            for (int k = 0; k < 3 * image.width * image.height; k++)
                assert_true(image.pixels[k] > 0.1f && image.pixels[k] < 2.0f);
            free(image.pixels);
        }
}

/* Sampling that is not of the format, or that chroma is not read with: refused, whichever channel has it. */
static void test_sampling_out_of_spec(void **state) {
    (void)state;
    static const int32_t bad[][2] = {{0, 1}, {1, 0}, {-1, 1}, {2, -2}, {3, 1}, {1, 5}, {INT32_MAX, 1},
                                     {1, INT32_MAX}, {INT32_MIN, INT32_MIN}, {65536, 65536}, {7, 7}, {32, 32}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        for (int c = 0; c < 4; c++) {
            bytes_part p = chroma_part(true, BYTES_HALF, 2, 2, 8, 4);
            p.channels[c].xs = bad[i][0];
            p.channels[c].ys = bad[i][1];
            expect_refused(&p, 1, "EXR");
        }
    bytes_part p = chroma_part(false, BYTES_HALF, 4, 4, 16, 16);
    expect_refused(&p, 1, "BY is sampled 4 x 4");
    p = chroma_part(false, BYTES_HALF, 2, 2, 7, 4); /* does not divide the window */
    expect_refused(&p, 1, "EXR");
    p = chroma_part(false, BYTES_HALF, 2, 2, 8, 4);
    p.x = 1;
    expect_refused(&p, 1, "EXR");
    p = chroma_part(false, BYTES_HALF, 2, 2, 8, 4); /* the two of another sampling */
    p.channels[0].xs = 1;
    expect_refused(&p, 1, "is sampled");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_chroma),
        cmocka_unit_test(test_chroma_primaries),
        cmocka_unit_test(test_chroma_compressed),
        cmocka_unit_test(test_chroma_sizes),
        cmocka_unit_test(test_sampling),
        cmocka_unit_test(test_sampling_out_of_spec),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
