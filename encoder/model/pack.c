/* Packing (paper 3.1). See pack.h; the layouts are those of decoder/FORMAT.md sections 3 to 5.
 *
 * SPDX-License-Identifier: MIT
 */
#include "pack.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

static btf_material_info describe(const enc_data *data, const enc_solution *s, const enc_pack_options *o) {
    btf_material_info info = {.struct_size = sizeof info};
    info.width = (uint32_t)s->width;
    info.height = (uint32_t)s->height;
    info.n_views = (uint32_t)s->n_views;
    info.n_lights = (uint32_t)s->n_lights;
    info.layout = o->layout;
    info.domain = s->domain;
    info.colour = !s->sbrdf ? BTF_COLOUR_NONE : s->sbrdf->rgb ? BTF_COLOUR_RGB : BTF_COLOUR_MONO;
    info.half_float = s->sbrdf && (o->half_float || s->half_parameters);
    info.lobes = s->sbrdf ? (uint32_t)s->sbrdf->lobes : 0;
    info.effects = s->effects;
    info.centres = s->effects & BTF_EFFECT_HIDDEN ? s->n_centres : 0;
    info.components = enc_solution_components(s);
    info.blend = s->blend;
    if (s->factors.units > 0) {
        info.store = BTF_STORE_FACTORS;
        info.horizon_scale = s->factors.horizon_scale;
        memcpy(info.factor_classes, s->factors.classes, sizeof info.factor_classes);
    }
    info.radiance_scale = s->radiance_scale;
    info.shadow_scale = s->effects & BTF_EFFECT_SHADOW ? s->shadow_scale : 1.0f / 255.0f;
    info.gain_scale = s->effects & BTF_EFFECT_GAIN ? s->gain_scale : BTF_GAIN_SCALE;
    if (s->packed) {
        info.point_store = s->point_entries > 0 ? BTF_POINTS_LISTS : BTF_POINTS_PACKED;
        info.point_entries = (uint32_t)s->point_entries;
        info.gain_base = s->gain_base;
        info.gain_step = s->gain_step;
    }
    if (s->effects & BTF_EFFECT_RELIEF) {
        info.relief_base = s->relief.base;
        info.relief_step = s->relief.step;
        info.relief_steps = s->relief.steps;
        info.relief_end = s->relief.end;
    }
    info.gloss_share = s->effects & BTF_EFFECT_GLOSS ? s->relief.gloss_share : 0;
    info.centre_scale = info.centres > 0 ? s->centre_scale : 1.0f / 255.0f;
    info.levels = o->levels > 0 ? (uint32_t)o->levels : 1;
    info.method = o->method;
    info.options = o->options;
    info.source = o->source ? o->source : data->source;
    return info;
}

/* Spreads the parameter blocks of enc_sbrdf over RGBA layers (FORMAT.md section 4). */
static void pack_sbrdf(const enc_sbrdf *sbrdf, bool half, void *out) {
    const size_t stride = enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb);
    for (size_t t = 0; t < sbrdf->n_texels; t++) {
        for (size_t i = 0; i < stride; i++) {
            const size_t at = enc_sbrdf_texture_index(sbrdf, t, i);
            const float value = sbrdf->values[t * stride + i];
            if (half) {
                ((uint16_t *)out)[at] = enc_half_from_float(value);
            } else {
                ((float *)out)[at] = value;
            }
        }
    }
}

/* The two shift bytes of section 3 at [view * texels + texel]. */
static void shift_bytes(const enc_solution *s, size_t at, uint8_t out[2]) {
    if ((s->effects & BTF_EFFECT_HIDDEN) && s->gain[at] == 0) {
        out[0] = (uint8_t)(s->centre[at] & 255);
        out[1] = (uint8_t)(s->centre[at] >> 8);
    } else if (s->effects & BTF_EFFECT_SHIFT) {
        out[0] = (uint8_t)s->shift[2 * at];
        out[1] = (uint8_t)s->shift[2 * at + 1];
    } else {
        out[0] = out[1] = 0;
    }
}

/* The two bytes of a packed point. */
static void point_bytes(const enc_solution *s, size_t at, uint8_t out[2]) {
    const int columns = s->shift[2 * at] + 32, rows = s->shift[2 * at + 1] + 32, code = s->gain[at];
    assert(columns >= 0 && columns < 64 && rows >= 0 && rows < 64 && code < 16);
    const int p = columns | rows << 6 | code << 12;
    out[0] = (uint8_t)p;
    out[1] = (uint8_t)(p >> 8);
}

/* Fills in the lists of packed points, with entries in the order in which rising views first name them, and
 * the views' indices; the caller zeroes both. Where a texel's list has no room, returns false and the
 * texel. */
static bool pack_point_lists(const enc_solution *s, uint8_t *lists, uint8_t *indices, size_t *out_texel) {
    const size_t texels = enc_solution_texels(s);
    for (size_t t = 0; t < texels; t++) {
        int used = 0;
        for (int view = 0; view < s->n_views; view++) {
            uint8_t point[2];
            point_bytes(s, (size_t)view * texels + t, point);
            int entry = 0;
            while (entry < used && memcmp(lists + 2 * ((size_t)entry * texels + t), point, 2) != 0) {
                entry++;
            }
            if (entry == s->point_entries) {
                *out_texel = t;
                return false;
            }
            memcpy(lists + 2 * ((size_t)entry * texels + t), point, 2);
            used = entry == used ? used + 1 : used;
            indices[(size_t)(view / 2) * texels + t] |= (uint8_t)(entry << 4 * (view % 2));
        }
    }
    return true;
}

static void pack_maps(const btf_material_info *info, const enc_solution *s, uint8_t *maps) {
    const size_t width = info->width, height = info->height, texels = width * height;
    const size_t columns = info->atlas_width / width;
    const bool has_code = s->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN);
    const size_t tiles = info->n_views > info->n_lights ? info->n_views : info->n_lights;
    for (size_t i = 0; i < tiles; i++) {
        for (size_t t = 0; t < texels; t++) {
            const size_t x = (i % columns) * width + t % width, y = (i / columns) * height + t / width;
            uint8_t *out = maps + 4 * (y * info->atlas_width + x);
            if (i < info->n_lights && (s->effects & BTF_EFFECT_SHADOW)) {
                out[0] = s->shadow[i * texels + t];
            }
            if (i < info->n_views) {
                out[1] = has_code ? s->gain[i * texels + t] : 0;
                shift_bytes(s, i * texels + t, out + 2);
            }
        }
    }
    for (uint32_t c = 0; c < info->centres; c++) {
        uint32_t x, y;
        btf_material_atlas_centre(info, c, &x, &y);
        for (uint32_t l = 0; l < info->n_lights; l++) {
            memcpy(maps + 4 * ((size_t)(y + l) * info->atlas_width + x),
                   s->centre_codes + 3 * ((size_t)c * info->n_lights + l), 3);
        }
    }
}

static void pack_centres(const btf_material_info *info, const enc_solution *s, const btf_texture *shape,
                         uint8_t *out) {
    for (uint32_t c = 0; c < info->centres; c++) {
        const uint32_t row = c % shape->height, block = c / shape->height;
        for (uint32_t l = 0; l < info->n_lights; l++) {
            memcpy(out + 4 * ((size_t)row * shape->width + (size_t)block * info->n_lights + l),
                   s->centre_codes + 3 * ((size_t)c * info->n_lights + l), 3);
        }
    }
}

static void pack_residual_texels(const enc_solution *s, int8_t *out) {
    const size_t texels = enc_solution_texels(s), k = s->n_components;
    for (size_t t = 0; t < texels; t++) {
        for (size_t j = 0; j < k; j++) {
            out[((j / 4) * texels + t) * 4 + j % 4] = s->residual_texels[t * k + j];
        }
    }
}

static void pack_residual_directions(const enc_solution *s, int8_t *out) {
    const size_t pairs = (size_t)s->n_views * (size_t)s->n_lights, k = s->n_components;
    for (size_t p = 0; p < pairs; p++) {
        for (size_t channel = 0; channel < 3; channel++) {
            for (size_t j = 0; j < k; j++) {
                out[((3 * (j / 4) + channel) * pairs + p) * 4 + j % 4] =
                    s->residual_directions[(p * 3 + channel) * k + j];
            }
        }
    }
}

static void fill(const btf_material_info *info, const enc_solution *s, btf_texture_id id,
                 const btf_texture *shape, void *out) {
    const size_t map_texels = (size_t)s->n_views * enc_solution_texels(s);
    switch (id) {
    case BTF_TEXTURE_SBRDF:
        pack_sbrdf(s->sbrdf, info->half_float, out);
        break;
    case BTF_TEXTURE_MAPS:
        pack_maps(info, s, out);
        break;
    case BTF_TEXTURE_SHADOW:
        memcpy(out, s->shadow, shape->size);
        break;
    case BTF_TEXTURE_SHIFT:
        for (size_t i = 0; i < map_texels; i++) {
            shift_bytes(s, i, (uint8_t *)out + 2 * i);
        }
        break;
    case BTF_TEXTURE_GAIN:
        memcpy(out, s->gain, shape->size);
        break;
    case BTF_TEXTURE_POINTS:
        for (size_t i = 0; i < map_texels; i++) {
            point_bytes(s, i, (uint8_t *)out + 2 * i);
        }
        break;
    case BTF_TEXTURE_HEIGHTS:
        memcpy(out, s->relief.heights, shape->size);
        break;
    case BTF_TEXTURE_CENTRES:
        pack_centres(info, s, shape, out);
        break;
    case BTF_TEXTURE_RESIDUAL_TEXELS:
        pack_residual_texels(s, out);
        break;
    case BTF_TEXTURE_RESIDUAL_DIRECTIONS:
        pack_residual_directions(s, out);
        break;
    case BTF_TEXTURE_RESIDUAL_SCALES:
        memcpy(out, s->residual_scales, s->n_components * sizeof(float));
        break;
    case BTF_TEXTURE_FACTOR_TEXELS:
        memcpy(out, s->factors.texels, shape->size);
        break;
    case BTF_TEXTURE_FACTOR_DIRECTIONS:
        memcpy(out, s->factors.directions, shape->size);
        break;
    case BTF_TEXTURE_FACTOR_SCALES:
        memcpy(out, s->factors.scales, shape->size);
        break;
    case BTF_TEXTURE_FACTOR_VIEWS:
        memcpy(out, s->factors.views, shape->size);
        break;
    case BTF_TEXTURE_POINT_LISTS:
    case BTF_TEXTURE_POINT_INDICES:
        break; /* pack_level makes both together */
    default:
        assert(!"internal error: direction tables are not packed here");
    }
}

/* Makes the textures that belong to one level alone; out [BTF_TEXTURE_COUNT] owns them. */
static btf_result pack_level(const enc_context *context, const btf_material_info *info, uint32_t level,
                             const enc_solution *solution, void **out) {
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) { /* tables, which are made later, have no shape */
        const btf_texture shape = btf_material_level_shape(info, level, (btf_texture_id)id);
        if (shape.format == BTF_FORMAT_NONE) {
            continue;
        }
        out[id] = calloc(1, shape.size);
        if (!out[id]) {
            return enc_fail(context, BTF_ERROR_MEMORY, "packing: out of memory for %zu bytes of %s",
                            shape.size, btf_texture_name((btf_texture_id)id));
        }
        fill(info, solution, (btf_texture_id)id, &shape, out[id]);
    }
    size_t texel;
    if (out[BTF_TEXTURE_POINT_LISTS] &&
        !pack_point_lists(solution, out[BTF_TEXTURE_POINT_LISTS], out[BTF_TEXTURE_POINT_INDICES], &texel)) {
        const size_t width = (size_t)solution->width;
        return enc_fail(context, BTF_ERROR_USAGE,
                        "packing: level %u, texel (%zu, %zu): more than %d different pairs of shift and gain",
                        level, texel % width, texel / width, solution->point_entries);
    }
    return BTF_OK;
}

static float *copy_directions(const enc_direction *directions, int count) {
    float *xyz = malloc((size_t)count * 3 * sizeof *xyz);
    if (xyz) {
        for (int i = 0; i < count; i++) {
            memcpy(xyz + 3 * i, directions[i].xyz, 3 * sizeof *xyz);
        }
    }
    return xyz;
}

btf_result enc_pack(const enc_context *context, const enc_data *data, const enc_solution *solution,
                    const enc_pack_options *options, btf_material **out_material) {
    *out_material = NULL;
    btf_material_desc desc = {.struct_size = sizeof desc};
    void *textures[BTF_MAX_LEVELS][BTF_TEXTURE_COUNT] = {{NULL}};
    float *views = NULL, *lights = NULL;
    btf_result result = BTF_OK;
    desc.info = describe(data, solution, options);
    if (options->layout == BTF_LAYOUT_PAPER) {
        uint32_t room = 0;
        result = btf_material_atlas(&desc.info, &desc.info.atlas_width, &desc.info.atlas_height, &room);
        if (result != BTF_OK) {
            enc_fail(context, result,
                     "no atlas of up to %d texels a side holds %d x %d texels with %d views, %d lights and "
                     "%u centres; --layout tight needs no atlas",
                     BTF_MAX_SIZE, solution->width, solution->height, solution->n_views, solution->n_lights,
                     desc.info.centres);
            goto done;
        }
        assert(desc.info.centres <= room);
    }
    views = copy_directions(data->views, data->n_views);
    lights = copy_directions(data->lights, data->n_lights);
    if (!views || !lights) {
        result = enc_fail(context, BTF_ERROR_MEMORY, "packing: out of memory");
        goto done;
    }
    for (uint32_t level = 0; level < desc.info.levels && result == BTF_OK; level++) {
        result = pack_level(context, &desc.info, level, level == 0 ? solution : &options->level[level - 1],
                            textures[level]);
    }
    if (result != BTF_OK) {
        goto done;
    }
    memcpy(desc.texture, textures[0], sizeof desc.texture);
    memcpy(desc.level_texture, textures, sizeof desc.level_texture);
    desc.views = views;
    desc.lights = lights;
    desc.errors = options->errors;
    desc.error_count = options->error_count;
    desc.effect_errors = options->effect_errors;
    desc.effect_error_count = options->effect_error_count;
    desc.effect_differences = options->effect_differences;
    desc.effect_difference_count = options->effect_difference_count;
    desc.between_errors = options->between_errors;
    desc.between_error_count = options->between_error_count;
    desc.level_errors = options->level_errors;
    desc.level_error_count = options->level_error_count;
    desc.preview = options->preview;
    desc.relief_views = solution->effects & BTF_EFFECT_RELIEF ? solution->relief.views : NULL;
    result = btf_material_create(&desc, context ? &context->log : NULL, out_material);
done:
    for (int i = 0; i < BTF_MAX_LEVELS * BTF_TEXTURE_COUNT; i++) {
        free(textures[i / BTF_TEXTURE_COUNT][i % BTF_TEXTURE_COUNT]);
    }
    free(views);
    free(lights);
    return result;
}

btf_result enc_pack_centre_room(const enc_context *context, int width, int height, int n_views,
                                int n_lights, uint32_t *out_room) {
    btf_material_info info = {.struct_size = sizeof info,
                              .width = (uint32_t)width,
                              .height = (uint32_t)height,
                              .n_views = (uint32_t)n_views,
                              .n_lights = (uint32_t)n_lights,
                              .layout = BTF_LAYOUT_PAPER,
                              .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN};
    uint32_t atlas_width, atlas_height;
    const btf_result result = btf_material_atlas(&info, &atlas_width, &atlas_height, out_room);
    if (result != BTF_OK) {
        return enc_fail(
            context, result,
            "no atlas of up to %d texels a side holds %d x %d texels with %d views and %d lights",
            BTF_MAX_SIZE, width, height, n_views, n_lights);
    }
    return BTF_OK;
}
