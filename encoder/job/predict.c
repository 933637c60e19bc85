/* What an encode will take, told without encoding. See predict.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "predict.h"

#include "encoder/data/extent.h"
#include "cost.h"
#include "decoder/toolkit/progress.h"
#include "encoder/math/gemm.h"
#include "memory.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { REPORT_BYTES = 8 << 20, NAME = 64, PRODUCT = 192, ROOTS = 1 << 22 };

/* Core seconds on the machine of the cost model: of a product of PRODUCT^3, of ROOTS square roots in
 * memory. */
static const double product_seconds = 0.16e-3, root_seconds = 3.6e-3;

/* Core seconds of a measured run by stage. */
typedef struct times {
    struct {
        char stage[NAME];
        double seconds;
    } of[2 * ESTIMATE_PARTS];
    size_t count;
} times;

static double time_of(const times *t, const char *stage) {
    for (size_t i = 0; i < t->count; i++)
        if (strcmp(t->of[i].stage, stage) == 0)
            return t->of[i].seconds;
    return NAN;
}

/* The whole file as text; the caller frees. NULL: not to be read, errno says why. */
static char *read_text(const char *path) {
    FILE *file = fopen(path, "r");
    char *text = file ? malloc(REPORT_BYTES) : NULL;
    if (text) {
        text[fread(text, 1, REPORT_BYTES - 1, file)] = '\0';
        if (ferror(file)) {
            free(text);
            text = NULL;
        }
    }
    if (file)
        fclose(file);
    return text;
}

/* The members of the object called `name` in the text of a report; false where there is none, or one of
 * them is no number. */
static bool take_times(const char *text, const char *name, times *out) {
    char key[NAME];
    snprintf(key, sizeof key, "\"%s\": {", name);
    const char *at = strstr(text, key);
    *out = (times){0};
    if (!at)
        return false;
    at += strlen(key);
    while (out->count < 2 * ESTIMATE_PARTS) {
        int used = 0;
        char *end;
        if (sscanf(at, " \"%63[^\"]\": %n", out->of[out->count].stage, &used) != 1 || used == 0)
            break;
        out->of[out->count].seconds = strtod(at + used, &end);
        if (end == at + used || !(out->of[out->count].seconds >= 0))
            return false;
        out->count++;
        at = end + strspn(end, " ,\n\r\t");
    }
    return *at == '}' && out->count > 0;
}

/* How much more time a stage takes than the model says. */
typedef struct scales {
    times measured, predicted;
    double all;
} scales;

static double scale_of(const scales *s, const char *stage) {
    const double measured = time_of(&s->measured, stage), predicted = time_of(&s->predicted, stage);
    if (predicted > 0 && isnan(measured))
        return 0;                                               /* there, it was not needed */
    const double least = 2e-3 * time_of(&s->measured, "total"); /* what is too short to be measured well */
    return measured > least && predicted > 0 ? measured / predicted : s->all;
}

static btf_result scales_of_report(const enc_context *context, const enc_job *job, const char *path,
                                   scales *out) {
    char *text = read_text(path), method[NAME];
    btf_result result = text ? BTF_OK : enc_fail(context, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    snprintf(method, sizeof method, "\"method\": \"%s\"",
             job->method == ENC_METHOD_PAPER ? "paper" : "joint");
    if (result == BTF_OK && (!take_times(text, "core_seconds", &out->measured) ||
                             !take_times(text, "predicted_core_seconds", &out->predicted)))
        result = enc_fail(context, BTF_ERROR_BAD_FILE,
                          "%s: no report of btf-encode with core seconds by stage", path);
    if (result == BTF_OK && !strstr(text, method))
        result = enc_fail(context, BTF_ERROR_USAGE, "%s: of another method", path);
    double sum = 0;
    for (size_t i = 0; i < out->predicted.count; i++)
        if (!isnan(time_of(&out->measured, out->predicted.of[i].stage)))
            sum += out->predicted.of[i].seconds;
    out->all = time_of(&out->measured, "total") / sum;
    if (result == BTF_OK && !(out->all > 0 && isfinite(out->all)))
        result = enc_fail(context, BTF_ERROR_BAD_FILE, "%s: took no time", path);
    free(text);
    return result;
}

/* The machine by a product that stays in the cache and roots that do not. */
static btf_result measure_machine(const enc_context *context, scales *out) {
    const enc_gemm_tile tile = enc_gemm_select();
    const size_t rows = enc_gemm_panels(PRODUCT, ENC_GEMM_M) * ENC_GEMM_M,
                 columns = enc_gemm_panels(PRODUCT, ENC_GEMM_N) * ENC_GEMM_N;
    float *a = enc_gemm_alloc(rows * PRODUCT), *b = enc_gemm_alloc(columns * PRODUCT),
          *c = enc_gemm_alloc(PRODUCT * PRODUCT), *roots = enc_gemm_alloc(ROOTS);
    double product = 0, root = 0;
    int products = 0, passes = 0;
    const bool ok = a && b && c && roots;
    for (size_t i = 0; ok && i < rows * PRODUCT; i++)
        a[i] = (float)(i % 7);
    for (size_t i = 0; ok && i < columns * PRODUCT; i++)
        b[i] = (float)(i % 5);
    for (size_t i = 0; ok && i < ROOTS; i++)
        roots[i] = (float)i;
    for (double begin = progress_core_clock(); ok && product < 0.4; products++) {
        enc_gemm_multiply(tile, PRODUCT, PRODUCT, PRODUCT, a, b, c, PRODUCT, 0);
        product = progress_core_clock() - begin;
    }
    for (double begin = progress_core_clock(); ok && root < 0.4; passes++) {
        for (size_t i = 0; i < ROOTS; i++)
            roots[i] = sqrtf(roots[i]);
        root = progress_core_clock() - begin;
    }
    if (ok)
        out->all = 0.5 * (product / products / product_seconds + root / passes / root_seconds);
    free(a);
    free(b);
    free(c);
    free(roots);
    return ok ? BTF_OK : enc_fail(context, BTF_ERROR_MEMORY, "prediction: out of memory");
}

static btf_result take_extent(void *user, const enc_context *context, const enc_extent *extent) {
    (void)context;
    *(enc_extent *)user = *extent;
    return BTF_ERROR_INTERRUPTED; /* nothing is read */
}

static void print_duration(FILE *out, double seconds) {
    if (seconds < 600)
        fprintf(out, "%.1f s", seconds);
    else if (seconds < 36000)
        fprintf(out, "%.0f min", seconds / 60);
    else
        fprintf(out, "%.1f h", seconds / 3600);
}

static void print_prediction(const enc_context *context, const enc_job *job, const enc_extent *e,
                             const scales *s, FILE *out) {
    estimate_part parts[ESTIMATE_PARTS];
    const size_t count = enc_cost_parts(context, job, e, parts),
                 components = enc_cost_components(job, e, true);
    const enc_memory_use use = enc_memory_expected(context, job->method, e->width, e->height, e->n_views,
                                                   e->n_lights, components, e->origin == ENC_ORIGIN_BONN);
    const uint64_t least =
        enc_memory_least(job->method)(e->width, e->height, e->n_views, e->n_lights, context->threads);
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
    fprintf(out, "\n  memory: --memory from %.3fG on; with %.3fG %.3f GB expected, scratch files %.3f GB\n",
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
    if (result != BTF_OK)
        return result;
    result = enc_read(&reading, job->input, &job->read, &data);
    enc_data_destroy(&data);
    if (result == BTF_ERROR_INTERRUPTED && extent.width > 0) {
        print_prediction(context, job, &extent, &s, out);
        result = BTF_OK;
    }
    return result;
}
