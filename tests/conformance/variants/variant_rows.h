/* Variants of the decoder's text: the macros that choose them, and rows of settings in which they meet.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_VARIANT_ROWS_H
#define OPENBTF_CONFORMANCE_VARIANT_ROWS_H

#include "tests/conformance/pairwise.h"

/* The options that decide which code exists: a row has a setting of each. */
enum factor {
    LAYOUT,
    DOMAIN,
    COLOUR,
    LOBES,
    SHADOW,
    SHIFT,
    HIDDEN,
    GAIN,
    COMPONENTS,
    NEAREST,
    BILINEAR,
    FAST,
    STORE, /* components, factors of all classes, of some */
    ROOTS,
    POINTS, /* packed or in lists: layout tight, without hidden points */
    RELIEF, /* of one height, of a map, of a map that ends before the last level: layout tight */
    GLOSS,  /* of a quarter, of a half: layout tight */
    STEEP,  /* with bilinear filtering */
    PICKS,  /* none, views, lights, all */
    FACTORS
};

enum { ROW_MACROS = 3000 };

/* Writes the macros of a row, which stand in front of the library, to `out` of ROW_MACROS bytes. */
void row_macros(const uint8_t *row, char *out);

/* Components of the residual, or units; 0: none. */
int row_components(const uint8_t *row);

int row_has_factors(const uint8_t *row);

/* Rows in which every two settings meet; returns how many. */
size_t rows_of_pairs(size_t most, uint8_t (*rows)[PAIRWISE_FACTORS]);

/* Rows in which every four settings meet that can, none of them without effect on the text. 0: no memory. */
size_t rows_of_fours(size_t most, uint8_t (*rows)[PAIRWISE_FACTORS]);

#endif
