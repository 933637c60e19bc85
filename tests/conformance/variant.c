/* Pairwise variants: rows are added until every pair of two factors' levels stands in one, each row the
 * best of some random tries.
 *
 * SPDX-License-Identifier: MIT
 */
#include "variant.h"
#include "random.h"

#include <stdio.h>
#include <string.h>

/* The factors and how many levels each has. */
enum factor {
    SIZE,
    DIRECTIONS,
    LAYOUT,
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
enum { MAX_LEVELS = 6 };
static const uint8_t levels[FACTORS] = {6, 6, 2, 2, 3, 2, 4, 2, 2, 3, 2, 4, 2, 6, 2, 2, 2};

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

typedef struct coverage {
    uint8_t met[FACTORS][FACTORS][MAX_LEVELS][MAX_LEVELS];
} coverage;

/* How many pairs a row would add; marks them when `mark`. */
static int new_pairs(coverage *c, const uint8_t row[FACTORS], int mark) {
    int count = 0;
    for (int f = 0; f < FACTORS; ++f)
        for (int g = f + 1; g < FACTORS; ++g)
            if (!c->met[f][g][row[f]][row[g]]) {
                ++count;
                if (mark)
                    c->met[f][g][row[f]][row[g]] = 1;
            }
    return count;
}

static void write_name(variant *v) {
    const synthetic_spec *s = &v->spec;
    static const char *const colours[] = {"mono", "rgb", "none"};
    snprintf(v->name, sizeof v->name, "%ux%u V%u L%u %s %s %s%s J%u%s%s%s%s k%u%s%s minus %u cut %u %s %s",
             s->width, s->height, s->n_views, s->n_lights, s->layout ? "tight" : "paper",
             s->domain ? "sqrt" : "linear", colours[s->colour], s->half_float ? " half" : "", s->lobes,
             s->effects & BTF_EFFECT_SHADOW ? " shadow" : "", s->effects & BTF_EFFECT_SHIFT ? " shift" : "",
             s->effects & BTF_EFFECT_HIDDEN ? " hidden" : "", s->effects & BTF_EFFECT_GAIN ? " gain" : "",
             s->components, s->all_hidden ? " all-hidden" : "", s->values ? " extreme" : "",
             v->shader.leave_out, v->shader.components, v->shader.interpolation ? "nearest" : "linear",
             v->shader.filter ? "bilinear" : "texel");
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
    s->layout = (btf_layout)row[LAYOUT];
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
    enum { TRIES = 60 };
    static coverage covered;
    memset(&covered, 0, sizeof covered);
    random_state r = {seed};
    int missing = 0;
    for (int f = 0; f < FACTORS; ++f)
        for (int g = f + 1; g < FACTORS; ++g)
            missing += levels[f] * levels[g];
    size_t count = 0;
    while (missing > 0 && count < VARIANT_MAX) {
        uint8_t best[FACTORS] = {0};
        int best_pairs = 0;
        for (int t = 0; t < TRIES || best_pairs == 0; ++t) {
            uint8_t row[FACTORS];
            for (int f = 0; f < FACTORS; ++f)
                row[f] = (uint8_t)random_below(&r, levels[f]);
            int pairs = new_pairs(&covered, row, 0);
            if (pairs > best_pairs) {
                best_pairs = pairs;
                memcpy(best, row, sizeof best);
            }
        }
        missing -= new_pairs(&covered, best, 1);
        make_variant(best, seed + count, &list[count]);
        ++count;
    }
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
