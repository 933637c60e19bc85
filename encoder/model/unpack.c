/* Unpacking. See unpack.h; the layouts are those of decoder/FORMAT.md sections 3 to 5.
 *
 * SPDX-License-Identifier: MIT
 */
#include "unpack.h"

#include <stdlib.h>
#include <string.h>

static float half_to_float(uint16_t bits) {
    const uint32_t sign = (uint32_t)(bits & 0x8000) << 16, exponent = (bits >> 10) & 31,
                   fraction = bits & 1023;
    if (exponent == 0) {
        const float magnitude = (float)fraction * 0x1p-24f;
        return sign ? -magnitude : magnitude;
    }
    const uint32_t word = sign | ((exponent + 127 - 15) << 23) | (fraction << 13);
    float value;
    memcpy(&value, &word, sizeof value);
    return value;
}

static void unpack_sbrdf(const btf_material_info *info, const void *texture, enc_sbrdf *sbrdf) {
    const size_t stride = enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb);
    for (size_t t = 0; t < sbrdf->n_texels; t++) {
        for (size_t i = 0; i < stride; i++) {
            const size_t at = enc_sbrdf_texture_index(sbrdf, t, i);
            sbrdf->values[t * stride + i] = info->half_float
                                                ? half_to_float(((const uint16_t *)texture)[at])
                                                : ((const float *)texture)[at];
        }
    }
}

/* Writes the gain code and the shift bytes of one point to the solution's maps. */
static void unpack_point(enc_solution *s, size_t at, uint8_t code, const uint8_t bytes[2]) {
    s->gain[at] = code;
    if ((s->effects & BTF_EFFECT_HIDDEN) && code == 0) {
        s->centre[at] = (uint16_t)(bytes[0] | bytes[1] << 8);
    } else {
        s->shift[2 * at] = (int8_t)bytes[0];
        s->shift[2 * at + 1] = (int8_t)bytes[1];
    }
}

static void unpack_maps(const btf_material_info *info, const uint8_t *maps, enc_solution *s) {
    const size_t width = info->width, texels = enc_solution_texels(s), columns = info->atlas_width / width;
    const size_t tiles = info->n_views > info->n_lights ? info->n_views : info->n_lights;
    const bool has_code = s->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN);
    for (size_t i = 0; i < tiles; i++) {
        for (size_t t = 0; t < texels; t++) {
            const size_t x = (i % columns) * width + t % width,
                         y = (i / columns) * info->height + t / width;
            const uint8_t *in = maps + 4 * (y * info->atlas_width + x);
            if (i < info->n_lights && s->shadow) {
                s->shadow[i * texels + t] = in[0];
            }
            if (i < info->n_views) {
                unpack_point(s, i * texels + t, has_code ? in[1] : BTF_GAIN_ONE, in + 2);
            }
        }
    }
    for (uint32_t c = 0; c < info->centres; c++) {
        uint32_t x, y;
        btf_material_atlas_centre(info, c, &x, &y);
        for (uint32_t l = 0; l < info->n_lights; l++) {
            memcpy(s->centre_codes + 3 * ((size_t)c * info->n_lights + l),
                   maps + 4 * ((size_t)(y + l) * info->atlas_width + x), 3);
        }
    }
}

/* The packed point that a view's index names in a texel's list. */
static const uint8_t *listed_point(const uint8_t *lists, const uint8_t *indices, size_t view, size_t texel,
                                   size_t texels) {
    const size_t entry = indices[(view / 2) * texels + texel] >> 4 * (view % 2) & 15;
    return lists + 2 * (entry * texels + texel);
}

/* Unpacks the maps of texels of one level in layout `tight`. */
static void unpack_tight(const btf_material *material, uint32_t level, enc_solution *s) {
    const size_t texels = enc_solution_texels(s), points = (size_t)s->n_views * texels;
    const uint8_t *shadow = btf_material_level_texture(material, level, BTF_TEXTURE_SHADOW).data;
    const uint8_t *shift = btf_material_level_texture(material, level, BTF_TEXTURE_SHIFT).data;
    const uint8_t *gain = btf_material_level_texture(material, level, BTF_TEXTURE_GAIN).data;
    const uint8_t *packed = btf_material_level_texture(material, level, BTF_TEXTURE_POINTS).data;
    const uint8_t *lists = btf_material_level_texture(material, level, BTF_TEXTURE_POINT_LISTS).data;
    const uint8_t *indices = btf_material_level_texture(material, level, BTF_TEXTURE_POINT_INDICES).data;
    static const uint8_t none[2] = {0, 0};
    if (shadow) {
        memcpy(s->shadow, shadow, (size_t)s->n_lights * texels);
    }
    for (size_t i = 0; i < points && (packed || lists); i++) {
        const uint8_t *point = packed ? packed + 2 * i : listed_point(lists, indices, i / texels, i % texels, texels);
        const int p = point[0] | point[1] << 8;
        s->gain[i] = (uint8_t)(p >> 12);
        s->shift[2 * i] = (int8_t)((p & 63) - 32);
        s->shift[2 * i + 1] = (int8_t)((p >> 6 & 63) - 32);
    }
    for (size_t i = 0; i < points && !packed && !lists; i++) {
        unpack_point(s, i, gain ? gain[i] : BTF_GAIN_ONE, shift ? shift + 2 * i : none);
    }
}

static void unpack_centres(const btf_material *material, enc_solution *s) {
    const btf_texture centres = btf_material_texture(material, BTF_TEXTURE_CENTRES);
    const size_t lights = (size_t)s->n_lights;
    for (uint32_t c = 0; c < s->n_centres; c++) {
        const size_t row = c % centres.height, block = c / centres.height;
        for (size_t l = 0; l < lights; l++) {
            memcpy(s->centre_codes + 3 * (c * lights + l),
                   (const uint8_t *)centres.data + 4 * (row * centres.width + block * lights + l), 3);
        }
    }
}

static void unpack_residual_texels(const btf_material *material, uint32_t level, enc_solution *s) {
    const int8_t *u = btf_material_level_texture(material, level, BTF_TEXTURE_RESIDUAL_TEXELS).data;
    const size_t texels = enc_solution_texels(s), k = s->n_components;
    for (size_t t = 0; t < texels; t++) {
        for (size_t j = 0; j < k; j++) {
            s->residual_texels[t * k + j] = u[((j / 4) * texels + t) * 4 + j % 4];
        }
    }
}

static void unpack_residual_directions(const btf_material *material, enc_solution *s) {
    const int8_t *v = btf_material_texture(material, BTF_TEXTURE_RESIDUAL_DIRECTIONS).data;
    const size_t k = s->n_components, pairs = (size_t)s->n_views * (size_t)s->n_lights;
    for (size_t p = 0; p < pairs; p++) {
        for (size_t channel = 0; channel < 3; channel++) {
            for (size_t j = 0; j < k; j++) {
                s->residual_directions[(p * 3 + channel) * k + j] =
                    v[((3 * (j / 4) + channel) * pairs + p) * 4 + j % 4];
            }
        }
    }
    memcpy(s->residual_scales, btf_material_texture(material, BTF_TEXTURE_RESIDUAL_SCALES).data,
           k * sizeof(float));
}

static bool copy_texture(const btf_material *material, uint32_t level, btf_texture_id id, void **out) {
    const btf_texture texture = btf_material_level_texture(material, level, id);
    *out = malloc(texture.size);
    if (*out) {
        memcpy(*out, texture.data, texture.size);
    }
    return *out;
}

/* Unpacks the heights of a level, where the material has them. */
static bool unpack_heights(const btf_material *material, uint32_t level, enc_solution *s) {
    void *heights = NULL;
    const bool ok = !btf_material_level_texture(material, level, BTF_TEXTURE_HEIGHTS).data ||
                    copy_texture(material, level, BTF_TEXTURE_HEIGHTS, &heights);
    s->relief.heights = heights;
    return ok;
}

/* Takes relief and gloss of level 0 from a material. */
static bool unpack_relief(const btf_material *material, const btf_material_info *info, enc_solution *s) {
    const float *vectors = btf_material_texture(material, BTF_TEXTURE_VIEW_VECTORS).data;
    s->relief = (enc_relief_store){.effects = info->effects & (BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS),
                                   .width = (int)info->width,
                                   .height = (int)info->height,
                                   .views = calloc(info->n_views, 1),
                                   .base = info->relief_base,
                                   .step = info->relief_step,
                                   .steps = info->relief_steps,
                                   .gloss_share = info->gloss_share,
                                   .end = info->relief_end};
    for (uint32_t v = 0; v < info->n_views && s->relief.views && vectors; v++) {
        s->relief.views[v] = vectors[4 * v + 3] != 0;
    }
    return unpack_heights(material, 0, s) && s->relief.views;
}

static bool unpack_factor_texels(const btf_material *material, uint32_t level, enc_solution *s) {
    void *texels;
    const bool ok = copy_texture(material, level, BTF_TEXTURE_FACTOR_TEXELS, &texels);
    s->factors.texels = texels;
    return ok;
}

/* Unpacks the factors of level 0. */
static bool unpack_factors(const btf_material *material, const btf_material_info *info, enc_solution *s) {
    void *directions, *scales, *views;
    s->factors = (enc_factor_store){.units = info->components,
                                    .layers = enc_store_layers(info->factor_classes),
                                    .horizon_scale = info->horizon_scale};
    memcpy(s->factors.classes, info->factor_classes, sizeof s->factors.classes);
    bool ok = copy_texture(material, 0, BTF_TEXTURE_FACTOR_DIRECTIONS, &directions);
    ok = copy_texture(material, 0, BTF_TEXTURE_FACTOR_SCALES, &scales) && ok;
    ok = copy_texture(material, 0, BTF_TEXTURE_FACTOR_VIEWS, &views) && ok;
    s->factors.directions = directions;
    s->factors.scales = scales;
    s->factors.views = views;
    return unpack_factor_texels(material, 0, s) && ok;
}

/* Makes room for the maps of texels. */
static bool allocate_texels(const btf_material_info *info, enc_solution *s) {
    const size_t texels = enc_solution_texels(s), points = texels * info->n_views;
    bool ok =
        info->colour == BTF_COLOUR_NONE ||
        enc_sbrdf_create(texels, (int)info->lobes, info->colour == BTF_COLOUR_RGB, &s->sbrdf) == BTF_OK;
    s->shift = calloc(points, 2);
    s->gain = calloc(points, 1);
    s->centre = calloc(points, sizeof *s->centre);
    ok = ok && s->shift && s->gain && s->centre;
    if (info->effects & BTF_EFFECT_SHADOW) {
        ok = (s->shadow = calloc(texels, info->n_lights)) && ok;
    }
    if (s->n_components > 0) {
        ok = (s->residual_texels = calloc(texels, s->n_components)) && ok;
    }
    return ok;
}

btf_result enc_unpack(const enc_context *context, const btf_material *material, enc_solution *s) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_result result = btf_material_get_info(material, &info);
    if (result != BTF_OK) {
        return result;
    }
    *s = (enc_solution){.width = (int)info.width,
                        .height = (int)info.height,
                        .n_views = (int)info.n_views,
                        .n_lights = (int)info.n_lights,
                        .domain = info.domain,
                        .effects = info.effects,
                        .radiance_scale = info.radiance_scale,
                        .shadow_scale = info.shadow_scale,
                        .gain_scale = info.gain_scale,
                        .packed = info.point_store != BTF_POINTS_SEPARATE,
                        .point_entries = (int)info.point_entries,
                        .gain_base = info.gain_base,
                        .gain_step = info.gain_step,
                        .n_centres = info.centres,
                        .centre_scale = info.centre_scale,
                        .n_components = info.store == BTF_STORE_FACTORS ? 0 : info.components,
                        .blend = info.blend};
    bool ok = allocate_texels(&info, s);
    if (info.centres > 0) {
        ok = (s->centre_codes = calloc((size_t)info.centres * info.n_lights, 3)) && ok;
    }
    if (s->n_components > 0) {
        ok = (s->residual_directions = calloc((size_t)info.n_views * info.n_lights * 3, s->n_components)) &&
             ok;
        ok = (s->residual_scales = calloc(s->n_components, sizeof *s->residual_scales)) && ok;
    }
    if (info.store == BTF_STORE_FACTORS) {
        ok = unpack_factors(material, &info, s) && ok;
    }
    if (info.effects & (BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS)) {
        ok = unpack_relief(material, &info, s) && ok;
    }
    if (!ok) {
        enc_solution_clear(s);
        return enc_fail(context, BTF_ERROR_MEMORY, "unpacking: out of memory");
    }
    if (s->sbrdf) {
        unpack_sbrdf(&info, btf_material_texture(material, BTF_TEXTURE_SBRDF).data, s->sbrdf);
    }
    if (info.layout == BTF_LAYOUT_TIGHT) {
        unpack_tight(material, 0, s);
        unpack_centres(material, s);
    } else if (btf_material_texture(material, BTF_TEXTURE_MAPS).data) {
        unpack_maps(&info, btf_material_texture(material, BTF_TEXTURE_MAPS).data, s);
    } else { /* without maps no point is hidden */
        memset(s->gain, BTF_GAIN_ONE, enc_solution_texels(s) * info.n_views);
    }
    if (s->n_components > 0) {
        unpack_residual_texels(material, 0, s);
        unpack_residual_directions(material, s);
    }
    return BTF_OK;
}

btf_result enc_unpack_level(const enc_context *context, const btf_material *material, uint32_t level,
                            const enc_solution *base, enc_solution *s) {
    btf_material_info info = {.struct_size = sizeof info};
    const btf_result result = btf_material_get_info(material, &info);
    if (result != BTF_OK) {
        return result;
    }
    *s =
        enc_level_of(base, (int)btf_level_size(info.width, level), (int)btf_level_size(info.height, level));
    const bool factors = info.store == BTF_STORE_FACTORS;
    if (!allocate_texels(&info, s) || (factors && !unpack_factor_texels(material, level, s)) ||
        !unpack_heights(material, level, s)) {
        enc_level_clear(s);
        return enc_fail(context, BTF_ERROR_MEMORY, "unpacking: out of memory");
    }
    if (s->sbrdf) {
        unpack_sbrdf(&info, btf_material_level_texture(material, level, BTF_TEXTURE_SBRDF).data, s->sbrdf);
    }
    unpack_tight(material, level, s);
    if (s->n_components > 0) {
        unpack_residual_texels(material, level, s);
    }
    return BTF_OK;
}

btf_result enc_levels_unpack(const enc_context *context, const btf_material *material,
                             const enc_solution *base, enc_levels *out_levels) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_result result = btf_material_get_info(material, &info);
    if (result != BTF_OK) {
        return result;
    }
    *out_levels =
        (enc_levels){.count = (int)info.levels, .level = calloc(info.levels, sizeof(enc_solution))};
    if (!out_levels->level) {
        *out_levels = (enc_levels){0};
        return enc_fail(context, BTF_ERROR_MEMORY, "levels: out of memory");
    }
    for (uint32_t i = 1; i < info.levels && result == BTF_OK; i++) {
        result = enc_unpack_level(context, material, i, base, &out_levels->level[i - 1]);
    }
    if (result != BTF_OK) {
        enc_levels_clear(out_levels);
    }
    return result;
}
