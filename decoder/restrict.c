/* OpenBTF: makes a material with the data that a plan reads and nothing else. See openbtf/plan.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "restrict.h"

#include "decoder/restrict/textures.h"
#include "material.h"
#include "reach.h"
#include "shape.h"

#include <stdlib.h>
#include <string.h>

/* The store of shift and gain, and its effects. Packed gains are no multiples of a scale, so that texture
 * `gain` cannot hold them. A shift alone takes as many bytes in its own texture as packed. Lists are kept
 * where they are smaller than either, which they are not for few views; a plan with the shift alone gets
 * lists of gain 1. */
static void restrict_points(const btf_material_info *info, btf_material_info *small, uint32_t *effects) {
    const uint32_t both = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN;
    const bool gain = *effects & BTF_EFFECT_GAIN;
    if (info->point_store == BTF_POINTS_LISTS && *effects & both &&
        2 * info->point_entries + (small->n_views + 1) / 2 < 2 * small->n_views) {
        small->gain_base = gain ? info->gain_base : 1;
        small->gain_step = gain ? info->gain_step : 0;
        *effects |= both;
        return;
    }
    small->point_entries = 0;
    if (btfi_shares_points(info) && gain) {
        small->point_store = BTF_POINTS_PACKED;
        *effects |= both;
    } else {
        small->point_store = BTF_POINTS_SEPARATE;
        small->gain_base = small->gain_step = 0;
    }
}

/* Heights stay as they are: those of the level that becomes level 0 are stored in texels of the finest
 * there was. */
static void restrict_relief(btf_material_info *small, uint32_t level) {
    small->relief_level += level;
    small->relief_end -= level;
    if (!(small->effects & BTF_EFFECT_RELIEF)) {
        small->relief_base = small->relief_step = 0;
        small->relief_steps = small->relief_level = small->relief_end = 0;
    }
    if (!(small->effects & BTF_EFFECT_GLOSS)) {
        small->gloss_share = 0;
    }
}

btf_material_info btfi_restricted_info(const btf_material_info *info, uint32_t effects, uint32_t components,
                                       uint32_t level, uint32_t views, uint32_t lights) {
    btf_material_info small = *info;
    small.n_views = views;
    small.n_lights = lights;
    effects &= info->effects;
    if (btfi_relief_has_ended(info, level)) {
        effects &= ~(uint32_t)BTF_EFFECT_RELIEF;
    }
    if (info->colour == BTF_COLOUR_NONE) {
        effects &= ~(uint32_t)BTF_EFFECT_SHADOW;
        /* A material needs a model: one component is the cheapest. */
        if (!(effects & BTF_EFFECT_RESIDUAL)) {
            effects |= BTF_EFFECT_RESIDUAL;
            components = 1;
        }
    }
    /* A hidden point that is not decoded as one has the gain 1, which no code may say. */
    if ((info->effects & BTF_EFFECT_HIDDEN) && (effects & BTF_EFFECT_GAIN) &&
        info->gain_scale != BTF_GAIN_SCALE) {
        effects |= BTF_EFFECT_HIDDEN;
    }
    restrict_points(info, &small, &effects);
    small.layout = BTF_LAYOUT_TIGHT;
    small.atlas_width = small.atlas_height = 0;
    small.width = btf_level_size(info->width, level);
    small.height = btf_level_size(info->height, level);
    small.levels = info->levels - level;
    small.effects = effects;
    restrict_relief(&small, level);
    small.components = effects & BTF_EFFECT_RESIDUAL
                           ? (components && components < info->components ? components : info->components)
                           : 0;
    small.centres = effects & BTF_EFFECT_HIDDEN ? info->centres : 0;
    btfi_truncate_classes(info->factor_classes, small.components, small.factor_classes);
    if (small.components == 0) {
        small.store = BTF_STORE_COMPONENTS;
        small.horizon_scale = 1;
    }
    return small;
}

static btf_result copy_array(const void *from, size_t size, void **out) {
    *out = size ? malloc(size) : NULL;
    if (size && !*out) {
        return BTF_ERROR_MEMORY;
    }
    if (size) {
        memcpy(*out, from, size);
    }
    return BTF_OK;
}

/* Whole lists keep the file's own triangulation. */
static btf_result copy_directions(const btfi_directions *from, const btf_log *log, btfi_directions *to) {
    btfi_directions_clear(to);
    *to = (btfi_directions){.count = from->count,
                            .triangle_count = from->triangle_count,
                            .hull_count = from->hull_count,
                            .grid = from->grid,
                            .cells_length = from->cells_length,
                            .table_height = from->table_height};
    if (copy_array(from->xyz, 3 * (size_t)from->count * sizeof *from->xyz, (void **)&to->xyz) ||
        copy_array(from->vertices, 2 * (size_t)from->count * sizeof *from->vertices,
                   (void **)&to->vertices) ||
        copy_array(from->triangles, 3 * (size_t)from->triangle_count * sizeof *from->triangles,
                   (void **)&to->triangles) ||
        copy_array(from->hull, from->hull_count * sizeof *from->hull, (void **)&to->hull) ||
        copy_array(from->cells, from->cells_length * sizeof *from->cells, (void **)&to->cells) ||
        copy_array(from->table, (size_t)from->table_height * BTFI_TABLE_WIDTH * 4 * sizeof *from->table,
                   (void **)&to->table)) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "out of memory for directions");
    }
    return BTF_OK;
}

static btf_result make(btfi_restriction *r, const btf_log *log, btf_material **out_material) {
    btf_result result = btfi_restriction_fill(r, log);
    if (result == BTF_OK) {
        result = btf_material_create(&r->desc, log, out_material);
    }
    if (result != BTF_OK) {
        return result;
    }
    btf_material *m = *out_material;
    if (r->views.count == r->whole->views.count) {
        result = copy_directions(&r->whole->views, log, &m->views);
    }
    if (result == BTF_OK && r->lights.count == r->whole->lights.count) {
        result = copy_directions(&r->whole->lights, log, &m->lights);
    }
    if (result == BTF_OK) {
        btfi_material_finish(m);
    } else {
        btf_material_close(out_material);
    }
    return result;
}

btf_result btf_material_restrict(const btf_material *material, const btf_plan *plan, const btf_log *log,
                                 btf_material **out_material) {
    *out_material = NULL;
    if (plan->struct_size != sizeof *plan || !btfi_range_is_legal(&plan->scene.view) ||
        !btfi_range_is_legal(&plan->scene.light) || plan->level >= material->info.levels) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "restrict: the plan is missing, or was made for another material");
    }
    btfi_restriction *r = calloc(1, sizeof *r);
    if (!r) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "restrict: out of memory");
    }
    r->whole = material;
    r->level = plan->level;
    r->shift = plan->effects & BTF_EFFECT_SHIFT;
    r->gain = plan->effects & BTF_EFFECT_GAIN;
    r->desc.struct_size = sizeof r->desc;
    btf_result result = btfi_subset_choose(&material->views, &plan->scene.view, log, &r->views);
    if (result == BTF_OK && plan->effects & material->info.effects & BTF_EFFECT_GLOSS) {
        btfi_subset_all(&material->lights, &r->lights); /* gloss may look up any light for a neighbouring view */
    } else if (result == BTF_OK) {
        result = btfi_subset_choose(&material->lights, &plan->scene.light, log, &r->lights);
    }
    r->desc.info = btfi_restricted_info(&material->info, plan->effects, plan->components, plan->level,
                                        r->views.count, r->lights.count);
    if (r->desc.info.effects & BTF_EFFECT_RELIEF) {
        for (uint32_t v = 0; v < r->views.count; v++) {
            r->acts[v] = material->view_vectors[4 * (size_t)r->views.number[v] + 3] != 0;
        }
        r->desc.relief_views = r->acts;
    }
    r->desc.views = r->views.xyz[0];
    r->desc.lights = r->lights.xyz[0];
    if (plan->level == 0 && btfi_version(&r->desc.info) >= 2) { /* the preview has the size of level 0 */
        r->desc.preview = material->preview;
    }
    if (result == BTF_OK) {
        result = make(r, log, out_material);
    }
    btfi_restriction_clear(r);
    free(r);
    return result;
}

/* A restriction that keeps everything: it only takes the atlas apart. */
btf_result btf_material_to_tight(const btf_material *material, const btf_log *log,
                                 btf_material **out_material) {
    btf_material_info info = {.struct_size = sizeof info};
    *out_material = NULL;
    const btf_result result = btf_material_get_info(material, &info);
    if (result != BTF_OK) {
        return result;
    }
    const btf_plan everything = {.struct_size = sizeof everything,
                                 .scene = {.struct_size = sizeof everything.scene},
                                 .effects = info.effects,
                                 .components = info.components};
    return btf_material_restrict(material, &everything, log, out_material);
}
