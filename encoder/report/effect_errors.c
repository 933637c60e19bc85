/* The errors of all variants of decoding. See effect_errors.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "effect_errors.h"

#include "bands.h"
#include "decoder/toolkit/reference_view.h"
#include "drawn_texels.h"
#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/data/level_filter.h"
#include "encoder/math/srgb.h"
#include "metrics.h"
#include "report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    MOST_VARIANTS = 1024,
    MOST_TEXELS = 512,
    MOST_PAIRS = 16,
    LEAST_EVALUATIONS = 200000,
    CELL_SAMPLES = 2048,
    MOST_EVALUATIONS = 3000000,
    MOST_OF_FULL = 300000,
    ROW_HEAD = 5
};

#define DEGREE (3.14159265358979323846 / 180)

/* Column 3 of a row. */
typedef enum kind { INTERPOLATED, NEAREST, AT_SAMPLES, VIEW_AT_SAMPLE, LIGHT_AT_SAMPLE, KINDS } kind;

/* One variant of decoding: a subset of effects, a number of components, a kind of directions. */
typedef struct variant {
    btf_ref_options options;
    kind kind;
    double gpu_bytes;
} variant;

typedef struct job {
    const enc_context *context;
    const enc_data *data;
    btf_ref_material material;
    enc_bands views, lights;
    variant *variants;
    size_t n_variants, cells;
    btf_ref_options full; /* everything: effects and components of the file */
    size_t texels, pairs; /* of the level at hand; pairs: directions a texel and pair of bands */
    const btf_material *packed;
    float *rows; /* of the levels so far */
} job;

/* Effects that change anything: without an SBRDF and without a residual, sources are black. */
static uint32_t effective(const btf_material_info *info, uint32_t effects) {
    if (info->colour == BTF_COLOUR_NONE) {
        effects &= ~(uint32_t)BTF_EFFECT_SHADOW;
        if (!(effects & BTF_EFFECT_RESIDUAL)) {
            effects &= BTF_EFFECT_HIDDEN;
        }
    }
    return effects;
}

static void add_way(job *j, const btf_material_info *info, uint32_t effects, uint32_t components) {
    btf_material_info reduced = *info;
    reduced.components = components;
    for (int kind = INTERPOLATED; kind < KINDS; kind++) {
        const int interpolation = kind == NEAREST || kind == AT_SAMPLES ? BTF_REF_NEAREST : BTF_REF_LINEAR;
        j->variants[j->n_variants++] =
            (variant){.options = {.effects = effects,
                                  .components = components,
                                  .interpolation = interpolation,
                                  .filter = BTF_REF_TEXEL},
                      .kind = (enum kind)kind,
                      .gpu_bytes = (double)enc_report_gpu_bytes(&reduced, effects)};
    }
}

/* All subsets of the effects present; of the residual all components, three quarters, a half, ... an
 * eighth, and 8 and 4, in whole groups of four. */
static void make_variants(job *j, const btf_material_info *info) {
    for (uint32_t effects = 0; effects <= info->effects; effects++) {
        if ((effects & ~info->effects) || effective(info, effects) != effects) {
            continue;
        }
        if (!(effects & BTF_EFFECT_RESIDUAL)) {
            add_way(j, info, effects, 0);
            continue;
        }
        const uint32_t k = info->components;
        const uint32_t some[] = {
            k, k > 4 ? k - 4 : 0, 7 * k / 8, 3 * k / 4, k / 2, 3 * k / 8, k / 4, k / 8, 8, 4};
        uint32_t last = UINT32_MAX;
        for (size_t i = 0; i < sizeof some / sizeof *some; i++) {
            const uint32_t components = i == 0 ? k : (some[i] + 3) / 4 * 4;
            if (components < last && components > 0) {
                add_way(j, info, effects, components);
                last = components;
            }
        }
    }
}

static double unit(uint64_t seed) {
    return (double)(enc_mix(seed) >> 11) * 0x1p-53;
}

/* Uniform over the solid angle of a band. */
static void pick(const enc_bands *b, int band, uint64_t seed, float out[3]) {
    const double low = cos(b->limit[band] * DEGREE), high = cos(b->limit[band + 1] * DEGREE);
    const double z = low + (high - low) * unit(seed), phi = 360 * DEGREE * unit(seed + 1),
                 s = sqrt(1 - z * z);
    out[0] = (float)(s * cos(phi));
    out[1] = (float)(s * sin(phi));
    out[2] = (float)z;
}

/* One of the sampled directions of a band. */
static void pick_sample(const enc_bands *b, int band, const enc_direction *directions, int count,
                        uint64_t seed, float out[3]) {
    int inside[ENC_MAX_DIRECTIONS];
    const int n = enc_bands_members(b, band, directions, count, inside);
    memcpy(out, directions[n > 0 ? inside[enc_mix(seed) % (uint64_t)n] : 0].xyz, 3 * sizeof *out);
}

static btf_ref_neighbours look_up(const uint16_t *table, uint32_t grid, const float direction[3]) {
    int32_t q[2];
    btf_ref_project(direction, q);
    return btf_ref_lookup(table, grid, q);
}

/* The data between samples: profiles[view][channel][light] of a texel, weighted. */
static void interpolate(const enc_data *data, const float *profiles, const btf_ref_neighbours *views,
                        const btf_ref_neighbours *lights, float out[3]) {
    const size_t n = (size_t)data->n_lights;
    for (size_t c = 0; c < 3; c++) {
        double sum = 0;
        for (int a = 0; a < 3; a++) {
            for (int b = 0; b < 3; b++) {
                sum += (double)views->weight[a] * lights->weight[b] *
                       profiles[(views->index[a] * 3 + c) * n + lights->index[b]];
            }
        }
        out[c] = (float)(sum * 0x1p-24);
    }
}

static float clip(float x) {
    return x > 0 ? (x < 1 ? x : 1.0f) : 0.0f;
}

/* Two directions and what is known of them. */
typedef struct pair {
    float light[3], view[3];
    btf_ref_neighbours lights, views;
    float truth[3];
} pair;

static void look_up_pair(const job *j, const float *profiles, pair *p) {
    p->views = look_up(j->material.view_table, j->material.view_grid, p->view);
    p->lights = look_up(j->material.light_table, j->material.light_grid, p->light);
    interpolate(j->data, profiles, &p->views, &p->lights, p->truth);
}

/* One texel under a pair of directions for each kind: adds squared errors, linear and sRGB-coded, of each
 * variant: sum[variant][cell][2]. */
static void measure_pair(const job *j, size_t texel, const pair pairs[KINDS], double *sum) {
    const uint32_t column = (uint32_t)texel % j->material.width, row = (uint32_t)texel / j->material.width;
    for (size_t w = 0; w < j->n_variants; w++) {
        const pair *p = &pairs[j->variants[w].kind];
        float rgb[3];
        btf_ref_evaluate_neighbours(&j->material, &j->variants[w].options, column, row, &p->lights,
                                    &p->views, p->light, p->view, rgb);
        for (int c = 0; c < 3; c++) {
            const double linear = (double)clip(rgb[c]) - clip(p->truth[c]);
            const double srgb = (double)enc_srgb_encode(rgb[c]) - enc_srgb_encode(p->truth[c]);
            sum[2 * w * j->cells] += linear * linear;
            sum[2 * w * j->cells + 1] += srgb * srgb;
        }
    }
}

/* All pairs of directions of one texel: sum[variant][cell][2]. */
static void measure_texel(const void *user, size_t index, size_t texel, const float *profiles,
                          double *sum) {
    const job *j = user;
    for (size_t cell = 0; cell < j->cells; cell++) {
        for (size_t p = 0; p < j->pairs; p++) {
            const uint64_t seed = enc_mix((index * j->cells + cell) * j->pairs + p);
            const int view_band = (int)(cell / (size_t)j->lights.count);
            const int light_band = (int)(cell % (size_t)j->lights.count);
            pair between, at, pairs[KINDS];
            pick(&j->views, view_band, seed, between.view);
            pick(&j->lights, light_band, seed + 2, between.light);
            pick_sample(&j->views, view_band, j->data->views, j->data->n_views, seed + 4, at.view);
            pick_sample(&j->lights, light_band, j->data->lights, j->data->n_lights, seed + 5, at.light);
            for (int kind = INTERPOLATED; kind < KINDS; kind++) {
                const bool at_view = kind == AT_SAMPLES || kind == VIEW_AT_SAMPLE;
                const bool at_light = kind == AT_SAMPLES || kind == LIGHT_AT_SAMPLE;
                memcpy(pairs[kind].view, at_view ? at.view : between.view, sizeof at.view);
                memcpy(pairs[kind].light, at_light ? at.light : between.light, sizeof at.light);
                look_up_pair(j, profiles, &pairs[kind]);
            }
            measure_pair(j, texel, pairs, sum + 2 * cell);
        }
    }
}

/* Texels and pairs of directions so that all variants take at most `evaluations`; halved so many times. */
static void choose_samples(job *j, size_t evaluations, int halvings) {
    const size_t count = enc_data_texel_count(j->data);
    const size_t samples = count * (size_t)j->data->n_views * (size_t)j->data->n_lights;
    const size_t enough = samples / 2 > LEAST_EVALUATIONS ? samples / 2 : LEAST_EVALUATIONS;
    size_t each = (enough < evaluations ? enough : evaluations) / (j->n_variants * j->cells);
    each = (each > CELL_SAMPLES ? CELL_SAMPLES : each) >> halvings;
    each = each < 16 ? 16 : each;
    j->texels = count < MOST_TEXELS ? count : MOST_TEXELS;
    if (j->texels > each) {
        j->texels = each;
    }
    j->pairs = each / j->texels;
    if (j->pairs > MOST_PAIRS) {
        j->pairs = MOST_PAIRS;
    }
}

/* Mean squared errors of some variants: out[variant][cell][2]. Errors: BTF_ERROR_MEMORY, those of the data.
 */
static btf_result measure_means(const job *j, double **out) {
    const size_t length = 2 * j->n_variants * j->cells;
    *out = calloc(length, sizeof **out);
    btf_result result = enc_ranks_agree(j->context, *out ? BTF_OK : BTF_ERROR_MEMORY);
    if (result == BTF_OK)
        result = enc_drawn_texels_sum(j->context, j->data, j->texels, length, measure_texel, j, *out);
    for (size_t i = 0; result == BTF_OK && i < length; i++) {
        (*out)[i] /= 3.0 * (double)(j->texels * j->pairs);
    }
    return result;
}

/* Measures the variants that decode everything, one a kind, at more samples. The difference between another
 * variant and them varies far less from sample to sample than its error does, so that few samples are
 * enough for that (control variates). */
static btf_result correct_by_full(const job *all, double *mean) {
    job j = *all;
    variant full[KINDS];
    size_t index[KINDS];
    double *better = NULL;
    j.variants = full;
    j.n_variants = 0;
    for (size_t w = 0; w < all->n_variants && j.n_variants < KINDS; w++) {
        if (all->variants[w].options.effects == all->full.effects &&
            all->variants[w].options.components == all->full.components) {
            index[j.n_variants] = w;
            full[j.n_variants++] = all->variants[w];
        }
    }
    if (j.n_variants < KINDS) {
        return BTF_OK;
    }
    choose_samples(&j, MOST_OF_FULL, 0);
    if (j.texels * j.pairs <= all->texels * all->pairs) {
        return BTF_OK;
    }
    const btf_result result = measure_means(&j, &better);
    for (size_t k = 0; result == BTF_OK && k < KINDS; k++) {
        for (size_t i = 0; i < 2 * j.cells; i++) {
            const double step = better[2 * k * j.cells + i] - mean[2 * index[k] * j.cells + i];
            for (size_t w = 0; w < all->n_variants; w++) {
                double *m = &mean[2 * w * j.cells + i];
                if (all->variants[w].kind == full[k].kind && w != index[k]) {
                    *m = fmax(*m + step, *m / 4);
                }
            }
            mean[2 * index[k] * j.cells + i] += step;
        }
    }
    free(better);
    return result;
}

/* Steps of the stage: each level has half the samples of the one before. */
static size_t steps_of(int level) {
    return (size_t)1 << (BTF_MAX_LEVELS - level);
}

/* Measures all variants in a level (an enc_level_fn) and writes their rows. */
static btf_result measure_level(void *user, int level, const enc_data *data) {
    job *j = user;
    double *mean = NULL;
    j->data = data;
    reference_view(j->packed, (uint32_t)level, &j->material);
    choose_samples(j, MOST_EVALUATIONS, level);
    btf_result result = measure_means(j, &mean);
    if (result == BTF_OK) {
        result = correct_by_full(j, mean);
    }
    enc_stage_step(j->context, steps_of(level));
    for (size_t w = 0; result == BTF_OK && w < j->n_variants; w++) {
        const btf_ref_options *o = &j->variants[w].options;
        *j->rows++ = (float)o->effects;
        *j->rows++ = (float)o->components;
        *j->rows++ = (float)j->variants[w].kind;
        *j->rows++ = (float)level;
        *j->rows++ = (float)j->variants[w].gpu_bytes;
        for (size_t i = 0; i < 2 * j->cells; i++) {
            *j->rows++ = fminf((float)mean[2 * w * j->cells + i], 1.0f);
        }
    }
    free(mean);
    return result;
}

btf_result enc_effect_errors(const enc_context *context, const enc_data *data, const btf_material *material,
                             float **out_values, size_t *out_count) {
    btf_material_info info = {.struct_size = sizeof info};
    *out_values = NULL;
    *out_count = 0;
    btf_result result = btf_material_get_info(material, &info);
    if (result != BTF_OK) {
        return result;
    }
    job j = {.context = context,
             .packed = material,
             .views = enc_bands_make(data->views, data->n_views),
             .lights = enc_bands_make(data->lights, data->n_lights)};
    j.cells = (size_t)j.views.count * (size_t)j.lights.count;
    j.full = (btf_ref_options){.effects = info.effects, .components = info.components};
    j.variants = calloc(MOST_VARIANTS, sizeof *j.variants);
    float *values = NULL;
    size_t count = 0;
    if (j.variants) {
        make_variants(&j, &info);
        count = 4 + (size_t)(j.views.count + j.lights.count) +
                info.levels * j.n_variants * (ROW_HEAD + 2 * j.cells);
        values = malloc(count * sizeof *values);
    }
    if (!values) {
        result = BTF_ERROR_MEMORY;
    } else {
        j.rows = enc_bands_write(&j.views, &j.lights, values);
        size_t steps = 0;
        for (int level = 0; level < (int)info.levels; level++) {
            steps += steps_of(level);
        }
        enc_stage_begin(context, "effect errors", steps);
        result = measure_level(&j, 0, data);
        if (result == BTF_OK && info.levels > 1) {
            result = enc_level_each(context, data, (int)info.levels, measure_level, &j);
        }
        enc_stage_end(context);
    }
    free(j.variants);
    if (result != BTF_OK) {
        free(values);
        return result == BTF_ERROR_INTERRUPTED
                   ? result
                   : enc_fail(context, result, "effect errors: %s", btf_result_text(result));
    }
    *out_values = values;
    *out_count = count;
    return BTF_OK;
}
