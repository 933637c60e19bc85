/* Budgets, trials and the solution. See method.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "method.h"

#include "factor.h"

#include "encoder/allocation/quality.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

_Static_assert((int)ENC_FACTOR_CLASSES == (int)BTF_FACTOR_CLASSES &&
                   (int)ENC_FACTOR_TIERS == (int)ENC_STORE_TIERS,
               "two names of one number");

/* 1 / l.z of the outermost light (FORMAT.md section 9, Factors), in float as decoders read it. */
static float horizon_scale(const enc_data *data) {
    float least = 1;
    for (int l = 0; l < data->n_lights; l++) {
        least = fminf(least, data->lights[l].xyz[2]);
    }
    const float scale = 1 / least;
    return fminf(fmaxf(scale, 1.0f), 0x1p24f);
}

/* Scales of weak components may be less than files can hold, while the views' factors are about 1. So
 * scales are multiplied by this and factors divided by it, which changes no bit of a decoded value. */
static const float balance = 0x1p12f;

/* The number that a file holds for x: 0 for magnitudes below the least it may hold. */
static float parameter(float x) {
    return fabsf(x) >= 0x1p-24f ? x : 0;
}

static void balance_scales(float *scales, size_t units) {
    for (size_t i = 0; i < ENC_STORE_WORDS * units; i++) {
        scales[i] = parameter(scales[i] * balance);
    }
}

static float *balance_views(const float *views, size_t count) {
    float *out = calloc(count * ENC_STORE_TIERS, 4 * sizeof *out);
    for (size_t i = 0; out && i < 3 * count * ENC_STORE_TIERS; i++) {
        out[i / 3 * 4 + i % 3] = parameter(views[i] / balance);
    }
    return out;
}

/* Moves the arrays of *io_factors to a solution. */
static btf_result to_solution(const enc_context *context, const enc_data *data, enc_factors **io_factors,
                              enc_solution *out) {
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
        out->effects |= BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN;
        out->packed = true;
        out->point_entries = f->point_entries;
        out->gain_scale = 1; /* not read */
        out->gain_base = f->gain_base;
        out->gain_step = f->gain_step;
        out->shift = f->shift;
        out->gain = f->gain;
        f->shift = NULL;
        f->gain = NULL;
    }
    out->factors.views = balance_views(f->views, (size_t)data->n_views);
    balance_scales(f->scales, (size_t)f->n_units);
    out->factors.texels = f->texels;
    out->factors.directions = f->directions;
    out->factors.scales = f->scales;
    f->texels = f->directions = NULL;
    f->scales = NULL;
    enc_factors_destroy(io_factors);
    if (out->factors.views) {
        return BTF_OK;
    }
    enc_solution_clear(out);
    return enc_fail(context, BTF_ERROR_MEMORY, "factors: out of memory");
}

/* Quality.
 * ------------------------------------------------------------------------------------------------ */

static double psnr(double mean) {
    return mean > 1e-10 ? -10 * log10(mean) : 100;
}

/* Bytes of an encode's textures without the tables, as reports count them. */
static uint64_t gpu_bytes(const enc_data *data, uint64_t bytes, int n_units) {
    const uint64_t tables = 16 * ((uint64_t)n_units + ENC_STORE_TIERS * (uint64_t)data->n_views);
    return bytes > tables ? bytes - tables : 0;
}

static const char *const verdicts[ENC_FACTOR_OMISSIONS] = {
    "left out", "given up after a first search, which left too much error",
    "not tried: it needs more memory than is allowed",
    "not tried: the budget does not hold its lists and one unit of factors"};

/* Records the candidates of an encode; *out_kept: the one that was kept. An encode that may yet turn out the best has
 * the verdict `left out` until all are made. */
static void note_trials(const enc_data *data, const enc_factors *f, bool measured, enc_factors_stats *stats,
                        int *out_kept) {
    for (int i = 0; i < f->n_trials; i++) {
        const enc_factor_trial *t = &f->trials[i];
        if (t->kept) {
            *out_kept = stats->trials_count;
        }
        stats->trials[stats->trials_count++] =
            (enc_trial){.effects = BTF_EFFECT_RESIDUAL | (t->match ? BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN : 0),
                        .components = t->n_units,
                        .gpu_bytes = gpu_bytes(data, t->bytes, t->n_units),
                        .psnr = measured && !t->omitted ? psnr(t->error.srgb) : NAN,
                        .core_seconds = t->core_seconds,
                        .verdict = verdicts[t->omitted]};
    }
}

/* Encodes within a budget, and records its candidates as trials; *out_kept: the one that it kept. basis: the
 * components that all encodes for one quality share. */
static btf_result encode(const enc_context *context, const enc_data *data,
                         const enc_factors_settings *settings, uint64_t budget, enc_components basis[3],
                         enc_factors **out, enc_factors_stats *stats, int *out_kept) {
    const bool match = settings->effects & BTF_EFFECT_SHIFT;
    const enc_factor_options options = {
        .budget = budget,
        .sweeps = settings->sweeps,
        .match = settings->choose ? ENC_FACTOR_CHOOSE_MATCH
                 : match          ? ENC_FACTOR_MATCH
                                  : ENC_FACTOR_NO_MATCH,
        .gain = settings->choose || settings->effects & BTF_EFFECT_GAIN,
        .tolerance = settings->quality > 0 ? 0 : settings->tolerance, /* a quality has a stop of its own */
        .measure = settings->quality > 0,
        .number = stats->encodes++,
        .basis = settings->quality > 0 ? basis : NULL};
    const btf_result result = enc_factor_encode(context, data, &options, out);
    if (result != BTF_OK) {
        return result;
    }
    const enc_factors *f = *out;
    stats->unspent = f->unspent;
    const bool chosen = f->n_trials > 1 && f->trials[1].omitted != ENC_FACTOR_NO_MEMORY;
    note_trials(data, f, settings->quality > 0 || chosen, stats, out_kept);
    enc_log(context, BTF_LOG_INFO,
            "factors: %zu components of Y, %zu of C1 and %zu of C2, in %d units%s, take %llu bytes",
            f->components[0], f->components[1], f->components[2], f->n_units,
            f->shift ? " with shifts and gains" : "",
            (unsigned long long)gpu_bytes(data, f->bytes, f->n_units));
    return BTF_OK;
}

/* Replaces *io_best, the encode of trial `best`, by one of fewer bytes that reaches the quality, too. */
static btf_result reduce(const enc_context *context, const enc_data *data,
                         const enc_factors_settings *settings, enc_components basis[3],
                         enc_factors **io_best, enc_factors_stats *stats, int *io_best_trial) {
    const uint64_t lists = (*io_best)->match_bytes, most = (*io_best)->bytes - lists;
    const uint64_t least =
        enc_factor_least_budget(data->width, data->height, data->n_views, data->n_lights);
    const enc_factor_energies energies = enc_components_energies(basis);
    enc_quality_search search;
    btf_result result = enc_quality_begin(&energies, enc_data_texel_count(data), (size_t)data->n_views,
                                          (size_t)data->n_lights, most, least, settings->quality,
                                          psnr((*io_best)->error.srgb), &search)
                            ? BTF_OK
                            : enc_fail(context, BTF_ERROR_MEMORY, "factors: out of memory");
    for (int i = 0; i < ENC_FACTORS_TRIALS && result == BTF_OK; i++) {
        const size_t next = enc_quality_next(&search);
        enc_factors *trial = NULL;
        int kept = 0;
        if (next == search.count) {
            break;
        }
        result = encode(context, data, settings, search.budget[next] + lists, basis, &trial, stats, &kept);
        if (result != BTF_OK) {
            return result;
        }
        enc_quality_note(&search, next, psnr(trial->error.srgb));
        if (search.reaches == next) {
            enc_factors_destroy(io_best);
            *io_best = trial;
            *io_best_trial = kept;
        } else {
            enc_factors_destroy(&trial);
        }
    }
    return result;
}

btf_result enc_factors_solve(const enc_context *context, const enc_data *data,
                             const enc_factors_settings *settings, enc_solution *out_solution,
                             enc_factors_stats *out_stats) {
    enc_factors_settings now = *settings;
    enc_components basis[ENC_FACTOR_CHANNELS] = {{0}};
    enc_factors *best = NULL;
    int best_trial = 0;
    *out_solution = (enc_solution){0};
    *out_stats = (enc_factors_stats){0};
    btf_result result = encode(context, data, &now, now.budget, basis, &best, out_stats, &best_trial);
    if (result == BTF_OK && settings->quality > 0) {
        const double reached = psnr(best->error.srgb);
        now.choose = false; /* a smaller budget keeps the choice made at the whole one */
        now.effects = settings->choose ? out_stats->trials[best_trial].effects : settings->effects;
        if (reached >= settings->quality) {
            result = reduce(context, data, &now, basis, &best, out_stats, &best_trial);
        } else {
            enc_log(context, BTF_LOG_WARNING,
                    "factors: %.2f dB is the best that was found, below --quality %.2f, within %llu bytes "
                    "(--budget)",
                    reached, settings->quality, (unsigned long long)settings->budget);
        }
    }
    if (result == BTF_OK) {
        out_stats->trials[best_trial].verdict = "best";
        result = to_solution(context, data, &best, out_solution);
    }
    enc_factors_destroy(&best);
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        enc_components_clear(&basis[c]);
    }
    return result;
}
