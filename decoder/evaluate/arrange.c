/* The order of the residual. See arrange.h.
 *
 * Words of w stay as they are. Byte j of a unit of w holds codes of word j div 4: one of 8 bits (class 0),
 * two of 4 bits (1, 2) or four of 2 bits (3, 4). Codes of u are put in the same places as the codes of w
 * that they are multiplied by:
 *   class 0, 2, 4   u is as wide as w and lies in the same bits
 *   class 1         u of the low halves of the 16 bytes of w, a byte each, then of the high halves
 *   class 3         in byte j of the first 16 the u of the lower two codes of byte j of w, 4 bits each,
 *                   in byte j of the last 16 those of the upper two
 *
 * SPDX-License-Identifier: MIT
 */
#include "arrange.h"

#include <stdlib.h>
#include <string.h>

enum { WORDS = 4, MOST_U_BYTES = 32 };

/* The table of FORMAT.md section 3. */
static const struct {
    uint8_t u_texels, tier, shift;
} classes[BTFI_CLASSES] = {{1, 0, 4}, {2, 1, 5}, {1, 1, 1}, {2, 2, 0}, {1, 2, 0}};

/* Byte of the stored texels of u (byte b of word k of texel t is 16 t + 4 k + b) that becomes byte `to`. */
static int source_byte(int class_index, int to) {
    const int half = to / 16, byte = to % 4, word = to / 4 % 4;
    switch (class_index) {
    case 1: /* component 2 byte + half */
        return 16 * (byte % 2) + 4 * word + half + 2 * (1 - byte / 2);
    case 2:
        return 4 * word + (byte ^ 2);
    case 3: /* components 4 byte + 2 half and the next */
        return 16 * (byte % 2) + 4 * word + half + 2 * (1 - byte / 2);
    case 4:
        return 4 * word + 3 - byte;
    default:
        return to;
    }
}

static btf_result make_units(const btf_material *material, btf_evaluator *e) {
    const float *scales = btf_material_texture(material, BTF_TEXTURE_FACTOR_SCALES).data;
    e->units = calloc(e->info.components, sizeof *e->units);
    if (!e->units) {
        return BTF_ERROR_MEMORY;
    }
    btfi_unit *unit = e->units;
    for (uint8_t c = 0; c < BTFI_CLASSES; c++) {
        const uint32_t *counts = e->info.factor_classes[c];
        for (uint32_t i = 0; i < counts[0]; i++, unit++) {
            *unit = (btfi_unit){.class_index = c, .tier = classes[c].tier, .u = (uint32_t)e->u_bytes};
            unit->whole = c > 0 && WORDS * i >= counts[1] + counts[2];
            for (uint32_t k = 0; k < WORDS; k++) {
                const uint32_t word = WORDS * i + k;
                const float step = (float)(1 << classes[c].shift) * 0x1p-12f;
                unit->channel[k] = word < counts[1] ? 1 : word < counts[1] + counts[2] ? 2 : 0;
                unit->scale[k] = scales[WORDS * (size_t)(unit - e->units) + k] * step;
            }
            e->u_bytes += (size_t)classes[c].u_texels * BTFI_UNIT_BYTES;
        }
    }
    return BTF_OK;
}

static btf_result make_w(const btf_material *material, btf_evaluator *e) {
    const uint32_t *stored = btf_material_texture(material, BTF_TEXTURE_FACTOR_DIRECTIONS).data;
    const size_t pairs = (size_t)e->info.n_views * e->info.n_lights, units = e->info.components;
    e->w = malloc(pairs * units * BTFI_UNIT_BYTES);
    if (!e->w) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t pair = 0; pair < pairs; pair++) {
        for (size_t unit = 0; unit < units; unit++) {
            const uint32_t *from = stored + WORDS * (unit * pairs + pair);
            uint8_t *to = e->w + BTFI_UNIT_BYTES * (pair * units + unit);
            for (size_t j = 0; j < BTFI_UNIT_BYTES; j++) {
                to[j] = (uint8_t)(from[j / 4] >> 8 * (j % 4));
            }
        }
    }
    return BTF_OK;
}

static btf_result make_u(const btf_material *material, uint32_t level, btf_evaluator *e) {
    btfi_level *l = &e->levels[level];
    const uint32_t *stored = btf_material_level_texture(material, level, BTF_TEXTURE_FACTOR_TEXELS).data;
    const size_t texels = (size_t)l->width * l->height;
    l->u = malloc(texels * e->u_bytes);
    if (!l->u) {
        return BTF_ERROR_MEMORY;
    }
    size_t layer = 0;
    for (size_t i = 0; i < e->info.components; i++) {
        const btfi_unit *unit = &e->units[i];
        const size_t bytes = (size_t)classes[unit->class_index].u_texels * BTFI_UNIT_BYTES;
        uint8_t from[MOST_U_BYTES], word[MOST_U_BYTES];
        for (size_t to = 0; to < bytes; to++) {
            from[to] = (uint8_t)source_byte(unit->class_index, (int)to);
            word[to] = from[to] / 4 % 4;
        }
        for (size_t texel = 0; texel < texels; texel++) {
            uint8_t *u = l->u + texel * e->u_bytes + unit->u;
            for (size_t to = 0; to < bytes; to++) {
                u[to] = (uint8_t)(stored[WORDS * ((layer + from[to] / 16) * texels + texel) + word[to]] >>
                                  8 * (from[to] % 4));
            }
        }
        layer += classes[unit->class_index].u_texels;
    }
    return BTF_OK;
}

static btf_result make_components(const btf_material *material, btf_evaluator *e) {
    const int8_t *stored = btf_material_texture(material, BTF_TEXTURE_RESIDUAL_DIRECTIONS).data;
    const float *scales = btf_material_texture(material, BTF_TEXTURE_RESIDUAL_SCALES).data;
    const size_t pairs = (size_t)e->info.n_views * e->info.n_lights, k = e->info.components;
    e->v = calloc(pairs * k, 4);
    e->scales = malloc(k * sizeof *e->scales);
    if (!e->v || !e->scales) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t j = 0; j < k; j++) {
        e->scales[j] = scales[j] * 0x1p-12f;
        for (size_t pair = 0; pair < pairs; pair++) {
            for (size_t c = 0; c < 3; c++) {
                e->v[4 * (pair * k + j) + c] = stored[4 * ((3 * (j / 4) + c) * pairs + pair) + j % 4];
            }
        }
    }
    return BTF_OK;
}

static btf_result make_texel_components(const btf_material *material, uint32_t level, btf_evaluator *e) {
    btfi_level *l = &e->levels[level];
    const int8_t *stored = btf_material_level_texture(material, level, BTF_TEXTURE_RESIDUAL_TEXELS).data;
    const size_t texels = (size_t)l->width * l->height, k = e->info.components;
    l->components = malloc(texels * k);
    if (!l->components) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t texel = 0; texel < texels; texel++) {
        for (size_t j = 0; j < k; j++) {
            l->components[texel * k + j] = stored[4 * (j / 4 * texels + texel) + j % 4];
        }
    }
    return BTF_OK;
}

btf_result btfi_arrange_residual(const btf_material *material, btf_evaluator *e) {
    btf_result result = BTF_OK;
    if (e->factors_stored) {
        if ((result = make_units(material, e)) || (result = make_w(material, e))) {
            return result;
        }
    } else if (e->components_stored) {
        if ((result = make_components(material, e))) {
            return result;
        }
    }
    for (uint32_t i = 0; i < e->info.levels && !result; i++) {
        if (e->factors_stored) {
            result = make_u(material, i, e);
        } else if (e->components_stored) {
            result = make_texel_components(material, i, e);
        }
    }
    return result;
}
