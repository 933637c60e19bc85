/* OpenBTF: a material in memory: made from an encoder's textures, looked into, freed.
 *
 * SPDX-License-Identifier: MIT
 */
#include "material.h"

#include "decoder/checks/effect_errors.h"
#include "decoder/checks/info.h"
#include "decoder/checks/values.h"
#include "shape.h"
#include <stdlib.h>
#include <string.h>

char *btfi_copy_string(const char *text, size_t length) {
    char *copy = malloc(length + 1);
    if (copy) {
        if (length) {
            memcpy(copy, text, length);
        }
        copy[length] = 0;
    }
    return copy;
}

void btf_free(void *pointer) {
    free(pointer);
}

btf_material *btfi_material_new(void) {
    return calloc(1, sizeof(btf_material));
}

void btf_material_close(btf_material **material) {
    if (!material || !*material) {
        return;
    }
    btf_material *m = *material;
    for (int level = 0; level < BTF_MAX_LEVELS; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            free(m->texture[level][id]);
        }
    }
    btfi_directions_clear(&m->views);
    btfi_directions_clear(&m->lights);
    free(m->errors);
    free(m->level_errors);
    free(m->effect_errors);
    free(m->effect_differences);
    free(m->between_errors);
    free(m->preview);
    free(m->view_vectors);
    free(m->method);
    free(m->options);
    free(m->source);
    free(m);
    *material = NULL;
}

btf_result btfi_material_make_vectors(const btf_log *log, const uint8_t *acts, btf_material *m) {
    const size_t views = m->info.n_views;
    if (!(m->info.effects & BTFI_VECTOR_EFFECTS)) {
        return BTF_OK;
    }
    m->view_vectors = calloc(views, 4 * sizeof *m->view_vectors);
    if (!m->view_vectors) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "view_vectors: out of memory for %zu views", views);
    }
    for (size_t v = 0; v < views; v++) {
        memcpy(m->view_vectors + 4 * v, m->views.xyz + 3 * v, 3 * sizeof *m->view_vectors);
        m->view_vectors[4 * v + 3] = m->info.effects & BTF_EFFECT_RELIEF && (!acts || acts[v]) ? 1 : 0;
    }
    return BTF_OK;
}

btf_result btfi_material_allocate(const btf_log *log, btf_material *m) {
    for (uint32_t level = 0; level < m->info.levels; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            size_t size = btf_material_level_shape(&m->info, level, (btf_texture_id)id).size;
            if (size == 0) {
                continue;
            }
            m->texture[level][id] = calloc(1, size);
            if (!m->texture[level][id]) {
                return btfi_fail(log, BTF_ERROR_MEMORY, "%s: out of memory for %zu bytes",
                                 btfi_texture_name(level, (btf_texture_id)id).text, size);
            }
        }
    }
    return BTF_OK;
}

void btfi_material_finish(btf_material *m) {
    m->info.struct_size = sizeof m->info;
    m->info.gpu_bytes = btfi_gpu_bytes(&m->info);
    m->info.table_bytes = btf_material_texture(m, BTF_TEXTURE_VIEW_TABLE).size +
                          btf_material_texture(m, BTF_TEXTURE_LIGHT_TABLE).size +
                          btf_material_texture(m, BTF_TEXTURE_RESIDUAL_SCALES).size +
                          btf_material_texture(m, BTF_TEXTURE_FACTOR_SCALES).size +
                          btf_material_texture(m, BTF_TEXTURE_FACTOR_VIEWS).size +
                          btf_material_texture(m, BTF_TEXTURE_VIEW_VECTORS).size;
    m->info.version = btfi_version(&m->info);
    if (m->info.version < 2) { /* the file would be of version 1, which has no part for it */
        free(m->preview);
        m->preview = NULL;
    }
    m->info.method = m->method;
    m->info.options = m->options;
    m->info.source = m->source;
}

btf_result btf_material_get_info(const btf_material *material, btf_material_info *out_info) {
    size_t size = out_info->struct_size;
    if (size < sizeof size) {
        return BTF_ERROR_USAGE;
    }
    size_t filled = size < sizeof material->info ? size : sizeof material->info;
    memcpy(out_info, &material->info, filled);
    out_info->struct_size = size;
    return BTF_OK;
}

static btf_texture table_texture(const btfi_directions *d) {
    btf_texture texture = {.format = BTF_FORMAT_RGBA16UI,
                           .width = BTFI_TABLE_WIDTH,
                           .height = d->table_height,
                           .layers = 1,
                           .data = d->table};
    texture.size = (size_t)texture.width * texture.height * btf_format_size(texture.format);
    return texture;
}

static btf_texture vector_texture(const btf_material *m) {
    btf_texture texture = {0};
    if (m->view_vectors) {
        texture = (btf_texture){.format = BTF_FORMAT_RGBA32F,
                                .width = m->info.n_views,
                                .height = 1,
                                .layers = 1,
                                .data = m->view_vectors};
        texture.size = (size_t)texture.width * btf_format_size(texture.format);
    }
    return texture;
}

btf_texture btf_material_texture(const btf_material *material, btf_texture_id id) {
    if (id == BTF_TEXTURE_VIEW_VECTORS) {
        return vector_texture(material);
    }
    if (id == BTF_TEXTURE_VIEW_TABLE) {
        return table_texture(&material->views);
    }
    if (id == BTF_TEXTURE_LIGHT_TABLE) {
        return table_texture(&material->lights);
    }
    btf_texture texture = btf_material_texture_shape(&material->info, id);
    if (texture.format != BTF_FORMAT_NONE) {
        texture.data = material->texture[0][id];
    }
    return texture;
}

btf_texture btf_material_level_texture(const btf_material *material, uint32_t level, btf_texture_id id) {
    if (level == 0) {
        return btf_material_texture(material, id);
    }
    btf_texture texture = btf_material_level_shape(&material->info, level, id);
    if (texture.format != BTF_FORMAT_NONE) {
        texture.data = material->texture[level][id];
    }
    return texture;
}

static btf_directions public_directions(const btfi_directions *d) {
    return (btf_directions){
        .count = d->count,
        .xyz = d->xyz,
        .vertices = d->vertices,
        .triangle_count = d->triangle_count,
        .triangles = d->triangles,
        .hull_count = d->hull_count,
        .hull = d->hull,
        .grid = d->grid,
        .cells = d->cells,
        .cells_length = d->cells_length,
    };
}

btf_directions btf_material_views(const btf_material *material) {
    return public_directions(&material->views);
}

btf_directions btf_material_lights(const btf_material *material) {
    return public_directions(&material->lights);
}

const btf_material_error *btf_material_errors(const btf_material *material, size_t *out_count) {
    *out_count = material->error_count;
    return material->error_count ? material->errors : NULL;
}

const btf_level_error *btf_material_level_errors(const btf_material *material, size_t *out_count) {
    *out_count = material->level_error_count;
    return material->level_error_count ? material->level_errors : NULL;
}

btf_effect_errors btf_material_effect_errors(const btf_material *material) {
    return btfi_effect_errors_of(material->effect_errors, material->effect_error_count);
}

btf_effect_errors btf_material_effect_differences(const btf_material *material) {
    return btfi_effect_errors_of(material->effect_differences, material->effect_difference_count);
}

btf_between_errors btf_material_between_errors(const btf_material *material) {
    return btfi_between_errors_of(material->between_errors, material->between_error_count);
}

const uint16_t *btf_material_preview(const btf_material *material) {
    return material->preview;
}

/* The caller's textures of a level. */
static const void *const *level_textures(const btf_material_desc *desc, uint32_t level) {
    return level ? desc->level_texture[level] : desc->texture;
}

/* Copies the caller's textures: those that info calls for must be there, others must not. */
static btf_result copy_textures(const btf_material_desc *desc, const btf_log *log, btf_material *m) {
    for (uint32_t level = 0; level < BTF_MAX_LEVELS; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            size_t size = btf_material_level_shape(&m->info, level, (btf_texture_id)id).size;
            const btfi_name name = btfi_texture_name(level, (btf_texture_id)id);
            const void *data = level_textures(desc, level)[id];
            if (size == 0 && data) {
                return btfi_fail(log, BTF_ERROR_USAGE, "%s: given, but the material has no such texture",
                                 name.text);
            }
            if (size != 0 && !data) {
                return btfi_fail(log, BTF_ERROR_USAGE, "%s: missing; the material needs its %zu bytes",
                                 name.text, size);
            }
        }
    }
    btf_result result = btfi_material_allocate(log, m);
    if (result) {
        return result;
    }
    for (uint32_t level = 0; level < m->info.levels; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            if (m->texture[level][id]) {
                memcpy(m->texture[level][id], level_textures(desc, level)[id],
                       btf_material_level_shape(&m->info, level, (btf_texture_id)id).size);
            }
        }
    }
    return BTF_OK;
}

/* A copy of `count` rows; NULL, and *good false, when out of memory. */
static void *copy_rows(const void *rows, size_t count, size_t size, bool *good) {
    void *copy = count ? calloc(count, size) : NULL;
    if (copy) {
        memcpy(copy, rows, count * size);
    }
    *good = *good && (copy || !count);
    return copy;
}

static btf_result copy_provenance(const btf_material_desc *desc, const btf_log *log, btf_material *m) {
    const char *method = desc->info.method ? desc->info.method : "";
    const char *options = desc->info.options ? desc->info.options : "";
    const char *source = desc->info.source ? desc->info.source : "";
    m->method = btfi_copy_string(method, strlen(method));
    m->options = btfi_copy_string(options, strlen(options));
    m->source = btfi_copy_string(source, strlen(source));
    bool good = m->method && m->options && m->source;
    m->errors = copy_rows(desc->errors, desc->error_count, sizeof *m->errors, &good);
    m->error_count = desc->error_count;
    m->level_errors =
        copy_rows(desc->level_errors, desc->level_error_count, sizeof *m->level_errors, &good);
    m->level_error_count = desc->level_error_count;
    m->effect_errors =
        copy_rows(desc->effect_errors, desc->effect_error_count, sizeof *m->effect_errors, &good);
    m->effect_error_count = desc->effect_error_count;
    m->effect_differences = copy_rows(desc->effect_differences, desc->effect_difference_count,
                                      sizeof *m->effect_differences, &good);
    m->effect_difference_count = desc->effect_difference_count;
    m->between_errors =
        copy_rows(desc->between_errors, desc->between_error_count, sizeof *m->between_errors, &good);
    m->between_error_count = desc->between_error_count;
    if (desc->preview) {
        m->preview =
            copy_rows(desc->preview, (size_t)m->info.width * m->info.height, 4 * sizeof *m->preview, &good);
    }
    if (!good) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "out of memory for the material's provenance");
    }
    return BTF_OK;
}

/* Checks the list of views that relief acts on: 0 or 1 each, and only with the effect. */
static btf_result check_relief_views(const btf_material_desc *desc, const btf_log *log) {
    if (!desc->relief_views) {
        return BTF_OK;
    }
    if (!(desc->info.effects & BTF_EFFECT_RELIEF)) {
        return btfi_fail(log, BTF_ERROR_USAGE, "reliefViews: given without the effect relief");
    }
    for (uint32_t v = 0; v < desc->info.n_views; v++) {
        if (desc->relief_views[v] > 1) {
            return btfi_fail(log, BTF_ERROR_USAGE, "reliefViews: number %u is %u, not 0 or 1", (unsigned)v,
                             (unsigned)desc->relief_views[v]);
        }
    }
    return BTF_OK;
}

btf_result btf_material_create(const btf_material_desc *desc, const btf_log *log,
                               btf_material **out_material) {
    const btfi_check check = {log, BTF_ERROR_USAGE};
    *out_material = NULL;
    if (desc->struct_size != sizeof *desc) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "struct_size is %zu; this library's btf_material_desc has %zu", desc->struct_size,
                         sizeof *desc);
    }
    if (!desc->views || !desc->lights) {
        return btfi_fail(log, BTF_ERROR_USAGE, "%s: missing", desc->views ? "lights" : "views");
    }
    if (desc->error_count && !desc->errors) {
        return btfi_fail(log, BTF_ERROR_USAGE, "errors: %zu rows, but the pointer to them is NULL",
                         desc->error_count);
    }
    if (desc->level_error_count && !desc->level_errors) {
        return btfi_fail(log, BTF_ERROR_USAGE, "level errors: %zu rows, but the pointer to them is NULL",
                         desc->level_error_count);
    }
    if (desc->effect_error_count && !desc->effect_errors) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "effect errors: %zu numbers, but the pointer to them is NULL",
                         desc->effect_error_count);
    }
    if (desc->effect_difference_count && !desc->effect_differences) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "effect differences: %zu numbers, but the pointer to them is NULL",
                         desc->effect_difference_count);
    }
    if (desc->between_error_count && !desc->between_errors) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "between errors: %zu numbers, but the pointer to them is NULL",
                         desc->between_error_count);
    }
    btf_material_info info = desc->info;
    info.levels = info.levels ? info.levels : 1;
    if (info.effects & BTF_EFFECT_RELIEF && info.relief_end == 0) {
        info.relief_end = info.levels;
    }
    info.half_float = info.half_float && info.colour != BTF_COLOUR_NONE;
    info.horizon_scale = info.horizon_scale == 0 ? 1 : info.horizon_scale;
    info.gain_base = info.gain_base == 0 ? 0 : info.gain_base; /* -0 becomes 0 */
    info.gain_step = info.gain_step == 0 ? 0 : info.gain_step;
    btf_result result = btfi_check_info(&check, &info);
    if (result) {
        return result;
    }
    if (desc->preview && btfi_version(&info) < 2) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "preview: given, but nothing else of the material needs version 2, and files of "
                         "version 1 have no preview");
    }

    btf_material *m = btfi_material_new();
    if (!m) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "out of memory for a material");
    }
    m->info = info;
    if ((result = copy_textures(desc, log, m)) ||
        (result = btfi_check_values(&check, &m->info, m->texture)) ||
        (result = btfi_directions_build(&check, "views", m->info.n_views, desc->views, &m->views)) ||
        (result = btfi_directions_build(&check, "lights", m->info.n_lights, desc->lights, &m->lights)) ||
        (result = check_relief_views(desc, log)) ||
        (result = btfi_material_make_vectors(log, desc->relief_views, m)) ||
        (result = btfi_check_errors(&check, btfi_version_effects(btfi_version(&m->info)), desc->errors,
                                    desc->error_count)) ||
        (result = btfi_check_level_errors(&check, m->info.levels, desc->level_errors,
                                          desc->level_error_count)) ||
        (result =
             btfi_check_effect_errors(&check, &m->info, desc->effect_errors, desc->effect_error_count)) ||
        (result = btfi_check_effect_differences(&check, &m->info, desc->effect_differences,
                                                desc->effect_difference_count)) ||
        (result = btfi_check_between_errors(&check, &m->info, BTFI_BETWEEN_IN_MEMORY, desc->between_errors,
                                            desc->between_error_count)) ||
        (result = copy_provenance(desc, log, m))) {
        btf_material_close(&m);
        return result;
    }
    btfi_material_finish(m);
    *out_material = m;
    return BTF_OK;
}
