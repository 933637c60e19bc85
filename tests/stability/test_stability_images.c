/* Images as cameras and other programs write them: every kind is decoded, or refused by name, and an incomplete file is
 * never accepted.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"

#include "encoder/input/image.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>
#include <png.h>

enum { W = 19, H = 13 };

typedef struct bytes {
    unsigned char *data;
    size_t size, room;
} bytes;

static void die(const char *what) {
    fprintf(stderr, "test_stability_images: %s\n", what);
    exit(99);
}

static void append(bytes *b, const void *data, size_t size) {
    if (b->size + size > b->room) {
        b->room = 2 * (b->size + size);
        b->data = realloc(b->data, b->room);
        if (!b->data) {
            die("out of memory");
        }
    }
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

/* The test picture, smooth so that JPEG keeps it: level 0..255 of a channel. */
static int level(int x, int y, int c) {
    return c == 0 ? 10 * x : c == 1 ? 15 * y : 255 - 10 * x;
}

typedef struct jpeg_kind {
    int channels; /* 1, 3, or 4 for CMYK */
    bool progressive, arithmetic, subsampled;
    int restart; /* rows between restart markers, 0 for none */
} jpeg_kind;

static bytes make_jpeg(jpeg_kind kind) {
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr errors;
    unsigned char *data = NULL;
    unsigned long size = 0;
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &data, &size);
    jpeg.image_width = W;
    jpeg.image_height = H;
    jpeg.input_components = kind.channels;
    jpeg.in_color_space = kind.channels == 1 ? JCS_GRAYSCALE : kind.channels == 3 ? JCS_RGB : JCS_CMYK;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 100, TRUE);
    for (int c = 0; c < jpeg.num_components && !kind.subsampled; c++) {
        jpeg.comp_info[c].h_samp_factor = jpeg.comp_info[c].v_samp_factor = 1;
    }
    jpeg.arith_code = kind.arithmetic;
    jpeg.restart_in_rows = kind.restart;
    if (kind.progressive) {
        jpeg_simple_progression(&jpeg);
    }
    jpeg_start_compress(&jpeg, TRUE);
    for (int y = 0; y < H; y++) {
        unsigned char row[W * 4];
        JSAMPROW rows = row;
        for (int x = 0; x < W; x++) {
            for (int c = 0; c < kind.channels; c++) {
                row[kind.channels * x + c] = (unsigned char)level(x, y, c % 3);
            }
        }
        jpeg_write_scanlines(&jpeg, &rows, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    bytes b = {0};
    append(&b, data, size);
    free(data);
    return b;
}

/* An EXIF block with one entry: the orientation. */
static void append_exif(bytes *b, bool big, int orientation) {
    static const unsigned char mm[] = {'M', 'M', 0, 42, 0, 0, 0, 8, 0, 1, 1, 0x12, 0,
                                       3,   0,   0, 0,  1, 0, 0, 0, 0, 0, 0, 0,    0};
    static const unsigned char ii[] = {'I', 'I', 42, 0, 8, 0, 0, 0, 1, 0, 0x12, 1, 3,
                                       0,   1,   0,  0, 0, 0, 0, 0, 0, 0, 0,    0, 0};
    const size_t at = b->size;
    append(b, big ? mm : ii, sizeof mm);
    b->data[at + (big ? 19 : 18)] = (unsigned char)orientation;
}

/* The JPEG with an EXIF marker behind its start. */
static bytes with_exif(bool big, int orientation) {
    const bytes plain = make_jpeg((jpeg_kind){.channels = 3});
    static const unsigned char marker[] = {0xff, 0xe1, 0, 34, 'E', 'x', 'i', 'f', 0, 0};
    bytes b = {0};
    append(&b, plain.data, 2);
    append(&b, marker, sizeof marker);
    append_exif(&b, big, orientation);
    append(&b, plain.data + 2, plain.size - 2);
    free(plain.data);
    return b;
}

static void on_write(png_structp png, png_bytep data, size_t size) {
    append(png_get_io_ptr(png), data, size);
}

static void on_flush(png_structp png) {
    (void)png;
}

typedef struct png_kind {
    int colour, depth;
    bool interlaced;
    int orientation; /* of an eXIf chunk, 0 for none */
} png_kind;

/* Levels are cut to the depth; a palette has an entry a row. */
static bytes make_png(png_kind kind) {
    bytes b = {0}, exif = {0};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    if (!info || setjmp(png_jmpbuf(png))) {
        die("libpng");
    }
    png_set_write_fn(png, &b, on_write, on_flush);
    png_set_IHDR(png, info, W, H, kind.depth, kind.colour,
                 kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (kind.colour == PNG_COLOR_TYPE_PALETTE) {
        png_color palette[16];
        for (int i = 0; i < 16; i++) {
            palette[i] =
                (png_color){(unsigned char)(16 * i), (unsigned char)(15 * i), (unsigned char)(255 - i)};
        }
        png_set_PLTE(png, info, palette, 16);
    }
    if (kind.orientation) {
        append_exif(&exif, true, kind.orientation);
        png_set_eXIf_1(png, info, (png_uint_32)exif.size, exif.data);
    }
    png_write_info(png, info);
    const int channels = kind.colour == PNG_COLOR_TYPE_RGB          ? 3
                         : kind.colour == PNG_COLOR_TYPE_RGB_ALPHA  ? 4
                         : kind.colour == PNG_COLOR_TYPE_GRAY_ALPHA ? 2
                                                                    : 1;
    unsigned char pixels[H][W * 8] = {{0}};
    png_bytep rows[H];
    for (int y = 0; y < H; y++) {
        for (int i = 0; i < W * channels; i++) {
            const int bits = kind.depth, x = i / channels;
            const int value = kind.colour == PNG_COLOR_TYPE_PALETTE ? y : level(x, y, i % channels % 3);
            if (bits == 16) {
                pixels[y][2 * i] = pixels[y][2 * i + 1] = (unsigned char)value;
            } else if (bits == 8) {
                pixels[y][i] = (unsigned char)value;
            } else {
                pixels[y][i * bits / 8] |=
                    (unsigned char)((kind.colour == PNG_COLOR_TYPE_PALETTE ? value : value >> (8 - bits))
                                    << (8 - bits - i * bits % 8));
            }
        }
        rows[y] = pixels[y];
    }
    png_write_image(png, rows);
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    free(exif.data);
    return b;
}

/* How far a decoded image is from the test picture, in levels of 255; -1 where it has another shape. */
static int difference(const enc_image *image, int channels, int depth, bool palette, int bits) {
    if (image->width != W || image->height != H || image->channels != channels || image->depth != depth) {
        return -1;
    }
    int worst = 0;
    for (int i = 0; i < W * H * channels; i++) {
        const int c = i % channels, x = i / channels % W, y = i / channels / W;
        int want = level(x, y, c);
        if (palette) {
            want = c == 0 ? 16 * y : c == 1 ? 15 * y : 255 - y;
        } else if (bits < 8) {
            want = (want >> (8 - bits)) * 255 / ((1 << bits) - 1);
        }
        const int seen =
            depth == 16 ? ((uint16_t *)image->pixels)[i] / 257 : ((unsigned char *)image->pixels)[i];
        const int distance = abs(seen - want);
        worst = distance > worst ? distance : worst;
    }
    return worst;
}

/* Counts the prefixes that are accepted as an image, each from a buffer of exactly its size. */
static int prefixes_taken(const bytes *b) {
    int taken = 0;
    for (size_t size = 0; size < b->size; size++) {
        char message[160] = "";
        enc_image image = {0};
        unsigned char *prefix = malloc(size ? size : 1);
        if (!prefix) {
            die("out of memory");
        }
        memcpy(prefix, b->data, size);
        const btf_result result = enc_image_decode(prefix, size, &image, message, sizeof message);
        taken += result == BTF_OK || !message[0];
        enc_image_clear(&image);
        free(prefix);
    }
    return taken;
}

static void expect_image(const char *input, bytes b, int channels, int depth, bool palette, int bits,
                         int most) {
    char message[160] = "";
    enc_image image = {0};
    const btf_result result = enc_image_decode(b.data, b.size, &image, message, sizeof message);
    const int worst = result == BTF_OK ? difference(&image, channels, depth, palette, bits) : -1;
    const int taken = prefixes_taken(&b);
    char expected[120];
    snprintf(expected, sizeof expected, "%d channel%s of %d bits, within %d of 255; every prefix refused",
             channels, channels > 1 ? "s" : "", depth, most);
    cases_add(input, expected, worst >= 0 && worst <= most && taken == 0,
              "%s%swithin %d; %d of %zu prefixes taken", message, message[0] ? "; " : "", worst, taken,
              b.size);
    enc_image_clear(&image);
    free(b.data);
}

static void expect_refusal(const char *input, bytes b, const char *words) {
    char message[160] = "", expected[120];
    enc_image image = {0};
    const btf_result result = enc_image_decode(b.data, b.size, &image, message, sizeof message);
    const int taken = prefixes_taken(&b);
    snprintf(expected, sizeof expected, "refused as not supported: %s", words);
    cases_add(input, expected, result == BTF_ERROR_UNSUPPORTED && strstr(message, words) && taken == 0,
              "%s", message);
    enc_image_clear(&image);
    free(b.data);
}

int main(void) {
    cases_title("Images as cameras and other programs write them.");
    expect_image("JPEG, baseline", make_jpeg((jpeg_kind){.channels = 3}), 3, 8, false, 8, 3);
    expect_image("JPEG, grey", make_jpeg((jpeg_kind){.channels = 1}), 1, 8, false, 8, 3);
    expect_image("JPEG, progressive", make_jpeg((jpeg_kind){.channels = 3, .progressive = true}), 3, 8,
                 false, 8, 3);
    expect_image("JPEG, arithmetic-coded", make_jpeg((jpeg_kind){.channels = 3, .arithmetic = true}), 3, 8,
                 false, 8, 3);
    expect_image("JPEG, chroma subsampled", make_jpeg((jpeg_kind){.channels = 3, .subsampled = true}), 3, 8,
                 false, 8, 24);
    expect_image("JPEG, restart markers", make_jpeg((jpeg_kind){.channels = 3, .restart = 1}), 3, 8, false,
                 8, 3);
    expect_refusal("JPEG, CMYK", make_jpeg((jpeg_kind){.channels = 4}), "4 colour components");
    expect_image("JPEG, EXIF orientation 1, big endian", with_exif(true, 1), 3, 8, false, 8, 3);
    expect_image("JPEG, EXIF orientation 9, which does not exist", with_exif(true, 9), 3, 8, false, 8, 3);
    expect_refusal("JPEG, EXIF orientation 6, big endian", with_exif(true, 6), "EXIF orientation 6");
    expect_refusal("JPEG, EXIF orientation 2, little endian", with_exif(false, 2), "EXIF orientation 2");
    static const struct {
        const char *name;
        png_kind kind;
        int channels;
    } kinds[] = {
        {"PNG, RGB", {PNG_COLOR_TYPE_RGB, 8, false, 0}, 3},
        {"PNG, RGB, interlaced", {PNG_COLOR_TYPE_RGB, 8, true, 0}, 3},
        {"PNG, RGB of 16 bits", {PNG_COLOR_TYPE_RGB, 16, false, 0}, 3},
        {"PNG, RGB of 16 bits, interlaced", {PNG_COLOR_TYPE_RGB, 16, true, 0}, 3},
        {"PNG, RGB and alpha", {PNG_COLOR_TYPE_RGB_ALPHA, 8, false, 0}, 3},
        {"PNG, grey", {PNG_COLOR_TYPE_GRAY, 8, false, 0}, 1},
        {"PNG, grey and alpha, 16 bits, interlaced", {PNG_COLOR_TYPE_GRAY_ALPHA, 16, true, 0}, 1},
        {"PNG, grey of 1 bit", {PNG_COLOR_TYPE_GRAY, 1, false, 0}, 1},
        {"PNG, grey of 4 bits, interlaced", {PNG_COLOR_TYPE_GRAY, 4, true, 0}, 1},
        {"PNG, palette of 4 bits", {PNG_COLOR_TYPE_PALETTE, 4, false, 0}, 3},
        {"PNG, palette of 8 bits, interlaced", {PNG_COLOR_TYPE_PALETTE, 8, true, 0}, 3},
        {"PNG, EXIF orientation 1", {PNG_COLOR_TYPE_RGB, 8, false, 1}, 3},
    };
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        expect_image(kinds[i].name, make_png(kinds[i].kind), kinds[i].channels,
                     kinds[i].kind.depth == 16 ? 16 : 8, kinds[i].kind.colour == PNG_COLOR_TYPE_PALETTE,
                     kinds[i].kind.depth, 0);
    }
    expect_refusal("PNG, EXIF orientation 8", make_png((png_kind){PNG_COLOR_TYPE_RGB, 8, false, 8}),
                   "EXIF orientation 8");
    return cases_result();
}
