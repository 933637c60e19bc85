/* Pairs: rows are added, each the best of some random tries, until every pair occurs in one. Fours: each row begins
 * with a combination of four that is still missing, and then gets for each other factor the level that adds most new
 * ones. (Greedy covering arrays: D. Cohen et al., The AETG system, 1997.)
 *
 * SPDX-License-Identifier: MIT
 */
#include "pairwise.h"
#include "random.h"

#include <stdlib.h>

typedef struct coverage {
    uint8_t met[PAIRWISE_FACTORS][PAIRWISE_FACTORS][PAIRWISE_LEVELS][PAIRWISE_LEVELS];
} coverage;

/* Counts the pairs that a row would add; marks them when `mark`. */
static int new_pairs(coverage *c, size_t factors, const uint8_t *row, int mark) {
    int count = 0;
    for (size_t f = 0; f < factors; ++f) {
        for (size_t g = f + 1; g < factors; ++g) {
            if (!c->met[f][g][row[f]][row[g]]) {
                ++count;
                if (mark) {
                    c->met[f][g][row[f]][row[g]] = 1;
                }
            }
        }
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
    for (size_t f = 0; f < factors; ++f) {
        for (size_t g = f + 1; g < factors; ++g) {
            missing += levels[f] * levels[g];
        }
    }
    size_t count = 0;
    for (; missing > 0 && count < most; ++count) {
        int best = 0;
        for (int t = 0; t < TRIES || best == 0; ++t) {
            uint8_t row[PAIRWISE_FACTORS] = {0};
            for (size_t f = 0; f < factors; ++f) {
                row[f] = (uint8_t)random_below(&r, levels[f]);
            }
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

typedef struct fourwise {
    size_t factors, need_count;
    const uint8_t *levels;
    const pairwise_need *needs;
    uint32_t first[PAIRWISE_FACTORS][PAIRWISE_FACTORS][PAIRWISE_FACTORS]
                  [PAIRWISE_FACTORS]; /* in met, of f < g < h < i */
    uint8_t *met;
} fourwise;

/* A row that is being filled: for each factor, the bits of the levels that the levels set so far allow. */
typedef struct partial {
    uint8_t allowed[PAIRWISE_FACTORS], level[PAIRWISE_FACTORS], set[PAIRWISE_FACTORS];
    size_t count; /* of set, which is sorted */
} partial;

/* Sets a factor to a level if the needs allow it; returns whether they do. */
static int set_level(const fourwise *c, partial *row, size_t factor, uint8_t level) {
    uint8_t allowed[PAIRWISE_FACTORS];
    memcpy(allowed, row->allowed, sizeof allowed);
    allowed[factor] &= (uint8_t)(1u << level);
    for (size_t n = 0; n < c->need_count && level > 0; ++n) {
        if (c->needs[n].factor == factor) {
            allowed[c->needs[n].other] &= c->needs[n].allowed;
        }
    }
    for (size_t f = 0; f < c->factors; ++f) {
        if (!allowed[f]) {
            return 0;
        }
    }
    memcpy(row->allowed, allowed, sizeof allowed);
    row->level[factor] = level;
    size_t at = row->count++;
    for (; at > 0 && row->set[at - 1] > factor; --at) {
        row->set[at] = row->set[at - 1];
    }
    row->set[at] = (uint8_t)factor;
    return 1;
}

static uint8_t *met_of(const fourwise *c, const uint8_t *level, size_t f, size_t g, size_t h, size_t i) {
    const size_t at =
        ((level[f] * (size_t)c->levels[g] + level[g]) * c->levels[h] + level[h]) * c->levels[i] + level[i];
    return &c->met[c->first[f][g][h][i] + at];
}

/* Counts the combinations of four set factors that no row has yet, or, if `with` is a factor, those that contain it;
 * marks them when `mark`. */
static int new_fours(const fourwise *c, const partial *row, size_t with, int mark) {
    int count = 0;
    const size_t n = row->count;
    const uint8_t *set = row->set;
    for (size_t f = 0; f < n; ++f) {
        for (size_t g = f + 1; g < n; ++g) {
            for (size_t h = g + 1; h < n; ++h) {
                const int among = with >= c->factors || set[f] == with || set[g] == with || set[h] == with;
                for (size_t i = h + 1; i < n; ++i) {
                    if (!among && set[i] != with) {
                        continue;
                    }
                    uint8_t *met = met_of(c, row->level, set[f], set[g], set[h], set[i]);
                    count += !*met;
                    *met |= (uint8_t)mark;
                }
            }
        }
    }
    return count;
}

/* Sets the other factors in a random order, each to the level that adds most new combinations of four. */
static void fill(const fourwise *c, random_state *r, partial *row) {
    uint8_t order[PAIRWISE_FACTORS] = {0};
    for (size_t f = 0; f < c->factors; ++f) {
        const size_t at = random_below(r, (uint32_t)f + 1);
        order[f] = order[at];
        order[at] = (uint8_t)f;
    }
    for (size_t k = 0; k < c->factors; ++k) {
        const uint8_t factor = order[k];
        if (memchr(row->set, factor, row->count)) {
            continue;
        }
        partial best = *row;
        int most = -1;
        const uint32_t turn = random_below(r, c->levels[factor]);
        for (uint32_t l = 0; l < c->levels[factor]; ++l) {
            partial next = *row;
            if (!set_level(c, &next, factor, (uint8_t)((l + turn) % c->levels[factor]))) {
                continue;
            }
            const int fours = new_fours(c, &next, factor, 0);
            if (fours > most) {
                most = fours;
                best = next;
            }
        }
        *row = best;
    }
}

static partial empty_row(const fourwise *c) {
    partial row = {.count = 0};
    for (size_t f = 0; f < c->factors; ++f) {
        row.allowed[f] = (uint8_t)((1u << c->levels[f]) - 1);
    }
    return row;
}

/* Makes rows for all combinations of levels of these four factors. */
static size_t rows_of_four(const fourwise *c, random_state *r, const size_t of[4], size_t most,
                           uint8_t (*rows)[PAIRWISE_FACTORS]) {
    size_t count = 0;
    uint8_t level[PAIRWISE_FACTORS] = {0};
    uint32_t all = 1;
    for (int k = 0; k < 4; ++k) {
        all *= c->levels[of[k]];
    }
    for (uint32_t four = 0; four < all; ++four) {
        partial row = empty_row(c);
        int possible = 1;
        uint32_t rest = four;
        for (int k = 0; k < 4; ++k) {
            level[of[k]] = (uint8_t)(rest % c->levels[of[k]]);
            rest /= c->levels[of[k]];
            possible = possible && set_level(c, &row, of[k], level[of[k]]);
        }
        if (!possible || *met_of(c, level, of[0], of[1], of[2], of[3])) {
            continue;
        }
        if (count == most) {
            return most;
        }
        fill(c, r, &row);
        new_fours(c, &row, c->factors, 1);
        memcpy(rows[count++], row.level, sizeof row.level);
    }
    return count;
}

size_t fourwise_rows(uint64_t seed, size_t factors, const uint8_t *levels, const pairwise_need *needs,
                     size_t need_count, size_t most, uint8_t (*rows)[PAIRWISE_FACTORS]) {
    static fourwise c;
    c = (fourwise){.factors = factors, .need_count = need_count, .levels = levels, .needs = needs};
    uint32_t fours = 0;
    size_t of[4], count = 0;
    for (of[0] = 0; of[0] < factors; ++of[0]) {
        for (of[1] = of[0] + 1; of[1] < factors; ++of[1]) {
            for (of[2] = of[1] + 1; of[2] < factors; ++of[2]) {
                for (of[3] = of[2] + 1; of[3] < factors; ++of[3]) {
                    c.first[of[0]][of[1]][of[2]][of[3]] = fours;
                    fours += (uint32_t)levels[of[0]] * levels[of[1]] * levels[of[2]] * levels[of[3]];
                }
            }
        }
    }
    c.met = calloc(fours, 1);
    if (!c.met) {
        return 0;
    }
    random_state r = {seed};
    for (of[0] = 0; of[0] < factors; ++of[0]) {
        for (of[1] = of[0] + 1; of[1] < factors; ++of[1]) {
            for (of[2] = of[1] + 1; of[2] < factors; ++of[2]) {
                for (of[3] = of[2] + 1; of[3] < factors; ++of[3]) {
                    count += rows_of_four(&c, &r, of, most - count, rows + count);
                }
            }
        }
    }
    free(c.met);
    return count;
}
