/* OpenEXR files of other programs (decoder/toolkit/exr_image.h): subsampled channels, within the format's rules and
 * beyond them; layers, parts, compressions, colours, spectra. tests/valgrind.sh runs this program too.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/exr_image.h"
#include "tests/support/exr_bytes.h"
#include "tests/support/image_files.h"
#include "tests/support/test.h"

#include <unistd.h>

static char message[700];
static image_info info;

static const char *layer; /* the layer to read */

/* Reads parts as a file in a buffer of just its size. */
static btf_result read_parts(const bytes_part *parts, int count, exr_image *out_image) {
    size_t size;
    void *data = exr_bytes(parts, count, &size), *just = malloc(size);
    assert_non_null(just);
    memcpy(just, data, size);
    free(data);
    const btf_result result = (info = (image_info){0}, exr_image_read(just, size, 1 << 24, layer, out_image,
                                                                      &info, message, sizeof message));
    free(just);
    return result;
}

static exr_image read_good(const bytes_part *parts, int count) {
    exr_image image = {0};
    if (read_parts(parts, count, &image) != BTF_OK) {
        fail_msg("%s", message);
    }
    return image;
}

static void expect_refused(const bytes_part *parts, int count, const char *words) {
    exr_image image = {0};
    const btf_result result = read_parts(parts, count, &image);
    free(image.pixels);
    if (result != BTF_ERROR_UNSUPPORTED && result != BTF_ERROR_BAD_FILE) {
        fail_msg("%s: %d", words, result);
    }
    if (!strstr(message, words)) {
        fail_msg("\"%s\" does not say \"%s\"", message, words);
    }
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
    if (alpha) {
        p.channels[p.channel_count++] = (bytes_channel){"A", type, 1, 1};
    }
    p.channels[p.channel_count++] = (bytes_channel){"BY", type, xs, ys};
    p.channels[p.channel_count++] = (bytes_channel){"RY", type, xs, ys};
    p.channels[p.channel_count++] = (bytes_channel){"Y", type, 1, 1};
    return p;
}

static void expect_colours(const exr_image *image, double tolerance) {
    assert_int_equal(image->channels, 3);
    assert_false(image->xyz);
    for (int y = 0; y < image->height; y++) {
        for (int x = 0; x < image->width; x++) {
            float rgb[3];
            colour_at(x, y, rgb);
            for (int c = 0; c < 3; c++) {
                const float *p = image->pixels + ((size_t)y * (size_t)image->width + (size_t)x) * 3;
                /* behind the last chroma sample the last one is repeated */
                const bool edge = x == image->width - 1 || y == image->height - 1;
                if (!(fabsf(p[c] - rgb[c]) <= tolerance * (edge ? 3 : 1))) {
                    fail_msg("(%d,%d) channel %d: %g, not %g", x, y, c, (double)p[c], (double)rgb[c]);
                }
            }
        }
    }
}

/* Luminance and chroma, with and without alpha, half and float, chroma in every pixel or in every second
 * one of a line, a column, or both. */
TEST(test_chroma) {
    for (int k = 0; k < 16; k++) {
        const bytes_part p =
            chroma_part(k & 1, k & 2 ? BYTES_HALF : BYTES_FLOAT, k & 4 ? 2 : 1, k & 8 ? 2 : 1, 64, 48);
        exr_image image = read_good(&p, 1);
        expect_colours(&image, 4e-3);
        free(image.pixels);
    }
}

/* The file's chromaticities say what the luminance is made of. */
TEST(test_chroma_primaries) {
    static const float ap1[8] = {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f};
    static const float ap1_luma[3] = {0.2722287f, 0.6740818f, 0.0536895f};
    bytes_part p = chroma_part(false, BYTES_FLOAT, 2, 2, 32, 16);
    p.attributes[p.attribute_count++] =
        (bytes_attribute){"chromaticities", "chromaticities", ap1, sizeof ap1};
    luma = ap1_luma;
    exr_image image = read_good(&p, 1);
    luma = rec709;
    expect_colours(&image, 4e-3);
    free(image.pixels);
}

/* Each compression whose blocks OpenEXRCore can undo, with a window that does not begin at 0. */
TEST(test_chroma_compressed) {
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
        if (exr_image_read(data, size, 1 << 20, NULL, &image, &info, message, sizeof message) != BTF_OK) {
            fail_msg("compression %d: %s", p.compression, message);
        }
        free(data);
        expect_colours(&image, 4e-3);
        free(image.pixels);
    }
    unlink(path);
}

/* One to five channels of halves, each sampled 1 x 1, 2 x 1, 1 x 2 or 2 x 2, of widths from 1 to 200,000. The picture
 * has the values of its own channels, whatever channels stand beside them; subsampled colour is refused. */
TEST(test_sampling) {
    static const char *const sets[] = {"Y", "AY", "BGR", "ABGR", "ABGRZ", "BGY", "ABYZ", "ABUYZ", "XYZ"};
    static const int widths[] = {1, 2, 3, 4, 6, 14, 33, 34, 100, 4094, 199999, 200000};
    for (size_t s = 0; s < sizeof sets / sizeof sets[0]; s++) {
        for (size_t w = 0; w < sizeof widths / sizeof widths[0]; w++) {
            for (int which = 0; which < 1 << (strlen(sets[s])); which++) {
                char names[5][2] = {{0}};
                bytes_part p = {.width = widths[w], .height = 2, .value = some_value};
                if (widths[w] > 100 && which % 5 != 3 && which != 1) {
                    continue; /* wide ones: a few of each */
                }
                bool colour = false;
                const char *wanted = strstr(sets[s], "BGR") ? "RGB" : strstr(sets[s], "XYZ") ? "XYZ" : "Y";
                for (int c = 0; sets[s][c]; c++) {
                    const bool sub = which >> c & 1;
                    names[c][0] = sets[s][c];
                    p.channels[p.channel_count++] = (bytes_channel){
                        names[c], BYTES_HALF, sub && (which + c) % 3 != 1 && p.width % 2 == 0 ? 2 : 1,
                        sub && ((which + c) % 3 != 2 || p.width % 2) ? 2 : 1};
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
    }
}

/* The chroma of narrow, flat and wide images: every place is written. */
TEST(test_chroma_sizes) {
    static const int sizes[][2] = {{2, 2}, {4, 2}, {2, 4}, {6, 30}, {30, 6}, {200000, 2}, {2, 20000}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        for (int alpha = 0; alpha < 2; alpha++) {
            const bytes_part p = chroma_part(alpha, BYTES_HALF, 2, 2, sizes[i][0], sizes[i][1]);
            exr_image image = read_good(&p, 1);
            assert_int_equal(image.width, sizes[i][0]);
            for (int k = 0; k < 3 * image.width * image.height; k++) {
                assert_true(image.pixels[k] > 0.1f && image.pixels[k] < 2.0f);
            }
            free(image.pixels);
        }
    }
}

/* Sampling that the format forbids, or with which chroma cannot be read, is refused, whichever channel has it. */
TEST(test_sampling_out_of_spec) {
    static const int32_t bad[][2] = {{0, 1},         {1, 0},         {-1, 1},
                                     {2, -2},        {3, 1},         {1, 5},
                                     {INT32_MAX, 1}, {1, INT32_MAX}, {INT32_MIN, INT32_MIN},
                                     {65536, 65536}, {7, 7},         {32, 32}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        for (int c = 0; c < 4; c++) {
            bytes_part p = chroma_part(true, BYTES_HALF, 2, 2, 8, 4);
            p.channels[c].xs = bad[i][0];
            p.channels[c].ys = bad[i][1];
            expect_refused(&p, 1, "EXR");
        }
    }
    bytes_part p = chroma_part(false, BYTES_HALF, 4, 4, 16, 16);
    expect_refused(&p, 1, "BY is subsampled 4 x 4");
    p = chroma_part(false, BYTES_HALF, 2, 2, 7, 4); /* does not divide the window */
    expect_refused(&p, 1, "EXR");
    p = chroma_part(false, BYTES_HALF, 2, 2, 8, 4);
    p.x = 1;
    expect_refused(&p, 1, "EXR");
    p = chroma_part(false, BYTES_HALF, 2, 2, 8, 4); /* RY and BY sampled differently */
    p.channels[0].xs = 1;
    expect_refused(&p, 1, "is subsampled");
}

/* 1 + c / 8: the channel's number in its part, exact in a half. */
static float channel_value(int c, int x, int y) {
    (void)x;
    (void)y;
    return 1.0f + (float)c * 0.125f;
}

/* A part of channels whose names are given with slashes between them. */
static bytes_part part_of(const char *name, const char *channels) {
    static char names[16][256];
    static int next;
    bytes_part p = {.name = name, .width = 4, .height = 3, .value = channel_value};
    char *at = names[next++ % 16];
    snprintf(at, 256, "%s", channels);
    for (at = strtok(at, "/"); at; at = strtok(NULL, "/")) {
        p.channels[p.channel_count++] = (bytes_channel){at, BYTES_HALF, 1, 1};
    }
    return p;
}

/* Checks that the picture is made of these channels of its part, by number. */
static void expect_channels(const bytes_part *parts, int count, const char *name, int n,
                            const int *channels, const char *note) {
    layer = name;
    exr_image image = read_good(parts, count);
    layer = NULL;
    assert_int_equal(image.channels, n);
    for (int i = 0; i < 12 * n; i++) {
        assert_true(image.pixels[i] == channel_value(channels[i % n], 0, 0));
    }
    free(image.pixels);
    const char *text = info.notes.texts[IMAGE_NOTE_LAYER];
    if (note ? !strstr(text, note) : text[0] != '\0') {
        fail_msg("note \"%s\", not \"%s\"", text, note ? note : "");
    }
}

static const int bgr[3] = {2, 1, 0};

/* Files with one obvious choice of picture: a layer, names in lower case or in full, another part. */
TEST(test_plain_choice) {
    bytes_part parts[3] = {part_of(NULL, "diffuse.B/diffuse.G/diffuse.R")};
    expect_channels(parts, 1, NULL, 3, bgr, "layer diffuse");
    parts[0] = part_of(NULL, "b/g/r");
    expect_channels(parts, 1, NULL, 3, bgr, NULL);
    parts[0] = part_of(NULL, "blue/green/red");
    expect_channels(parts, 1, NULL, 3, bgr, NULL);
    parts[0] = part_of(NULL, "Combined.B/Combined.G/Combined.R/Depth.Z/Normal.X/Normal.Y/Normal.Z");
    expect_channels(parts, 1, NULL, 3, bgr, "layer Combined");
    parts[0] = part_of(NULL, "B/G/R/spec.B/spec.G/spec.R"); /* the first part's own stand for themselves */
    expect_channels(parts, 1, NULL, 3, bgr, NULL);
    parts[0] = part_of("depth", "Z");
    parts[1] = part_of("beauty", "A/B/G/R");
    expect_channels(parts, 2, NULL, 3, (const int[]){3, 2, 1}, "\"beauty\"");
    parts[1] = part_of("grey", "mask.Y");
    expect_channels(parts, 2, NULL, 1, (const int[]){0}, "layer mask");
    parts[0] = part_of("left", "B/G/R"); /* two alike: the first is read, with a message */
    parts[1] = part_of("right", "B/G/R");
    expect_channels(parts, 2, NULL, 3, bgr, NULL);
    assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_PARTS], "\"right\""));
}

/* Files with several choices or none: the message lists parts and channels, and --layer picks one by name. */
TEST(test_layer_option) {
    bytes_part parts[3] = {part_of(NULL, "a.B/a.G/a.R/b.c.B/b.c.G/b.c.R")};
    expect_refused(parts, 1, "option layer picks one: part 1 has a.B, a.G, a.R, b.c.B");
    expect_channels(parts, 1, "a", 3, bgr, NULL);
    expect_channels(parts, 1, "b.c", 3, (const int[]){5, 4, 3}, NULL);
    expect_channels(parts, 1, "b.c.G", 1, (const int[]){4}, NULL);
    layer = "c";
    expect_refused(parts, 1, "option layer: 'c' does not name exactly one layer, part or channel");
    layer = NULL;
    parts[0] = part_of("grey", "Y");
    parts[1] = part_of("one", "B/G/R");
    parts[2] = part_of("two", "B/G/R/x.B/x.G/x.R");
    expect_refused(parts, 3, "part \"one\" has B, G, R; part \"two\" has");
    expect_channels(parts, 3, "grey", 1, (const int[]){0}, NULL);
    expect_channels(parts, 3, "one", 3, bgr, NULL);
    expect_channels(parts, 3, "two", 3, bgr, NULL);
    expect_channels(parts, 3, "two.x", 3, (const int[]){5, 4, 3}, NULL);
    layer = "G";
    expect_refused(parts, 3, "does not name exactly one layer, part or channel");
    layer = NULL;
    parts[0] = part_of(NULL, "Normal.X/Normal.Y/Normal.Z/u/v"); /* not colours */
    expect_refused(parts, 1, "Normal.X, Normal.Y, Normal.Z, u, v");
}

/* Luminance with one of the two chroma channels is not read as grey; one of several grey pictures is read with a
 * message. */
TEST(test_grey_choice) {
    bytes_part parts[3] = {part_of(NULL, "RY/Y")};
    expect_refused(parts, 1, "part 1 has RY, Y");
    expect_channels(parts, 1, "Y", 1, (const int[]){1}, NULL);
    parts[0] = part_of(NULL, "l.BY/l.Y");
    expect_refused(parts, 1, "part 1 has l.BY, l.Y");
    parts[0] = part_of("400nm", "Y"); /* a band a part */
    parts[1] = part_of("500nm", "Y");
    expect_channels(parts, 2, NULL, 1, (const int[]){0}, NULL);
    assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_PARTS], "\"500nm\""));
    parts[0] = part_of("beauty", "B/G/R"); /* a mask beside colours is no choice */
    expect_channels(parts, 2, NULL, 3, bgr, NULL);
    assert_true(info.notes.texts[IMAGE_NOTE_PARTS][0] == '\0');
}

static float number_value(int c, int x, int y) {
    (void)x;
    (void)y;
    return (float)c;
}

/* A file of one pixel and `count` layers, one of them or all chosen from; by number, count - 1 last. */
TEST(test_many_layers) {
    enum { LAYERS = 100 };
    static char names[3 * LAYERS][16];
    static bytes_part p;
    for (int many = 0; many < 2; many++) { /* colours beside 100 layers, then the 100 alone */
        p = (bytes_part){.width = 1, .height = 1, .value = number_value};
        for (int l = 0; l < LAYERS; l++) {
            for (int c = 0; c < 3; c++) {
                snprintf(names[3 * l + c], sizeof names[0], "Al%03d.%c", l, "BGR"[c]);
                p.channels[p.channel_count++] = (bytes_channel){names[3 * l + c], BYTES_HALF, 1, 1};
            }
        }
        for (int c = 0; c < 3 && !many; c++) { /* by name behind them all */
            p.channels[p.channel_count++] = (bytes_channel){&"B\0G\0R"[2 * c], BYTES_HALF, 1, 1};
        }
        layer = many ? "Al099" : NULL;
        exr_image image = read_good(&p, 1);
        layer = NULL;
        for (int c = 0; c < 3; c++) {
            assert_true(image.pixels[c] == (float)(p.channel_count - 1 - c));
        }
        free(image.pixels);
    }
    expect_refused(&p, 1, "option layer picks one");
}

/* A file with too many channels is refused. */
TEST(test_too_many_channels) {
    enum { COUNT = 4097 };
    static char names[COUNT][8];
    static bytes_part p = {.width = 1, .height = 1, .value = number_value};
    for (int c = 0; c < COUNT; c++) {
        snprintf(names[c], sizeof names[0], "%05d", c);
        p.channels[c] = (bytes_channel){names[c], BYTES_HALF, 1, 1};
    }
    p.channel_count = COUNT;
    expect_refused(&p, 1, "4097 channels");
}

TEST(test_deep) {
    bytes_part parts[2] = {part_of("smoke", "B/G/R/Z"), part_of("beauty", "B/G/R")};
    parts[0].deep = true;
    expect_channels(parts, 2, NULL, 3, bgr, "\"beauty\"");
    parts[1] = part_of("depth", "Z");
    expect_refused(parts, 2, "part \"smoke\" (deep data)");
}

TEST(test_compression) {
    static const char *const names[] = {"B44 ", "B44A ", "DWAA ", "DWAB "};
    bytes_part p = part_of(NULL, "B/G/R");
    for (int k = 0; k < 10; k++) {
        p.compression = k;
        if (k < 6) {
            expect_channels(&p, 1, NULL, 3, bgr, NULL);
        } else {
            expect_refused(&p, 1, names[k - 6]);
        }
    }
}

static void add(bytes_part *p, const char *name, const char *type, const void *value, size_t size) {
    p->attributes[p->attribute_count++] = (bytes_attribute){name, type, value, size};
}

/* ACEScg and XYZ by their chromaticities: known colours of Rec. 709 come out; Rec. 709's own are left
 * alone. */
TEST(test_chromaticities) {
    static const float ap1[8] = {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f};
    static const float xyz[8] = {1, 0, 0, 1, 0, 0, 1 / 3.0f, 1 / 3.0f};
    static const float same[8] = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
    static const float flat[8] = {0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f};
    /* red, green and blue of Rec. 709 in ACEScg, by Bradford's adaptation, as published with ACES */
    static const float in_ap1[3][3] = {{0.613097f, 0.070194f, 0.020616f},
                                       {0.339523f, 0.916354f, 0.109570f},
                                       {0.047379f, 0.013452f, 0.869815f}};
    bytes_part p = part_of(NULL, "B/G/R");
    add(&p, "chromaticities", "chromaticities", ap1, sizeof ap1);
    exr_image image = read_good(&p, 1);
    free(image.pixels);
    assert_true(info.converts);
    assert_non_null(strstr(info.primaries_name, "red (0.713,0.293)"));
    for (int c = 0; c < 3; c++) {
        float pixel[3] = {in_ap1[c][0], in_ap1[c][1], in_ap1[c][2]};
        primaries_apply(info.to_rec709, 1, pixel);
        for (int k = 0; k < 3; k++) {
            assert_true(fabsf(pixel[k] - (float)(k == c)) < 5e-4f);
        }
    }
    p.attributes[0].value = xyz; /* white E becomes white */
    image = read_good(&p, 1);
    free(image.pixels);
    float white[3] = {1, 1, 1};
    assert_true(info.converts);
    primaries_apply(info.to_rec709, 1, white);
    for (int k = 0; k < 3; k++) {
        assert_true(fabsf(white[k] - 1) < 1e-4f);
    }
    p.attributes[0].value = same;
    image = read_good(&p, 1);
    free(image.pixels);
    assert_false(info.converts);
    p.attributes[0].value = flat;
    image = read_good(&p, 1);
    free(image.pixels);
    assert_false(info.converts);
    assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_SPACE], "span no colour space"));
}

/* Attributes that change the meaning of pixels, but are not followed, give a message. */
TEST(test_notes) {
    static const float nits = 100;
    static const int32_t turned = 6, upright = 1;
    bytes_part p = part_of(NULL, "A/B/G/R");
    p.aspect = 2;
    p.display[2] = 10;
    p.display[3] = 20;
    add(&p, "whiteLuminance", "float", &nits, sizeof nits);
    add(&p, "oiio:ColorSpace", "string", "ACEScg", 6);
    add(&p, "Orientation", "int", &upright, sizeof upright);
    free(read_good(&p, 1).pixels);
    assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_ASPECT], "pixelAspectRatio 2"));
    assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_WINDOW],
                           "(0,0)-(3,2) is read, not the display window (0,0)-(9,19)"));
    assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_SCALE], "whiteLuminance 100"));
    assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_SPACE], "ACEScg"));
    assert_true(info.notes.texts[IMAGE_NOTE_ALPHA][0] == '\0'); /* A is 1 */
    p.attributes[2].value = &turned;
    expect_refused(&p, 1, "Orientation 6");
    static const struct {
        const char *name, *type, *value, *note; /* NULL: none */
    } spaces[] = {{"ColorSpace", "string", "sRGB", "ColorSpace \"sRGB\""},
                  {"arnold/color_space", "string", "ACEScg", "ACEScg"},
                  {"colorInteropID", "string", "lin_ap1_scene", "lin_ap1_scene"},
                  {"colorspace", "string", "Linear Rec.709 (sRGB)", NULL},
                  {"oiio:ColorSpace", "string", "lin_srgb", NULL},
                  {"comment", "string", "sRGB", NULL},
                  {"acesImageContainerFlag", "int", "\1\0\0\0", "acesImageContainerFlag"}};
    for (size_t k = 0; k < sizeof spaces / sizeof *spaces; k++) {
        p = part_of(NULL, "B/G/R");
        const bool text = strcmp(spaces[k].type, "string") == 0;
        add(&p, spaces[k].name, spaces[k].type, spaces[k].value, text ? strlen(spaces[k].value) : 4);
        free(read_good(&p, 1).pixels);
        const char *note = info.notes.texts[IMAGE_NOTE_SPACE];
        if (spaces[k].note ? !strstr(note, spaces[k].note) : note[0] != '\0') {
            fail_msg("%s: \"%s\"", spaces[k].name, note);
        }
    }
    p = part_of(NULL, "A/B/G/R");
    free(read_good(&p, 1).pixels);
    for (int k = 0; k < IMAGE_NOTE_KINDS; k++) {
        assert_true(info.notes.texts[k][0] == '\0');
    }
}

/* A message tells of the other view of a stereo picture in one part. */
TEST(test_views) {
    static const char views[] = "\4\0\0\0left\5\0\0\0right";
    bytes_part p = part_of(NULL, "B/G/R/right.B/right.G/right.R");
    add(&p, "multiView", "stringvector", views, sizeof views - 1);
    expect_channels(&p, 1, NULL, 3, bgr, NULL);
    assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_PARTS],
                           "\"left\" is read (option layer: \"right\" reads another)"));
    expect_channels(&p, 1, "right", 3, (const int[]){5, 4, 3}, NULL);
    assert_true(info.notes.texts[IMAGE_NOTE_PARTS][0] == '\0');
    p.attributes[0].size = 8; /* one view */
    expect_channels(&p, 1, NULL, 3, bgr, NULL);
    assert_true(info.notes.texts[IMAGE_NOTE_PARTS][0] == '\0');
}

static float half_clear(int c, int x, int y) {
    return c == 0 && x == 1 && y == 2 ? 0.5f : 1.0f;
}

TEST(test_alpha) {
    static const char *const names[] = {"A/B/G/R", "a/b/g/r", "Alpha/Blue/Green/Red", "l.A/l.B/l.G/l.R",
                                        "l.alpha/l.blue/l.green/l.red"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        bytes_part p = part_of(NULL, names[k]);
        p.value = half_clear;
        free(read_good(&p, 1).pixels);
        assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_ALPHA], "alpha below 1"));
    }
    bytes_part p = part_of(NULL, "B/G/R/l.A"); /* another layer's */
    p.value = half_clear;
    free(read_good(&p, 1).pixels);
    assert_true(info.notes.texts[IMAGE_NOTE_ALPHA][0] == '\0');
}

static float reflectance(int c, int x, int y) {
    (void)x;
    return y == 0   ? 1.0f
           : y == 1 ? (c == 30 ? 64.0f : 0.0f)
                    : (float)(c >= 20 ? 1 : 0); /* white, a line, red */
}

/* Channels by wavelength as several programs name them: white is white, a line at the last band is red. */
TEST(test_spectrum) {
    static const char *const formats[] = {"%dnm",           "w%dnm",  "T.%d,000000nm", "T.%d.0nm",
                                          "S0.%d,000000nm", "%d.0nm", "%d.00-%d.00nm", "m.%d-%dnm"};
    for (size_t f = 0; f < sizeof formats / sizeof *formats; f++) {
        static char names[31][32];
        bytes_part p = {.width = 2, .height = 3, .value = reflectance};
        for (int b = 0; b < 31; b++) { /* names of three digits rise with the wavelength */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
            if (strchr(formats[f], '-')) { /* a band, of the same middle */
                snprintf(names[b], sizeof names[b], formats[f], 395 + 10 * b, 405 + 10 * b);
            } else {
                snprintf(names[b], sizeof names[b], formats[f], 400 + 10 * b);
            }
#pragma GCC diagnostic pop
            p.channels[p.channel_count++] = (bytes_channel){names[b], BYTES_FLOAT, 1, 1};
        }
        const bool light = formats[f][0] == 'S';
        exr_image image = read_good(&p, 1);
        assert_int_equal(image.channels, 3);
        const float *white = image.pixels, *line = white + 6, *red = white + 12;
        if (light) {
            /* illuminant E in Rec. 709; the fitted functions' own white is within 1 % of it */
            assert_true(fabsf(white[0] - 1.205f) < 0.02f && fabsf(white[1] - 0.948f) < 0.02f &&
                        fabsf(white[2] - 0.909f) < 0.02f);
        } else {
            for (int c = 0; c < 3; c++) {
                assert_true(fabsf(white[c] - 1.0f) < 1e-5f);
            }
        }
        assert_true(line[0] > 0 && fabsf(line[1]) < line[0] && fabsf(line[2]) < 0.2f * line[0]);
        assert_true(red[0] > 0.8f * white[0] && fabsf(red[1]) < 0.1f && fabsf(red[2]) < 0.1f);
        free(image.pixels);
        assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_SPECTRUM], "31 bands of 400 to 700 nm"));
        assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_SPECTRUM], light ? "as light" : "under D65"));
    }
    /* of a spectrum with RGB beside it, RGB is read, with a message */
    bytes_part p = part_of(NULL, "B/G/R/T.400nm/T.500nm/T.600nm/T.700nm");
    free(read_good(&p, 1).pixels);
    assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_PARTS], "spectrum"));
    layer = "spectral";
    free(read_good(&p, 1).pixels);
    assert_non_null(strstr(info.notes.texts[IMAGE_NOTE_SPECTRUM], "4 bands"));
    layer = NULL;
    p = part_of(NULL, "400.0nm/400nm/500nm/600nm");
    expect_refused(&p, 1, "two channels have the wavelength of 400 nm");
    p = part_of(NULL, "1000nm/1100nm/1200nm/1300nm");
    expect_refused(&p, 1, "lies outside of what is visible");
}

RUN_TESTS(NULL, NULL)
