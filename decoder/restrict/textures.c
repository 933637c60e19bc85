/* OpenBTF: the textures of a restriction. See textures.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "textures.h"

#include "decoder/material.h"
#include "decoder/shape.h"

#include <stdlib.h>
#include <string.h>

static const void *whole_data(const btfi_restriction *r, uint32_t level, btf_texture_id id) {
    return btf_material_level_texture(r->whole, r->level + level, id).data;
}

/* Byte `channel` of tile i at texel t of the atlas. */
static uint8_t atlas_byte(const btf_material *m, uint32_t i, size_t t, size_t channel) {
    const size_t columns = m->info.atlas_width / m->info.width;
    const size_t x = i % columns * m->info.width + t % m->info.width;
    const size_t y = i / columns * m->info.height + t / m->info.width;
    return ((const uint8_t *)btf_material_texture(m, BTF_TEXTURE_MAPS)
                .data)[4 * (y * m->info.atlas_width + x) + channel];
}

/* Takes a packed point apart: gain code, then the two bytes of the shift. */
static void read_point(const uint8_t point[2], uint8_t out[3]) {
    const unsigned p = point[0] + 256u * point[1];
    out[0] = (uint8_t)(p >> 12);
    out[1] = (uint8_t)((p & 63) - 32);
    out[2] = (uint8_t)((p >> 6 & 63) - 32);
}

static uint8_t point_index(const uint8_t *indices, size_t view, size_t t, size_t texels) {
    return indices[view / 2 * texels + t] >> 4 * (view % 2) & 15;
}

/* The two bytes of a view's packed point, in a list or not. */
static const uint8_t *packed_point(const btfi_restriction *r, uint32_t level, size_t view, size_t t,
                                   size_t texels) {
    if (r->whole->info.point_store == BTF_POINTS_PACKED) {
        return (const uint8_t *)whole_data(r, level, BTF_TEXTURE_POINTS) + 2 * (view * texels + t);
    }
    const size_t entry = point_index(whole_data(r, level, BTF_TEXTURE_POINT_INDICES), view, t, texels);
    return (const uint8_t *)whole_data(r, level, BTF_TEXTURE_POINT_LISTS) + 2 * (entry * texels + t);
}

/* Copies a packed point, with a shift or a gain code of 0 where the plan leaves that effect out. */
static void copy_point(const btfi_restriction *r, const uint8_t *from, uint8_t *to) {
    const unsigned p = from[0] + 256u * from[1], shift = r->shift ? p & 0xFFF : 32 << 6 | 32;
    const unsigned point = shift | (r->gain ? p & 0xF000 : 0);
    to[0] = (uint8_t)point;
    to[1] = (uint8_t)(point >> 8);
}

static void fill_points(const btfi_restriction *r, uint32_t level, size_t texels, uint8_t *out) {
    for (uint32_t v = 0; v < r->views.count; v++) {
        for (size_t t = 0; t < texels; t++, out += 2) {
            copy_point(r, packed_point(r, level, r->views.number[v], t, texels), out);
        }
    }
}

static void fill_point_lists(const btfi_restriction *r, uint32_t level, const btf_texture *shape,
                             uint8_t *out) {
    const uint8_t *in = whole_data(r, level, BTF_TEXTURE_POINT_LISTS);
    for (size_t i = 0; i < shape->size; i += 2) {
        copy_point(r, in + i, out + i);
    }
}

static void fill_point_indices(const btfi_restriction *r, uint32_t level, size_t texels, uint8_t *out) {
    const uint8_t *in = whole_data(r, level, BTF_TEXTURE_POINT_INDICES);
    for (size_t v = 0; v < r->views.count; v++) {
        for (size_t t = 0; t < texels; t++) {
            out[v / 2 * texels + t] |=
                (uint8_t)(point_index(in, r->views.number[v], t, texels) << 4 * (v % 2));
        }
    }
}

/* Reads gain code and shift bytes as they are stored; 128 and 0, 0 stand for those that are not. */
static void read_codes(const btfi_restriction *r, uint32_t level, uint32_t view, size_t t, size_t texels,
                       uint8_t out[3]) {
    const btf_material_info *info = &r->whole->info;
    const bool code = info->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN);
    const bool bytes = info->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN);
    const size_t at = view * texels + t;
    if (btfi_shares_points(info)) {
        read_point(packed_point(r, level, view, t, texels), out);
        return;
    }
    const bool tight = info->layout == BTF_LAYOUT_TIGHT;
    const uint8_t *gain = tight && code ? whole_data(r, level, BTF_TEXTURE_GAIN) : NULL;
    const uint8_t *shift = tight && bytes ? whole_data(r, level, BTF_TEXTURE_SHIFT) : NULL;
    out[0] = !code ? BTF_GAIN_ONE : tight ? gain[at] : atlas_byte(r->whole, view, t, 1);
    for (size_t k = 0; k < 2; k++) {
        out[1 + k] = !bytes ? 0 : tight ? shift[2 * at + k] : atlas_byte(r->whole, view, t, 2 + k);
    }
}

/* Turns codes as read into those that the restriction stores. */
static void translate_codes(const btfi_restriction *r, uint8_t codes[3]) {
    const uint32_t effects = r->desc.info.effects;
    const bool hidden = codes[0] == 0 && (r->whole->info.effects & BTF_EFFECT_HIDDEN);
    if (hidden && (effects & BTF_EFFECT_HIDDEN)) {
        const uint32_t centre = r->centre[codes[1] + 256u * codes[2]];
        codes[1] = (uint8_t)centre;
        codes[2] = (uint8_t)(centre >> 8);
        return;
    }
    if (hidden || !(effects & BTF_EFFECT_GAIN)) {
        codes[0] = BTF_GAIN_ONE;
    }
    if (hidden || !(effects & BTF_EFFECT_SHIFT)) {
        codes[1] = codes[2] = 0;
    }
}

/* Numbers the centres that kept views show, in their order; at least one is kept. */
static void number_centres(btfi_restriction *r) {
    const btf_material_info *info = &r->whole->info;
    for (uint32_t i = 0; i < info->centres; i++) {
        r->centre[i] = UINT32_MAX;
    }
    for (uint32_t level = 0; level < r->desc.info.levels; level++) {
        const size_t texels =
            (size_t)btf_level_size(r->desc.info.width, level) * btf_level_size(r->desc.info.height, level);
        for (uint32_t v = 0; v < r->views.count; v++) {
            for (size_t t = 0; t < texels; t++) {
                uint8_t codes[3];
                read_codes(r, level, r->views.number[v], t, texels, codes);
                if (codes[0] == 0) {
                    r->centre[codes[1] + 256u * codes[2]] = 0;
                }
            }
        }
    }
    r->desc.info.centres = 0;
    for (uint32_t i = 0; i < info->centres; i++) {
        if (r->centre[i] == 0) {
            r->centre[i] = r->desc.info.centres++;
        }
    }
    if (r->desc.info.centres == 0) {
        r->centre[0] = 0;
        r->desc.info.centres = 1;
    }
}

static void fill_shadow(const btfi_restriction *r, uint32_t level, size_t texels, uint8_t *out) {
    const bool tight = r->whole->info.layout == BTF_LAYOUT_TIGHT;
    const uint8_t *in = tight ? whole_data(r, level, BTF_TEXTURE_SHADOW) : NULL;
    for (uint32_t l = 0; l < r->lights.count; l++) {
        for (size_t t = 0; t < texels; t++) {
            *out++ = tight ? in[r->lights.number[l] * texels + t]
                           : atlas_byte(r->whole, r->lights.number[l], t, 0);
        }
    }
}

/* Fills a texture of shift bytes, two a point, or of gain codes, one a point. */
static void fill_codes(const btfi_restriction *r, uint32_t level, size_t texels, bool shift, uint8_t *out) {
    for (uint32_t v = 0; v < r->views.count; v++) {
        for (size_t t = 0; t < texels; t++) {
            uint8_t codes[3];
            read_codes(r, level, r->views.number[v], t, texels, codes);
            translate_codes(r, codes);
            if (shift) {
                *out++ = codes[1];
                *out++ = codes[2];
            } else {
                *out++ = codes[0];
            }
        }
    }
}

static void fill_centres(const btfi_restriction *r, const btf_texture *shape, uint8_t *out) {
    const btf_material_info *info = &r->whole->info;
    const btf_texture centres = btf_material_texture(
        r->whole, info->layout == BTF_LAYOUT_TIGHT ? BTF_TEXTURE_CENTRES : BTF_TEXTURE_MAPS);
    for (uint32_t c = 0; c < info->centres; c++) {
        if (r->centre[c] == UINT32_MAX) {
            continue;
        }
        const size_t row = r->centre[c] % shape->height, block = r->centre[c] / shape->height;
        for (uint32_t i = 0; i < r->lights.count; i++) {
            const uint32_t l = r->lights.number[i];
            uint32_t x = c / centres.height * info->n_lights + l, y = c % centres.height;
            if (info->layout == BTF_LAYOUT_PAPER) {
                btf_material_atlas_centre(info, c, &x, &y);
                y += l;
            }
            memcpy(out + 4 * (row * shape->width + block * r->lights.count + i),
                   (const uint8_t *)centres.data + 4 * ((size_t)y * centres.width + x), 3);
        }
    }
}

/* Copies components of texels or of directions, four bytes each time, of which those from `count` on stay 0. */
static void copy_quads(const int8_t *in, size_t pairs, uint32_t count, int8_t *out) {
    for (size_t i = 0; i < pairs; i++) {
        memcpy(out + 4 * i, in + 4 * i, count < 4 ? count : 4);
    }
}

static void fill_residual(const btfi_restriction *r, uint32_t level, btf_texture_id id,
                          const btf_texture *shape, void *out) {
    const uint32_t k = r->desc.info.components, groups = (k + 3) / 4;
    const size_t plane = (size_t)shape->width * shape->height;
    const int8_t *in = id == BTF_TEXTURE_RESIDUAL_TEXELS ? whole_data(r, level, id)
                                                         : btf_material_texture(r->whole, id).data;
    for (uint32_t g = 0; g < groups; g++) {
        if (id == BTF_TEXTURE_RESIDUAL_TEXELS) {
            copy_quads(in + 4 * g * plane, plane, k - 4 * g, (int8_t *)out + 4 * g * plane);
            continue;
        }
        for (size_t layer = 3 * (size_t)g; layer < 3 * (size_t)g + 3; layer++) {
            for (uint32_t v = 0; v < r->views.count; v++) {
                for (uint32_t l = 0; l < r->lights.count; l++) {
                    const btf_material_info *info = &r->whole->info;
                    const size_t from =
                        (layer * info->n_views + r->views.number[v]) * info->n_lights + r->lights.number[l];
                    const size_t to = (layer * r->views.count + v) * r->lights.count + l;
                    copy_quads(in + 4 * from, 1, k - 4 * g, (int8_t *)out + 4 * to);
                }
            }
        }
    }
}

/* Copies the units of kept views and lights, or the factors of kept views: 16 bytes a texel. */
static void fill_factors(const btfi_restriction *r, btf_texture_id id, const btf_texture *shape,
                         uint8_t *out) {
    const btf_texture whole = btf_material_texture(r->whole, id);
    const bool views = id == BTF_TEXTURE_FACTOR_VIEWS;
    for (size_t layer = 0; layer < shape->layers; layer++) {
        for (uint32_t v = 0; v < r->views.count; v++) {
            for (uint32_t x = 0; x < shape->width; x++, out += 16) {
                const uint32_t from = views ? x : r->lights.number[x];
                memcpy(out,
                       (const uint8_t *)whole.data +
                           16 * ((layer * whole.height + r->views.number[v]) * whole.width + from),
                       16);
            }
        }
    }
}

static void fill(const btfi_restriction *r, uint32_t level, btf_texture_id id, const btf_texture *shape,
                 void *out) {
    const size_t texels =
        (size_t)btf_level_size(r->desc.info.width, level) * btf_level_size(r->desc.info.height, level);
    switch (id) {
    case BTF_TEXTURE_SBRDF:
    case BTF_TEXTURE_HEIGHTS:
        memcpy(out, whole_data(r, level, id), shape->size);
        break;
    case BTF_TEXTURE_SHADOW:
        fill_shadow(r, level, texels, out);
        break;
    case BTF_TEXTURE_SHIFT:
    case BTF_TEXTURE_GAIN:
        fill_codes(r, level, texels, id == BTF_TEXTURE_SHIFT, out);
        break;
    case BTF_TEXTURE_POINTS:
        fill_points(r, level, texels, out);
        break;
    case BTF_TEXTURE_POINT_LISTS:
        fill_point_lists(r, level, shape, out);
        break;
    case BTF_TEXTURE_POINT_INDICES:
        fill_point_indices(r, level, texels, out);
        break;
    case BTF_TEXTURE_CENTRES:
        fill_centres(r, shape, out);
        break;
    case BTF_TEXTURE_RESIDUAL_TEXELS:
    case BTF_TEXTURE_RESIDUAL_DIRECTIONS:
        fill_residual(r, level, id, shape, out);
        break;
    case BTF_TEXTURE_RESIDUAL_SCALES:
        memcpy(out, btf_material_texture(r->whole, id).data, r->desc.info.components * sizeof(float));
        break;
    case BTF_TEXTURE_FACTOR_TEXELS: /* the first units are the first layers */
        memcpy(out, whole_data(r, level, id), shape->size);
        break;
    case BTF_TEXTURE_FACTOR_SCALES:
        memcpy(out, btf_material_texture(r->whole, id).data, shape->size);
        break;
    case BTF_TEXTURE_FACTOR_DIRECTIONS:
    case BTF_TEXTURE_FACTOR_VIEWS:
        fill_factors(r, id, shape, out);
        break;
    default:
        break;
    }
}

btf_result btfi_restriction_fill(btfi_restriction *r, const btf_log *log) {
    if (r->desc.info.centres > 0) {
        r->centre = malloc(r->whole->info.centres * sizeof *r->centre);
        if (!r->centre) {
            return btfi_fail(log, BTF_ERROR_MEMORY, "restrict: out of memory for %u centres",
                             (unsigned)r->whole->info.centres);
        }
        number_centres(r);
    }
    for (uint32_t level = 0; level < r->desc.info.levels; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            const btf_texture shape = btf_material_level_shape(&r->desc.info, level, (btf_texture_id)id);
            if (shape.format == BTF_FORMAT_NONE) {
                continue;
            }
            void *data = calloc(1, shape.size);
            if (!data) {
                return btfi_fail(log, BTF_ERROR_MEMORY, "%s: out of memory for %zu bytes",
                                 btf_texture_name((btf_texture_id)id), shape.size);
            }
            fill(r, level, (btf_texture_id)id, &shape, data);
            r->made[level][id] = data;
            *(level ? &r->desc.level_texture[level][id] : &r->desc.texture[id]) = data;
        }
    }
    return BTF_OK;
}

void btfi_restriction_clear(btfi_restriction *r) {
    for (int level = 0; level < BTF_MAX_LEVELS; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            free(r->made[level][id]);
        }
    }
    free(r->centre);
}
