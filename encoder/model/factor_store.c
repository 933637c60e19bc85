/* Factors: sums over their classes, and the levels of their codes. See factor_store.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factor_store.h"

#include <stdlib.h>
#include <string.h>

/* The errors of 8 and 4 bits are those of rounding to the nearest level, with the step of least error.
 * Rounding to 2 bits leaves 0.13, but coordinate descent takes part of that back: BRICKS64 gains 0.08 dB by
 * counting less. */
const enc_factor_class enc_factor_classes[BTF_FACTOR_CLASSES] = {
    {8, 8, 4, 1, 0, 4, 127, 127, 6e-5 + 6e-5},  {4, 8, 8, 2, 1, 5, 15, 255, 0.0135 + 6e-5},
    {4, 4, 8, 1, 1, 1, 15, 15, 0.0135 + 0.016}, {2, 4, 16, 2, 2, 0, 3, 15, 0.098 + 0.016},
    {2, 2, 16, 1, 2, 0, 3, 3, 0.098 + 0.098},
};

static uint32_t smaller(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

uint32_t enc_store_units(const uint32_t classes[BTF_FACTOR_CLASSES][3]) {
    uint32_t units = 0;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        units += classes[c][0];
    }
    return units;
}

uint32_t enc_store_layers(const uint32_t classes[BTF_FACTOR_CLASSES][3]) {
    uint32_t layers = 0;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        layers += classes[c][0] * enc_factor_classes[c].u_texels;
    }
    return layers;
}

void enc_store_truncate(const uint32_t classes[BTF_FACTOR_CLASSES][3], uint32_t units,
                        uint32_t out[BTF_FACTOR_CLASSES][3]) {
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        out[c][0] = smaller(classes[c][0], units);
        units -= out[c][0];
        out[c][1] = smaller(classes[c][1], ENC_STORE_WORDS * out[c][0]);
        out[c][2] = smaller(classes[c][2], ENC_STORE_WORDS * out[c][0] - out[c][1]);
    }
}

size_t enc_store_list(const uint32_t classes[BTF_FACTOR_CLASSES][3], enc_factor_unit *out) {
    size_t first = 0;
    uint32_t layer = 0;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        const uint32_t chroma = classes[c][1] + classes[c][2];
        for (uint32_t i = 0; i < classes[c][0]; i++, out++) {
            *out = (enc_factor_unit){.class = c,
                                     .tier = (int)enc_factor_classes[c].tier,
                                     .shift = enc_factor_classes[c].shift,
                                     .mixed = c == 0 || ENC_STORE_WORDS * i < chroma,
                                     .layer = layer,
                                     .word = (int)enc_factor_classes[c].word,
                                     .first = first};
            for (uint32_t k = 0; k < ENC_STORE_WORDS; k++) {
                const uint32_t number = ENC_STORE_WORDS * i + k;
                out->channel[k] = number < classes[c][1] ? 1 : number < chroma ? 2 : 0;
            }
            layer += enc_factor_classes[c].u_texels;
            first += ENC_STORE_WORDS * enc_factor_classes[c].word;
        }
    }
    return first;
}

static int16_t level(uint32_t field, int bits) {
    return (int16_t)(2 * (int)(field & ((1u << bits) - 1)) - ((1 << bits) - 1));
}

void enc_store_w_levels(const enc_factor_unit *unit, const uint32_t words[ENC_STORE_WORDS], int16_t *out) {
    const int bits = enc_factor_classes[unit->class].bits_w;
    for (int k = 0; k < ENC_STORE_WORDS; k++) {
        for (int i = 0; i < unit->word; i++) {
            *out++ = bits == 8 ? (int8_t)(words[k] >> (8 * i)) : level(words[k] >> (bits * i), bits);
        }
    }
}

enc_store_place enc_store_place_of_u(int class, int i) {
    switch (class) {
    case 0:
        return (enc_store_place){0, 8 * i};
    case 1:
        return (enc_store_place){i % 4 >= 2, 8 * (i % 2) + 16 * (1 - i / 4)};
    case 2:
        return (enc_store_place){0, 4 * (i ^ 4)};
    case 3:
        return (enc_store_place){i % 8 >= 4, 4 * (i % 4) + 16 * (1 - i / 8)};
    default:
        return (enc_store_place){0, 8 * (3 - i / 4) + 2 * (i % 4)};
    }
}

void enc_store_u_levels(const enc_factor_unit *unit, const uint32_t first[ENC_STORE_WORDS],
                        const uint32_t second[ENC_STORE_WORDS], int16_t *out) {
    const int bits = enc_factor_classes[unit->class].bits_u;
    for (int i = 0; i < unit->word; i++) {
        const enc_store_place at = enc_store_place_of_u(unit->class, i);
        const uint32_t *words = at.second ? second : first;
        for (int k = 0; k < ENC_STORE_WORDS; k++) {
            const uint32_t field = words[k] >> at.bit;
            out[k * unit->word + i] = unit->class == 0 ? (int8_t)field : level(field, bits);
        }
    }
}

void enc_store_texel_levels(const enc_factor_unit *units, size_t count, const uint32_t *texel_words,
                            size_t texels, size_t texel, int16_t *out) {
    for (size_t i = 0; i < count; i++) {
        const uint32_t *first = texel_words + (units[i].layer * texels + texel) * ENC_STORE_WORDS;
        const bool two = enc_factor_classes[units[i].class].u_texels == 2;
        enc_store_u_levels(&units[i], first, two ? first + texels * ENC_STORE_WORDS : first,
                           out + units[i].first);
    }
}

void enc_store_pack_texel(const enc_factor_unit *units, size_t count, const int16_t *levels, size_t texels,
                          size_t texel, uint32_t *texel_words) {
    for (const enc_factor_unit *unit = units; unit < units + count; unit++) {
        const int top = (1 << enc_factor_classes[unit->class].bits_u) - 1;
        for (int n = 0; n < ENC_STORE_WORDS * unit->word; n++) {
            const enc_store_place at = enc_store_place_of_u(unit->class, n % unit->word);
            const int value = levels[unit->first + (size_t)n];
            const uint32_t code = unit->class == 0 ? (uint32_t)value & 255 : (uint32_t)((value + top) / 2);
            const size_t layer = unit->layer + (uint32_t)at.second;
            texel_words[(layer * texels + texel) * ENC_STORE_WORDS + (size_t)(n / unit->word)] |= code
                                                                                                  << at.bit;
        }
    }
}

void enc_store_clear(enc_factor_store *factors) {
    free(factors->texels);
    free(factors->directions);
    free(factors->scales);
    free(factors->views);
    memset(factors, 0, sizeof *factors);
}
