/* OpenEXR files written byte by byte.
 *
 * SPDX-License-Identifier: MIT
 */
#include "exr_bytes.h"

#include <math.h>
#include <openexr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct bytes {
    uint8_t *data;
    size_t size, capacity;
} bytes;

static void must(bool good, const char *what) {
    if (!good) {
        fprintf(stderr, "exr_bytes: %s\n", what);
        abort();
    }
}

static void put(bytes *b, const void *data, size_t size) {
    if (b->size + size > b->capacity) {
        b->capacity = 2 * (b->size + size) + 4096;
        b->data = realloc(b->data, b->capacity);
        must(b->data != NULL, "out of memory");
    }
    if (size) {
        memcpy(b->data + b->size, data, size);
    }
    b->size += size;
}

static void put_number(bytes *b, uint64_t value, int size) {
    for (int i = 0; i < size; i++) {
        put(b, &(uint8_t){(uint8_t)(value >> 8 * i)}, 1);
    }
}

static void put_text(bytes *b, const char *text) {
    put(b, text, strlen(text) + 1);
}

static void put_attribute(bytes *b, const char *name, const char *type, const void *value, size_t size) {
    put_text(b, name);
    put_text(b, type);
    put_number(b, size, 4);
    put(b, value, size);
}

static void put_float(bytes *b, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_number(b, bits, 4);
}

/* The half nearest to a number of its normal range or 0, what is not representable cut off. */
static unsigned half_of(float value) {
    int exponent;
    const float fraction = frexpf(fabsf(value), &exponent);
    if (value == 0.0f || exponent < -13) {
        return 0;
    }
    must(exponent <= 16, "beyond half");
    return (value < 0 ? 0x8000u : 0u) | (unsigned)(exponent + 14) << 10 |
           ((unsigned)(fraction * 2048.0f) & 1023u);
}

static void put_sample(bytes *b, const bytes_part *p, int c, int x, int y) {
    const float value = p->value(c, x, y);
    if (p->channels[c].type == BYTES_HALF) {
        put_number(b, half_of(value), 2);
    } else if (p->channels[c].type == BYTES_FLOAT) {
        put_float(b, value);
    } else {
        put_number(b, (uint32_t)value, 4);
    }
}

/* One row: of each channel the samples whose coordinates its sampling divides. */
static void put_row(bytes *b, const bytes_part *p, int y) {
    for (int c = 0; c < p->channel_count; c++) {
        const bytes_channel *channel = &p->channels[c];
        if (channel->ys < 1 || channel->xs < 1 || (p->y + y) % channel->ys != 0) {
            continue;
        }
        for (int x = 0; x < p->width; x++) {
            if ((p->x + x) % channel->xs == 0) {
                put_sample(b, p, c, x, y);
            }
        }
    }
}

static int lines_of(const bytes_part *p) {
    static const int lines[10] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
    return lines[p->compression];
}

static int chunks_of(const bytes_part *p) {
    return (p->height + lines_of(p) - 1) / lines_of(p);
}

static void put_window(bytes *b, const char *name, int x, int y, int width, int height) {
    bytes w = {0};
    const int sides[4] = {x, y, x + width - 1, y + height - 1};
    for (int i = 0; i < 4; i++) {
        put_number(&w, (uint32_t)sides[i], 4);
    }
    put_attribute(b, name, "box2i", w.data, w.size);
    free(w.data);
}

static void put_channels(bytes *b, const bytes_part *p) {
    bytes list = {0};
    for (int c = 0; c < p->channel_count; c++) {
        put_text(&list, p->channels[c].name);
        put_number(&list, (uint32_t)p->channels[c].type, 4);
        put_number(&list, 0, 4);
        put_number(&list, (uint32_t)p->channels[c].xs, 4);
        put_number(&list, (uint32_t)p->channels[c].ys, 4);
    }
    put_number(&list, 0, 1);
    put_attribute(b, "channels", "chlist", list.data, list.size);
    free(list.data);
}

static void put_header(bytes *b, const bytes_part *p, bool deep_file) {
    put_channels(b, p);
    put_attribute(b, "compression", "compression", &(uint8_t){(uint8_t)p->compression}, 1);
    put_window(b, "dataWindow", p->x, p->y, p->width, p->height);
    const bool own = p->display[2] > 0;
    put_window(b, "displayWindow", own ? p->display[0] : p->x, own ? p->display[1] : p->y,
               own ? p->display[2] : p->width, own ? p->display[3] : p->height);
    put_attribute(b, "lineOrder", "lineOrder", &(uint8_t){0}, 1);
    bytes number = {0};
    put_float(&number, p->aspect > 0 ? p->aspect : 1.0f);
    put_attribute(b, "pixelAspectRatio", "float", number.data, 4);
    number.size = 0;
    put_number(&number, 0, 8);
    put_attribute(b, "screenWindowCenter", "v2f", number.data, 8);
    number.size = 0;
    put_float(&number, 1.0f);
    put_attribute(b, "screenWindowWidth", "float", number.data, 4);
    if (p->name || p->deep) {
        const char *name = p->name ? p->name : "deep", *type = p->deep ? "deepscanline" : "scanlineimage";
        put_attribute(b, "name", "string", name, strlen(name));
        put_attribute(b, "type", "string", type, strlen(type));
        number.size = 0;
        put_number(&number, (uint32_t)chunks_of(p), 4);
        put_attribute(b, "chunkCount", "int", number.data, 4);
        if (deep_file) { /* OpenEXRCore wants it of every part */
            number.size = 0;
            put_number(&number, 1, 4);
            put_attribute(b, "version", "int", number.data, 4);
        }
    }
    free(number.data);
    for (int i = 0; i < p->attribute_count; i++) {
        put_attribute(b, p->attributes[i].name, p->attributes[i].type, p->attributes[i].value,
                      p->attributes[i].size);
    }
    put_number(b, 0, 1);
}

void *exr_bytes(const bytes_part *parts, int count, size_t *out_size) {
    bytes b = {0};
    const bool multiple = count > 1;
    bool deep = false;
    for (int p = 0; p < count; p++) {
        deep = deep || parts[p].deep;
    }
    put_number(&b, 20000630, 4);
    put_number(&b, 2u | (multiple ? 0x1000u : 0u) | (deep ? 0x800u : 0u), 4);
    for (int p = 0; p < count; p++) {
        put_header(&b, &parts[p], deep);
    }
    if (multiple) {
        put_number(&b, 0, 1);
    }
    size_t table = b.size;
    for (int p = 0; p < count; p++) {
        for (int i = 0; i < chunks_of(&parts[p]); i++) {
            put_number(&b, 0, 8);
        }
    }
    for (int p = 0; p < count; p++) {
        const int lines = lines_of(&parts[p]);
        for (int y = 0; y < parts[p].height; y += lines) {
            bytes at = {.data = b.data + table, .capacity = 8};
            put_number(&at, b.size, 8);
            table += 8;
            if (multiple) {
                put_number(&b, (uint32_t)p, 4);
            }
            put_number(&b, (uint32_t)(parts[p].y + y), 4);
            const size_t length = b.size;
            put_number(&b, 0, 4);
            for (int line = y; line < y + lines && line < parts[p].height; line++) {
                put_row(&b, &parts[p], line);
            }
            bytes size = {.data = b.data + length, .capacity = 4};
            put_number(&size, b.size - length - 4, 4);
        }
    }
    *out_size = b.size;
    return b.data;
}

/* Instead of OpenEXRCore's packing. */
static exr_result_t pack(exr_encode_pipeline_t *pipeline) {
    const bytes_part *part = pipeline->encoding_user_data;
    bytes b = {0};
    for (int y = 0; y < pipeline->chunk.height; y++) {
        put_row(&b, part, pipeline->chunk.start_y - part->y + y);
    }
    must(b.size == pipeline->chunk.unpacked_size, "size of a block");
    if (!pipeline->packed_buffer || pipeline->packed_alloc_size < b.size) {
        free(pipeline->packed_buffer);
        pipeline->packed_buffer = malloc(b.size + 64);
        pipeline->packed_alloc_size = b.size + 64;
    }
    memcpy(pipeline->packed_buffer, b.data, b.size);
    pipeline->packed_bytes = b.size;
    free(b.data);
    return EXR_ERR_SUCCESS;
}

static exr_result_t (*library_compress)(exr_encode_pipeline_t *pipeline);

static exr_result_t compress_or_keep(exr_encode_pipeline_t *pipeline) {
    const exr_result_t code = library_compress(pipeline);
    if (code == EXR_ERR_SUCCESS && pipeline->compressed_bytes >= pipeline->packed_bytes) {
        memcpy(pipeline->compressed_buffer, pipeline->packed_buffer, pipeline->packed_bytes);
        pipeline->compressed_bytes = pipeline->packed_bytes;
    }
    return code;
}

static void check(exr_result_t code) {
    must(code == EXR_ERR_SUCCESS, exr_get_default_error_message(code));
}

void exr_bytes_compressed(const char *path, const bytes_part *p) {
    exr_context_t context;
    exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
    check(exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &options));
    const exr_attr_box2i_t window = {.min = {.x = p->x, .y = p->y},
                                     .max = {.x = p->x + p->width - 1, .y = p->y + p->height - 1}};
    const exr_attr_v2f_t centre = {.x = 0, .y = 0};
    int part, lines;
    check(exr_add_part(context, "image", EXR_STORAGE_SCANLINE, &part));
    check(exr_initialize_required_attr(context, part, &window, &window, 1, &centre, 1,
                                       EXR_LINEORDER_INCREASING_Y, (exr_compression_t)p->compression));
    for (int c = 0; c < p->channel_count; c++) {
        check(exr_add_channel(context, part, p->channels[c].name, (exr_pixel_type_t)p->channels[c].type,
                              EXR_PERCEPTUALLY_LOGARITHMIC, p->channels[c].xs, p->channels[c].ys));
    }
    check(exr_write_header(context));
    check(exr_get_scanlines_per_chunk(context, part, &lines));
    for (int y = 0; y < p->height; y += lines) {
        exr_chunk_info_t chunk = {0};
        exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
        check(exr_write_scanline_chunk_info(context, part, p->y + y, &chunk));
        check(exr_encoding_initialize(context, part, &chunk, &pipeline));
        for (int c = 0; c < pipeline.channel_count; c++) { /* asked for, never read */
            pipeline.channels[c].encode_from_ptr = (const uint8_t *)p;
            pipeline.channels[c].user_pixel_stride = pipeline.channels[c].user_bytes_per_element = 4;
            pipeline.channels[c].user_line_stride = 4 * p->width;
            pipeline.channels[c].user_data_type = EXR_PIXEL_FLOAT;
        }
        check(exr_encoding_choose_default_routines(context, part, &pipeline));
        pipeline.encoding_user_data = (void *)(uintptr_t)p;
        pipeline.convert_and_pack_fn = pack;
        library_compress = pipeline.compress_fn;
        if (pipeline.compress_fn) {
            pipeline.compress_fn = compress_or_keep;
        }
        check(exr_encoding_run(context, part, &pipeline));
        exr_encoding_destroy(context, &pipeline);
    }
    check(exr_finish(&context));
}
