/* Section `machine`: what the processor and its memory could do at best, and how near the places come where
 * an encode spends most of its time.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"

#include "encoder/lafortune/gram.h"
#include "encoder/joint/rows.h"
#include "encoder/joint/search.h"

#include "tests/conformance/random.h"

#include <openbtf/material.h>
#include <stdlib.h>

/* Rates are work over core time, times the threads: what the clock would show on a machine of our own.
 * ------------------------------------------------------------------------------------------------ */

/* Operations a second of the joint method's tile on operands that fit the first-level cache: k components,
 * all threads, best of some tries. 0: out of memory. */
static double tile_rate(int threads, size_t k) {
    enum { TRIES = 5, CALLS = 40000 };
    const enc_gemm_tile tile = enc_gemm_select();
    double best = 0;
    bool room = true;
    for (int try = 0; try < TRIES && room; try++) {
        const bench_clock start = bench_now();
#pragma omp parallel num_threads(threads)
        {
            float *a = enc_gemm_alloc(ENC_GEMM_M * k), *b = enc_gemm_alloc(ENC_GEMM_N * k);
            float *out = enc_gemm_alloc(ENC_GEMM_M * ENC_GEMM_N);
            if (a && b && out) {
                for (size_t i = 0; i < k * ENC_GEMM_N; i++) {
                    b[i] = 1.0f;
                }
                for (size_t i = 0; i < k * ENC_GEMM_M; i++) {
                    a[i] = 1.0f;
                }
                for (int call = 0; call < CALLS; call++) {
                    tile(k, a, b, out);
                }
            } else {
#pragma omp atomic write
                room = false;
            }
            free(a);
            free(b);
            free(out);
        }
        const double rate = 2.0 * ENC_GEMM_M * ENC_GEMM_N * (double)k * CALLS * threads * threads /
                            (bench_now().core - start.core);
        best = rate > best ? rate : best;
    }
    return room ? best : 0;
}

enum { KERNEL_TRIES = 5, SEARCH_COMPONENTS = 48, GRAM_LOBES = 3 };

static void ignore(void *user, size_t view, size_t first, size_t count, const float *rows) {
    (void)user;
    (void)view;
    (void)first;
    (void)count;
    (void)rows;
}

/* Bytes of samples a second that a pass over the data takes in, square roots included. */
static btf_result pass_rate(const bench_run *run, double *out_rate) {
    const double bytes = bench_samples_bytes(run->data) * run->context->threads;
    joint_rows rows;
    btf_result result = joint_rows_init(run->context, run->data, true, &rows);
    *out_rate = 0;
    for (int try = 0; try < KERNEL_TRIES && result == BTF_OK; try++) {
        const bench_clock start = bench_now();
        result = joint_rows_pass(&rows, ignore, NULL);
        const double rate = bytes / (bench_now().core - start.core);
        *out_rate = rate > *out_rate ? rate : *out_rate;
    }
    joint_rows_clear(&rows);
    return result;
}

/* Operations a second of a search for the nearest source, those of its matrix product counted: as many
 * random queries and sources as the data have texels. */
static btf_result search_rate(const bench_run *run, double *out_rate) {
    const size_t texels = enc_data_texel_count(run->data), k = SEARCH_COMPONENTS;
    const joint_search search = {.width = run->data->width,
                                 .height = run->data->height,
                                 .k = k,
                                 .gains = {BTF_GAIN_SCALE, 1, 255},
                                 .sources = JOINT_GRID_SOURCES,
                                 .tolerance = 1e-6,
                                 .tile = enc_gemm_select(),
                                 .threads = run->context->threads};
    float *c = enc_gemm_alloc(texels * k), *z = enc_gemm_alloc(texels * k);
    float *energy = calloc(texels, sizeof *energy);
    uint32_t *match = calloc(texels, sizeof *match);
    uint8_t *gain = calloc(texels, 1);
    double *value = calloc(texels, sizeof *value);
    btf_result result = c && z && energy && match && gain && value
                            ? BTF_OK
                            : enc_fail(run->context, BTF_ERROR_MEMORY, "bench: out of memory");
    random_state random = {1};
    for (size_t i = 0; i < texels * k && result == BTF_OK; i++) {
        c[i] = (float)(random_bits(&random) % 2048) / 1024 - 1;
        z[i] = (float)(random_bits(&random) % 2048) / 1024 - 1;
        energy[i / k] += c[i] * c[i];
    }
    *out_rate = 0;
    for (int try = 0; try < KERNEL_TRIES && result == BTF_OK; try++) {
        for (size_t i = 0; i < texels; i++) {
            match[i] = (uint32_t)i;
            gain[i] = BTF_GAIN_ONE;
        }
        const bench_clock start = bench_now();
        result = joint_search_view(&search, c, energy, z, match, gain, value);
        const double rate = 2.0 * (double)texels * (double)texels * (double)k * run->context->threads /
                            (bench_now().core - start.core);
        *out_rate = rate > *out_rate ? rate : *out_rate;
    }
    free(c);
    free(z);
    free(energy);
    free(match);
    free(gain);
    free(value);
    return result;
}

/* Operations a second of one thread's Gram matrices of the fit, products and sums of columns counted. */
static btf_result gram_rate(const bench_run *run, double *out_rate) {
    enum { SAMPLES = 26 * ENC_GRAM_BLOCK, PLANES = 7, CALLS = 200 };
    const int columns = enc_gram_columns(GRAM_LOBES);
    double gram[ENC_GRAM_MAX_COLUMNS * ENC_GRAM_MAX_COLUMNS];
    float *planes = enc_gemm_alloc((size_t)PLANES * SAMPLES);
    if (!planes) {
        return enc_fail(run->context, BTF_ERROR_MEMORY, "bench: out of memory");
    }
    random_state random = {1};
    for (size_t i = 0; i < (size_t)PLANES * SAMPLES; i++) {
        planes[i] = (float)(random_bits(&random) % 1024) / 1024;
    }
    const enc_gram_samples samples = {SAMPLES,
                                      {planes, planes + SAMPLES, planes + 2 * SAMPLES},
                                      planes + 3 * SAMPLES,
                                      {planes + 4 * SAMPLES, planes + 5 * SAMPLES, planes + 6 * SAMPLES}};
    const enc_gram_point point = {
        .shape = {{-0.5f, -0.5f, 0.8f, 5}, {0.4f, 0.4f, 0.6f, 2}, {0.1f, 0.2f, 0.9f, 1}},
        .colour = {{0.5f, 0.2f, 0.2f, 0.1f}, {0.4f, 0.2f, 0.2f, 0.1f}, {0.3f, 0.2f, 0.2f, 0.1f}}};
    *out_rate = 0;
    for (int try = 0; try < KERNEL_TRIES; try++) {
        const bench_clock start = bench_now();
        for (int call = 0; call < CALLS; call++) {
            enc_gram_accumulate(&samples, GRAM_LOBES, &point, gram);
        }
        const double rate =
            (double)columns * (columns + 1) * SAMPLES * CALLS / (bench_now().core - start.core);
        *out_rate = rate > *out_rate ? rate : *out_rate;
    }
    free(planes);
    return BTF_OK;
}

static void print_rate(FILE *summary, FILE *csv, const char *what, double rate, const char *unit,
                       double limit, const char *of) {
    fprintf(summary, "| %s | %.1f G%s/s |", what, 1e-9 * rate, unit);
    if (limit > 0) {
        fprintf(summary, " %.0f %% of %s |\n", 100 * rate / limit, of);
    } else {
        fprintf(summary, " |\n");
    }
    fprintf(csv, "%s,%.6g,%s/s\n", what, rate, unit);
}

btf_result bench_section_machine(const bench_run *run) {
    const int threads = run->context->threads;
    bench_limits limits;
    double pass = 0, search = 0, gram = 0;
    FILE *csv = NULL;
    btf_result result = bench_limits_measure(run->context, &limits);
    if (result == BTF_OK) {
        result = pass_rate(run, &pass);
    }
    if (result == BTF_OK) {
        result = search_rate(run, &search);
    }
    if (result == BTF_OK) {
        result = gram_rate(run, &gram);
    }
    if (result != BTF_OK || (result = bench_open(run, "machine", "csv", &csv)) != BTF_OK) {
        return result;
    }
    fprintf(csv, "what,value,unit\n");
    fprintf(run->summary,
            "%d threads, the best of some tries; by core time, as if no one else used the cores. Fused "
            "multiply-adds "
            "count as two operations; the fit's sums are not fused, so that half of that is its limit.\n\n"
            "| limit, place | measured | bound |\n| --- | --- | --- |\n",
            threads);
    FILE *const out = run->summary;
    char flops[80];
    snprintf(flops, sizeof flops, "multiply-adds; %s", limits.vectors);
    print_rate(out, csv, "memory; read and written", limits.memory, "B", 0, NULL);
    print_rate(out, csv, "second-level cache; read and written", limits.cache, "B", 0, NULL);
    print_rate(out, csv, flops, limits.flops, "op", 0, NULL);
    print_rate(out, csv, "joint: dense tile; k = 20", tile_rate(threads, 20), "op", limits.flops,
               "multiply-adds");
    print_rate(out, csv, "joint: dense tile; k = 96", tile_rate(threads, 96), "op", limits.flops,
               "multiply-adds");
    print_rate(out, csv, "joint: search of sources; k = 48", search, "op", limits.flops, "multiply-adds");
    print_rate(out, csv, "joint: pass over the samples", pass, "B", limits.memory, "memory");
    print_rate(out, csv, "paper: Gram matrix of the fit; one thread", gram, "op",
               0.5 * limits.flops / threads, "plain operations of one core");
    fputc('\n', run->summary);
    return fclose(csv) == 0 ? BTF_OK : enc_fail(run->context, BTF_ERROR_IO, "machine.csv: cannot write");
}
