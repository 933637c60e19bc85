/* Making an evaluator of a material.
 *
 * SPDX-License-Identifier: MIT
 */
#include "prepared.h"

#include "arrange.h"
#include "partners.h"
#include "decoder/result.h"
#include "kernels.h"
#include "sound.h"

#include <stdlib.h>

enum { CENTRE_ROWS = 4096 }; /* of a block of layout tight, at most */

/* Where the centres of hidden points are (FORMAT.md sections 3 and 5). */
static btf_result find_centres(const btf_material *material, btf_evaluator *e) {
    const btf_material_info *info = &e->info;
    const bool tight = info->layout == BTF_LAYOUT_TIGHT;
    e->centre_texels = tight ? btf_material_texture(material, BTF_TEXTURE_CENTRES).data : e->maps;
    if (info->centres == 0) {
        return BTF_OK;
    }
    e->centre_at = malloc(info->centres * sizeof *e->centre_at);
    if (!e->centre_at) {
        return BTF_ERROR_MEMORY;
    }
    const uint32_t blocks = (info->centres + CENTRE_ROWS - 1) / CENTRE_ROWS,
                   rows = (info->centres + blocks - 1) / blocks;
    e->centre_step = tight ? 1 : info->atlas_width;
    for (uint32_t i = 0; i < info->centres; i++) {
        uint32_t x = i / rows * info->n_lights, y = i % rows;
        if (!tight) {
            btf_material_atlas_centre(info, i, &x, &y);
        }
        e->centre_at[i] = y * (tight ? blocks * info->n_lights : info->atlas_width) + x;
    }
    return BTF_OK;
}

static void find_level(const btf_material *material, uint32_t level, btf_evaluator *e) {
    e->levels[level] = (btfi_level){
        .width = btf_level_size(e->info.width, level),
        .height = btf_level_size(e->info.height, level),
        .shift = level + e->info.relief_level,
        .sbrdf = btf_material_level_texture(material, level, BTF_TEXTURE_SBRDF).data,
        .shadow = btf_material_level_texture(material, level, BTF_TEXTURE_SHADOW).data,
        .shifts = btf_material_level_texture(material, level, BTF_TEXTURE_SHIFT).data,
        .gain = btf_material_level_texture(material, level, BTF_TEXTURE_GAIN).data,
        .points = btf_material_level_texture(material, level, BTF_TEXTURE_POINTS).data,
        .point_lists = btf_material_level_texture(material, level, BTF_TEXTURE_POINT_LISTS).data,
        .point_indices = btf_material_level_texture(material, level, BTF_TEXTURE_POINT_INDICES).data,
        .heights = btf_material_level_texture(material, level, BTF_TEXTURE_HEIGHTS).data,
    };
}

/* Finds the partners of each view, which sums of products need (decoder/evaluate/partners.h). Where there are too many
 * views for partners, e->partners stays NULL, and such sums are not supported. */
static btf_result find_partners(const btf_material *material, btf_evaluator *e) {
    const btf_directions views = btf_material_views(material);
    if (e->info.blend != BTF_BLEND_ROOTS || e->info.colour != BTF_COLOUR_NONE) {
        return BTF_OK;
    }
    const btf_result result = btfi_fold_partners(&views, &e->partners);
    return result == BTF_ERROR_MEMORY ? result : BTF_OK;
}

static btf_result fill(const btf_material *material, btf_evaluator *e) {
    const bool residual = e->info.effects & BTF_EFFECT_RESIDUAL;
    e->factors_stored = residual && e->info.store == BTF_STORE_FACTORS;
    e->components_stored = residual && e->info.store == BTF_STORE_COMPONENTS;
    e->modelled = e->info.colour != BTF_COLOUR_NONE;
    e->view_table = btf_material_texture(material, BTF_TEXTURE_VIEW_TABLE).data;
    e->light_table = btf_material_texture(material, BTF_TEXTURE_LIGHT_TABLE).data;
    e->view_grid = btf_material_views(material).grid;
    e->light_grid = btf_material_lights(material).grid;
    e->view_vectors = btf_material_texture(material, BTF_TEXTURE_VIEW_VECTORS).data;
    e->factor_views = btf_material_texture(material, BTF_TEXTURE_FACTOR_VIEWS).data;
    e->maps = btf_material_texture(material, BTF_TEXTURE_MAPS).data;
    e->kernels = btfi_kernels_of(BTFI_ISA_AVX2);
    for (uint32_t i = 0; i < e->info.levels; i++) {
        find_level(material, i, e);
    }
    if (find_partners(material, e)) {
        return BTF_ERROR_MEMORY;
    }
    const btf_result result = find_centres(material, e);
    return result ? result : btfi_arrange_residual(material, e);
}

btf_result btf_evaluator_create(const btf_material *material, const btf_log *log,
                                btf_evaluator **out_evaluator) {
    if (!out_evaluator) {
        return BTF_ERROR_USAGE;
    }
    *out_evaluator = NULL;
    if (!material) {
        return BTF_ERROR_USAGE;
    }
    if (!btfi_build_is_sound()) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED,
                         "this build does not round floats as FORMAT.md demands");
    }
    btf_evaluator *e = calloc(1, sizeof *e);
    btf_result result = e ? BTF_OK : BTF_ERROR_MEMORY;
    if (e) {
        e->info.struct_size = sizeof e->info;
        if (!(result = btf_material_get_info(material, &e->info))) {
            result = fill(material, e);
        }
    }
    if (result) {
        btf_evaluator_destroy(&e);
        return btfi_fail(log, result, "out of memory for an evaluator");
    }
    *out_evaluator = e;
    return BTF_OK;
}

void btf_evaluator_destroy(btf_evaluator **evaluator) {
    btf_evaluator *e = evaluator ? *evaluator : NULL;
    if (!e) {
        return;
    }
    for (int i = 0; i < BTF_MAX_LEVELS; i++) {
        free(e->levels[i].u);
        free(e->levels[i].components);
    }
    free(e->centre_at);
    free(e->units);
    free(e->w);
    free(e->v);
    free(e->scales);
    free(e->partners);
    free(e);
    *evaluator = NULL;
}
