/* Times decoding on this machine's GPU context, and for comparison its fetches alone (the floor) and its peers.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_DECODE_BENCH_H
#define OPENBTF_TESTS_BENCH_DECODE_BENCH_H

#include <openbtf/result.h>
#include <stdio.h>

enum { BENCH_DECODE_NAME = 64, BENCH_DECODE_MAX = 64 };

/* One shader. Times are core time (of all threads) a pixel. */
typedef struct bench_decode_row {
    char name[BENCH_DECODE_NAME];
    int components;    /* of a residual or of PCA, else 0 */
    double ns, spread; /* median of the repeats; (largest - smallest) / median */
    double floor_ns;   /* the same fetches added up; 0: not measured */
    double fast_ns;    /* the same variant in fast math; 0: not measured */
} bench_decode_row;

typedef struct bench_decode {
    char renderer[200];
    bench_decode_row rows[BENCH_DECODE_MAX];
    int count;
    double open_ms,
        upload_ms;  /* a 64 x 64, 81 x 81 material of layout tight: open from memory; btf_gl_upload */
    double bytes;   /* its textures */
    double peak_mb; /* peak memory of this process, 10^6 bytes */
} bench_decode;

/* Draws 256 x 256 pixels of a sphere with every variant of synthetic materials, with the material files
 * named, and with every peer, `repeats` times each. Synthetic materials are random to the texel: a third of
 * the points is hidden and every shift its own, which real ones do not do to a cache. Errors:
 * BTF_ERROR_UNSUPPORTED without a context, with the reason on log; those of opening files. Half a minute
 * for 5 repeats on a free core. */
btf_result bench_decode_run(int repeats, char *const *files, int file_count, const btf_log *log,
                            bench_decode *out);

/* A table in Markdown, and the same as CSV (either may be NULL). */
void bench_decode_print(const bench_decode *result, FILE *markdown, FILE *csv);

#endif
