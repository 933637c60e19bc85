/* The rows of section `codecs`, as Markdown, CSV and a plot.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_CODEC_TABLE_H
#define OPENBTF_TESTS_BENCH_CODEC_TABLE_H

#include "tests/bench/bench.h"

typedef enum codec_kind {
    CODEC_OURS = 0,
    CODEC_PEER,  /* at most the budget */
    CODEC_CURVE, /* 8-bit PCA of another size: plot and CSV, no SSIM */
} codec_kind;

/* The ring (theta in degrees) of lowest PSNR, in linear and in sRGB-coded values. */
typedef struct codec_ring {
    double linear, linear_theta, srgb, srgb_theta;
} codec_ring;

typedef struct codec_row {
    codec_kind kind;
    char name[64];
    bool srgb_coded;  /* peers: sRGB-coded values were factorised */
    int eight_bit_of; /* 1 + pca_coding of a whole PCA in 8 bits, else 0 */
    size_t rank;      /* components; 0: has none */
    size_t bytes;     /* on the GPU */
    double linear, srgb, ssim;
    codec_ring view_ring, light_ring;
    double wall, core; /* seconds of encoding; for PCA the factorisation that serves all ranks */
} codec_row;

/* The rank and bytes with which PCA reaches the quality of a row of ours. */
typedef struct codec_equal {
    size_t row;      /* of the table */
    bool srgb_coded; /* equal in sRGB-coded PSNR, else in linear */
    codec_row peer;  /* peer.rank 0: the largest rank falls short; its figures stand there */
} codec_equal;

enum { CODEC_EQUALS = 2 * BENCH_PRESETS };

typedef struct codec_table {
    codec_row *rows;
    size_t count;
    codec_equal equal[CODEC_EQUALS];
    int equals;
    size_t factor_rank; /* of the factorisations in the plot */
    uint64_t budget;
} codec_table;

/* Errors: BTF_ERROR_MEMORY. */
btf_result codec_table_add(const enc_context *context, codec_table *table, const codec_row *row);
void codec_table_clear(codec_table *table);

void codec_table_print(const codec_table *table, FILE *out);

/* codecs-MATERIAL.csv, and with gnuplot codecs-MATERIAL.svg; without it the plot is left out with a
 * message. Errors: BTF_ERROR_IO. */
btf_result codec_table_write(const bench_run *run, const codec_table *table);

#endif
