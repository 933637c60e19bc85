/* Samples of one part of an OpenEXR file. OpenEXRCore 3.1.5 unpacks three or four channels of halves by a
 * fast path that takes every channel for one sampled 1 x 1, and writes wrong pixels or reads beyond its
 * block where one is not; so its unpacking is never asked for. The layout of a block is that of the OpenEXR
 * file layout document: row by row, in each row channel by channel in the file's order, of each channel the
 * samples that the row has.
 *
 * SPDX-License-Identifier: MIT
 */
#include "exr_pixels.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* A chunk's bytes, its place in the picture, and where its samples go. */
typedef struct job {
    const exr_attr_chlist_t *channels;
    const exr_attr_box2i_t *window;
    const exr_target *targets;
    int x, y; /* of the chunk's first pixel, from the window's corner */
    bool compressed;
    uint8_t *block; /* of an uncompressed part */
    size_t block_size;
} job;

bool exr_sampling_fits(const exr_attr_chlist_entry_t *channel, const exr_attr_box2i_t *window) {
    const int64_t xs = channel->x_sampling, ys = channel->y_sampling;
    if (xs < 1 || ys < 1) {
        return false;
    }
    const int64_t width = (int64_t)window->max.x - window->min.x + 1;
    const int64_t height = (int64_t)window->max.y - window->min.y + 1;
    return window->min.x % xs == 0 && window->min.y % ys == 0 && width % xs == 0 && height % ys == 0;
}

static float from_half(unsigned bits) {
    const uint32_t sign = (uint32_t)(bits & 0x8000u) << 16, exponent = bits >> 10 & 31u;
    const uint32_t mantissa = bits & 1023u;
    uint32_t out = sign | (exponent + 112) << 23 | mantissa << 13;
    if (exponent == 0) {
        const float value = (float)mantissa * 0x1p-24f;
        return sign ? -value : value;
    }
    if (exponent == 31) {
        out = sign | 0x7F800000u | mantissa << 13;
    }
    float value;
    memcpy(&value, &out, sizeof value);
    return value;
}

static uint32_t read32(const uint8_t *p) {
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static float sample_at(const uint8_t *p, exr_pixel_type_t type, size_t i) {
    if (type == EXR_PIXEL_HALF) {
        return from_half((unsigned)p[2 * i] | (unsigned)p[2 * i + 1] << 8);
    }
    const uint32_t bits = read32(p + 4 * i);
    if (type == EXR_PIXEL_UINT) {
        return (float)bits;
    }
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static size_t sample_size(exr_pixel_type_t type) {
    return type == EXR_PIXEL_HALF ? 2 : 4;
}

/* Samples of a channel in `width` columns of row y of the chunk: the window's corner has one. */
static size_t row_samples(const job *j, const exr_attr_chlist_entry_t *channel, int y, int width) {
    const int xs = channel->x_sampling, ys = channel->y_sampling;
    return (j->y + y) % ys == 0 ? (size_t)(width / xs) : 0;
}

static uint64_t expected_size(const job *j, const exr_chunk_info_t *chunk) {
    uint64_t size = 0;
    for (int y = 0; y < chunk->height; y++) {
        for (int c = 0; c < j->channels->num_channels; c++) {
            const exr_attr_chlist_entry_t *channel = &j->channels->entries[c];
            size += row_samples(j, channel, y, chunk->width) * sample_size(channel->pixel_type);
        }
    }
    return size;
}

static void store_row(const exr_target *target, const uint8_t *from, exr_pixel_type_t type, size_t count,
                      float *out) {
    const size_t stride = target->stride;
    if (!target->weights) {
        for (size_t i = 0; i < count; i++) {
            out[i * stride] = sample_at(from, type, i);
        }
        return;
    }
    for (size_t i = 0; i < count; i++) {
        const float value = sample_at(from, type, i);
        for (size_t c = 0; c < 3; c++) {
            out[i * stride + c] += target->weights[c] * value;
        }
    }
}

static void unpack(const job *j, const exr_chunk_info_t *chunk, const uint8_t *from) {
    for (int y = 0; y < chunk->height; y++) {
        for (int c = 0; c < j->channels->num_channels; c++) {
            const exr_attr_chlist_entry_t *channel = &j->channels->entries[c];
            const exr_target *target = &j->targets[c];
            const size_t count = row_samples(j, channel, y, chunk->width);
            if (target->out && count > 0) {
                store_row(target, from, channel->pixel_type, count,
                          target->out + (size_t)((j->y + y) / channel->y_sampling) * target->pitch +
                              (size_t)(j->x / channel->x_sampling) * target->stride);
            }
            for (size_t i = 0; target->below_one && !*target->below_one && i < count; i++) {
                *target->below_one = sample_at(from, channel->pixel_type, i) < 1.0f;
            }
            from += count * sample_size(channel->pixel_type);
        }
    }
}

/* The pipeline's last stage, instead of OpenEXRCore's. */
static exr_result_t unpack_stage(exr_decode_pipeline_t *pipeline) {
    if (!pipeline->unpacked_buffer) {
        return EXR_ERR_CORRUPT_CHUNK;
    }
    unpack(pipeline->decoding_user_data, &pipeline->chunk, pipeline->unpacked_buffer);
    return EXR_ERR_SUCCESS;
}

static exr_result_t read_plain(exr_const_context_t context, int part, job *j,
                               const exr_chunk_info_t *chunk) {
    if (chunk->packed_size != chunk->unpacked_size) {
        return EXR_ERR_CORRUPT_CHUNK;
    }
    if (chunk->packed_size > j->block_size) {
        uint8_t *more = realloc(j->block, chunk->packed_size);
        if (!more) {
            return EXR_ERR_OUT_OF_MEMORY;
        }
        j->block = more;
        j->block_size = chunk->packed_size;
    }
    if (chunk->packed_size == 0) {
        return EXR_ERR_SUCCESS;
    }
    const exr_result_t code = exr_read_chunk(context, part, chunk, j->block);
    if (code == EXR_ERR_SUCCESS) {
        unpack(j, chunk, j->block);
    }
    return code;
}

static exr_result_t read_compressed(exr_const_context_t context, int part, job *j,
                                    exr_decode_pipeline_t *pipeline, const exr_chunk_info_t *chunk) {
    const bool first = !pipeline->context;
    exr_result_t code = first ? exr_decoding_initialize(context, part, chunk, pipeline)
                              : exr_decoding_update(context, part, chunk, pipeline);
    if (code == EXR_ERR_SUCCESS && first) {
        code = exr_decoding_choose_default_routines(context, part, pipeline);
    }
    if (code != EXR_ERR_SUCCESS) {
        return code;
    }
    pipeline->decoding_user_data = j;
    pipeline->unpack_and_convert_fn = unpack_stage;
    return exr_decoding_run(context, part, pipeline);
}

static exr_result_t decode_chunk(exr_const_context_t context, int part, job *j,
                                 exr_decode_pipeline_t *pipeline, const exr_chunk_info_t *chunk) {
    const int64_t width = (int64_t)j->window->max.x - j->window->min.x + 1;
    const int64_t height = (int64_t)j->window->max.y - j->window->min.y + 1;
    if (chunk->width < 1 || chunk->height < 1 || chunk->width > width - j->x ||
        chunk->height > height - j->y || chunk->unpacked_size != expected_size(j, chunk)) {
        return EXR_ERR_BAD_CHUNK_LEADER;
    }
    return j->compressed ? read_compressed(context, part, j, pipeline, chunk)
                         : read_plain(context, part, j, chunk);
}

static exr_result_t read_scanlines(exr_const_context_t context, int part, job *j,
                                   exr_decode_pipeline_t *pipeline) {
    int32_t lines;
    exr_result_t code = exr_get_scanlines_per_chunk(context, part, &lines);
    const int height = j->window->max.y - j->window->min.y + 1;
    for (; code == EXR_ERR_SUCCESS && j->y < height; j->y += lines) {
        exr_chunk_info_t chunk = {0};
        code = exr_read_scanline_chunk_info(context, part, j->window->min.y + j->y, &chunk);
        if (code == EXR_ERR_SUCCESS) {
            code = decode_chunk(context, part, j, pipeline, &chunk);
        }
    }
    return code;
}

static exr_result_t read_tiles(exr_const_context_t context, int part, job *j,
                               exr_decode_pipeline_t *pipeline) {
    int32_t width, height;
    exr_result_t code = exr_get_tile_sizes(context, part, 0, 0, &width, &height);
    const int columns = j->window->max.x - j->window->min.x + 1;
    const int rows = j->window->max.y - j->window->min.y + 1;
    for (; code == EXR_ERR_SUCCESS && j->y < rows; j->y += height) {
        for (j->x = 0; code == EXR_ERR_SUCCESS && j->x < columns; j->x += width) {
            exr_chunk_info_t chunk = {0};
            code = exr_read_tile_chunk_info(context, part, j->x / width, j->y / height, 0, 0, &chunk);
            if (code == EXR_ERR_SUCCESS) {
                code = decode_chunk(context, part, j, pipeline, &chunk);
            }
        }
    }
    return code;
}

exr_result_t exr_read_pixels(exr_const_context_t context, int part, const exr_attr_box2i_t *window,
                             bool tiled, const exr_target *targets) {
    job j = {.window = window, .targets = targets};
    exr_compression_t compression = EXR_COMPRESSION_NONE;
    exr_result_t code = exr_get_channels(context, part, &j.channels);
    if (code == EXR_ERR_SUCCESS) {
        code = exr_get_compression(context, part, &compression);
    }
    j.compressed = compression != EXR_COMPRESSION_NONE;
    if (code != EXR_ERR_SUCCESS) {
        return code;
    }
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    code = tiled ? read_tiles(context, part, &j, &pipeline) : read_scanlines(context, part, &j, &pipeline);
    exr_decoding_destroy(context, &pipeline);
    free(j.block);
    return code;
}
