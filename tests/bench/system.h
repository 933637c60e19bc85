/* The machine of a run, and its best rates.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_SYSTEM_H
#define OPENBTF_TESTS_BENCH_SYSTEM_H

#include "encoder/base/context.h"

#include <stdint.h>

typedef struct bench_system {
    char cpu[128];
    int cores;
    double load;      /* average of the last minute, before the run */
    char boot[64];    /* changes when the machine starts anew; "unknown" where the system has none */
    uint64_t program; /* hash of this program's file: which build */
    char kernel[200], compiler[120];
} bench_system;

void bench_system_find(bench_system *out_system);

/* Starts this program anew with OpenMP's idle threads asleep instead of spinning, unless the environment sets that:
 * core time would count a thread that spins while it waits. Returns when that is not needed or not possible. */
void bench_sleep_when_idle(char **argv);

/* Memory of the process, bytes: hands freed memory back and starts a new peak, returns what is held now;
 * and the peak since then. Where the system cannot start a new one, the peak since the start. */
double bench_peak_reset(void);
double bench_peak_memory(void);

/* The machine's best rates, measured with small kernels over `threads` threads, each the best of
 * some tries, by core time: bandwidth of a sum of two arrays too large for the caches, and of one that fits
 * the second-level cache, bytes read and written a second; fused multiply-adds on independent vectors, each
 * two operations, operations a second. Where the compiler or the processor lacks AVX-512 or AVX2, plain
 * vectors are used. Errors: BTF_ERROR_MEMORY. */
typedef struct bench_limits {
    double memory, cache, flops;
    const char *vectors; /* which instructions `flops` used */
} bench_limits;
btf_result bench_limits_measure(const enc_context *context, bench_limits *out_limits);

#endif
