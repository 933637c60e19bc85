/* OpenBTF: where tiles and centres lie in the atlas of layout `paper` (FORMAT.md section 5; paper 3.1).
 *
 * SPDX-License-Identifier: MIT
 */
#include "atlas.h"
#include <assert.h>

static uint32_t min_u32(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

bool btfi_atlas_plan(const btf_material_info *info, uint32_t width, uint32_t height, btfi_atlas *out) {
    const uint32_t w = info->width, h = info->height, n_lights = info->n_lights;
    btfi_atlas a = {.tiles = info->n_views > n_lights ? info->n_views : n_lights, .columns = width / w};
    if (a.columns == 0 || (a.tiles + a.columns - 1) / a.columns > height / h) {
        return false;
    }
    a.part = a.tiles % a.columns;
    a.y0 = a.tiles / a.columns * h;
    a.bands = (height - a.y0) / n_lights;
    a.narrow = a.part > 0 ? min_u32(a.bands, (h + n_lights - 1) / n_lights) : 0;
    a.w0 = width - a.part * w;
    a.room = a.narrow * a.w0 + (a.bands - a.narrow) * width;
    *out = a;
    return true;
}

btf_result btf_material_atlas(const btf_material_info *info, uint32_t *out_width, uint32_t *out_height,
                              uint32_t *out_room) {
    const uint32_t most = info->centres > info->n_views ? info->centres : info->n_views;
    const uint32_t c_min = info->effects & BTF_EFFECT_HIDDEN ? most : 0;
    uint64_t best = UINT64_MAX;
    *out_width = *out_height = *out_room = 0;
    if (info->width < 1 || info->height < 1 || info->n_views < 1 || info->n_lights < 1) {
        return BTF_ERROR_UNSUPPORTED;
    }
    /* With rising width and, for each, falling height, the first of an area has the smallest width /
     * height. */
    for (uint32_t width = 1; width <= BTF_MAX_SIZE; width *= 2) {
        for (uint32_t height = width; height >= 1; height /= 2) {
            btfi_atlas atlas;
            if (!btfi_atlas_plan(info, width, height, &atlas) || atlas.room < c_min) {
                continue;
            }
            uint64_t area = (uint64_t)width * height;
            if (area < best) {
                best = area;
                *out_width = width;
                *out_height = height;
                *out_room = atlas.room;
            }
        }
    }
    return best == UINT64_MAX ? BTF_ERROR_UNSUPPORTED : BTF_OK;
}

void btf_material_atlas_centre(const btf_material_info *info, uint32_t i, uint32_t *out_x,
                               uint32_t *out_y) {
    btfi_atlas a;
    bool fits = btfi_atlas_plan(info, info->atlas_width, info->atlas_height, &a);
    assert(fits && i < a.room);
    (void)fits;
    uint32_t band, column;
    if (i < a.narrow * a.w0) {
        band = i / a.w0;
        column = a.part * info->width + i % a.w0;
    } else {
        uint32_t rest = i - a.narrow * a.w0;
        band = a.narrow + rest / info->atlas_width;
        column = rest % info->atlas_width;
    }
    *out_x = column;
    *out_y = a.y0 + band * info->n_lights;
}

bool btfi_atlas_centre_at(const btf_material_info *info, const btfi_atlas *atlas, uint32_t x, uint32_t y,
                          uint32_t *out_centre) {
    if (y < atlas->y0) {
        return false;
    }
    uint32_t band = (y - atlas->y0) / info->n_lights;
    if (band >= atlas->bands) {
        return false;
    }
    if (band < atlas->narrow) {
        uint32_t left = atlas->part * info->width;
        if (x < left) {
            return false;
        }
        *out_centre = band * atlas->w0 + (x - left);
    } else {
        *out_centre = atlas->narrow * atlas->w0 + (band - atlas->narrow) * info->atlas_width + x;
    }
    return true;
}
