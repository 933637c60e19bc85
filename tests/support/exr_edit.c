/* OpenEXR files taken apart, changed and put together again.
 *
 * SPDX-License-Identifier: MIT
 */
#include "exr_edit.h"
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void must(bool good, const char *what) {
    if (!good) {
        fprintf(stderr, "exr_edit: %s\n", what);
        abort();
    }
}

static void check(exr_result_t result, const char *what) {
    must(result == EXR_ERR_SUCCESS, what);
}

static void *allocate(size_t size) {
    void *memory = calloc(1, size ? size : 1);
    must(memory != NULL, "out of memory");
    return memory;
}

static size_t pixel_size(exr_pixel_type_t type) {
    return type == EXR_PIXEL_HALF ? 2 : 4;
}

static void set_name(char out[40], const char *name) {
    snprintf(out, 40, "%s", name);
}

/* A file in memory. */
typedef struct memory {
    uint8_t *data;
    size_t size, capacity;
} memory;

static int64_t read_bytes(exr_const_context_t context, void *user, void *buffer, uint64_t size,
                          uint64_t offset, exr_stream_error_func_ptr_t fail) {
    (void)context;
    (void)fail;
    const memory *m = user;
    must(offset <= m->size, "read beyond the end");
    const uint64_t count =
        size < m->size - offset ? size : m->size - offset; /* the header is read in blocks */
    memcpy(buffer, m->data + offset, count);
    return (int64_t)count;
}

static int64_t memory_size(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((const memory *)user)->size;
}

static int64_t write_bytes(exr_const_context_t context, void *user, const void *buffer, uint64_t size,
                           uint64_t offset, exr_stream_error_func_ptr_t fail) {
    (void)context;
    (void)fail;
    memory *m = user;
    if (offset + size > m->capacity) {
        m->capacity = 2 * (offset + size) + 1000;
        m->data = realloc(m->data, m->capacity);
        must(m->data != NULL, "out of memory");
    }
    memcpy(m->data + offset, buffer, size);
    m->size = offset + size > m->size ? offset + size : m->size;
    return (int64_t)size;
}

static void load_part(exr_context_t context, int index, edit_part *part) {
    const char *name = NULL;
    exr_attr_box2i_t window, display;
    const exr_attr_chlist_t *list = NULL;
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    int32_t lines;
    check(exr_get_name(context, index, &name), "name");
    set_name(part->name, name);
    check(exr_get_data_window(context, index, &window), "window");
    check(exr_get_display_window(context, index, &display), "display window");
    check(exr_get_compression(context, index, &part->compression), "compression");
    check(exr_get_channels(context, index, &list), "channels");
    check(exr_get_scanlines_per_chunk(context, index, &lines), "lines");
    part->display_width = display.max.x + 1;
    part->display_height = display.max.y + 1;
    part->width = window.max.x + 1;
    part->height = window.max.y + 1;
    for (int c = 0; c < list->num_channels; c++) {
        edit_add_channel(part, list->entries[c].name.str, list->entries[c].pixel_type);
    }
    for (int y = 0; y < part->height; y += lines) {
        exr_chunk_info_t chunk;
        check(exr_read_scanline_chunk_info(context, index, y, &chunk), "chunk");
        check(exr_decoding_initialize(context, index, &chunk, &decode), "decode");
        for (int c = 0; c < decode.channel_count; c++) {
            size_t size = pixel_size(part->channels[c].type), row = size * (size_t)part->width;
            decode.channels[c].decode_to_ptr = part->channels[c].data + row * (size_t)y;
            decode.channels[c].user_pixel_stride = (int32_t)size;
            decode.channels[c].user_line_stride = (int32_t)row;
        }
        check(exr_decoding_choose_default_routines(context, index, &decode), "routines");
        check(exr_decoding_run(context, index, &decode), "pixels");
        exr_decoding_destroy(context, &decode);
    }
}

static void load_attribute(const exr_attribute_t *from, edit_attribute *to) {
    set_name(to->name, from->name);
    to->type = from->type;
    switch (from->type) {
    case EXR_ATTR_INT:
        to->i = from->i;
        break;
    case EXR_ATTR_FLOAT:
        to->f = from->f;
        break;
    case EXR_ATTR_STRING:
        to->text = allocate((size_t)from->string->length + 1);
        memcpy(to->text, from->string->str, (size_t)from->string->length);
        break;
    case EXR_ATTR_FLOAT_VECTOR:
        to->count = from->floatvector->length;
        to->values = allocate((size_t)to->count * sizeof *to->values);
        memcpy(to->values, from->floatvector->arr, (size_t)to->count * sizeof *to->values);
        break;
    default:
        must(false, "attribute type");
    }
}

edit_file *edit_load(const void *data, size_t size) {
    edit_file *file = allocate(sizeof *file);
    memory m = {(uint8_t *)(uintptr_t)data, size, size};
    exr_context_t context = NULL;
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.user_data = &m;
    start.read_fn = read_bytes;
    start.size_fn = memory_size;
    check(exr_start_read(&context, "edit", &start), "start");
    check(exr_get_count(context, &file->part_count), "count");
    for (int p = 0; p < file->part_count; p++) {
        load_part(context, p, &file->parts[p]);
    }
    int32_t count;
    check(exr_get_attribute_count(context, 0, &count), "attributes");
    for (int32_t i = 0; i < count; i++) {
        const exr_attribute_t *attribute = NULL;
        check(exr_get_attribute_by_index(context, 0, EXR_ATTR_LIST_FILE_ORDER, i, &attribute), "attribute");
        if (!strncmp(attribute->name, "openbtf.", 8)) {
            load_attribute(attribute, &file->attributes[file->attribute_count++]);
        }
    }
    exr_finish(&context);
    return file;
}

static void save_attribute(exr_context_t context, const edit_attribute *a) {
    switch (a->type) {
    case EXR_ATTR_INT:
        check(exr_attr_set_int(context, 0, a->name, a->i), "set int");
        break;
    case EXR_ATTR_FLOAT:
        check(exr_attr_set_float(context, 0, a->name, a->f), "set float");
        break;
    case EXR_ATTR_STRING:
        check(exr_attr_set_string(context, 0, a->name, a->text), "set string");
        break;
    case EXR_ATTR_FLOAT_VECTOR:
        check(exr_attr_set_float_vector(context, 0, a->name, a->count, a->values), "set floats");
        break;
    default:
        check(exr_attr_set_double(context, 0, a->name, 1.0), "set double");
    }
}

static void declare_part(exr_context_t context, const edit_part *part) {
    int index;
    check(exr_add_part(context, part->name, EXR_STORAGE_SCANLINE, &index), "part");
    exr_attr_box2i_t data = {
        .min = {.x = part->min_x, .y = part->min_y},
        .max = {.x = part->min_x + part->width - 1, .y = part->min_y + part->height - 1}};
    exr_attr_box2i_t display = {.min = {.x = 0, .y = 0},
                                .max = {.x = part->display_width - 1, .y = part->display_height - 1}};
    const exr_attr_v2f_t centre = {.x = 0, .y = 0};
    check(exr_initialize_required_attr(context, index, &display, &data, 1, &centre, 1, part->order,
                                       part->compression),
          "required attributes");
    for (int c = 0; c < part->channel_count; c++) {
        check(exr_add_channel(context, index, part->channels[c].name, part->channels[c].type,
                              EXR_PERCEPTUALLY_LINEAR, 1, 1),
              "channel");
    }
}

static exr_result_t (*default_compress)(exr_encode_pipeline_t *encode);

/* As exr_write.c in the library: chunks that do not shrink are kept plain. */
static exr_result_t compress_or_keep(exr_encode_pipeline_t *encode) {
    exr_result_t result = default_compress(encode);
    if (!result && encode->compressed_bytes >= encode->packed_bytes) {
        memcpy(encode->compressed_buffer, encode->packed_buffer, encode->packed_bytes);
        encode->compressed_bytes = encode->packed_bytes;
    }
    return result;
}

static void save_part(exr_context_t context, int index, const edit_part *part) {
    int32_t lines;
    check(exr_get_scanlines_per_chunk(context, index, &lines), "lines");
    int chunks = (part->height + lines - 1) / lines;
    for (int i = 0; i < chunks; i++) {
        int y = i * lines;
        exr_chunk_info_t chunk;
        exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
        check(exr_write_scanline_chunk_info(context, index, part->min_y + y, &chunk), "chunk");
        check(exr_encoding_initialize(context, index, &chunk, &encode), "encode");
        for (int e = 0; e < encode.channel_count; e++) {
            int c = 0;
            while (strcmp(part->channels[c].name, encode.channels[e].channel_name)) {
                c++;
            }
            size_t size = pixel_size(part->channels[c].type), row = size * (size_t)part->width;
            encode.channels[e].encode_from_ptr = part->channels[c].data + row * (size_t)y;
            encode.channels[e].user_pixel_stride = (int32_t)size;
            encode.channels[e].user_line_stride = (int32_t)row;
        }
        check(exr_encoding_choose_default_routines(context, index, &encode), "routines");
        if (encode.compress_fn) {
            default_compress = encode.compress_fn;
            encode.compress_fn = compress_or_keep;
        }
        check(exr_encoding_run(context, index, &encode), "pixels");
        exr_encoding_destroy(context, &encode);
    }
}

void edit_save(const edit_file *file, void **out_data, size_t *out_size) {
    memory m = {0};
    exr_context_t context = NULL;
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.user_data = &m;
    start.write_fn = write_bytes;
    check(exr_start_write(&context, "edit", EXR_WRITE_FILE_DIRECTLY, &start), "start");
    for (int p = 0; p < file->part_count; p++) {
        declare_part(context, &file->parts[p]);
    }
    for (int i = 0; i < file->attribute_count; i++) {
        save_attribute(context, &file->attributes[i]);
    }
    check(exr_write_header(context), "header");
    for (int p = 0; p < file->part_count; p++) {
        save_part(context, p, &file->parts[p]);
    }
    check(exr_finish(&context), "finish");
    *out_data = m.data;
    *out_size = m.size;
}

static void clear_part(edit_part *part) {
    for (int c = 0; c < part->channel_count; c++) {
        free(part->channels[c].data);
    }
    part->channel_count = 0;
}

static void clear_attribute(edit_attribute *attribute) {
    free(attribute->text);
    free(attribute->values);
}

void edit_free(edit_file *file) {
    for (int p = 0; p < file->part_count; p++) {
        clear_part(&file->parts[p]);
    }
    for (int i = 0; i < file->attribute_count; i++) {
        clear_attribute(&file->attributes[i]);
    }
    free(file);
}

edit_attribute *edit_find_attribute(edit_file *file, const char *name) {
    for (int i = 0; i < file->attribute_count; i++) {
        if (!strcmp(file->attributes[i].name, name)) {
            return &file->attributes[i];
        }
    }
    must(false, name);
    return NULL;
}

void edit_remove_attribute(edit_file *file, const char *name) {
    edit_attribute *attribute = edit_find_attribute(file, name);
    clear_attribute(attribute);
    *attribute = file->attributes[--file->attribute_count];
}

edit_part *edit_find_part(edit_file *file, const char *name) {
    for (int p = 0; p < file->part_count; p++) {
        if (!strcmp(file->parts[p].name, name)) {
            return &file->parts[p];
        }
    }
    must(false, name);
    return NULL;
}

edit_channel *edit_find_channel(edit_file *file, const char *part, const char *channel) {
    edit_part *p = edit_find_part(file, part);
    for (int c = 0; c < p->channel_count; c++) {
        if (!strcmp(p->channels[c].name, channel)) {
            return &p->channels[c];
        }
    }
    must(false, channel);
    return NULL;
}

void edit_copy_part(edit_file *file, const char *name, const char *new_name) {
    must(file->part_count < EDIT_PARTS, "too many parts");
    const edit_part *from = edit_find_part(file, name);
    edit_part *to = &file->parts[file->part_count++];
    *to = *from;
    set_name(to->name, new_name);
    for (int c = 0; c < to->channel_count; c++) {
        size_t size = pixel_size(to->channels[c].type) * (size_t)to->width * (size_t)to->height;
        to->channels[c].data = allocate(size);
        memcpy(to->channels[c].data, from->channels[c].data, size);
    }
}

void edit_add_channel(edit_part *part, const char *name, exr_pixel_type_t type) {
    must(part->channel_count < EDIT_CHANNELS, "too many channels");
    edit_channel *channel = &part->channels[part->channel_count++];
    set_name(channel->name, name);
    channel->type = type;
    channel->data = allocate(pixel_size(type) * (size_t)part->width * (size_t)part->height);
}

void edit_remove_part(edit_file *file, const char *name) {
    edit_part *part = edit_find_part(file, name);
    clear_part(part);
    *part = file->parts[--file->part_count];
}

void edit_remove_channel(edit_part *part, const char *name) {
    for (int c = 0; c < part->channel_count; c++) {
        if (!strcmp(part->channels[c].name, name)) {
            free(part->channels[c].data);
            part->channels[c] = part->channels[--part->channel_count];
            return;
        }
    }
    must(false, name);
}

void edit_resize(edit_part *part, int width, int height) {
    part->width = width;
    part->height = height;
    for (int c = 0; c < part->channel_count; c++) {
        free(part->channels[c].data);
        part->channels[c].data =
            allocate(pixel_size(part->channels[c].type) * (size_t)width * (size_t)height);
    }
}

void edit_set_text(edit_file *file, const char *name, const char *text) {
    edit_attribute *a = edit_find_attribute(file, name);
    free(a->text);
    a->text = strdup(text);
}
