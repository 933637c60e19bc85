/* Names and limits of the machine. See system.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "system.h"

#include <malloc.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <time.h>
#include <unistd.h>

/* The rest of the first line of a file that starts with `key`, or "unknown". */
static void line_of(const char *path, const char *key, char *out, size_t size) {
    char line[512];
    FILE *file = fopen(path, "r");
    snprintf(out, size, "unknown");
    while (file && fgets(line, sizeof line, file)) {
        if (strncmp(line, key, strlen(key)) == 0) {
            const char *from = line + strlen(key);
            from += strspn(from, " \t:");
            snprintf(out, size, "%.*s", (int)strcspn(from, "\n"), from);
            break;
        }
    }
    if (file) {
        fclose(file);
    }
}

/* FNV-1a of the program's own file. */
static uint64_t hash_program(void) {
    unsigned char bytes[4096];
    uint64_t hash = 14695981039346656037u;
    size_t count;
    FILE *file = fopen("/proc/self/exe", "rb");
    while (file && (count = fread(bytes, 1, sizeof bytes, file)) > 0) {
        for (size_t i = 0; i < count; i++) {
            hash = (hash ^ bytes[i]) * 1099511628211u;
        }
    }
    if (file) {
        fclose(file);
    }
    return hash;
}

void bench_system_find(bench_system *s) {
    struct utsname name;
    *s = (bench_system){.cores = omp_get_num_procs(), .program = hash_program()};
    line_of("/proc/cpuinfo", "model name", s->cpu, sizeof s->cpu);
    line_of("/proc/sys/kernel/random/boot_id", "", s->boot, sizeof s->boot);
    if (getloadavg(&s->load, 1) != 1) {
        s->load = -1;
    }
    if (uname(&name) == 0) {
        snprintf(s->kernel, sizeof s->kernel, "%s %s %s", name.sysname, name.release, name.machine);
    }
#ifdef __clang__
    snprintf(s->compiler, sizeof s->compiler, "clang %s", __clang_version__);
#else
    snprintf(s->compiler, sizeof s->compiler, "gcc %s", __VERSION__);
#endif
}

void bench_sleep_when_idle(char **argv) {
    if (!getenv("OMP_WAIT_POLICY") && setenv("OMP_WAIT_POLICY", "passive", 1) == 0) {
        execv("/proc/self/exe", argv);
    }
}

/* A number of KiB in /proc/self/status, as bytes. */
static double status_of(const char *key) {
    char text[64];
    line_of("/proc/self/status", key, text, sizeof text);
    return 1024.0 * strtod(text, NULL);
}

double bench_peak_reset(void) {
    malloc_trim(0);
    FILE *file = fopen("/proc/self/clear_refs", "w");
    if (file) {
        fputs("5", file);
        fclose(file);
    }
    return status_of("VmRSS");
}

double bench_peak_memory(void) {
    const double peak = status_of("VmHWM");
    struct rusage use;
    getrusage(RUSAGE_SELF, &use);
    return peak > 0 ? peak : 1024.0 * (double)use.ru_maxrss;
}

/* --- limits --- */

enum { TRIES = 7, LARGE = 1 << 24, SMALL = 1 << 14, STEPS = 1 << 20, CHAINS = 12 };

/* The core time of the process divided by its threads: the time by the clock on a machine without other load. */
static double seconds_of(int threads) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return ((double)t.tv_sec + 1e-9 * (double)t.tv_nsec) / threads;
}

#if defined(__x86_64__)
#include <immintrin.h>
#define CHAIN_LOOP(set1, fma, type)                                                                        \
    type a[CHAINS];                                                                                        \
    const type b = set1(0.999f), c = set1(0.001f);                                                         \
    for (int i = 0; i < CHAINS; i++) {                                                                     \
        a[i] = set1((float)i);                                                                             \
    }                                                                                                      \
    for (int step = 0; step < STEPS; step++) {                                                             \
        _Pragma("GCC unroll 12") for (int i = 0; i < CHAINS; i++) {                                        \
            a[i] = fma(a[i], b, c);                                                                        \
        }                                                                                                  \
    }                                                                                                      \
    float sum = 0;                                                                                         \
    for (int i = 0; i < CHAINS; i++) {                                                                     \
        float lanes[sizeof(type) / sizeof(float)];                                                         \
        memcpy(lanes, &a[i], sizeof lanes);                                                                \
        sum += lanes[0];                                                                                   \
    }                                                                                                      \
    return sum;

__attribute__((target("avx512f"))) static float chains_avx512(void) {
    CHAIN_LOOP(_mm512_set1_ps, _mm512_fmadd_ps, __m512)
}

__attribute__((target("avx2,fma"))) static float chains_avx2(void) {
    CHAIN_LOOP(_mm256_set1_ps, _mm256_fmadd_ps, __m256)
}
#endif

typedef float plain __attribute__((vector_size(16)));

static float chains_plain(void) {
    plain a[CHAINS];
    const plain b = {0.999f, 0.999f, 0.999f, 0.999f}, c = {0.001f, 0.001f, 0.001f, 0.001f};
    for (int i = 0; i < CHAINS; i++) {
        a[i] = (plain){(float)i, 0, 0, 0};
    }
    for (int step = 0; step < STEPS; step++) {
        for (int i = 0; i < CHAINS; i++) {
            a[i] = a[i] * b + c;
        }
    }
    float sum = 0;
    for (int i = 0; i < CHAINS; i++) {
        sum += a[i][0];
    }
    return sum;
}

static double best_flops(int threads, const char **out_vectors) {
    float (*chains)(void) = chains_plain;
    double lanes = 4, best = 0;
    *out_vectors = "plain vectors of 4";
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f")) {
        chains = chains_avx512;
        lanes = 16;
        *out_vectors = "AVX-512";
    } else if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
        chains = chains_avx2;
        lanes = 8;
        *out_vectors = "AVX2";
    }
#endif
    for (int try = 0; try < TRIES; try++) {
        volatile float sink = 0;
        const double start = seconds_of(threads);
#pragma omp parallel num_threads(threads)
        {
            const float sum = chains();
#pragma omp critical(bench_chains)
            sink = sink + sum;
        }
        const double rate = 2.0 * lanes * CHAINS * STEPS * threads / (seconds_of(threads) - start);
        best = rate > best ? rate : best;
    }
    return best;
}

/* The rate of c = a + b in bytes a second, over `count` floats a thread, `rounds` times. */
static double best_bandwidth(int threads, size_t count, int rounds, float *arrays) {
    double best = 0;
    for (int try = 0; try < TRIES; try++) {
        const double start = seconds_of(threads);
#pragma omp parallel num_threads(threads)
        {
            float *a = arrays + 3 * count * (size_t)omp_get_thread_num(), *b = a + count, *c = b + count;
            for (int round = 0; round < rounds; round++) {
                for (size_t i = 0; i < count; i++) {
                    c[i] = a[i] + b[i];
                }
                __asm__ volatile("" ::: "memory");
            }
        }
        const double rate = 12.0 * (double)count * rounds * threads / (seconds_of(threads) - start);
        best = rate > best ? rate : best;
    }
    return best;
}

btf_result bench_limits_measure(const enc_context *context, bench_limits *out_limits) {
    const size_t floats = 3 * (size_t)LARGE * (size_t)context->threads;
    float *arrays = malloc(floats * sizeof *arrays);
    if (!arrays) {
        return enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory for %zu floats", floats);
    }
    memset(arrays, 0, floats * sizeof *arrays);
    out_limits->memory = best_bandwidth(context->threads, LARGE, 1, arrays);
    out_limits->cache = best_bandwidth(context->threads, SMALL, 1000, arrays);
    out_limits->flops = best_flops(context->threads, &out_limits->vectors);
    free(arrays);
    return BTF_OK;
}
