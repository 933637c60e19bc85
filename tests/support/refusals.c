/* Materials that must be accepted or refused. See refusals.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "refusals.h"

#include "test.h"

btf_material *create_accepted(const btf_material_desc *desc) {
    btf_material *material;
    last_message[0] = 0;
    const btf_result result = btf_material_create(desc, &log_keep, &material);
    if (result) {
        print_error("create: %s\n", last_message);
    }
    assert_int_equal(result, BTF_OK);
    return material;
}

static void assert_refused(btf_result result, btf_result code, const char *text,
                           const btf_material *material) {
    if (result != code || !strstr(last_message, text)) {
        print_error("expected \"%s\", got %d \"%s\"\n", text, (int)result, last_message);
    }
    assert_int_equal(result, code);
    assert_non_null(strstr(last_message, text));
    assert_null(material);
}

void create_refused(const btf_material_desc *desc, const char *text) {
    btf_material *material;
    last_message[0] = 0;
    const btf_result result = btf_material_create(desc, &log_keep, &material);
    assert_refused(result, BTF_ERROR_USAGE, text, material);
    assert_int_equal(btf_material_create(desc, NULL, &material), BTF_ERROR_USAGE);
}

btf_result open_edited(edit_file *file, btf_material **out_material) {
    void *data;
    size_t size;
    edit_save(file, &data, &size);
    edit_free(file);
    last_message[0] = 0;
    const btf_result result = btf_material_open_memory(data, size, &log_keep, out_material);
    assert_int_equal(result == BTF_OK, *out_material != NULL);
    free(data);
    return result;
}

saved save_material(const btf_material *material) {
    saved file;
    assert_int_equal(btf_material_save_memory(material, &log_keep, &file.data, &file.size), BTF_OK);
    return file;
}

edit_file *take(const saved *file) {
    return edit_load(file->data, file->size);
}

btf_material *open_accepted(edit_file *file) {
    btf_material *material;
    if (open_edited(file, &material)) {
        fail_msg("refused: %s", last_message);
    }
    return material;
}

void file_accepted(edit_file *file) {
    btf_material *material = open_accepted(file);
    btf_material_close(&material);
}

void refused_as(edit_file *file, btf_result code, const char *text) {
    btf_material *material;
    const btf_result result = open_edited(file, &material);
    assert_refused(result, code, text, material);
}

void file_refused(edit_file *file, const char *text) {
    refused_as(file, BTF_ERROR_BAD_FILE, text);
}

btf_material_info accepted_info(const btf_material *material) {
    btf_material_info info = {.struct_size = sizeof info};
    assert_int_equal(btf_material_get_info(material, &info), BTF_OK);
    return info;
}

bool accepted_texture(const btf_material *material, btf_texture_id id) {
    return btf_material_texture(material, id).format != BTF_FORMAT_NONE;
}

static edit_attribute *find_floats(edit_file *file, const char *name) {
    char full[64];
    snprintf(full, sizeof full, "openbtf.%s", name);
    return edit_find_attribute(file, full);
}

void number_refused(edit_file *file, const char *name, int index, float value, const char *text) {
    edit_attribute *a = find_floats(file, name);
    assert_true(index < a->count);
    a->values[index < 0 ? a->count + index : index] = value;
    file_refused(file, text);
}

void count_refused(edit_file *file, const char *name, int count, const char *text) {
    edit_attribute *a = find_floats(file, name);
    float *values = calloc((size_t)(count > 0 ? count : 1), sizeof *values);
    assert_non_null(values);
    memcpy(values, a->values, (size_t)(count < a->count ? count : a->count) * sizeof *values);
    free(a->values);
    a->values = values;
    a->count = count;
    file_refused(file, text);
}
