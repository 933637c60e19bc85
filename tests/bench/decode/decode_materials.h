/* The materials that section `decode` times, encoded from the data of a run.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_DECODE_MATERIALS_H
#define OPENBTF_TESTS_BENCH_DECODE_MATERIALS_H

#include "tests/bench/bench.h"

/* A part of a material that is decoded: without some effects, of the first components, or in directions
 * that never change. */
typedef struct decode_subset {
    const char *name;
    uint32_t leave_out;
    uint32_t part;  /* of the components: one in so many, in whole groups; 0: all */
    uint32_t fixed; /* btf_fixed bits, of the first view and light; accuracy is not measured then */
} decode_subset;

/* Names are those of rows. The first subset is "whole". */
enum { DECODE_MATERIALS = 4 };
#define DECODE_JOINT "joint"
#define DECODE_HALF_JOINT "joint; half the bytes"
#define DECODE_PAPER "paper"
#define DECODE_RELIEF "joint; relief"
#define DECODE_NO_RELIEF "relief left out"
#define DECODE_NO_GLOSS "gloss left out"
#define DECODE_NEITHER "relief and gloss left out"
#define DECODE_ADDED_GLOSS "gloss of a quarter added"

typedef struct decode_material {
    const char *name; /* NULL: not there */
    bench_encoded encoded;
    btf_ref_material view;
    const decode_subset *subsets;
    int count;
} decode_material;

/* By name; NULL: not there. */
const decode_material *decode_material_find(const decode_material materials[DECODE_MATERIALS],
                                            const char *name);

/* Encodes those of `run->methods`, by joint for the budget, for half of what that took, and for the budget with what
 * the default does between the samples where that finds relief or gloss. Where it finds relief alone, the file has a
 * quarter of gloss, too, so that gloss is timed; its "whole" is what the default finds. Clear with
 * decode_materials_clear, also on an error. Errors: those of encoding. */
btf_result decode_materials_create(const bench_run *run, decode_material out[DECODE_MATERIALS]);
void decode_materials_clear(decode_material materials[DECODE_MATERIALS]);

#endif
