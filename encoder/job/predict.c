/* Predicts the time and memory of an encode. See predict.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "predict.h"

#include "cost.h"
#include "decoder/toolkit/progress.h"
#include "encoder/data/data.h"
#include "encoder/data/extent.h"
#include "encoder/math/gemm.h"
#include "encoder/report/stage_times.h"
#include "memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PRODUCT = 192, ROOTS = 1 << 22 };

/* Core seconds on the machine to which cost.c was fitted: a matrix product of PRODUCT^3, and ROOTS square
 * roots in memory. Medians of four runs while it was idle, where encodes of 32x32 and 64x64 texels by both
 * methods took what the model says within a fifth. */
static const double product_seconds = 0.0734e-3, root_seconds = 0.78e-3;

/* Factors from the model's times to those of this machine, stage by stage. */
typedef struct scales {
    enc_report_times report; /* of the encode that the scales come from; empty where this machine was
                                measured */
    double all;              /* for stages that the report does not list */
} scales;

static double scale_of(const scales *s, const char *stage) {
    const enc_stage_times *measured = &s->report.measured;
    const double took = enc_stage_time(measured, stage),
                 predicted = enc_stage_time(&s->report.predicted, stage);
    if (predicted > 0 && isnan(took)) {
        return 0; /* the report's encode did not need it */
    }
    const double least =
        2e-3 * enc_stage_time(measured, "total"); /* shorter stages are not measured well */
    return took > least && predicted > 0 ? took / predicted : s->all;
}

static btf_result scales_of_report(const enc_context *context, const enc_job *job, const char *path,
                                   scales *out) {
    const char *method = enc_method_name(job->method);
    const enc_stage_times *measured = &out->report.measured, *predicted = &out->report.predicted;
    const btf_result result = enc_report_times_read(context, path, &out->report);
    if (result != BTF_OK) {
        return result;
    }
    if (strcmp(out->report.method, method) != 0) {
        return enc_fail(
            context, BTF_ERROR_USAGE,
            "%s: is the report of an encode by --method %s, but the prediction is for --method %s", path,
            out->report.method, method);
    }
    double sum = 0;
    for (size_t i = 0; i < predicted->count; i++) {
        if (!isnan(enc_stage_time(measured, predicted->of[i].stage))) {
            sum += predicted->of[i].seconds;
        }
    }
    out->all = enc_stage_time(measured, "total") / sum;
    if (!(out->all > 0 && isfinite(out->all))) {
        return enc_fail(context, BTF_ERROR_BAD_FILE,
                        "%s: core_seconds.total is 0, or no stage is both measured and predicted", path);
    }
    return BTF_OK;
}

/* Measures this machine by a product that stays in the cache and square roots that do not. */
static btf_result measure_machine(const enc_context *context, scales *out) {
    const enc_gemm_tile tile = enc_gemm_select();
    const size_t rows = enc_gemm_panels(PRODUCT, ENC_GEMM_M) * ENC_GEMM_M,
                 columns = enc_gemm_panels(PRODUCT, ENC_GEMM_N) * ENC_GEMM_N;
    float *a = enc_gemm_alloc(rows * PRODUCT), *b = enc_gemm_alloc(columns * PRODUCT),
          *c = enc_gemm_alloc(PRODUCT * PRODUCT), *roots = enc_gemm_alloc(ROOTS);
    double product = 0, root = 0;
    int products = 0, passes = 0;
    const bool ok = a && b && c && roots;
    for (size_t i = 0; ok && i < rows * PRODUCT; i++) {
        a[i] = (float)(i % 7);
    }
    for (size_t i = 0; ok && i < columns * PRODUCT; i++) {
        b[i] = (float)(i % 5);
    }
    for (size_t i = 0; ok && i < ROOTS; i++) {
        roots[i] = (float)i;
    }
    for (double begin = progress_core_clock(); ok && product < 0.4; products++) {
        enc_gemm_multiply(tile, PRODUCT, PRODUCT, PRODUCT, a, b, c, PRODUCT, 0);
        product = progress_core_clock() - begin;
    }
    for (double begin = progress_core_clock(); ok && root < 0.4; passes++) {
        for (size_t i = 0; i < ROOTS; i++) {
            roots[i] = sqrtf(roots[i]);
        }
        root = progress_core_clock() - begin;
    }
    if (ok) {
        out->all = 0.5 * (product / products / product_seconds + root / passes / root_seconds);
    }
    free(a);
    free(b);
    free(c);
    free(roots);
    return ok ? BTF_OK : enc_fail(context, BTF_ERROR_MEMORY, "prediction: out of memory");
}

static btf_result take_extent(void *user, const enc_context *context, const enc_extent *extent) {
    (void)context;
    *(enc_extent *)user = *extent;
    return BTF_ERROR_INTERRUPTED; /* ends the reading before the samples are read */
}

static void print_duration(FILE *out, double seconds) {
    if (seconds < 600) {
        fprintf(out, "%.1f s", seconds);
    } else if (seconds < 36000) {
        fprintf(out, "%.0f min", seconds / 60);
    } else {
        fprintf(out, "%.1f h", seconds / 3600);
    }
}

static void print_prediction(const enc_context *context, const enc_job *job, const enc_extent *e,
                             const scales *s, FILE *out) {
    estimate_part parts[ESTIMATE_PARTS];
    const size_t count = enc_cost_parts(context, job, e, parts);
    const uint64_t budget =
        enc_settings_of_factors(job, e->width, e->height, e->n_views, e->n_lights).budget;
    enc_memory_use use =
        enc_memory_expected(context, job->method, e->width, e->height, e->n_views, e->n_lights, budget,
                            e->origin == ENC_ORIGIN_BONN, job->fit == ENC_FIT_BETWEEN);
    if (enc_settings_try_relief(job) && job->relief.relief &&
        enc_data_fits(context, e->width, e->height, e->n_views, e->n_lights)) {
        /* relief is looked for beside the samples, which may take more than all later stages */
        const uint64_t relief = enc_extent_bytes(e) + enc_relief_memory(e->width, e->height, e->n_views, e->n_lights);
        use.peak = relief > use.peak ? relief : use.peak;
    }
    const uint64_t least =
        job->method == ENC_METHOD_JOINT
            ? enc_memory_of_factors(e->width, e->height, e->n_views, e->n_lights, context->threads, budget)
            : enc_memory_least(job->method)(e->width, e->height, e->n_views, e->n_lights, context->threads);
    double total = 0;
    fprintf(out, "%s: %d x %d texels, %d views, %d lights: %.2f GB of samples\n", job->input, e->width,
            e->height, e->n_views, e->n_lights, (double)enc_extent_bytes(e) * 1e-9);
    for (size_t i = 0; i < count; i++) {
        const double seconds = parts[i].cost * scale_of(s, parts[i].stage);
        fprintf(out, "  %-18s %10.1f core s\n", parts[i].stage, seconds);
        total += seconds;
    }
    fprintf(out, "  %-18s %10.1f core s", "total", total);
    fprintf(out, "; on %d idle cores at least ", context->threads);
    print_duration(out, total / context->threads);
    fprintf(out,
            "\n"
            "  memory: needs --memory %.3fG at least; with %.3fG it is expected to use %.3f GB, and %.3f "
            "GB in scratch files\n",
            (double)least * 1e-9, (double)context->memory * 1e-9, (double)use.peak * 1e-9,
            (double)use.scratch * 1e-9);
}

btf_result enc_predict(const enc_context *context, const enc_job *job, const char *from, FILE *out) {
    enc_extent extent = {0};
    enc_data *data = NULL;
    scales s = {.all = 1};
    const enc_extent_listener listener = {take_extent, &extent};
    enc_context reading = *context;
    reading.listener = &listener;
    reading.least_memory = enc_memory_least(job->method);
    btf_result result =
        strcmp(from, "self") == 0 ? measure_machine(context, &s) : scales_of_report(context, job, from, &s);
    if (result != BTF_OK) {
        return result;
    }
    result = enc_read(&reading, job->input, &job->read, &data);
    enc_data_destroy(&data);
    if (result == BTF_ERROR_INTERRUPTED && extent.width > 0) {
        print_prediction(context, job, &extent, &s, out);
        result = BTF_OK;
    }
    return result;
}
