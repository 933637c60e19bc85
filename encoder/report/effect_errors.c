/* The errors of all variants of decoding. See effect_errors.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "effect_errors.h"

#include "bands.h"
#include "drawn_texels.h"
#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/data/level_filter.h"
#include "encoder/math/srgb.h"
#include "encoder/model/evaluator.h"
#include "metrics.h"
#include "report.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    MOST_SETS = 32 + 3 + 1,        /* subsets of effects: see make_variants */
    MOST_VARIANTS = MOST_SETS * 5, /* kinds */
    MOST_TEXELS = 512,
    MOST_PAIRS = 16,
    LEAST_EVALUATIONS = 200000,
    CELL_SAMPLES = 2048,
    MOST_OF_FULL = 300000,
    MOST_ROWS = 4096, /* of a table (FORMAT.md) */
    ROW_HEAD = 5
};

/* Column 3 of a row. */
typedef enum kind { INTERPOLATED, NEAREST, AT_SAMPLES, VIEW_AT_SAMPLE, LIGHT_AT_SAMPLE, KINDS } kind;

enum { MOST_COUNTS = 16 };

_Static_assert(MOST_VARIANTS == MOST_SETS * KINDS, "a variant for each kind");

/* Variants of decoding that one evaluation gives: a subset of effects, a kind of directions, and falling
 * numbers of components. */
typedef struct variant {
    btf_ref_options options; /* but for the components */
    kind kind;
    uint32_t components[MOST_COUNTS];
    double gpu_bytes[MOST_COUNTS];
    size_t count, first; /* numbers of components; first: the number of its first row */
} variant;

/* The row of a variant with its i-th number of components: rows of all kinds stand together. */
static size_t row_of(const variant *v, size_t i) {
    return v->first + i * KINDS;
}

typedef struct job {
    const enc_context *context;
    const enc_data *data;
    enc_evaluator *evaluator;
    enc_bands views, lights;
    variant *variants;
    size_t n_variants, n_rows, cells;
    int levels;           /* levels that are measured: as many as a table has rows for */
    uint32_t all_effects; /* of the file */
    bool differences;     /* whether differences from the variants that decode everything are summed too,
                             after the errors */
    size_t samples;       /* of the data, level 0 */
    size_t texels, pairs; /* drawn of the present level; pairs: of directions, for each texel and pair of
                             bands */
    const btf_material *packed;
    float *rows;            /* errors of the present level, row by row */
    float *difference_rows; /* where the next row of differences goes */
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

static void add_way(job *j, const btf_material_info *info, uint32_t effects, const uint32_t *components,
                    size_t count) {
    assert(j->n_variants + KINDS <= MOST_VARIANTS);
    for (int kind = INTERPOLATED; kind < KINDS; kind++) {
        const int interpolation = kind == NEAREST || kind == AT_SAMPLES ? BTF_REF_NEAREST : BTF_REF_LINEAR;
        variant *v = &j->variants[j->n_variants++];
        *v = (variant){
            .options = {.effects = effects, .interpolation = interpolation, .filter = BTF_REF_TEXEL},
            .kind = (enum kind)kind,
            .count = count,
            .first = j->n_rows + (size_t)kind};
        for (size_t i = 0; i < count; i++) {
            v->components[i] = components[i];
            v->gpu_bytes[i] = (double)enc_report_gpu_bytes_part(info, effects, components[i]);
        }
    }
    j->n_rows += count * KINDS;
}

/* Makes the variants of all subsets of the other effects together with relief and gloss. Errors are
 * measured against the data interpolated between the samples, which know nothing of these two, so that each
 * would seem to harm; the table of errors between the samples tells what they are worth (leave_one_out.h).
 * What changes without one of them, or both, is measured once with all other effects: three sets besides
 * the 32 subsets and the empty one. Of up to 16 units of factors every number is measured, since one
 * evaluation gives them all. Of more units, and of components in groups of four: all, all but one or one
 * group, 7, 6, 4, 3, 2 and 1 eighths, and the fewest two. */
static void make_variants(job *j, const btf_material_info *info) {
    const uint32_t group = info->store == BTF_STORE_FACTORS ? 1 : 4;
    const uint32_t between = info->effects & (BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS);
    for (uint32_t effects = 0; effects <= info->effects; effects++) {
        const bool lacks = (effects & between) != between;
        if (effects != 0 && lacks && (effects | between) != info->effects) {
            continue;
        }
        if ((effects & ~info->effects) || effective(info, effects) != effects) {
            continue;
        }
        uint32_t list[MOST_COUNTS] = {0};
        size_t count = 0;
        if (effects & BTF_EFFECT_RESIDUAL) {
            const uint32_t k = info->components;
            const uint32_t some[] = {k,         k > group ? k - group : 0,
                                     7 * k / 8, 3 * k / 4,
                                     k / 2,     3 * k / 8,
                                     k / 4,     k / 8,
                                     2 * group, group};
            const bool all = group == 1 && k <= MOST_COUNTS;
            const size_t most = lacks ? 1 : all ? k : sizeof some / sizeof *some;
            for (size_t i = 0; i < most; i++) {
                const uint32_t components = all      ? k - (uint32_t)i
                                            : i == 0 ? k
                                                     : (some[i] + group - 1) / group * group;
                if (components > 0 && (count == 0 || components < list[count - 1])) {
                    list[count++] = components;
                }
            }
        }
        add_way(j, info, effects, list, count > 0 ? count : 1);
    }
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

/* A light and a view, their neighbours, and the value of the data there. */
typedef struct pair {
    float light[3], view[3];
    enc_evaluated_neighbours around;
    float truth[3];
} pair;

static void look_up_pair(const job *j, const float *profiles, pair *p) {
    p->around = enc_evaluated_look_up(j->evaluator, p->light, p->view);
    interpolate(j->data, profiles, &p->around.views, &p->around.lights, p->truth);
}

/* Adds the squared differences of a and b, linear and sRGB-coded; a_srgb is a, sRGB-coded. */
static void add_squares(const float a[3], const float a_srgb[3], const float b[3], double sum[2]) {
    for (int c = 0; c < 3; c++) {
        const double linear = (double)clip(b[c]) - clip(a[c]);
        const double srgb = (double)enc_srgb_encode(b[c]) - a_srgb[c];
        sum[0] += linear * linear;
        sum[1] += srgb * srgb;
    }
}

static void encode_srgb(const float rgb[3], float out[3]) {
    for (int c = 0; c < 3; c++) {
        out[c] = enc_srgb_encode(rgb[c]);
    }
}

/* Decodes one texel by every variant, under the pair of directions of its kind, to rgb
 * [variant][MOST_COUNTS], and adds the squared errors, linear and sRGB-coded: sum[row][cell][2]. */
static void add_errors(const job *j, enc_evaluated_texel *texel, const pair pairs[KINDS],
                       float (*rgb)[MOST_COUNTS][3], double *sum) {
    for (size_t w = 0; w < j->n_variants; w++) {
        const variant *v = &j->variants[w];
        const pair *p = &pairs[v->kind];
        const enc_evaluated_at at = {&p->around.lights, &p->around.views, p->light, p->view, true, false};
        float truth[3];
        enc_evaluate(texel, &v->options, &at, v->components, v->count, rgb[w]);
        encode_srgb(p->truth, truth);
        for (size_t i = 0; i < v->count; i++) {
            add_squares(p->truth, truth, rgb[w][i], sum + 2 * row_of(v, i) * j->cells);
        }
    }
}

/* Adds the squared differences of all variants from those that decode everything, whose rows come last:
 * sum[row][cell][2]. Variants by nearest directions are compared with what interpolation shows. */
static void add_differences(const job *j, float (*rgb)[MOST_COUNTS][3], double *sum) {
    const size_t full = j->n_variants - KINDS;
    for (size_t w = 0; w < j->n_variants; w++) {
        const variant *v = &j->variants[w];
        const float *everything = rgb[full + (v->kind == NEAREST ? INTERPOLATED : v->kind)][0];
        float coded[3];
        encode_srgb(everything, coded);
        for (size_t i = 0; i < v->count; i++) {
            add_squares(everything, coded, rgb[w][i], sum + 2 * row_of(v, i) * j->cells);
        }
    }
}

/* Adds errors and differences of a texel under one pair of each kind: sum[2][row][cell][2], the second half
 * only where differences are asked for. */
static void measure_pair(const job *j, enc_evaluated_texel *texel, const pair pairs[KINDS], double *sum) {
    float rgb[MOST_VARIANTS][MOST_COUNTS][3];
    add_errors(j, texel, pairs, rgb, sum);
    if (j->differences) {
        add_differences(j, rgb, sum + 2 * j->n_rows * j->cells);
    }
}

/* Measures one texel under all its pairs of directions; `sum` is that of measure_pair. Errors:
 * BTF_ERROR_MEMORY. */
static btf_result measure_texel(const void *user, size_t index, size_t texel, const float *profiles,
                                double *sum) {
    const job *j = user;
    enc_evaluated_texel *evaluated = enc_evaluated_texel_create(j->evaluator, texel);
    if (!evaluated) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t cell = 0; cell < j->cells; cell++) {
        for (size_t p = 0; p < j->pairs; p++) {
            const uint64_t seed = enc_mix((index * j->cells + cell) * j->pairs + p);
            const int view_band = (int)(cell / (size_t)j->lights.count);
            const int light_band = (int)(cell % (size_t)j->lights.count);
            pair between, at, pairs[KINDS];
            enc_bands_draw(&j->views, view_band, seed, between.view);
            enc_bands_draw(&j->lights, light_band, seed + 2, between.light);
            enc_bands_draw_sample(&j->views, view_band, j->data->views, j->data->n_views, seed + 4,
                                  at.view);
            enc_bands_draw_sample(&j->lights, light_band, j->data->lights, j->data->n_lights, seed + 5,
                                  at.light);
            for (int kind = INTERPOLATED; kind < KINDS; kind++) {
                const bool at_view = kind == AT_SAMPLES || kind == VIEW_AT_SAMPLE;
                const bool at_light = kind == AT_SAMPLES || kind == LIGHT_AT_SAMPLE;
                memcpy(pairs[kind].view, at_view ? at.view : between.view, sizeof at.view);
                memcpy(pairs[kind].light, at_light ? at.light : between.light, sizeof at.light);
                look_up_pair(j, profiles, &pairs[kind]);
            }
            measure_pair(j, evaluated, pairs, sum + 2 * cell);
        }
    }
    enc_evaluated_texel_destroy(&evaluated);
    return BTF_OK;
}

/* Chooses texels and pairs of directions so that all rows take at most `evaluations`, and no more than half
 * as many as level 0 has samples, for every level: a coarse one has few texels, but as many directions
 * between the samples. */
static void choose_samples(job *j, size_t evaluations) {
    const size_t count = enc_data_texel_count(j->data);
    const size_t enough = j->samples / 2 > LEAST_EVALUATIONS ? j->samples / 2 : LEAST_EVALUATIONS;
    size_t each = (enough < evaluations ? enough : evaluations) / (j->n_rows * j->cells);
    each = each > CELL_SAMPLES ? CELL_SAMPLES : each;
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

/* Measures the mean squared errors of some variants: out[row][cell][2], and after them the differences
 * where they are asked for. Errors: BTF_ERROR_MEMORY, those of the data. */
static btf_result measure_means(const job *j, double **out) {
    const size_t length = (j->differences ? 4 : 2) * j->n_rows * j->cells;
    *out = calloc(length, sizeof **out);
    btf_result result = enc_ranks_agree(j->context, *out ? BTF_OK : BTF_ERROR_MEMORY);
    if (result == BTF_OK) {
        result = enc_drawn_texels_sum(j->context, j->data, j->texels, length, measure_texel, j, *out);
    }
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
    size_t row[KINDS];
    double *better = NULL;
    j.differences = false;
    j.variants = full;
    j.n_variants = 0;
    for (size_t w = 0; w < all->n_variants && j.n_variants < KINDS; w++) {
        if (all->variants[w].options.effects == all->all_effects) {
            row[j.n_variants] = all->variants[w].first;
            full[j.n_variants] = all->variants[w];
            full[j.n_variants].first = j.n_variants;
            full[j.n_variants++].count = 1;
        }
    }
    if (j.n_variants < KINDS) {
        return BTF_OK;
    }
    j.n_rows = j.n_variants;
    choose_samples(&j, MOST_OF_FULL);
    if (j.texels * j.pairs <= all->texels * all->pairs) {
        return BTF_OK;
    }
    const btf_result result = measure_means(&j, &better);
    for (size_t k = 0; result == BTF_OK && k < KINDS; k++) {
        for (size_t i = 0; i < 2 * j.cells; i++) {
            const double step = better[2 * k * j.cells + i] - mean[2 * row[k] * j.cells + i];
            for (size_t w = 0; w < all->n_variants; w++) {
                const variant *v = &all->variants[w];
                for (size_t n = 0; v->kind == full[k].kind && n < v->count; n++) {
                    double *m = &mean[2 * row_of(v, n) * j.cells + i];
                    *m = row_of(v, n) == row[k] ? *m + step : fmax(*m + step, *m / 4);
                }
            }
        }
    }
    free(better);
    return result;
}

/* Steps of the stage: further levels have half the samples of level 0. */
static size_t steps_of(int level) {
    return level > 0 ? 1 : 2;
}

/* Writes the row of a table for the variant's n-th number of components; returns its end. */
static float *write_row(const job *j, const variant *v, size_t n, int level, const double *mean,
                        float *row) {
    const double *of_row = mean + 2 * row_of(v, n) * j->cells;
    *row++ = (float)v->options.effects;
    *row++ = (float)v->components[n];
    *row++ = (float)v->kind;
    *row++ = (float)level;
    *row++ = (float)v->gpu_bytes[n];
    for (size_t i = 0; i < 2 * j->cells; i++) {
        *row++ = fminf((float)of_row[i], 1.0f);
    }
    return row;
}

static void write_rows(const job *j, int level, const double *mean) {
    for (size_t w = 0; w < j->n_variants; w++) {
        const variant *v = &j->variants[w];
        for (size_t n = 0; n < v->count; n++) {
            write_row(j, v, n, level, mean, j->rows + row_of(v, n) * (ROW_HEAD + 2 * j->cells));
        }
    }
}

/* Whether the table of differences has a row of this kind. There is none where view and light are samples,
 * since errors against the data say more there; coarser levels, to save bytes, have one between the samples
 * alone, by interpolated directions. */
static bool has_differences(int level, kind kind) {
    return level > 0 ? kind == INTERPOLATED : kind != AT_SAMPLES;
}

static void write_differences(job *j, int level, const double *mean) {
    for (size_t w = 0; w < j->n_variants; w++) {
        const variant *v = &j->variants[w];
        for (size_t n = 0; n < v->count && has_differences(level, v->kind); n++) {
            j->difference_rows = write_row(j, v, n, level, mean, j->difference_rows);
        }
    }
}

/* Measures all variants in a level (an enc_level_fn) and writes their rows. */
static btf_result measure_level(void *user, int level, const enc_data *data) {
    job *j = user;
    double *mean = NULL;
    j->data = data;
    j->differences = j->difference_rows;
    btf_result result = enc_evaluator_create(j->context, j->packed, (uint32_t)level, &j->evaluator);
    result = enc_ranks_agree(j->context, result);
    if (result == BTF_OK) {
        choose_samples(j, ENC_EFFECT_EVALUATIONS(level));
        result = measure_means(j, &mean);
    }
    if (result == BTF_OK) {
        result = correct_by_full(j, mean);
    }
    enc_stage_step(j->context, steps_of(level));
    if (result == BTF_OK && j->differences) {
        write_differences(j, level, mean + 2 * j->n_rows * j->cells);
    }
    if (result == BTF_OK) {
        write_rows(j, level, mean);
        j->rows += j->n_rows * (ROW_HEAD + 2 * j->cells);
    }
    free(mean);
    enc_evaluator_destroy(&j->evaluator);
    return result;
}

/* Makes room for the tables and writes their heads. False when out of memory. */
static bool make_tables(job *j, const btf_material_info *info, enc_effect_tables *out) {
    const size_t head = 4 + (size_t)(j->views.count + j->lights.count), length = ROW_HEAD + 2 * j->cells;
    j->variants = calloc(MOST_VARIANTS, sizeof *j->variants);
    if (!j->variants) {
        return false;
    }
    make_variants(j, info);
    const size_t most = MOST_ROWS / j->n_rows;
    j->levels = (int)(info->levels < most ? info->levels : most);
    out->error_count = head + (size_t)j->levels * j->n_rows * length;
    out->errors = malloc(out->error_count * sizeof *out->errors);
    if (!out->errors) {
        return false;
    }
    j->rows = enc_bands_write(&j->views, &j->lights, out->errors);
    if (j->variants[j->n_variants - KINDS].options.effects != j->all_effects) {
        return true; /* the file has effects that do nothing, so that no variant decodes everything */
    }
    out->difference_count = head + j->n_rows / KINDS * (KINDS - 2 + (size_t)j->levels) * length;
    out->differences = malloc(out->difference_count * sizeof *out->differences);
    if (!out->differences) {
        return false;
    }
    j->difference_rows = enc_bands_write(&j->views, &j->lights, out->differences);
    return true;
}

void enc_effect_tables_clear(enc_effect_tables *tables) {
    free(tables->errors);
    free(tables->differences);
    *tables = (enc_effect_tables){0};
}

btf_result enc_effect_errors(const enc_context *context, const enc_data *data, const btf_material *material,
                             enc_effect_tables *out) {
    btf_material_info info = {.struct_size = sizeof info};
    *out = (enc_effect_tables){0};
    btf_result result = btf_material_get_info(material, &info);
    if (result != BTF_OK) {
        return result;
    }
    job j = {.context = context,
             .packed = material,
             .samples = enc_data_texel_count(data) * (size_t)data->n_views * (size_t)data->n_lights,
             .views = enc_bands_make(data->views, data->n_views),
             .lights = enc_bands_make(data->lights, data->n_lights)};
    j.cells = (size_t)j.views.count * (size_t)j.lights.count;
    j.all_effects = info.effects;
    if (!make_tables(&j, &info, out)) {
        result = BTF_ERROR_MEMORY;
    } else {
        size_t steps = 0;
        for (int level = 0; level < j.levels; level++) {
            steps += steps_of(level);
        }
        enc_stage_begin(context, "effect errors", steps);
        result = measure_level(&j, 0, data);
        if (result == BTF_OK && j.levels > 1) {
            result = enc_level_each(context, data, j.levels, measure_level, &j);
        }
        enc_stage_end(context);
    }
    free(j.variants);
    if (result == BTF_OK) {
        return BTF_OK;
    }
    enc_effect_tables_clear(out);
    return result == BTF_ERROR_INTERRUPTED
               ? result
               : enc_fail(context, result, "measuring the errors without single effects: %s",
                          btf_result_text(result));
}
