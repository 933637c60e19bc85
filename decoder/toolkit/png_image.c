/* PNG images through libpng: writing RGB, and reading every kind.
 *
 * SPDX-License-Identifier: MIT
 */
#include "png_image.h"

#include "exif.h"
#include "output.h"
#include "png_text.h"

#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { MESSAGE_SIZE = 128 };

static bool little_endian(void) {
    const unsigned short one = 1;
    return *(const unsigned char *)&one == 1;
}

/* libpng's first complaint is kept, never printed; the caller names the file. */
static void on_error(png_structp png, png_const_charp text) {
    char *kept = png_get_error_ptr(png);
    if (!kept[0]) {
        snprintf(kept, MESSAGE_SIZE, "%s", text);
    }
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp text) {
    (void)png;
    (void)text;
}

/* Writes the picture. libpng jumps back here on an error: objects that must outlive the jump belong to the caller. */
static btf_result encode(png_structp png, png_infop info, FILE *stream, int width, int height, int depth,
                         const unsigned char *pixels) {
    if (setjmp(png_jmpbuf(png))) {
        return BTF_ERROR_IO;
    }
    png_init_io(png, stream);
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, depth, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    if (depth == 16 && little_endian()) {
        png_set_swap(png); /* the file's order is big endian */
    }
    const size_t row_bytes = (size_t)width * 3 * (size_t)depth / 8;
    for (int row = 0; row < height; row++) {
        png_write_row(png, pixels + (size_t)row * row_bytes);
    }
    png_write_end(png, info);
    return BTF_OK;
}

static btf_result write_image(const char *path, int width, int height, int depth, const void *pixels,
                              btf_log log) {
    output *file;
    btf_result result = output_open(path, log, &file);
    if (result != BTF_OK) {
        return result;
    }
    result = BTF_ERROR_MEMORY;
    char text[MESSAGE_SIZE] = "";
    png_infop info = NULL;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, text, on_error, on_warning);
    if (png && (info = png_create_info_struct(png))) {
        result = encode(png, info, output_stream(file), width, height, depth, pixels);
    }
    png_destroy_write_struct(&png, &info);
    if (result == BTF_ERROR_MEMORY) {
        output_abort(&file);
        return result;
    }
    /* A failed write shows in the stream, and output_commit names the file and the reason. Any other error is one of
     * libpng. */
    if (result != BTF_OK && !ferror(output_stream(file))) {
        if (log.callback) {
            char message[512];
            snprintf(message, sizeof message, "%.300s: PNG: %s", path, text);
            log.callback(log.user, BTF_LOG_ERROR, message);
        }
        output_abort(&file);
        return result;
    }
    return output_commit(&file);
}

btf_result png_image_write8(const char *path, int width, int height, const unsigned char *rgb,
                            btf_log log) {
    return write_image(path, width, height, 8, rgb, log);
}

btf_result png_image_write16(const char *path, int width, int height, const unsigned short *rgb,
                             btf_log log) {
    return write_image(path, width, height, 16, rgb, log);
}

/* A decoder in the making: what must survive libpng's longjmp lives here, not in locals. */
typedef struct reading {
    const unsigned char *data;
    size_t left;
    int width, height, channels, depth;
    unsigned char *pixels;
    png_bytep *rows;
    image_info *info;
    char text[MESSAGE_SIZE];
} reading;

static void on_read(png_structp png, png_bytep out, size_t size) {
    reading *r = png_get_io_ptr(png);
    if (size > r->left) {
        png_error(png, "the file ends too early");
    }
    memcpy(out, r->data, size);
    r->data += size;
    r->left -= size;
}

static uint32_t number_at(const unsigned char *p) {
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

/* The first chunk of a type, wherever it stands, even behind the pixels; NULL: none. libpng checks the chunks'
 * checksums. */
static const unsigned char *find_chunk(const unsigned char *data, size_t size, const char *type,
                                       size_t *out_length) {
    for (size_t at = 8; at < size && size - at >= 12;) {
        const size_t length = number_at(data + at);
        if (length > size - at - 12) {
            return NULL;
        }
        if (memcmp(data + at + 4, type, 4) == 0) {
            *out_length = length;
            return data + at + 8;
        }
        at += 12 + length;
    }
    return NULL;
}

/* Reads the code points (ITU-T H.273) of chunk cICP: primaries, then transfer function. */
static void heed_code_points(const unsigned char *code, image_info *info) {
    static const struct {
        int code;
        primaries p;
    } spaces[] = {{1, {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}}},
                  {5, {{0.64, 0.33}, {0.29, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}}},
                  {6, {{0.630, 0.340}, {0.310, 0.595}, {0.155, 0.070}, {0.3127, 0.3290}}},
                  {7, {{0.630, 0.340}, {0.310, 0.595}, {0.155, 0.070}, {0.3127, 0.3290}}},
                  {9, {{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, {0.3127, 0.3290}}},
                  {11, {{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, {0.314, 0.351}}},
                  {12, {{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, {0.3127, 0.3290}}}};
    const char *other = code[1] == 16 ? ", PQ," : code[1] == 18 ? ", HLG," : "";
    bool known = false;
    for (size_t i = 0; i < sizeof spaces / sizeof *spaces && !known; i++) {
        if ((known = spaces[i].code == code[0])) {
            image_info_primaries(info, "PNG cICP primaries", &spaces[i].p);
        }
    }
    if (!known) {
        image_note(info, IMAGE_NOTE_SPACE, "PNG: cICP primaries %d are not known: taken as Rec. 709",
                   code[0]);
    }
    if (code[2] != 0 || code[3] != 1) {
        image_note(info, IMAGE_NOTE_RANGE,
                   "PNG: cICP matrix %d, range %d are not applied: taken as full-range RGB", code[2],
                   code[3]);
    }
    snprintf(info->transfer_name, sizeof info->transfer_name, "PNG: cICP transfer %d%s", code[1], other);
    switch (code[1]) {
    case 13:
        info->transfer = IMAGE_TRANSFER_SRGB;
        break;
    case 8:
        info->transfer = IMAGE_TRANSFER_LINEAR;
        break;
    case 4:
    case 5:
        info->transfer = IMAGE_TRANSFER_GAMMA;
        info->gamma = code[1] == 4 ? 2.2 : 2.8;
        break;
    case 1:
    case 6:
    case 14:
    case 15:
        info->transfer = IMAGE_TRANSFER_BT709;
        break;
    default:
        info->transfer = IMAGE_TRANSFER_OTHER;
    }
}

/* gAMA 1 / 2.2 with Rec. 709's cHRM is what the PNG specification has writers of sRGB write beside the chunk
 * sRGB, and what ImageMagick writes without it: sRGB is meant. */
static void heed_gamma(const unsigned char *gamma, const unsigned char *chromaticities, image_info *info) {
    bool stands_for_srgb = false;
    double c[8];
    for (int i = 0; i < 8 && chromaticities; i++) {
        c[i] = number_at(chromaticities + 4 * i) / 1e5;
    }
    if (chromaticities) {
        const primaries p = {{c[2], c[3]}, {c[4], c[5]}, {c[6], c[7]}, {c[0], c[1]}};
        image_info_primaries(info, "PNG cHRM", &p);
        stands_for_srgb = primaries_are_rec709(&p) && gamma && fabs(number_at(gamma) - 45455.0) < 10.0;
    }
    if (!gamma) {
        return;
    }
    const double value = number_at(gamma) / 1e5;
    if (!(value >= 0.01 && value <= 100.0)) {
        image_note(info, IMAGE_NOTE_SPACE, "PNG: gAMA %g is not usable: taken as sRGB", value);
        return;
    }
    if (stands_for_srgb) {
        snprintf(info->transfer_name, sizeof info->transfer_name,
                 "PNG: gAMA %g with Rec. 709's cHRM (an old way to say sRGB)", value);
        info->transfer = IMAGE_TRANSFER_SRGB;
        return;
    }
    snprintf(info->transfer_name, sizeof info->transfer_name, "PNG: gAMA %g", value);
    info->transfer = value == 1.0 ? IMAGE_TRANSFER_LINEAR : IMAGE_TRANSFER_GAMMA;
    info->gamma = 1.0 / value;
}

/* Reads chunk iCCP: a name, a zero, the compression method, and the profile. It is inflated here, because libpng hands
 * out no profile that it finds fault with. */
static void heed_profile(const unsigned char *chunk, size_t length, image_info *out) {
    enum { MOST = 1 << 16 }; /* the description stands near the beginning */
    char name[80] = "";
    size_t at = 0;
    for (; at < length && chunk[at]; at++) {
        if (at + 1 < sizeof name) {
            name[at] = (char)chunk[at];
        }
    }
    unsigned char *profile = malloc(MOST);
    z_stream z = {0};
    size_t size = 0;
    if (profile && at + 2 < length && inflateInit(&z) == Z_OK) {
        z.next_in = (unsigned char *)(uintptr_t)(chunk + at + 2);
        z.avail_in = (uInt)(length - at - 2);
        z.next_out = profile;
        z.avail_out = MOST;
        inflate(&z, Z_FINISH); /* the beginning is of use, whatever comes behind */
        size = MOST - z.avail_out;
        inflateEnd(&z);
    }
    image_info_profile(out, "PNG", profile, size, name);
    free(profile);
}

/* Notes what a file without chunk gAMA or any of higher rank says of its colours elsewhere: in a profile among its
 * texts, or in EXIF. */
static void heed_texts(const unsigned char *data, size_t size, const unsigned char *exif, size_t exif_size,
                       image_info *out) {
    static const char *const kinds[] = {"icc", "icm"};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        size_t length;
        unsigned char *profile = png_text_raw_profile(data, size, kinds[k], &length);
        if (profile) {
            image_info_profile(out, "PNG", profile, length, NULL);
        }
        free(profile);
        if (profile) {
            return;
        }
    }
    if (exif && exif_colour_is_other(exif, exif_size)) {
        image_note(
            out, IMAGE_NOTE_SPACE,
            "PNG: EXIF says that the colour space is not sRGB (cameras mean Adobe RGB): not applied");
    }
}

/* Reads what the file says of its colours, in the chunk of the highest rank alone: cICP, iCCP, sRGB, gAMA with
 * cHRM. */
static void heed_colour(const unsigned char *data, size_t size, const unsigned char *exif, size_t exif_size,
                        image_info *out) {
    size_t length, gamma_length = 0, chromaticities_length = 0;
    const unsigned char *chunk = find_chunk(data, size, "cICP", &length);
    if (chunk && length == 4) {
        heed_code_points(chunk, out);
        return;
    }
    chunk = find_chunk(data, size, "iCCP", &length);
    if (chunk) {
        heed_profile(chunk, length, out);
        return;
    }
    if (find_chunk(data, size, "sRGB", &length)) {
        out->transfer = IMAGE_TRANSFER_SRGB;
        return;
    }
    const unsigned char *gamma = find_chunk(data, size, "gAMA", &gamma_length);
    const unsigned char *chromaticities = find_chunk(data, size, "cHRM", &chromaticities_length);
    heed_gamma(gamma_length == 4 ? gamma : NULL, chromaticities_length == 32 ? chromaticities : NULL, out);
    if (!gamma) {
        heed_texts(data, size, exif, exif_size, out);
    }
}

/* The picture's orientation: as chunk eXIf says, else EXIF among the texts. XMP's is only noted: few readers follow
 * it, and programs that turn pixels leave it behind. */
static int heed_orientation(const unsigned char *data, size_t size, const unsigned char *exif,
                            size_t exif_size, image_info *out) {
    static const char *const kinds[] = {"exif", "APP1"};
    int turned = exif ? exif_orientation(exif, exif_size) : 1;
    size_t length;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds && !exif && turned == 1; k++) {
        unsigned char *block = png_text_raw_profile(data, size, kinds[k], &length);
        turned = block ? exif_orientation(block, length) : 1;
        free(block);
    }
    unsigned char *xmp = png_text_find(data, size, "XML:com.adobe.xmp", &length);
    if (xmp && xmp_orientation(xmp, length) != 1) {
        image_note(out, IMAGE_NOTE_TURNED, "PNG: XMP orientation %d is not applied: taken as stored",
                   xmp_orientation(xmp, length));
    }
    free(xmp);
    return turned;
}

/* Takes alpha, the last channel, out of the pixels; true where it was not 1 everywhere. */
static bool drop_alpha(reading *r) {
    const size_t bytes = (size_t)r->depth / 8, colours = (size_t)r->channels - 1;
    const size_t count = (size_t)r->width * (size_t)r->height;
    bool clear = false;
    for (size_t i = 0; i < count; i++) {
        const unsigned char *from = r->pixels + i * (colours + 1) * bytes;
        for (size_t b = 0; b < bytes; b++) {
            clear = clear || from[colours * bytes + b] != 255;
        }
        memmove(r->pixels + i * colours * bytes, from, colours * bytes);
    }
    r->channels = (int)colours;
    return clear;
}

static btf_result decode(reading *r, png_structp png, png_infop info, size_t max_pixels) {
    const unsigned char *data = r->data;
    const size_t size = r->left;
    if (setjmp(png_jmpbuf(png))) {
        return BTF_ERROR_BAD_FILE;
    }
    png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    png_set_read_fn(png, r, on_read);
    png_read_info(png, info);
    const size_t width = png_get_image_width(png, info), height = png_get_image_height(png, info);
    if (width > max_pixels / height) {
        snprintf(r->text, sizeof r->text, "%zux%zu pixels are more than %zu, the most that are read", width,
                 height, max_pixels);
        return BTF_ERROR_UNSUPPORTED;
    }
    size_t exif_size = 0;
    const unsigned char *exif = find_chunk(data, size, "eXIf", &exif_size);
    const int turned = heed_orientation(data, size, exif, exif_size, r->info);
    if (turned != 1) {
        snprintf(r->text, sizeof r->text, "EXIF orientation %d: turn the pixels, then set it to 1", turned);
        return BTF_ERROR_UNSUPPORTED;
    }
    heed_colour(data, size, exif, exif_size, r->info);
    png_set_expand(png); /* palettes, less than 8 bits, transparent colours */
    if (png_get_bit_depth(png, info) == 16 && little_endian()) {
        png_set_swap(png);
    }
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    r->width = (int)width;
    r->height = (int)height;
    r->channels = png_get_channels(png, info);
    r->depth = png_get_bit_depth(png, info);
    const size_t row_bytes = png_get_rowbytes(png, info);
    r->pixels = malloc(height * row_bytes);
    r->rows = malloc(height * sizeof *r->rows);
    if (!r->pixels || !r->rows) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t row = 0; row < height; row++) {
        r->rows[row] = r->pixels + row * row_bytes;
    }
    png_read_image(png, r->rows);
    png_read_end(png, NULL);
    if (r->channels % 2 == 0 && drop_alpha(r)) {
        image_note(r->info, IMAGE_NOTE_ALPHA,
                   "PNG: transparency is not used: colours are taken as they are stored");
    }
    return BTF_OK;
}

btf_result png_image_read(const void *data, size_t size, size_t max_pixels, int *out_width, int *out_height,
                          int *out_channels, int *out_depth, void **out_pixels, image_info *info,
                          char *message, size_t message_size) {
    reading *r = calloc(1, sizeof *r);
    if (!r) {
        return BTF_ERROR_MEMORY;
    }
    r->data = data;
    r->left = size;
    r->info = info;
    btf_result result = BTF_ERROR_MEMORY;
    png_infop png_info = NULL;
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, r->text, on_error, on_warning);
    if (png && (png_info = png_create_info_struct(png))) {
        result = decode(r, png, png_info, max_pixels);
    }
    png_destroy_read_struct(&png, &png_info, NULL);
    if (result == BTF_OK) {
        *out_width = r->width;
        *out_height = r->height;
        *out_channels = r->channels;
        *out_depth = r->depth;
        *out_pixels = r->pixels;
    } else {
        free(r->pixels);
        snprintf(message, message_size, "PNG: %s", r->text[0] ? r->text : btf_result_text(result));
    }
    free(r->rows);
    free(r);
    return result;
}
