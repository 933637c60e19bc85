/* OpenBTF reference decoder: radiance of a texel and of a point: neighbours, filters, blends (FORMAT.md,
 * section 9).
 *
 * SPDX-License-Identifier: MIT
 */
#include "btf_reference_private.h"

#include <stddef.h>

enum { CHANNELS = 3, CORNERS = 4 };

/** An evaluation: what texels and views share, and the neighbours. */
typedef struct evaluation {
    btf_ref_situation shared;
    btf_ref_neighbours views;
    btf_ref_lights lights[3]; /**< of each neighbouring view */
    uint32_t shown[3];        /**< the views, or where each lies in what was folded */
    const float *view;        /**< V */
    bool linear;              /**< directions */
} evaluation;

bool btf_ref_above_horizon(const float light[3], const float view[3]) {
    for (int i = 0; i < 3; ++i) {
        uint32_t l = btf_ref_bits(light[i]) & 0x7FFFFFFFu, v = btf_ref_bits(view[i]) & 0x7FFFFFFFu;
        if (l > 0x40000000u || v > 0x40000000u) { /* beyond 2, infinite, NaN */
            return false;
        }
    }
    return light[2] >= 0x1p-24f && view[2] >= 0x1p-24f;
}

btf_ref_lights btf_ref_lights_of(const btf_ref_neighbours *neighbours) {
    btf_ref_lights lights = {0};
    for (int b = 0; b < 3; ++b) {
        if (neighbours->weight[b] == 0) {
            continue;
        }
        lights.index[lights.count] = neighbours->index[b];
        lights.weight[lights.count] = (int32_t)neighbours->weight[b];
        ++lights.count;
    }
    return lights;
}

static btf_ref_lights some_lights(btf_ref_neighbours neighbours, bool linear) {
    if (!linear) {
        neighbours = btf_ref_nearest(neighbours);
    }
    return btf_ref_lights_of(&neighbours);
}

/** The effects that act: relief ends before a level (section 9). */
static uint32_t acting_effects(const btf_ref_material *material, const btf_ref_options *options) {
    uint32_t effects = material->effects & options->effects;
    bool ended = material->relief_end > 0 && material->level >= material->relief_end;
    return ended ? effects & ~(uint32_t)BTF_REF_RELIEF : effects;
}

btf_ref_situation btf_ref_make_situation(const btf_ref_material *material, const btf_ref_options *options,
                                         const float light[3], const float view[3]) {
    btf_ref_situation s = {.material = material,
                           .effects = acting_effects(material, options),
                           .cosine = material->domain_sqrt ? btf_ref_pow(light[2], 0.5f) : light[2]};
    if (s.effects & BTF_REF_RESIDUAL) {
        s.components =
            options->components < material->components ? options->components : material->components;
    }
    if (material->store == BTF_REF_FACTORS) {
        float q = light[2] * material->horizon_scale;
        s.horizon = q < 1.0f ? (material->domain_sqrt ? btf_ref_pow(q, 0.5f) : q) : 1.0f;
    }
    for (int i = 0; i < 3; ++i) {
        s.product[i] = light[i] * view[i];
    }
    return s;
}

/** Everything that does not depend on the texel, with the same lights for every view; `light` and `view`
 * are above the horizon. */
static evaluation make_evaluation(const btf_ref_material *material, const btf_ref_options *options,
                                  const btf_ref_neighbours *lights, const btf_ref_neighbours *views,
                                  const float light[3], const float view[3]) {
    bool linear = options->interpolation != BTF_REF_NEAREST;
    evaluation e = {
        .shared = btf_ref_make_situation(material, options, light, view),
        .views = linear ? *views : btf_ref_nearest(*views),
        .view = view,
        .linear = linear,
    };
    for (int i = 0; i < 3; ++i) {
        e.lights[i] = some_lights(*lights, linear);
        e.shown[i] = e.views.index[i];
    }
    return e;
}

/** An evaluation whose neighbours are looked up here, with gloss the lights of each view. */
static evaluation look_up(const btf_ref_material *material, const btf_ref_options *options,
                          const float light[3], const float view[3]) {
    int32_t q[2];
    btf_ref_project(view, q);
    btf_ref_neighbours views = btf_ref_lookup(material->view_table, material->view_grid, q);
    btf_ref_project(light, q);
    btf_ref_neighbours lights = btf_ref_lookup(material->light_table, material->light_grid, q);
    evaluation e = make_evaluation(material, options, &lights, &views, light, view);
    if (!(e.shared.effects & BTF_REF_GLOSS)) {
        return e;
    }
    for (int a = 0; a < 3; ++a) {
        btf_ref_gloss(material, e.views.index[a], light, view, q);
        lights = btf_ref_lookup(material->light_table, material->light_grid, q);
        e.lights[a] = some_lights(lights, e.linear);
    }
    return e;
}

/** The sum over views and what follows it; values of views of weight 0 are not read. */
static void blend_views(const evaluation *e, const uint32_t weights[3], float values[3][CHANNELS],
                        float out_rgb[3]) {
    const btf_ref_material *material = e->shared.material;
    float sum[CHANNELS] = {0.0f, 0.0f, 0.0f};
    for (int a = 0; a < 3; ++a) {
        if (weights[a] == 0) {
            continue;
        }
        float weight = (float)weights[a] * 0x1p-12f;
        for (int c = 0; c < CHANNELS; ++c) {
            float term = values[a][c] * weight;
            sum[c] = sum[c] + term;
        }
    }
    for (int c = 0; c < CHANNELS; ++c) {
        if (material->blend == BTF_REF_BLEND_ROOTS) {
            float root = btf_ref_keep_within(sum[c]);
            sum[c] = root * root;
        }
        out_rgb[c] = sum[c] * material->radiance_scale;
    }
}

/** The sum, over lights, of the products of the roots that views i and j show: of one view its own layer; of two a layer
 * behind that of the one which names the other in its fourth channel. */
static const float *kept_products(const evaluation *e, uint32_t column, uint32_t row, uint32_t i,
                                  uint32_t j) {
    const btf_ref_material *m = e->shared.material;
    size_t layer = (size_t)4 * m->width * m->height;
    const float *texel = e->shared.folded->values + 4 * ((size_t)row * m->width + column);
    uint32_t views[2] = {i, j};
    for (int turn = 0; turn < 2 && i != j; ++turn) {
        const float *own = texel + 4 * layer * views[turn];
        for (uint32_t partner = 0; partner < 3; ++partner) {
            if ((btf_ref_bits(own[3]) >> (10 * partner) & 1023u) == views[1 - turn]) {
                return own + layer * (1 + partner);
            }
        }
    }
    return texel + 4 * layer * i;
}

/** The square of the blended roots, multiplied out and added up over lights; first squares, then products. */
static void blend_products(const evaluation *e, uint32_t column, uint32_t row, float out_rgb[3]) {
    static const int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    const uint32_t *weight = e->views.weight;
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    for (int k = 0; k < 6; ++k) {
        int a = pairs[k][0], b = pairs[k][1];
        if (weight[a] == 0 || weight[b] == 0) {
            continue;
        }
        const float *kept = kept_products(e, column, row, e->views.index[a], e->views.index[b]);
        float share = (float)((a == b ? 1 : 2) * weight[a] * weight[b]) * 0x1p-24f;
        for (int c = 0; c < CHANNELS; ++c) {
            float term = kept[c] * share;
            out_rgb[c] = out_rgb[c] + term;
        }
    }
    for (int c = 0; c < CHANNELS; ++c) {
        out_rgb[c] = (out_rgb[c] > 0.0f ? out_rgb[c] : 0.0f) * e->shared.material->radiance_scale;
    }
}

/** Section 9, one texel, without relief. */
static void texel_radiance(const evaluation *e, uint32_t column, uint32_t row, float out_rgb[3]) {
    const btf_ref_folded *folded = e->shared.folded;
    if (folded && folded->fold == BTF_REF_FOLD_BOTH) {
        const float *kept = folded->values + 4 * ((size_t)row * e->shared.material->width + column);
        for (int c = 0; c < CHANNELS; ++c) {
            out_rgb[c] = kept[c];
        }
        return;
    }
    if (folded && folded->fold == BTF_REF_FOLD_SUM && e->shared.material->blend == BTF_REF_BLEND_ROOTS) {
        blend_products(e, column, row, out_rgb);
        return;
    }
    float values[3][CHANNELS];
    for (int a = 0; a < 3; ++a) {
        if (e->views.weight[a] > 0) {
            btf_ref_view_value(&e->shared, &e->lights[a], column, row, e->shown[a], values[a]);
        }
    }
    blend_views(e, e->views.weight, values, out_rgb);
}

btf_ref_footprint btf_ref_texels_around(const btf_ref_material *material, int filter, uint32_t tu,
                                        uint32_t tv) {
    uint32_t width = material->width, height = material->height;
    btf_ref_footprint f = {
        .count = 1, .column = {tu >> 18}, .row = {height - 1 - (tv >> 18)}, .weight = {65536}};
    if (filter == BTF_REF_TEXEL) {
        return f;
    }

    uint32_t column[2], row[2], weight_u[2], weight_v[2];
    btf_ref_bilinear(tu, width, &column[0], &column[1], &weight_u[1]);
    btf_ref_bilinear(tv, height, &row[0], &row[1], &weight_v[1]);
    if (filter == BTF_REF_STEEP) {
        weight_u[1] = btf_ref_steep(weight_u[1]);
        weight_v[1] = btf_ref_steep(weight_v[1]);
    }
    weight_u[0] = 256 - weight_u[1];
    weight_v[0] = 256 - weight_v[1];
    f.count = 0;
    for (int corner = 0; corner < CORNERS; ++corner) { /* 00, 10, 01, 11 */
        int i = corner & 1, j = corner >> 1;
        uint32_t product = weight_u[i] * weight_v[j];
        if (product == 0) {
            continue;
        }
        f.column[f.count] = column[i];
        f.row[f.count] = height - 1 - row[j];
        f.weight[f.count] = product;
        ++f.count;
    }
    return f;
}

/** Adds a term of a filter's sum, which is taken from the left. */
static void add_weighted(float sum[CHANNELS], const float value[CHANNELS], uint32_t weight) {
    float share = (float)weight * 0x1p-16f;
    for (int c = 0; c < CHANNELS; ++c) {
        float term = value[c] * share;
        sum[c] = sum[c] + term;
    }
}

/** Radiance at texture coordinates without relief: of decoded texels, blended. */
static void filtered_radiance(const evaluation *e, int filter, uint32_t tu, uint32_t tv, float out_rgb[3]) {
    btf_ref_footprint f = btf_ref_texels_around(e->shared.material, filter, tu, tv);
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    for (uint32_t i = 0; i < f.count; ++i) {
        float radiance[CHANNELS];
        texel_radiance(e, f.column[i], f.row[i], radiance);
        add_weighted(out_rgb, radiance, f.weight[i]);
    }
}

/** With relief: each view's texels are blended around a position of its own, then views. */
static void relief_radiance(const evaluation *e, int filter, uint32_t tu, uint32_t tv, float out_rgb[3]) {
    const int32_t position[2] = {(int32_t)(tu >> 10), (int32_t)(tv >> 10)};
    int32_t positions[3][2];
    uint32_t weights[3];
    float values[3][CHANNELS] = {{0.0f}};
    btf_ref_relief(e->shared.material, &e->views, e->view, e->linear, position, positions, weights);
    for (int a = 0; a < 3; ++a) {
        if (weights[a] == 0) {
            continue;
        }
        btf_ref_footprint f = btf_ref_texels_around(
            e->shared.material, filter, (uint32_t)positions[a][0] << 10, (uint32_t)positions[a][1] << 10);
        for (uint32_t i = 0; i < f.count; ++i) {
            float value[CHANNELS];
            btf_ref_view_value(&e->shared, &e->lights[a], f.column[i], f.row[i], e->shown[a], value);
            add_weighted(values[a], value, f.weight[i]);
        }
    }
    blend_views(e, weights, values, out_rgb);
}

static void radiance_at(const evaluation *e, int filter, uint32_t tu, uint32_t tv, float out_rgb[3]) {
    if (e->shared.effects & BTF_REF_RELIEF) {
        relief_radiance(e, filter, tu, tv, out_rgb);
    } else {
        filtered_radiance(e, filter, tu, tv, out_rgb);
    }
}

/** Radiance of a texel: with relief, at its centre. */
static void radiance_of(const evaluation *e, uint32_t column, uint32_t row, float out_rgb[3]) {
    const uint32_t half = 1u << 17;
    uint32_t from_below = e->shared.material->height - 1 - row;
    radiance_at(e, BTF_REF_TEXEL, (column << 18) + half, (from_below << 18) + half, out_rgb);
}

void btf_ref_evaluate_neighbours(const btf_ref_material *material, const btf_ref_options *options,
                                 uint32_t column, uint32_t row, const btf_ref_neighbours *lights,
                                 const btf_ref_neighbours *views, const float light[3], const float view[3],
                                 float out_rgb[3]) {
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    if (!btf_ref_above_horizon(light, view)) {
        return;
    }
    evaluation e = make_evaluation(material, options, lights, views, light, view);
    radiance_of(&e, column, row, out_rgb);
}

void btf_ref_evaluate_apart(const btf_ref_material *material, const btf_ref_options *options,
                            uint32_t column, uint32_t row, const btf_ref_neighbours lights[3],
                            const btf_ref_neighbours *views, const float light[3], const float view[3],
                            float out_rgb[3]) {
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    if (!btf_ref_above_horizon(light, view)) {
        return;
    }
    evaluation e = make_evaluation(material, options, lights, views, light, view);
    for (int a = 0; a < 3; ++a) {
        int from = a;
        while (views->index[from] != e.views.index[a]) { /* the nearest view is one of the three */
            from = (from + 1) % 3;
        }
        e.lights[a] = some_lights(lights[from], e.linear);
    }
    radiance_of(&e, column, row, out_rgb);
}

void btf_ref_evaluate_texel(const btf_ref_material *material, const btf_ref_options *options,
                            uint32_t column, uint32_t row, const float light[3], const float view[3],
                            float out_rgb[3]) {
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    if (!btf_ref_above_horizon(light, view)) {
        return;
    }
    evaluation e = look_up(material, options, light, view);
    radiance_of(&e, column, row, out_rgb);
}

void btf_ref_evaluate(const btf_ref_material *material, const btf_ref_options *options, float u, float v,
                      const float light[3], const float view[3], float out_rgb[3]) {
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    if (!btf_ref_above_horizon(light, view)) {
        return;
    }
    evaluation e = look_up(material, options, light, view);
    radiance_at(&e, options->filter, btf_ref_coordinate(u, material->width),
                btf_ref_coordinate(v, material->height), out_rgb);
}

int btf_ref_can_fold(const btf_ref_material *material, const btf_ref_options *options, int fold) {
    uint32_t effects = material->effects & options->effects;
    if (fold == BTF_REF_FOLD_LIGHT) {
        return material->colour == BTF_REF_NONE && !(effects & BTF_REF_GLOSS);
    }
    if (fold == BTF_REF_FOLD_SUM) {
        return material->colour == BTF_REF_NONE && !(effects & (BTF_REF_GLOSS | BTF_REF_RELIEF));
    }
    if (fold == BTF_REF_FOLD_BOTH) {
        return !(effects & BTF_REF_RELIEF);
    }
    return fold == BTF_REF_FOLD_NEIGHBOURS;
}

void btf_ref_fold_light(const btf_ref_material *material, const btf_ref_options *options,
                        const float light[3], uint32_t view, uint32_t first_row, uint32_t rows,
                        float *out_values) {
    static const float normal[3] = {0.0f, 0.0f, 1.0f}; /* values do not depend on the viewer */
    bool lit = btf_ref_above_horizon(light, normal);
    evaluation e = {0};
    if (lit) {
        e = look_up(material, options, light, normal);
    }
    for (uint32_t row = first_row; row < first_row + rows; ++row) {
        for (uint32_t column = 0; column < material->width; ++column, out_values += 4) {
            out_values[0] = out_values[1] = out_values[2] = out_values[3] = 0.0f;
            if (lit) {
                btf_ref_view_value(&e.shared, &e.lights[0], column, row, view, out_values);
            }
        }
    }
}

void btf_ref_fold_both(const btf_ref_material *material, const btf_ref_options *options,
                       const float light[3], const float view[3], uint32_t first_row, uint32_t rows,
                       float *out_values) {
    bool seen = btf_ref_above_horizon(light, view);
    evaluation e = {0};
    if (seen) {
        e = look_up(material, options, light, view);
    }
    for (uint32_t row = first_row; row < first_row + rows; ++row) {
        for (uint32_t column = 0; column < material->width; ++column, out_values += 4) {
            out_values[0] = out_values[1] = out_values[2] = out_values[3] = 0.0f;
            if (seen) {
                texel_radiance(&e, column, row, out_values);
            }
        }
    }
}

void btf_ref_fold_add(size_t texels, const float *values, const float weight[3], float *sum) {
    for (size_t i = 0; i < texels; ++i, values += 4, sum += 4) {
        for (int c = 0; c < CHANNELS; ++c) {
            float term = values[c] * weight[c];
            sum[c] = sum[c] + term;
        }
    }
}

void btf_ref_fold_neighbour(const btf_ref_material *material, const btf_ref_options *options,
                            const float light[3], const float view[3], uint32_t neighbour,
                            uint32_t first_row, uint32_t rows, float *out_values) {
    evaluation e = {0};
    if (btf_ref_above_horizon(light, view)) {
        e = look_up(material, options, light, view);
    }
    bool seen = e.views.weight[neighbour] > 0;
    for (uint32_t row = first_row; row < first_row + rows; ++row) {
        for (uint32_t column = 0; column < material->width; ++column, out_values += 4) {
            out_values[0] = out_values[1] = out_values[2] = out_values[3] = 0.0f;
            if (seen) {
                btf_ref_view_value(&e.shared, &e.lights[neighbour], column, row, e.views.index[neighbour],
                                   out_values);
            }
        }
    }
}

void btf_ref_evaluate_folded(const btf_ref_material *material, const btf_ref_options *options,
                             const btf_ref_folded *folded, float u, float v, const float light[3],
                             const float view[3], float out_rgb[3]) {
    static const btf_ref_neighbours no_lights = {{0}, {4096, 0, 0}};
    out_rgb[0] = out_rgb[1] = out_rgb[2] = 0.0f;
    if (!btf_ref_above_horizon(light, view)) {
        return;
    }
    int32_t q[2];
    btf_ref_project(view, q);
    btf_ref_neighbours views = btf_ref_lookup(material->view_table, material->view_grid, q);
    evaluation e = make_evaluation(material, options, &no_lights, &views, light, view);
    e.shared.folded = folded;
    for (uint32_t a = 0; a < 3 && folded->fold == BTF_REF_FOLD_NEIGHBOURS; ++a) {
        e.shown[a] = a;
    }
    radiance_at(&e, options->filter, btf_ref_coordinate(u, material->width),
                btf_ref_coordinate(v, material->height), out_rgb);
}

bool btf_ref_probe_evaluate(void) {
    return btf_ref_probe();
}
