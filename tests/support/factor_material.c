/* Valid materials of version 2. See factor_material.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factor_material.h"
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

const uint32_t factor_classes[BTF_FACTOR_CLASSES][3] = {
    {2, 3, 2}, {1, 1, 1}, {3, 0, 0}, {1, 2, 0}, {2, 0, 1}};

btf_material_desc factor_material_desc(uint32_t width, uint32_t height, uint32_t n_views, uint32_t n_lights,
                                       btf_layout layout, uint32_t effects,
                                       const uint32_t classes[BTF_FACTOR_CLASSES][3]) {
    btf_material_desc desc =
        random_material_desc(width, height, n_views, n_lights, layout, effects | BTF_EFFECT_RESIDUAL);
    desc.info.store = BTF_STORE_FACTORS;
    memcpy(desc.info.factor_classes, classes, sizeof desc.info.factor_classes);
    desc.info.components = 0;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        desc.info.components += classes[c][0];
    }
    desc.info.domain = BTF_DOMAIN_SQRT;
    desc.info.horizon_scale = 5.75f;
    return desc;
}

uint32_t *factor_words(const btf_material_desc *desc, btf_texture_id id) {
    return (uint32_t *)(uintptr_t)desc->texture[id];
}

float *factor_numbers(const btf_material_desc *desc, btf_texture_id id) {
    return (float *)(uintptr_t)desc->texture[id];
}

/* Random words; in those of class 0, which come first, no byte is -128. */
static void fill_words(random_state *r, size_t of_class_0, size_t count, uint32_t *out) {
    for (size_t i = 0; i < count; i++) {
        out[i] = (uint32_t)random_next(r);
        for (int shift = 0; shift < 32 && i < of_class_0; shift += 8) {
            if ((out[i] >> shift & 255) == 128) {
                out[i] ^= 1u << shift;
            }
        }
    }
}

/* Of magnitude 2^-14 to 2^-6, now and then 0. */
static float random_scale(random_state *r) {
    const float sign = random_below(r, 2) ? -1.0f : 1.0f;
    return random_below(r, 16) ? sign * (float)ldexp(1 + random_unit(r), (int)random_below(r, 8) - 14) : 0;
}

static void fill_scales(random_state *r, const btf_material_info *info, float *out) {
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        for (uint32_t unit = 0; unit < info->factor_classes[c][0]; unit++, out += 4) {
            const bool mixed = c == 0 || 4 * unit < info->factor_classes[c][1] + info->factor_classes[c][2];
            for (int word = 0; word < 4; word++) {
                out[word] = word == 0 || mixed ? random_scale(r) : out[0];
            }
        }
    }
}

void factor_material_pack_points(btf_material_desc *desc) {
    const uint32_t both = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN;
    btf_material_info *info = &desc->info;
    if (info->layout != BTF_LAYOUT_TIGHT || (info->effects & (both | BTF_EFFECT_HIDDEN)) != both) {
        return;
    }
    info->point_store = BTF_POINTS_PACKED;
    info->gain_base = 0.3f;
    info->gain_step = 0.11f;
}

void factor_material_list_points(btf_material_desc *desc, uint32_t entries) {
    factor_material_pack_points(desc);
    if (desc->info.point_store == BTF_POINTS_PACKED) {
        desc->info.point_store = BTF_POINTS_LISTS;
        desc->info.point_entries = entries;
    }
}

void factor_material_choose(random_state *r, btf_material_desc *desc) {
    btf_material_info *info = &desc->info;
    if (info->domain == BTF_DOMAIN_SQRT) {
        info->blend = (btf_blend)random_below(r, 2);
    }
    if (random_below(r, 3) > 0) {
        factor_material_pack_points(desc);
    }
    if (!(info->effects & BTF_EFFECT_RESIDUAL) || random_below(r, 3) == 0) {
        return;
    }
    info->store = BTF_STORE_FACTORS;
    info->horizon_scale = (float)(1 + 5 * random_unit(r));
    info->components = 0;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        uint32_t *n = info->factor_classes[c];
        n[0] = random_below(r, 3);
        n[0] += info->components == 0 && n[0] == 0 && c + 1 == BTF_FACTOR_CLASSES;
        n[1] = random_below(r, 4 * n[0] + 1);
        n[2] = random_below(r, 4 * n[0] - n[1] + 1);
        info->components += n[0];
    }
}

void factor_material_fill(random_state *r, btf_material_desc *desc) {
    const btf_material_info *info = &desc->info;
    random_material_fill(r, desc);
    if (info->store != BTF_STORE_FACTORS) {
        return;
    }
    for (uint32_t level = 0; level < (info->levels ? info->levels : 1); level++) {
        for (int which = 0; which < (level ? 1 : 2); which++) {
            const btf_texture_id id = which ? BTF_TEXTURE_FACTOR_DIRECTIONS : BTF_TEXTURE_FACTOR_TEXELS;
            const btf_texture t = btf_material_level_shape(info, level, id);
            const size_t texels = (size_t)t.width * t.height;
            fill_words(r, 4 * texels * info->factor_classes[0][0], 4 * texels * t.layers,
                       (uint32_t *)(uintptr_t)(level ? desc->level_texture[level][id] : desc->texture[id]));
        }
    }
    fill_scales(r, info, factor_numbers(desc, BTF_TEXTURE_FACTOR_SCALES));
    float *views = factor_numbers(desc, BTF_TEXTURE_FACTOR_VIEWS);
    for (size_t i = 0; i < 12 * (size_t)info->n_views; i++) {
        views[i] = i % 4 == 3 ? 0 : (float)(0.25 + random_unit(r));
    }
}
