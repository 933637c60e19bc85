/* The method of factors. See method.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "method.h"

#include "factor.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

_Static_assert((int)ENC_FACTOR_CLASSES == (int)BTF_FACTOR_CLASSES && (int)ENC_FACTOR_TIERS == (int)ENC_STORE_TIERS,
               "two names of one number");

/* 1 / l.z of the outermost light, in float as decoders read it. */
static float horizon_scale(const enc_data *data) {
    float least = 1;
    for (int l = 0; l < data->n_lights; l++)
        least = fminf(least, data->lights[l].xyz[2]);
    const float scale = 1 / least;
    return fminf(fmaxf(scale, 1.0f), 0x1p24f);
}

static float *spread_views(const float *views, size_t count) {
    float *out = calloc(count * ENC_STORE_TIERS, 4 * sizeof *out);
    for (size_t i = 0; out && i < count * ENC_STORE_TIERS; i++)
        memcpy(out + 4 * i, views + 3 * i, 3 * sizeof *out);
    return out;
}

/* Moves the arrays of *io_factors to a solution. */
static btf_result to_solution(const enc_context *context, const enc_data *data, bool gain,
                              enc_factors **io_factors, enc_solution *out) {
    enc_factors *f = *io_factors;
    *out = (enc_solution){.width = data->width,
                          .height = data->height,
                          .n_views = data->n_views,
                          .n_lights = data->n_lights,
                          .domain = BTF_DOMAIN_SQRT,
                          .effects = BTF_EFFECT_RESIDUAL,
                          .radiance_scale = 1,
                          .blend = BTF_BLEND_ROOTS, /* measured: FORMAT.md, section 12 */
                          .factors = {.units = (uint32_t)f->n_units,
                                      .layers = (uint32_t)f->n_u_texels,
                                      .horizon_scale = horizon_scale(data)}};
    memcpy(out->factors.classes, f->classes, sizeof out->factors.classes);
    if (f->shift) {
        out->effects |= BTF_EFFECT_SHIFT | (gain ? BTF_EFFECT_GAIN : 0);
        out->gain_scale = f->gain_scale;
        out->shift = f->shift;
        out->gain = f->gain;
        f->shift = NULL;
        f->gain = NULL;
    }
    out->factors.views = spread_views(f->views, (size_t)data->n_views);
    out->factors.texels = f->texels;
    out->factors.directions = f->directions;
    out->factors.scales = f->scales;
    f->texels = f->directions = NULL;
    f->scales = NULL;
    enc_factors_destroy(io_factors);
    if (out->factors.views)
        return BTF_OK;
    enc_solution_clear(out);
    return enc_fail(context, BTF_ERROR_MEMORY, "factors: out of memory");
}

/* Quality.
 * ------------------------------------------------------------------------------------------------ */

static double psnr(double mean) {
    return mean > 1e-10 ? -10 * log10(mean) : 100;
}

/* Bytes of the textures but the tables, as a budget counts them. */
static uint64_t gpu_bytes(const enc_data *data, const enc_factors *f) {
    const uint64_t texels = enc_data_texel_count(data);
    const uint64_t pairs = (uint64_t)data->n_views * (uint64_t)data->n_lights;
    return 16 * (texels * (uint64_t)f->n_u_texels + pairs * (uint64_t)f->n_units) + f->match_bytes;
}

/* Notes what an encode tried; *out_kept: the trial that it kept, whose verdict is `left out` until all are made. */
static void note_trials(const enc_data *data, const enc_factors *f, uint32_t match, double quality,
                        enc_factors_stats *stats, int *out_kept) {
    for (int i = 0; i < f->n_trials; i++) {
        const enc_factor_trial *t = &f->trials[i];
        const uint64_t tables = 16 * ((uint64_t)t->n_units + 3 * (uint64_t)data->n_views);
        if (t->kept)
            *out_kept = stats->trials_count;
        stats->trials[stats->trials_count++] =
            (enc_trial){.effects = BTF_EFFECT_RESIDUAL | (t->match ? match : 0),
                        .components = t->n_units,
                        .gpu_bytes = t->bytes > tables ? t->bytes - tables : 0,
                        .psnr = t->error.linear > 0 || quality > 0 ? psnr(t->error.srgb) : NAN,
                        .core_seconds = t->core_seconds,
                        .verdict = t->given_up ? "given up after a survey" : "left out"};
    }
}

/* One encode by a budget, noted as trials; *out_kept: the one kept. */
static btf_result encode(const enc_context *context, const enc_data *data, const enc_factors_settings *settings,
                         uint64_t budget, enc_factors **out, enc_factors_stats *stats, int *out_kept) {
    const bool match = settings->effects & BTF_EFFECT_SHIFT;
    const enc_factor_options options = {
        .budget = budget,
        .sweeps = settings->sweeps,
        .match = settings->choose ? ENC_FACTOR_CHOOSE_MATCH : match ? ENC_FACTOR_MATCH : ENC_FACTOR_NO_MATCH,
        .gain = settings->choose || settings->effects & BTF_EFFECT_GAIN,
        .measure = settings->quality > 0};
    const btf_result result = enc_factor_encode(context, data, &options, out);
    if (result != BTF_OK)
        return result;
    const enc_factors *f = *out;
    note_trials(data, f, BTF_EFFECT_SHIFT | (options.gain ? BTF_EFFECT_GAIN : 0), settings->quality, stats, out_kept);
    enc_log(context, BTF_LOG_INFO, "factors: %zu + %zu + %zu components in %d units%s, %llu bytes",
            f->components[0], f->components[1], f->components[2], f->n_units, f->shift ? " with match" : "",
            (unsigned long long)gpu_bytes(data, f));
    return BTF_OK;
}

/* Between a budget that falls short of the quality and one that reaches it, by the straight line of dB over the
 * logarithm of bytes, but not at the ends. */
static uint64_t next_budget(double low, double low_psnr, double high, double high_psnr, double quality) {
    const double share = isnan(low_psnr) || !(high_psnr > low_psnr) ? 0.5
                                                                    : (quality - low_psnr) / (high_psnr - low_psnr);
    const double inside = fmin(fmax(share + 0.05, 0.1), 0.9);
    return (uint64_t)(low * pow(high / low, inside));
}

/* Replaces *io_best, the encode of trial `best`, by one of fewer bytes that reaches the quality, too. */
static btf_result reduce(const enc_context *context, const enc_data *data, const enc_factors_settings *settings,
                         enc_factors **io_best, enc_factors_stats *stats, int *io_best_trial) {
    double low = (double)((*io_best)->match_bytes +
                          enc_factor_least_budget(data->width, data->height, data->n_views, data->n_lights));
    double low_psnr = NAN, high = (double)(*io_best)->bytes, high_psnr = psnr((*io_best)->error.srgb);
    for (int i = 0; i < ENC_FACTORS_TRIALS && high > 1.01 * low; i++) {
        enc_factors *trial = NULL;
        const uint64_t budget = next_budget(low, low_psnr, high, high_psnr, settings->quality);
        int kept = 0;
        const btf_result result = encode(context, data, settings, budget, &trial, stats, &kept);
        if (result != BTF_OK)
            return result;
        const double reached = psnr(trial->error.srgb);
        if (reached >= settings->quality) {
            high = fmin((double)trial->bytes, (double)budget);
            high_psnr = reached;
            enc_factors_destroy(io_best);
            *io_best = trial;
            *io_best_trial = kept;
        } else {
            low = (double)budget;
            low_psnr = reached;
            enc_factors_destroy(&trial);
        }
    }
    return BTF_OK;
}

btf_result enc_factors_solve(const enc_context *context, const enc_data *data, const enc_factors_settings *settings,
                             enc_solution *out_solution, enc_factors_stats *out_stats) {
    enc_factors_settings now = *settings;
    enc_factors *best = NULL;
    int best_trial = 0;
    *out_solution = (enc_solution){0};
    *out_stats = (enc_factors_stats){0};
    btf_result result = encode(context, data, &now, now.budget, &best, out_stats, &best_trial);
    if (result == BTF_OK && settings->quality > 0) {
        const double reached = psnr(best->error.srgb);
        now.effects = out_stats->trials[best_trial].effects;
        now.choose = false; /* what paid at the whole budget is kept */
        if (reached >= settings->quality)
            result = reduce(context, data, &now, &best, out_stats, &best_trial);
        else
            enc_log(context, BTF_LOG_WARNING, "factors: %.2f dB of %.2f within %llu bytes", reached,
                    settings->quality, (unsigned long long)settings->budget);
    }
    if (result == BTF_OK) {
        const bool gain = out_stats->trials[best_trial].effects & BTF_EFFECT_GAIN;
        out_stats->trials[best_trial].verdict = "best";
        result = to_solution(context, data, gain, &best, out_solution);
    }
    enc_factors_destroy(&best);
    return result;
}

/* Levels of detail.
 * ------------------------------------------------------------------------------------------------ */

enum { FIT_SWEEPS = 12, CHANNELS = ENC_FACTOR_CHANNELS };

/* What a level's u is fitted to, a channel at a time. */
typedef struct level_channel {
    size_t rank;
    size_t *component; /* [rank] its place among the levels of a texel */
    float *top;        /* [rank] the largest level */
    bool *bytes;       /* [rank] levels step by 1, with a zero; else by 2 */
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

/* The components of each channel, in the order of the units. */
static bool list_components(level_fit *fit) {
    const enc_factor_store *f = &fit->base->factors;
    for (size_t i = 0; i < f->units; i++)
        for (int k = 0; k < ENC_STORE_WORDS; k++)
            fit->channel[fit->units[i].channel[k]].rank += (size_t)fit->units[i].word;
    for (int c = 0; c < CHANNELS; c++) {
        if (!allocate_channel(fit, &fit->channel[c]))
            return false;
        fit->channel[c].rank = 0;
    }
    for (size_t i = 0; i < f->units; i++)
        for (int n = 0; n < ENC_STORE_WORDS * fit->units[i].word; n++) {
            level_channel *of = &fit->channel[fit->units[i].channel[n / fit->units[i].word]];
            of->component[of->rank] = fit->units[i].first + (size_t)n;
            of->top[of->rank] = (float)enc_factor_classes[fit->units[i].class].top_u;
            of->bytes[of->rank++] = fit->units[i].class == 0;
        }
    return true;
}

/* w of one pair of directions, in the orthonormal axes of matrix.h. */
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

static float dot(const float *a, const float *b, size_t count) {
    double total = 0;
    for (size_t i = 0; i < count; i++)
        total += (double)a[i] * b[i];
    return (float)total;
}

static void fill_gram(const level_fit *fit, level_channel *of) {
    const size_t columns = (size_t)fit->data->n_views * (size_t)fit->data->n_lights;
#pragma omp parallel for schedule(dynamic) num_threads(fit->context->threads)
    for (size_t i = 0; i < of->rank; i++)
        for (size_t j = 0; j <= i; j++)
            of->gram[i * of->rank + j] = of->gram[j * of->rank + i] =
                dot(of->w + i * columns, of->w + j * columns, columns);
}

static btf_result prepare(level_fit *fit) {
    const enc_factor_store *f = &fit->base->factors;
    const size_t columns = (size_t)fit->data->n_views * (size_t)fit->data->n_lights;
    const enc_factor_matrix matrix = enc_factor_matrix_of(fit->context, fit->data);
    enc_factor_set w, product;
    int16_t *levels = NULL;
    fit->units = calloc(f->units, sizeof *fit->units);
    bool ok = fit->units;
    if (ok) {
        fit->components = enc_store_list((const uint32_t(*)[3])f->classes, fit->units);
        levels = malloc(fit->components * sizeof *levels);
        ok = levels && list_components(fit);
    }
    for (size_t column = 0; ok && column < columns; column++)
        fill_column(fit, column, levels);
    free(levels);
    if (!ok)
        return enc_fail(fit->context, BTF_ERROR_MEMORY, "levels: out of memory for %zu components",
                        fit->components);
    for (int c = 0; c < CHANNELS; c++) {
        fill_gram(fit, &fit->channel[c]);
        w.rank[c] = product.rank[c] = fit->channel[c].rank;
        w.factor[c] = fit->channel[c].w;
        product.factor[c] = fit->channel[c].product;
    }
    return enc_factor_times_w(&matrix, &w, &product);
}

static float nearest_level(float x, float top, bool bytes) {
    const float level = bytes ? rintf(x) : 2 * rintf((x - 1) / 2) + 1;
    return fminf(fmaxf(level, -top), top);
}

/* Sweeps of coordinate descent of x^T G x - 2 x^T p; gradient = p - G x. */
static void descend(const level_channel *of, int sweeps, bool coded, float *x, float *gradient) {
    const size_t rank = of->rank;
    for (int sweep = 0; sweep < sweeps; sweep++)
        for (size_t j = 0; j < rank; j++) {
            const float *g = of->gram + j * rank;
            if (!(g[j] > 0))
                continue;
            const float best = x[j] + gradient[j] / g[j];
            const float step = (coded ? nearest_level(best, of->top[j], of->bytes[j]) : best) - x[j];
            if (step == 0)
                continue;
            x[j] += step;
            for (size_t i = 0; i < rank; i++)
                gradient[i] -= step * g[i];
        }
}

/* Levels of one texel: x and gradient take a channel's. */
static void fit_texel(const level_fit *fit, size_t texel, float *x, float *gradient, int16_t *levels) {
    const size_t texels = enc_data_texel_count(fit->data);
    for (int c = 0; c < CHANNELS; c++) {
        const level_channel *of = &fit->channel[c];
        for (size_t j = 0; j < of->rank; j++) {
            gradient[j] = of->product[j * texels + texel];
            x[j] = 0;
        }
        descend(of, FIT_SWEEPS, false, x, gradient);
        for (size_t j = 0; j < of->rank; j++) {
            const float level = nearest_level(x[j], of->top[j], of->bytes[j]), step = level - x[j];
            x[j] = level;
            for (size_t i = 0; i < of->rank; i++)
                gradient[i] -= step * of->gram[j * of->rank + i];
        }
        descend(of, ENC_FACTORS_LEVEL_SWEEPS, true, x, gradient);
        for (size_t j = 0; j < of->rank; j++)
            levels[of->component[j]] = (int16_t)x[j];
    }
}

static btf_result fit_texels(const level_fit *fit, uint32_t *out) {
    const size_t texels = enc_data_texel_count(fit->data);
    btf_result result = BTF_OK;
#pragma omp parallel num_threads(fit->context->threads)
    {
        float *x = malloc(2 * fit->components * sizeof *x);
        int16_t *levels = malloc(fit->components * sizeof *levels);
#pragma omp for schedule(dynamic)
        for (size_t t = 0; t < texels; t++) {
            const btf_result mine = !x || !levels                     ? BTF_ERROR_MEMORY
                                    : enc_cancelled(fit->context) ? BTF_ERROR_INTERRUPTED
                                                                  : BTF_OK;
            if (mine == BTF_OK) {
                fit_texel(fit, t, x, x + fit->components, levels);
                enc_store_pack_texel(fit->units, fit->base->factors.units, levels, texels, t, out);
            } else {
#pragma omp critical(enc_factors_level)
                result = mine;
            }
        }
        free(x);
        free(levels);
    }
    return result == BTF_ERROR_MEMORY ? enc_fail(fit->context, result, "levels: out of memory") : result;
}

/* A level has no match: every texel is its own source, with a gain of 1. */
static bool fill_points(const enc_solution *base, enc_solution *level) {
    const size_t points = enc_solution_texels(level) * (size_t)level->n_views;
    if (!base->shift)
        return true;
    level->shift = calloc(points, 2 * sizeof *level->shift);
    level->gain = malloc(points);
    if (level->gain)
        memset(level->gain, (int)lrintf(1 / base->gain_scale), points);
    return level->shift && level->gain;
}

btf_result enc_factors_level(const enc_context *context, const enc_data *data, const enc_solution *base,
                             enc_solution *out_solution) {
    level_fit fit = {.context = context, .data = data, .base = base};
    *out_solution = enc_level_of(base, data->width, data->height);
    uint32_t *texels =
        calloc((size_t)base->factors.layers * enc_data_texel_count(data), ENC_STORE_WORDS * sizeof *texels);
    out_solution->factors.texels = texels;
    btf_result result = texels && fill_points(base, out_solution) ? prepare(&fit) : enc_fail(context, BTF_ERROR_MEMORY, "levels: out of memory");
    if (result == BTF_OK)
        result = fit_texels(&fit, texels);
    clear_fit(&fit);
    if (result != BTF_OK)
        enc_level_clear(out_solution);
    return result;
}
