/* Rows of settings in which all combinations of settings of two factors occur, or of four.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_PAIRWISE_H
#define OPENBTF_CONFORMANCE_PAIRWISE_H

#include <stddef.h>
#include <stdint.h>

enum { PAIRWISE_FACTORS = 20, PAIRWISE_LEVELS = 8 };

/* Factor f has levels[f] levels (at most PAIRWISE_LEVELS), `factors` of them. Fills at most `most` rows,
 * each level a byte; returns how many it took. The same seed gives the same rows. */
size_t pairwise_rows(uint64_t seed, size_t factors, const uint8_t *levels, size_t most,
                     uint8_t (*rows)[PAIRWISE_FACTORS]);

/* A level of `factor` other than 0 needs one of `other` whose bit is in `allowed`. Factors that others need have no needs. */
typedef struct pairwise_need {
    uint8_t factor, other, allowed;
} pairwise_need;

/* The same for all combinations of levels of four factors that the needs allow; every row keeps to the needs. Returns 0
 * where memory is out. */
size_t fourwise_rows(uint64_t seed, size_t factors, const uint8_t *levels, const pairwise_need *needs, size_t need_count,
                     size_t most, uint8_t (*rows)[PAIRWISE_FACTORS]);

#endif
