/* Image files for the readers' tests. See image_files.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "image_files.h"

#include "test.h"

#include <openexr.h>
#include <png.h>

/* One component of a scan line in runs and literals. */
static void put_new_runs(FILE *f, const unsigned char *rgbe, int width, int component) {
    for (int x = 0; x < width;) {
        int run = 1;
        while (x + run < width && run < 127 && rgbe[4 * (x + run) + component] == rgbe[4 * x + component]) {
            run++;
        }
        putc(run > 1 ? 128 + run : 1, f);
        putc(rgbe[4 * x + component], f);
        x += run;
    }
}

static void put_old_runs(FILE *f, const unsigned char *rgbe, int width) {
    for (int x = 0; x < width;) {
        int run = 0;
        while (x > 0 && x + run < width && memcmp(rgbe + 4 * (x + run), rgbe + 4 * (x - 1), 4) == 0) {
            run++;
        }
        if (run > 0) {
            for (int rest = run; rest > 0; rest >>= 8) {
                const unsigned char code[4] = {1, 1, 1, (unsigned char)(rest & 255)};
                fwrite(code, 1, 4, f);
            }
            x += run;
        } else {
            fwrite(rgbe + 4 * x++, 1, 4, f);
        }
    }
}

void write_hdr(const char *path, int width, int height, const unsigned char *rgbe, hdr_coding coding,
               const char *header, bool upwards) {
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    fprintf(f, "#?RADIANCE\n%s\n%cY %d +X %d\n", header, upwards ? '+' : '-', height, width);
    for (int line = 0; line < height; line++) {
        const unsigned char *row = rgbe + (size_t)(upwards ? height - 1 - line : line) * (size_t)width * 4;
        if (coding == HDR_NEW_RUNS) {
            const unsigned char start[4] = {2, 2, (unsigned char)(width >> 8),
                                            (unsigned char)(width & 255)};
            fwrite(start, 1, 4, f);
            for (int c = 0; c < 4; c++) {
                put_new_runs(f, row, width, c);
            }
        } else if (coding == HDR_OLD_RUNS) {
            put_old_runs(f, row, width);
        } else {
            fwrite(row, 4, (size_t)width, f);
        }
    }
    assert_int_equal(fclose(f), 0);
}

void write_png(const char *path, int width, int height, int colour_type, int depth, bool interlaced,
               const unsigned char *pixels, const unsigned char *palette) {
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    assert_non_null(info);
    if (setjmp(png_jmpbuf(png))) {
        fail_msg("libpng could not write %s", path);
    }
    png_init_io(png, f);
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, depth, colour_type,
                 interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (palette) {
        png_set_PLTE(png, info, (png_const_colorp)(const void *)palette, 1 << depth);
    }
    png_write_info(png, info);
    const size_t row_bytes = png_get_rowbytes(png, info);
    const int passes = png_set_interlace_handling(png);
    for (int pass = 0; pass < passes; pass++) {
        for (int row = 0; row < height; row++) {
            png_write_row(png, pixels + (size_t)row * row_bytes);
        }
    }
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    assert_int_equal(fclose(f), 0);
}

static void check(exr_result_t code) {
    if (code != EXR_ERR_SUCCESS) {
        fail_msg("OpenEXRCore: %s", exr_get_default_error_message(code));
    }
}

static void set_channels(exr_encode_pipeline_t *pipeline, const float *first, int n, const char *names,
                         int width) {
    for (int i = 0; i < pipeline->channel_count; i++) {
        exr_coding_channel_info_t *channel = &pipeline->channels[i];
        const int c = n == 1 ? 0 : (int)(strchr(names, channel->channel_name[0]) - names);
        channel->encode_from_ptr = (const uint8_t *)(first + c);
        channel->user_pixel_stride = n * (int32_t)sizeof(float);
        channel->user_line_stride = width * n * (int32_t)sizeof(float);
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
    }
}

void write_exr_tiled(const char *path, int width, int height, int n, const char *names,
                     const float *pixels) {
    enum { TILE = 8 };
    exr_context_t context;
    exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
    check(exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &options));
    const exr_attr_box2i_t window = {.min = {.x = -3, .y = 5}, .max = {.x = width - 4, .y = height + 4}};
    const exr_attr_v2f_t centre = {.x = 0.0f, .y = 0.0f};
    for (int expected = 0, part; expected < 2; expected++) {
        check(exr_add_part(context, expected ? "second" : "first",
                           expected ? EXR_STORAGE_SCANLINE : EXR_STORAGE_TILED, &part));
        check(exr_initialize_required_attr(context, part, &window, &window, 1.0f, &centre, 1.0f,
                                           EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_NONE));
    }
    check(exr_set_tile_descriptor(context, 0, TILE, TILE, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN));
    for (int c = 0; c < n; c++) {
        const char name[2] = {names[c], '\0'};
        check(exr_add_channel(context, 0, name, EXR_PIXEL_HALF, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    }
    check(exr_add_channel(context, 1, "Z", EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LINEAR, 1, 1));
    check(exr_write_header(context));

    for (int y = 0; y < height; y += TILE) {
        for (int x = 0; x < width; x += TILE) {
            exr_chunk_info_t chunk = {0};
            exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
            check(exr_write_tile_chunk_info(context, 0, x / TILE, y / TILE, 0, 0, &chunk));
            check(exr_encoding_initialize(context, 0, &chunk, &pipeline));
            set_channels(&pipeline, pixels + ((size_t)y * (size_t)width + (size_t)x) * (size_t)n, n, names,
                         width);
            check(exr_encoding_choose_default_routines(context, 0, &pipeline));
            check(exr_encoding_run(context, 0, &pipeline));
            exr_encoding_destroy(context, &pipeline);
        }
    }
    int32_t lines;
    float *depth = calloc((size_t)width * (size_t)height, sizeof *depth);
    assert_non_null(depth);
    check(exr_get_scanlines_per_chunk(context, 1, &lines));
    for (int y = 0; y < height; y += lines) {
        exr_chunk_info_t chunk = {0};
        exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
        check(exr_write_scanline_chunk_info(context, 1, y + window.min.y, &chunk));
        check(exr_encoding_initialize(context, 1, &chunk, &pipeline));
        set_channels(&pipeline, depth + (size_t)y * (size_t)width, 1, "Z", width);
        check(exr_encoding_choose_default_routines(context, 1, &pipeline));
        check(exr_encoding_run(context, 1, &pipeline));
        exr_encoding_destroy(context, &pipeline);
    }
    free(depth);
    check(exr_finish(&context));
}

void *read_whole_file(const char *path, size_t *out_size) {
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    fseek(f, 0, SEEK_END);
    *out_size = (size_t)ftell(f);
    rewind(f);
    void *data = malloc(*out_size + 1);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, *out_size, f), *out_size);
    fclose(f);
    return data;
}

void write_whole_file(const char *path, const void *data, size_t size) {
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
}
