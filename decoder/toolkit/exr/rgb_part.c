/* Writes the one part of an RGB picture through OpenEXRCore. See rgb_part.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "rgb_part.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

static exr_result_t describe(exr_context_t context, int width, int height, bool half) {
    int part;
    const exr_attr_box2i_t window = {.max = {.x = width - 1, .y = height - 1}};
    const exr_attr_v2f_t centre = {.x = 0.0f, .y = 0.0f};
    exr_result_t code = exr_add_part(context, "image", EXR_STORAGE_SCANLINE, &part);
    if (code == EXR_ERR_SUCCESS) {
        code = exr_initialize_required_attr(context, part, &window, &window, 1.0f, &centre, 1.0f,
                                            EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP);
    }
    static const char *const names[3] = {"B", "G", "R"}; /* files list channels by name */
    for (int c = 0; c < 3 && code == EXR_ERR_SUCCESS; c++) {
        code = exr_add_channel(context, part, names[c], half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                               EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    }
    return code == EXR_ERR_SUCCESS ? exr_write_header(context) : code;
}

typedef exr_result_t (*compress_function)(exr_encode_pipeline_t *pipeline);
typedef struct encoder_state {
    compress_function compress; /* OpenEXRCore's own */
} encoder_state;

/* A chunk that deflates to exactly its plain length is taken for plain data by every reader, but
 * OpenEXRCore 3.1.5 writes it deflated. Here it is written plain, as any chunk that does not shrink. */
static exr_result_t compress_chunk(exr_encode_pipeline_t *pipeline) {
    const encoder_state *state = pipeline->encoding_user_data;
    const exr_result_t code = state->compress(pipeline);
    if (code == EXR_ERR_SUCCESS && pipeline->compressed_bytes >= pipeline->packed_bytes) {
        memcpy(pipeline->compressed_buffer, pipeline->packed_buffer, pipeline->packed_bytes);
        pipeline->compressed_bytes = pipeline->packed_bytes;
    }
    return code;
}

static exr_result_t write_chunks(exr_context_t context, int width, int height, const float *rgb,
                                 exr_encode_pipeline_t *pipeline) {
    int32_t lines;
    encoder_state state;
    exr_result_t code = exr_get_scanlines_per_chunk(context, 0, &lines);
    for (int y = 0; code == EXR_ERR_SUCCESS && y < height; y += lines) {
        exr_chunk_info_t chunk = {0};
        code = exr_write_scanline_chunk_info(context, 0, y, &chunk);
        if (code == EXR_ERR_SUCCESS) {
            code = y == 0 ? exr_encoding_initialize(context, 0, &chunk, pipeline)
                          : exr_encoding_update(context, 0, &chunk, pipeline);
        }
        if (code != EXR_ERR_SUCCESS) {
            return code;
        }
        for (int i = 0; i < pipeline->channel_count; i++) {
            exr_coding_channel_info_t *channel = &pipeline->channels[i];
            const int c = strchr("RGB", channel->channel_name[0]) - "RGB";
            channel->encode_from_ptr = (const uint8_t *)(rgb + (size_t)y * (size_t)width * 3 + (size_t)c);
            channel->user_pixel_stride = 3 * (int32_t)sizeof(float);
            channel->user_line_stride = width * 3 * (int32_t)sizeof(float);
            channel->user_bytes_per_element = sizeof(float);
            channel->user_data_type = EXR_PIXEL_FLOAT;
        }
        if (y == 0) {
            code = exr_encoding_choose_default_routines(context, 0, pipeline);
            state.compress = pipeline->compress_fn;
            pipeline->compress_fn = compress_chunk;
            pipeline->encoding_user_data = &state;
        }
        if (code == EXR_ERR_SUCCESS) {
            code = exr_encoding_run(context, 0, pipeline);
        }
    }
    return code;
}

exr_result_t exr_rgb_part_write(exr_context_t context, int width, int height, const float *rgb, bool half) {
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t code = describe(context, width, height, half);
    if (code == EXR_ERR_SUCCESS) {
        code = write_chunks(context, width, height, rgb, &pipeline);
    }
    exr_encoding_destroy(context, &pipeline);
    return code;
}
