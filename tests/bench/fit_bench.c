/* Times our fit and Ceres with automatic derivatives on the same samples. See fit_bench.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fit_bench.h"
#include "encoder/lafortune/ceres_bridge.h"
#include "encoder/lafortune/texel_fit.h"
#include <math.h>
#include <stdlib.h>
#include <time.h>

enum { LOBES = ENC_CERES_AUTODIFF_LOBES, STRIDE = 4 + 4 * LOBES };

static const double ceres_tolerance = 1e-6;

typedef struct bench {
    const enc_data *data;
    size_t n;
    float *memory;
    float *product[3], *multiplier, *target[3], *model;
    enc_fit_workspace *workspace;
} bench;

static double thread_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static btf_result bench_make(const enc_data *data, bench *b) {
    const size_t lights = (size_t)data->n_lights, n = (size_t)data->n_views * lights;
    *b = (bench){.data = data, .n = n, .memory = malloc(10 * n * sizeof(float))};
    if (b->memory == NULL) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t k = 0; k < 3; k++) {
        b->product[k] = b->memory + k * n;
        b->target[k] = b->memory + (4 + k) * n;
    }
    b->multiplier = b->memory + 3 * n;
    b->model = b->memory + 7 * n;
    for (size_t i = 0; i < n; i++) {
        const float *light = data->lights[i % lights].xyz, *view = data->views[i / lights].xyz;
        for (int k = 0; k < 3; k++) {
            b->product[k][i] = light[k] * view[k];
        }
        b->multiplier[i] = fmaxf(light[2], 0);
    }
    return enc_fit_workspace_create(n, &b->workspace);
}

static void load_texel(bench *b, const float *samples) {
    const size_t lights = (size_t)b->data->n_lights;
    for (size_t i = 0; i < b->n; i++) {
        for (size_t c = 0; c < 3; c++) {
            b->target[c][i] = samples[(i / lights * 3 + c) * lights + i % lights];
        }
    }
}

/* The first fixed start, its colour solved for these samples. */
static btf_result make_start(bench *b, double parameters[STRIDE]) {
    static const float one[3] = {1, 1, 1};
    enc_sbrdf *start;
    const btf_result result = enc_sbrdf_create(1, LOBES, false, &start);
    if (result != BTF_OK) {
        return result;
    }
    enc_fit_fixed_start(0, LOBES, start->values);
    enc_sbrdf_evaluate(start, 0, one, (int)b->n, b->product[0], b->product[1], b->product[2], b->model);
    for (int i = 3; i < STRIDE; i++) {
        parameters[i] = (double)start->values[i];
    }
    for (size_t c = 0; c < 3; c++) {
        double mm = 0, mt = 0;
        for (size_t i = 0; i < b->n; i++) {
            const double m = (double)b->model[i] * (double)b->multiplier[i];
            mm += m * m;
            mt += m * (double)b->target[c][i];
        }
        parameters[c] = mm > 0 ? mt / mm : 0;
    }
    enc_sbrdf_destroy(&start);
    return BTF_OK;
}

static btf_result time_fit(bench *b, int starts, double *out_seconds, double *out_cost) {
    const enc_fit_options options = enc_fit_options_default();
    const enc_fit_samples samples = {
        .n = b->n,
        .product = {b->product[0], b->product[1], b->product[2]},
        .multiplier = b->multiplier,
        .target = {b->target[0], b->target[1], b->target[2]},
    };
    float parameters[STRIDE];
    enc_fit_result fit;
    const double begin = thread_seconds();
    const btf_result result =
        enc_fit_texel(b->workspace, &samples, &options, NULL, starts, parameters, &fit);
    *out_seconds = thread_seconds() - begin;
    *out_cost = fit.cost;
    return result;
}

static btf_result bench_texel(const enc_context *context, bench *b, size_t texel, FILE *csv,
                              bench_fit_summary *sum) {
    double parameters[STRIDE], ceres_cost, single_seconds, single_cost, full_seconds, full_cost;
    int iterations;
    btf_result result = make_start(b, parameters);
    if (result != BTF_OK) {
        return result;
    }
    const double begin = thread_seconds();
    if (!enc_ceres_autodiff_fit(b->n, (const float *const *)b->product, b->multiplier,
                                (const float *const *)b->target, ENC_FIT_MIN_N, ENC_FIT_MAX_N,
                                ENC_FIT_MAX_C, ceres_tolerance, parameters, &ceres_cost, &iterations)) {
        return enc_fail(context, BTF_ERROR_INTERNAL, "bench: Ceres failed on texel %zu", texel);
    }
    const double ceres_seconds = thread_seconds() - begin;
    result = time_fit(b, 1, &single_seconds, &single_cost);
    if (result == BTF_OK) {
        result = time_fit(b, enc_fit_options_default().starts, &full_seconds, &full_cost);
    }
    if (result != BTF_OK) {
        return result;
    }
    sum->texels++;
    sum->ceres_seconds += ceres_seconds;
    sum->ceres_cost += ceres_cost;
    sum->single_seconds += single_seconds;
    sum->single_cost += single_cost;
    sum->full_seconds += full_seconds;
    sum->full_cost += full_cost;
    if (ceres_cost > 0) {
        sum->worst_ratio = fmax(sum->worst_ratio, full_cost / ceres_cost);
    }
    if (csv != NULL) {
        fprintf(csv, "%zu,%d,%.6f,%.6g,%.6f,%.6g,%.6f,%.6g\n", texel, iterations, ceres_seconds, ceres_cost,
                single_seconds, single_cost, full_seconds, full_cost);
    }
    return BTF_OK;
}

btf_result bench_fit(const enc_context *context, const enc_data *data, int texels, FILE *csv,
                     bench_fit_summary *out_summary) {
    *out_summary = (bench_fit_summary){0};
    const size_t count = enc_data_texel_count(data);
    if (texels < 1) {
        return enc_fail(context, BTF_ERROR_USAGE, "bench: %d texels, expected at least 1", texels);
    }
    bench b;
    float *buffer = malloc(enc_data_texel_stride(data) * sizeof *buffer);
    btf_result result = bench_make(data, &b);
    if (result == BTF_OK && buffer == NULL) {
        result = BTF_ERROR_MEMORY;
    }
    if (csv != NULL) {
        fprintf(csv, "texel,ceres_iterations,ceres_s,ceres_cost,single_s,single_cost,full_s,full_cost\n");
    }
    const size_t wanted = (size_t)texels < count ? (size_t)texels : count;
    for (size_t i = 0; i < wanted && result == BTF_OK; i++) {
        const size_t texel = (2 * i + 1) * count / (2 * wanted);
        const float *samples;
        result = enc_cancelled(context) ? BTF_ERROR_INTERRUPTED
                                        : enc_data_texels(context, data, texel, 1, buffer, &samples);
        if (result == BTF_OK) {
            load_texel(&b, samples);
            result = bench_texel(context, &b, texel, csv, out_summary);
        }
    }
    enc_fit_workspace_destroy(&b.workspace);
    free(b.memory);
    free(buffer);
    return result;
}
