/* The data set whose steps fuzz_checkpoint.c reads and make_corpus.c writes.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_STEP_DATA_H
#define OPENBTF_TESTS_STEP_DATA_H

#include "encoder/data/data.h"
#include "encoder/factor/factor.h"
#include "encoder/relief/relief.h"

enum {
    STEP_SIDE = 3,
    STEP_TEXELS = STEP_SIDE * STEP_SIDE,
    STEP_VIEWS = 2,
    STEP_LIGHTS = 2,
    STEP_CENTRES = 5
};

/* The first byte of an input is the index of its step. */
enum {
    STEP_FIT,
    STEP_SHADOW,
    STEP_FLOW,
    STEP_REFINE,
    STEP_CLUSTER,
    STEP_COMPONENTS,
    STEP_FACTORS,
    STEP_MATCHED,
    STEP_MATCH,
    STEP_RELIEF,
    STEP_COUNT
};
extern const char *const step_names[STEP_COUNT];

/* Makes a plausible choice of relief and gloss for the data, with arrays of its own; enc_relief_clear clears
 * *out_store. */
void step_relief(const enc_data *data, enc_relief_choice *out_choice, enc_relief_store *out_store);

/* The options of the factor encoder for the data, with match or without. */
enc_factor_options step_factors(bool match);

/* Destroy with enc_data_destroy. NULL when out of memory. */
enc_data *step_data(const enc_context *context);

#endif
