/* Rows of settings in which every two settings of two factors meet.
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

#endif
