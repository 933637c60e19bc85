/* OpenBTF: a material from a multi-part OpenEXR file. Nothing in the file is trusted: sizes are compared
 * with what the header says, and with what a file of this length can hold, before anything is allocated.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/checks/values.h"
#include "exr_common.h"
#include "header.h"
#include "material.h"
#include "parts.h"
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MAX_SIDE = 16 * BTF_MAX_SIZE, /* a contact sheet of 256 layers */
    MAX_RATIO = 2048,             /* texture bytes a byte of the file: deflate gives 1032 */
};

typedef struct source {
    const uint8_t *data;
    size_t size;
} source;

static int64_t read_bytes(exr_const_context_t context, void *user, void *buffer, uint64_t size,
                          uint64_t offset, exr_stream_error_func_ptr_t fail) {
    (void)context;
    (void)fail;
    const source *s = user;
    if (offset >= s->size) {
        return 0;
    }
    uint64_t count = s->size - offset < size ? s->size - offset : size;
    if (count) {
        memcpy(buffer, s->data + offset, (size_t)count);
    }
    return (int64_t)count;
}

static int64_t source_size(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((const source *)user)->size;
}

/* Fails with OpenEXR's own message. */
static btf_result fail_exr(const btf_log *log, exr_result_t result, const char *what) {
    if (result == EXR_ERR_OUT_OF_MEMORY) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "%s: out of memory", what);
    }
    return btfi_fail(log, BTF_ERROR_BAD_FILE, "%s: %s", what, btfi_exr_message(result));
}

static const exr_attr_chlist_entry_t *find_channel(const exr_attr_chlist_t *list, const char *name) {
    for (int i = 0; i < list->num_channels; i++) {
        if (list->entries[i].name.str && !strcmp(list->entries[i].name.str, name)) {
            return &list->entries[i];
        }
    }
    return NULL;
}

/* Parts of the file by index; -1 where the picture for viewers is missing, which need not be there. Any
 * other that is missing, unknown or repeated is refused. */
static btf_result find_parts(exr_const_context_t context, const btf_log *log, const btfi_part *parts,
                             int count, int index[BTFI_MAX_PARTS]) {
    int file_count = 0;
    exr_get_count(context, &file_count);
    for (int p = 0; p < count; p++) {
        index[p] = -1;
    }
    for (int f = 0; f < file_count; f++) {
        const char *name = NULL;
        if (exr_get_name(context, f, &name) != EXR_ERR_SUCCESS || !name) {
            return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %d has no name", f);
        }
        if (!strncmp(name, "x-", 2)) {
            continue;
        }
        int p = 0;
        while (p < count && strcmp(name, parts[p].name.text)) {
            p++;
        }
        if (p == count) {
            return btfi_fail(log, BTF_ERROR_BAD_FILE,
                             "part %.60s: unknown, or not in a material of these effects and levels", name);
        }
        if (index[p] >= 0) {
            return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %s: repeated", name);
        }
        index[p] = f;
    }
    for (int p = 0; p < count; p++) {
        if (index[p] < 0 && parts[p].id != BTF_TEXTURE_COUNT) {
            return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %s: missing", parts[p].name.text);
        }
    }
    return BTF_OK;
}

/* True when part `sbrdf` holds halves; false too when there is no such part. */
static bool sbrdf_is_half(exr_const_context_t context) {
    int count = 0;
    exr_get_count(context, &count);
    for (int f = 0; f < count; f++) {
        const char *name = NULL;
        const exr_attr_chlist_t *channels = NULL;
        if (exr_get_name(context, f, &name) == EXR_ERR_SUCCESS && name && !strcmp(name, "sbrdf") &&
            exr_get_channels(context, f, &channels) == EXR_ERR_SUCCESS && channels &&
            channels->num_channels > 0) {
            return channels->entries[0].pixel_type == EXR_PIXEL_HALF;
        }
    }
    return false;
}

static btf_result check_window(exr_const_context_t context, const btf_log *log, int index,
                               const btfi_part *part) {
    exr_attr_box2i_t w;
    if (exr_get_data_window(context, index, &w) != EXR_ERR_SUCCESS) {
        return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %s: no data window", part->name.text);
    }
    if (w.min.x != 0 || w.min.y != 0 || w.max.x != (int32_t)part->width - 1 ||
        w.max.y != (int32_t)part->height - 1) {
        return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %s: data window (%d,%d)-(%d,%d), not (0,0)-(%d,%d)",
                         part->name.text, (int)w.min.x, (int)w.min.y, (int)w.max.x, (int)w.max.y,
                         (int)part->width - 1, (int)part->height - 1);
    }
    return BTF_OK;
}

static btf_result check_channels(exr_const_context_t context, const btf_log *log, int index,
                                 const btfi_part *part) {
    const exr_attr_chlist_t *list = NULL;
    if (exr_get_channels(context, index, &list) != EXR_ERR_SUCCESS || !list) {
        return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %s: no channels", part->name.text);
    }
    const exr_pixel_type_t type = btfi_pixel_type(part->storage);
    for (int c = 0; c < part->channel_count; c++) {
        const exr_attr_chlist_entry_t *entry = find_channel(list, part->channels[c].name);
        if (!entry) {
            return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %s: channel %s is missing", part->name.text,
                             part->channels[c].name);
        }
        if (entry->pixel_type != type) {
            return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %s: channel %s is of type %d, not %d (%s)",
                             part->name.text, part->channels[c].name, (int)entry->pixel_type, (int)type,
                             type == EXR_PIXEL_FLOAT  ? "FLOAT"
                             : type == EXR_PIXEL_UINT ? "UINT"
                                                      : "HALF");
        }
        if (entry->x_sampling != 1 || entry->y_sampling != 1) {
            return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %s: channel %s is sampled %d x %d, not 1 x 1",
                             part->name.text, part->channels[c].name, (int)entry->x_sampling,
                             (int)entry->y_sampling);
        }
    }
    for (int i = 0; i < list->num_channels; i++) {
        const char *name = list->entries[i].name.str;
        int c = 0;
        while (c < part->channel_count && name && strcmp(name, part->channels[c].name)) {
            c++;
        }
        if (!name || c == part->channel_count) {
            return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %s: unknown channel %.60s", part->name.text,
                             name ? name : "without a name");
        }
    }
    if (list->num_channels != part->channel_count) {
        return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %s: a channel is repeated", part->name.text);
    }
    return BTF_OK;
}

static btf_result check_part(exr_const_context_t context, const btf_log *log, int index,
                             const btfi_part *part) {
    exr_storage_t storage;
    exr_compression_t compression;
    int32_t chunks, lines;
    exr_result_t exr;
    if ((exr = exr_get_storage(context, index, &storage)) ||
        (exr = exr_get_compression(context, index, &compression))) {
        return fail_exr(log, exr, part->name.text);
    }
    if (storage != EXR_STORAGE_SCANLINE) {
        return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %s: not a scan-line image (storage %d)",
                         part->name.text, (int)storage);
    }
    if (compression != EXR_COMPRESSION_NONE && compression != EXR_COMPRESSION_RLE &&
        compression != EXR_COMPRESSION_ZIPS && compression != EXR_COMPRESSION_ZIP &&
        compression != EXR_COMPRESSION_PIZ) {
        return btfi_fail(log, BTF_ERROR_BAD_FILE,
                         "part %s: compression %d is none of NONE, RLE, ZIPS, ZIP, PIZ", part->name.text,
                         (int)compression);
    }
    btf_result result;
    if ((result = check_window(context, log, index, part)) ||
        (result = check_channels(context, log, index, part))) {
        return result;
    }
    if ((exr = exr_get_chunk_count(context, index, &chunks)) ||
        (exr = exr_get_scanlines_per_chunk(context, index, &lines))) {
        return fail_exr(log, exr, part->name.text);
    }
    if (lines < 1 || chunks != ((int32_t)part->height + lines - 1) / lines) {
        return btfi_fail(log, BTF_ERROR_BAD_FILE, "part %s: %d chunks of %d lines do not make %u rows",
                         part->name.text, (int)chunks, (int)lines, (unsigned)part->height);
    }
    return BTF_OK;
}

/* Stores one row of one channel into the texture. Returns false, with the place, at a value that cannot be. */
static bool store_row(const btfi_part *part, void *texture, int channel, uint32_t y, const void *row,
                      uint32_t *out_x) {
    for (uint32_t x = 0; x < part->width;) {
        btfi_run run = btfi_part_run(part, channel, x, y);
        for (uint32_t i = 0; i < run.count; i++) {
            size_t at = run.offset + i * run.stride;
            if (part->storage == BTFI_STORAGE_FLOAT) {
                ((float *)texture)[at] = ((const float *)row)[x + i];
                continue;
            }
            if (part->storage == BTFI_STORAGE_UINT32) {
                const uint32_t word = ((const uint32_t *)row)[x + i];
                if (run.blank && word != 0) {
                    *out_x = x + i;
                    return false;
                }
                if (!run.blank) {
                    ((uint32_t *)texture)[at] = word;
                }
                continue;
            }
            uint16_t half = ((const uint16_t *)row)[x + i];
            if (part->storage == BTFI_STORAGE_HALF) {
                ((uint16_t *)texture)[at] = half;
                continue;
            }
            int32_t value = btfi_int_from_half(half);
            bool is_signed = part->storage == BTFI_STORAGE_INT8;
            if (value < (is_signed ? -127 : 0) || value > (is_signed ? 127 : 255) ||
                (run.blank && value != 0)) {
                *out_x = x + i;
                return false;
            }
            if (!run.blank) {
                ((uint8_t *)texture)[at] = (uint8_t)value;
            }
        }
        x += run.count;
    }
    return true;
}

static btf_result store_chunk(const btf_log *log, const btfi_part *part, void *texture, const uint8_t *rows,
                              size_t plane, const exr_chunk_info_t *chunk, uint32_t y) {
    const size_t row = part->width * btfi_pixel_size(part->storage);
    for (int c = 0; c < part->channel_count; c++) {
        for (uint32_t line = 0; line < (uint32_t)chunk->height; line++) {
            uint32_t x = 0;
            const void *data = rows + plane * (size_t)c + row * line;
            if (store_row(part, texture, c, y + line, data, &x)) {
                continue;
            }
            if (part->storage == BTFI_STORAGE_UINT32) {
                return btfi_fail(log, BTF_ERROR_BAD_FILE,
                                 "part %s: channel %s at (%u, %u) holds 0x%08x where no layer lies, not 0",
                                 part->name.text, part->channels[c].name, (unsigned)x, (unsigned)(y + line),
                                 (unsigned)((const uint32_t *)data)[x]);
            }
            return btfi_fail(
                log, BTF_ERROR_BAD_FILE,
                "part %s: channel %s at (%u, %u) holds half 0x%04x, not an integer of its range",
                part->name.text, part->channels[c].name, (unsigned)x, (unsigned)(y + line),
                (unsigned)((const uint16_t *)data)[x]);
        }
    }
    return BTF_OK;
}

static btf_result read_part(exr_const_context_t context, const btf_log *log, int index,
                            const btfi_part *part, void *texture) {
    int32_t lines = 0;
    exr_result_t exr = exr_get_scanlines_per_chunk(context, index, &lines);
    if (exr) {
        return fail_exr(log, exr, part->name.text);
    }
    const size_t pixel = btfi_pixel_size(part->storage), row = part->width * pixel,
                 plane = row * (size_t)lines;
    uint8_t *rows = calloc((size_t)part->channel_count, plane);
    if (!rows) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "%s: out of memory", part->name.text);
    }
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    btf_result result = BTF_OK;
    for (uint32_t y = 0; y < part->height && !exr && !result; y += (uint32_t)lines) {
        exr_chunk_info_t chunk;
        const int32_t left = (int32_t)(part->height - y), height = left < lines ? left : lines;
        exr = exr_read_scanline_chunk_info(context, index, (int)y, &chunk);
        if (!exr &&
            (chunk.start_y != (int32_t)y || chunk.height != height || chunk.width != (int32_t)part->width ||
             chunk.unpacked_size != row * (size_t)height * (size_t)part->channel_count)) {
            result = btfi_fail(log, BTF_ERROR_BAD_FILE,
                               "part %s: chunk of %d x %d at row %d, not %u x %d at row %u",
                               part->name.text, (int)chunk.width, (int)chunk.height, (int)chunk.start_y,
                               (unsigned)part->width, (int)height, (unsigned)y);
            break;
        }
        if (!exr) {
            exr = y == 0 ? exr_decoding_initialize(context, index, &chunk, &decode)
                         : exr_decoding_update(context, index, &chunk, &decode);
        }
        for (int i = 0; i < decode.channel_count && !exr; i++) {
            int c = 0;
            while (strcmp(decode.channels[i].channel_name, part->channels[c].name)) {
                c++;
            }
            decode.channels[i].decode_to_ptr = rows + plane * (size_t)c;
            decode.channels[i].user_pixel_stride = (int32_t)pixel;
            decode.channels[i].user_line_stride = (int32_t)row;
            decode.channels[i].user_bytes_per_element = (int16_t)pixel;
        }
        if (!exr && y == 0) {
            exr = exr_decoding_choose_default_routines(context, index, &decode);
        }
        if (!exr) {
            exr = exr_decoding_run(context, index, &decode);
        }
        if (!exr) {
            result = store_chunk(log, part, texture, rows, plane, &chunk, y);
        }
    }
    exr_decoding_destroy(context, &decode);
    free(rows);
    return exr ? fail_exr(log, exr, part->name.text) : result;
}

/* Refuses texture sizes that a file of this length cannot hold. */
static btf_result check_plausible(const btf_log *log, const source *s, const btf_material_info *info,
                                  bool preview) {
    uint64_t bytes = btfi_gpu_bytes(info) + (preview ? 8 * (uint64_t)info->width * info->height : 0);
    if (bytes / MAX_RATIO > s->size) {
        return btfi_fail(log, BTF_ERROR_BAD_FILE,
                         "%llu bytes of textures cannot come from a file of %zu bytes",
                         (unsigned long long)bytes, s->size);
    }
    return BTF_OK;
}

/* Scales lie in attributes, and in textures once read. */
static void place_scales(btf_material *m, const btfi_scales *scales) {
    const size_t units = m->info.components;
    if (scales->residual) {
        memcpy(m->texture[0][BTF_TEXTURE_RESIDUAL_SCALES], scales->residual, units * sizeof(float));
    }
    if (scales->factor) {
        memcpy(m->texture[0][BTF_TEXTURE_FACTOR_SCALES], scales->factor, 4 * units * sizeof(float));
    }
    float *views = m->texture[0][BTF_TEXTURE_FACTOR_VIEWS];
    for (size_t i = 0; scales->view && i < 9 * (size_t)m->info.n_views; i++) {
        views[i / 3 * 4 + i % 3] = scales->view[i];
    }
}

static btf_result read_textures(exr_const_context_t context, const btf_log *log, const source *s,
                                btf_material *m, const btfi_scales *scales) {
    int index[BTFI_MAX_PARTS], count;
    btfi_part *parts = btfi_parts(&m->info, m->info.version >= 2, &count);
    if (!parts) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "out of memory for the list of parts");
    }
    btf_result result = find_parts(context, log, parts, count, index);
    for (int p = 0; p < count && !result; p++) {
        if (index[p] >= 0) {
            result = check_part(context, log, index[p], &parts[p]);
        }
    }
    const bool preview = !result && count > 0 && parts[0].id == BTF_TEXTURE_COUNT && index[0] >= 0;
    if (!result) {
        result = check_plausible(log, s, &m->info, preview);
    }
    if (!result) {
        result = btfi_material_allocate(log, m);
    }
    if (!result && preview) {
        m->preview = calloc((size_t)m->info.width * m->info.height, 4 * sizeof *m->preview);
        if (!m->preview) {
            result = btfi_fail(log, BTF_ERROR_MEMORY, "preview: out of memory");
        }
    }
    for (int p = 0; p < count && !result; p++) {
        if (index[p] >= 0) {
            result = read_part(context, log, index[p], &parts[p],
                               parts[p].id == BTF_TEXTURE_COUNT ? m->preview
                                                                : m->texture[parts[p].level][parts[p].id]);
        }
    }
    free(parts);
    if (!result) {
        place_scales(m, scales);
    }
    if (!result) {
        result = btfi_material_make_vectors(log, scales->relief, m);
    }
    if (!result) {
        result = btfi_check_values(&(btfi_check){log, BTF_ERROR_BAD_FILE}, &m->info, m->texture);
    }
    return result;
}

static btf_result read_material(exr_const_context_t context, const btf_log *log, const source *s,
                                btf_material **out_material) {
    btf_material *m = btfi_material_new();
    if (!m) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "out of memory for a material");
    }
    btfi_scales scales = {0};
    btf_result result = btfi_header_read(context, log, m, &scales);
    if (!result) {
        m->info.half_float = m->info.colour != BTF_COLOUR_NONE && sbrdf_is_half(context);
        result = read_textures(context, log, s, m, &scales);
    }
    free(scales.residual);
    free(scales.factor);
    free(scales.view);
    free(scales.relief);
    if (result) {
        btf_material_close(&m);
        return result;
    }
    btfi_material_finish(m);
    *out_material = m;
    return BTF_OK;
}

btf_result btf_material_open_memory(const void *data, size_t size, const btf_log *log,
                                    btf_material **out_material) {
    *out_material = NULL;
    if (!data || size == 0) {
        return btfi_fail(log, BTF_ERROR_BAD_FILE, "empty file");
    }
    source s = {.data = data, .size = size};
    btfi_exr_clear_message();
    exr_context_t context = NULL;
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.error_handler_fn = btfi_exr_keep_message;
    start.user_data = &s;
    start.read_fn = read_bytes;
    start.size_fn = source_size;
    start.max_image_width = start.max_image_height = MAX_SIDE;
    start.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    exr_result_t exr = exr_start_read(&context, "material.btf.exr", &start);
    if (exr == EXR_ERR_SUCCESS && btfi_exr_was_out_of_memory()) {
        exr = EXR_ERR_OUT_OF_MEMORY;
    }
    btf_result result =
        exr ? fail_exr(log, exr, "not an OpenEXR file") : read_material(context, log, &s, out_material);
    if (context) {
        exr_finish(&context);
    }
    return result;
}
