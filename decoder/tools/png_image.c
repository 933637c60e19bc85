/* Writing RGB images as PNG.
 *
 * SPDX-License-Identifier: MIT
 */
#include "png_image.h"

#include "output.h"

#include <png.h>
#include <setjmp.h>
#include <stdlib.h>

/* libpng reports errors here and never to stderr; the caller names the file. */
static void on_error(png_structp png, png_const_charp text) {
    (void)text;
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
    const unsigned short one = 1;
    if (depth == 16 && *(const unsigned char *)&one == 1)
        png_set_swap(png); /* samples are in the machine's order, the file's are big endian */
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
    png_infop info = NULL;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, on_error, on_warning);
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
        if (log.callback)
            log.callback(log.user, BTF_LOG_ERROR, "PNG: encoding failed");
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
