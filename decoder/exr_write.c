/* OpenBTF: a material as a multi-part OpenEXR file, in memory or on disk (FORMAT.md sections 2 and 7).
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/checks/effect_errors.h"
#include "exr_common.h"
#include "material.h"
#include "parts.h"
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Fixed, so that the same material gives the same bytes. */
enum { ZIP_LEVEL = 6 };

/* The file as it grows. */
typedef struct sink {
    uint8_t *data;
    size_t size, capacity;
    bool out_of_memory;
} sink;

static int64_t write_bytes(exr_const_context_t context, void *user, const void *buffer, uint64_t size,
                           uint64_t offset, exr_stream_error_func_ptr_t fail) {
    (void)context;
    (void)fail;
    sink *s = user;
    if (offset > SIZE_MAX / 2 || size > SIZE_MAX / 2) {
        s->out_of_memory = true;
        return -1;
    }
    size_t end = (size_t)offset + (size_t)size;
    if (end > s->capacity) {
        size_t capacity = s->capacity ? s->capacity : 65536;
        while (capacity < end) {
            capacity *= 2;
        }
        uint8_t *data = realloc(s->data, capacity);
        if (!data) {
            s->out_of_memory = true;
            return -1;
        }
        s->data = data;
        s->capacity = capacity;
    }
    if (offset > s->size) {
        memset(s->data + s->size, 0, (size_t)offset - s->size);
    }
    if (size) {
        memcpy(s->data + offset, buffer, (size_t)size);
    }
    if (end > s->size) {
        s->size = end;
    }
    return (int64_t)size;
}

/* Attributes of part 0; the first error sticks. */
typedef struct header {
    exr_context_t context;
    exr_result_t result;
} header;

static void put_int(header *h, const char *name, uint32_t value) {
    if (!h->result) {
        h->result = exr_attr_set_int(h->context, 0, name, (int32_t)value);
    }
}

static void put_float(header *h, const char *name, float value) {
    if (!h->result) {
        h->result = exr_attr_set_float(h->context, 0, name, value);
    }
}

static void put_string(header *h, const char *name, const char *value) {
    if (!h->result) {
        h->result = exr_attr_set_string(h->context, 0, name, value);
    }
}

static void put_floats(header *h, const char *name, const float *values, size_t count) {
    if (!h->result && count) {
        h->result = exr_attr_set_float_vector(h->context, 0, name, (int32_t)count, values);
    }
}

static void put_integers(header *h, const char *name, const uint16_t *values, size_t count) {
    if (h->result || !count) {
        return;
    }
    float *floats = malloc(count * sizeof *floats);
    if (!floats) {
        h->result = EXR_ERR_OUT_OF_MEMORY;
        return;
    }
    for (size_t i = 0; i < count; i++) {
        floats[i] = values[i];
    }
    put_floats(h, name, floats, count);
    free(floats);
}

static void put_directions(header *h, const btfi_directions *d, const char *list, const char *one) {
    char name[64];
#define NAME(format, word) (snprintf(name, sizeof name, "openbtf." format, word), name)
    put_floats(h, NAME("%s", list), d->xyz, 3 * (size_t)d->count);
    put_integers(h, NAME("%sVertices", one), d->vertices, 2 * (size_t)d->count);
    put_integers(h, NAME("%sTriangles", one), d->triangles, 3 * (size_t)d->triangle_count);
    put_integers(h, NAME("%sHull", one), d->hull, d->hull_count);
    put_int(h, NAME("%sGrid", one), d->grid);
    put_integers(h, NAME("%sCells", one), d->cells, d->cells_length);
#undef NAME
}

static void put_errors(header *h, const btf_material *m) {
    if (h->result || !m->error_count) {
        return;
    }
    float *rows = malloc(m->error_count * 4 * sizeof *rows);
    if (!rows) {
        h->result = EXR_ERR_OUT_OF_MEMORY;
        return;
    }
    for (size_t i = 0; i < m->error_count; i++) {
        rows[4 * i] = (float)m->errors[i].effects;
        rows[4 * i + 1] = m->errors[i].psnr_linear;
        rows[4 * i + 2] = m->errors[i].psnr_srgb;
        rows[4 * i + 3] = m->errors[i].gpu_bytes;
    }
    put_floats(h, "openbtf.errors", rows, 4 * m->error_count);
    free(rows);
}

static void put_level_errors(header *h, const btf_material *m) {
    float rows[4 * BTF_MAX_LEVELS];
    for (size_t i = 0; i < m->level_error_count; i++) {
        rows[4 * i] = (float)m->level_errors[i].level;
        rows[4 * i + 1] = m->level_errors[i].psnr_linear;
        rows[4 * i + 2] = m->level_errors[i].psnr_srgb;
        rows[4 * i + 3] = m->level_errors[i].gpu_bytes;
    }
    put_floats(h, "openbtf.levelErrors", rows, 4 * m->level_error_count);
}

/* Writes the rows of errors between the samples that are of level 0, or those of coarser levels, behind the bands and
 * limits of the table; without rows of coarser levels nothing for those. */
static void put_between_rows(header *h, const btf_material *m, bool coarser, const char *name) {
    const btf_between_errors b = btf_material_between_errors(m);
    if (h->result || !m->between_error_count) {
        return;
    }
    float *table = malloc(m->between_error_count * sizeof *table);
    if (!table) {
        h->result = EXR_ERR_OUT_OF_MEMORY;
        return;
    }
    const size_t head = btfi_table_head(m->between_errors);
    size_t count = head;
    memcpy(table, m->between_errors, head * sizeof *table);
    for (uint32_t r = 0; r < b.row_count; r++) {
        const float *row = b.rows + (size_t)r * b.row_stride;
        if ((row[0] >= BTF_BETWEEN_NEXT_LEVEL) == coarser) {
            memcpy(table + count, row, b.row_stride * sizeof *table);
            count += b.row_stride;
        }
    }
    put_floats(h, name, table, coarser && count == head ? 0 : count);
    free(table);
}

static void put_factors(header *h, const btf_material *m) {
    const btf_material_info *info = &m->info;
    float classes[3 * BTF_FACTOR_CLASSES];
    for (int i = 0; i < 3 * BTF_FACTOR_CLASSES; i++) {
        classes[i] = (float)info->factor_classes[i / 3][i % 3];
    }
    put_floats(h, "openbtf.factorClasses", classes, 3 * BTF_FACTOR_CLASSES);
    put_floats(h, "openbtf.factorScales", m->texture[0][BTF_TEXTURE_FACTOR_SCALES],
               4 * (size_t)info->components);
    const float *texels = m->texture[0][BTF_TEXTURE_FACTOR_VIEWS];
    float *views = malloc(9 * (size_t)info->n_views * sizeof *views);
    if (!views && !h->result) {
        h->result = EXR_ERR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; views && i < 9 * (size_t)info->n_views; i++) {
        views[i] = texels[i / 3 * 4 + i % 3];
    }
    put_floats(h, "openbtf.factorViews", views, 9 * (size_t)info->n_views);
    free(views);
    put_float(h, "openbtf.horizonScale", info->horizon_scale);
}

static void put_relief(header *h, const btf_material *m) {
    const btf_material_info *info = &m->info;
    put_int(h, "openbtf.reliefBase", (uint32_t)info->relief_base);
    put_int(h, "openbtf.reliefStep", (uint32_t)info->relief_step);
    put_int(h, "openbtf.reliefSteps", info->relief_steps);
    if (info->relief_level > 0) {
        put_int(h, "openbtf.reliefLevel", info->relief_level);
    }
    if (info->relief_end < info->levels) {
        put_int(h, "openbtf.reliefEnd", info->relief_end);
    }
    float *acts = malloc(info->n_views * sizeof *acts);
    if (!acts && !h->result) {
        h->result = EXR_ERR_OUT_OF_MEMORY;
    }
    for (size_t v = 0; acts && v < info->n_views; v++) {
        acts[v] = m->view_vectors[4 * v + 3];
    }
    put_floats(h, "openbtf.reliefViews", acts, info->n_views);
    free(acts);
}

static exr_result_t write_attributes(exr_context_t context, const btf_material *m) {
    const btf_material_info *info = &m->info;
    header h = {context, EXR_ERR_SUCCESS};
    char effects[64];
    btfi_effects_text(info->effects, effects, sizeof effects);

    put_int(&h, "openbtf.version", info->version);
    put_string(&h, "openbtf.layout", btfi_layout_words[info->layout]);
    put_string(&h, "openbtf.domain", btfi_domain_words[info->domain]);
    put_int(&h, "openbtf.width", info->width);
    put_int(&h, "openbtf.height", info->height);
    put_string(&h, "openbtf.effects", effects);
    put_int(&h, "openbtf.lobes", info->lobes);
    put_string(&h, "openbtf.colour", btfi_colour_words[info->colour]);
    put_int(&h, "openbtf.centres", info->centres);
    put_int(&h, "openbtf.residual", info->components);
    if (info->store == BTF_STORE_FACTORS) {
        put_factors(&h, m);
    } else {
        put_floats(&h, "openbtf.residualScales", m->texture[0][BTF_TEXTURE_RESIDUAL_SCALES],
                   info->components);
    }
    if (info->blend != BTF_BLEND_RADIANCE) {
        put_string(&h, "openbtf.blend", btfi_blend_words[info->blend]);
    }
    if (info->point_store != BTF_POINTS_SEPARATE) {
        put_string(&h, "openbtf.pointStore", btfi_point_words[info->point_store]);
        if (info->point_store == BTF_POINTS_LISTS) {
            put_int(&h, "openbtf.pointEntries", info->point_entries);
        }
        put_float(&h, "openbtf.gainBase", info->gain_base);
        put_float(&h, "openbtf.gainStep", info->gain_step);
    }
    if (info->effects & BTF_EFFECT_RELIEF) {
        put_relief(&h, m);
    }
    if (info->effects & BTF_EFFECT_GLOSS) {
        put_int(&h, "openbtf.glossShare", info->gloss_share);
    }
    put_float(&h, "openbtf.radianceScale", info->radiance_scale);
    put_float(&h, "openbtf.shadowScale", info->shadow_scale);
    put_float(&h, "openbtf.gainScale", info->gain_scale);
    put_float(&h, "openbtf.centreScale", info->centre_scale);
    if (info->layout == BTF_LAYOUT_PAPER) {
        put_int(&h, "openbtf.atlasWidth", info->atlas_width);
        put_int(&h, "openbtf.atlasHeight", info->atlas_height);
    }
    put_directions(&h, &m->views, "views", "view");
    put_directions(&h, &m->lights, "lights", "light");
    if (*m->method) {
        put_string(&h, "openbtf.method", m->method);
    }
    if (*m->options) {
        put_string(&h, "openbtf.options", m->options);
    }
    if (*m->source) {
        put_string(&h, "openbtf.source", m->source);
    }
    put_errors(&h, m);
    if (info->levels > 1) {
        put_int(&h, "openbtf.levels", info->levels);
    }
    put_level_errors(&h, m);
    put_floats(&h, "openbtf.effectErrors", m->effect_errors, m->effect_error_count);
    put_floats(&h, "openbtf.effectDifferences", m->effect_differences, m->effect_difference_count);
    put_between_rows(&h, m, false, "openbtf.betweenErrors");
    put_between_rows(&h, m, true, "openbtf.levelBetweenErrors");
    return h.result;
}

static exr_result_t declare_parts(exr_context_t context, const btfi_part *parts, int count) {
    const exr_attr_v2f_t centre = {.x = 0, .y = 0};
    exr_attr_box2i_t display = {.min = {.x = 0, .y = 0}, .max = {.x = 0, .y = 0}};
    for (int p = 0; p < count; p++) {
        if (display.max.x < (int32_t)parts[p].width - 1) {
            display.max.x = (int32_t)parts[p].width - 1;
        }
        if (display.max.y < (int32_t)parts[p].height - 1) {
            display.max.y = (int32_t)parts[p].height - 1;
        }
    }
    for (int p = 0; p < count; p++) {
        int index;
        exr_result_t result = exr_add_part(context, parts[p].name.text, EXR_STORAGE_SCANLINE, &index);
        exr_attr_box2i_t data = {
            .min = {.x = 0, .y = 0},
            .max = {.x = (int32_t)parts[p].width - 1, .y = (int32_t)parts[p].height - 1}};
        if (!result) {
            result = exr_initialize_required_attr(context, index, &display, &data, 1, &centre, 1,
                                                  EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP);
        }
        const exr_pixel_type_t type = btfi_pixel_type(parts[p].storage);
        for (int c = 0; c < parts[p].channel_count && !result; c++) {
            result = exr_add_channel(context, index, parts[p].channels[c].name, type,
                                     EXR_PERCEPTUALLY_LINEAR, 1, 1);
        }
        if (result) {
            return result;
        }
    }
    return EXR_ERR_SUCCESS;
}

/* One row of one channel as pixels of the file. */
static void fetch_row(const btfi_part *part, const void *texture, int channel, uint32_t y, void *out) {
    for (uint32_t x = 0; x < part->width;) {
        btfi_run run = btfi_part_run(part, channel, x, y);
        for (uint32_t i = 0; i < run.count; i++) {
            size_t at = run.offset + i * run.stride;
            if (part->storage == BTFI_STORAGE_FLOAT) {
                ((float *)out)[x + i] = run.blank ? 0 : ((const float *)texture)[at];
            } else if (part->storage == BTFI_STORAGE_UINT32) {
                ((uint32_t *)out)[x + i] = run.blank ? 0 : ((const uint32_t *)texture)[at];
            } else if (run.blank) {
                ((uint16_t *)out)[x + i] = 0;
            } else if (part->storage == BTFI_STORAGE_HALF) {
                ((uint16_t *)out)[x + i] = ((const uint16_t *)texture)[at];
            } else if (part->storage == BTFI_STORAGE_UINT8) {
                ((uint16_t *)out)[x + i] = btfi_half_from_int(((const uint8_t *)texture)[at]);
            } else {
                ((uint16_t *)out)[x + i] = btfi_half_from_int(((const int8_t *)texture)[at]);
            }
        }
        x += run.count;
    }
}

/* OpenEXR 3.1.5 keeps deflated data also when they are exactly as long as the plain ones, which readers
 * (its own too) then take for plain. Such chunks are written plain. `encoding_user_data` points to
 * OpenEXR's routine. */
typedef struct compressor {
    exr_result_t (*run)(exr_encode_pipeline_t *encode);
} compressor;

static exr_result_t compress_or_keep(exr_encode_pipeline_t *encode) {
    const compressor *default_routine = encode->encoding_user_data;
    exr_result_t result = default_routine->run(encode);
    if (!result && encode->compressed_bytes >= encode->packed_bytes) {
        memcpy(encode->compressed_buffer, encode->packed_buffer, encode->packed_bytes);
        encode->compressed_bytes = encode->packed_bytes;
    }
    return result;
}

static exr_result_t write_part(exr_context_t context, int index, const btfi_part *part,
                               const void *texture) {
    int32_t lines;
    exr_result_t result = exr_get_scanlines_per_chunk(context, index, &lines);
    if (result) {
        return result;
    }
    const size_t pixel = btfi_pixel_size(part->storage), row = part->width * pixel,
                 plane = row * (size_t)lines;
    uint8_t *rows = malloc(plane * (size_t)part->channel_count);
    if (!rows) {
        return EXR_ERR_OUT_OF_MEMORY;
    }
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    compressor default_routine;
    for (uint32_t y = 0; y < part->height && !result; y += (uint32_t)lines) {
        exr_chunk_info_t chunk;
        result = exr_write_scanline_chunk_info(context, index, (int)y, &chunk);
        if (!result) {
            result = y == 0 ? exr_encoding_initialize(context, index, &chunk, &encode)
                            : exr_encoding_update(context, index, &chunk, &encode);
        }
        for (int c = 0; c < part->channel_count && !result; c++) {
            exr_coding_channel_info_t *to = NULL;
            for (int i = 0; i < encode.channel_count; i++) {
                if (!strcmp(encode.channels[i].channel_name, part->channels[c].name)) {
                    to = &encode.channels[i];
                }
            }
            assert(to);
            uint8_t *data = rows + plane * (size_t)c;
            for (int32_t line = 0; line < chunk.height; line++) {
                fetch_row(part, texture, c, y + (uint32_t)line, data + row * (size_t)line);
            }
            to->encode_from_ptr = data;
            to->user_pixel_stride = (int32_t)pixel;
            to->user_line_stride = (int32_t)row;
            to->user_bytes_per_element = (int16_t)pixel;
        }
        if (!result && y == 0) {
            result = exr_encoding_choose_default_routines(context, index, &encode);
            default_routine.run = encode.compress_fn;
            encode.compress_fn = compress_or_keep;
            encode.encoding_user_data = &default_routine;
        }
        if (!result) {
            result = exr_encoding_run(context, index, &encode);
        }
    }
    exr_encoding_destroy(context, &encode);
    free(rows);
    return result;
}

static exr_result_t write_all(exr_context_t context, const btf_material *m) {
    int count;
    btfi_part *parts = btfi_parts(&m->info, m->preview != NULL, &count);
    if (!parts) {
        return EXR_ERR_OUT_OF_MEMORY;
    }
    exr_result_t result = declare_parts(context, parts, count);
    if (!result) {
        result = write_attributes(context, m);
    }
    if (!result) {
        result = exr_write_header(context);
    }
    for (int p = 0; p < count && !result; p++) {
        result = write_part(context, p, &parts[p],
                            parts[p].id == BTF_TEXTURE_COUNT ? m->preview
                                                             : m->texture[parts[p].level][parts[p].id]);
    }
    free(parts);
    return result;
}

btf_result btf_material_save_memory(const btf_material *material, const btf_log *log, void **out_data,
                                    size_t *out_size) {
    *out_data = NULL;
    *out_size = 0;
    sink s = {0};
    btfi_exr_clear_message();
    exr_context_t context = NULL;
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.error_handler_fn = btfi_exr_keep_message;
    start.user_data = &s;
    start.write_fn = write_bytes;
    start.zip_level = ZIP_LEVEL;
    exr_result_t result = exr_start_write(&context, "material.btf.exr", EXR_WRITE_FILE_DIRECTLY, &start);
    if (!result) {
        result = write_all(context, material);
    }
    if (context) {
        exr_result_t end = exr_finish(&context);
        result = result ? result : end;
    }
    if (result) {
        free(s.data);
        if (s.out_of_memory || result == EXR_ERR_OUT_OF_MEMORY) {
            return btfi_fail(log, BTF_ERROR_MEMORY, "out of memory while writing the material");
        }
        return btfi_fail(log, BTF_ERROR_INTERNAL, "OpenEXR could not write the material: %s",
                         btfi_exr_message(result));
    }
    *out_data = s.data;
    *out_size = s.size;
    return BTF_OK;
}
