/* RGB images in OpenEXR files through OpenEXRCore.
 *
 * SPDX-License-Identifier: MIT
 */
#include "exr_image.h"

#include "exr_chroma.h"
#include "exr_pixels.h"
#include "output.h"
#include "primaries.h"

#include <openexr.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What the library's callbacks see: the bytes to read, or the stream to write, and its first complaint. */
typedef struct exr_stream {
    const unsigned char *data;
    uint64_t size;
    FILE *stream;
    char text[256];
} exr_stream;

/* The stream this thread is at work on. OpenEXRCore 3.1 may call the error handler with its context locked,
 * and exr_get_user_data would wait for that lock for ever. */
static _Thread_local exr_stream *current;

static void on_error(exr_const_context_t context, exr_result_t code, const char *text) {
    (void)context;
    (void)code;
    if (current && !current->text[0])
        snprintf(current->text, sizeof current->text, "%s", text);
}

static int64_t on_size(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((exr_stream *)user)->size;
}

static int64_t on_read(exr_const_context_t context, void *user, void *buffer, uint64_t size,
                       uint64_t offset, exr_stream_error_func_ptr_t fail) {
    (void)context;
    (void)fail;
    const exr_stream *s = user;
    if (offset >= s->size)
        return 0;
    const uint64_t n = size < s->size - offset ? size : s->size - offset;
    memcpy(buffer, s->data + offset, n);
    return (int64_t)n;
}

static int64_t on_write(exr_const_context_t context, void *user, const void *buffer, uint64_t size,
                        uint64_t offset, exr_stream_error_func_ptr_t fail) {
    FILE *stream = ((exr_stream *)user)->stream;
    if (fseeko(stream, (off_t)offset, SEEK_SET) != 0 || fwrite(buffer, 1, size, stream) != size) {
        fail(context, EXR_ERR_WRITE_IO, "writing failed");
        return -1;
    }
    return (int64_t)size;
}

static btf_result result_of(exr_result_t code) {
    switch (code) {
    case EXR_ERR_SUCCESS:
        return BTF_OK;
    case EXR_ERR_OUT_OF_MEMORY:
        return BTF_ERROR_MEMORY;
    case EXR_ERR_FEATURE_NOT_IMPLEMENTED:
        return BTF_ERROR_UNSUPPORTED;
    default:
        return BTF_ERROR_BAD_FILE;
    }
}

/* An open file being decoded. names[] are the wanted channels in the order of the image's. */
typedef struct reading {
    exr_context_t context;
    exr_image image;
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *list;
    const char *names[3];
    bool chroma; /* they are RY, Y, BY */
    int x_step, y_step;
} reading;

static int find_channel(const reading *r, const char *name) {
    for (int i = 0; i < r->list->num_channels; i++)
        if (strcmp(r->list->entries[i].name.str, name) == 0)
            return i;
    return -1;
}

/* Refuses sampling that the picture's channels may not have: chroma alone is subsampled, by 2, all of it
 * alike. */
static btf_result check_sampling(reading *r, bool tiled, char *message, size_t message_size) {
    r->x_step = r->y_step = 1;
    if (r->chroma) {
        const exr_attr_chlist_entry_t *red = &r->list->entries[find_channel(r, "RY")];
        r->x_step = red->x_sampling == 2 ? 2 : 1;
        r->y_step = red->y_sampling == 2 ? 2 : 1;
    }
    for (int i = 0; i < r->list->num_channels; i++) {
        const exr_attr_chlist_entry_t *channel = &r->list->entries[i];
        int c = 0;
        while (c < r->image.channels && strcmp(channel->name.str, r->names[c]) != 0)
            c++;
        const bool free_to_differ = c == r->image.channels && !tiled, is_chroma = r->chroma && c != 1;
        if (exr_sampling_fits(channel, &r->window) &&
            (free_to_differ || (channel->x_sampling == (is_chroma ? r->x_step : 1) &&
                                channel->y_sampling == (is_chroma ? r->y_step : 1))))
            continue;
        snprintf(message, message_size,
                 "EXR: subsampled channels: %.40s is sampled %d x %d, which is read for chroma (RY and BY, both "
                 "by 2) alone",
                 channel->name.str, (int)channel->x_sampling, (int)channel->y_sampling);
        return BTF_ERROR_UNSUPPORTED;
    }
    return BTF_OK;
}

/* Finds which channels make the picture. */
static btf_result choose_channels(reading *r, char *message, size_t message_size) {
    static const char *const sets[4][3] = {
        {"R", "G", "B"}, {"X", "Y", "Z"}, {"RY", "Y", "BY"}, {"Y", NULL, NULL}};
    for (int set = 0; set < 4; set++) {
        int wanted = 0, found = 0;
        for (; wanted < 3 && sets[set][wanted]; wanted++)
            found += find_channel(r, sets[set][wanted]) >= 0;
        if (found != wanted)
            continue;
        r->image.channels = wanted;
        r->image.xyz = set == 1;
        r->chroma = set == 2;
        memcpy(r->names, sets[set], sizeof r->names);
        return BTF_OK;
    }
    snprintf(message, message_size, "EXR: %d channels, neither R, G, B nor X, Y, Z nor Y among them",
             r->list->num_channels);
    return BTF_ERROR_UNSUPPORTED;
}

/* Luminance and chroma to RGB, the luminance of R, G and B being that of the file's primaries. */
static btf_result finish_chroma(reading *r) {
    exr_attr_chromaticities_t c;
    primaries p = primaries_rec709;
    double xyz[9];
    if (exr_attr_get_chromaticities(r->context, 0, "chromaticities", &c) == EXR_ERR_SUCCESS)
        p = (primaries){{(double)c.red_x, (double)c.red_y},
                        {(double)c.green_x, (double)c.green_y},
                        {(double)c.blue_x, (double)c.blue_y},
                        {(double)c.white_x, (double)c.white_y}};
    if (!primaries_to_xyz(&p, xyz) || !(fabs(xyz[4]) > 1e-6))
        return BTF_ERROR_BAD_FILE;
    const float weights[3] = {(float)xyz[3], (float)xyz[4], (float)xyz[5]};
    return exr_chroma_to_rgb(r->image.width, r->image.height, r->x_step, r->y_step, weights,
                             r->image.pixels);
}

static btf_result read_samples(reading *r, bool tiled) {
    const size_t n = (size_t)r->image.channels, row = (size_t)r->image.width * n;
    exr_target *targets = calloc((size_t)r->list->num_channels, sizeof *targets);
    r->image.pixels = calloc(row * (size_t)r->image.height, sizeof *r->image.pixels);
    if (!targets || !r->image.pixels) {
        free(targets);
        return BTF_ERROR_MEMORY;
    }
    for (size_t c = 0; c < n; c++) {
        const int i = find_channel(r, r->names[c]);
        const exr_attr_chlist_entry_t *channel = &r->list->entries[i];
        targets[i] = (exr_target){.out = r->image.pixels + c,
                                  .stride = n * (size_t)channel->x_sampling,
                                  .pitch = row * (size_t)channel->y_sampling};
    }
    const btf_result result = result_of(exr_read_pixels(r->context, 0, &r->window, tiled, targets));
    free(targets);
    return result == BTF_OK && r->chroma ? finish_chroma(r) : result;
}

static btf_result decode(reading *r, size_t max_pixels, char *message, size_t message_size) {
    exr_storage_t storage;
    exr_compression_t compression;
    exr_result_t code = exr_get_storage(r->context, 0, &storage);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_compression(r->context, 0, &compression);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_data_window(r->context, 0, &r->window);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_channels(r->context, 0, &r->list);
    if (code != EXR_ERR_SUCCESS)
        return result_of(code);
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED) {
        snprintf(message, message_size, "EXR: the first part holds deep data");
        return BTF_ERROR_UNSUPPORTED;
    }
    /* OpenEXRCore 3.1.5 gives wrong values for float channels and fails on small tiles. */
    if (compression == EXR_COMPRESSION_B44 || compression == EXR_COMPRESSION_B44A) {
        snprintf(message, message_size, "EXR: B44 compression");
        return BTF_ERROR_UNSUPPORTED;
    }
    const int64_t width = (int64_t)r->window.max.x - r->window.min.x + 1;
    const int64_t height = (int64_t)r->window.max.y - r->window.min.y + 1;
    if (width < 1 || height < 1 || width > (1 << 20) || height > (1 << 20) ||
        (uint64_t)width * (uint64_t)height > max_pixels) {
        snprintf(message, message_size, "EXR: size %lldx%lld is not usable", (long long)width,
                 (long long)height);
        return BTF_ERROR_UNSUPPORTED;
    }
    r->image.width = (int)width;
    r->image.height = (int)height;
    btf_result result = choose_channels(r, message, message_size);
    if (result == BTF_OK)
        result = check_sampling(r, storage == EXR_STORAGE_TILED, message, message_size);
    return result == BTF_OK ? read_samples(r, storage == EXR_STORAGE_TILED) : result;
}

btf_result exr_image_read(const void *data, size_t size, size_t max_pixels, exr_image *out_image,
                          char *message, size_t message_size) {
    exr_stream stream = {.data = data, .size = size};
    exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
    options.error_handler_fn = on_error;
    options.user_data = &stream;
    options.read_fn = on_read;
    options.size_fn = on_size;
    reading r = {0};
    message[0] = '\0';
    current = &stream;
    btf_result result = result_of(exr_start_read(&r.context, "memory", &options));
    if (result == BTF_OK)
        result = decode(&r, max_pixels, message, message_size);
    exr_finish(&r.context);
    current = NULL;
    if (result == BTF_OK) {
        *out_image = r.image;
        return BTF_OK;
    }
    free(r.image.pixels);
    if (!message[0])
        snprintf(message, message_size, "EXR: %s", stream.text[0] ? stream.text : btf_result_text(result));
    return result;
}

static exr_result_t describe_part(exr_context_t context, int width, int height, bool half) {
    int part;
    const exr_attr_box2i_t window = {.max = {.x = width - 1, .y = height - 1}};
    const exr_attr_v2f_t centre = {.x = 0.0f, .y = 0.0f};
    exr_result_t code = exr_add_part(context, "image", EXR_STORAGE_SCANLINE, &part);
    if (code == EXR_ERR_SUCCESS)
        code = exr_initialize_required_attr(context, part, &window, &window, 1.0f, &centre, 1.0f,
                                            EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP);
    static const char *const names[3] = {"B", "G", "R"}; /* files list channels by name */
    for (int c = 0; c < 3 && code == EXR_ERR_SUCCESS; c++)
        code = exr_add_channel(context, part, names[c], half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                               EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
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

static exr_result_t encode_chunks(exr_context_t context, int width, int height, const float *rgb,
                                  exr_encode_pipeline_t *pipeline) {
    int32_t lines;
    encoder_state state;
    exr_result_t code = exr_get_scanlines_per_chunk(context, 0, &lines);
    for (int y = 0; code == EXR_ERR_SUCCESS && y < height; y += lines) {
        exr_chunk_info_t chunk = {0};
        code = exr_write_scanline_chunk_info(context, 0, y, &chunk);
        if (code == EXR_ERR_SUCCESS)
            code = y == 0 ? exr_encoding_initialize(context, 0, &chunk, pipeline)
                          : exr_encoding_update(context, 0, &chunk, pipeline);
        if (code != EXR_ERR_SUCCESS)
            return code;
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
        if (code == EXR_ERR_SUCCESS)
            code = exr_encoding_run(context, 0, pipeline);
    }
    return code;
}

/* A copy whose values fit a half float. */
static float *clamp_to_half(const float *rgb, size_t count) {
    float *copy = malloc(count * sizeof *copy);
    for (size_t i = 0; copy && i < count; i++)
        copy[i] = fminf(fmaxf(rgb[i], -65504.0f), 65504.0f);
    return copy;
}

btf_result exr_image_write(const char *path, int width, int height, const float *rgb, bool half,
                           btf_log log) {
    float *clamped = NULL;
    if (half) {
        clamped = clamp_to_half(rgb, (size_t)width * (size_t)height * 3);
        if (!clamped)
            return BTF_ERROR_MEMORY;
        rgb = clamped;
    }
    output *file;
    btf_result result = output_open(path, log, &file);
    if (result != BTF_OK) {
        free(clamped);
        return result;
    }
    exr_stream stream = {.stream = output_stream(file)};
    exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
    options.error_handler_fn = on_error;
    options.user_data = &stream;
    options.write_fn = on_write;
    exr_context_t context = NULL;
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    current = &stream;
    exr_result_t code = exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &options);
    if (code == EXR_ERR_SUCCESS)
        code = describe_part(context, width, height, half);
    if (code == EXR_ERR_SUCCESS)
        code = encode_chunks(context, width, height, rgb, &pipeline);
    if (context)
        exr_encoding_destroy(context, &pipeline);
    const exr_result_t finished = exr_finish(&context);
    current = NULL;
    free(clamped);
    if (code == EXR_ERR_SUCCESS)
        code = finished;
    if (code == EXR_ERR_SUCCESS)
        return output_commit(&file);
    output_abort(&file);
    if (log.callback) {
        char text[512];
        snprintf(text, sizeof text, "%.200s: EXR: %s", path,
                 stream.text[0] ? stream.text : exr_get_default_error_message(code));
        log.callback(log.user, BTF_LOG_ERROR, text);
    }
    return code == EXR_ERR_OUT_OF_MEMORY ? BTF_ERROR_MEMORY : BTF_ERROR_IO;
}
