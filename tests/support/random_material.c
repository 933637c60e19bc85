/* Valid materials of any shape filled with seeded random values.
 *
 * SPDX-License-Identifier: MIT
 */
#include "random_material.h"
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

uint64_t random_next(random_state *r) {
    uint64_t z = r->state += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return z ^ z >> 31;
}

uint32_t random_below(random_state *r, uint32_t n) {
    return (uint32_t)((random_next(r) >> 32) * n >> 32);
}

double random_unit(random_state *r) {
    return (double)(random_next(r) >> 11) * 0x1p-53;
}

static void from_angles(double theta, double phi, float out[3]) {
    out[0] = (float)(sin(theta * PI / 180) * cos(phi * PI / 180));
    out[1] = (float)(sin(theta * PI / 180) * sin(phi * PI / 180));
    out[2] = (float)cos(theta * PI / 180);
}

void random_rings(uint32_t count, double theta_max, float *out) {
    uint32_t rings = 0, done = 0;
    for (uint32_t held = 0; held < count; rings++) {
        held += rings ? 6 * rings : 1;
    }
    for (uint32_t ring = 0; ring < rings; ring++) {
        uint32_t n = ring ? 6 * ring : 1;
        n = n < count - done ? n : count - done;
        for (uint32_t i = 0; i < n; i++, done++) {
            from_angles(rings > 1 ? theta_max * ring / (rings - 1) : 0, 360.0 * i / n, out + 3 * done);
        }
    }
}

void random_directions(random_state *r, uint32_t count, double theta_max, float *out) {
    for (uint32_t i = 0; i < count; i++) {
        double z = 1 - random_unit(r) * (1 - cos(theta_max * PI / 180));
        from_angles(acos(z) * 180 / PI, random_unit(r) * 360, out + 3 * (size_t)i);
    }
}

static uint32_t add_ring(double theta, uint32_t n, double offset, float (*out)[3], uint32_t at) {
    for (uint32_t i = 0; i < n; i++) {
        from_angles(theta, offset + 360.0 * i / n, out[at++]);
    }
    return at;
}

void random_ubo2003(float out[81][3]) {
    static const uint32_t n[6] = {1, 6, 12, 18, 20, 24};
    uint32_t at = 0;
    for (int ring = 0; ring < 6; ring++) {
        at = add_ring(15.0 * ring, n[ring], 0, out, at);
    }
}

void random_ubo2014(float out[151][3]) {
    static const double theta[10] = {0, 11, 23.5, 30, 37.5, 45, 52.5, 60, 67.5, 75};
    static const uint32_t n[10] = {1, 6, 12, 12, 12, 18, 18, 24, 24, 24};
    static const double offset[10] = {0, 15, 0, 15, 0, 0, 7.5, 0, 7.5, 0};
    uint32_t at = 0;
    for (int ring = 0; ring < 10; ring++) {
        at = add_ring(theta[ring], n[ring], offset[ring], out, at);
    }
}

btf_material_desc random_material_desc(uint32_t width, uint32_t height, uint32_t n_views, uint32_t n_lights,
                                       btf_layout layout, uint32_t effects) {
    btf_material_desc desc = {.struct_size = sizeof desc};
    /* clang-format off */
    desc.info = (btf_material_info){
        .struct_size = sizeof desc.info, .width = width, .height = height, .n_views = n_views,
        .n_lights = n_lights, .layout = layout, .effects = effects, .lobes = 3,
        .centres = effects & BTF_EFFECT_HIDDEN ? 7 : 0, .components = effects & BTF_EFFECT_RESIDUAL ? 5 : 0,
        .radiance_scale = 1, .shadow_scale = 0x1p-7f, .gain_scale = BTF_GAIN_SCALE, .centre_scale = 0x1p-8f,
    };
    /* clang-format on */
    if (effects & BTF_EFFECT_RELIEF) { /* from a texel below the plane to two above, and a bit */
        desc.info.relief_base = -256;
        desc.info.relief_step = 801;
        desc.info.relief_steps = 7;
    }
    desc.info.gloss_share = effects & BTF_EFFECT_GLOSS ? 1 : 0;
    float *views = malloc(sizeof(float[3]) * n_views), *lights = malloc(sizeof(float[3]) * n_lights);
    if (!views || !lights) {
        abort();
    }
    random_rings(n_views, 75, views);
    random_rings(n_lights, 80, lights);
    desc.views = views;
    desc.lights = lights;
    return desc;
}

/* 0, or of magnitude 2^-10 to 2^3, now and then 2^-24 or 2^24. */
static float random_parameter(random_state *r) {
    uint32_t kind = random_below(r, 32);
    float sign = random_below(r, 2) ? -1.0f : 1.0f;
    if (kind == 0) {
        return 0;
    }
    if (kind == 1) {
        return sign * 0x1p-24f;
    }
    if (kind == 2) {
        return sign * 0x1p24f;
    }
    return sign * (float)ldexp(1 + random_unit(r), (int)random_below(r, 13) - 10);
}

static uint16_t random_half(random_state *r) {
    uint16_t bits = (uint16_t)random_next(r);
    return (bits & 0x7C00) == 0x7C00 || (bits & 0x7C00) == 0 ? 0 : bits; /* normal */
}

static void fill_sbrdf(random_state *r, const btf_material_info *info, const btf_texture *t, void *data) {
    uint32_t used = info->colour == BTF_COLOUR_MONO ? 4 : 3 + 3 * info->lobes;
    uint32_t lead = t->layers - info->lobes;
    size_t texels = (size_t)t->width * t->height;
    for (uint32_t layer = 0; layer < t->layers; layer++) {
        for (size_t i = 0; i < 4 * texels; i++) {
            size_t at = 4 * texels * layer + i;
            if (layer < lead && 4 * layer + i % 4 >= used) {
                continue;
            }
            if (info->half_float) {
                ((uint16_t *)data)[at] = random_half(r);
            } else {
                ((float *)data)[at] = random_parameter(r);
            }
        }
    }
}

/* Gain code and shift bytes of a point. */
static void random_point(random_state *r, const btf_material_info *info, uint8_t out[3]) {
    bool hidden = info->effects & BTF_EFFECT_HIDDEN && random_below(r, 3) == 0;
    uint32_t bytes = random_below(r, 65536);
    out[0] = (uint8_t)(info->effects & BTF_EFFECT_GAIN ? 1 + random_below(r, 255) : BTF_GAIN_ONE);
    if (hidden) {
        out[0] = 0;
        bytes = random_below(r, info->centres);
    } else if (!(info->effects & BTF_EFFECT_SHIFT)) {
        bytes = 0;
    }
    out[1] = (uint8_t)bytes;
    out[2] = (uint8_t)(bytes >> 8);
}

static void fill_maps(random_state *r, const btf_material_info *info, uint8_t *data) {
    uint32_t tiles = info->n_views > info->n_lights ? info->n_views : info->n_lights;
    uint32_t columns = info->atlas_width / info->width;
    for (uint32_t tile = 0; tile < tiles; tile++) {
        for (uint32_t y = 0; y < info->height; y++) {
            for (uint32_t x = 0; x < info->width; x++) {
                size_t row = tile / columns * info->height + y, column = tile % columns * info->width + x;
                uint8_t *texel = data + 4 * (row * info->atlas_width + column);
                if (tile < info->n_lights && info->effects & BTF_EFFECT_SHADOW) {
                    texel[0] = (uint8_t)random_next(r);
                }
                if (tile < info->n_views) {
                    random_point(r, info, texel + 1);
                }
                if (!(info->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN))) {
                    texel[1] = 0; /* no code is stored */
                }
            }
        }
    }
    for (uint32_t i = 0; i < info->centres; i++) {
        uint32_t x, y;
        btf_material_atlas_centre(info, i, &x, &y);
        for (uint32_t l = 0; l < info->n_lights; l++) {
            for (int c = 0; c < 3; c++) {
                data[4 * ((size_t)(y + l) * info->atlas_width + x) + (size_t)c] = (uint8_t)random_next(r);
            }
        }
    }
}

static void fill_points(random_state *r, const btf_material_info *info, uint8_t *shift, uint8_t *gain) {
    size_t points = (size_t)info->width * info->height * info->n_views;
    for (size_t i = 0; i < points; i++) {
        uint8_t point[3];
        random_point(r, info, point);
        if (gain) {
            gain[i] = point[0];
        }
        if (shift) {
            memcpy(shift + 2 * i, point + 1, 2);
        }
    }
}

static void fill_centres(random_state *r, const btf_material_info *info, const btf_texture *t,
                         uint8_t *data) {
    for (uint32_t i = 0; i < info->centres; i++) {
        for (uint32_t l = 0; l < info->n_lights; l++) {
            for (size_t c = 0; c < 3; c++) {
                data[4 * ((size_t)(i % t->height) * t->width + i / t->height * info->n_lights + l) + c] =
                    (uint8_t)random_next(r);
            }
        }
    }
}

static void fill_residual(random_state *r, const btf_texture *t, uint32_t components,
                          uint32_t layers_a_quad, int8_t *data) {
    size_t texels = (size_t)t->width * t->height;
    for (uint32_t layer = 0; layer < t->layers; layer++) {
        for (size_t i = 0; i < 4 * texels; i++, data++) {
            if (layer / layers_a_quad * 4 + i % 4 < components) {
                *data = (int8_t)((int)random_below(r, 255) - 127);
            }
        }
    }
}

/* Lists of points, of which each may be anything; indices of entries, two views a byte, the odd last one alone. */
static void fill_lists(random_state *r, const btf_material_info *info, size_t size, uint8_t *lists,
                       uint8_t *indices) {
    const size_t texels = (size_t)info->width * info->height;
    for (size_t i = 0; i < size; i++) {
        lists[i] = (uint8_t)random_next(r);
    }
    for (size_t i = 0; i < info->n_views * texels; i++) {
        indices[i / texels / 2 * texels + i % texels] |=
            (uint8_t)(random_below(r, info->point_entries) << (i / texels % 2 * 4));
    }
}

/* Textures of a level; info's size is that of the level. */
static void fill_level(random_state *r, const btf_material_info *info, const btf_texture *shape,
                       void *const *data) {
    if (data[BTF_TEXTURE_SBRDF]) {
        fill_sbrdf(r, info, &shape[BTF_TEXTURE_SBRDF], data[BTF_TEXTURE_SBRDF]);
    }
    if (data[BTF_TEXTURE_MAPS]) {
        fill_maps(r, info, data[BTF_TEXTURE_MAPS]);
    }
    if (data[BTF_TEXTURE_SHADOW]) {
        for (size_t i = 0; i < shape[BTF_TEXTURE_SHADOW].size; i++) {
            ((uint8_t *)data[BTF_TEXTURE_SHADOW])[i] = (uint8_t)random_next(r);
        }
    }
    if (data[BTF_TEXTURE_SHIFT] || data[BTF_TEXTURE_GAIN]) {
        fill_points(r, info, data[BTF_TEXTURE_SHIFT], data[BTF_TEXTURE_GAIN]);
    }
    for (size_t i = 0; data[BTF_TEXTURE_POINTS] && i < shape[BTF_TEXTURE_POINTS].size; i++) {
        ((uint8_t *)data[BTF_TEXTURE_POINTS])[i] = (uint8_t)random_next(r);
    }
    if (data[BTF_TEXTURE_POINT_LISTS]) {
        fill_lists(r, info, shape[BTF_TEXTURE_POINT_LISTS].size, data[BTF_TEXTURE_POINT_LISTS],
                   data[BTF_TEXTURE_POINT_INDICES]);
    }
    for (size_t i = 0; data[BTF_TEXTURE_HEIGHTS] && i < shape[BTF_TEXTURE_HEIGHTS].size; i++) {
        ((uint8_t *)data[BTF_TEXTURE_HEIGHTS])[i] = (uint8_t)random_next(r);
    }
    if (data[BTF_TEXTURE_CENTRES]) {
        fill_centres(r, info, &shape[BTF_TEXTURE_CENTRES], data[BTF_TEXTURE_CENTRES]);
    }
    if (data[BTF_TEXTURE_RESIDUAL_TEXELS]) {
        fill_residual(r, &shape[BTF_TEXTURE_RESIDUAL_TEXELS], info->components, 1,
                      data[BTF_TEXTURE_RESIDUAL_TEXELS]);
    }
    if (data[BTF_TEXTURE_RESIDUAL_DIRECTIONS]) {
        fill_residual(r, &shape[BTF_TEXTURE_RESIDUAL_DIRECTIONS], info->components, 3,
                      data[BTF_TEXTURE_RESIDUAL_DIRECTIONS]);
    }
    if (data[BTF_TEXTURE_RESIDUAL_SCALES]) {
        for (uint32_t i = 0; i < info->components; i++) {
            ((float *)data[BTF_TEXTURE_RESIDUAL_SCALES])[i] = random_parameter(r);
        }
    }
}

void random_material_relief(random_state *r, btf_material_desc *desc) {
    btf_material_info *info = &desc->info;
    if (info->effects & BTF_EFFECT_RELIEF) {
        const uint32_t kind = random_below(r, 8);
        info->relief_base = kind == 0 ? INT16_MIN : (int32_t)random_below(r, 1200) - 600;
        info->relief_step = kind < 2 ? INT16_MAX : kind < 4 ? 0 : (int32_t)random_below(r, 1000);
        if (info->relief_base + (255 * info->relief_step >> 8) > INT16_MAX) {
            info->relief_base = INT16_MAX - (255 * info->relief_step >> 8);
        }
        info->relief_steps = info->relief_step == 0 ? 1 : 1 + random_below(r, BTF_MAX_RELIEF_STEPS);
        const uint32_t levels = info->levels ? info->levels : 1;
        info->relief_level = random_below(r, 2) ? 0 : random_below(r, BTF_MAX_LEVELS - levels + 1);
        info->relief_end = random_below(r, 2) ? 0 : 1 + random_below(r, levels);
        if (random_below(r, 2)) {
            uint8_t *acts = malloc(info->n_views);
            if (!acts) {
                abort();
            }
            for (uint32_t v = 0; v < info->n_views; v++) {
                acts[v] = (uint8_t)random_below(r, 2);
            }
            desc->relief_views = acts;
        }
    }
    info->gloss_share = info->effects & BTF_EFFECT_GLOSS ? 1 + random_below(r, 2) : 0;
}

void random_material_fill(random_state *r, btf_material_desc *desc) {
    btf_material_info *info = &desc->info;
    if (info->layout == BTF_LAYOUT_PAPER && info->atlas_width == 0) {
        uint32_t room;
        if (btf_material_atlas(info, &info->atlas_width, &info->atlas_height, &room)) {
            abort();
        }
        info->centres = info->centres < room ? info->centres : room;
    }
    for (uint32_t level = 0; level < (info->levels ? info->levels : 1); level++) {
        void *data[BTF_TEXTURE_COUNT] = {0};
        btf_texture shape[BTF_TEXTURE_COUNT];
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            shape[id] = btf_material_level_shape(info, level, (btf_texture_id)id);
            if (shape[id].size == 0) {
                continue;
            }
            data[id] = calloc(1, shape[id].size);
            if (!data[id]) {
                abort();
            }
            *(level ? &desc->level_texture[level][id] : &desc->texture[id]) = data[id];
        }
        btf_material_info of_level = *info;
        of_level.width = btf_level_size(info->width, level);
        of_level.height = btf_level_size(info->height, level);
        fill_level(r, &of_level, shape, data);
    }
}

void random_material_free(btf_material_desc *desc) {
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        free((void *)(uintptr_t)desc->texture[id]);
    }
    for (int level = 1; level < BTF_MAX_LEVELS; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            free((void *)(uintptr_t)desc->level_texture[level][id]);
        }
    }
    free((void *)(uintptr_t)desc->views);
    free((void *)(uintptr_t)desc->lights);
    free((void *)(uintptr_t)desc->relief_views);
    *desc = (btf_material_desc){0};
}

void *random_material_save(random_state *r, btf_material_desc *desc, size_t *size) {
    btf_material *material;
    void *data;
    random_material_fill(r, desc);
    if (btf_material_create(desc, NULL, &material) ||
        btf_material_save_memory(material, NULL, &data, size)) {
        abort();
    }
    btf_material_close(&material);
    random_material_free(desc);
    return data;
}
