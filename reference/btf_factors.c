/* OpenBTF reference decoder: factors, the second store of the residual (FORMAT.md, sections 3 and 9).
 *
 * Code by code, as the page has it; a fast decoder multiplies whole words instead and must give the same.
 *
 * SPDX-License-Identifier: MIT
 */
#include "btf_reference_private.h"

#include <stddef.h>

enum { CHANNELS = 3, WORDS = 4, TIERS = 3, MAX_WORD_COMPONENTS = 16 };

/** Channels of separated colour. */
enum { LUMA, CHROMA_1, CHROMA_2 };

/** The table of section 3. */
typedef struct factor_class {
    uint32_t w_bits, u_bits;
    uint32_t components; /**< a word */
    uint32_t texels;     /**< of u, a unit */
    uint32_t tier, shift;
} factor_class;

static const factor_class classes[BTF_REF_FACTOR_CLASSES] = {
    {8, 8, 4, 1, 0, 4}, {4, 8, 8, 2, 1, 5}, {4, 4, 8, 1, 1, 1}, {2, 4, 16, 2, 2, 0}, {2, 2, 16, 1, 2, 0},
};

/** A unit, and where its texels are. */
typedef struct unit {
    uint32_t class_index;
    uint32_t number;      /**< in its class */
    uint32_t layer;       /**< of factor_directions */
    uint32_t texel_layer; /**< of factor_texels, the first */
} unit;

/** Levels of u of a unit at a texel. */
typedef struct unit_levels {
    int32_t of[WORDS][MAX_WORD_COMPONENTS];
} unit_levels;

/** The level of a code of `bits` bits. */
static int32_t level_of(uint32_t class_index, uint32_t code, uint32_t bits) {
    if (class_index == 0) { /* a signed byte */
        return code < 128 ? (int32_t)code : (int32_t)code - 256;
    }
    return 2 * (int32_t)code - ((1 << bits) - 1);
}

static uint32_t bits_at(uint32_t word, uint32_t position, uint32_t bits) {
    return word >> position & ((1u << bits) - 1);
}

/** Where the u of component i of a word lies: a texel of the unit, and the lowest bit in that word. */
static void position_of_u(uint32_t class_index, uint32_t i, uint32_t *out_texel, uint32_t *out_bit) {
    *out_texel = 0;
    switch (class_index) {
    case 0:
        *out_bit = 8 * i;
        break;
    case 1:
        *out_texel = i % 4 < 2 ? 0 : 1;
        *out_bit = 8 * (i % 2) + 16 * (1 - i / 4);
        break;
    case 2:
        *out_bit = 4 * (i ^ 4);
        break;
    case 3:
        *out_texel = i % 8 < 4 ? 0 : 1;
        *out_bit = 4 * (i % 4) + 16 * (1 - i / 8);
        break;
    default:
        *out_bit = 8 * (3 - i / 4) + 2 * (i % 4);
        break;
    }
}

static unit_levels read_texel_levels(const btf_ref_material *material, const unit *of, uint32_t column,
                                     uint32_t row) {
    const factor_class *c = &classes[of->class_index];
    unit_levels levels;
    for (uint32_t word = 0; word < WORDS; ++word) {
        for (uint32_t i = 0; i < c->components; ++i) {
            uint32_t texel, bit;
            position_of_u(of->class_index, i, &texel, &bit);
            size_t layer = of->texel_layer + texel;
            size_t index = (layer * material->height + row) * material->width + column;
            uint32_t code = bits_at(material->factor_texels[WORDS * index + word], bit, c->u_bits);
            levels.of[word][i] = level_of(of->class_index, code, c->u_bits);
        }
    }
    return levels;
}

/** D of section 9 for a word and one light. */
static int32_t dot_product(const btf_ref_material *material, const unit *of, const unit_levels *u,
                           uint32_t word, uint32_t view, uint32_t light) {
    const factor_class *c = &classes[of->class_index];
    size_t index = ((size_t)of->layer * material->n_views + view) * material->n_lights + light;
    uint32_t packed = material->factor_directions[WORDS * index + word];
    int32_t sum = 0;
    for (uint32_t i = 0; i < c->components; ++i) {
        uint32_t code = bits_at(packed, c->w_bits * i, c->w_bits);
        sum += level_of(of->class_index, code, c->w_bits) * u->of[word][i];
    }
    return sum;
}

/** e of section 9 for a word: its dot products, weighted by the lights. */
static int32_t light_sum(const btf_ref_material *material, const btf_ref_lights *lights, const unit *of,
                         const unit_levels *u, uint32_t word, uint32_t view) {
    int32_t sum = 0;
    for (uint32_t b = 0; b < lights->count; ++b) {
        sum += lights->weight[b] * dot_product(material, of, u, word, view, lights->index[b]);
    }
    return sum;
}

/** float(e >> s) * (scale * 2^(s - 12)) */
static float scaled(int32_t e, uint32_t shift, float scale) {
    float step = scale * btf_ref_float((127 + shift - 12) << 23);
    return (float)btf_ref_shift_down(e, shift) * step;
}

/** The channel of a word of a class, counted through its units. */
static int channel_of(const uint32_t counts[3], uint32_t word) {
    if (word < counts[1]) {
        return CHROMA_1;
    }
    return word < counts[1] + counts[2] ? CHROMA_2 : LUMA;
}

/** Adds a unit to the sums of its tier. */
static void add_unit(const btf_ref_material *material, const btf_ref_lights *lights, const unit *of,
                     const unit_levels *u, uint32_t view, float sums[3]) {
    const uint32_t *counts = material->factor_classes[of->class_index];
    const float *scales = material->factor_scales + WORDS * (size_t)of->layer;
    uint32_t shift = classes[of->class_index].shift;
    int32_t e[WORDS];
    for (uint32_t word = 0; word < WORDS; ++word) {
        e[word] = light_sum(material, lights, of, u, word, view);
    }

    if (of->class_index == 0 || WORDS * of->number < counts[1] + counts[2]) { /* mixed */
        for (uint32_t word = 0; word < WORDS; ++word) {
            int channel = channel_of(counts, WORDS * of->number + word);
            sums[channel] = sums[channel] + scaled(e[word], shift, scales[word]);
        }
    } else {
        sums[LUMA] = sums[LUMA] + scaled(e[0] + e[1] + e[2] + e[3], shift, scales[0]);
    }
}

void btf_ref_factors(const btf_ref_material *material, uint32_t units, const btf_ref_lights *lights,
                     uint32_t column, uint32_t row, uint32_t view, float out_r[3]) {
    float total[CHANNELS] = {0.0f, 0.0f, 0.0f};
    unit next = {0, 0, 0, 0};
    for (uint32_t tier = 0; tier < TIERS; ++tier) {
        float sums[CHANNELS] = {0.0f, 0.0f, 0.0f};
        for (; next.class_index < BTF_REF_FACTOR_CLASSES; ++next.class_index) {
            const factor_class *c = &classes[next.class_index];
            if (c->tier != tier) {
                break;
            }
            uint32_t count = material->factor_classes[next.class_index][0];
            for (next.number = 0; next.number < count && next.layer < units; ++next.number, ++next.layer) {
                unit_levels u = read_texel_levels(material, &next, column, row);
                add_unit(material, lights, &next, &u, view, sums);
                next.texel_layer += c->texels;
            }
        }
        const float *factors = material->factor_views + 4 * (TIERS * (size_t)view + tier);
        for (int channel = 0; channel < CHANNELS; ++channel) {
            float term = sums[channel] * factors[channel];
            total[channel] = total[channel] + term;
        }
    }

    out_r[0] = total[LUMA] + total[CHROMA_1];
    out_r[0] = out_r[0] + total[CHROMA_2];
    out_r[1] = total[LUMA] - (total[CHROMA_2] + total[CHROMA_2]);
    out_r[2] = total[LUMA] - total[CHROMA_1];
    out_r[2] = out_r[2] + total[CHROMA_2];
}

bool btf_ref_probe_factors(void) {
    return btf_ref_probe();
}
