/* Rows of the sweeps, each with the cost and accuracy of one setting; statistics over repeats, the Pareto front, CSV,
 * and the journal from which a stopped run goes on.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_RESULTS_H
#define OPENBTF_TESTS_BENCH_RESULTS_H

#include "encodes.h"
#include "tests/bench/codecs/between.h"
#include "tests/bench/codecs/held.h"

#include <stdio.h>

enum { BENCH_MOST_REPEATS = 25, BENCH_MOST_ROWS = 256 };

/* Figures that do not apply are NAN. */
typedef struct bench_row {
    char sweep[24];           /* rows of one sweep are joined by a line in plots */
    char name[72];            /* the setting, without commas or quotes */
    double x;                 /* the number that the sweep changes */
    double core, core_spread; /* seconds of all threads: median; (largest - smallest) / median */
    double wall, wall_spread; /* seconds of the clock */
    double bytes;             /* GPU bytes */
    double memory;            /* bytes: samples, and what encoding added at its peak */
    double linear, srgb;      /* PSNR over all samples encoded, dB */
    double ssim;
    bench_between_figures between;     /* PSNR between the samples: truth, estimate */
    double held[BENCH_HELD_SETS][2];   /* PSNR at directions left out: linear, sRGB-coded, dB */
    double pareto_linear, pareto_srgb; /* 1: nothing else is both cheaper and better, else 0 */
} bench_row;

/* All figures NAN. */
bench_row bench_row_named(const char *sweep, const char *name, double x);

typedef struct bench_table {
    bench_row rows[BENCH_MOST_ROWS];
    int count;
} bench_table;

/* Adds a copy; the last row is overwritten in a full table. */
void bench_table_add(bench_table *table, const bench_row *row);

/* Median and (largest - smallest) / median of `count` values, which it sorts. */
double bench_median(double *values, int count, double *out_spread);

/* The accuracy that counts for a renderer, in dB, as far as it is known: between the samples against truth; else at
 * views and lights left out; else estimated; else at the samples. */
double bench_seen(const bench_row *row, bool srgb);

/* Marks the rows of the Pareto front: no other row is cheaper and as good or better by bench_seen(). cost: returns a
 * row's cost. */
void bench_mark_pareto(bench_table *table, double (*cost)(const bench_row *row));
double bench_cost_core(const bench_row *row);
double bench_cost_bytes(const bench_row *row);

/* The columns above, one line a row; NAN is left empty. */
void bench_table_write(const bench_table *table, FILE *csv);

/* The slope of log y over log x by least squares. */
double bench_exponent(const double *x, const double *y, int count);

/* The journal: rows as they were measured, of one run. A run is known by its identity, a text of machine,
 * boot, program and settings: rows of another identity are dropped when it is opened, so that no table
 * mixes them. */
typedef struct bench_journal bench_journal;

/* Reads DIR/journal.csv; a line that was cut short is dropped. Errors, on the log: BTF_ERROR_IO,
 * BTF_ERROR_MEMORY. */
btf_result bench_journal_open(const enc_context *context, const char *directory, const char *identity,
                              bench_journal **out_journal);
/* The row of that table, sweep and name as measured before, into *row; false where there is none. */
bool bench_journal_find(const bench_journal *journal, const char *table, bench_row *row);
/* Appends and flushes to the disk. Errors, on the log: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result bench_journal_add(const enc_context *context, bench_journal *journal, const char *table,
                             const bench_row *row);
/* Rows that were found at opening. */
size_t bench_journal_resumed(const bench_journal *journal);
void bench_journal_close(bench_journal **journal);

/* Bytes that the samples take in memory. */
double bench_samples_bytes(const enc_data *data);
/* Bytes of all images in 8 bits a channel. */
double bench_samples_8bit(const enc_data *data);

/* Accuracy of a material over the samples that were encoded, with SSIM, between them, and at the directions
 * held out (three neighbours, by the reference decoder); effects: those decoded. `between` is of
 * held->train. Errors: those of comparing. */
btf_result bench_accuracy(const enc_context *context, const bench_held *held, const bench_between *between,
                          const bench_encoded *encoded, uint32_t effects, bench_row *row);
/* Measures any codec of images at the directions of held->train, which are blended barycentrically
 * between them, and where directions were held out by `tables`. */
btf_result bench_accuracy_images(const enc_context *context, const bench_held *held,
                                 const bench_between *between, const btf_ref_material *tables,
                                 enc_image_source images, bench_row *row);
/* Every image of `images` as data in memory, at the directions of `shape`. Errors: those of the images,
 * BTF_ERROR_MEMORY. */
btf_result bench_decode_all(const enc_context *context, const enc_data *shape, enc_image_source images,
                            enc_data **out_data);

#endif
