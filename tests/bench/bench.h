/* What btf-bench hands to each of its sections.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_BENCH_H
#define OPENBTF_TESTS_BENCH_BENCH_H

#include "encoder/data.h"

#include <stdio.h>

typedef struct bench_run {
    const enc_context *context;
    const enc_data *data;
    const char *source; /* what the data are */
    const char *out;    /* existing folder for CSV files */
    int texels;         /* texels that slow peers are run on */
    FILE *summary;      /* Markdown; the section's heading was written */
} bench_run;

/* Measures, writes CSV into run->out and tables into run->summary. */
typedef btf_result (*bench_section_fn)(const bench_run *run);

btf_result bench_section_fit(const bench_run *run);

/* Opens run->out/NAME for writing. Errors, on the log: BTF_ERROR_IO. */
btf_result bench_open(const bench_run *run, const char *name, FILE **out_file);

#endif
