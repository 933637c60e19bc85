/* Data in image files that change the meaning of pixels, and that the reader has to follow or warn of: colour chunks of
 * PNG, profiles, lenient headers of JPEG, header lines of Radiance HDR.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/jpeg_image.h"
#include "decoder/toolkit/png_image.h"
#include "encoder/input/colour.h"
#include "tests/support/image_files.h"
#include "tests/support/temporary.h"
#include "tests/support/test.h"

#include <png.h>
#include <unistd.h>
#include <zlib.h>

enum { W = 8, H = 6 };
static char message[700];

static btf_result decode_bytes(const unsigned char *data, size_t size, enc_image *out_image) {
    unsigned char *just = malloc(size);
    assert_non_null(just);
    memcpy(just, data, size);
    *out_image = (enc_image){0};
    const btf_result result = enc_image_decode(just, size, out_image, message, sizeof message);
    free(just);
    return result;
}

static void put32(unsigned char *p, uint32_t value) {
    for (int i = 0; i < 4; i++) {
        p[i] = (unsigned char)(value >> (24 - 8 * i));
    }
}

static uint32_t get32(const unsigned char *p) {
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

typedef struct bytes {
    unsigned char data[8192];
    size_t size;
} bytes;

/* A PNG of `depth` bits without a word about its colours. */
static bytes plain_png(int depth, int colour_type) {
    static unsigned char pixels[W * H * 8];
    bytes b;
    for (size_t i = 0; i < sizeof pixels; i++) {
        pixels[i] = (unsigned char)(i * 5);
    }
    if (colour_type == PNG_COLOR_TYPE_RGB_ALPHA) {
        for (size_t i = 3; i < sizeof pixels; i += 4) {
            pixels[i] = 255;
        }
    }
    write_png(temporary_file, W, H, colour_type, depth, false, pixels, NULL);
    size_t size;
    void *data = read_whole_file(temporary_file, &size);
    assert_true(size < sizeof b.data);
    memcpy(b.data, data, size);
    free(data);
    b.size = size;
    return b;
}

/* Puts a chunk behind IHDR, or behind the pixels. */
static void add_chunk(bytes *b, const char *type, const void *data, size_t size, bool behind) {
    size_t at = 8;
    while (memcmp(b->data + at + 4, behind ? "IEND" : "IHDR", 4) != 0) {
        at += 12 + get32(b->data + at);
    }
    at += behind ? 0 : 12 + get32(b->data + at);
    assert_true(b->size + size + 12 <= sizeof b->data);
    memmove(b->data + at + size + 12, b->data + at, b->size - at);
    put32(b->data + at, (uint32_t)size);
    memcpy(b->data + at + 4, type, 4);
    if (size) {
        memcpy(b->data + at + 8, data, size);
    }
    put32(b->data + at + 8 + size, (uint32_t)crc32(0, b->data + at + 4, (uInt)(size + 4)));
    b->size += size + 12;
}

/* The linear value that the first sample decodes to, as the encoder makes it. */
static double first_value(const enc_image *image, double *out_code) {
    double gamma;
    const enc_transfer transfer = enc_transfer_of(image, &gamma);
    enc_decoder *decoder = enc_decoder_create(transfer, gamma);
    static float out[W * H * 3];
    assert_non_null(decoder);
    enc_decode_pixels(decoder, image, (enc_rectangle){0, 0, W, H}, out);
    enc_decoder_destroy(&decoder);
    *out_code = image->depth == 16 ? ((unsigned short *)image->pixels)[4] / 65535.0
                                   : ((unsigned char *)image->pixels)[4] / 255.0;
    return (double)out[4];
}

static enc_image decode_good(const bytes *b) {
    enc_image image;
    if (decode_bytes(b->data, b->size, &image) != BTF_OK) {
        fail_msg("%s", message);
    }
    return image;
}

/* Checks that decoding gives a note of this kind that holds the words, or none where they are NULL. */
static void expect_note(const bytes *b, image_note_kind kind, const char *words) {
    enc_image image = decode_good(b);
    const char *note = image.info.notes.texts[kind];
    const bool as_said = words ? strstr(note, words) != NULL : note[0] == '\0';
    if (!as_said) {
        print_error("\"%s\", not \"%s\"\n", note, words ? words : "");
    }
    assert_true(as_said);
    enc_image_clear(&image);
}

static void expect_refused(const bytes *b, btf_result expected, const char *words) {
    enc_image image;
    assert_int_equal(decode_bytes(b->data, b->size, &image), expected);
    if (!strstr(message, words)) {
        print_error("\"%s\" does not say \"%s\"\n", message, words);
    }
    assert_non_null(strstr(message, words));
}

static void expect_curve(bytes b, double (*curve)(double)) {
    double code;
    enc_image image = decode_good(&b);
    const double value = first_value(&image, &code);
    enc_image_clear(&image);
    if (!(fabs(value - curve(code)) <= 1e-5)) {
        fail_msg("%g decodes to %g, not %g", code, value, curve(code));
    }
}

static double linear(double v) {
    return v;
}

static double power22(double v) {
    return pow(v, 1 / 0.45455);
}

static double bt709(double v) {
    return v < 0.081 ? v / 4.5 : pow((v + 0.099) / 1.099, 1 / 0.45);
}

/* Of gAMA, sRGB and cICP the later overrides the earlier in this order; without any, sRGB is assumed. */
TEST(test_png_transfer) {
    for (int depth = 8; depth <= 16; depth += 8) {
        unsigned char gamma[4];
        bytes b = plain_png(depth, PNG_COLOR_TYPE_RGB);
        expect_curve(b, enc_srgb_decode);
        put32(gamma, 100000);
        add_chunk(&b, "gAMA", gamma, 4, false);
        expect_curve(b, linear);
        add_chunk(&b, "sRGB", "", 1, false);
        expect_curve(b, enc_srgb_decode);
        add_chunk(&b, "cICP", "\1\10\0\1", 4, false);
        expect_curve(b, linear);
        b = plain_png(depth, PNG_COLOR_TYPE_RGB);
        put32(gamma, 45455);
        add_chunk(&b, "gAMA", gamma, 4, false);
        expect_curve(b, power22);
        b = plain_png(depth, PNG_COLOR_TYPE_RGB);
        add_chunk(&b, "cICP", "\1\15\0\1", 4, false);
        expect_curve(b, enc_srgb_decode);
        b = plain_png(depth, PNG_COLOR_TYPE_RGB);
        add_chunk(&b, "cICP", "\1\1\0\1", 4, false);
        expect_curve(b, bt709);
        b = plain_png(depth, PNG_COLOR_TYPE_RGB);
        put32(gamma, 0);
        add_chunk(&b, "gAMA", gamma, 4, false);
        expect_curve(b, enc_srgb_decode);
        enc_image image = decode_good(&b);
        assert_non_null(strstr(image.info.notes.texts[IMAGE_NOTE_SPACE], "gAMA 0 is not usable"));
        assert_true(image.info.transfer_name[0] == '\0'); /* nothing is followed */
        enc_image_clear(&image);
    }
    bytes b = plain_png(16, PNG_COLOR_TYPE_RGB);
    add_chunk(&b, "cICP", "\11\20\0\0", 4, false);
    enc_image image = decode_good(&b);
    assert_int_equal(image.info.transfer, IMAGE_TRANSFER_OTHER);
    assert_string_equal(image.info.transfer_name, "PNG: cICP transfer 16, PQ,");
    assert_non_null(strstr(image.info.notes.texts[IMAGE_NOTE_RANGE], "range 0"));
    assert_true(image.info.converts); /* BT.2020 */
    enc_image_clear(&image);
}

/* cHRM: with primaries of Rec. 709 nothing changes, others are converted, and beside sRGB the chunk is ignored. */
TEST(test_png_primaries) {
    static const uint32_t same[8] = {31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000};
    static const uint32_t wide[8] = {31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000};
    for (int k = 0; k < 3; k++) {
        unsigned char values[32];
        for (int i = 0; i < 8; i++) {
            put32(values + 4 * i, k ? wide[i] : same[i]);
        }
        unsigned char gamma[4];
        put32(gamma, 45455);
        bytes stands = plain_png(8, PNG_COLOR_TYPE_RGB); /* for sRGB, with the primaries of sRGB */
        add_chunk(&stands, "gAMA", gamma, 4, false);
        add_chunk(&stands, "cHRM", values, 32, false);
        expect_curve(stands, k ? power22 : enc_srgb_decode);
        bytes b = plain_png(8, PNG_COLOR_TYPE_RGB);
        if (k == 2) {
            add_chunk(&b, "sRGB", "", 1, false);
        }
        add_chunk(&b, "cHRM", values, 32, false);
        enc_image image = decode_good(&b);
        assert_int_equal(image.info.converts, k == 1);
        if (k == 1) {
            assert_non_null(strstr(image.info.primaries_name, "PNG cHRM red (0.68,0.32)"));
        }
        enc_image_clear(&image);
    }
}

/* A profile of version 2 with a description alone. */
static size_t make_profile(unsigned char *out, const char *name, bool version4) {
    const size_t length = strlen(name) + 1;
    memset(out, 0, 400);
    memcpy(out + 4, "none", 4);
    out[8] = version4 ? 4 : 2;
    memcpy(out + 12, "mntrRGB XYZ ", 12);
    memcpy(out + 36, "acsp", 4);
    put32(out + 68, 0xF6D6);
    put32(out + 72, 0x10000);
    put32(out + 76, 0xD32D);
    put32(out + 128, 1);
    memcpy(out + 132, "desc", 4);
    put32(out + 136, 144);
    size_t size;
    if (version4) {
        memcpy(out + 144, "mluc", 4);
        put32(out + 152, 1);
        put32(out + 156, 12);
        memcpy(out + 160, "enUS", 4);
        put32(out + 164, (uint32_t)(2 * (length - 1)));
        put32(out + 168, 28);
        for (size_t i = 0; i + 1 < length; i++) {
            out[144 + 28 + 2 * i + 1] = (unsigned char)name[i];
        }
        size = 28 + 2 * (length - 1);
    } else {
        memcpy(out + 144, "desc", 4);
        put32(out + 152, (uint32_t)length);
        memcpy(out + 156, name, length);
        size = 12 + length + 78;
    }
    size = (size + 3) / 4 * 4;
    put32(out + 140, (uint32_t)size);
    put32(out, (uint32_t)(144 + size));
    return 144 + size;
}

static const struct {
    const char *name;
    bool srgb;
} profiles[] = {{"sRGB IEC61966-2.1", true},
                {"Adobe RGB (1998)", false},
                {"GIMP built-in Linear sRGB", false},
                {"sRGB built-in", true},
                {"Default RGB IEC61966-2.1", true},
                {"IEC 61966-2-2 scRGB", false},
                {"opRGB IEC 61966-2-5", false},
                {"Some esRGB", false},
                {"e-sRGB", false},
                {"Display P3", false}};

static void expect_profile(const bytes *b, size_t k) {
    expect_note(b, IMAGE_NOTE_PROFILE, profiles[k].srgb ? NULL : profiles[k].name);
}

/* A profile is named by its description and not by its chunk; one that cannot be inflated by the name in the chunk. */
TEST(test_png_profile) {
    for (size_t k = 0; k < 2 * sizeof profiles / sizeof *profiles; k++) {
        unsigned char profile[400], chunk[600] = "icc\0";
        const size_t size = make_profile(profile, profiles[k / 2].name, k % 2);
        uLongf packed = sizeof chunk - 5;
        assert_int_equal(compress(chunk + 5, &packed, profile, size), Z_OK);
        bytes b = plain_png(16, PNG_COLOR_TYPE_RGB);
        add_chunk(&b, "iCCP", chunk, 5 + packed, false);
        expect_profile(&b, k / 2);
        b = plain_png(16, PNG_COLOR_TYPE_RGB);
        add_chunk(&b, "iCCP", "my screen\0\0oops", 15, false);
        expect_note(&b, IMAGE_NOTE_PROFILE, "\"my screen\"");
    }
}

/* Puts a tag at the end of a profile. */
static size_t add_tag(unsigned char *profile, size_t size, const char *name, const void *data,
                      size_t length) {
    const uint32_t count = get32(profile + 128);
    const size_t table = 132 + 12 * (size_t)count;
    memmove(profile + table + 12, profile + table, size - table);
    size += 12;
    for (uint32_t i = 0; i < count; i++) {
        put32(profile + 136 + 12 * i, get32(profile + 136 + 12 * i) + 12);
    }
    put32(profile + 128, count + 1);
    memcpy(profile + table, name, 4);
    put32(profile + table + 4, (uint32_t)size);
    put32(profile + table + 8, (uint32_t)length);
    memcpy(profile + size, data, length);
    return size + length;
}

/* Makes a profile that is called sRGB, with these curves and this red; returns whether the reader accepts it as
 * sRGB. */
static bool is_taken_as_srgb(const unsigned char *curve, size_t curve_size, const unsigned char *red) {
    static unsigned char profile[4000];
    image_info info = {0};
    size_t size = make_profile(profile, "sRGB built-in", true);
    size = add_tag(profile, size, "rTRC", curve, curve_size);
    if (red) {
        size = add_tag(profile, size, "rXYZ", red, 20);
    }
    unsigned char *just = malloc(size);
    assert_non_null(just);
    memcpy(just, profile, size);
    image_info_profile(&info, "PNG", just, size, NULL);
    free(just);
    const bool told =
        strstr(info.notes.texts[IMAGE_NOTE_PROFILE], "\"sRGB built-in\", whose curves") != NULL;
    assert_int_equal(told, info.transfer != IMAGE_TRANSFER_SRGB);
    return !told;
}

/* A profile that is called sRGB but has other curves or primaries gives a note. */
TEST(test_profile_contents) {
    static const unsigned char linear_curve[12] = "curv", gamma22[14] = "curv\0\0\0\0\0\0\0\1\2\63";
    static unsigned char table[12 + 2 * 1024] = "curv";
    put32(table + 8, 1024);
    for (int i = 0; i < 1024; i++) {
        const int value = (int)lround(65535 * enc_srgb_decode(i / 1023.0));
        table[12 + 2 * i] = (unsigned char)(value >> 8);
        table[13 + 2 * i] = (unsigned char)value;
    }
    unsigned char parametric[32] = "para\0\0\0\0\0\3", red[20] = "XYZ ", wide[20] = "XYZ ";
    static const double p[5] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    static const double srgb_red[3] = {0.43607, 0.22249, 0.01392}, p3_red[3] = {0.51512, 0.2412, 0.0};
    for (int i = 0; i < 5; i++) {
        put32(parametric + 12 + 4 * i, (uint32_t)lround(p[i] * 65536));
    }
    for (int i = 0; i < 3; i++) {
        put32(red + 8 + 4 * i, (uint32_t)lround(srgb_red[i] * 65536));
        put32(wide + 8 + 4 * i, (uint32_t)lround(p3_red[i] * 65536));
    }
    assert_true(is_taken_as_srgb(parametric, sizeof parametric, red));
    assert_true(is_taken_as_srgb(table, sizeof table, red));
    assert_true(is_taken_as_srgb(table, sizeof table, NULL));
    assert_false(is_taken_as_srgb(parametric, sizeof parametric, wide));
    assert_false(is_taken_as_srgb(linear_curve, sizeof linear_curve, red));
    assert_false(is_taken_as_srgb(gamma22, sizeof gamma22, red));
    for (size_t size = 0; size < 16; size++) { /* damaged: its name alone is left */
        assert_true(is_taken_as_srgb(parametric, size, red));
    }
    parametric[9] = 9;
    assert_true(is_taken_as_srgb(parametric, sizeof parametric, red));
}

/* An EXIF orientation behind the pixels counts; a colour space in it as well. */
TEST(test_png_exif_behind) {
    static const unsigned char turned[] = {'M', 'M', 0, 42, 0, 0, 0, 8, 0, 1, 1, 0x12, 0,
                                           3,   0,   0, 0,  1, 0, 6, 0, 0, 0, 0, 0,    0};
    for (int behind = 0; behind < 2; behind++) {
        bytes b = plain_png(8, PNG_COLOR_TYPE_RGB);
        add_chunk(&b, "eXIf", turned, sizeof turned, behind);
        expect_refused(&b, BTF_ERROR_UNSUPPORTED, "EXIF orientation 6");
    }
}

static const unsigned char turned_long[] = {'I', 'I', 42, 0, 8, 0, 0, 0, 1, 0, 0x12, 1, 4,
                                            0,   1,   0,  0, 0, 6, 0, 0, 0, 0, 0,    0, 0};

/* Other places where programs keep an orientation in a PNG: texts of ImageMagick and ExifTool, the prefix of JPEG's
 * EXIF block, the type LONG. That of XMP is not followed, but gives a note. */
TEST(test_png_exif_elsewhere) {
    static const char xmp[] = "XML:com.adobe.xmp\0\0\0\0\0<rdf:Description tiff:Orientation=\"8\"/>";
    unsigned char block[6 + sizeof turned_long] = "Exif\0\0", text[300], packed[400];
    memcpy(block + 6, turned_long, sizeof turned_long);
    for (int kind = 0; kind < 4; kind++) {
        bytes b = plain_png(8, PNG_COLOR_TYPE_RGB);
        const char *key = kind == 1 ? "Raw profile type exif" : "Raw profile type APP1";
        size_t size = strlen(key) + 1;
        memcpy(text, key, size);
        size += (size_t)snprintf((char *)text + size, sizeof text - size, "\nexif\n%8zu\n", sizeof block);
        for (size_t i = 0; i < sizeof block; i++) {
            size += (size_t)snprintf((char *)text + size, sizeof text - size, "%02x%s", block[i],
                                     i % 36 == 35 ? "\n" : "");
        }
        const size_t key_size = strlen(key) + 1;
        uLongf length = sizeof packed - key_size - 1;
        memcpy(packed, key, key_size);
        packed[key_size] = 0;
        assert_int_equal(compress(packed + key_size + 1, &length, text + key_size, size - key_size), Z_OK);
        if (kind == 0) {
            add_chunk(&b, "eXIf", block, sizeof block, false);
        } else if (kind == 1) {
            add_chunk(&b, "tEXt", text, size, true);
        } else if (kind == 2) {
            add_chunk(&b, "zTXt", packed, key_size + 1 + length, false);
        } else {
            add_chunk(&b, "eXIf", turned_long, sizeof turned_long, true);
        }
        expect_refused(&b, BTF_ERROR_UNSUPPORTED, "EXIF orientation 6");
    }
    bytes b = plain_png(8, PNG_COLOR_TYPE_RGB);
    add_chunk(&b, "iTXt", xmp, sizeof xmp - 1, false);
    expect_note(&b, IMAGE_NOTE_TURNED, "XMP orientation 8");
}

/* A profile among the texts counts where no chunk says anything. */
TEST(test_png_profile_in_text) {
    unsigned char profile[400], text[1200] = "Raw profile type icc";
    const size_t profile_size = make_profile(profile, "Adobe RGB (1998)", false);
    size_t size = strlen((char *)text) + 1;
    size += (size_t)snprintf((char *)text + size, sizeof text - size, "\nicc\n%8zu\n", profile_size);
    for (size_t i = 0; i < profile_size; i++) {
        size += (size_t)snprintf((char *)text + size, sizeof text - size, "%02X", profile[i]);
    }
    for (int k = 0; k < 2; k++) {
        bytes b = plain_png(8, PNG_COLOR_TYPE_RGB);
        add_chunk(&b, "tEXt", text, size, false);
        if (k) {
            add_chunk(&b, "sRGB", "", 1, false);
        }
        expect_note(&b, IMAGE_NOTE_PROFILE, k ? NULL : "Adobe RGB");
    }
}

TEST(test_png_alpha) {
    bytes b = plain_png(8, PNG_COLOR_TYPE_RGB_ALPHA);
    enc_image image = decode_good(&b);
    assert_int_equal(image.channels, 3);
    assert_int_equal(((unsigned char *)image.pixels)[3],
                     20); /* the second pixel's red, of four bytes each */
    assert_true(image.info.notes.texts[IMAGE_NOTE_ALPHA][0] == '\0');
    enc_image_clear(&image);
    b = plain_png(8, PNG_COLOR_TYPE_GRAY_ALPHA);
    image = decode_good(&b);
    assert_int_equal(image.channels, 1);
    assert_non_null(strstr(image.info.notes.texts[IMAGE_NOTE_ALPHA], "transparency is not used"));
    enc_image_clear(&image);
}

static bytes plain_jpeg(void) {
    unsigned char rgb[W * H * 3];
    bytes b;
    for (int i = 0; i < W * H * 3; i++) {
        rgb[i] = (unsigned char)(i * 2);
    }
    assert_int_equal(jpeg_image_write(temporary_file, W, H, rgb, 90, (btf_log){0}), BTF_OK);
    void *data = read_whole_file(temporary_file, &b.size);
    assert_true(b.size < sizeof b.data);
    memcpy(b.data, data, b.size);
    free(data);
    return b;
}

static void add_marker(bytes *b, int marker, const void *data, size_t size) {
    memmove(b->data + 6 + size, b->data + 2, b->size - 2);
    b->data[2] = 0xFF;
    b->data[3] = (unsigned char)marker;
    b->data[4] = (unsigned char)((size + 2) >> 8);
    b->data[5] = (unsigned char)(size + 2);
    memcpy(b->data + 6, data, size);
    b->size += 4 + size;
}

TEST(test_jpeg_profile) {
    for (size_t k = 0; k < 2 * sizeof profiles / sizeof *profiles; k++) {
        unsigned char marker[14 + 400] = "ICC_PROFILE\0\1\1";
        const size_t size = make_profile(marker + 14, profiles[k / 2].name, k % 2);
        bytes b = plain_jpeg();
        add_marker(&b, 0xE2, marker, 14 + size);
        expect_profile(&b, k / 2);
    }
    for (int space = 0; space < 2; space++) { /* EXIF: uncalibrated, or sRGB */
        unsigned char exif[] = "Exif\0\0MM\0*\0\0\0\10\0\1\x87\x69\0\4\0\0\0\1\0\0\0\x1a\0\0\0\0"
                               "\0\1\xa0\1\0\3\0\0\0\1\xff\xff\0\0\0\0\0";
        if (space) {
            memcpy(exif + 6 + 26 + 10, "\0\1", 2);
        }
        bytes b = plain_jpeg();
        add_marker(&b, 0xE1, exif, sizeof exif - 1);
        enc_image image = decode_good(&b);
        assert_int_equal(image.info.notes.texts[IMAGE_NOTE_SPACE][0] != '\0', !space);
        enc_image_clear(&image);
    }
}

/* An orientation of the type LONG counts; that of XMP gives a note only. */
TEST(test_jpeg_orientation) {
    static const char xmp[] = "http://ns.adobe.com/xap/1.0/\0<tiff:Orientation>3</tiff:Orientation>";
    unsigned char exif[6 + sizeof turned_long] = "Exif\0\0";
    memcpy(exif + 6, turned_long, sizeof turned_long);
    bytes b = plain_jpeg();
    add_marker(&b, 0xE1, xmp, sizeof xmp - 1);
    expect_note(&b, IMAGE_NOTE_TURNED, "XMP orientation 3");
    add_marker(&b, 0xE1, exif, sizeof exif);
    expect_refused(&b, BTF_ERROR_UNSUPPORTED, "EXIF orientation 6");
}

/* A sequential file whose scan header has the spectral range of a progressive one is read whole, with a note. A broken
 * code is still refused. */
TEST(test_jpeg_lenient) {
    bytes b = plain_jpeg(), strict = b;
    size_t at = 2;
    while (b.data[at + 1] != 0xDA) {
        at += 2 + ((size_t)b.data[at + 2] << 8 | b.data[at + 3]);
    }
    unsigned char *range = b.data + at + 5 + 2 * b.data[at + 4];
    assert_int_equal(range[0], 0);
    assert_int_equal(range[1], 63);
    enc_image want = decode_good(&strict);
    assert_true(want.info.notes.texts[IMAGE_NOTE_HEADER][0] == '\0');
    static const unsigned char kinds[3][3] = {{0, 0, 0}, {1, 5, 0}, {0, 63, 0x10}};
    for (int k = 0; k < 3; k++) {
        memcpy(range, kinds[k], 3);
        enc_image image = decode_good(&b);
        assert_memory_equal(image.pixels, want.pixels, W * H * 3);
        assert_non_null(strstr(image.info.notes.texts[IMAGE_NOTE_HEADER], "SOS"));
        enc_image_clear(&image);
    }
    enc_image_clear(&want);
    b.size -= 2 + (b.size - (size_t)(range + 3 - b.data)) / 2; /* cut off within the scan */
    enc_image image;
    assert_int_equal(decode_bytes(b.data, b.size, &image), BTF_ERROR_BAD_FILE);
}

/* A flat file of W x H pixels that count, with these header lines and resolution. */
static bytes hdr_of(const char *lines, const char *resolution) {
    bytes b;
    b.size = (size_t)snprintf((char *)b.data, sizeof b.data, "#?RADIANCE\n%s\n%s\n", lines, resolution);
    for (int i = 0; i < W * H; i++) {
        const unsigned char rgbe[4] = {(unsigned char)(128 + i), 160, 200, 128};
        memcpy(b.data + b.size, rgbe, 4);
        b.size += 4;
    }
    return b;
}

/* The eight orders: which of the stored pixels lies where. */
TEST(test_hdr_orders) {
    static const char *const orders[8] = {"-Y 6 +X 8", "-Y 6 -X 8", "+Y 6 +X 8", "+Y 6 -X 8",
                                          "+X 8 -Y 6", "+X 8 +Y 6", "-X 8 -Y 6", "-X 8 +Y 6"};
    for (int k = 0; k < 8; k++) {
        const bytes b = hdr_of("FORMAT=32-bit_rle_rgbe\n", orders[k]);
        enc_image image = decode_good(&b);
        assert_int_equal(image.width, W);
        assert_int_equal(image.height, H);
        const bool columns = orders[k][1] == 'X';
        const char *x_sign = strchr(orders[k], 'X') - 1, *y_sign = strchr(orders[k], 'Y') - 1;
        for (int i = 0; i < W * H; i++) {
            const int along_x = columns ? i / H : i % W, along_y = columns ? i % H : i / W;
            const int x = *x_sign == '+' ? along_x : W - 1 - along_x,
                      y = *y_sign == '-' ? along_y : H - 1 - along_y;
            assert_true(((float *)image.pixels)[3 * (y * W + x)] == (float)(128 + i) / 256);
        }
        enc_image_clear(&image);
    }
    static const char *const bad[] = {"-Y 6 +Y 8", "-Z 6 +X 8", "Y 6 X 8", "-Y six +X 8", ""};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        const bytes b = hdr_of("", bad[k]);
        expect_refused(&b, BTF_ERROR_UNSUPPORTED, "line 3");
    }
    const bytes b = hdr_of("", "+X 6 -Y 6"); /* a square one is taken for ATRIUM's, with a note */
    enc_image image = decode_good(&b);
    assert_true(((float *)image.pixels)[0] == (float)(128 + 30) / 256);
    assert_non_null(strstr(image.info.notes.texts[IMAGE_NOTE_HEADER], "\"+X 6 -Y 6\""));
    enc_image_clear(&image);
}

/* Header lines of real writers. The values divide by `scale`. */
TEST(test_hdr_headers) {
    char longest[600];
    memset(longest, 'x', sizeof longest);
    memcpy(longest, "VIEW= -vtl", 10);
    snprintf(longest + 400, 100, "\nEXPOSURE=2\n");
    const struct {
        const char *lines;
        double scale[3];
        image_note_kind kind; /* IMAGE_NOTE_KINDS: none */
        const char *note;
    } good[] = {
        {"EXPOSURE=0\n", {1, 1, 1}, IMAGE_NOTE_EXPOSURE, "EXPOSURE=0"},
        {"EXPOSURE= 2 \t\nEXPOSURE=3\r\n", {6, 6, 6}, IMAGE_NOTE_EXPOSURE, "in all 6, 6, 6"},
        {"EXPOSURE \t = 2\n", {2, 2, 2}, IMAGE_NOTE_EXPOSURE, "in all 2, 2, 2"},
        {"EXPOSURES=2\nEXPOSURE\n", {1, 1, 1}, IMAGE_NOTE_KINDS, ""},
        {"FORMAT=32-bit_rle_rgbe  \n", {1, 1, 1}, IMAGE_NOTE_KINDS, ""},
        {"FORMAT= 32-bit_rle_rgbe\n", {1, 1, 1}, IMAGE_NOTE_KINDS, ""},
        {longest, {2, 2, 2}, IMAGE_NOTE_EXPOSURE, "in all 2, 2, 2"},
        {"COLORCORR=2 4 0.5\nEXPOSURE=2\n", {4, 8, 1}, IMAGE_NOTE_EXPOSURE, "in all 4, 8, 1"},
        {"GAMMA=1\nGAMMA=1.0\n", {1, 1, 1}, IMAGE_NOTE_KINDS, ""},
        {"GAMMA=2.2\n", {1, 1, 1}, IMAGE_NOTE_GAMMA, "GAMMA=2.2 is not applied"},
        {"PIXASPECT=1.5\n", {1, 1, 1}, IMAGE_NOTE_ASPECT, "PIXASPECT=1.5"},
        {"\tEXPOSURE=9\nSOFTWARE=none\n# EXPOSURE=7\n", {1, 1, 1}, IMAGE_NOTE_KINDS, ""},
        {"PRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329\n", {1, 1, 1}, IMAGE_NOTE_KINDS, ""},
    };
    for (size_t k = 0; k < sizeof good / sizeof *good; k++) {
        const bytes b = hdr_of(good[k].lines, "-Y 6 +X 8");
        enc_image image = decode_good(&b);
        const float *p = image.pixels;
        assert_true(fabs(p[0] * good[k].scale[0] - 0.5) < 1e-6 &&
                    fabs(p[1] * good[k].scale[1] - 0.625) < 1e-6 &&
                    fabs(p[2] * good[k].scale[2] - 200 / 256.0) < 1e-6);
        assert_false(image.info.converts);
        for (int n = 0; n < IMAGE_NOTE_KINDS; n++) {
            assert_true(n == (int)good[k].kind ? strstr(image.info.notes.texts[n], good[k].note) != NULL
                                               : image.info.notes.texts[n][0] == '\0');
        }
        enc_image_clear(&image);
    }
    const bytes wide = hdr_of("PRIMARIES=.68 .32 .265 .69 .15 .06 .3127 .329\n", "-Y 6 +X 8");
    enc_image image = decode_good(&wide);
    assert_true(image.info.converts && strstr(image.info.primaries_name, "HDR PRIMARIES red (0.68,0.32)"));
    enc_image_clear(&image);
    static const char *const bad[] = {
        "EXPOSURE=-1\n",       "EXPOSURE=two\n",  "EXPOSURE=1 2\n",    "EXPOSURE=inf\n",
        "FORMAT=32-bit_rle\n", "COLORCORR=1 2\n", "PRIMARIES=1 2 3\n", "GAMMA=x\n"};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        char lines[100], expected[100];
        snprintf(lines, sizeof lines, "SOFTWARE=none\n%s", bad[k]);
        const bytes b = hdr_of(lines, "-Y 6 +X 8");
        snprintf(expected, sizeof expected, "line 3, \"%.*s\"", (int)strlen(bad[k]) - 1, bad[k]);
        expect_refused(&b, BTF_ERROR_BAD_FILE, expected);
    }
}

RUN_TESTS(make_temporary_file, remove_temporary_file)
