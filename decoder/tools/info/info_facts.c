/* Facts of a material for btf-info. See info_facts.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "info_facts.h"

#include <math.h>

const char *const layout_names[] = {"paper", "tight"};
const char *const domain_names[] = {"linear", "sqrt"};
const char *const colour_names[] = {"mono", "rgb", "none"};
const char *const store_names[] = {"components", "factors"};
const char *const blend_names[] = {"radiance", "roots"};
const char *const point_store_names[] = {"separate", "packed", "lists"};

const int class_bits[BTF_FACTOR_CLASSES][2] = {{8, 8}, {4, 8}, {4, 4}, {2, 4}, {2, 2}};

class_counts count_class(const btf_material_info *info, int c) {
    const uint32_t *n = info->factor_classes[c];
    return (class_counts){.units = n[0],
                          .words = {4 * n[0] - n[1] - n[2], n[1], n[2]},
                          .components = 4 * n[0] * (32 / (uint32_t)class_bits[c][0])};
}

const char *format_name(btf_format format) {
    static const char *const names[] = {
        [BTF_FORMAT_NONE] = "none",         [BTF_FORMAT_R8UI] = "R8UI",
        [BTF_FORMAT_RG8UI] = "RG8UI",       [BTF_FORMAT_RGBA8UI] = "RGBA8UI",
        [BTF_FORMAT_RGBA8I] = "RGBA8I",     [BTF_FORMAT_RGBA16UI] = "RGBA16UI",
        [BTF_FORMAT_RGBA16F] = "RGBA16F",   [BTF_FORMAT_RGBA32F] = "RGBA32F",
        [BTF_FORMAT_RGBA32UI] = "RGBA32UI",
    };
    return names[format];
}

int find_rings(const btf_directions *d, ring rings[BTF_MAX_DIRECTIONS]) {
    int count = 0;
    for (uint32_t i = 0; i < d->count; i++) {
        const float *v = d->xyz + 3 * (size_t)i;
        double theta =
            atan2(hypot((double)v[0], (double)v[1]), (double)v[2]) * (180 / 3.14159265358979323846);
        int r = 0;
        while (r < count && fabs(rings[r].theta - theta) >= 0.05) {
            r++;
        }
        if (r == count) {
            rings[count++] = (ring){round(theta * 100) / 100, 0};
        }
        rings[r].count++;
    }
    return count;
}

/* The row that decodes exactly these effects; NULL when the encoder did not measure it. */
static const btf_material_error *find_error(const btf_material_error *errors, size_t count,
                                            uint32_t effects) {
    for (size_t i = 0; i < count; i++) {
        if (errors[i].effects == effects) {
            return &errors[i];
        }
    }
    return NULL;
}

bool find_gain(const btf_material_error *errors, size_t count, uint32_t effect,
               const btf_material_error **out_with, const btf_material_error **out_without) {
    bool found = false;
    for (size_t i = 0; i < count; i++) {
        const btf_material_error *without = find_error(errors, count, errors[i].effects & ~effect);
        if (!(errors[i].effects & effect) || !without) {
            continue;
        }
        if (!found || __builtin_popcount(errors[i].effects) > __builtin_popcount((*out_with)->effects)) {
            *out_with = &errors[i];
            *out_without = without;
            found = true;
        }
    }
    return found;
}

size_t between_bytes(const btf_material *material, uint32_t effect) {
    return effect == BTF_EFFECT_RELIEF ? btf_material_texture(material, BTF_TEXTURE_HEIGHTS).size : 0;
}

/* What was left out, in words and as JSON keys, by the number of a row (modulo BTF_BETWEEN_NEXT_LEVEL). */
static const char *const left_out_names[] = {[1] = "view",
                                             [2] = "light",
                                             [3] = "both",
                                             [5] = "view, no relief",
                                             [7] = "both, no relief",
                                             [9] = "view, no gloss",
                                             [11] = "both, no gloss"};
static const char *const left_out_keys[] = {[1] = "view",
                                            [2] = "light",
                                            [3] = "both",
                                            [5] = "view_without_relief",
                                            [7] = "both_without_relief",
                                            [9] = "view_without_gloss",
                                            [11] = "both_without_gloss"};

int left_out_level(float number) {
    return (int)number / BTF_BETWEEN_NEXT_LEVEL;
}

const char *left_out_name(float number) {
    return left_out_names[(int)number % BTF_BETWEEN_NEXT_LEVEL];
}

const char *left_out_key(float number) {
    return left_out_keys[(int)number % BTF_BETWEEN_NEXT_LEVEL];
}

double decibels(float mse) {
    return mse > 1e-10f ? -10 * log10((double)mse) : 100;
}

const btf_level_error *find_level_error(const btf_material *material, uint32_t level) {
    size_t count;
    const btf_level_error *errors = btf_material_level_errors(material, &count);
    for (size_t i = 0; i < count; i++) {
        if (errors[i].level == level) {
            return &errors[i];
        }
    }
    return NULL;
}

bool is_table(btf_texture_id id) {
    return id == BTF_TEXTURE_VIEW_TABLE || id == BTF_TEXTURE_LIGHT_TABLE ||
           id == BTF_TEXTURE_RESIDUAL_SCALES || id == BTF_TEXTURE_FACTOR_SCALES ||
           id == BTF_TEXTURE_FACTOR_VIEWS || id == BTF_TEXTURE_VIEW_VECTORS;
}

relief_range find_relief(const btf_material *material, const btf_material_info *info) {
    const btf_texture t = btf_material_texture(material, BTF_TEXTURE_HEIGHTS);
    const float *vectors = btf_material_texture(material, BTF_TEXTURE_VIEW_VECTORS).data;
    int least = t.size ? 255 : 0, most = 0;
    for (size_t i = 0; i < t.size; i++) {
        const int code = ((const uint8_t *)t.data)[i];
        least = code < least ? code : least;
        most = code > most ? code : most;
    }
    const double texel = 256.0 * (1u << info->relief_level);
    relief_range range = {.low = (info->relief_base + (least * info->relief_step >> 8)) / texel,
                          .high = (info->relief_base + (most * info->relief_step >> 8)) / texel};
    for (uint32_t v = 0; v < info->n_views; v++) {
        range.views += vectors[4 * (size_t)v + 3] != 0;
    }
    return range;
}
