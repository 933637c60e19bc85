/* OpenBTF: makes a material with the data that a plan reads and nothing else. See openbtf/plan.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "restrict.h"

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

/* Views or lights that are kept: their numbers in the whole material. */
typedef struct subset {
    uint32_t count;
    uint16_t number[BTF_MAX_DIRECTIONS];
    float xyz[BTF_MAX_DIRECTIONS][3];
} subset;

static bool same_array(const void *a, const void *b, size_t size) {
    return size == 0 || memcmp(a, b, size) == 0;
}

static bool same_directions(const btfi_directions *a, const btfi_directions *b) {
    return a->count == b->count && a->triangle_count == b->triangle_count &&
           a->hull_count == b->hull_count && a->grid == b->grid && a->cells_length == b->cells_length &&
           same_array(a->vertices, b->vertices, 2 * (size_t)a->count * sizeof *a->vertices) &&
           same_array(a->triangles, b->triangles, 3 * (size_t)a->triangle_count * sizeof *a->triangles) &&
           same_array(a->hull, b->hull, a->hull_count * sizeof *a->hull) &&
           same_array(a->cells, b->cells, a->cells_length * sizeof *a->cells);
}

static int compare_triangles(const void *a, const void *b) {
    const uint16_t *p = a, *q = b;
    for (int k = 0; k < 2; k++) {
        if (p[k] != q[k]) {
            return p[k] - q[k];
        }
    }
    return p[2] - q[2];
}

/* In a list that was triangulated here, which is sorted. */
static bool has_triangle(const btfi_directions *d, const uint16_t corner[3]) {
    return d->triangle_count > 0 && bsearch(corner, d->triangles, d->triangle_count,
                                            3 * sizeof *d->triangles, compare_triangles) != NULL;
}

static bool has_edge(const btfi_directions *d, const uint16_t corner[3], bool with_next) {
    for (uint32_t h = 0; h < d->hull_count; h++) {
        if (d->hull[h] == corner[0] && d->hull[(h + 1) % d->hull_count] == corner[1] &&
            (!with_next || d->hull[(h + 2) % d->hull_count] == corner[2])) {
            return true;
        }
    }
    return false;
}

/* Whether the triangulation of the subset holds every record that the range needs. */
static bool has_records(const btfi_directions *whole, const btfi_reach *reach, const subset *kept,
                        const btfi_directions *small) {
    uint16_t now[BTF_MAX_DIRECTIONS] = {0}, corner[3];
    for (uint32_t i = 0; i < kept->count; i++) {
        now[kept->number[i]] = (uint16_t)i;
    }
    for (uint32_t t = 0; t < whole->triangle_count; t++) {
        for (int k = 0; k < 3; k++) {
            corner[k] = now[whole->triangles[3 * (size_t)t + (size_t)k]];
        }
        if (reach->record[t] && !has_triangle(small, corner)) {
            return false;
        }
    }
    for (uint32_t h = 0; h < whole->hull_count; h++) {
        const uint8_t needed = reach->record[whole->triangle_count + h];
        for (uint32_t k = 0; k < 3; k++) {
            corner[k] = now[whole->hull[(h + k) % whole->hull_count]];
        }
        if (needed && kept->count > 1 && !has_edge(small, corner, (needed & BTFI_REACH_CORNER) != 0)) {
            return false;
        }
    }
    return true;
}

/* Whether a fixed direction has the same neighbours and weights in the subset. */
static bool same_answer(const btfi_directions *whole, const subset *kept, const btfi_directions *small,
                        const float direction[3]) {
    const btfi_neighbours a = btfi_neighbours_of(whole, direction, false),
                          b = btfi_neighbours_of(small, direction, false);
    bool same = a.count == b.count;
    for (uint32_t i = 0; same && i < a.count; i++) {
        same = a.index[i] == kept->number[b.index[i]] && a.weight[i] == b.weight[i];
    }
    return same;
}

static void select_directions(const btfi_directions *whole, const bool *keep, subset *out) {
    out->count = 0;
    for (uint32_t i = 0; i < whole->count; i++) {
        if (!keep || keep[i]) {
            memcpy(out->xyz[out->count], whole->xyz + 3 * (size_t)i, sizeof out->xyz[0]);
            out->number[out->count++] = (uint16_t)i;
        }
    }
}

/* Chooses the directions that the range needs; all where the triangulation of fewer would give other
 * neighbours. */
static btf_result choose_directions(const btfi_directions *whole, const btf_range *range,
                                    const btf_log *log, subset *out) {
    const btfi_check check = {log, BTF_ERROR_MEMORY};
    btfi_reach reach;
    btfi_directions again = {0}, small = {0};
    btfi_reach_range(whole, range, &reach);
    select_directions(whole, reach.keep, out);
    if (out->count == whole->count) {
        return BTF_OK;
    }
    btf_result result = btfi_directions_build(&check, "directions", whole->count, whole->xyz, &again);
    if (result == BTF_OK) {
        result = btfi_directions_build(&check, "directions", out->count, out->xyz[0], &small);
    }
    if (result == BTF_OK && (!same_directions(whole, &again) ||
                             (range->fixed ? !same_answer(whole, out, &small, range->direction)
                                           : !has_records(whole, &reach, out, &small)))) {
        select_directions(whole, NULL, out);
    }
    btfi_directions_clear(&again);
    btfi_directions_clear(&small);
    return result;
}

/* A restriction in the making: its source, its plan and its result. */
typedef struct work {
    const btf_material *whole;
    uint32_t level;   /* of the whole that becomes level 0 */
    bool shift, gain; /* the plan has that effect */
    btf_material_desc desc;
    subset views, lights;
    uint8_t acts[BTF_MAX_DIRECTIONS];              /* [view of the restriction] 1 where relief acts */
    uint32_t *centre;                              /* [centre of the whole] its new number, or UINT32_MAX */
    void *made[BTF_MAX_LEVELS][BTF_TEXTURE_COUNT]; /* [level of the restriction] */
} work;

static const void *whole_data(const work *w, uint32_t level, btf_texture_id id) {
    return btf_material_level_texture(w->whole, w->level + level, id).data;
}

/* Byte `channel` of tile i at texel t of the atlas. */
static uint8_t atlas_byte(const btf_material *m, uint32_t i, size_t t, size_t channel) {
    const size_t columns = m->info.atlas_width / m->info.width;
    const size_t x = i % columns * m->info.width + t % m->info.width;
    const size_t y = i / columns * m->info.height + t / m->info.width;
    return ((const uint8_t *)btf_material_texture(m, BTF_TEXTURE_MAPS)
                .data)[4 * (y * m->info.atlas_width + x) + channel];
}

/* Shift bytes and code of a packed point. */
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
static const uint8_t *packed_point(const work *w, uint32_t level, size_t view, size_t t, size_t texels) {
    if (w->whole->info.point_store == BTF_POINTS_PACKED) {
        return (const uint8_t *)whole_data(w, level, BTF_TEXTURE_POINTS) + 2 * (view * texels + t);
    }
    const size_t entry = point_index(whole_data(w, level, BTF_TEXTURE_POINT_INDICES), view, t, texels);
    return (const uint8_t *)whole_data(w, level, BTF_TEXTURE_POINT_LISTS) + 2 * (entry * texels + t);
}

/* A packed point whose shift and gain code are 0 where the plan leaves that effect out. */
static void copy_point(const work *w, const uint8_t *from, uint8_t *to) {
    const unsigned p = from[0] + 256u * from[1], shift = w->shift ? p & 0xFFF : 32 << 6 | 32;
    const unsigned point = shift | (w->gain ? p & 0xF000 : 0);
    to[0] = (uint8_t)point;
    to[1] = (uint8_t)(point >> 8);
}

static void fill_points(const work *w, uint32_t level, size_t texels, uint8_t *out) {
    for (uint32_t v = 0; v < w->views.count; v++) {
        for (size_t t = 0; t < texels; t++, out += 2) {
            copy_point(w, packed_point(w, level, w->views.number[v], t, texels), out);
        }
    }
}

static void fill_point_lists(const work *w, uint32_t level, const btf_texture *shape, uint8_t *out) {
    const uint8_t *in = whole_data(w, level, BTF_TEXTURE_POINT_LISTS);
    for (size_t i = 0; i < shape->size; i += 2) {
        copy_point(w, in + i, out + i);
    }
}

static void fill_point_indices(const work *w, uint32_t level, size_t texels, uint8_t *out) {
    const uint8_t *in = whole_data(w, level, BTF_TEXTURE_POINT_INDICES);
    for (size_t v = 0; v < w->views.count; v++) {
        for (size_t t = 0; t < texels; t++) {
            out[v / 2 * texels + t] |=
                (uint8_t)(point_index(in, w->views.number[v], t, texels) << 4 * (v % 2));
        }
    }
}

/* Gain code and shift bytes as stored: (128, 0, 0) where they are not. */
static void read_codes(const work *w, uint32_t level, uint32_t view, size_t t, size_t texels,
                       uint8_t out[3]) {
    const btf_material_info *info = &w->whole->info;
    const bool code = info->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN);
    const bool bytes = info->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN);
    const size_t at = view * texels + t;
    if (btfi_shares_points(info)) {
        read_point(packed_point(w, level, view, t, texels), out);
        return;
    }
    const bool tight = info->layout == BTF_LAYOUT_TIGHT;
    const uint8_t *gain = tight && code ? whole_data(w, level, BTF_TEXTURE_GAIN) : NULL;
    const uint8_t *shift = tight && bytes ? whole_data(w, level, BTF_TEXTURE_SHIFT) : NULL;
    out[0] = !code ? BTF_GAIN_ONE : tight ? gain[at] : atlas_byte(w->whole, view, t, 1);
    for (size_t k = 0; k < 2; k++) {
        out[1 + k] = !bytes ? 0 : tight ? shift[2 * at + k] : atlas_byte(w->whole, view, t, 2 + k);
    }
}

/* Turns codes as read into those that the restriction stores. */
static void translate_codes(const work *w, uint8_t codes[3]) {
    const uint32_t effects = w->desc.info.effects;
    const bool hidden = codes[0] == 0 && (w->whole->info.effects & BTF_EFFECT_HIDDEN);
    if (hidden && (effects & BTF_EFFECT_HIDDEN)) {
        const uint32_t centre = w->centre[codes[1] + 256u * codes[2]];
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
static void number_centres(work *w) {
    const btf_material_info *info = &w->whole->info;
    for (uint32_t i = 0; i < info->centres; i++) {
        w->centre[i] = UINT32_MAX;
    }
    for (uint32_t level = 0; level < w->desc.info.levels; level++) {
        const size_t texels =
            (size_t)btf_level_size(w->desc.info.width, level) * btf_level_size(w->desc.info.height, level);
        for (uint32_t v = 0; v < w->views.count; v++) {
            for (size_t t = 0; t < texels; t++) {
                uint8_t codes[3];
                read_codes(w, level, w->views.number[v], t, texels, codes);
                if (codes[0] == 0) {
                    w->centre[codes[1] + 256u * codes[2]] = 0;
                }
            }
        }
    }
    w->desc.info.centres = 0;
    for (uint32_t i = 0; i < info->centres; i++) {
        if (w->centre[i] == 0) {
            w->centre[i] = w->desc.info.centres++;
        }
    }
    if (w->desc.info.centres == 0) {
        w->centre[0] = 0;
        w->desc.info.centres = 1;
    }
}

static void fill_shadow(const work *w, uint32_t level, size_t texels, uint8_t *out) {
    const bool tight = w->whole->info.layout == BTF_LAYOUT_TIGHT;
    const uint8_t *in = tight ? whole_data(w, level, BTF_TEXTURE_SHADOW) : NULL;
    for (uint32_t l = 0; l < w->lights.count; l++) {
        for (size_t t = 0; t < texels; t++) {
            *out++ = tight ? in[w->lights.number[l] * texels + t]
                           : atlas_byte(w->whole, w->lights.number[l], t, 0);
        }
    }
}

/* Shift bytes (two a point) or gain codes (one). */
static void fill_codes(const work *w, uint32_t level, size_t texels, bool shift, uint8_t *out) {
    for (uint32_t v = 0; v < w->views.count; v++) {
        for (size_t t = 0; t < texels; t++) {
            uint8_t codes[3];
            read_codes(w, level, w->views.number[v], t, texels, codes);
            translate_codes(w, codes);
            if (shift) {
                *out++ = codes[1];
                *out++ = codes[2];
            } else {
                *out++ = codes[0];
            }
        }
    }
}

static void fill_centres(const work *w, const btf_texture *shape, uint8_t *out) {
    const btf_material_info *info = &w->whole->info;
    const btf_texture centres = btf_material_texture(
        w->whole, info->layout == BTF_LAYOUT_TIGHT ? BTF_TEXTURE_CENTRES : BTF_TEXTURE_MAPS);
    for (uint32_t c = 0; c < info->centres; c++) {
        if (w->centre[c] == UINT32_MAX) {
            continue;
        }
        const size_t row = w->centre[c] % shape->height, block = w->centre[c] / shape->height;
        for (uint32_t i = 0; i < w->lights.count; i++) {
            const uint32_t l = w->lights.number[i];
            uint32_t x = c / centres.height * info->n_lights + l, y = c % centres.height;
            if (info->layout == BTF_LAYOUT_PAPER) {
                btf_material_atlas_centre(info, c, &x, &y);
                y += l;
            }
            memcpy(out + 4 * (row * shape->width + block * w->lights.count + i),
                   (const uint8_t *)centres.data + 4 * ((size_t)y * centres.width + x), 3);
        }
    }
}

/* Texel components or direction components: `pairs` of four bytes, of which component `first` on stay 0. */
static void copy_quads(const int8_t *in, size_t pairs, uint32_t count, int8_t *out) {
    for (size_t i = 0; i < pairs; i++) {
        memcpy(out + 4 * i, in + 4 * i, count < 4 ? count : 4);
    }
}

static void fill_residual(const work *w, uint32_t level, btf_texture_id id, const btf_texture *shape,
                          void *out) {
    const uint32_t k = w->desc.info.components, groups = (k + 3) / 4;
    const size_t plane = (size_t)shape->width * shape->height;
    const int8_t *in = id == BTF_TEXTURE_RESIDUAL_TEXELS ? whole_data(w, level, id)
                                                         : btf_material_texture(w->whole, id).data;
    for (uint32_t g = 0; g < groups; g++) {
        if (id == BTF_TEXTURE_RESIDUAL_TEXELS) {
            copy_quads(in + 4 * g * plane, plane, k - 4 * g, (int8_t *)out + 4 * g * plane);
            continue;
        }
        for (size_t layer = 3 * (size_t)g; layer < 3 * (size_t)g + 3; layer++) {
            for (uint32_t v = 0; v < w->views.count; v++) {
                for (uint32_t l = 0; l < w->lights.count; l++) {
                    const btf_material_info *info = &w->whole->info;
                    const size_t from =
                        (layer * info->n_views + w->views.number[v]) * info->n_lights + w->lights.number[l];
                    const size_t to = (layer * w->views.count + v) * w->lights.count + l;
                    copy_quads(in + 4 * from, 1, k - 4 * g, (int8_t *)out + 4 * to);
                }
            }
        }
    }
}

/* Units of kept views and lights, and the factors of kept views: 16 bytes a texel. */
static void fill_factors(const work *w, btf_texture_id id, const btf_texture *shape, uint8_t *out) {
    const btf_texture whole = btf_material_texture(w->whole, id);
    const bool views = id == BTF_TEXTURE_FACTOR_VIEWS;
    for (size_t layer = 0; layer < shape->layers; layer++) {
        for (uint32_t v = 0; v < w->views.count; v++) {
            for (uint32_t x = 0; x < shape->width; x++, out += 16) {
                const uint32_t from = views ? x : w->lights.number[x];
                memcpy(out,
                       (const uint8_t *)whole.data +
                           16 * ((layer * whole.height + w->views.number[v]) * whole.width + from),
                       16);
            }
        }
    }
}

static void fill(const work *w, uint32_t level, btf_texture_id id, const btf_texture *shape, void *out) {
    const size_t texels =
        (size_t)btf_level_size(w->desc.info.width, level) * btf_level_size(w->desc.info.height, level);
    switch (id) {
    case BTF_TEXTURE_SBRDF:
    case BTF_TEXTURE_HEIGHTS:
        memcpy(out, whole_data(w, level, id), shape->size);
        break;
    case BTF_TEXTURE_SHADOW:
        fill_shadow(w, level, texels, out);
        break;
    case BTF_TEXTURE_SHIFT:
    case BTF_TEXTURE_GAIN:
        fill_codes(w, level, texels, id == BTF_TEXTURE_SHIFT, out);
        break;
    case BTF_TEXTURE_POINTS:
        fill_points(w, level, texels, out);
        break;
    case BTF_TEXTURE_POINT_LISTS:
        fill_point_lists(w, level, shape, out);
        break;
    case BTF_TEXTURE_POINT_INDICES:
        fill_point_indices(w, level, texels, out);
        break;
    case BTF_TEXTURE_CENTRES:
        fill_centres(w, shape, out);
        break;
    case BTF_TEXTURE_RESIDUAL_TEXELS:
    case BTF_TEXTURE_RESIDUAL_DIRECTIONS:
        fill_residual(w, level, id, shape, out);
        break;
    case BTF_TEXTURE_RESIDUAL_SCALES:
        memcpy(out, btf_material_texture(w->whole, id).data, w->desc.info.components * sizeof(float));
        break;
    case BTF_TEXTURE_FACTOR_TEXELS: /* the first units are the first layers */
        memcpy(out, whole_data(w, level, id), shape->size);
        break;
    case BTF_TEXTURE_FACTOR_SCALES:
        memcpy(out, btf_material_texture(w->whole, id).data, shape->size);
        break;
    case BTF_TEXTURE_FACTOR_DIRECTIONS:
    case BTF_TEXTURE_FACTOR_VIEWS:
        fill_factors(w, id, shape, out);
        break;
    default:
        break;
    }
}

static btf_result make_textures(work *w, const btf_log *log) {
    for (uint32_t level = 0; level < w->desc.info.levels; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            const btf_texture shape = btf_material_level_shape(&w->desc.info, level, (btf_texture_id)id);
            if (shape.format == BTF_FORMAT_NONE) {
                continue;
            }
            void *data = calloc(1, shape.size);
            if (!data) {
                return btfi_fail(log, BTF_ERROR_MEMORY, "%s: out of memory for %zu bytes",
                                 btf_texture_name((btf_texture_id)id), shape.size);
            }
            fill(w, level, (btf_texture_id)id, &shape, data);
            w->made[level][id] = data;
            *(level ? &w->desc.level_texture[level][id] : &w->desc.texture[id]) = data;
        }
    }
    return BTF_OK;
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

static btf_result make(work *w, const btf_log *log, btf_material **out_material) {
    btf_result result = make_textures(w, log);
    if (result == BTF_OK) {
        result = btf_material_create(&w->desc, log, out_material);
    }
    if (result != BTF_OK) {
        return result;
    }
    btf_material *m = *out_material;
    if (w->views.count == w->whole->views.count) {
        result = copy_directions(&w->whole->views, log, &m->views);
    }
    if (result == BTF_OK && w->lights.count == w->whole->lights.count) {
        result = copy_directions(&w->whole->lights, log, &m->lights);
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
    work *w = calloc(1, sizeof *w);
    if (!w) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "restrict: out of memory");
    }
    w->whole = material;
    w->level = plan->level;
    w->shift = plan->effects & BTF_EFFECT_SHIFT;
    w->gain = plan->effects & BTF_EFFECT_GAIN;
    w->desc.struct_size = sizeof w->desc;
    btf_result result = choose_directions(&material->views, &plan->scene.view, log, &w->views);
    if (result == BTF_OK && plan->effects & material->info.effects & BTF_EFFECT_GLOSS) {
        select_directions(&material->lights, NULL, &w->lights); /* a neighbour's light may be any */
    } else if (result == BTF_OK) {
        result = choose_directions(&material->lights, &plan->scene.light, log, &w->lights);
    }
    w->desc.info = btfi_restricted_info(&material->info, plan->effects, plan->components, plan->level,
                                        w->views.count, w->lights.count);
    if (w->desc.info.effects & BTF_EFFECT_RELIEF) {
        for (uint32_t v = 0; v < w->views.count; v++) {
            w->acts[v] = material->view_vectors[4 * (size_t)w->views.number[v] + 3] != 0;
        }
        w->desc.relief_views = w->acts;
    }
    w->desc.views = w->views.xyz[0];
    w->desc.lights = w->lights.xyz[0];
    if (plan->level == 0 && btfi_version(&w->desc.info) >= 2) { /* of a coarser level it has not the size */
        w->desc.preview = material->preview;
    }
    if (result == BTF_OK && w->desc.info.centres > 0) {
        w->centre = malloc(material->info.centres * sizeof *w->centre);
        if (w->centre) {
            number_centres(w);
        } else {
            result = btfi_fail(log, BTF_ERROR_MEMORY, "restrict: out of memory");
        }
    }
    if (result == BTF_OK) {
        result = make(w, log, out_material);
    }
    for (int level = 0; level < BTF_MAX_LEVELS; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            free(w->made[level][id]);
        }
    }
    free(w->centre);
    free(w);
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
