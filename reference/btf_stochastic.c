/* OpenBTF reference decoder: one neighbour in place of all, picked with its weight, and the mean of such
 * picks (FORMAT.md, section 9, Stochastic decode; filtering after shading of Pharr, Wronski, Salvi and Fajardo 2024).
 *
 * SPDX-License-Identifier: MIT
 */
#include "btf_reference_private.h"

enum { CHANNELS = 3, WEIGHT_BITS = 12, FULL_WEIGHT = 1 << WEIGHT_BITS, FULL_TEXEL = 65536 };

/** A point under a light, before any choice. */
typedef struct scene {
    btf_ref_situation shared;
    const btf_ref_options *options;
    int picks;
    const float *light, *view;
    btf_ref_neighbours views; /**< with relief, weights after occlusion */
    uint32_t tu[3], tv[3];    /**< where each view shows the point, 18 bits below the texel */
} scene;

void btf_ref_random(const uint32_t counter[3], uint32_t out_random[3]) {
    uint32_t x = counter[0] * 1664525u + 1013904223u;
    uint32_t y = counter[1] * 1664525u + 1013904223u;
    uint32_t z = counter[2] * 1664525u + 1013904223u;
    for (int round = 0; round < 2; ++round) {
        x += y * z;
        y += z * x;
        z += x * y;
        if (round == 0) {
            x ^= x >> 16;
            y ^= y >> 16;
            z ^= z >> 16;
        }
    }
    out_random[0] = x;
    out_random[1] = y;
    out_random[2] = z;
}

/** Makes a scene of light and view above the horizon. */
static scene set_scene(const btf_ref_material *material, const btf_ref_options *options, int picks, float u,
                       float v, const float light[3], const float view[3]) {
    scene s = {.shared = btf_ref_make_situation(material, options, light, view),
               .options = options,
               .picks = picks,
               .light = light,
               .view = view};
    const bool linear = options->interpolation != BTF_REF_NEAREST;
    int32_t q[2];
    btf_ref_project(view, q);
    s.views = btf_ref_lookup(material->view_table, material->view_grid, q);
    if (!linear) {
        s.views = btf_ref_nearest(s.views);
    }

    uint32_t tu = btf_ref_coordinate(u, material->width), tv = btf_ref_coordinate(v, material->height);
    for (int a = 0; a < 3; ++a) {
        s.tu[a] = tu;
        s.tv[a] = tv;
    }
    if (s.shared.effects & BTF_REF_RELIEF) {
        const int32_t position[2] = {(int32_t)(tu >> 10), (int32_t)(tv >> 10)};
        int32_t positions[3][2];
        uint32_t weights[3];
        btf_ref_relief(material, &s.views, view, linear, position, positions, weights);
        for (int a = 0; a < 3; ++a) {
            s.views.weight[a] = weights[a];
            s.tu[a] = (uint32_t)positions[a][0] << 10;
            s.tv[a] = (uint32_t)positions[a][1] << 10;
        }
    }
    return s;
}

/** The lights around the light, with gloss as view a has them. */
static btf_ref_neighbours lights_around(const scene *s, int a) {
    const btf_ref_material *material = s->shared.material;
    int32_t q[2];
    if (s->shared.effects & BTF_REF_GLOSS) {
        btf_ref_gloss(material, s->views.index[a], s->light, s->view, q);
    } else {
        btf_ref_project(s->light, q);
    }
    btf_ref_neighbours lights = btf_ref_lookup(material->light_table, material->light_grid, q);
    return s->options->interpolation == BTF_REF_NEAREST ? btf_ref_nearest(lights) : lights;
}

static void add_weighted(float sum[CHANNELS], const float value[CHANNELS], float weight) {
    for (int c = 0; c < CHANNELS; ++c) {
        float term = value[c] * weight;
        sum[c] = sum[c] + term;
    }
}

static void to_radiance(const btf_ref_material *material, float value[CHANNELS]) {
    for (int c = 0; c < CHANNELS; ++c) {
        if (material->blend == BTF_REF_BLEND_ROOTS) {
            float root = btf_ref_keep_within(value[c]);
            value[c] = root * root;
        }
        value[c] = value[c] * material->radiance_scale;
    }
}

/** Section 9 with the whole weight on view a: radiance of some texels, blended as the filter says. With
 * relief it is a view's values that are blended, else radiance. */
static void decode_view(const scene *s, int a, const btf_ref_lights *lights,
                        const btf_ref_footprint *texels, float out_rgb[CHANNELS]) {
    const btf_ref_material *material = s->shared.material;
    const bool values_first = (s->shared.effects & BTF_REF_RELIEF) != 0;
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    for (uint32_t i = 0; i < texels->count; ++i) {
        float value[CHANNELS];
        btf_ref_view_value(&s->shared, lights, texels->column[i], texels->row[i], s->views.index[a], value);
        if (!values_first) {
            to_radiance(material, value);
        }
        add_weighted(out_rgb, value, (float)texels->weight[i] * 0x1p-16f);
    }
    if (values_first) {
        to_radiance(material, out_rgb);
    }
}

/** A footprint of one texel. */
static btf_ref_footprint one_texel(uint32_t column, uint32_t row) {
    return (btf_ref_footprint){.count = 1, .column = {column}, .row = {row}, .weight = {FULL_TEXEL}};
}

static btf_ref_lights one_light(const btf_ref_neighbours *lights, int b) {
    return (btf_ref_lights){.count = 1, .index = {lights->index[b]}, .weight = {FULL_WEIGHT}};
}

/* The mean of all choices: sums within sums.
 * ---------------------------------------------------------------------------------------------------- */

/** Over the texels of the filter, where these are picked. */
static void blend_texels(const scene *s, int a, const btf_ref_lights *lights, float out_rgb[CHANNELS]) {
    btf_ref_footprint texels =
        btf_ref_texels_around(s->shared.material, s->options->filter, s->tu[a], s->tv[a]);
    if (s->picks < BTF_REF_PICK_ALL) {
        decode_view(s, a, lights, &texels, out_rgb);
        return;
    }
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    for (uint32_t i = 0; i < texels.count; ++i) {
        float radiance[CHANNELS];
        btf_ref_footprint one = one_texel(texels.column[i], texels.row[i]);
        decode_view(s, a, lights, &one, radiance);
        add_weighted(out_rgb, radiance, (float)texels.weight[i] * 0x1p-16f);
    }
}

/** Over the lights of a view, where these are picked. */
static void blend_lights(const scene *s, int a, float out_rgb[CHANNELS]) {
    btf_ref_neighbours lights = lights_around(s, a);
    if (s->picks < BTF_REF_PICK_LIGHT) {
        btf_ref_lights all = btf_ref_lights_of(&lights);
        blend_texels(s, a, &all, out_rgb);
        return;
    }
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    for (int b = 0; b < 3; ++b) {
        if (lights.weight[b] == 0) {
            continue;
        }
        float radiance[CHANNELS];
        btf_ref_lights one = one_light(&lights, b);
        blend_texels(s, a, &one, radiance);
        add_weighted(out_rgb, radiance, (float)lights.weight[b] * 0x1p-12f);
    }
}

void btf_ref_evaluate_radiance_blend(const btf_ref_material *material, const btf_ref_options *options,
                                     int picks, float u, float v, const float light[3], const float view[3],
                                     float out_rgb[3]) {
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    if (!btf_ref_above_horizon(light, view)) {
        return;
    }
    scene s = set_scene(material, options, picks, u, v, light, view);
    for (int a = 0; a < 3; ++a) {
        if (s.views.weight[a] == 0) {
            continue;
        }
        float radiance[CHANNELS];
        blend_lights(&s, a, radiance);
        add_weighted(out_rgb, radiance, (float)s.views.weight[a] * 0x1p-12f);
    }
}

/* One choice.
 * ---------------------------------------------------------------------------------------------------- */

/** The neighbour whose share of 0 .. 4095, in their order, holds the highest bits of a number. */
static int pick(const btf_ref_neighbours *neighbours, uint32_t random) {
    uint32_t number = random >> (32 - WEIGHT_BITS), end = 0;
    for (int i = 0; i < 2; ++i) {
        end += neighbours->weight[i];
        if (number < end) {
            return i;
        }
    }
    return 2;
}

/** The texel of the filter that a number picks: columns by bits 24 to 31, rows by bits 16 to 23. */
static btf_ref_footprint pick_texel(const scene *s, int a, uint32_t random) {
    const btf_ref_material *material = s->shared.material;
    const uint32_t size[2] = {material->width, material->height}, t[2] = {s->tu[a], s->tv[a]};
    const uint32_t number[2] = {random >> 24, random >> 16 & 255u};
    uint32_t chosen[2];
    for (int axis = 0; axis < 2; ++axis) {
        uint32_t near, far, weight;
        btf_ref_bilinear(t[axis], size[axis], &near, &far, &weight);
        if (s->options->filter == BTF_REF_STEEP) {
            weight = btf_ref_steep(weight);
        }
        chosen[axis] = number[axis] < weight ? far : near;
    }
    return one_texel(chosen[0], size[1] - 1 - chosen[1]);
}

void btf_ref_evaluate_stochastic(const btf_ref_material *material, const btf_ref_options *options,
                                 int picks, float u, float v, const float light[3], const float view[3],
                                 const uint32_t random[3], float out_rgb[3]) {
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    if (!btf_ref_above_horizon(light, view)) {
        return;
    }
    scene s = set_scene(material, options, picks, u, v, light, view);
    int a = pick(&s.views, random[0]);
    btf_ref_neighbours around = lights_around(&s, a);
    btf_ref_lights lights = picks >= BTF_REF_PICK_LIGHT ? one_light(&around, pick(&around, random[1]))
                                                        : btf_ref_lights_of(&around);
    btf_ref_footprint texels = picks >= BTF_REF_PICK_ALL && options->filter != BTF_REF_TEXEL
                                   ? pick_texel(&s, a, random[2])
                                   : btf_ref_texels_around(material, options->filter, s.tu[a], s.tv[a]);
    decode_view(&s, a, &lights, &texels, out_rgb);
}

/* Between two levels of detail.
 * ---------------------------------------------------------------------------------------------------- */

/** A level in 256ths, of those there are. */
static uint32_t level_256ths(float level, uint32_t levels) {
    uint32_t bits = btf_ref_bits(level);
    if (bits > 0x7F800000u || bits == 0) { /* negative, NaN, 0 */
        return 0;
    }
    if (level >= (float)(levels - 1)) {
        return (levels - 1) * 256;
    }
    return (uint32_t)(level * 256.0f);
}

void btf_ref_evaluate_stochastic_between(const btf_ref_material *levels, uint32_t count,
                                         const btf_ref_options *options, int picks, float level, float u,
                                         float v, const float light[3], const float view[3],
                                         const uint32_t random[3], float out_rgb[3]) {
    uint32_t at = level_256ths(level, count), share = at % 256;
    uint32_t i = at / 256 + ((random[2] >> 8 & 255u) < share ? 1 : 0);
    btf_ref_evaluate_stochastic(&levels[i], options, picks, u, v, light, view, random, out_rgb);
}

void btf_ref_evaluate_radiance_blend_between(const btf_ref_material *levels, uint32_t count,
                                             const btf_ref_options *options, int picks, float level,
                                             float u, float v, const float light[3], const float view[3],
                                             float out_rgb[3]) {
    uint32_t at = level_256ths(level, count), share = at % 256;
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    for (uint32_t i = 0; i < 2; ++i) {
        uint32_t weight = i == 0 ? 256 - share : share;
        if (weight == 0) {
            continue;
        }
        float radiance[CHANNELS];
        btf_ref_evaluate_radiance_blend(&levels[at / 256 + i], options, picks, u, v, light, view, radiance);
        add_weighted(out_rgb, radiance, (float)weight * 0x1p-8f);
    }
}

bool btf_ref_probe_stochastic(void) {
    return btf_ref_probe();
}
