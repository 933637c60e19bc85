/* OpenBTF: reading the header attributes of a file.
 *
 * SPDX-License-Identifier: MIT
 */
#include "header.h"

#include "decoder/checks/effect_errors.h"
#include "decoder/checks/info.h"
#include "decoder/checks/values.h"
#include "decoder/header/attributes.h"
#include "exr_common.h"
#include "shape.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char *get_provenance(btfi_attributes *r, const char *name) {
    size_t length;
    const char *text = btfi_get_string(r, name, false, &length);
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
static uint32_t get_effects(btfi_attributes *r, uint32_t known) {
    const char *const name = "openbtf.effects";
    size_t length;
    const char *text = btfi_get_string(r, name, true, &length);
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
        btfi_refuse(r, "attribute %s is \"%.*s\": unknown, repeated or out of order from \"%.*s\" on", name,
                    length < 60 ? (int)length : 60, text, length - at < 20 ? (int)(length - at) : 20,
                    text + at);
    }
    return effects;
}

/* Reads a list of at most `most` directions. */
static void get_directions(btfi_attributes *r, const char *list, const char *one, size_t most,
                           btfi_directions *d) {
    char name[64];
    size_t count;
    const btfi_check check = {r->log, BTF_ERROR_BAD_FILE};
#define NAME(format, word) (snprintf(name, sizeof name, "openbtf." format, word), name)
    const float *xyz = btfi_get_floats(r, NAME("%s", list), true, 3, most, &count);
    if (!xyz) {
        return;
    }
    d->count = (uint32_t)(count / 3);
    d->xyz = malloc(count * sizeof *d->xyz);
    if (!d->xyz) {
        btfi_out_of_memory(r, name);
        return;
    }
    memcpy(d->xyz, xyz, count * sizeof *xyz);
    d->vertices = btfi_get_integers(r, NAME("%sVertices", one), true, 2, d->count, 2 * BTFI_PLANE, &count);
    if (!r->result && count != 2 * (size_t)d->count) {
        btfi_refuse(r, "attribute %s holds %zu numbers, not 2 for each of %u directions", name, count,
                    (unsigned)d->count);
    }
    const unsigned last = d->count - 1;
    d->triangles =
        btfi_get_integers(r, NAME("%sTriangles", one), false, 3, 2 * (size_t)d->count, last, &count);
    d->triangle_count = (uint32_t)(count / 3);
    d->hull = btfi_get_integers(r, NAME("%sHull", one), false, 1, 2 * (size_t)d->count, last, &count);
    d->hull_count = (uint32_t)count;
    d->grid = btfi_get_int(r, NAME("%sGrid", one), 1, BTFI_MAX_GRID);
    d->cells = btfi_get_integers(r, NAME("%sCells", one), true, 1,
                                 BTFI_MAX_GRID * BTFI_MAX_GRID + BTFI_MAX_RECORDS, BTFI_MAX_RECORDS,
                                 &d->cells_length);
#undef NAME
    if (!r->result) {
        r->result = btfi_directions_check(&check, list, d);
    }
    if (!r->result) {
        r->result = btfi_directions_make_table(r->log, d);
    }
}

static void get_errors(btfi_attributes *r, btf_material *m) {
    size_t count;
    const float *rows = btfi_get_floats(r, "openbtf.errors", false, 4, 4096, &count);
    if (!rows) {
        return;
    }
    const uint32_t known = btfi_version_effects(btfi_version(&m->info));
    m->errors = malloc(count / 4 * sizeof *m->errors);
    if (!m->errors) {
        btfi_out_of_memory(r, "openbtf.errors");
        return;
    }
    for (size_t i = 0; i < count / 4; i++, rows += 4) {
        if (!(rows[0] >= 0 && rows[0] <= (float)known) || rows[0] != floorf(rows[0])) {
            btfi_refuse(r,
                        "attribute openbtf.errors: row %zu has the effects %g, of which bits are unknown",
                        i, (double)rows[0]);
            return;
        }
        m->errors[i] = (btf_material_error){(uint32_t)rows[0], rows[1], rows[2], rows[3]};
    }
    m->error_count = count / 4;
    r->result =
        btfi_check_errors(&(btfi_check){r->log, BTF_ERROR_BAD_FILE}, known, m->errors, m->error_count);
}

static void get_level_errors(btfi_attributes *r, btf_material *m) {
    const char *const name = "openbtf.levelErrors";
    size_t count;
    const float *rows = btfi_get_floats(r, name, false, 4, BTF_MAX_LEVELS, &count);
    if (!rows) {
        return;
    }
    m->level_errors = malloc(count / 4 * sizeof *m->level_errors);
    if (!m->level_errors) {
        btfi_out_of_memory(r, name);
        return;
    }
    for (size_t i = 0; i < count / 4; i++, rows += 4) {
        if (!(rows[0] >= 0 && rows[0] < BTF_MAX_LEVELS) || rows[0] != floorf(rows[0])) {
            btfi_refuse(r, "attribute %s: row %zu is of level %g, which no material has", name, i,
                        (double)rows[0]);
            return;
        }
        m->level_errors[i] = (btf_level_error){(uint32_t)rows[0], rows[1], rows[2], rows[3]};
    }
    m->level_error_count = count / 4;
    r->result = btfi_check_level_errors(&(btfi_check){r->log, BTF_ERROR_BAD_FILE}, m->info.levels,
                                        m->level_errors, m->level_error_count);
}

/* Room for 4096 rows of 5 + 2 * 16 * 16 numbers, and for the limits in front of them. */
enum { MOST_EFFECT_FLOATS = 1 << 22 };

static void get_effect_errors(btfi_attributes *r, btf_material *m) {
    const char *const name = "openbtf.effectErrors";
    size_t count;
    const float *values = btfi_get_floats(r, name, false, 1, MOST_EFFECT_FLOATS, &count);
    if (!values) {
        return;
    }
    r->result =
        btfi_check_effect_errors(&(btfi_check){r->log, BTF_ERROR_BAD_FILE}, &m->info, values, count);
    if (!r->result) {
        btfi_keep_floats(r, name, values, count, &m->effect_errors, &m->effect_error_count);
    }
}

static void get_effect_differences(btfi_attributes *r, btf_material *m) {
    const char *const name = "openbtf.effectDifferences";
    size_t count;
    const float *values = btfi_get_floats(r, name, false, 1, MOST_EFFECT_FLOATS, &count);
    if (!values) {
        return;
    }
    r->result =
        btfi_check_effect_differences(&(btfi_check){r->log, BTF_ERROR_BAD_FILE}, &m->info, values, count);
    if (!r->result) {
        btfi_keep_floats(r, name, values, count, &m->effect_differences, &m->effect_difference_count);
    }
}

/* Reads and checks a table of errors between the samples; NULL where the file has none, or it is refused. */
static const float *get_between_table(btfi_attributes *r, const btf_material_info *info, const char *name,
                                      btfi_between_table where, size_t *out_count) {
    const float *values = btfi_get_floats(r, name, false, 1, 1 << 20, out_count);
    if (values) {
        r->result = btfi_check_between_errors(&(btfi_check){r->log, BTF_ERROR_BAD_FILE}, info, where,
                                              values, *out_count);
    }
    return r->result ? NULL : values;
}

/* Both tables of errors between the samples become one: the rows of coarser levels follow those of level 0. */
static void get_between_errors(btfi_attributes *r, btf_material *m) {
    const char *const name = "openbtf.betweenErrors", *const level_name = "openbtf.levelBetweenErrors";
    size_t count = 0, level_count = 0;
    const float *values = get_between_table(r, &m->info, name, BTFI_BETWEEN_OF_LEVEL_0, &count),
                *of_levels = NULL;
    if (m->info.version >= 2) {
        of_levels =
            get_between_table(r, &m->info, level_name, BTFI_BETWEEN_OF_COARSER_LEVELS, &level_count);
    }
    if (r->result || !of_levels) {
        if (values && !r->result) {
            btfi_keep_floats(r, name, values, count, &m->between_errors, &m->between_error_count);
        }
        return;
    }
    if (!values) {
        btfi_keep_floats(r, level_name, of_levels, level_count, &m->between_errors,
                         &m->between_error_count);
        return;
    }
    const size_t head = btfi_table_head(of_levels);
    /* Counts of bands come first, so that no number beyond the other head is read. */
    for (size_t i = 0; i < head; i++) {
        if (of_levels[i] != values[i]) {
            btfi_refuse(r, "attribute %s: number %zu, of bands and their limits, is %g, but in %s it is %g",
                        level_name, i, (double)of_levels[i], name, (double)values[i]);
            return;
        }
    }
    m->between_errors = malloc((count + level_count - head) * sizeof *m->between_errors);
    if (!m->between_errors) {
        btfi_out_of_memory(r, level_name);
        return;
    }
    m->between_error_count = count + level_count - head;
    memcpy(m->between_errors, values, count * sizeof *values);
    memcpy(m->between_errors + count, of_levels + head, (level_count - head) * sizeof *values);
}

/* Reads exactly `group` numbers for each of `items` into *out. Where there are no items, the attribute is refused. */
static void get_scales(btfi_attributes *r, const char *name, size_t group, uint32_t items,
                       const char *things, float **out) {
    size_t count;
    if (items == 0) {
        if (!r->result && btfi_find_attribute(r, name, EXR_ATTR_FLOAT_VECTOR, "floatvector", false)) {
            btfi_refuse(r, "attribute %s is there, but there are no %s", name, things);
        }
        return;
    }
    const float *scales = btfi_get_floats(r, name, true, group, 1 << 16, &count);
    if (!scales) {
        return;
    }
    if (count != group * items) {
        btfi_refuse(r, "attribute %s holds %zu numbers, which do not fit the %u %s", name, count,
                    (unsigned)items, things);
        return;
    }
    btfi_keep_floats(r, name, scales, count, out, &count);
}

/* Reads the scales of the residual, whichever its store. */
static void get_all_scales(btfi_attributes *r, const btf_material_info *info, btfi_scales *out) {
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

/* Reads how a file of version 2 stores shift and gain. */
static void get_points(btfi_attributes *r, btf_material_info *info) {
    if (info->version < 2 ||
        !btfi_find_attribute(r, "openbtf.pointStore", EXR_ATTR_STRING, "string", false)) {
        return;
    }
    info->point_store = (btf_point_store)btfi_get_word(r, "openbtf.pointStore", btfi_point_words, 3);
    if (info->point_store == BTF_POINTS_SEPARATE) {
        return;
    }
    if (info->point_store == BTF_POINTS_LISTS) {
        info->point_entries = btfi_get_int(r, "openbtf.pointEntries", 1, BTF_MAX_POINT_ENTRIES);
    }
    const float base = btfi_get_float(r, "openbtf.gainBase"), step = btfi_get_float(r, "openbtf.gainStep");
    info->gain_base = base == 0 ? 0 : base; /* -0 becomes 0 */
    info->gain_step = step == 0 ? 0 : step;
}

/* Reads how a file of version 2 stores the residual and how its views are blended. In version 1 such attributes have no
 * meaning. */
static void get_factors(btfi_attributes *r, btf_material_info *info) {
    const char *const name = "openbtf.factorClasses";
    size_t count;
    info->horizon_scale = 1;
    if (info->version < 2) {
        return;
    }
    const float *numbers = btfi_get_floats(r, name, false, 3 * BTF_FACTOR_CLASSES, 1, &count);
    if (numbers) {
        info->store = BTF_STORE_FACTORS;
        info->horizon_scale = btfi_get_float(r, "openbtf.horizonScale");
        uint16_t *integers = btfi_copy_integers(r, name, numbers, count, 4 * BTF_MAX_COMPONENTS);
        for (size_t i = 0; integers && i < count; i++) {
            info->factor_classes[i / 3][i % 3] = integers[i];
        }
        free(integers);
    }
    if (btfi_find_attribute(r, "openbtf.blend", EXR_ATTR_STRING, "string", false)) {
        info->blend = (btf_blend)btfi_get_word(r, "openbtf.blend", btfi_blend_words, 2);
    }
}

/* Reads heights and the share of the half vector of a file of version 2, once its levels are known. Refuses those of an
 * effect that the file lacks. */
static void get_relief(btfi_attributes *r, btf_material_info *info) {
    static const char *const names[] = {"openbtf.reliefBase",  "openbtf.reliefStep", "openbtf.reliefSteps",
                                        "openbtf.reliefLevel", "openbtf.reliefEnd",  "openbtf.glossShare"};
    enum { COUNT = sizeof names / sizeof *names, GLOSS = COUNT - 1 };
    const bool relief = info->effects & BTF_EFFECT_RELIEF, gloss = info->effects & BTF_EFFECT_GLOSS;
    if (info->version < 2) {
        return;
    }
    for (int i = 0; i < COUNT; i++) {
        if (!(i < GLOSS ? relief : gloss) && btfi_find_attribute(r, names[i], EXR_ATTR_INT, "int", false)) {
            btfi_refuse(r, "attribute %s without the effect %s", names[i], i < GLOSS ? "relief" : "gloss");
        }
    }
    if (relief) {
        info->relief_base = (int32_t)btfi_get_int(r, names[0], INT16_MIN, INT16_MAX);
        info->relief_step = (int32_t)btfi_get_int(r, names[1], 0, INT16_MAX);
        info->relief_steps = btfi_get_int(r, names[2], 1, BTF_MAX_RELIEF_STEPS);
        info->relief_level = btfi_get_int_or(r, names[3], 0, BTF_MAX_LEVELS - 1, &(uint32_t){0});
        info->relief_end = btfi_get_int_or(r, names[4], 1, (int32_t)info->levels, &info->levels);
    }
    if (gloss) {
        info->gloss_share = btfi_get_int(r, names[GLOSS], 1, 2);
    }
}

/* Reads on which views of a file of version 2 relief acts, 0 or 1 each. */
static void get_relief_views(btfi_attributes *r, const btf_material_info *info, btfi_scales *out) {
    const char *const name = "openbtf.reliefViews";
    float *acts = NULL;
    if (info->version >= 2) {
        get_scales(r, name, 1, info->effects & BTF_EFFECT_RELIEF ? info->n_views : 0, "views of relief",
                   &acts);
    }
    if (acts && !(out->relief = malloc(info->n_views))) {
        btfi_out_of_memory(r, name);
    }
    for (uint32_t v = 0; out->relief && v < info->n_views; v++) {
        if (acts[v] != 0 && acts[v] != 1) {
            btfi_refuse(r, "attribute %s: number %u is %g, not 0 or 1", name, (unsigned)v, (double)acts[v]);
        }
        out->relief[v] = acts[v] != 0;
    }
    free(acts);
}

static uint32_t get_version(btfi_attributes *r) {
    const exr_attribute_t *attribute = NULL;
    if (exr_get_attribute_by_name(r->context, 0, "openbtf.version", &attribute) != EXR_ERR_SUCCESS ||
        !attribute) {
        btfi_refuse(r, "not an OpenBTF material: the attribute openbtf.version is missing");
    } else if (attribute->type == EXR_ATTR_INT && attribute->i > BTF_FORMAT_VERSION) {
        r->result = btfi_fail(r->log, BTF_ERROR_UNSUPPORTED,
                              "format version %d is newer than %d, the newest that this library reads",
                              (int)attribute->i, BTF_FORMAT_VERSION);
    } else {
        return btfi_get_int(r, "openbtf.version", 1, BTF_FORMAT_VERSION);
    }
    return 0;
}

btf_result btfi_header_read(exr_const_context_t context, const btf_log *log, btf_material *m,
                            btfi_scales *out_scales) {
    btfi_attributes r = {context, log, BTF_OK};
    btf_material_info *info = &m->info;
    info->version = get_version(&r);
    info->layout = (btf_layout)btfi_get_word(&r, "openbtf.layout", btfi_layout_words, 2);
    info->domain = (btf_domain)btfi_get_word(&r, "openbtf.domain", btfi_domain_words, 2);
    info->width = btfi_get_int(&r, "openbtf.width", 1, BTF_MAX_SIZE);
    info->height = btfi_get_int(&r, "openbtf.height", 1, BTF_MAX_SIZE);
    info->effects = get_effects(&r, btfi_version_effects(info->version));
    info->lobes = btfi_get_int(&r, "openbtf.lobes", 0, BTF_MAX_LOBES);
    info->colour = (btf_colour)btfi_get_word(&r, "openbtf.colour", btfi_colour_words, 3);
    info->centres = btfi_get_int(&r, "openbtf.centres", 0, BTF_MAX_CENTRES);
    info->components = btfi_get_int(&r, "openbtf.residual", 0, BTF_MAX_COMPONENTS);
    get_factors(&r, info);
    get_points(&r, info);
    info->levels = btfi_get_int_or(&r, "openbtf.levels", 1, BTF_MAX_LEVELS, &(uint32_t){1});
    get_relief(&r, info);
    info->radiance_scale = btfi_get_float(&r, "openbtf.radianceScale");
    info->shadow_scale = btfi_get_float(&r, "openbtf.shadowScale");
    info->gain_scale = btfi_get_float(&r, "openbtf.gainScale");
    info->centre_scale = btfi_get_float(&r, "openbtf.centreScale");
    if (!r.result && info->layout == BTF_LAYOUT_PAPER) {
        info->atlas_width = btfi_get_int(&r, "openbtf.atlasWidth", 1, BTF_MAX_SIZE);
        info->atlas_height = btfi_get_int(&r, "openbtf.atlasHeight", 1, BTF_MAX_SIZE);
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
