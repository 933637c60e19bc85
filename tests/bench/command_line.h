/* The command line of btf-bench.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_COMMAND_LINE_H
#define OPENBTF_TESTS_BENCH_COMMAND_LINE_H

#include "bench.h"
#include "decoder/toolkit/cli.h"
#include "encoder/input/read_options.h"
#include "tests/sample/sample.h"

/* A file, a folder, or the name of a built-in relief. */
typedef struct bench_material {
    const char *input, *pairs; /* pairs: images between the samples of input, or NULL */
    relief_kind relief;        /* where input is NULL */
} bench_material;

enum { BENCH_MAX_MATERIALS = 64 };

typedef struct bench_options {
    const char *out, *device, *keep;
    bench_material materials[BENCH_MAX_MATERIALS];
    int count; /* of materials */
    int threads, texels, rank, repeats, holdout;
    bool sections[BENCH_SECTIONS]; /* those that --only names */
    bool presets[BENCH_PRESETS];
    bool only, presets_given, repeats_given, quick, quiet;
    uint32_t methods; /* BENCH_METHOD bits */
    uint64_t budget;
    enc_read_options read;
} bench_options;

/* The program, for cli_parse(), and the options that it fills. */
extern const cli_program bench_program;
extern bench_options bench_given;

#endif
