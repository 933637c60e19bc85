/* Decoding at any directions. See evaluator.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "evaluator.h"

#include "decoder/toolkit/reference_view.h"
#include "encoder/math/clones.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Texels whose levels are kept at a time: more than the sources in a texel's list of points. */
enum { SOURCES = 24 };
/* Effects that change nothing where the view is a sample. */
enum { BETWEEN = BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS };

struct enc_evaluator {
    btf_ref_material reference;
    btf_evaluator *library;
    int32_t level;
    bool fast; /* nothing but factors, shift and gain, and what acts between the samples */
    bool roots;
    float horizon_scale;
    enc_factor_unit *units;
    size_t n_units, components;
    int16_t *w; /* [view][light][component] levels */
    const uint32_t *texels;
    const float *scales, *views;
};

struct enc_evaluated_texel {
    const enc_evaluator *evaluator;
    uint32_t column, row;
    size_t source[SOURCES]; /* texels whose levels are known */
    size_t sources, oldest; /* how many there are; which one the next replaces */
    int16_t *u;             /* [SOURCES][component] */
    int32_t *scratch;       /* [component] */
};

static btf_result load_factors(const enc_context *context, const btf_material *material, uint32_t level,
                               const btf_material_info *info, enc_evaluator *e) {
    const uint32_t *directions = btf_material_texture(material, BTF_TEXTURE_FACTOR_DIRECTIONS).data;
    const size_t pairs = (size_t)info->n_views * info->n_lights;
    e->roots = info->blend == BTF_BLEND_ROOTS;
    e->horizon_scale = info->horizon_scale;
    e->texels = btf_material_level_texture(material, level, BTF_TEXTURE_FACTOR_TEXELS).data;
    e->scales = btf_material_texture(material, BTF_TEXTURE_FACTOR_SCALES).data;
    e->views = btf_material_texture(material, BTF_TEXTURE_FACTOR_VIEWS).data;
    e->n_units = info->components;
    e->units = calloc(e->n_units, sizeof *e->units);
    if (e->units) {
        e->components = enc_store_list(info->factor_classes, e->units);
        e->w = malloc(pairs * e->components * sizeof *e->w);
    }
    if (!e->w) {
        return enc_fail(context, BTF_ERROR_MEMORY, "decoding: out of memory for %zu components",
                        e->components);
    }
    for (size_t i = 0; i < e->n_units; i++) {
        for (size_t p = 0; p < pairs; p++) {
            enc_store_w_levels(&e->units[i], directions + (i * pairs + p) * ENC_STORE_WORDS,
                               e->w + p * e->components + e->units[i].first);
        }
    }
    return BTF_OK;
}

btf_result enc_evaluator_create(const enc_context *context, const btf_material *material, uint32_t level,
                                enc_evaluator **out_evaluator) {
    btf_material_info info = {.struct_size = sizeof info};
    enc_evaluator *e = calloc(1, sizeof *e);
    *out_evaluator = NULL;
    if (!e) {
        return enc_fail(context, BTF_ERROR_MEMORY, "decoding: out of memory");
    }
    btf_result result = btf_material_get_info(material, &info);
    reference_view(material, level, &e->reference);
    if (level >= info.relief_end) { /* relief ends before this level, which the fast path can then decode */
        e->reference.effects &= ~(uint32_t)BTF_EFFECT_RELIEF;
    }
    e->level = (int32_t)level;
    if (result == BTF_OK) {
        result = btf_evaluator_create(material, &context->log, &e->library);
    }
    const uint32_t others =
        info.effects & ~(uint32_t)(BTF_EFFECT_RESIDUAL | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BETWEEN);
    e->fast = info.store == BTF_STORE_FACTORS && others == 0 && info.colour == BTF_COLOUR_NONE &&
              info.layout == BTF_LAYOUT_TIGHT;
    if (result == BTF_OK && e->fast) {
        result = load_factors(context, material, level, &info, e);
    }
    if (result != BTF_OK) {
        enc_evaluator_destroy(&e);
    }
    *out_evaluator = e;
    return result;
}

void enc_evaluator_destroy(enc_evaluator **evaluator) {
    enc_evaluator *e = evaluator ? *evaluator : NULL;
    if (!e) {
        return;
    }
    btf_evaluator_destroy(&e->library);
    free(e->units);
    free(e->w);
    free(e);
    *evaluator = NULL;
}

const btf_ref_material *enc_evaluator_reference(const enc_evaluator *e) {
    return &e->reference;
}

void enc_evaluator_many(const enc_evaluator *e, const btf_ref_options *options,
                        const btf_evaluations *evaluations) {
    enum { CHUNK = 256 };
    int32_t levels[CHUNK];
    const btf_evaluate_options how = {
        .struct_size = sizeof how,
        .leave_out = ~options->effects | (options->components == 0 ? (uint32_t)BTF_EFFECT_RESIDUAL : 0),
        .components = options->components,
        .interpolation = options->interpolation == BTF_REF_NEAREST ? BTF_INTERPOLATION_NEAREST
                                                                   : BTF_INTERPOLATION_LINEAR,
        .filter = options->filter == BTF_REF_BILINEAR ? BTF_FILTER_BILINEAR
                  : options->filter == BTF_REF_STEEP  ? BTF_FILTER_STEEP
                                                      : BTF_FILTER_TEXEL};
    for (int i = 0; i < CHUNK; i++) {
        levels[i] = e->level;
    }
    for (size_t first = 0; first < evaluations->count; first += CHUNK) {
        btf_evaluations part = *evaluations;
        const size_t step = part.stride ? part.stride : 3;
        part.count = part.count - first < CHUNK ? part.count - first : CHUNK;
        part.uv = part.uv ? part.uv + first * (part.stride ? part.stride : 2) : NULL;
        part.texels = part.texels ? part.texels + 2 * first : NULL;
        part.lights += part.fixed & BTF_FIXED_LIGHT ? 0 : first * step;
        part.views += part.fixed & BTF_FIXED_VIEW ? 0 : first * step;
        part.levels = levels;
        part.rgb += 3 * first;
        btf_evaluate_many(e->library, &how, &part);
    }
}

static btf_ref_neighbours look_up(const uint16_t *table, uint32_t grid, const float direction[3]) {
    int32_t q[2];
    btf_ref_project(direction, q);
    return btf_ref_lookup(table, grid, q);
}

enc_evaluated_neighbours enc_evaluated_look_up(const enc_evaluator *e, const float light[3],
                                               const float view[3]) {
    const btf_ref_material *m = &e->reference;
    return (enc_evaluated_neighbours){look_up(m->light_table, m->light_grid, light),
                                      look_up(m->view_table, m->view_grid, view)};
}

void enc_evaluated_texel_move(enc_evaluated_texel *t, size_t texel) {
    t->column = (uint32_t)texel % t->evaluator->reference.width;
    t->row = (uint32_t)texel / t->evaluator->reference.width;
}

enc_evaluated_texel *enc_evaluated_texel_create(const enc_evaluator *e, size_t texel) {
    enc_evaluated_texel *t = calloc(1, sizeof *t);
    if (!t) {
        return NULL;
    }
    t->evaluator = e;
    enc_evaluated_texel_move(t, texel);
    if (e->fast) {
        t->u = malloc(SOURCES * e->components * sizeof *t->u);
        t->scratch = malloc(e->components * sizeof *t->scratch);
        if (!t->u || !t->scratch) {
            enc_evaluated_texel_destroy(&t);
        }
    }
    return t;
}

void enc_evaluated_texel_destroy(enc_evaluated_texel **texel) {
    enc_evaluated_texel *t = texel ? *texel : NULL;
    if (!t) {
        return;
    }
    free(t->u);
    free(t->scratch);
    free(t);
    *texel = NULL;
}

/* Finds the levels of u of a texel, [component], among those kept or from its codes. */
static const int16_t *levels_of(enc_evaluated_texel *t, size_t source) {
    const enc_evaluator *e = t->evaluator;
    for (size_t i = 0; i < t->sources; i++) {
        if (t->source[i] == source) {
            return t->u + i * e->components;
        }
    }
    const size_t at = t->sources < SOURCES ? t->sources++ : t->oldest;
    t->oldest = (at + 1) % SOURCES;
    t->source[at] = source;
    int16_t *u = t->u + at * e->components;
    enc_store_texel_levels(e->units, e->n_units, e->texels,
                           (size_t)e->reference.width * e->reference.height, source, u);
    return u;
}

/* How a texel is seen in a view (FORMAT.md section 3). */
typedef struct point {
    size_t source;
    float gain;
} point;

static size_t shifted(const enc_evaluated_texel *t, int32_t columns, int32_t rows) {
    const btf_ref_material *m = &t->evaluator->reference;
    return (size_t)btf_ref_wrap(t->row, rows, m->height) * m->width +
           btf_ref_wrap(t->column, columns, m->width);
}

static point packed_point(const enc_evaluated_texel *t, const uint8_t bytes[2], uint32_t effects) {
    const btf_ref_material *m = &t->evaluator->reference;
    const uint32_t p = bytes[0] + 256u * bytes[1];
    const bool shift = effects & BTF_EFFECT_SHIFT;
    const float above = (float)(p >> 12) * m->gain_step;
    return (point){shifted(t, shift ? (int32_t)(p & 63) - 32 : 0, shift ? (int32_t)(p >> 6 & 63) - 32 : 0),
                   effects & BTF_EFFECT_GAIN ? m->gain_base + above : 1.0f};
}

static point point_of(const enc_evaluated_texel *t, uint32_t view, uint32_t effects) {
    const btf_ref_material *m = &t->evaluator->reference;
    const size_t at = ((size_t)view * m->height + t->row) * m->width + t->column;
    if (m->point_lists) {
        const size_t texels = (size_t)m->width * m->height, own = (size_t)t->row * m->width + t->column;
        const size_t entry = m->point_indices[view / 2 * texels + own] >> (view % 2 * 4) & 15;
        return packed_point(t, m->point_lists + 2 * (entry * texels + own), effects);
    }
    if (m->points_packed) {
        return packed_point(t, m->points + 2 * at, effects);
    }
    const uint32_t code = m->effects & BTF_EFFECT_GAIN ? m->gain[at] : BTF_GAIN_ONE;
    const bool shift = m->effects & effects & BTF_EFFECT_SHIFT && code > 0;
    const bool gain = m->effects & effects & BTF_EFFECT_GAIN && code > 0;
    return (point){shift ? shifted(t, (int8_t)m->shift[2 * at], (int8_t)m->shift[2 * at + 1])
                         : (size_t)t->row * m->width + t->column,
                   gain ? (float)code * m->gain_scale : 1.0f};
}

/* The lights of non-zero weight. */
typedef struct lit {
    int count;
    const int16_t *w[3]; /* [component] */
    int32_t weight[3];
} lit;

/* out[i] = u[i] * sum over the lights of weight * w. Sums of a word or unit of these stay below 2^31
 * (FORMAT.md section 9), and so does each of them. */
ENC_CLONES static void weigh(size_t count, const int16_t *u, const lit *lights, int32_t *out) {
    const int16_t *const *w = lights->w;
    const int32_t *weight = lights->weight;
    if (lights->count == 1) {
        for (size_t i = 0; i < count; i++) {
            out[i] = u[i] * (weight[0] * w[0][i]);
        } } else {
        for (size_t i = 0; i < count; i++) {
            out[i] = u[i] * (weight[0] * w[0][i] + weight[1] * w[1][i] + weight[2] * w[2][i]);
        }
    }
}

ENC_CLONES static int32_t sum(size_t count, const int32_t *values) {
    int32_t total = 0;
    for (size_t i = 0; i < count; i++) {
        total += values[i];
    }
    return total;
}

/* Adds one unit to p, the sums of its tier: p_ch of FORMAT.md section 9. */
static void add_unit(const enc_factor_unit *unit, const float scales[ENC_STORE_WORDS],
                     const int32_t *products, float p[3]) {
    const float step = ldexpf(1.0f, unit->shift - 12);
    const size_t word = (size_t)unit->word;
    if (!unit->mixed) {
        const int32_t e = sum(ENC_STORE_WORDS * word, products);
        p[0] = p[0] + (float)(e >> unit->shift) * (scales[0] * step);
        return;
    }
    for (size_t k = 0; k < ENC_STORE_WORDS; k++) {
        const int32_t e = sum(word, products + k * word);
        float *channel = &p[unit->channel[k]];
        *channel = *channel + (float)(e >> unit->shift) * (scales[k] * step);
    }
}

/* Sums in three channels: over the tiers done, and over the units of the present one. */
typedef struct sums {
    float done[3], tier[3];
} sums;

static void finish_tier(sums *s, const float *views, int tier) {
    for (int c = 0; c < 3; c++) {
        s->done[c] = s->done[c] + s->tier[c] * views[4 * tier + c];
        s->tier[c] = 0.0f;
    }
}

/* r of FORMAT.md section 9: the residual in R, G, B from all units summed so far; `tier` is the present
 * one. */
static void residual_of(const sums *s, const float *views, int tier, float r[3]) {
    sums copy = *s;
    finish_tier(&copy, views, tier);
    const float *y = copy.done;
    r[0] = (y[0] + y[1]) + y[2];
    r[1] = y[0] - (y[2] + y[2]);
    r[2] = (y[0] - y[1]) + y[2];
}

/* Adds to acc the value of a view of this weight. */
static void add_view(const enc_evaluator *e, const float r[3], float m, float gain, uint32_t weight,
                     float acc[3]) {
    for (int c = 0; c < 3; c++) {
        float y = r[c] * m;
        y = y * gain; /* without the effect, by 1, which changes nothing */
        if (e->roots) {
            y = fminf(fmaxf(y, -0x1p32f), 0x1p32f);
        } else {
            y = y >= 0x1p-30f ? fminf(y, 0x1p32f) : 0.0f;
            y = e->reference.domain_sqrt ? y * y : y;
        }
        acc[c] = acc[c] + y * ((float)weight * 0x1p-12f);
    }
}

static lit lights_of(const enc_evaluator *e, uint32_t view, const btf_ref_neighbours *lights) {
    lit out = {0, {e->w, e->w, e->w}, {0, 0, 0}};
    for (int b = 0; b < 3; b++) {
        if (lights->weight[b] == 0) {
            continue;
        }
        out.w[out.count] = e->w + ((size_t)view * e->reference.n_lights + lights->index[b]) * e->components;
        out.weight[out.count++] = (int32_t)lights->weight[b];
    }
    return out;
}

/* Adds one view to each acc[i], decoded with the first components[i] units alone. */
static void evaluate_view(enc_evaluated_texel *t, uint32_t effects, uint32_t view, uint32_t weight,
                          const btf_ref_neighbours *lights, float m, const uint32_t *components,
                          size_t count, float acc[][3]) {
    const enc_evaluator *e = t->evaluator;
    const float *views = e->views + (size_t)view * ENC_STORE_TIERS * 4;
    const point seen = point_of(t, view, effects);
    const int16_t *u = levels_of(t, seen.source);
    const lit of_view = lights_of(e, view, lights);
    const size_t most = components[0] < e->n_units ? components[0] : e->n_units;
    const enc_factor_unit *last = &e->units[most - 1];
    weigh(last->first + ENC_STORE_WORDS * (size_t)last->word, u, &of_view, t->scratch);
    sums s = {{0}, {0}};
    int tier = 0;
    size_t next = count; /* counts fall, so that the next to be reached is at next - 1 */
    for (size_t i = 0; i < most; i++) {
        for (; tier < e->units[i].tier; tier++) {
            finish_tier(&s, views, tier);
        }
        add_unit(&e->units[i], e->scales + i * ENC_STORE_WORDS, t->scratch + e->units[i].first, s.tier);
        for (; next > 0 && (components[next - 1] == i + 1 || i + 1 == most); next--) {
            float r[3];
            residual_of(&s, views, tier, r);
            add_view(e, r, m, seen.gain, weight, acc[next - 1]);
        }
    }
}

static float horizon(const enc_evaluator *e, float z) {
    const float q = z * e->horizon_scale;
    return q >= 1 ? 1.0f : e->reference.domain_sqrt ? btf_ref_pow(q, 0.5f) : q;
}

static void evaluate_factors(enc_evaluated_texel *t, const btf_ref_options *options,
                             const enc_evaluated_at *at, const uint32_t *components, size_t count,
                             float out[][3]) {
    const enc_evaluator *e = t->evaluator;
    const bool nearest = options->interpolation == BTF_REF_NEAREST;
    const btf_ref_neighbours views = nearest ? btf_ref_nearest(*at->views) : *at->views;
    const float m = horizon(e, at->light[2]);
    memset(out, 0, count * sizeof *out);
    for (int a = 0; a < 3; a++) {
        const btf_ref_neighbours *of_view = at->apart ? &at->lights[a] : at->lights;
        const btf_ref_neighbours lights = nearest ? btf_ref_nearest(*of_view) : *of_view;
        if (views.weight[a] > 0) {
            evaluate_view(t, options->effects, views.index[a], views.weight[a], &lights, m, components,
                          count, out);
        }
    }
    for (size_t i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++) {
            float x = out[i][c];
            if (e->roots) {
                x = x >= 0x1p-30f ? fminf(x, 0x1p32f) : 0.0f;
                x = x * x;
            }
            out[i][c] = x * e->reference.radiance_scale;
        }
    }
}

/* Whether the view is a sampled direction to the bit: a neighbour is then shifted by nothing, weighs 4096
 * and has the pixel's own lights. */
static bool view_is_sample(const enc_evaluator *e, const enc_evaluated_at *at) {
    const float *vectors = e->reference.view_vectors;
    for (int a = 0; a < 3; a++) {
        if (at->views->weight[a] == 4096) {
            return memcmp(vectors + 4 * (size_t)at->views->index[a], at->view, 3 * sizeof *vectors) == 0;
        }
    }
    return false;
}

/* Whether relief or gloss act. Without a look-up gloss does nothing that `at` does not say. */
static bool acts_between(const enc_evaluator *e, const btf_ref_options *options,
                         const enc_evaluated_at *at) {
    const uint32_t acting = at->looked_up ? BETWEEN : BTF_EFFECT_RELIEF;
    const bool unordered =
        at->apart && options->interpolation == BTF_REF_NEAREST; /* the reference decodes these */
    return unordered || (options->effects & e->reference.effects & acting && !view_is_sample(e, at));
}

void enc_evaluate(enc_evaluated_texel *t, const btf_ref_options *options, const enc_evaluated_at *at,
                  const uint32_t *components, size_t count, float out[][3]) {
    const enc_evaluator *e = t->evaluator;
    const bool above = at->light[2] >= 0x1p-24f && at->view[2] >= 0x1p-24f;
    if (e->fast && above && options->effects & BTF_EFFECT_RESIDUAL && components[count - 1] > 0 &&
        !acts_between(e, options, at)) {
        evaluate_factors(t, options, at, components, count, out);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        btf_ref_options each = *options;
        each.components = components[i];
        if (at->looked_up) {
            const uint32_t texel[2] = {t->column, t->row};
            enc_evaluator_many(e, &each,
                               &(btf_evaluations){.struct_size = sizeof(btf_evaluations),
                                                  .count = 1,
                                                  .texels = texel,
                                                  .lights = at->light,
                                                  .views = at->view,
                                                  .rgb = out[i]});
            continue;
        }
        (at->apart ? btf_ref_evaluate_apart : btf_ref_evaluate_neighbours)(
            &e->reference, &each, t->column, t->row, at->lights, at->views, at->light, at->view, out[i]);
    }
}
