/* Section `machine`: the best rates of the processor and its memory, and the rates of the loops in which an encode
 * spends most of its time.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"

#include "encoder/factor/matrix.h"
#include "encoder/lafortune/gram.h"

#include "tests/conformance/random.h"

#include <openbtf/material.h>
#include <stdlib.h>

/* Rates are work over core time, times the number of threads: the rate by the clock on a machine without other load. */

/* Operations a second of the joint method's inner tile of products, with k components whose operands fit the
 * first-level cache, on all threads: the best of some tries. 0: out of memory. */
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

enum { KERNEL_TRIES = 5, GRAM_LOBES = 3, PASS_COMPONENTS = 32 };

/* Operations a second of a product of the samples with factors, PASS_COMPONENTS of each channel. It includes square
 * roots and the change to opponent colour, whose operations are not counted. */
static btf_result pass_rate(const bench_run *run, double *out_rate) {
    const enc_factor_matrix matrix = enc_factor_matrix_of(run->context, run->data);
    const size_t rank = PASS_COMPONENTS;
    enc_factor_set w = {{rank, rank, rank}, {NULL}}, u = w;
    bool room = true;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        w.factor[c] = enc_gemm_alloc(rank * matrix.columns);
        u.factor[c] = enc_gemm_alloc(rank * matrix.texels);
        room = room && w.factor[c] && u.factor[c];
        for (size_t i = 0; room && i < rank * matrix.columns; i++) {
            w.factor[c][i] = (float)(i % 7) - 3;
        }
    }
    btf_result result = room ? BTF_OK : enc_fail(run->context, BTF_ERROR_MEMORY, "bench: out of memory");
    *out_rate = 0;
    for (int try = 0; try < KERNEL_TRIES && result == BTF_OK; try++) {
        const bench_clock start = bench_now();
        result = enc_factor_times_w(&matrix, &w, &u);
        const double rate = 2.0 * ENC_FACTOR_CHANNELS * (double)rank * (double)matrix.columns *
                            (double)matrix.texels * run->context->threads / (bench_now().core - start.core);
        *out_rate = rate > *out_rate ? rate : *out_rate;
    }
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        free(w.factor[c]);
        free(u.factor[c]);
    }
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
    double pass = 0, gram = 0;
    FILE *csv = NULL;
    btf_result result = bench_limits_measure(run->context, &limits);
    if (result == BTF_OK) {
        result = pass_rate(run, &pass);
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
    print_rate(out, csv, "joint: product with the samples; k = 32", pass, "op", limits.flops, "multiply-adds");
    print_rate(out, csv, "paper: Gram matrix of the fit; one thread", gram, "op",
               0.5 * limits.flops / threads, "plain operations of one core");
    fputc('\n', run->summary);
    return fclose(csv) == 0 ? BTF_OK : enc_fail(run->context, BTF_ERROR_IO, "machine.csv: cannot write");
}
