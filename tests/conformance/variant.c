/* Pairwise variants: rows are added until every pair of two factors' levels stands in one, each row the
 * best of some random tries.
 *
 * SPDX-License-Identifier: MIT
 */
#include "variant.h"
#include "pairwise.h"

#include <stdio.h>
#include <string.h>

/* The factors and how many levels each has. */
enum factor {
    SIZE,
    DIRECTIONS,
    LAYOUT, /* paper, tight, tight with all levels of detail */
    DOMAIN,
    COLOUR,
    HALF,
    LOBES,
    SHADOW,
    SHIFT,
    HIDDEN,
    GAIN,
    COMPONENTS,
    VALUES,
    LEAVE_OUT,
    TRUNCATE,
    INTERPOLATION,
    FILTER,
    FACTORS
};
static const uint8_t levels[FACTORS] = {6, 6, 3, 2, 3, 2, 4, 2, 2, 3, 2, 4, 2, 6, 2, 2, 2};

static const uint32_t sizes[][2] = {{1, 1}, {3, 5}, {16, 16}, {37, 41}, {130, 7}, {64, 32}};
static const struct {
    uint32_t n_views, n_lights;
    synthetic_directions kind;
} directions[] = {
    {1, 1, SYNTHETIC_RINGS},   {81, 81, SYNTHETIC_RINGS},  {256, 256, SYNTHETIC_RINGS},
    {7, 19, SYNTHETIC_RANDOM}, {30, 11, SYNTHETIC_RANDOM}, {2, 5, SYNTHETIC_COLLINEAR},
};
static const uint32_t components[] = {0, 1, 6, 19};
static const uint32_t left_out[] = {
    0, BTF_EFFECT_SHADOW, BTF_EFFECT_SHIFT, BTF_EFFECT_HIDDEN, BTF_EFFECT_GAIN, BTF_EFFECT_RESIDUAL};

static void write_name(variant *v) {
    const synthetic_spec *s = &v->spec;
    static const char *const colours[] = {"mono", "rgb", "none"};
    snprintf(v->name, sizeof v->name,
             "%ux%u V%u L%u %s %s %s%s J%u%s%s%s%s k%u%s%s%s minus %u cut %u %s %s", s->width, s->height,
             s->n_views, s->n_lights, s->layout ? "tight" : "paper", s->domain ? "sqrt" : "linear",
             colours[s->colour], s->half_float ? " half" : "", s->lobes,
             s->effects & BTF_EFFECT_SHADOW ? " shadow" : "", s->effects & BTF_EFFECT_SHIFT ? " shift" : "",
             s->effects & BTF_EFFECT_HIDDEN ? " hidden" : "", s->effects & BTF_EFFECT_GAIN ? " gain" : "",
             s->components, s->all_hidden ? " all-hidden" : "", s->values ? " extreme" : "",
             s->levels > 1 ? " levels" : "", v->shader.leave_out, v->shader.components,
             v->shader.interpolation ? "nearest" : "linear", v->shader.filter ? "bilinear" : "texel");
}

static void make_variant(const uint8_t row[FACTORS], uint64_t seed, variant *v) {
    memset(v, 0, sizeof *v);
    synthetic_spec *s = &v->spec;
    s->seed = seed;
    s->width = sizes[row[SIZE]][0];
    s->height = sizes[row[SIZE]][1];
    s->n_views = directions[row[DIRECTIONS]].n_views;
    s->n_lights = directions[row[DIRECTIONS]].n_lights;
    s->directions = directions[row[DIRECTIONS]].kind;
    s->layout = row[LAYOUT] ? BTF_LAYOUT_TIGHT : BTF_LAYOUT_PAPER;
    s->levels = row[LAYOUT] == 2 ? BTF_MAX_LEVELS : 1; /* as many as the size has */
    s->domain = (btf_domain)row[DOMAIN];
    s->colour = (btf_colour)row[COLOUR];
    s->half_float = row[HALF];
    s->lobes = s->colour == BTF_COLOUR_NONE ? 0 : 1u + row[LOBES];
    s->components = components[row[COMPONENTS]];
    if (s->colour == BTF_COLOUR_NONE && s->components == 0)
        s->components = 4;
    s->effects = (row[SHADOW] ? BTF_EFFECT_SHADOW : 0u) | (row[SHIFT] ? BTF_EFFECT_SHIFT : 0u) |
                 (row[HIDDEN] ? BTF_EFFECT_HIDDEN : 0u) | (row[GAIN] ? BTF_EFFECT_GAIN : 0u) |
                 (s->components ? BTF_EFFECT_RESIDUAL : 0u);
    s->centres = row[HIDDEN] == 1 ? 5000 : 300;
    s->all_hidden = row[HIDDEN] == 2;
    s->values = (synthetic_values)row[VALUES];
    v->shader.struct_size = sizeof v->shader;
    v->shader.leave_out = left_out[row[LEAVE_OUT]];
    v->shader.components = row[TRUNCATE] ? 5 : 0;
    v->shader.interpolation = (btf_interpolation)row[INTERPOLATION];
    v->shader.filter = (btf_filter)row[FILTER];
    write_name(v);
}

size_t variant_pairwise(uint64_t seed, variant list[VARIANT_MAX]) {
    static uint8_t rows[VARIANT_MAX][PAIRWISE_FACTORS];
    size_t count = pairwise_rows(seed, FACTORS, levels, VARIANT_MAX, rows);
    for (size_t i = 0; i < count; ++i)
        make_variant(rows[i], seed + i, &list[i]);
    return count;
}

btf_ref_options variant_reference_options(const btf_shader_options *shader) {
    btf_ref_options o = {0};
    o.effects = BTF_EFFECT_ALL & ~shader->leave_out;
    o.components = shader->components ? shader->components : UINT32_MAX;
    o.interpolation = shader->interpolation == BTF_INTERPOLATION_NEAREST ? BTF_REF_NEAREST : BTF_REF_LINEAR;
    o.filter = shader->filter == BTF_FILTER_BILINEAR ? BTF_REF_BILINEAR : BTF_REF_TEXEL;
    return o;
}
