/* Images at directions between the samples that show the truth: ray-cast for the built-in reliefs, read for data sets.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_TRUTH_H
#define OPENBTF_TESTS_BENCH_TRUTH_H

#include "encoder/between/pairs.h"
#include "tests/sample/sample.h"

enum { BENCH_RAYCAST_PAIRS = 100 };

/* Linear radiance at pairs of a view and a light. */
typedef struct bench_truth {
    size_t count; /* 0: none is known */
    int width, height;
    enc_pair *pair; /* [count], without names */
    float *images;  /* [count][row][column][3] */
    char source[160];
} bench_truth;

/* BENCH_RAYCAST_PAIRS random pairs of the relief that the options describe: those of btf-sample --between,
 * seed 0. Errors: those of sample_scene_create, BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result bench_truth_raycast(const sample_options *options, bench_truth *out_truth);

/* All images of a folder or an archive. `side` above 0 keeps the top left texels, at most `side` along each
 * side. Errors: those of enc_pairs_open and enc_pairs_read, BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result bench_truth_read(const enc_context *context, const char *path, const enc_read_options *options,
                            int side, bench_truth *out_truth);

void bench_truth_clear(bench_truth *truth);

#endif
