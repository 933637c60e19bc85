/* The iterative fit of every texel: solve, leave out samples that look shadowed, solve again (paper 2.1).
 *
 * SPDX-License-Identifier: MIT
 */
#include "fit.h"
#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "shadow.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Texels handed to a thread at once; a fixed number, so that reading is blocked the same way always. */
enum { CHUNK = 16 };

/* At least this part of a texel's samples stays in the fit. */
static const double least_kept = 0.1;

/* What all texels share: l * v by component, and m(l), for every (view, light). */
typedef struct geometry {
    size_t n;
    float *memory;
    float *product[3], *multiplier;
} geometry;

static void geometry_free(geometry *g) {
    free(g->memory);
}

static btf_result geometry_make(const enc_data *data, bool square_root, geometry *out) {
    const size_t lights = (size_t)data->n_lights, n = (size_t)data->n_views * lights;
    float *memory = malloc(4 * n * sizeof *memory);
    if (!memory) {
        return BTF_ERROR_MEMORY;
    }
    *out = (geometry){.n = n, .memory = memory, .multiplier = memory + 3 * n};
    for (int k = 0; k < 3; k++) {
        out->product[k] = memory + (size_t)k * n;
    }
    for (size_t v = 0; v < (size_t)data->n_views; v++) {
        for (size_t l = 0; l < lights; l++) {
            const float *light = enc_data_light(data, v, l)->xyz;
            const float cosine = fmaxf(light[2], 0);
            for (int k = 0; k < 3; k++) {
                out->product[k][v * lights + l] = light[k] * data->views[v].xyz[k];
            }
            out->multiplier[v * lights + l] = square_root ? sqrtf(cosine) : cosine;
        }
    }
    return BTF_OK;
}

/* Memory of one thread. */
typedef struct worker {
    enc_fit_workspace *workspace;
    float *chunk;    /* CHUNK texels as read from the scratch file */
    float *memory;   /* all that follows */
    float *value[3]; /* the texel's samples, planar, in the fitted domain */
    float *kept[7];  /* compacted product, multiplier, value */
    float *model;    /* planar */
    bool *rejected;  /* [n] */
} worker;

static void worker_free(worker *w) {
    enc_fit_workspace_destroy(&w->workspace);
    free(w->chunk);
    free(w->memory);
    free(w->rejected);
}

static btf_result worker_make(const enc_data *data, size_t n, worker *out) {
    *out = (worker){0};
    const btf_result result = enc_fit_workspace_create(n, &out->workspace);
    if (result != BTF_OK) {
        return result;
    }
    out->chunk = data->samples ? NULL : malloc(CHUNK * enc_data_texel_stride(data) * sizeof(float));
    out->memory = malloc(13 * n * sizeof(float));
    out->rejected = malloc(n * sizeof(bool));
    if ((!data->samples && !out->chunk) || !out->memory || !out->rejected) {
        worker_free(out);
        return BTF_ERROR_MEMORY;
    }
    for (size_t k = 0; k < 3; k++) {
        out->value[k] = out->memory + k * n;
    }
    for (size_t k = 0; k < 7; k++) {
        out->kept[k] = out->memory + (3 + k) * n;
    }
    out->model = out->memory + 10 * n;
    return BTF_OK;
}

/* What one texel adds to the statistics. */
typedef struct texel_stats {
    double cost, core_seconds;
    uint32_t solves, evaluations, rejected, dead_lobes;
    bool diffuse, black;
} texel_stats;

/* Copies samples [view][channel][light] to planar [channel][view, light]; returns false when all are 0. */
static bool load_texel(const enc_data *data, const float *samples, bool square_root, worker *w) {
    const size_t lights = (size_t)data->n_lights;
    bool any = false;
    for (size_t v = 0; v < (size_t)data->n_views; v++) {
        for (size_t c = 0; c < 3; c++) {
            const float *from = samples + (v * 3 + c) * lights;
            float *to = w->value[c] + v * lights;
            for (size_t l = 0; l < lights; l++) {
                const float value = from[l] > 0 ? from[l] : 0;
                any = any || value > 0;
                to[l] = square_root ? sqrtf(value) : value;
            }
        }
    }
    return any;
}

/* Gathers the samples that are not rejected, planar. */
static enc_fit_samples keep_samples(const geometry *g, worker *w) {
    size_t n = 0;
    for (size_t i = 0; i < g->n; i++) {
        if (!w->rejected[i]) {
            for (int k = 0; k < 3; k++) {
                w->kept[k][n] = g->product[k][i];
                w->kept[4 + k][n] = w->value[k][i];
            }
            w->kept[3][n] = g->multiplier[i];
            n++;
        }
    }
    return (enc_fit_samples){
        .n = n,
        .product = {w->kept[0], w->kept[1], w->kept[2]},
        .multiplier = w->kept[3],
        .target = {w->kept[4], w->kept[5], w->kept[6]},
    };
}

/* Marks the samples that the model calls shadowed; returns how many, and through out_changed whether the
 * set differs from the one before. */
static size_t reject(const geometry *g, const enc_fit_options *options, const enc_sbrdf *sbrdf,
                     size_t texel, worker *w, bool *out_changed) {
    static const float one[3] = {1, 1, 1};
    const size_t n = g->n;
    enc_sbrdf_evaluate(sbrdf, texel, one, (int)n, g->product[0], g->product[1], g->product[2], w->model);
    size_t count = 0;
    *out_changed = false;
    for (size_t i = 0; i < n; i++) {
        float model[3], value[3];
        for (size_t c = 0; c < 3; c++) {
            model[c] = w->model[c * n + i] * g->multiplier[i];
            value[c] = w->value[c][i];
            if (options->square_root) {
                model[c] *= model[c];
                value[c] *= value[c];
            }
        }
        const bool shadowed =
            enc_is_shadowed(enc_luminance(model[0], model[1], model[2]),
                            enc_luminance(value[0], value[1], value[2]), options->t_error, options->t_btf);
        *out_changed = *out_changed || shadowed != w->rejected[i];
        w->rejected[i] = shadowed;
        count += shadowed;
    }
    return count;
}

static double thread_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static btf_result fit_texel(const enc_data *data, const geometry *g, const enc_fit_options *options,
                            const float *samples, enc_sbrdf *sbrdf, size_t texel, worker *w,
                            texel_stats *stats) {
    if (!load_texel(data, samples, options->square_root, w)) {
        stats->black = true;
        return BTF_OK;
    }
    const double begin = thread_seconds();
    float *parameters = sbrdf->values + texel * enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb);
    memset(w->rejected, 0, g->n * sizeof *w->rejected);
    size_t rejected = 0;
    for (int round = 0; round <= options->rounds; round++) {
        if (round > 0) {
            bool changed;
            const size_t now = reject(g, options, sbrdf, texel, w, &changed);
            if (!changed || (double)(g->n - now) < least_kept * (double)g->n) {
                break;
            }
            rejected = now;
        }
        const enc_fit_samples kept = keep_samples(g, w);
        float next[3 + 7 * ENC_MAX_LOBES];
        enc_fit_result fit;
        const btf_result result = enc_fit_texel(w->workspace, &kept, options, round > 0 ? parameters : NULL,
                                                round > 0 ? 0 : options->starts, next, &fit);
        if (result != BTF_OK) {
            return result;
        }
        memcpy(parameters, next, enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb) * sizeof *next);
        stats->cost = fit.cost;
        stats->solves++;
        stats->evaluations += (uint32_t)fit.evaluations;
        stats->diffuse = fit.diffuse;
        stats->dead_lobes = fit.diffuse ? 0 : (uint32_t)fit.dead_lobes;
    }
    stats->rejected = (uint32_t)rejected;
    stats->core_seconds = thread_seconds() - begin;
    return BTF_OK;
}

static btf_result fit_chunk(const enc_context *context, const enc_data *data, const geometry *g,
                            const enc_fit_options *options, size_t first, size_t end, enc_sbrdf *sbrdf,
                            worker *w, texel_stats *stats) {
    const size_t count = first + CHUNK < end ? CHUNK : end - first;
    const float *samples;
    btf_result result = enc_data_texels(context, data, first, count, w->chunk, &samples);
    for (size_t i = 0; i < count && result == BTF_OK; i++) {
        result = fit_texel(data, g, options, samples + i * enc_data_texel_stride(data), sbrdf, first + i, w,
                           stats + first + i);
    }
    enc_stage_step(context, count);
    return result;
}

static void add_stats(const texel_stats *stats, size_t texels, size_t samples, enc_fit_stats *out) {
    *out = (enc_fit_stats){.texels = texels, .samples = (uint64_t)texels * samples};
    for (size_t i = 0; i < texels; i++) {
        out->cost += stats[i].cost;
        out->core_seconds += stats[i].core_seconds;
        out->solves += stats[i].solves;
        out->evaluations += stats[i].evaluations;
        out->rejected += stats[i].rejected;
        out->dead_lobes += stats[i].dead_lobes;
        out->fallbacks += stats[i].diffuse;
        out->black += stats[i].black;
    }
}

static btf_result check_options(const enc_context *context, const enc_fit_options *options) {
    if (options->lobes < 1 || options->lobes > ENC_MAX_LOBES) {
        return enc_fail(context, BTF_ERROR_USAGE, "fit: %d lobes, expected 1 to %d", options->lobes,
                        ENC_MAX_LOBES);
    }
    if (options->starts < 1 || options->starts > ENC_FIT_MAX_STARTS) {
        return enc_fail(context, BTF_ERROR_USAGE, "fit: %d starts, expected 1 to %d", options->starts,
                        ENC_FIT_MAX_STARTS);
    }
    if (options->rounds < 0 || options->max_evaluations < 1 || !(options->tolerance >= 0)) {
        return enc_fail(context, BTF_ERROR_USAGE,
                        "fit: %d rounds, %d evaluations and tolerance %g, expected at least 0, 1 and 0",
                        options->rounds, options->max_evaluations, options->tolerance);
    }
    if (!(options->t_error >= 0) || !(options->t_btf >= 0)) {
        return enc_fail(context, BTF_ERROR_USAGE, "fit: thresholds %g and %g, expected at least 0",
                        (double)options->t_error, (double)options->t_btf);
    }
    return BTF_OK;
}

btf_result enc_fit(const enc_context *context, const enc_data *data, const enc_fit_options *options,
                   enc_sbrdf **out_sbrdf, enc_fit_stats *out_stats) {
    *out_sbrdf = NULL;
    btf_result result = check_options(context, options);
    if (result != BTF_OK) {
        return result;
    }
    const size_t texels = enc_data_texel_count(data);
    geometry g = {0};
    enc_sbrdf *sbrdf = NULL;
    texel_stats *stats = calloc(texels, sizeof *stats);
    result = !stats ? BTF_ERROR_MEMORY : geometry_make(data, options->square_root, &g);
    if (result == BTF_OK) {
        result = enc_sbrdf_create(texels, options->lobes, options->rgb, &sbrdf);
    }
    if (result == BTF_OK) {
        size_t begin, end;
        enc_ranks_range(context, texels, &begin, &end);
        enc_stage_begin(context, "fit", end - begin);
#pragma omp parallel num_threads(context->threads)
        {
            worker w;
            btf_result mine = worker_make(data, g.n, &w);
#pragma omp for schedule(dynamic, 1)
            for (size_t first = begin; first < end; first += CHUNK) {
                if (mine == BTF_OK) {
                    mine = enc_cancelled(context)
                               ? BTF_ERROR_INTERRUPTED
                               : fit_chunk(context, data, &g, options, first, end, sbrdf, &w, stats);
                }
            }
            worker_free(&w);
            enc_keep_worse(&result, mine);
        }
        const size_t stride = enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb);
        result = enc_ranks_gather(context, result, sbrdf->values, stride * sizeof *sbrdf->values, texels);
        result = enc_ranks_gather(context, result, stats, sizeof *stats, texels);
        enc_stage_end(context);
    }
    if (result == BTF_OK && out_stats) {
        add_stats(stats, texels, g.n, out_stats);
    }
    free(stats);
    geometry_free(&g);
    if (result != BTF_OK) {
        enc_sbrdf_destroy(&sbrdf);
        return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "fit: out of memory") : result;
    }
    *out_sbrdf = sbrdf;
    return BTF_OK;
}
