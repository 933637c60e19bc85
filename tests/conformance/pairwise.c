/* Rows are added until every pair stands in one, each row the best of some random tries.
 *
 * SPDX-License-Identifier: MIT
 */
#include "pairwise.h"
#include "random.h"

typedef struct coverage {
    uint8_t met[PAIRWISE_FACTORS][PAIRWISE_FACTORS][PAIRWISE_LEVELS][PAIRWISE_LEVELS];
} coverage;

/* How many pairs a row would add; marks them when `mark`. */
static int new_pairs(coverage *c, size_t factors, const uint8_t *row, int mark) {
    int count = 0;
    for (size_t f = 0; f < factors; ++f)
        for (size_t g = f + 1; g < factors; ++g)
            if (!c->met[f][g][row[f]][row[g]]) {
                ++count;
                if (mark)
                    c->met[f][g][row[f]][row[g]] = 1;
            }
    return count;
}

size_t pairwise_rows(uint64_t seed, size_t factors, const uint8_t *levels, size_t most,
                     uint8_t (*rows)[PAIRWISE_FACTORS]) {
    enum { TRIES = 60 };
    coverage covered;
    memset(&covered, 0, sizeof covered);
    random_state r = {seed};
    int missing = 0;
    for (size_t f = 0; f < factors; ++f)
        for (size_t g = f + 1; g < factors; ++g)
            missing += levels[f] * levels[g];
    size_t count = 0;
    for (; missing > 0 && count < most; ++count) {
        int best = 0;
        for (int t = 0; t < TRIES || best == 0; ++t) {
            uint8_t row[PAIRWISE_FACTORS] = {0};
            for (size_t f = 0; f < factors; ++f)
                row[f] = (uint8_t)random_below(&r, levels[f]);
            int pairs = new_pairs(&covered, factors, row, 0);
            if (pairs > best) {
                best = pairs;
                memcpy(rows[count], row, sizeof row);
            }
        }
        missing -= new_pairs(&covered, factors, rows[count], 1);
    }
    return count;
}
