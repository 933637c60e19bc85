/* OpenBTF: reading the header attributes of a file.
 *
 * SPDX-License-Identifier: MIT
 */
#include "header.h"

#include "decoder/checks/effect_errors.h"
#include "decoder/checks/info.h"
#include "decoder/checks/values.h"
#include "exr_common.h"
#include "shape.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A string of provenance longer than this is refused. */
enum { MAX_STRING = 1 << 20 };

/* The first error sticks, and makes the rest do nothing. */
typedef struct reader {
    exr_const_context_t context;
    const btf_log *log;
    btf_result result;
} reader;

static void __attribute__((format(printf, 2, 3))) refuse(reader *r, const char *format, ...) {
    char message[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (!r->result) {
        r->result = btfi_fail(r->log, BTF_ERROR_BAD_FILE, "%s", message);
    }
}

/* The attribute, or NULL when it is absent (refused if required) or of another type (refused). */
static const exr_attribute_t *find(reader *r, const char *name, exr_attribute_type_t type,
                                   const char *type_name, bool required) {
    const exr_attribute_t *attribute = NULL;
    if (r->result) {
        return NULL;
    }
    if (exr_get_attribute_by_name(r->context, 0, name, &attribute) != EXR_ERR_SUCCESS || !attribute) {
        if (required) {
            refuse(r, "attribute %s is missing", name);
        }
        return NULL;
    }
    if (attribute->type != type) {
        refuse(r, "attribute %s is of type %s, not %s", name,
               attribute->type_name ? attribute->type_name : "unknown", type_name);
        return NULL;
    }
    return attribute;
}

static uint32_t get_int_or(reader *r, const char *name, int32_t low, int32_t high, const uint32_t *absent) {
    const exr_attribute_t *attribute = find(r, name, EXR_ATTR_INT, "int", !absent);
    if (!attribute) {
        return absent ? *absent : 0;
    }
    if (attribute->i < low || attribute->i > high) {
        refuse(r, "attribute %s is %d, not within %d to %d", name, (int)attribute->i, (int)low, (int)high);
        return 0;
    }
    return (uint32_t)attribute->i;
}

static uint32_t get_int(reader *r, const char *name, int32_t low, int32_t high) {
    return get_int_or(r, name, low, high, NULL);
}

static float get_float(reader *r, const char *name) {
    const exr_attribute_t *attribute = find(r, name, EXR_ATTR_FLOAT, "float", true);
    return attribute ? attribute->f : 0;
}

/* The text up to its first zero; *out_length without it. NULL when absent. */
static const char *get_string(reader *r, const char *name, bool required, size_t *out_length) {
    const exr_attribute_t *attribute = find(r, name, EXR_ATTR_STRING, "string", required);
    *out_length = 0;
    if (!attribute || !attribute->string || !attribute->string->str || attribute->string->length < 0) {
        return attribute ? "" : NULL;
    }
    if (attribute->string->length > MAX_STRING) {
        refuse(r, "attribute %s has %d bytes, more than %d", name, (int)attribute->string->length,
               MAX_STRING);
        return NULL;
    }
    *out_length = strnlen(attribute->string->str, (size_t)attribute->string->length);
    return attribute->string->str;
}

static int get_word(reader *r, const char *name, const char *const *words, int count) {
    size_t length;
    const char *text = get_string(r, name, true, &length);
    if (!text) {
        return 0;
    }
    for (int i = 0; i < count; i++) {
        if (strlen(words[i]) == length && !memcmp(words[i], text, length)) {
            return i;
        }
    }
    refuse(r, "attribute %s is \"%.*s\", which is unknown", name, length < 40 ? (int)length : 40, text);
    return 0;
}

static char *get_provenance(reader *r, const char *name) {
    size_t length;
    const char *text = get_string(r, name, false, &length);
    if (r->result) {
        return NULL;
    }
    char *copy = btfi_copy_string(text, text ? length : 0);
    if (!copy) {
        r->result = btfi_fail(r->log, BTF_ERROR_MEMORY, "out of memory for attribute %s", name);
    }
    return copy;
}

/* Reads the list of effects; known: those that the file's version has. */
static uint32_t get_effects(reader *r, uint32_t known) {
    const char *const name = "openbtf.effects";
    size_t length;
    const char *text = get_string(r, name, true, &length);
    if (!text) {
        return 0;
    }
    uint32_t effects = 0;
    size_t at = 0;
    for (int i = 0; btfi_effect_name(i) && 1u << i & known && at < length; i++) {
        const char *word = btfi_effect_name(i);
        size_t size = strlen(word);
        if (length - at < size || memcmp(text + at, word, size) ||
            (at + size < length && (text[at + size] != ',' || at + size + 1 == length))) {
            continue;
        }
        effects |= 1u << i;
        at += size + (at + size < length);
    }
    if (at < length) {
        refuse(r, "attribute %s is \"%.*s\": unknown, repeated or out of order from \"%.*s\" on", name,
               length < 60 ? (int)length : 60, text, length - at < 20 ? (int)(length - at) : 20, text + at);
    }
    return effects;
}

/* Numbers of a floatvector; *out_count is a multiple of `group`, at most group * most. NULL when absent. */
static const float *get_floats(reader *r, const char *name, bool required, size_t group, size_t most,
                               size_t *out_count) {
    const exr_attribute_t *attribute = find(r, name, EXR_ATTR_FLOAT_VECTOR, "floatvector", required);
    *out_count = 0;
    if (!attribute) {
        return NULL;
    }
    const exr_attr_float_vector_t *v = attribute->floatvector;
    size_t count = v && v->length > 0 && v->arr ? (size_t)v->length : 0;
    if (count == 0 || count % group != 0 || count > group * most) {
        refuse(r, "attribute %s holds %zu numbers, which are not 1 to %zu groups of %zu", name, count, most,
               group);
        return NULL;
    }
    *out_count = count;
    return v->arr;
}

static void out_of_memory(reader *r, const char *name) {
    r->result = btfi_fail(r->log, BTF_ERROR_MEMORY, "out of memory for attribute %s", name);
}

/* Copies integers 0..high, which is at most 65535. */
static uint16_t *copy_integers(reader *r, const char *name, const float *values, size_t count,
                               unsigned high) {
    uint16_t *out = malloc(count * sizeof *out);
    if (!out) {
        out_of_memory(r, name);
        return NULL;
    }
    for (size_t i = 0; i < count; i++) {
        if (!(values[i] >= 0 && values[i] <= (float)high) || values[i] != floorf(values[i])) {
            refuse(r, "attribute %s: number %zu is %g, not an integer within 0 to %u", name, i,
                   (double)values[i], high);
            free(out);
            return NULL;
        }
        out[i] = (uint16_t)values[i];
    }
    return out;
}

static uint16_t *get_integers(reader *r, const char *name, bool required, size_t group, size_t most,
                              unsigned high, size_t *out_count) {
    const float *values = get_floats(r, name, required, group, most, out_count);
    return values ? copy_integers(r, name, values, *out_count, high) : NULL;
}

/* A list of at most `most` directions. */
static void get_directions(reader *r, const char *list, const char *one, size_t most, btfi_directions *d) {
    char name[64];
    size_t count;
    const btfi_check check = {r->log, BTF_ERROR_BAD_FILE};
#define NAME(format, word) (snprintf(name, sizeof name, "openbtf." format, word), name)
    const float *xyz = get_floats(r, NAME("%s", list), true, 3, most, &count);
    if (!xyz) {
        return;
    }
    d->count = (uint32_t)(count / 3);
    d->xyz = malloc(count * sizeof *d->xyz);
    if (!d->xyz) {
        out_of_memory(r, name);
        return;
    }
    memcpy(d->xyz, xyz, count * sizeof *xyz);
    d->vertices = get_integers(r, NAME("%sVertices", one), true, 2, d->count, 2 * BTFI_PLANE, &count);
    if (!r->result && count != 2 * (size_t)d->count) {
        refuse(r, "attribute %s holds %zu numbers, not 2 for each of %u directions", name, count,
               (unsigned)d->count);
    }
    const unsigned last = d->count - 1;
    d->triangles = get_integers(r, NAME("%sTriangles", one), false, 3, 2 * (size_t)d->count, last, &count);
    d->triangle_count = (uint32_t)(count / 3);
    d->hull = get_integers(r, NAME("%sHull", one), false, 1, 2 * (size_t)d->count, last, &count);
    d->hull_count = (uint32_t)count;
    d->grid = get_int(r, NAME("%sGrid", one), 1, BTFI_MAX_GRID);
    d->cells =
        get_integers(r, NAME("%sCells", one), true, 1, BTFI_MAX_GRID * BTFI_MAX_GRID + BTFI_MAX_RECORDS,
                     BTFI_MAX_RECORDS, &d->cells_length);
#undef NAME
    if (!r->result) {
        r->result = btfi_directions_check(&check, list, d);
    }
    if (!r->result) {
        r->result = btfi_directions_make_table(r->log, d);
    }
}

static void get_errors(reader *r, btf_material *m) {
    size_t count;
    const float *rows = get_floats(r, "openbtf.errors", false, 4, 4096, &count);
    if (!rows) {
        return;
    }
    const uint32_t known = btfi_version_effects(btfi_version(&m->info));
    m->errors = malloc(count / 4 * sizeof *m->errors);
    if (!m->errors) {
        out_of_memory(r, "openbtf.errors");
        return;
    }
    for (size_t i = 0; i < count / 4; i++, rows += 4) {
        if (!(rows[0] >= 0 && rows[0] <= (float)known) || rows[0] != floorf(rows[0])) {
            refuse(r, "attribute openbtf.errors: row %zu has the effects %g, of which bits are unknown", i,
                   (double)rows[0]);
            return;
        }
        m->errors[i] = (btf_material_error){(uint32_t)rows[0], rows[1], rows[2], rows[3]};
    }
    m->error_count = count / 4;
    r->result =
        btfi_check_errors(&(btfi_check){r->log, BTF_ERROR_BAD_FILE}, known, m->errors, m->error_count);
}

static void get_level_errors(reader *r, btf_material *m) {
    const char *const name = "openbtf.levelErrors";
    size_t count;
    const float *rows = get_floats(r, name, false, 4, BTF_MAX_LEVELS, &count);
    if (!rows) {
        return;
    }
    m->level_errors = malloc(count / 4 * sizeof *m->level_errors);
    if (!m->level_errors) {
        out_of_memory(r, name);
        return;
    }
    for (size_t i = 0; i < count / 4; i++, rows += 4) {
        if (!(rows[0] >= 0 && rows[0] < BTF_MAX_LEVELS) || rows[0] != floorf(rows[0])) {
            refuse(r, "attribute %s: row %zu is of level %g, which no material has", name, i,
                   (double)rows[0]);
            return;
        }
        m->level_errors[i] = (btf_level_error){(uint32_t)rows[0], rows[1], rows[2], rows[3]};
    }
    m->level_error_count = count / 4;
    r->result = btfi_check_level_errors(&(btfi_check){r->log, BTF_ERROR_BAD_FILE}, m->info.levels,
                                        m->level_errors, m->level_error_count);
}

/* A copy of numbers that were checked: into *out and *out_count. */
static void keep_floats(reader *r, const char *name, const float *values, size_t count, float **out,
                        size_t *out_count) {
    *out = malloc(count * sizeof *values);
    if (!*out) {
        out_of_memory(r, name);
        return;
    }
    memcpy(*out, values, count * sizeof *values);
    *out_count = count;
}

/* Room for 4096 rows of 5 + 2 * 16 * 16 numbers, and for the limits in front of them. */
enum { MOST_EFFECT_FLOATS = 1 << 22 };

static void get_effect_errors(reader *r, btf_material *m) {
    const char *const name = "openbtf.effectErrors";
    size_t count;
    const float *values = get_floats(r, name, false, 1, MOST_EFFECT_FLOATS, &count);
    if (!values) {
        return;
    }
    r->result =
        btfi_check_effect_errors(&(btfi_check){r->log, BTF_ERROR_BAD_FILE}, &m->info, values, count);
    if (!r->result) {
        keep_floats(r, name, values, count, &m->effect_errors, &m->effect_error_count);
    }
}

static void get_effect_differences(reader *r, btf_material *m) {
    const char *const name = "openbtf.effectDifferences";
    size_t count;
    const float *values = get_floats(r, name, false, 1, MOST_EFFECT_FLOATS, &count);
    if (!values) {
        return;
    }
    r->result =
        btfi_check_effect_differences(&(btfi_check){r->log, BTF_ERROR_BAD_FILE}, &m->info, values, count);
    if (!r->result) {
        keep_floats(r, name, values, count, &m->effect_differences, &m->effect_difference_count);
    }
}

static void get_between_errors(reader *r, btf_material *m) {
    const char *const name = "openbtf.betweenErrors";
    size_t count;
    const float *values = get_floats(r, name, false, 1, 1 << 20, &count);
    if (!values) {
        return;
    }
    r->result =
        btfi_check_between_errors(&(btfi_check){r->log, BTF_ERROR_BAD_FILE}, &m->info, values, count);
    if (!r->result) {
        keep_floats(r, name, values, count, &m->between_errors, &m->between_error_count);
    }
}

/* Exactly `group` numbers for each of `items`, into *out; nothing may be there when items are 0. */
static void get_scales(reader *r, const char *name, size_t group, uint32_t items, const char *things,
                       float **out) {
    size_t count;
    if (items == 0) {
        if (!r->result && find(r, name, EXR_ATTR_FLOAT_VECTOR, "floatvector", false)) {
            refuse(r, "attribute %s is there, but there are no %s", name, things);
        }
        return;
    }
    const float *scales = get_floats(r, name, true, group, 1 << 16, &count);
    if (!scales) {
        return;
    }
    if (count != group * items) {
        refuse(r, "attribute %s holds %zu numbers, which do not fit the %u %s", name, count,
               (unsigned)items, things);
        return;
    }
    keep_floats(r, name, scales, count, out, &count);
}

/* Scales of the residual, whichever its store. */
static void get_all_scales(reader *r, const btf_material_info *info, btfi_scales *out) {
    const bool factors = info->store == BTF_STORE_FACTORS;
    get_scales(r, "openbtf.residualScales", 1, factors ? 0 : info->components, "components of the residual",
               &out->residual);
    if (info->version < 2) {
        return;
    }
    get_scales(r, "openbtf.factorScales", 4, factors ? info->components : 0, "units of factors",
               &out->factor);
    get_scales(r, "openbtf.factorViews", 9, factors ? info->n_views : 0, "views of factors", &out->view);
}

/* Version 2: the store of shift and gain. */
static void get_points(reader *r, btf_material_info *info) {
    if (info->version < 2 || !find(r, "openbtf.pointStore", EXR_ATTR_STRING, "string", false)) {
        return;
    }
    info->point_store = (btf_point_store)get_word(r, "openbtf.pointStore", btfi_point_words, 3);
    if (info->point_store == BTF_POINTS_SEPARATE) {
        return;
    }
    if (info->point_store == BTF_POINTS_LISTS) {
        info->point_entries = get_int(r, "openbtf.pointEntries", 1, BTF_MAX_POINT_ENTRIES);
    }
    const float base = get_float(r, "openbtf.gainBase"), step = get_float(r, "openbtf.gainStep");
    info->gain_base = base == 0 ? 0 : base; /* -0 becomes 0 */
    info->gain_step = step == 0 ? 0 : step;
}

/* Version 2: the store of the residual and how views are blended. In version 1 such attributes have no
 * meaning. */
static void get_factors(reader *r, btf_material_info *info) {
    const char *const name = "openbtf.factorClasses";
    size_t count;
    info->horizon_scale = 1;
    if (info->version < 2) {
        return;
    }
    const float *numbers = get_floats(r, name, false, 3 * BTF_FACTOR_CLASSES, 1, &count);
    if (numbers) {
        info->store = BTF_STORE_FACTORS;
        info->horizon_scale = get_float(r, "openbtf.horizonScale");
        uint16_t *integers = copy_integers(r, name, numbers, count, 4 * BTF_MAX_COMPONENTS);
        for (size_t i = 0; integers && i < count; i++) {
            info->factor_classes[i / 3][i % 3] = integers[i];
        }
        free(integers);
    }
    if (find(r, "openbtf.blend", EXR_ATTR_STRING, "string", false)) {
        info->blend = (btf_blend)get_word(r, "openbtf.blend", btfi_blend_words, 2);
    }
}

/* Version 2: heights and the share of the half vector, once the levels are known. Those of an effect that
 * the file has not are refused. */
static void get_relief(reader *r, btf_material_info *info) {
    static const char *const names[] = {"openbtf.reliefBase",  "openbtf.reliefStep", "openbtf.reliefSteps",
                                        "openbtf.reliefLevel", "openbtf.reliefEnd",  "openbtf.glossShare"};
    enum { COUNT = sizeof names / sizeof *names, GLOSS = COUNT - 1 };
    const bool relief = info->effects & BTF_EFFECT_RELIEF, gloss = info->effects & BTF_EFFECT_GLOSS;
    if (info->version < 2) {
        return;
    }
    for (int i = 0; i < COUNT; i++) {
        if (!(i < GLOSS ? relief : gloss) && find(r, names[i], EXR_ATTR_INT, "int", false)) {
            refuse(r, "attribute %s without the effect %s", names[i], i < GLOSS ? "relief" : "gloss");
        }
    }
    if (relief) {
        info->relief_base = (int32_t)get_int(r, names[0], INT16_MIN, INT16_MAX);
        info->relief_step = (int32_t)get_int(r, names[1], 0, INT16_MAX);
        info->relief_steps = get_int(r, names[2], 1, BTF_MAX_RELIEF_STEPS);
        info->relief_level = get_int_or(r, names[3], 0, BTF_MAX_LEVELS - 1, &(uint32_t){0});
        info->relief_end = get_int_or(r, names[4], 1, (int32_t)info->levels, &info->levels);
    }
    if (gloss) {
        info->gloss_share = get_int(r, names[GLOSS], 1, 2);
    }
}

/* Version 2: which views relief acts on, 0 or 1 each. */
static void get_relief_views(reader *r, const btf_material_info *info, btfi_scales *out) {
    const char *const name = "openbtf.reliefViews";
    float *acts = NULL;
    if (info->version >= 2) {
        get_scales(r, name, 1, info->effects & BTF_EFFECT_RELIEF ? info->n_views : 0, "views of relief",
                   &acts);
    }
    if (acts && !(out->relief = malloc(info->n_views))) {
        out_of_memory(r, name);
    }
    for (uint32_t v = 0; out->relief && v < info->n_views; v++) {
        if (acts[v] != 0 && acts[v] != 1) {
            refuse(r, "attribute %s: number %u is %g, not 0 or 1", name, (unsigned)v, (double)acts[v]);
        }
        out->relief[v] = acts[v] != 0;
    }
    free(acts);
}

static uint32_t get_version(reader *r) {
    const exr_attribute_t *attribute = NULL;
    if (exr_get_attribute_by_name(r->context, 0, "openbtf.version", &attribute) != EXR_ERR_SUCCESS ||
        !attribute) {
        refuse(r, "not an OpenBTF material: the attribute openbtf.version is missing");
    } else if (attribute->type == EXR_ATTR_INT && attribute->i > BTF_FORMAT_VERSION) {
        r->result = btfi_fail(r->log, BTF_ERROR_UNSUPPORTED,
                              "format version %d is newer than %d, the newest that this library reads",
                              (int)attribute->i, BTF_FORMAT_VERSION);
    } else {
        return get_int(r, "openbtf.version", 1, BTF_FORMAT_VERSION);
    }
    return 0;
}

btf_result btfi_header_read(exr_const_context_t context, const btf_log *log, btf_material *m,
                            btfi_scales *out_scales) {
    reader r = {context, log, BTF_OK};
    btf_material_info *info = &m->info;
    info->version = get_version(&r);
    info->layout = (btf_layout)get_word(&r, "openbtf.layout", btfi_layout_words, 2);
    info->domain = (btf_domain)get_word(&r, "openbtf.domain", btfi_domain_words, 2);
    info->width = get_int(&r, "openbtf.width", 1, BTF_MAX_SIZE);
    info->height = get_int(&r, "openbtf.height", 1, BTF_MAX_SIZE);
    info->effects = get_effects(&r, btfi_version_effects(info->version));
    info->lobes = get_int(&r, "openbtf.lobes", 0, BTF_MAX_LOBES);
    info->colour = (btf_colour)get_word(&r, "openbtf.colour", btfi_colour_words, 3);
    info->centres = get_int(&r, "openbtf.centres", 0, BTF_MAX_CENTRES);
    info->components = get_int(&r, "openbtf.residual", 0, BTF_MAX_COMPONENTS);
    get_factors(&r, info);
    get_points(&r, info);
    info->levels = get_int_or(&r, "openbtf.levels", 1, BTF_MAX_LEVELS, &(uint32_t){1});
    get_relief(&r, info);
    info->radiance_scale = get_float(&r, "openbtf.radianceScale");
    info->shadow_scale = get_float(&r, "openbtf.shadowScale");
    info->gain_scale = get_float(&r, "openbtf.gainScale");
    info->centre_scale = get_float(&r, "openbtf.centreScale");
    if (!r.result && info->layout == BTF_LAYOUT_PAPER) {
        info->atlas_width = get_int(&r, "openbtf.atlasWidth", 1, BTF_MAX_SIZE);
        info->atlas_height = get_int(&r, "openbtf.atlasHeight", 1, BTF_MAX_SIZE);
    }
    const size_t most = info->version < 2 ? BTF_MAX_DIRECTION_LAYERS : BTF_MAX_DIRECTIONS;
    get_directions(&r, "views", "view", most, &m->views);
    get_directions(&r, "lights", "light", most, &m->lights);
    info->n_views = m->views.count;
    info->n_lights = m->lights.count;
    if (!r.result) {
        r.result = btfi_check_info(&(btfi_check){log, BTF_ERROR_BAD_FILE}, info);
    }
    get_all_scales(&r, info, out_scales);
    get_relief_views(&r, info, out_scales);
    m->method = get_provenance(&r, "openbtf.method");
    m->options = get_provenance(&r, "openbtf.options");
    m->source = get_provenance(&r, "openbtf.source");
    get_errors(&r, m);
    get_level_errors(&r, m);
    get_effect_errors(&r, m);
    get_effect_differences(&r, m);
    get_between_errors(&r, m);
    return r.result;
}
