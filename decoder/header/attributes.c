/* OpenBTF: reading attributes of part 0 by type. See attributes.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "attributes.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A string of provenance longer than this is refused. */
enum { MAX_STRING = 1 << 20 };

void btfi_refuse(btfi_attributes *r, const char *format, ...) {
    char message[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (!r->result) {
        r->result = btfi_fail(r->log, BTF_ERROR_BAD_FILE, "%s", message);
    }
}

const exr_attribute_t *btfi_find_attribute(btfi_attributes *r, const char *name, exr_attribute_type_t type,
                                           const char *type_name, bool required) {
    const exr_attribute_t *attribute = NULL;
    if (r->result) {
        return NULL;
    }
    if (exr_get_attribute_by_name(r->context, 0, name, &attribute) != EXR_ERR_SUCCESS || !attribute) {
        if (required) {
            btfi_refuse(r, "attribute %s is missing", name);
        }
        return NULL;
    }
    if (attribute->type != type) {
        btfi_refuse(r, "attribute %s is of type %s, not %s", name,
                    attribute->type_name ? attribute->type_name : "unknown", type_name);
        return NULL;
    }
    return attribute;
}

uint32_t btfi_get_int_or(btfi_attributes *r, const char *name, int32_t low, int32_t high,
                         const uint32_t *absent) {
    const exr_attribute_t *attribute = btfi_find_attribute(r, name, EXR_ATTR_INT, "int", !absent);
    if (!attribute) {
        return absent ? *absent : 0;
    }
    if (attribute->i < low || attribute->i > high) {
        btfi_refuse(r, "attribute %s is %d, not within %d to %d", name, (int)attribute->i, (int)low,
                    (int)high);
        return 0;
    }
    return (uint32_t)attribute->i;
}

uint32_t btfi_get_int(btfi_attributes *r, const char *name, int32_t low, int32_t high) {
    return btfi_get_int_or(r, name, low, high, NULL);
}

float btfi_get_float(btfi_attributes *r, const char *name) {
    const exr_attribute_t *attribute = btfi_find_attribute(r, name, EXR_ATTR_FLOAT, "float", true);
    return attribute ? attribute->f : 0;
}

const char *btfi_get_string(btfi_attributes *r, const char *name, bool required, size_t *out_length) {
    const exr_attribute_t *attribute = btfi_find_attribute(r, name, EXR_ATTR_STRING, "string", required);
    *out_length = 0;
    if (!attribute || !attribute->string || !attribute->string->str || attribute->string->length < 0) {
        return attribute ? "" : NULL;
    }
    if (attribute->string->length > MAX_STRING) {
        btfi_refuse(r, "attribute %s has %d bytes, more than %d", name, (int)attribute->string->length,
                    MAX_STRING);
        return NULL;
    }
    *out_length = strnlen(attribute->string->str, (size_t)attribute->string->length);
    return attribute->string->str;
}

int btfi_get_word(btfi_attributes *r, const char *name, const char *const *words, int count) {
    size_t length;
    const char *text = btfi_get_string(r, name, true, &length);
    if (!text) {
        return 0;
    }
    for (int i = 0; i < count; i++) {
        if (strlen(words[i]) == length && !memcmp(words[i], text, length)) {
            return i;
        }
    }
    btfi_refuse(r, "attribute %s is \"%.*s\", which is unknown", name, length < 40 ? (int)length : 40,
                text);
    return 0;
}

const float *btfi_get_floats(btfi_attributes *r, const char *name, bool required, size_t group, size_t most,
                             size_t *out_count) {
    const exr_attribute_t *attribute =
        btfi_find_attribute(r, name, EXR_ATTR_FLOAT_VECTOR, "floatvector", required);
    *out_count = 0;
    if (!attribute) {
        return NULL;
    }
    const exr_attr_float_vector_t *v = attribute->floatvector;
    size_t count = v && v->length > 0 && v->arr ? (size_t)v->length : 0;
    if (count == 0 || count % group != 0 || count > group * most) {
        btfi_refuse(r, "attribute %s holds %zu numbers, which are not 1 to %zu groups of %zu", name, count,
                    most, group);
        return NULL;
    }
    *out_count = count;
    return v->arr;
}

void btfi_out_of_memory(btfi_attributes *r, const char *name) {
    r->result = btfi_fail(r->log, BTF_ERROR_MEMORY, "out of memory for attribute %s", name);
}

uint16_t *btfi_copy_integers(btfi_attributes *r, const char *name, const float *values, size_t count,
                             unsigned high) {
    uint16_t *out = malloc(count * sizeof *out);
    if (!out) {
        btfi_out_of_memory(r, name);
        return NULL;
    }
    for (size_t i = 0; i < count; i++) {
        if (!(values[i] >= 0 && values[i] <= (float)high) || values[i] != floorf(values[i])) {
            btfi_refuse(r, "attribute %s: number %zu is %g, not an integer within 0 to %u", name, i,
                        (double)values[i], high);
            free(out);
            return NULL;
        }
        out[i] = (uint16_t)values[i];
    }
    return out;
}

uint16_t *btfi_get_integers(btfi_attributes *r, const char *name, bool required, size_t group, size_t most,
                            unsigned high, size_t *out_count) {
    const float *values = btfi_get_floats(r, name, required, group, most, out_count);
    return values ? btfi_copy_integers(r, name, values, *out_count, high) : NULL;
}

void btfi_keep_floats(btfi_attributes *r, const char *name, const float *values, size_t count, float **out,
                      size_t *out_count) {
    *out = malloc(count * sizeof *values);
    if (!*out) {
        btfi_out_of_memory(r, name);
        return;
    }
    memcpy(*out, values, count * sizeof *values);
    *out_count = count;
}
