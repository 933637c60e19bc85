/* What btf-bench hands to each of its sections.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_BENCH_H
#define OPENBTF_TESTS_BENCH_BENCH_H

#include "encoder/data.h"

#include <stdio.h>

enum { BENCH_PRESETS = 4 };

typedef struct bench_run {
    const enc_context *context;
    const enc_data *data;
    const char *source;          /* what the data are */
    const char *name;            /* the same as a part of file names */
    const char *out;             /* existing folder for CSV files */
    int texels;                  /* texels that slow peers are run on */
    bool presets[BENCH_PRESETS]; /* of the joint method, enc_joint_preset */
    uint64_t budget;             /* GPU bytes a codec may take; 0: what layout `paper` takes */
    int rank;                    /* components of the largest PCA */
    FILE *summary;               /* Markdown; the section's heading was written */
} bench_run;

/* Measures, writes CSV into run->out and tables into run->summary. */
typedef btf_result (*bench_section_fn)(const bench_run *run);

btf_result bench_section_fit(const bench_run *run);
btf_result bench_section_codecs(const bench_run *run);
btf_result bench_section_holdout(const bench_run *run);
btf_result bench_section_decode(const bench_run *run); /* of synthetic materials, whatever the data */

/* run->out/SECTION-MATERIAL.EXTENSION, in `path` of `size` bytes. */
void bench_path(const bench_run *run, const char *section, const char *extension, char *path, size_t size);
/* Opens that file for writing. Errors, on the log: BTF_ERROR_IO. */
btf_result bench_open(const bench_run *run, const char *section, const char *extension, FILE **out_file);

#endif
