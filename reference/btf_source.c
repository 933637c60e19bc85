/* OpenBTF reference decoder: the value of a texel in one view (FORMAT.md, sections 3, 4 and 9).
 *
 * SPDX-License-Identifier: MIT
 */
#include "btf_reference_private.h"

#include <stddef.h>

enum { MAX_LOBES = 4, CHANNELS = 3, DIFFUSE_AND_WEIGHTS = CHANNELS * (1 + MAX_LOBES) };

/** How a texel is seen in a view (section 3). */
typedef struct appearance {
    bool hidden;
    uint32_t centre;       /**< where hidden */
    int32_t columns, rows; /**< shift, where not hidden */
    float gain;            /**< where not hidden; 1 without gain */
} appearance;

/** Index of an element of an array of layers, [layer][row][column]. */
static size_t layer_index(const btf_ref_material *material, uint32_t layer, uint32_t column, uint32_t row) {
    return ((size_t)layer * material->height + row) * material->width + column;
}

/** Byte `channel` of tile `tile` at a texel, layout paper. */
static uint8_t tile_byte(const btf_ref_material *material, uint32_t tile, uint32_t column, uint32_t row,
                         uint32_t channel) {
    uint32_t x, y;
    btf_ref_tile(material, tile, column, row, &x, &y);
    return material->maps[4 * ((size_t)y * material->atlas_width + x) + channel];
}

static int32_t signed_byte(uint8_t byte) {
    return byte < 128 ? byte : (int32_t)byte - 256;
}

/** Section 3, lists of points: the entry that 4 bits name, an even view's the low ones. */
static const uint8_t *listed_point(const btf_ref_material *material, uint32_t column, uint32_t row,
                                   uint32_t view) {
    uint32_t two_views = material->point_indices[layer_index(material, view / 2, column, row)];
    uint32_t entry = view % 2 == 0 ? two_views % 16 : two_views / 16;
    return material->point_lists + 2 * layer_index(material, entry, column, row);
}

/** Section 3, packed points: 6 bits of column shift, 6 of row shift, 4 of gain. */
static appearance read_packed(const btf_ref_situation *s, uint32_t column, uint32_t row, uint32_t view) {
    const btf_ref_material *material = s->material;
    const uint8_t *bytes = material->point_lists
                               ? listed_point(material, column, row, view)
                               : material->points + 2 * layer_index(material, view, column, row);
    uint32_t point = bytes[0] + 256u * bytes[1];
    appearance result = {false, 0, 0, 0, 1.0f};

    if (s->effects & BTF_REF_SHIFT) {
        result.columns = (int32_t)(point & 63) - 32;
        result.rows = (int32_t)(point >> 6 & 63) - 32;
    }
    if (s->effects & BTF_REF_GAIN) {
        float above = (float)(point >> 12) * material->gain_step;
        result.gain = material->gain_base + above;
    }
    return result;
}

/** Section 3: gain code and shift bytes of a texel in a view, as far as the file stores and the caller
 * wants. A code is stored where the file has gain or hidden, and is read to tell shifts from centre indices
 * even where neither is decoded. */
static appearance read_appearance(const btf_ref_situation *s, uint32_t column, uint32_t row,
                                  uint32_t view) {
    const btf_ref_material *material = s->material;
    appearance result = {false, 0, 0, 0, 1.0f};
    uint32_t code = 128, byte0 = 0, byte1 = 0;

    if (material->points_packed) {
        return read_packed(s, column, row, view);
    }
    if (material->effects & (BTF_REF_GAIN | BTF_REF_HIDDEN)) {
        code = material->layout_tight ? material->gain[layer_index(material, view, column, row)]
                                      : tile_byte(material, view, column, row, 1);
    }
    if (material->effects & (BTF_REF_SHIFT | BTF_REF_HIDDEN)) {
        if (material->layout_tight) {
            const uint8_t *bytes = material->shift + 2 * layer_index(material, view, column, row);
            byte0 = bytes[0];
            byte1 = bytes[1];
        } else {
            byte0 = tile_byte(material, view, column, row, 2);
            byte1 = tile_byte(material, view, column, row, 3);
        }
    }

    if (code == 0) { /* hidden; without that effect: no shift, gain 1 */
        result.hidden = (s->effects & BTF_REF_HIDDEN) != 0;
        result.centre = byte0 + 256 * byte1;
        return result;
    }
    if (s->effects & BTF_REF_SHIFT) {
        result.columns = signed_byte((uint8_t)byte0);
        result.rows = signed_byte((uint8_t)byte1);
    }
    if (s->effects & BTF_REF_GAIN) {
        result.gain = (float)code * material->gain_scale;
    }
    return result;
}

/** Section 9: sum over lights of weight and shadow code; 0 to 255 * 4096. */
static int32_t shadow_sum(const btf_ref_situation *s, const btf_ref_lights *lights, uint32_t column,
                          uint32_t row) {
    const btf_ref_material *material = s->material;
    int32_t sum = 0;
    for (uint32_t b = 0; b < lights->count; ++b) {
        uint32_t light = lights->index[b];
        uint8_t code = material->layout_tight ? material->shadow[layer_index(material, light, column, row)]
                                              : tile_byte(material, light, column, row, 0);
        sum += lights->weight[b] * code;
    }
    return sum;
}

/** Value of a centre before it is squared. */
static void centre_value(const btf_ref_situation *s, const btf_ref_lights *lights, uint32_t centre,
                         float out_y[3]) {
    const btf_ref_material *material = s->material;
    const uint8_t *texture = material->layout_tight ? material->centre : material->maps;
    uint32_t width = material->atlas_width;
    if (material->layout_tight) { /* ceil(K / 4096) blocks of n_lights columns */
        width = (material->centres + 4095) / 4096 * material->n_lights;
    }

    int32_t sum[3] = {0, 0, 0};
    for (uint32_t b = 0; b < lights->count; ++b) {
        uint32_t x, y;
        btf_ref_centre(material, centre, lights->index[b], &x, &y);
        const uint8_t *code = texture + 4 * ((size_t)y * width + x);
        for (int c = 0; c < CHANNELS; ++c) {
            sum[c] += lights->weight[b] * code[c];
        }
    }
    float scale = material->centre_scale * 0x1p-12f;
    for (int c = 0; c < CHANNELS; ++c) {
        out_y[c] = (float)sum[c] * scale;
    }
}

/** The four parameters in a layer of `sbrdf`. */
static void read_parameters(const btf_ref_material *material, uint32_t layer, uint32_t column, uint32_t row,
                            float out_parameters[4]) {
    size_t first = 4 * layer_index(material, layer, column, row);
    for (size_t i = 0; i < 4; ++i) {
        if (material->half_float) {
            out_parameters[i] = btf_ref_half(((const uint16_t *)material->sbrdf)[first + i]);
        } else {
            out_parameters[i] = ((const float *)material->sbrdf)[first + i];
        }
    }
}

/** A lobe: max(0, Cx lx Vx + Cy ly Vy + Cz lz Vz)^n (Lafortune et al. 1997; the paper, section 2.1). */
static float lobe(const float parameters[4], const float product[3]) {
    float x = parameters[0] * product[0];
    float y = parameters[1] * product[1];
    float z = parameters[2] * product[2];
    float b = x + y;
    b = b + z;
    return btf_ref_pow(b, parameters[3]);
}

/** Section 9, SBRDF(x', P). */
static void sbrdf(const btf_ref_situation *s, uint32_t column, uint32_t row, float out_f[3]) {
    const btf_ref_material *material = s->material;
    float parameters[4];

    if (material->colour == BTF_REF_MONO) {
        float colour[4];
        read_parameters(material, 0, column, row, colour);
        float sum = colour[3];
        for (uint32_t j = 0; j < material->lobes; ++j) {
            read_parameters(material, 1 + j, column, row, parameters);
            sum = sum + lobe(parameters, s->product);
        }
        for (int c = 0; c < CHANNELS; ++c) {
            out_f[c] = colour[c] * sum;
        }
        return;
    }

    float factors[DIFFUSE_AND_WEIGHTS + 1]; /* the diffuse term, then a weight a lobe; in whole layers */
    uint32_t factor_layers = (CHANNELS * (1 + material->lobes) + 3) / 4;
    for (uint32_t layer = 0; layer < factor_layers; ++layer) {
        read_parameters(material, layer, column, row, factors + 4 * layer);
    }
    for (int c = 0; c < CHANNELS; ++c) {
        out_f[c] = factors[c];
    }
    for (uint32_t j = 0; j < material->lobes; ++j) {
        read_parameters(material, factor_layers + j, column, row, parameters);
        float q = lobe(parameters, s->product);
        for (uint32_t c = 0; c < CHANNELS; ++c) {
            float term = factors[CHANNELS * (1 + j) + c] * q;
            out_f[c] = out_f[c] + term;
        }
    }
}

/** Section 9, residual(x', view, lights). */
static void residual(const btf_ref_situation *s, const btf_ref_lights *lights, uint32_t column,
                     uint32_t row, uint32_t view, float out_r[3]) {
    const btf_ref_material *material = s->material;
    const size_t plane = (size_t)material->n_views * material->n_lights;

    for (int c = 0; c < CHANNELS; ++c) {
        out_r[c] = 0.0f;
    }
    for (uint32_t j = 0; j < s->components; ++j) {
        size_t layer = j / 4, channel = j % 4;
        int8_t u = material->residual_texels[4 * layer_index(material, j / 4, column, row) + channel];
        float scale = material->residual_scales[j] * 0x1p-12f;
        float factor = (float)u * scale;
        for (size_t c = 0; c < CHANNELS; ++c) {
            const int8_t *v = material->residual_directions +
                              4 * ((CHANNELS * layer + c) * plane + (size_t)view * material->n_lights) +
                              channel;
            int32_t sum = 0;
            for (uint32_t b = 0; b < lights->count; ++b) {
                sum += lights->weight[b] * v[4 * lights->index[b]];
            }
            float term = factor * (float)sum;
            out_r[c] = out_r[c] + term;
        }
    }
}

/** y of section 9 before the gain: a source texel, modelled and residual, under the light's cosine. */
static void source(const btf_ref_situation *s, const btf_ref_lights *lights, uint32_t column, uint32_t row,
                   uint32_t view, float out_y[3]) {
    const btf_ref_material *material = s->material;
    bool modelled = material->colour != BTF_REF_NONE;
    float h[3] = {0.0f, 0.0f, 0.0f}, r[3];

    if (modelled) {
        sbrdf(s, column, row, h);
    }
    if (modelled && (s->effects & BTF_REF_SHADOW)) {
        float scale = material->shadow_scale * 0x1p-12f;
        float shadow = (float)shadow_sum(s, lights, column, row) * scale;
        for (int c = 0; c < CHANNELS; ++c) {
            h[c] = h[c] * shadow;
        }
    }
    if (!(s->effects & BTF_REF_RESIDUAL)) {
        for (int c = 0; c < CHANNELS; ++c) {
            out_y[c] = h[c] * s->cosine;
        }
        return;
    }
    if (material->store == BTF_REF_FACTORS) {
        btf_ref_factors(material, s->components, lights, column, row, view, r);
        for (int c = 0; c < CHANNELS; ++c) {
            float term = r[c] * s->horizon;
            out_y[c] = h[c] * s->cosine;
            out_y[c] = modelled ? out_y[c] + term : term;
        }
        return;
    }
    residual(s, lights, column, row, view, r);
    for (int c = 0; c < CHANNELS; ++c) {
        out_y[c] = modelled ? h[c] + r[c] : r[c];
        out_y[c] = out_y[c] * s->cosine;
    }
}

float btf_ref_keep_within(float value) {
    if (!(value >= 0x1p-30f)) {
        return 0.0f;
    }
    if (value > 0x1p32f) {
        return 0x1p32f;
    }
    return value;
}

void btf_ref_view_value(const btf_ref_situation *s, const btf_ref_lights *lights, uint32_t column,
                        uint32_t row, uint32_t view, float out[3]) {
    const btf_ref_material *material = s->material;
    if (s->folded) {
        const float *kept = s->folded->values + 4 * layer_index(material, view, column, row);
        for (int c = 0; c < CHANNELS; ++c) {
            out[c] = kept[c];
        }
        return;
    }
    bool roots = material->blend == BTF_REF_BLEND_ROOTS;
    appearance seen = read_appearance(s, column, row, view);

    if (seen.hidden) {
        centre_value(s, lights, seen.centre, out);
        for (int c = 0; c < CHANNELS; ++c) {
            out[c] = roots ? out[c] : out[c] * out[c];
        }
        return;
    }
    uint32_t source_column = btf_ref_wrap(column, seen.columns, material->width);
    uint32_t source_row = btf_ref_wrap(row, seen.rows, material->height);
    source(s, lights, source_column, source_row, view, out);
    for (int c = 0; c < CHANNELS; ++c) {
        float value = out[c] * seen.gain; /* by 1, which changes nothing, without gain */
        if (roots) {
            out[c] = value > 0x1p32f ? 0x1p32f : value < -0x1p32f ? -0x1p32f : value;
            continue;
        }
        value = btf_ref_keep_within(value);
        out[c] = material->domain_sqrt ? value * value : value;
    }
}

bool btf_ref_probe_source(void) {
    return btf_ref_probe();
}
