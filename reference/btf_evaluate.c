/* OpenBTF reference decoder: radiance of a texel and of a point (FORMAT.md, sections 3, 4 and 9).
 *
 * SPDX-License-Identifier: MIT
 */
#include "btf_reference_private.h"

#include <stddef.h>

enum { MAX_LOBES = 4, CHANNELS = 3, DIFFUSE_AND_WEIGHTS = CHANNELS * (1 + MAX_LOBES) };

/** The part of an evaluation that all texels share under one light and one view. */
typedef struct situation {
    const btf_ref_material *material;
    uint32_t effects;    /**< decoded */
    uint32_t components; /**< decoded; units, with factors */
    btf_ref_lights lights;
    btf_ref_neighbours views;
    float product[3]; /**< P of section 9: l * V by component */
    float cosine;     /**< m of section 9 */
    float horizon;    /**< m_r of section 9; with factors */
} situation;

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
static const uint8_t *listed_point(const btf_ref_material *material, uint32_t column, uint32_t row, uint32_t view) {
    uint32_t two_views = material->point_indices[layer_index(material, view / 2, column, row)];
    uint32_t entry = view % 2 == 0 ? two_views % 16 : two_views / 16;
    return material->point_lists + 2 * layer_index(material, entry, column, row);
}

/** Section 3, packed points: 6 bits of column shift, 6 of row shift, 4 of gain. */
static appearance read_packed(const situation *s, uint32_t column, uint32_t row, uint32_t view) {
    const btf_ref_material *material = s->material;
    const uint8_t *bytes = material->point_lists ? listed_point(material, column, row, view)
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
static appearance read_appearance(const situation *s, uint32_t column, uint32_t row, uint32_t view) {
    const btf_ref_material *material = s->material;
    appearance result = {false, 0, 0, 0, 1.0f};
    uint32_t code = 128, byte0 = 0, byte1 = 0;

    if (material->points_packed)
        return read_packed(s, column, row, view);
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
    if (s->effects & BTF_REF_GAIN)
        result.gain = (float)code * material->gain_scale;
    return result;
}

/** Section 9: sum over lights of weight and shadow code; 0 to 255 * 4096. */
static int32_t shadow_sum(const situation *s, uint32_t column, uint32_t row) {
    const btf_ref_material *material = s->material;
    int32_t sum = 0;
    for (uint32_t b = 0; b < s->lights.count; ++b) {
        uint32_t light = s->lights.index[b];
        uint8_t code = material->layout_tight ? material->shadow[layer_index(material, light, column, row)]
                                              : tile_byte(material, light, column, row, 0);
        sum += s->lights.weight[b] * code;
    }
    return sum;
}

/** Value of a centre before it is squared. */
static void centre_value(const situation *s, uint32_t centre, float out_y[3]) {
    const btf_ref_material *material = s->material;
    const uint8_t *texture = material->layout_tight ? material->centre : material->maps;
    uint32_t width = material->atlas_width;
    if (material->layout_tight) /* ceil(K / 4096) blocks of n_lights columns */
        width = (material->centres + 4095) / 4096 * material->n_lights;

    int32_t sum[3] = {0, 0, 0};
    for (uint32_t b = 0; b < s->lights.count; ++b) {
        uint32_t x, y;
        btf_ref_centre(material, centre, s->lights.index[b], &x, &y);
        const uint8_t *code = texture + 4 * ((size_t)y * width + x);
        for (int c = 0; c < CHANNELS; ++c)
            sum[c] += s->lights.weight[b] * code[c];
    }
    float scale = material->centre_scale * 0x1p-12f;
    for (int c = 0; c < CHANNELS; ++c)
        out_y[c] = (float)sum[c] * scale;
}

/** The four parameters in a layer of `sbrdf`. */
static void read_parameters(const btf_ref_material *material, uint32_t layer, uint32_t column, uint32_t row,
                            float out_parameters[4]) {
    size_t first = 4 * layer_index(material, layer, column, row);
    for (size_t i = 0; i < 4; ++i) {
        if (material->half_float)
            out_parameters[i] = btf_ref_half(((const uint16_t *)material->sbrdf)[first + i]);
        else
            out_parameters[i] = ((const float *)material->sbrdf)[first + i];
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
static void sbrdf(const situation *s, uint32_t column, uint32_t row, float out_f[3]) {
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
        for (int c = 0; c < CHANNELS; ++c)
            out_f[c] = colour[c] * sum;
        return;
    }

    float factors[DIFFUSE_AND_WEIGHTS + 1]; /* the diffuse term, then a weight a lobe; in whole layers */
    uint32_t factor_layers = (CHANNELS * (1 + material->lobes) + 3) / 4;
    for (uint32_t layer = 0; layer < factor_layers; ++layer)
        read_parameters(material, layer, column, row, factors + 4 * layer);
    for (int c = 0; c < CHANNELS; ++c)
        out_f[c] = factors[c];
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
static void residual(const situation *s, uint32_t column, uint32_t row, uint32_t view, float out_r[3]) {
    const btf_ref_material *material = s->material;
    const size_t plane = (size_t)material->n_views * material->n_lights;

    for (int c = 0; c < CHANNELS; ++c)
        out_r[c] = 0.0f;
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
            for (uint32_t b = 0; b < s->lights.count; ++b)
                sum += s->lights.weight[b] * v[4 * s->lights.index[b]];
            float term = factor * (float)sum;
            out_r[c] = out_r[c] + term;
        }
    }
}

/** y of section 9 before the gain: a source texel, modelled and residual, under the light's cosine. */
static void source(const situation *s, uint32_t column, uint32_t row, uint32_t view, float out_y[3]) {
    const btf_ref_material *material = s->material;
    bool modelled = material->colour != BTF_REF_NONE;
    float h[3] = {0.0f, 0.0f, 0.0f}, r[3];

    if (modelled)
        sbrdf(s, column, row, h);
    if (modelled && (s->effects & BTF_REF_SHADOW)) {
        float scale = material->shadow_scale * 0x1p-12f;
        float shadow = (float)shadow_sum(s, column, row) * scale;
        for (int c = 0; c < CHANNELS; ++c)
            h[c] = h[c] * shadow;
    }
    if (!(s->effects & BTF_REF_RESIDUAL)) {
        for (int c = 0; c < CHANNELS; ++c)
            out_y[c] = h[c] * s->cosine;
        return;
    }
    if (material->store == BTF_REF_FACTORS) {
        btf_ref_factors(material, s->components, &s->lights, column, row, view, r);
        for (int c = 0; c < CHANNELS; ++c) {
            float term = r[c] * s->horizon;
            out_y[c] = h[c] * s->cosine;
            out_y[c] = modelled ? out_y[c] + term : term;
        }
        return;
    }
    residual(s, column, row, view, r);
    for (int c = 0; c < CHANNELS; ++c) {
        out_y[c] = modelled ? h[c] + r[c] : r[c];
        out_y[c] = out_y[c] * s->cosine;
    }
}

/** Within 0 and 2^32; 0 below 2^-30. */
static float keep_within(float value) {
    if (!(value >= 0x1p-30f))
        return 0.0f;
    if (value > 0x1p32f)
        return 0x1p32f;
    return value;
}

/** The value of a texel that is blended in one view: L of section 9, or y where the blend is of roots. */
static void view_value(const situation *s, uint32_t column, uint32_t row, uint32_t view, float out[3]) {
    const btf_ref_material *material = s->material;
    bool roots = material->blend == BTF_REF_BLEND_ROOTS;
    appearance seen = read_appearance(s, column, row, view);

    if (seen.hidden) {
        centre_value(s, seen.centre, out);
        for (int c = 0; c < CHANNELS; ++c)
            out[c] = roots ? out[c] : out[c] * out[c];
        return;
    }
    uint32_t source_column = btf_ref_wrap(column, seen.columns, material->width);
    uint32_t source_row = btf_ref_wrap(row, seen.rows, material->height);
    source(s, source_column, source_row, view, out);
    for (int c = 0; c < CHANNELS; ++c) {
        float value = out[c] * seen.gain; /* by 1, which changes nothing, without gain */
        if (roots) {
            out[c] = value > 0x1p32f ? 0x1p32f : value < -0x1p32f ? -0x1p32f : value;
            continue;
        }
        value = keep_within(value);
        out[c] = material->domain_sqrt ? value * value : value;
    }
}

/** Section 9, one texel, in a situation that is above the horizon. */
static void texel_radiance(const situation *s, uint32_t column, uint32_t row, float out_rgb[3]) {
    float sum[3] = {0.0f, 0.0f, 0.0f};
    for (int a = 0; a < 3; ++a) {
        if (s->views.weight[a] == 0)
            continue;
        float weight = (float)s->views.weight[a] * 0x1p-12f;
        float value[3];
        view_value(s, column, row, s->views.index[a], value);
        for (int c = 0; c < CHANNELS; ++c) {
            float term = value[c] * weight;
            sum[c] = sum[c] + term;
        }
    }
    for (int c = 0; c < CHANNELS; ++c) {
        if (s->material->blend == BTF_REF_BLEND_ROOTS) {
            float root = keep_within(sum[c]);
            sum[c] = root * root;
        }
        out_rgb[c] = sum[c] * s->material->radiance_scale;
    }
}

/** Section 9, Directions. @return whether there is anything to be seen. */
static bool above_horizon(const float light[3], const float view[3]) {
    for (int i = 0; i < 3; ++i) {
        uint32_t l = btf_ref_bits(light[i]) & 0x7FFFFFFFu, v = btf_ref_bits(view[i]) & 0x7FFFFFFFu;
        if (l > 0x40000000u || v > 0x40000000u) /* beyond 2, infinite, NaN */
            return false;
    }
    return light[2] >= 0x1p-24f && view[2] >= 0x1p-24f;
}

/** Everything that does not depend on the texel; `light` and `view` are above the horizon. */
static situation make_situation(const btf_ref_material *material, const btf_ref_options *options,
                                const btf_ref_neighbours *lights, const btf_ref_neighbours *views,
                                const float light[3], const float view[3]) {
    bool nearest = options->interpolation == BTF_REF_NEAREST;
    btf_ref_neighbours used_lights = nearest ? btf_ref_nearest(*lights) : *lights;
    situation s = {
        .material = material,
        .effects = material->effects & options->effects,
        .views = nearest ? btf_ref_nearest(*views) : *views,
        .cosine = material->domain_sqrt ? btf_ref_pow(light[2], 0.5f) : light[2],
    };
    if (s.effects & BTF_REF_RESIDUAL)
        s.components =
            options->components < material->components ? options->components : material->components;
    if (material->store == BTF_REF_FACTORS) {
        float q = light[2] * material->horizon_scale;
        s.horizon = q < 1.0f ? (material->domain_sqrt ? btf_ref_pow(q, 0.5f) : q) : 1.0f;
    }
    for (int b = 0; b < 3; ++b) {
        if (used_lights.weight[b] == 0)
            continue;
        s.lights.index[s.lights.count] = used_lights.index[b];
        s.lights.weight[s.lights.count] = (int32_t)used_lights.weight[b];
        ++s.lights.count;
    }
    for (int i = 0; i < 3; ++i)
        s.product[i] = light[i] * view[i];
    return s;
}

static btf_ref_neighbours look_up(const uint16_t *table, uint32_t grid, const float direction[3]) {
    int32_t q[2];
    btf_ref_project(direction, q);
    return btf_ref_lookup(table, grid, q);
}

void btf_ref_evaluate_neighbours(const btf_ref_material *material, const btf_ref_options *options,
                                 uint32_t column, uint32_t row, const btf_ref_neighbours *lights,
                                 const btf_ref_neighbours *views, const float light[3], const float view[3],
                                 float out_rgb[3]) {
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    if (!above_horizon(light, view))
        return;
    situation s = make_situation(material, options, lights, views, light, view);
    texel_radiance(&s, column, row, out_rgb);
}

void btf_ref_evaluate_texel(const btf_ref_material *material, const btf_ref_options *options,
                            uint32_t column, uint32_t row, const float light[3], const float view[3],
                            float out_rgb[3]) {
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    if (!above_horizon(light, view))
        return;
    btf_ref_neighbours views = look_up(material->view_table, material->view_grid, view);
    btf_ref_neighbours lights = look_up(material->light_table, material->light_grid, light);
    situation s = make_situation(material, options, &lights, &views, light, view);
    texel_radiance(&s, column, row, out_rgb);
}

void btf_ref_evaluate(const btf_ref_material *material, const btf_ref_options *options, float u, float v,
                      const float light[3], const float view[3], float out_rgb[3]) {
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    if (!above_horizon(light, view))
        return;
    btf_ref_neighbours views = look_up(material->view_table, material->view_grid, view);
    btf_ref_neighbours lights = look_up(material->light_table, material->light_grid, light);
    situation s = make_situation(material, options, &lights, &views, light, view);

    uint32_t width = material->width, height = material->height;
    uint32_t tu = btf_ref_coordinate(u, width), tv = btf_ref_coordinate(v, height);
    if (options->filter == BTF_REF_TEXEL) {
        texel_radiance(&s, tu >> 18, height - 1 - (tv >> 18), out_rgb);
        return;
    }

    uint32_t column[2], row[2], weight_u[2], weight_v[2];
    btf_ref_bilinear(tu, width, &column[0], &column[1], &weight_u[1]);
    btf_ref_bilinear(tv, height, &row[0], &row[1], &weight_v[1]);
    weight_u[0] = 256 - weight_u[1];
    weight_v[0] = 256 - weight_v[1];
    /* L00 * w00 + L10 * w10 + L01 * w01 + L11 * w11, from the left; what weighs 0 adds 0 */
    for (int corner = 0; corner < 4; ++corner) {
        int i = corner & 1, j = corner >> 1;
        uint32_t product = weight_u[i] * weight_v[j];
        if (product == 0)
            continue;
        float weight = (float)product * 0x1p-16f;
        float radiance[3];
        texel_radiance(&s, column[i], height - 1 - row[j], radiance);
        for (int c = 0; c < CHANNELS; ++c) {
            float term = radiance[c] * weight;
            out_rgb[c] = out_rgb[c] + term;
        }
    }
}

bool btf_ref_probe_evaluate(void) {
    return btf_ref_probe();
}
