/* Fits u of a level of detail to w, which stays as it is. See level.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "level.h"

#include "encoder/math/linear.h"
#include "matrix.h"
#include "rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CHANNELS = ENC_FACTOR_CHANNELS };

/* The sums that a level's u is fitted to, a channel at a time. */
typedef struct level_channel {
    size_t rank;
    size_t *component; /* [rank] its place among the levels of a texel */
    float *top;        /* [rank] the largest level */
    bool *bytes;       /* [rank] true: levels in steps of 1, with a zero; false: in steps of 2 */
    float *w;          /* [rank][column] value of a level of u */
    float *product;    /* [rank][texel] of the samples and w */
    float *gram;       /* [rank][rank] */
} level_channel;

typedef struct level_fit {
    const enc_context *context;
    const enc_data *data;
    const enc_solution *base;
    enc_factor_unit *units;
    size_t components;
    level_channel channel[CHANNELS];
} level_fit;

static void clear_fit(level_fit *fit) {
    for (int c = 0; c < CHANNELS; c++) {
        level_channel *of = &fit->channel[c];
        free(of->component);
        free(of->top);
        free(of->bytes);
        free(of->w);
        free(of->product);
        free(of->gram);
    }
    free(fit->units);
}

static bool allocate_channel(const level_fit *fit, level_channel *of) {
    const size_t columns = (size_t)fit->data->n_views * (size_t)fit->data->n_lights;
    of->component = malloc((of->rank + 1) * sizeof *of->component);
    of->top = malloc((of->rank + 1) * sizeof *of->top);
    of->bytes = malloc((of->rank + 1) * sizeof *of->bytes);
    of->w = malloc((of->rank * columns + 1) * sizeof *of->w);
    of->product = malloc((of->rank * enc_data_texel_count(fit->data) + 1) * sizeof *of->product);
    of->gram = malloc((of->rank * of->rank + 1) * sizeof *of->gram);
    return of->component && of->top && of->bytes && of->w && of->product && of->gram;
}

/* Lists the components of each channel, in the order of the units. */
static bool list_components(level_fit *fit) {
    const enc_factor_store *f = &fit->base->factors;
    for (size_t i = 0; i < f->units; i++) {
        for (int k = 0; k < ENC_STORE_WORDS; k++) {
            fit->channel[fit->units[i].channel[k]].rank += (size_t)fit->units[i].word;
        }
    }
    for (int c = 0; c < CHANNELS; c++) {
        if (!allocate_channel(fit, &fit->channel[c])) {
            return false;
        }
        fit->channel[c].rank = 0;
    }
    for (size_t i = 0; i < f->units; i++) {
        for (int n = 0; n < ENC_STORE_WORDS * fit->units[i].word; n++) {
            level_channel *of = &fit->channel[fit->units[i].channel[n / fit->units[i].word]];
            of->component[of->rank] = fit->units[i].first + (size_t)n;
            of->top[of->rank] = (float)enc_factor_classes[fit->units[i].class].top_u;
            of->bytes[of->rank++] = fit->units[i].class == 0;
        }
    }
    return true;
}

/* Fills in w of one pair of directions, in the orthonormal channels of matrix.h. */
static void fill_column(const level_fit *fit, size_t column, int16_t *levels) {
    static const float axis[CHANNELS] = {0.57735027f, 0.70710678f, 0.40824829f};
    const enc_factor_store *f = &fit->base->factors;
    const size_t columns = (size_t)fit->data->n_views * (size_t)fit->data->n_lights;
    const size_t view = column / (size_t)fit->data->n_lights;
    size_t at[CHANNELS] = {0};
    for (size_t i = 0; i < f->units; i++) {
        const enc_factor_unit *unit = &fit->units[i];
        enc_store_w_levels(unit, f->directions + (i * columns + column) * ENC_STORE_WORDS, levels);
        for (int n = 0; n < ENC_STORE_WORDS * unit->word; n++) {
            const int k = n / unit->word, c = unit->channel[k];
            const float factor = f->views[(view * ENC_STORE_TIERS + (size_t)unit->tier) * 4 + (size_t)c];
            fit->channel[c].w[at[c]++ * columns + column] =
                (float)levels[n] * f->scales[i * ENC_STORE_WORDS + (size_t)k] * factor / axis[c];
        }
    }
}

static void fill_gram(const level_fit *fit, level_channel *of) {
    const size_t columns = (size_t)fit->data->n_views * (size_t)fit->data->n_lights;
#pragma omp parallel for schedule(dynamic) num_threads(fit->context->threads)
    for (size_t i = 0; i < of->rank; i++) {
        for (size_t j = 0; j <= i; j++) {
            of->gram[i * of->rank + j] = of->gram[j * of->rank + i] =
                (float)enc_dot(columns, of->w + i * columns, of->w + j * columns);
        }
    }
}

static btf_result prepare(level_fit *fit) {
    const enc_factor_store *f = &fit->base->factors;
    const size_t columns = (size_t)fit->data->n_views * (size_t)fit->data->n_lights;
    enc_factor_matrix matrix = enc_factor_matrix_of(fit->context, fit->data);
    enc_factor_set w, product;
    int16_t *levels = NULL;
    fit->units = calloc(f->units, sizeof *fit->units);
    bool ok = fit->units;
    if (ok) {
        fit->components = enc_store_list((const uint32_t(*)[3])f->classes, fit->units);
        levels = malloc(fit->components * sizeof *levels);
        ok = levels && list_components(fit);
    }
    for (size_t column = 0; ok && column < columns; column++) {
        fill_column(fit, column, levels);
    }
    free(levels);
    if (!ok) {
        return enc_fail(fit->context, BTF_ERROR_MEMORY, "levels: out of memory for %zu components",
                        fit->components);
    }
    for (int c = 0; c < CHANNELS; c++) {
        fill_gram(fit, &fit->channel[c]);
        w.rank[c] = product.rank[c] = fit->channel[c].rank;
        w.factor[c] = fit->channel[c].w;
        product.factor[c] = fit->channel[c].product;
    }
    const btf_result result = enc_factor_clip(&matrix);
    return result == BTF_OK ? enc_factor_times_w(&matrix, &w, &product) : result;
}

static float nearest_level(float x, float top, bool bytes) {
    const float level = bytes ? rintf(x) : 2 * rintf((x - 1) / 2) + 1;
    return fminf(fmaxf(level, -top), top);
}

/* Makes sweeps of coordinate descent on x^T G x - 2 x^T p; gradient is p - G x. coded: x moves from level
 * to level, else freely. */
static void descend(const level_channel *of, int sweeps, bool coded, float *x, float *gradient) {
    const size_t rank = of->rank;
    for (int sweep = 0; sweep < sweeps; sweep++) {
        for (size_t j = 0; j < rank; j++) {
            const float *g = of->gram + j * rank;
            if (!(g[j] > 0)) {
                continue;
            }
            const float best = x[j] + gradient[j] / g[j];
            const float step = (coded ? nearest_level(best, of->top[j], of->bytes[j]) : best) - x[j];
            if (step == 0) {
                continue;
            }
            x[j] += step;
            for (size_t i = 0; i < rank; i++) {
                gradient[i] -= step * g[i];
            }
        }
    }
}

/* Fits the levels of one texel; x and gradient have room for those of a channel. */
static void fit_texel(const level_fit *fit, size_t texel, float *x, float *gradient, int16_t *levels) {
    const size_t texels = enc_data_texel_count(fit->data);
    for (int c = 0; c < CHANNELS; c++) {
        const level_channel *of = &fit->channel[c];
        for (size_t j = 0; j < of->rank; j++) {
            gradient[j] = of->product[j * texels + texel];
            x[j] = 0;
        }
        descend(of, ENC_FACTORS_FIT_SWEEPS, false, x, gradient);
        for (size_t j = 0; j < of->rank; j++) {
            const float level = nearest_level(x[j], of->top[j], of->bytes[j]), step = level - x[j];
            x[j] = level;
            for (size_t i = 0; i < of->rank; i++) {
                gradient[i] -= step * of->gram[j * of->rank + i];
            }
        }
        descend(of, ENC_FACTORS_LEVEL_SWEEPS, true, x, gradient);
        for (size_t j = 0; j < of->rank; j++) {
            levels[of->component[j]] = (int16_t)x[j];
        }
    }
}

static btf_result fit_texels(const level_fit *fit, uint32_t *out) {
    const size_t texels = enc_data_texel_count(fit->data);
    size_t begin, end; /* texels of this rank */
    btf_result result = BTF_OK;
    enc_rows_range(fit->context, texels, 1, &begin, &end);
#pragma omp parallel num_threads(fit->context->threads)
    {
        float *x = malloc(2 * fit->components * sizeof *x);
        int16_t *levels = malloc(fit->components * sizeof *levels);
#pragma omp for schedule(dynamic)
        for (size_t t = begin; t < end; t++) {
            const btf_result mine = !x || !levels                 ? BTF_ERROR_MEMORY
                                    : enc_cancelled(fit->context) ? BTF_ERROR_INTERRUPTED
                                                                  : BTF_OK;
            if (mine == BTF_OK) {
                fit_texel(fit, t, x, x + fit->components, levels);
                enc_store_pack_texel(fit->units, fit->base->factors.units, levels, texels, t, out);
            } else {
                enc_keep_worse(&result, mine);
            }
        }
        free(x);
        free(levels);
    }
    if (result == BTF_ERROR_MEMORY) {
        enc_fail(fit->context, result, "levels: out of memory");
    }
    return enc_rows_complete(fit->context, result, (size_t)fit->base->factors.layers, texels, 1,
                             ENC_STORE_WORDS * sizeof *out, out);
}

/* Further levels have no match: every texel is its own source, with the gain that is nearest to 1. */
static bool fill_points(const enc_solution *base, enc_solution *level) {
    const size_t points = enc_solution_texels(level) * (size_t)level->n_views;
    if (!base->shift) {
        return true;
    }
    int code = 0;
    for (int i = 1; i < 16; i++) {
        if (fabsf(enc_solution_gain(base, i) - 1) < fabsf(enc_solution_gain(base, code) - 1)) {
            code = i;
        }
    }
    level->shift = calloc(points, 2 * sizeof *level->shift);
    level->gain = malloc(points);
    if (level->gain) {
        memset(level->gain, code, points);
    }
    return level->shift && level->gain;
}

btf_result enc_factors_level(const enc_context *context, const enc_data *data, const enc_solution *base,
                             enc_solution *out_solution) {
    level_fit fit = {.context = context, .data = data, .base = base};
    *out_solution = enc_level_of(base, data->width, data->height);
    uint32_t *texels =
        calloc((size_t)base->factors.layers * enc_data_texel_count(data), ENC_STORE_WORDS * sizeof *texels);
    out_solution->factors.texels = texels;
    btf_result result = texels && fill_points(base, out_solution)
                            ? prepare(&fit)
                            : enc_fail(context, BTF_ERROR_MEMORY, "levels: out of memory");
    if (result == BTF_OK) {
        result = fit_texels(&fit, texels);
    }
    clear_fit(&fit);
    if (result != BTF_OK) {
        enc_level_clear(out_solution);
    }
    return result;
}
