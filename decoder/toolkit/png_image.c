/* PNG images through libpng: writing RGB, and reading what the file holds.
 *
 * SPDX-License-Identifier: MIT
 */
#include "png_image.h"

#include "exif.h"
#include "output.h"

#include <png.h>
#include <setjmp.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MESSAGE_SIZE = 128 };

static bool little_endian(void) {
    const unsigned short one = 1;
    return *(const unsigned char *)&one == 1;
}

/* libpng's first complaint is kept, never printed; the caller names the file. */
static void on_error(png_structp png, png_const_charp text) {
    char *kept = png_get_error_ptr(png);
    if (!kept[0])
        snprintf(kept, MESSAGE_SIZE, "%s", text);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp text) {
    (void)png;
    (void)text;
}

/* Everything between the two jumps; objects that live across them belong to the caller. */
static btf_result encode(png_structp png, png_infop info, FILE *stream, int width, int height, int depth,
                         const unsigned char *pixels) {
    if (setjmp(png_jmpbuf(png)))
        return BTF_ERROR_IO;
    png_init_io(png, stream);
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, depth, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    if (depth == 16 && little_endian())
        png_set_swap(png); /* the file's order is big endian */
    const size_t row_bytes = (size_t)width * 3 * (size_t)depth / 8;
    for (int row = 0; row < height; row++)
        png_write_row(png, pixels + (size_t)row * row_bytes);
    png_write_end(png, info);
    return BTF_OK;
}

static btf_result write_image(const char *path, int width, int height, int depth, const void *pixels,
                              btf_log log) {
    output *file;
    btf_result result = output_open(path, log, &file);
    if (result != BTF_OK)
        return result;
    result = BTF_ERROR_MEMORY;
    char text[MESSAGE_SIZE] = "";
    png_infop info = NULL;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, text, on_error, on_warning);
    if (png && (info = png_create_info_struct(png)))
        result = encode(png, info, output_stream(file), width, height, depth, pixels);
    png_destroy_write_struct(&png, &info);
    if (result == BTF_ERROR_MEMORY) {
        output_abort(&file);
        return result;
    }
    /* A failed write shows in the stream, so that commit names the file and the reason; else it was
     * libpng's. */
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
    char text[MESSAGE_SIZE];
} reading;

static void on_read(png_structp png, png_bytep out, size_t size) {
    reading *r = png_get_io_ptr(png);
    if (size > r->left)
        png_error(png, "the file ends too early");
    memcpy(out, r->data, size);
    r->data += size;
    r->left -= size;
}

static btf_result decode(reading *r, png_structp png, png_infop info, size_t max_pixels) {
    if (setjmp(png_jmpbuf(png)))
        return BTF_ERROR_BAD_FILE;
    png_set_read_fn(png, r, on_read);
    png_read_info(png, info);
    const size_t width = png_get_image_width(png, info), height = png_get_image_height(png, info);
    if (width > max_pixels / height) {
        snprintf(r->text, sizeof r->text, "%zux%zu pixels are too many", width, height);
        return BTF_ERROR_UNSUPPORTED;
    }
    png_bytep exif = NULL;
    png_uint_32 exif_size = 0;
    if (png_get_eXIf_1(png, info, &exif_size, &exif) && exif_orientation(exif, exif_size) != 1) {
        snprintf(r->text, sizeof r->text, "EXIF orientation %d: turn the pixels, then set it to 1",
                 exif_orientation(exif, exif_size));
        return BTF_ERROR_UNSUPPORTED;
    }
    png_set_expand(png); /* palettes, less than 8 bits, transparent colours */
    png_set_strip_alpha(png);
    if (png_get_bit_depth(png, info) == 16 && little_endian())
        png_set_swap(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    r->width = (int)width;
    r->height = (int)height;
    r->channels = png_get_channels(png, info);
    r->depth = png_get_bit_depth(png, info);
    const size_t row_bytes = png_get_rowbytes(png, info);
    r->pixels = malloc(height * row_bytes);
    r->rows = malloc(height * sizeof *r->rows);
    if (!r->pixels || !r->rows)
        return BTF_ERROR_MEMORY;
    for (size_t row = 0; row < height; row++)
        r->rows[row] = r->pixels + row * row_bytes;
    png_read_image(png, r->rows);
    png_read_end(png, NULL);
    return BTF_OK;
}

btf_result png_image_read(const void *data, size_t size, size_t max_pixels, int *out_width, int *out_height,
                          int *out_channels, int *out_depth, void **out_pixels, char *message,
                          size_t message_size) {
    reading *r = calloc(1, sizeof *r);
    if (!r)
        return BTF_ERROR_MEMORY;
    r->data = data;
    r->left = size;
    btf_result result = BTF_ERROR_MEMORY;
    png_infop info = NULL;
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, r->text, on_error, on_warning);
    if (png && (info = png_create_info_struct(png)))
        result = decode(r, png, info, max_pixels);
    png_destroy_read_struct(&png, &info, NULL);
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
