/* Rows of section `decode` as CSV, Markdown and plots.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_DECODE_TABLE_H
#define OPENBTF_TESTS_BENCH_DECODE_TABLE_H

#include "tests/bench/bench.h"
#include "decode_cost.h"
#include "decode_rig.h"

enum { DECODE_MOST_ROWS = 1200, DECODE_MOST_SIZES = 16, DECODE_MOST_DEVICES = 12 };

/* The `effects` of a row of fetches alone. */
#define DECODE_FLOOR "fetches only"

typedef struct decode_row {
    char device[24], material[40], effects[40];
    bool nearest, fast, peer;
    btf_filter filter;
    bool estimated;            /* the figures between the samples are estimates */
    int side;                  /* of the picture, where that is what changes; else 0 */
    double gpu_bytes;          /* of the whole material */
    bool counted;              /* has a cost */
    decode_cost cost;          /* a pixel */
    double ns, spread;         /* a pixel: median of the repeats, (largest - smallest) / median */
    double linear[3], srgb[3]; /* PSNR at sampled directions, at those held out (both), and between the
                                  samples: against truth, else estimated; NAN: none */
} decode_row;

typedef struct decode_table {
    decode_row rows[DECODE_MOST_ROWS];
    int count;
    decode_row sizes[DECODE_MOST_SIZES];
    int size_count;
    struct {
        char name[24], renderer[200];
        bool software;
    } device[DECODE_MOST_DEVICES];
    int devices;
} decode_table;

decode_row decode_row_named(const char *device, const char *material, const char *effects);
void decode_table_add(decode_table *table, const decode_row *row);
void decode_table_add_size(decode_table *table, const decode_row *row);
void decode_table_device(decode_table *table, const char *name, const char *renderer, bool software);

/* The one of these three that a renderer sees: between the samples against truth, else held out, else estimated;
 * 0 where there is only the first. */
int decode_seen(const decode_row *row);

/* The row of those names; NULL: not measured. */
const decode_row *decode_table_find(const decode_table *table, const char *device, const char *material,
                                    const char *effects, bool nearest, btf_filter filter, bool fast);

/* decode-MATERIAL.csv, tables in the summary, plots. Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result decode_table_write(const bench_run *run, const decode_table *table);

#endif
