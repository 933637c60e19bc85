/* OpenBTF: formats, names and shapes of the textures (FORMAT.md section 3).
 *
 * SPDX-License-Identifier: MIT
 */
#include "shape.h"

#include <stdio.h>

static const char *const texture_names[BTF_TEXTURE_COUNT] = {
    "sbrdf",
    "maps",
    "shadow",
    "shift",
    "gain",
    "centres",
    "residual_texels",
    "residual_directions",
    "residual_scales",
    "view_table",
    "light_table",
    "factor_texels",
    "factor_directions",
    "factor_scales",
    "factor_views",
    "points",
    "point_lists",
    "point_indices",
    "heights",
    "view_vectors",
};

static const char *const effect_names[] = {"shadow",   "shift",  "hidden", "gain",
                                           "residual", "relief", "gloss"};

const char *btfi_effect_name(int index) {
    int count = (int)(sizeof effect_names / sizeof *effect_names);
    return index >= 0 && index < count ? effect_names[index] : NULL;
}

uint32_t btfi_format_channels(btf_format format) {
    switch (format) {
    case BTF_FORMAT_NONE:
        return 0;
    case BTF_FORMAT_R8UI:
        return 1;
    case BTF_FORMAT_RG8UI:
        return 2;
    case BTF_FORMAT_RGBA8UI:
    case BTF_FORMAT_RGBA8I:
    case BTF_FORMAT_RGBA16UI:
    case BTF_FORMAT_RGBA16F:
    case BTF_FORMAT_RGBA32F:
    case BTF_FORMAT_RGBA32UI:
        return 4;
    }
    return 0;
}

size_t btf_format_size(btf_format format) {
    switch (format) {
    case BTF_FORMAT_RGBA16UI:
    case BTF_FORMAT_RGBA16F:
        return 8;
    case BTF_FORMAT_RGBA32F:
    case BTF_FORMAT_RGBA32UI:
        return 16;
    default:
        return btfi_format_channels(format);
    }
}

const char *btf_texture_name(btf_texture_id id) {
    return (unsigned)id < BTF_TEXTURE_COUNT ? texture_names[id] : "unknown";
}

btfi_name btfi_texture_name(uint32_t level, btf_texture_id id) {
    btfi_name name;
    if (level == 0) {
        snprintf(name.text, sizeof name.text, "%s", btf_texture_name(id));
    } else {
        snprintf(name.text, sizeof name.text, "level%u.%s", (unsigned)level, btf_texture_name(id));
    }
    return name;
}

static uint32_t ceil_div(uint32_t a, uint32_t b) {
    return (a + b - 1) / b;
}

/* Texels of factor_texels that a unit of each class takes. */
static const uint32_t unit_layers[BTF_FACTOR_CLASSES] = {1, 2, 1, 2, 1};

static uint32_t smaller(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

void btfi_truncate_classes(const uint32_t classes[BTF_FACTOR_CLASSES][3], uint32_t units,
                           uint32_t out[BTF_FACTOR_CLASSES][3]) {
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        out[c][0] = smaller(classes[c][0], units);
        units -= out[c][0];
        out[c][1] = smaller(classes[c][1], 4 * out[c][0]);
        out[c][2] = smaller(classes[c][2], 4 * out[c][0] - out[c][1]);
    }
}

uint32_t btfi_factor_layers(const btf_material_info *info, uint32_t units) {
    uint32_t layers = 0;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        const uint32_t of_class = smaller(info->factor_classes[c][0], units);
        layers += of_class * unit_layers[c];
        units -= of_class;
    }
    return layers;
}

uint32_t btfi_unit_class(const btf_material_info *info, uint32_t unit, uint32_t *out_number) {
    uint32_t c = 0;
    while (c + 1 < BTF_FACTOR_CLASSES && unit >= info->factor_classes[c][0]) {
        unit -= info->factor_classes[c++][0];
    }
    *out_number = unit;
    return c;
}

bool btfi_unit_is_mixed(const btf_material_info *info, uint32_t unit) {
    uint32_t number;
    const uint32_t c = btfi_unit_class(info, unit, &number);
    return c == 0 || 4 * number < info->factor_classes[c][1] + info->factor_classes[c][2];
}

bool btfi_is_table(btf_texture_id id) {
    return id == BTF_TEXTURE_RESIDUAL_SCALES || id == BTF_TEXTURE_FACTOR_SCALES ||
           id == BTF_TEXTURE_FACTOR_VIEWS || id == BTF_TEXTURE_VIEW_TABLE ||
           id == BTF_TEXTURE_LIGHT_TABLE || id == BTF_TEXTURE_VIEW_VECTORS;
}

uint32_t btfi_version(const btf_material_info *info) {
    const bool many = info->n_views > BTF_MAX_DIRECTION_LAYERS || info->n_lights > BTF_MAX_DIRECTION_LAYERS;
    return many || info->store == BTF_STORE_FACTORS || info->blend != BTF_BLEND_RADIANCE ||
                   btfi_shares_points(info) || info->effects & BTFI_VECTOR_EFFECTS
               ? 2
               : 1;
}

static btf_texture shape(btf_format format, int is_array, uint32_t width, uint32_t height,
                         uint32_t layers) {
    btf_texture texture = {
        .format = format, .is_array = is_array, .width = width, .height = height, .layers = layers};
    texture.size = (size_t)width * height * layers * btf_format_size(format);
    return texture;
}

btf_texture btf_material_texture_shape(const btf_material_info *info, btf_texture_id id) {
    const btf_texture none = {0};
    const uint32_t w = info->width, h = info->height, effects = info->effects;
    const bool tight = info->layout == BTF_LAYOUT_TIGHT, packed = btfi_shares_points(info);
    const bool lists = info->point_store == BTF_POINTS_LISTS;
    const uint32_t quads = ceil_div(info->components, 4);
    const bool residual = effects & BTF_EFFECT_RESIDUAL && info->store == BTF_STORE_COMPONENTS;
    const bool factors = effects & BTF_EFFECT_RESIDUAL && info->store == BTF_STORE_FACTORS;

    switch (id) {
    case BTF_TEXTURE_SBRDF: {
        if (info->colour == BTF_COLOUR_NONE) {
            return none;
        }
        uint32_t lead = info->colour == BTF_COLOUR_MONO ? 1 : ceil_div(3 + 3 * info->lobes, 4);
        return shape(info->half_float ? BTF_FORMAT_RGBA16F : BTF_FORMAT_RGBA32F, 1, w, h,
                     lead + info->lobes);
    }
    case BTF_TEXTURE_MAPS:
        return !tight && effects & BTFI_ATLAS_EFFECTS
                   ? shape(BTF_FORMAT_RGBA8UI, 0, info->atlas_width, info->atlas_height, 1)
                   : none;
    case BTF_TEXTURE_SHADOW:
        return tight && effects & BTF_EFFECT_SHADOW ? shape(BTF_FORMAT_R8UI, 1, w, h, info->n_lights)
                                                    : none;
    case BTF_TEXTURE_SHIFT:
        return tight && !packed && effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN)
                   ? shape(BTF_FORMAT_RG8UI, 1, w, h, info->n_views)
                   : none;
    case BTF_TEXTURE_GAIN:
        return tight && !packed && effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN)
                   ? shape(BTF_FORMAT_R8UI, 1, w, h, info->n_views)
                   : none;
    case BTF_TEXTURE_POINTS:
        return packed && !lists && effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN)
                   ? shape(BTF_FORMAT_RG8UI, 1, w, h, info->n_views)
                   : none;
    case BTF_TEXTURE_POINT_LISTS:
        return lists ? shape(BTF_FORMAT_RG8UI, 1, w, h, info->point_entries) : none;
    case BTF_TEXTURE_POINT_INDICES:
        return lists ? shape(BTF_FORMAT_R8UI, 1, w, h, ceil_div(info->n_views, 2)) : none;
    case BTF_TEXTURE_CENTRES: {
        if (!tight || !(effects & BTF_EFFECT_HIDDEN) || info->centres == 0) {
            return none;
        }
        uint32_t blocks = ceil_div(info->centres, 4096);
        return shape(BTF_FORMAT_RGBA8UI, 0, info->n_lights * blocks, ceil_div(info->centres, blocks), 1);
    }
    case BTF_TEXTURE_RESIDUAL_TEXELS:
        return residual ? shape(BTF_FORMAT_RGBA8I, 1, w, h, quads) : none;
    case BTF_TEXTURE_RESIDUAL_DIRECTIONS:
        return residual ? shape(BTF_FORMAT_RGBA8I, 1, info->n_lights, info->n_views, 3 * quads) : none;
    case BTF_TEXTURE_RESIDUAL_SCALES:
        return residual ? shape(BTF_FORMAT_RGBA32F, 0, quads, 1, 1) : none;
    case BTF_TEXTURE_FACTOR_TEXELS:
        return factors ? shape(BTF_FORMAT_RGBA32UI, 1, w, h, btfi_factor_layers(info, info->components))
                       : none;
    case BTF_TEXTURE_FACTOR_DIRECTIONS:
        return factors ? shape(BTF_FORMAT_RGBA32UI, 1, info->n_lights, info->n_views, info->components)
                       : none;
    case BTF_TEXTURE_FACTOR_SCALES:
        return factors ? shape(BTF_FORMAT_RGBA32F, 0, info->components, 1, 1) : none;
    case BTF_TEXTURE_FACTOR_VIEWS:
        return factors ? shape(BTF_FORMAT_RGBA32F, 0, 3, info->n_views, 1) : none;
    case BTF_TEXTURE_HEIGHTS:
        return tight && effects & BTF_EFFECT_RELIEF && info->relief_step > 0
                   ? shape(BTF_FORMAT_R8UI, 0, w, h, 1)
                   : none;
    case BTF_TEXTURE_VIEW_VECTORS:
    case BTF_TEXTURE_VIEW_TABLE:
    case BTF_TEXTURE_LIGHT_TABLE:
    case BTF_TEXTURE_COUNT:
        return none;
    }
    return none;
}

uint32_t btf_level_size(uint32_t size, uint32_t level) {
    return level < 32 && size >> level ? size >> level : 1;
}

btf_texture btf_material_level_shape(const btf_material_info *info, uint32_t level, btf_texture_id id) {
    if (level == 0) {
        return btf_material_texture_shape(info, id);
    }
    const bool shared = id == BTF_TEXTURE_CENTRES || id == BTF_TEXTURE_RESIDUAL_DIRECTIONS ||
                        id == BTF_TEXTURE_FACTOR_DIRECTIONS || btfi_is_table(id);
    if (shared || level >= info->levels) {
        return (btf_texture){0};
    }
    btf_material_info of_level = *info;
    of_level.width = btf_level_size(info->width, level);
    of_level.height = btf_level_size(info->height, level);
    return btf_material_texture_shape(&of_level, id);
}

size_t btf_level_bytes(const btf_material_info *info, uint32_t level) {
    size_t bytes = 0;
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        if (!btfi_is_table((btf_texture_id)id)) {
            bytes += btf_material_level_shape(info, level, (btf_texture_id)id).size;
        }
    }
    return bytes;
}

size_t btfi_gpu_bytes(const btf_material_info *info) {
    size_t bytes = 0;
    for (uint32_t level = 0; level < info->levels; level++) {
        bytes += btf_level_bytes(info, level);
    }
    return bytes;
}
