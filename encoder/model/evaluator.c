/* Decoding at any directions. See evaluator.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "evaluator.h"

#include "decoder/toolkit/reference_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define WIDE
#endif

struct enc_evaluator {
    btf_ref_material reference;
    bool fast; /* nothing but factors */
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
    int16_t *u;       /* [component] */
    int32_t *scratch; /* [component] */
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
    if (!e->w)
        return enc_fail(context, BTF_ERROR_MEMORY, "decoding: out of memory for %zu components",
                        e->components);
    for (size_t i = 0; i < e->n_units; i++)
        for (size_t p = 0; p < pairs; p++)
            enc_store_w_levels(&e->units[i], directions + (i * pairs + p) * ENC_STORE_WORDS,
                               e->w + p * e->components + e->units[i].first);
    return BTF_OK;
}

btf_result enc_evaluator_create(const enc_context *context, const btf_material *material, uint32_t level,
                                enc_evaluator **out_evaluator) {
    btf_material_info info = {.struct_size = sizeof info};
    enc_evaluator *e = calloc(1, sizeof *e);
    *out_evaluator = NULL;
    if (!e)
        return enc_fail(context, BTF_ERROR_MEMORY, "decoding: out of memory");
    btf_result result = btf_material_get_info(material, &info);
    reference_view(material, level, &e->reference);
    e->fast = info.store == BTF_STORE_FACTORS && info.effects == BTF_EFFECT_RESIDUAL &&
              info.colour == BTF_COLOUR_NONE;
    if (result == BTF_OK && e->fast)
        result = load_factors(context, material, level, &info, e);
    if (result != BTF_OK)
        enc_evaluator_destroy(&e);
    *out_evaluator = e;
    return result;
}

void enc_evaluator_destroy(enc_evaluator **evaluator) {
    enc_evaluator *e = evaluator ? *evaluator : NULL;
    if (!e)
        return;
    free(e->units);
    free(e->w);
    free(e);
    *evaluator = NULL;
}

const btf_ref_material *enc_evaluator_reference(const enc_evaluator *e) {
    return &e->reference;
}

enc_evaluated_texel *enc_evaluated_texel_create(const enc_evaluator *e, size_t texel) {
    enc_evaluated_texel *t = calloc(1, sizeof *t);
    if (!t)
        return NULL;
    *t = (enc_evaluated_texel){.evaluator = e,
                               .column = (uint32_t)texel % e->reference.width,
                               .row = (uint32_t)texel / e->reference.width};
    if (e->fast) {
        t->u = malloc(e->components * sizeof *t->u);
        t->scratch = malloc(e->components * sizeof *t->scratch);
        if (t->u && t->scratch)
            enc_store_texel_levels(e->units, e->n_units, e->texels,
                                   (size_t)e->reference.width * e->reference.height, texel, t->u);
        else
            enc_evaluated_texel_destroy(&t);
    }
    return t;
}

void enc_evaluated_texel_destroy(enc_evaluated_texel **texel) {
    enc_evaluated_texel *t = texel ? *texel : NULL;
    if (!t)
        return;
    free(t->u);
    free(t->scratch);
    free(t);
    *texel = NULL;
}

/* out[i] = u[i] * sum over the three lights of weight * w. Sums of a word or unit of these stay below 2^31
 * (FORMAT.md section 9), and so does each of them. */
WIDE static void weigh(size_t count, const int16_t *u, const int16_t *const w[3], const int32_t weight[3],
                       int32_t *out) {
    for (size_t i = 0; i < count; i++)
        out[i] = u[i] * (weight[0] * w[0][i] + weight[1] * w[1][i] + weight[2] * w[2][i]);
}

WIDE static int32_t sum(size_t count, const int32_t *values) {
    int32_t total = 0;
    for (size_t i = 0; i < count; i++)
        total += values[i];
    return total;
}

/* p_ch of the tier, with one unit more. */
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

/* Sums in three channels, and those of the tier at hand. */
typedef struct sums {
    float done[3], tier[3];
} sums;

static void finish_tier(sums *s, const float *views, int tier) {
    for (int c = 0; c < 3; c++) {
        s->done[c] = s->done[c] + s->tier[c] * views[4 * tier + c];
        s->tier[c] = 0.0f;
    }
}

/* r of the first `last` tiers, the last of them at hand. */
static void residual_of(const sums *s, const float *views, int tier, float r[3]) {
    sums copy = *s;
    finish_tier(&copy, views, tier);
    const float *y = copy.done;
    r[0] = (y[0] + y[1]) + y[2];
    r[1] = y[0] - (y[2] + y[2]);
    r[2] = (y[0] - y[1]) + y[2];
}

/* Adds to acc what a view of this weight gives. */
static void add_view(const enc_evaluator *e, const float r[3], float m, uint32_t weight, float acc[3]) {
    for (int c = 0; c < 3; c++) {
        float y = r[c] * m;
        if (e->roots) {
            y = fminf(fmaxf(y, -0x1p32f), 0x1p32f);
        } else {
            y = y >= 0x1p-30f ? fminf(y, 0x1p32f) : 0.0f;
            y = e->reference.domain_sqrt ? y * y : y;
        }
        acc[c] = acc[c] + y * ((float)weight * 0x1p-12f);
    }
}

/* One view: acc[i] of the first components[i] units. */
static void evaluate_view(const enc_evaluated_texel *t, uint32_t view, uint32_t weight,
                          const btf_ref_neighbours *lights, float m, const uint32_t *components,
                          size_t count, float acc[][3]) {
    const enc_evaluator *e = t->evaluator;
    const float *views = e->views + (size_t)view * ENC_STORE_TIERS * 4;
    const int16_t *w[3];
    int32_t weights[3];
    for (int b = 0; b < 3; b++) {
        w[b] = e->w + ((size_t)view * e->reference.n_lights + lights->index[b]) * e->components;
        weights[b] = (int32_t)lights->weight[b];
    }
    const size_t most = components[0] < e->n_units ? components[0] : e->n_units;
    const enc_factor_unit *last = &e->units[most - 1];
    weigh(last->first + ENC_STORE_WORDS * (size_t)last->word, t->u, w, weights, t->scratch);
    sums s = {{0}, {0}};
    int tier = 0;
    size_t next = count; /* the smallest count that is still to come is at next - 1 */
    for (size_t i = 0; i < most; i++) {
        for (; tier < e->units[i].tier; tier++)
            finish_tier(&s, views, tier);
        add_unit(&e->units[i], e->scales + i * ENC_STORE_WORDS, t->scratch + e->units[i].first, s.tier);
        for (; next > 0 && (components[next - 1] == i + 1 || i + 1 == most); next--) {
            float r[3];
            residual_of(&s, views, tier, r);
            add_view(e, r, m, weight, acc[next - 1]);
        }
    }
}

static float horizon(const enc_evaluator *e, float z) {
    const float q = z * e->horizon_scale;
    return q >= 1 ? 1.0f : e->reference.domain_sqrt ? btf_ref_pow(q, 0.5f) : q;
}

static void evaluate_factors(const enc_evaluated_texel *t, const btf_ref_options *options,
                             const enc_evaluated_at *at, const uint32_t *components, size_t count,
                             float out[][3]) {
    const enc_evaluator *e = t->evaluator;
    const bool nearest = options->interpolation == BTF_REF_NEAREST;
    const btf_ref_neighbours views = nearest ? btf_ref_nearest(*at->views) : *at->views;
    const btf_ref_neighbours lights = nearest ? btf_ref_nearest(*at->lights) : *at->lights;
    const float m = horizon(e, at->light[2]);
    memset(out, 0, count * sizeof *out);
    for (int a = 0; a < 3; a++)
        if (views.weight[a] > 0)
            evaluate_view(t, views.index[a], views.weight[a], &lights, m, components, count, out);
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++) {
            float x = out[i][c];
            if (e->roots) {
                x = x >= 0x1p-30f ? fminf(x, 0x1p32f) : 0.0f;
                x = x * x;
            }
            out[i][c] = x * e->reference.radiance_scale;
        }
}

void enc_evaluate(const enc_evaluated_texel *t, const btf_ref_options *options, const enc_evaluated_at *at,
                  const uint32_t *components, size_t count, float out[][3]) {
    const enc_evaluator *e = t->evaluator;
    if (e->fast && options->effects & BTF_EFFECT_RESIDUAL && components[count - 1] > 0) {
        evaluate_factors(t, options, at, components, count, out);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        btf_ref_options each = *options;
        each.components = components[i];
        btf_ref_evaluate_neighbours(&e->reference, &each, t->column, t->row, at->lights, at->views,
                                    at->light, at->view, out[i]);
    }
}
