/* Variants in which all pairs of settings occur (pairwise.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "variant.h"
#include "decoder/toolkit/filter.h"
#include "pairwise.h"

#include <stdbool.h>
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

/* The factors for materials of version 2: their codes and channels in all pairs with fewer sizes and effects. */
enum factor_2 {
    SIZE_2,
    DIRECTIONS_2,
    LAYOUT_2,
    BLEND_2, /* linear, roots blended as radiance, as roots */
    COLOUR_2,
    SHADOW_2,
    SHIFT_2,
    HIDDEN_2,
    GAIN_2,
    CODES_2,
    HORIZON_2,
    VALUES_2,
    TRUNCATE_2,
    LEAVE_OUT_2,
    INTERPOLATION_2,
    FILTER_2,
    FACTORS_2
};
static const uint8_t levels_2[FACTORS_2] = {2, 2, 3, 3, 3, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2};

/* The factors for packed points, in pairs with every other part of a material. */
enum factor_3 {
    LAYOUT_3, /* one level, all levels of detail */
    DOMAIN_3, /* linear, roots blended as radiance, as roots */
    COLOUR_3,
    SHADOW_3,
    RESIDUAL_3, /* none, components, factors */
    VALUES_3,
    LEAVE_OUT_3, /* nothing, shift, gain, both */
    LISTS_3,     /* none, of as many entries as there may be or fewer */
    INTERPOLATION_3,
    FILTER_3,
    FACTORS_3
};
static const uint8_t levels_3[FACTORS_3] = {2, 3, 3, 2, 3, 2, 4, 2, 2, 2};

/* The factors for relief, gloss and the steep filter, in pairs with every other part of a material. */
enum factor_4 {
    SIZE_4,
    DIRECTIONS_4,
    LAYOUT_4, /* one level, all levels of detail, all and relief on the first ones alone */
    DOMAIN_4, /* linear, roots blended as radiance, as roots */
    MODEL_4,
    RELIEF_4, /* none, or a synthetic_relief */
    VIEWS_4,  /* relief acts on all of them, on some */
    GLOSS_4,  /* none, a quarter, a half */
    VALUES_4,
    LEAVE_OUT_4, /* nothing, what the model leaves out, relief, gloss */
    INTERPOLATION_4,
    FILTER_4,
    FACTORS_4
};
static const uint8_t levels_4[FACTORS_4] = {4, 4, 3, 3, 5, 1 + SYNTHETIC_RELIEFS, 2, 3, 2, 4, 2, 3};

/* Units, words of C1 and of C2 of each class: every class alone and with others, and mixed units of 0 to 5
 * words of colour in each class. */
static const uint32_t mixtures[][BTF_FACTOR_CLASSES][3] = {
    {{2, 1, 1}, {2, 1, 2}, {3, 2, 2}, {2, 0, 3}, {2, 0, 0}},
    {{1, 0, 0}, {2, 2, 2}, {2, 1, 0}, {2, 3, 2}, {2, 0, 1}},
    {{2, 3, 2}, {0, 0, 0}, {2, 0, 3}, {0, 0, 0}, {3, 2, 3}},
    {{0, 0, 0}, {3, 2, 3}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}},
    {{0, 0, 0}, {0, 0, 0}, {3, 3, 2}, {0, 0, 0}, {0, 0, 0}},
    {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {3, 1, 3}, {0, 0, 0}},
    {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {3, 1, 2}},
    {{3, 2, 2}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}},
    {{2, 1, 0}, {1, 0, 0}, {5, 4, 3}, {1, 0, 0}, {4, 0, 0}},
    {{0, 0, 0}, {2, 0, 1}, {0, 0, 0}, {2, 1, 0}, {2, 2, 2}},
    {{1, 2, 2}, {1, 2, 2}, {1, 1, 3}, {1, 3, 1}, {1, 2, 2}},    /* no Y */
    {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}},    /* components, of roots that are blended */
    {{0, 0, 0}, {60, 9, 9}, {60, 8, 9}, {0, 0, 0}, {76, 5, 6}}, /* as many layers of u as there may be */
};

enum { MIXTURES = sizeof mixtures / sizeof *mixtures };

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
    static const char *const reliefs[] = {" relief-flat", " relief", " relief-deep", " relief-high",
                                          " relief-even"};
    char classes[100] = "";
    for (int c = 0, at = 0; c < BTF_FACTOR_CLASSES; ++c) {
        if (s->classes[c][0]) {
            at += snprintf(classes + at, sizeof classes - (size_t)at, " %d:%u/%u/%u", c, s->classes[c][0],
                           s->classes[c][1], s->classes[c][2]);
        }
    }
    snprintf(v->name, sizeof v->name,
             "%ux%u V%u L%u %s %s %s%s J%u%s%s%s%s%s%s%s k%u%s%s%s%s%s%s minus %u cut %u %s %s", s->width,
             s->height, s->n_views, s->n_lights, s->layout ? "tight" : "paper",
             s->domain ? "sqrt" : "linear", colours[s->colour], s->half_float ? " half" : "", s->lobes,
             s->effects & BTF_EFFECT_SHADOW ? " shadow" : "", s->effects & BTF_EFFECT_SHIFT ? " shift" : "",
             s->effects & BTF_EFFECT_HIDDEN ? " hidden" : "", s->effects & BTF_EFFECT_GAIN ? " gain" : "",
             s->entries  ? " lists"
             : s->packed ? " packed"
                         : "",
             s->effects & BTF_EFFECT_RELIEF ? reliefs[s->relief] : "",
             !(s->effects & BTF_EFFECT_GLOSS) ? ""
             : s->gloss_share > 1             ? " gloss 1/2"
                                              : " gloss 1/4",
             s->components, classes, s->codes ? " bounds" : "", s->blend ? " roots" : "",
             s->all_hidden ? " all-hidden" : "", s->values ? " extreme" : "",
             s->levels < 2   ? ""
             : s->relief_end ? " levels, relief ends"
                             : " levels",
             v->shader.leave_out, v->shader.components, v->shader.interpolation ? "nearest" : "linear",
             filter_name(v->shader.filter));
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
    if (s->colour == BTF_COLOUR_NONE && s->components == 0) {
        s->components = 4;
    }
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

static void make_variant_2(const uint8_t row[FACTORS_2], uint64_t seed, size_t mixture, variant *v) {
    static const uint32_t few_sizes[][2] = {{3, 5}, {37, 21}};
    memset(v, 0, sizeof *v);
    synthetic_spec *s = &v->spec;
    s->seed = seed;
    s->width = few_sizes[row[SIZE_2]][0];
    s->height = few_sizes[row[SIZE_2]][1];
    s->directions = row[DIRECTIONS_2] ? SYNTHETIC_RANDOM : SYNTHETIC_RINGS;
    s->n_views = row[DIRECTIONS_2] ? 7 : 37;
    s->n_lights = row[DIRECTIONS_2] ? 11 : 19;
    s->layout = row[LAYOUT_2] ? BTF_LAYOUT_TIGHT : BTF_LAYOUT_PAPER;
    s->levels = row[LAYOUT_2] == 2 ? BTF_MAX_LEVELS : 1;
    s->domain = row[BLEND_2] ? BTF_DOMAIN_SQRT : BTF_DOMAIN_LINEAR;
    s->blend = row[BLEND_2] == 2 ? BTF_BLEND_ROOTS : BTF_BLEND_RADIANCE;
    s->colour = (btf_colour)row[COLOUR_2];
    s->half_float = (int)(seed & 1);
    s->lobes = s->colour == BTF_COLOUR_NONE ? 0 : 1;
    s->effects = (row[SHADOW_2] ? BTF_EFFECT_SHADOW : 0u) | (row[SHIFT_2] ? BTF_EFFECT_SHIFT : 0u) |
                 (row[HIDDEN_2] ? BTF_EFFECT_HIDDEN : 0u) | (row[GAIN_2] ? BTF_EFFECT_GAIN : 0u) |
                 BTF_EFFECT_RESIDUAL;
    s->centres = 300;
    s->values = (synthetic_values)row[VALUES_2];
    s->codes = (synthetic_codes)row[CODES_2];
    s->horizon_scale = row[HORIZON_2] ? 3.75f : 0;
    memcpy(s->classes, mixtures[mixture], sizeof s->classes);
    for (int c = 0; c < BTF_FACTOR_CLASSES; ++c) {
        s->components += s->classes[c][0];
    }
    if (s->components == 0) {
        s->components = 6;
        s->domain = BTF_DOMAIN_SQRT;
        s->blend = BTF_BLEND_ROOTS;
        s->horizon_scale = 0;
    }
    v->shader.struct_size = sizeof v->shader;
    v->shader.leave_out =
        (row[LEAVE_OUT_2] ? BTF_EFFECT_SHIFT : 0u) | (mixture == 9 ? BTF_EFFECT_RESIDUAL : 0u);
    v->shader.components = row[TRUNCATE_2] ? 1 + 2 * s->components / 3 : 0;
    v->shader.interpolation = (btf_interpolation)row[INTERPOLATION_2];
    v->shader.filter = (btf_filter)row[FILTER_2];
    write_name(v);
}

static void make_variant_3(const uint8_t row[FACTORS_3], uint64_t seed, variant *v) {
    static const uint32_t classes[BTF_FACTOR_CLASSES][3] = {{1, 1, 1}, {0}, {2, 1, 0}};
    memset(v, 0, sizeof *v);
    synthetic_spec *s = &v->spec;
    s->seed = seed;
    s->width = 37;
    s->height = 21;
    s->directions = seed & 1 ? SYNTHETIC_RANDOM : SYNTHETIC_RINGS;
    s->n_views = seed & 1 ? 7 : 37;
    s->n_lights = 11;
    s->layout = BTF_LAYOUT_TIGHT;
    s->levels = row[LAYOUT_3] ? BTF_MAX_LEVELS : 1;
    s->domain = row[DOMAIN_3] ? BTF_DOMAIN_SQRT : BTF_DOMAIN_LINEAR;
    s->blend = row[DOMAIN_3] == 2 ? BTF_BLEND_ROOTS : BTF_BLEND_RADIANCE;
    s->colour = (btf_colour)row[COLOUR_3];
    s->lobes = s->colour == BTF_COLOUR_NONE ? 0 : 2;
    s->packed = 1;
    s->entries = row[LISTS_3] == 0 ? 0 : seed % 3 ? 1 + (uint32_t)(7 * seed % 16) : BTF_MAX_POINT_ENTRIES;
    const int residual = s->colour == BTF_COLOUR_NONE && !row[RESIDUAL_3] ? 1 : row[RESIDUAL_3];
    s->components = residual == 0 ? 0 : residual == 1 ? 6 : 3;
    if (residual == 2) {
        memcpy(s->classes, classes, sizeof s->classes);
    }
    s->horizon_scale = residual == 2 ? 3.75f : 0;
    s->effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | (row[SHADOW_3] ? BTF_EFFECT_SHADOW : 0u) |
                 (residual ? BTF_EFFECT_RESIDUAL : 0u);
    s->values = (synthetic_values)row[VALUES_3];
    v->shader.struct_size = sizeof v->shader;
    v->shader.leave_out =
        (row[LEAVE_OUT_3] & 1 ? BTF_EFFECT_SHIFT : 0u) | (row[LEAVE_OUT_3] & 2 ? BTF_EFFECT_GAIN : 0u);
    v->shader.interpolation = (btf_interpolation)row[INTERPOLATION_3];
    v->shader.filter = (btf_filter)row[FILTER_3];
    write_name(v);
}

/* An SBRDF with shadow; factors; components with shift and gain of all stores; hidden points among factors. */
static void make_model_4(int model, uint64_t seed, synthetic_spec *s) {
    static const uint32_t classes[][BTF_FACTOR_CLASSES][3] = {{{1, 1, 1}, {0}, {2, 1, 0}},
                                                              {{0}, {0}, {2, 0, 1}}};
    static const uint32_t effects[] = {
        BTF_EFFECT_SHADOW, BTF_EFFECT_RESIDUAL, BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL,
        BTF_EFFECT_HIDDEN | BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_RESIDUAL,
        BTF_EFFECT_RESIDUAL};
    s->effects = effects[model];
    s->colour = model == 0 ? BTF_COLOUR_RGB : model == 3 ? BTF_COLOUR_MONO : BTF_COLOUR_NONE;
    s->lobes = s->colour == BTF_COLOUR_NONE ? 0 : 1;
    s->centres = 40;
    s->components = model == 0 ? 0 : model == 1 ? 3 : model == 2 ? 5 : 2;
    if (model == 1 || model > 2) {
        memcpy(s->classes, classes[model != 1], sizeof s->classes);
        s->horizon_scale = 3.75f;
    }
    s->packed = model == 2 && seed % 3 > 0;
    s->entries = s->packed && seed % 3 > 1 ? 5 : 0;
}

static void make_variant_4(const uint8_t row[FACTORS_4], uint64_t seed, variant *v) {
    static const uint32_t few_sizes[][2] = {{1, 1}, {3, 5}, {16, 32}, {37, 21}};
    static const synthetic_directions kinds[] = {SYNTHETIC_RINGS, SYNTHETIC_RANDOM, SYNTHETIC_COLLINEAR,
                                                 SYNTHETIC_RINGS};
    static const uint32_t counts[][2] = {{37, 19}, {9, 11}, {3, 5}, {1, 37}};
    memset(v, 0, sizeof *v);
    synthetic_spec *s = &v->spec;
    s->seed = seed;
    s->width = few_sizes[row[SIZE_4]][0];
    s->height = few_sizes[row[SIZE_4]][1];
    s->directions = kinds[row[DIRECTIONS_4]];
    s->n_views = counts[row[DIRECTIONS_4]][0];
    s->n_lights = counts[row[DIRECTIONS_4]][1];
    s->layout = BTF_LAYOUT_TIGHT;
    s->levels = row[LAYOUT_4] ? BTF_MAX_LEVELS : 1;
    s->domain = row[DOMAIN_4] ? BTF_DOMAIN_SQRT : BTF_DOMAIN_LINEAR;
    s->blend = row[DOMAIN_4] == 2 ? BTF_BLEND_ROOTS : BTF_BLEND_RADIANCE;
    make_model_4(row[MODEL_4], seed, s);
    s->effects |= (row[RELIEF_4] ? BTF_EFFECT_RELIEF : 0u) | (row[GLOSS_4] ? BTF_EFFECT_GLOSS : 0u);
    s->relief = row[RELIEF_4] ? (synthetic_relief)(row[RELIEF_4] - 1) : SYNTHETIC_FLAT;
    s->relief_mixed = row[VIEWS_4];
    s->relief_end = row[LAYOUT_4] == 2 ? 1 + (uint32_t)(seed % 2) : 0;
    s->gloss_share = row[GLOSS_4];
    s->values = (synthetic_values)row[VALUES_4];
    static const uint32_t left_out_4[] = {0, BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT, BTF_EFFECT_RELIEF,
                                          BTF_EFFECT_GLOSS};
    v->shader.struct_size = sizeof v->shader;
    v->shader.leave_out = left_out_4[row[LEAVE_OUT_4]];
    v->shader.interpolation = (btf_interpolation)row[INTERPOLATION_4];
    v->shader.filter = (btf_filter)row[FILTER_4];
    write_name(v);
}

/* Chooses a mixture that was not used yet: of few classes for bilinear filtering, else of many, because compilers take
 * long for both together. */
static size_t choose_mixture(bool used[MIXTURES], bool bilinear) {
    size_t best = 0;
    int least = BTF_FACTOR_CLASSES + 1;
    for (size_t i = 0; i < MIXTURES; ++i) {
        int classes = 0;
        for (int c = 0; c < BTF_FACTOR_CLASSES; ++c) {
            classes += mixtures[i][c][0] > 0;
        }
        const int cost = bilinear ? classes : BTF_FACTOR_CLASSES - classes;
        if (!used[i] && cost < least) {
            least = cost;
            best = i;
        }
    }
    used[best] = true;
    return best;
}

size_t variant_pairwise(uint64_t seed, variant list[VARIANT_MAX]) {
    static uint8_t rows[VARIANT_MAX][PAIRWISE_FACTORS];
    size_t count = pairwise_rows(seed, FACTORS, levels, VARIANT_MAX, rows);
    for (size_t i = 0; i < count; ++i) {
        make_variant(rows[i], seed + i, &list[i]);
    }

    bool used[MIXTURES] = {false};
    size_t more = pairwise_rows(seed, FACTORS_2, levels_2, VARIANT_MAX - count, rows);
    for (size_t i = 0; i < more; ++i, ++count) {
        make_variant_2(rows[i], seed + count, choose_mixture(used, rows[i][FILTER_2]), &list[count]);
    }
    more = pairwise_rows(seed, FACTORS_3, levels_3, VARIANT_MAX - count, rows);
    for (size_t i = 0; i < more; ++i, ++count) {
        make_variant_3(rows[i], seed + count, &list[count]);
    }
    more = pairwise_rows(seed, FACTORS_4, levels_4, VARIANT_MAX - count, rows);
    for (size_t i = 0; i < more; ++i, ++count) {
        make_variant_4(rows[i], seed + count, &list[count]);
    }
    return count;
}

btf_ref_options variant_reference_options(const btf_shader_options *shader) {
    btf_ref_options o = {0};
    o.effects = BTF_EFFECT_ALL & ~shader->leave_out;
    o.components = shader->components ? shader->components : UINT32_MAX;
    o.interpolation = shader->interpolation == BTF_INTERPOLATION_NEAREST ? BTF_REF_NEAREST : BTF_REF_LINEAR;
    o.filter = filter_of_reference(shader->filter);
    return o;
}
