/* The settings and data that btf-bench hands to each of its sections.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_BENCH_H
#define OPENBTF_TESTS_BENCH_BENCH_H

#include "results.h"
#include "system.h"

#include <stdio.h>

enum { BENCH_PRESETS = 4, BENCH_DECODE_REPEATS = 5 };

/* The codecs that section `decode` decodes. */
enum {
    BENCH_METHOD_JOINT = 1,
    BENCH_METHOD_PAPER = 2,
    BENCH_METHOD_PEERS = 4,
    BENCH_METHOD_REFERENCE = 8, /* decode the materials of the others by the reference on the CPU, too */
    BENCH_METHOD_ALL = 15,
};

typedef struct bench_run {
    const enc_context *context;
    const enc_data *data;
    const char *source;                /* the data set */
    const char *name;                  /* the same as a part of file names */
    const char *out;                   /* existing folder for CSV files */
    int texels;                        /* texels that slow peers are run on */
    bool presets[BENCH_PRESETS];       /* [enc_preset] those of the joint method to run */
    bool presets_given;                /* the user named presets; else section `encode` runs all */
    uint64_t budget;                   /* GPU bytes a codec may take; 0: btf-encode's default */
    int rank;                          /* components of the largest PCA */
    FILE *summary;                     /* Markdown; the section's heading was written */
    const bench_held *held;            /* the data that sweeps encode, and the directions left out of them */
    const bench_truth *truth;          /* between the samples; count 0: not known */
    const bench_between *between;      /* of held->train */
    const bench_between *between_data; /* of data: the same where nothing was left out */
    bench_journal *journal;
    const bench_system *system;
    int repeats;        /* of an encode; a decode is repeated at least BENCH_DECODE_REPEATS times */
    bool quick;         /* fewer settings */
    uint32_t methods;   /* BENCH_METHOD bits of section `decode` */
    const char *device; /* the only one to decode on; NULL: all */
    const char *keep;   /* folder of materials that section `plan` encodes once; NULL: none */
    int most_side;      /* texels along a side that section `growth` goes up to; 0: all of its sizes */
} bench_run;

extern const char *const bench_preset_names[BENCH_PRESETS];

/* Runs a section: measures, writes CSV files to run->out and tables to run->summary. */
typedef btf_result (*bench_section_fn)(const bench_run *run);

typedef struct bench_section {
    const char *name, *what; /* for --only; the title in the summary */
    bench_section_fn run;
    bool quick; /* part of --quick */
} bench_section;

/* All sections, in the order in which they run. */
enum { BENCH_SECTIONS = 14 };
extern const bench_section bench_sections[BENCH_SECTIONS];

btf_result bench_section_machine(const bench_run *run); /* does not depend on the data */
btf_result bench_section_encode(const bench_run *run);
btf_result bench_section_decode(const bench_run *run);
btf_result bench_section_storage(const bench_run *run);
btf_result bench_section_growth(const bench_run *run); /* of the built-in bricks, whatever the data; up to --size */
btf_result bench_section_fit(const bench_run *run);
btf_result bench_section_codecs(const bench_run *run);
btf_result bench_section_lowbit(const bench_run *run);
btf_result bench_section_between(const bench_run *run);
btf_result bench_section_holdout(const bench_run *run);
btf_result bench_section_plan(const bench_run *run);
btf_result bench_section_costs(const bench_run *run); /* of synthetic materials, whatever the data */
btf_result bench_section_stochastic(const bench_run *run);
btf_result bench_section_shaders(const bench_run *run); /* of synthetic materials, whatever the data */

/* The heading of bench_seen()'s column in this run: "between the samples", or the estimate that replaces it. */
const char *bench_seen_words(const bench_run *run);

/* run->out/SECTION-MATERIAL.EXTENSION, in `path` of `size` bytes. */
void bench_path(const bench_run *run, const char *section, const char *extension, char *path, size_t size);
/* Opens that file for writing. Errors, on the log: BTF_ERROR_IO. */
btf_result bench_open(const bench_run *run, const char *section, const char *extension, FILE **out_file);

#endif
