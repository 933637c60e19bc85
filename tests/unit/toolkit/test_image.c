/* Decoding of single images (encoder/input/image.h): every format in sound files, in files cut off anywhere, and in odd
 * ones.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/exr_image.h"
#include "decoder/toolkit/jpeg_image.h"
#include "decoder/toolkit/png_image.h"
#include "encoder/input/image.h"
#include "tests/support/image_files.h"
#include "tests/support/temporary.h"
#include "tests/support/test.h"

#include <png.h>
#include <unistd.h>

enum { W = 19, H = 13 };
static const btf_log no_log = {NULL, NULL};

static unsigned char byte_at(int i) {
    return (unsigned char)((unsigned)i * 7u % 251u);
}

/* Decodes the temporary file; the caller clears the image. */
static enc_image decode(void) {
    size_t size;
    char message[700];
    enc_image image = {0};
    void *data = read_whole_file(temporary_file, &size);
    const btf_result result = enc_image_decode(data, size, &image, message, sizeof message);
    free(data);
    if (result != BTF_OK) {
        fail_msg("%s", message);
    }
    assert_int_equal(image.width, W);
    assert_int_equal(image.height, H);
    return image;
}

static void expect_error(btf_result expected, const char *text) {
    size_t size;
    char message[700];
    enc_image image = {0};
    void *data = read_whole_file(temporary_file, &size);
    const btf_result result = enc_image_decode(data, size, &image, message, sizeof message);
    free(data);
    assert_int_equal(result, expected);
    if (!strstr(message, text)) {
        fail_msg("\"%s\" does not say \"%s\"", message, text);
    }
}

/* Every prefix of the temporary file, in a buffer of just its size, is refused with a message. */
static void expect_prefixes_refused(void) {
    size_t size;
    void *data = read_whole_file(temporary_file, &size);
    for (size_t n = 0; n < size; n++) {
        char message[700] = "";
        enc_image image = {0};
        void *prefix = malloc(n ? n : 1);
        assert_non_null(prefix);
        memcpy(prefix, data, n);
        const btf_result result = enc_image_decode(prefix, n, &image, message, sizeof message);
        free(prefix);
        if (result == BTF_OK) {
            fail_msg("%zu of %zu bytes were taken for an image", n, size);
        }
        assert_true(result == BTF_ERROR_BAD_FILE || result == BTF_ERROR_UNSUPPORTED);
        assert_true(message[0]);
    }
    free(data);
}

static void expect_bytes(const enc_image *image, int channels, const unsigned char *expected) {
    assert_int_equal(image->depth, 8);
    assert_int_equal(image->channels, channels);
    assert_memory_equal(image->pixels, expected, (size_t)(W * H * channels));
}

TEST(test_png_rgb) {
    unsigned char rgb[W * H * 3];
    for (int i = 0; i < W * H * 3; i++) {
        rgb[i] = byte_at(i);
    }
    assert_int_equal(png_image_write8(temporary_file, W, H, rgb, no_log), BTF_OK);
    enc_image image = decode();
    expect_bytes(&image, 3, rgb);
    enc_image_clear(&image);
    expect_prefixes_refused();
    write_png(temporary_file, W, H, PNG_COLOR_TYPE_RGB, 8, true, rgb, NULL);
    image = decode();
    expect_bytes(&image, 3, rgb);
    enc_image_clear(&image);
}

TEST(test_png_16) {
    unsigned short rgb[W * H * 3];
    for (int i = 0; i < W * H * 3; i++) {
        rgb[i] = (unsigned short)(i * 257 + i % 7);
    }
    assert_int_equal(png_image_write16(temporary_file, W, H, rgb, no_log), BTF_OK);
    enc_image image = decode();
    assert_int_equal(image.depth, 16);
    assert_int_equal(image.channels, 3);
    assert_memory_equal(image.pixels, rgb, sizeof rgb);
    enc_image_clear(&image);
    /* grey, as bytes: the higher one first */
    unsigned char grey[W * H * 2];
    for (int i = 0; i < W * H * 2; i++) {
        grey[i] = byte_at(i);
    }
    write_png(temporary_file, W, H, PNG_COLOR_TYPE_GRAY, 16, false, grey, NULL);
    image = decode();
    assert_int_equal(image.depth, 16);
    assert_int_equal(image.channels, 1);
    for (int i = 0; i < W * H; i++) {
        assert_int_equal(((unsigned short *)image.pixels)[i], grey[2 * i] * 256 + grey[2 * i + 1]);
    }
    enc_image_clear(&image);
}

TEST(test_png_kinds) {
    unsigned char in[W * H * 4], out[W * H * 3], palette[3 * 256];
    for (int i = 0; i < W * H * 4; i++) {
        in[i] = byte_at(i);
    }
    for (int i = 0; i < 3 * 256; i++) {
        palette[i] = (unsigned char)(255 - i % 256);
    }

    write_png(temporary_file, W, H, PNG_COLOR_TYPE_GRAY, 8, false, in, NULL);
    enc_image image = decode();
    expect_bytes(&image, 1, in);
    enc_image_clear(&image);

    write_png(temporary_file, W, H, PNG_COLOR_TYPE_RGB_ALPHA, 8, false, in, NULL);
    for (int i = 0; i < W * H * 3; i++) {
        out[i] = in[i / 3 * 4 + i % 3];
    }
    image = decode();
    expect_bytes(&image, 3, out);
    enc_image_clear(&image);

    write_png(temporary_file, W, H, PNG_COLOR_TYPE_GRAY_ALPHA, 8, false, in, NULL);
    for (int i = 0; i < W * H; i++) {
        out[i] = in[2 * i];
    }
    image = decode();
    expect_bytes(&image, 1, out);
    enc_image_clear(&image);

    write_png(temporary_file, W, H, PNG_COLOR_TYPE_PALETTE, 8, false, in, palette);
    for (int i = 0; i < W * H * 3; i++) {
        out[i] = palette[3 * in[i / 3] + i % 3];
    }
    image = decode();
    expect_bytes(&image, 3, out);
    enc_image_clear(&image);

    /* 4 bits a pixel, two in a byte, rows begin anew */
    write_png(temporary_file, W, H, PNG_COLOR_TYPE_GRAY, 4, false, in, NULL);
    for (int row = 0; row < H; row++) {
        for (int x = 0; x < W; x++) {
            out[row * W + x] =
                (unsigned char)((in[row * ((W + 1) / 2) + x / 2] >> (x % 2 ? 0 : 4) & 15) * 17);
        }
    }
    image = decode();
    expect_bytes(&image, 1, out);
    enc_image_clear(&image);
}

/* A bit flipped within the data is found by its checksum. */
TEST(test_png_damaged) {
    unsigned char rgb[W * H * 3];
    for (int i = 0; i < W * H * 3; i++) {
        rgb[i] = byte_at(i);
    }
    assert_int_equal(png_image_write8(temporary_file, W, H, rgb, no_log), BTF_OK);
    size_t size;
    unsigned char *data = read_whole_file(temporary_file, &size);
    data[size / 2] ^= 16;
    write_whole_file(temporary_file, data, size);
    free(data);
    expect_error(BTF_ERROR_BAD_FILE, "PNG");
}

TEST(test_jpeg) {
    unsigned char rgb[W * H * 3];
    for (int i = 0; i < W * H; i++) {
        rgb[3 * i] = (unsigned char)(10 * (i % W));
        rgb[3 * i + 1] = (unsigned char)(15 * (i / W));
        rgb[3 * i + 2] = (unsigned char)(255 - 10 * (i % W));
    }
    assert_int_equal(jpeg_image_write(temporary_file, W, H, rgb, 100, no_log), BTF_OK);
    enc_image image = decode();
    assert_int_equal(image.depth, 8);
    assert_int_equal(image.channels, 3);
    for (int i = 0; i < W * H * 3; i++) {
        assert_true(abs(((unsigned char *)image.pixels)[i] - rgb[i]) <= 3);
    }
    enc_image_clear(&image);
    expect_prefixes_refused();

    /* libjpeg would paint the rest grey */
    size_t size;
    unsigned char *data = read_whole_file(temporary_file, &size);
    data[size - 1] = 0xd9;
    data[size - 2] = 0xff;
    memmove(data + size / 2, data + size - 2, 2);
    write_whole_file(temporary_file, data, size / 2 + 2);
    free(data);
    expect_error(BTF_ERROR_BAD_FILE, "JPEG");
}

/* A file whose EXIF data ask for a rotation by 90 degrees is refused, and not read unrotated. */
TEST(test_jpeg_orientation) {
    static const unsigned char exif[] = {0xff, 0xe1, 0, 34, 'E', 'x', 'i', 'f', 0, 0,    'M', 'M',
                                         0,    42,   0, 0,  0,   8,   0,   1,   1, 0x12, 0,   3,
                                         0,    0,    0, 1,  0,   6,   0,   0,   0, 0,    0,   0};
    unsigned char rgb[W * H * 3];
    for (int i = 0; i < W * H * 3; i++) {
        rgb[i] = (unsigned char)(i / 3 / W * 10);
    }
    assert_int_equal(jpeg_image_write(temporary_file, W, H, rgb, 100, no_log), BTF_OK);
    size_t size;
    unsigned char *data = read_whole_file(temporary_file, &size);
    unsigned char *turned = malloc(size + sizeof exif);
    assert_non_null(turned);
    memcpy(turned, data, 2);
    memcpy(turned + 2, exif, sizeof exif);
    memcpy(turned + 2 + sizeof exif, data + 2, size - 2);
    write_whole_file(temporary_file, turned, size + sizeof exif);
    free(turned);
    free(data);
    expect_error(BTF_ERROR_UNSUPPORTED, "EXIF orientation 6");
}

TEST(test_hdr) {
    static const hdr_coding codings[] = {HDR_FLAT, HDR_OLD_RUNS, HDR_NEW_RUNS};
    unsigned char rgbe[W * H * 4];
    for (int i = 0; i < W * H; i++) {
        for (int c = 0; c < 3; c++) {
            rgbe[4 * i + c] = (unsigned char)(128 + (i / 3 * 5 + c * 40) % 128); /* runs of three */
        }
        rgbe[4 * i + 3] = i % 17 < 3 ? 0 : (unsigned char)(120 + i / 3 % 20);
    }
    for (int k = 0; k < 6; k++) {
        write_hdr(temporary_file, W, H, rgbe, codings[k % 3],
                  k < 3 ? "FORMAT=32-bit_rle_rgbe\n" : "# a comment\nEXPOSURE=2\nEXPOSURE=4.0\n", k >= 3);
        enc_image image = decode();
        assert_int_equal(image.depth, 32);
        assert_int_equal(image.channels, 3);
        assert_false(image.xyz);
        for (int i = 0; i < W * H * 3; i++) {
            const int e = rgbe[i / 3 * 4 + 3];
            const double expected = e ? ldexp(rgbe[i / 3 * 4 + i % 3], e - 136) / (k < 3 ? 1 : 8) : 0;
            assert_true(((float *)image.pixels)[i] == (float)expected);
        }
        enc_image_clear(&image);
        expect_prefixes_refused();
    }
    write_hdr(temporary_file, W, H, rgbe, HDR_NEW_RUNS, "FORMAT=32-bit_rle_xyze\n", false);
    enc_image image = decode();
    assert_true(image.xyz);
    enc_image_clear(&image);
    write_hdr(temporary_file, W, H, rgbe, HDR_NEW_RUNS, "FORMAT=unheard of\n", false);
    expect_error(BTF_ERROR_BAD_FILE, "HDR");
    static const char *const exposures[] = {"EXPOSURE=one\n", "EXPOSURE=-1\n", "EXPOSURE=inf\n",
                                            "EXPOSURE=1e300\nEXPOSURE=1e300\n",
                                            "EXPOSURE=1e-300\nEXPOSURE=1e-300\n"};
    for (size_t i = 0; i < sizeof exposures / sizeof exposures[0]; i++) {
        write_hdr(temporary_file, W, H, rgbe, HDR_NEW_RUNS, exposures[i], false);
        expect_error(BTF_ERROR_BAD_FILE, "HDR");
    }
    const char wrapped[] = "#?RADIANCE\n\n-Y 1 +X 4294967297\n0000"; /* 1 modulo 2^32 */
    write_whole_file(temporary_file, wrapped, sizeof wrapped - 1);
    expect_error(BTF_ERROR_UNSUPPORTED, "429496729");
    const char huge[] = "#?RADIANCE\n\n-Y 2000000000 +X 2000000000\n";
    write_whole_file(temporary_file, huge, sizeof huge - 1);
    expect_error(BTF_ERROR_UNSUPPORTED, "2000000000");
}

/* ATRIUM's files: "+X W -Y H" over rows that begin at the bottom. */
TEST(test_hdr_of_atrium) {
    unsigned char rgbe[W * H * 4];
    for (int i = 0; i < W * H * 4; i++) {
        rgbe[i] = (unsigned char)(i % 4 == 3 ? 128 : 128 + i % 97);
    }
    write_hdr(temporary_file, W, H, rgbe, HDR_NEW_RUNS, "", true);
    size_t size;
    unsigned char *data = read_whole_file(temporary_file, &size);
    char usual[64], theirs[64];
    const size_t length = (size_t)snprintf(usual, sizeof usual, "+Y %d +X %d\n", H, W);
    snprintf(theirs, sizeof theirs, "+X %d -Y %d\n", W, H);
    unsigned char *line = memmem(data, size, usual, length);
    assert_non_null(line);
    memcpy(line, theirs, length);
    write_whole_file(temporary_file, data, size);
    free(data);
    enc_image image = decode();
    assert_int_equal(image.width, W);
    assert_int_equal(image.height, H);
    for (int i = 0; i < W * H * 3; i++) {
        assert_true(((float *)image.pixels)[i] == (float)ldexp(rgbe[i / 3 * 4 + i % 3], -8));
    }
    enc_image_clear(&image);
}

TEST(test_exr) {
    float rgb[W * H * 3];
    for (int i = 0; i < W * H * 3; i++) {
        rgb[i] = ldexpf((float)(1 + i % 1000), i % 5 - 12);
    }
    for (int half = 0; half < 2; half++) {
        rgb[4] = half ? 1e6f : -1e30f;
        assert_int_equal(exr_image_write(temporary_file, W, H, rgb, half, no_log), BTF_OK);
        enc_image image = decode();
        assert_int_equal(image.depth, 32);
        assert_int_equal(image.channels, 3);
        assert_false(image.xyz);
        rgb[4] = half ? 65504.0f : rgb[4];
        assert_memory_equal(image.pixels, rgb, sizeof rgb);
        enc_image_clear(&image);
        expect_prefixes_refused();
    }
    assert_int_equal(exr_image_write("/nowhere/at/all.exr", W, H, rgb, false, no_log), BTF_ERROR_IO);
    assert_int_equal(exr_image_write("/dev/full", W, H, rgb, false, no_log), BTF_ERROR_IO);
}

/* Noise, in sizes where some chunk deflates to exactly its own length: 37x23 of half floats once was read back
 * wrong. */
TEST(test_exr_noise) {
    uint32_t random = 1;
    for (int width = 35; width <= 42; width++) {
        for (int height = 16; height <= 32; height++) {
            float rgb[42 * 32 * 3];
            for (int i = 0; i < width * height * 3; i++) {
                random = random * 1664525u + 1013904223u;
                rgb[i] = ldexpf((float)(1024 + (random >> 12) % 1024), (int)(random >> 24) % 24 - 20);
            }
            assert_int_equal(exr_image_write(temporary_file, width, height, rgb, true, no_log), BTF_OK);
            size_t size;
            char message[700];
            exr_image image = {0};
            image_info info = {0};
            void *data = read_whole_file(temporary_file, &size);
            assert_int_equal(
                exr_image_read(data, size, 1 << 20, NULL, &image, &info, message, sizeof message), BTF_OK);
            assert_memory_equal(image.pixels, rgb, sizeof *rgb * (size_t)(width * height * 3));
            free(image.pixels);
            free(data);
        }
    }
}

TEST(test_exr_tiled) {
    float pixels[W * H * 4];
    for (int i = 0; i < W * H * 4; i++) {
        pixels[i] = ldexpf((float)(1 + i % 1000), i % 5 - 12);
    }
    write_exr_tiled(temporary_file, W, H, 4, "ABGR", pixels);
    enc_image image = decode();
    assert_int_equal(image.channels, 3);
    assert_false(image.xyz);
    for (int i = 0; i < W * H; i++) {
        for (int c = 0; c < 3; c++) {
            assert_true(((float *)image.pixels)[3 * i + c] == pixels[4 * i + 3 - c]);
        }
    }
    enc_image_clear(&image);

    write_exr_tiled(temporary_file, W, H, 3, "XYZ", pixels);
    image = decode();
    assert_int_equal(image.channels, 3);
    assert_true(image.xyz);
    assert_memory_equal(image.pixels, pixels, sizeof(float) * W * H * 3);
    enc_image_clear(&image);

    write_exr_tiled(temporary_file, W, H, 1, "Y", pixels);
    image = decode();
    assert_int_equal(image.channels, 1);
    assert_memory_equal(image.pixels, pixels, sizeof(float) * W * H);
    enc_image_clear(&image);

    /* one wanted channel of three, at which OpenEXRCore 3.1.5 writes the others as well; of four, and of
     * five */
    static const char *const sets[] = {"BGY", "BGYZ", "ABGRY"};
    for (int set = 0; set < 3; set++) {
        const int n = (int)strlen(sets[set]);
        float five[W * H * 5];
        for (int i = 0; i < W * H * n; i++) {
            five[i] = pixels[i % (W * H * 4)];
        }
        write_exr_tiled(temporary_file, W, H, n, sets[set], five);
        image = decode();
        assert_int_equal(image.channels, set < 2 ? 1 : 3);
        for (int i = 0; i < W * H; i++) {
            assert_true(((float *)image.pixels)[image.channels * i] == five[n * i + (set < 2 ? 2 : 3)]);
        }
        enc_image_clear(&image);
    }

    write_exr_tiled(temporary_file, W, H, 2, "UV", pixels);
    expect_error(BTF_ERROR_UNSUPPORTED, "U, V");
}

TEST(test_no_image) {
    write_whole_file(temporary_file, "", 0);
    expect_error(BTF_ERROR_BAD_FILE, "empty");
    write_whole_file(temporary_file, "GIF89a", 6);
    expect_error(BTF_ERROR_BAD_FILE, "not a JPEG, PNG");
    write_whole_file(temporary_file, "\xff\xd8junk", 6);
    expect_error(BTF_ERROR_BAD_FILE, "JPEG");
}

/* --layer is refused for a file format without layers. */
TEST(test_layer_of_png) {
    static const char png[] = "\x89PNG\r\n\x1a\n";
    char message[700];
    enc_image image = {0};
    assert_int_equal(enc_image_decode_layer(png, sizeof png, "diffuse", &image, message, sizeof message),
                     BTF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(message, "option layer: 'diffuse'"));
    assert_null(image.pixels);
}

RUN_TESTS(make_temporary_file, remove_temporary_file)
