/* Lagrange's multiplier, then whole units. See allocate.h.
 *
 * Each component alone would take the class of the least error + price * bytes (Shoham and Gersho 1988); a
 * bisection finds the price that meets the budget. Units then have to be whole. Two classes have two texels
 * of u a unit, the others one, so that only so many combinations of both exhaust the budget: for each of
 * them the nearest plan is improved by moving words from channel to channel and units from class to class
 * until nothing gains.
 *
 * SPDX-License-Identifier: MIT
 */
#include "allocate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BISECTIONS = 60, SPLITS = 15 };

uint32_t enc_factor_units(const enc_factor_plan *plan, int class) {
    const uint32_t *words = plan->words[class];
    return (words[0] + words[1] + words[2]) / ENC_FACTOR_UNIT_WORDS;
}

uint32_t enc_factor_all_units(const enc_factor_plan *plan) {
    uint32_t units = 0;
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        units += enc_factor_units(plan, k);
    }
    return units;
}

uint32_t enc_factor_u_texels(const enc_factor_plan *plan) {
    uint32_t texels = 0;
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        texels += enc_factor_units(plan, k) * (uint32_t)enc_factor_classes[k].u_texels;
    }
    return texels;
}

size_t enc_factor_held(const enc_factor_plan *plan, int class, int channel, size_t rank) {
    const size_t held = plan->words[class][channel] * enc_factor_classes[class].word;
    return class == 0 && held > rank ? rank : held;
}

static uint64_t bytes_of(size_t texels, size_t n_views, size_t n_lights, uint64_t units,
                         uint64_t u_texels) {
    return 16 * (units * n_views * n_lights + u_texels * texels + units + 3 * (uint64_t)n_views);
}

uint64_t enc_factor_bytes(const enc_factor_plan *plan, size_t texels, size_t n_views, size_t n_lights) {
    return bytes_of(texels, n_views, n_lights, enc_factor_all_units(plan), enc_factor_u_texels(plan));
}

typedef struct search {
    const enc_factor_energies *energies;
    double *sums[ENC_FACTOR_CHANNELS]; /* [rank + 1]: energy of the first components */
    size_t texels, columns;
} search;

static double rounding_of(const enc_factor_energies *energies, int class) {
    return energies->rounding ? energies->rounding[class] : enc_factor_classes[class].error;
}

/* The error that a plan leaves; infinite where it holds more components than there are. */
static double error_of(const search *s, const enc_factor_plan *plan) {
    double error = 0;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        const size_t rank = s->energies->rank[c];
        size_t at = 0;
        for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
            const size_t held = enc_factor_held(plan, k, c, rank);
            if (held > rank - at) {
                return INFINITY;
            }
            error += rounding_of(s->energies, k) * (s->sums[c][at + held] - s->sums[c][at]);
            at += held;
        }
        error += s->sums[c][rank] - s->sums[c][at];
    }
    return error;
}

double enc_factor_plan_error(const enc_factor_energies *energies, const enc_factor_plan *plan,
                             int first_rounded) {
    double error = 0;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        size_t at = 0;
        for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
            const size_t held = enc_factor_held(plan, k, c, energies->rank[c] - at);
            for (size_t i = 0; i < held && at < energies->rank[c]; i++) {
                error += (k >= first_rounded ? rounding_of(energies, k) : 0) * energies->energy[c][at];
                at++;
            }
        }
        while (at < energies->rank[c]) {
            error += energies->energy[c][at++];
        }
    }
    return error;
}

/* The words of each channel in a unit: one of the ways to divide its four words among three channels. */
static void split_words(int split, uint32_t out[ENC_FACTOR_CHANNELS]) {
    int at = 0;
    for (uint32_t a = 0; a <= ENC_FACTOR_UNIT_WORDS; a++) {
        for (uint32_t b = 0; a + b <= ENC_FACTOR_UNIT_WORDS; b++, at++) {
            if (at == split) {
                out[0] = ENC_FACTOR_UNIT_WORDS - a - b;
                out[1] = a;
                out[2] = b;
            }
        }
    }
}

static bool take_unit(enc_factor_plan *plan, int class, int split) {
    uint32_t words[ENC_FACTOR_CHANNELS];
    split_words(split, words);
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        if (plan->words[class][c] < words[c]) {
            return false;
        }
    }
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        plan->words[class][c] -= words[c];
    }
    return true;
}

static void add_unit(enc_factor_plan *plan, int class, int split) {
    uint32_t words[ENC_FACTOR_CHANNELS];
    split_words(split, words);
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        plan->words[class][c] += words[c];
    }
}

/* Finds the best plan that has a unit more, or one less, among the classes whose units take `u_texels`
 * texels of u. Returns its error. */
static double best_step(const search *s, const enc_factor_plan *from, size_t u_texels, bool more,
                        enc_factor_plan *out) {
    double least = INFINITY;
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        for (int split = 0; split < SPLITS && enc_factor_classes[k].u_texels == u_texels; split++) {
            enc_factor_plan plan = *from;
            if (more) {
                add_unit(&plan, k, split);
            } else if (!take_unit(&plan, k, split)) {
                continue;
            }
            const double error = error_of(s, &plan);
            if (error < least) {
                least = error;
                *out = plan;
            }
        }
    }
    return least;
}

/* Finds the best move of one word from channel to channel within a class. Returns the least error, `least`
 * where no move gains. */
static double best_word_move(const search *s, const enc_factor_plan *from, double least,
                             enc_factor_plan *out) {
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        for (int move = 0; move < 9; move++) {
            const int a = move / 3, b = move % 3;
            enc_factor_plan plan = *from;
            if (a == b || plan.words[k][a] == 0) {
                continue;
            }
            plan.words[k][a]--;
            plan.words[k][b]++;
            const double error = error_of(s, &plan);
            if (error < least) {
                least = error;
                *out = plan;
            }
        }
    }
    return least;
}

/* Finds the best move of one unit between classes whose units take as many texels of u. Returns as
 * best_word_move does. */
static double best_unit_move(const search *s, const enc_factor_plan *from, double least,
                             enc_factor_plan *out) {
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        for (int to = 0; to < ENC_FACTOR_CLASSES; to++) {
            for (int i = 0; i < SPLITS * SPLITS; i++) {
                enc_factor_plan plan = *from;
                if (k == to || enc_factor_classes[k].u_texels != enc_factor_classes[to].u_texels ||
                    !take_unit(&plan, k, i / SPLITS)) {
                    continue;
                }
                add_unit(&plan, to, i % SPLITS);
                const double error = error_of(s, &plan);
                if (error < least) {
                    least = error;
                    *out = plan;
                }
            }
        }
    }
    return least;
}

/* Adds or takes away units until `units` says how many take one texel of u and how many two, then makes
 * moves as long as they gain. */
static double fit_units(const search *s, const uint32_t units[2], enc_factor_plan *plan) {
    double error = error_of(s, plan);
    for (size_t u_texels = 1; u_texels <= 2; u_texels++) {
        for (;;) {
            uint32_t have = 0;
            for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
                have += enc_factor_classes[k].u_texels == u_texels ? enc_factor_units(plan, k) : 0;
            }
            enc_factor_plan next;
            const bool more = have < units[u_texels - 1];
            if (have == units[u_texels - 1]) {
                break;
            }
            const double then = best_step(s, plan, u_texels, more, &next);
            if (isinf(then) || (more && !(then < error))) {
                break; /* nothing is left that a unit could hold */
            }
            *plan = next;
            error = then;
        }
    }
    for (;;) {
        enc_factor_plan next;
        double least = best_word_move(s, plan, error, &next);
        least = least < error ? least : best_unit_move(s, plan, error, &next);
        if (!(least < error * (1 - 1e-12))) {
            return error;
        }
        *plan = next;
        error = least;
    }
}

static double component_bytes(const search *s, int class) {
    const enc_factor_class *k = &enc_factor_classes[class];
    return 4.0 * (double)(s->texels * k->u_texels + s->columns) / (double)k->word;
}

/* Counts the components of each channel that go to each class when a byte costs `price`; returns their
 * bytes. */
static double count_at(const search *s, double price,
                       size_t counts[ENC_FACTOR_CLASSES][ENC_FACTOR_CHANNELS]) {
    double bytes = 0;
    memset(counts, 0, sizeof(size_t) * ENC_FACTOR_CLASSES * ENC_FACTOR_CHANNELS);
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        for (size_t j = 0; j < s->energies->rank[c]; j++) {
            double least = s->energies->energy[c][j];
            int best = -1;
            for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
                const double cost =
                    s->energies->energy[c][j] * rounding_of(s->energies, k) + price * component_bytes(s, k);
                if (cost < least) {
                    least = cost;
                    best = k;
                }
            }
            if (best >= 0) {
                counts[best][c]++;
                bytes += component_bytes(s, best);
            }
        }
    }
    return bytes;
}

/* The plan of the bisection, with words and units rounded down. */
static enc_factor_plan rough_plan(const search *s, double budget) {
    size_t counts[ENC_FACTOR_CLASSES][ENC_FACTOR_CHANNELS];
    double high = 1e-30;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        high += s->sums[c][s->energies->rank[c]]; /* a price at which nothing is bought */
    }
    double low = 1e-18 * high;
    for (int i = 0; i < BISECTIONS; i++) {
        const double middle = sqrt(low * high);
        if (count_at(s, middle, counts) <= budget) {
            high = middle;
        } else {
            low = middle;
        }
    }
    count_at(s, high, counts);
    enc_factor_plan plan = {{{0}}};
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        uint32_t sum = 0;
        for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
            const size_t word = enc_factor_classes[k].word;
            plan.words[k][c] = (uint32_t)(counts[k][c] / word);
            sum += plan.words[k][c];
        }
        for (int c = 0; sum % ENC_FACTOR_UNIT_WORDS > 0; c = (c + 1) % ENC_FACTOR_CHANNELS) {
            while (plan.words[k][c] > 0 && sum % ENC_FACTOR_UNIT_WORDS > 0) {
                plan.words[k][c]--;
                sum--;
            }
        }
    }
    return plan;
}

/* The best of all combinations of units of one and of two texels of u that exhaust the budget. */
static bool allocate(const search *s, size_t n_views, size_t n_lights, uint64_t budget,
                     enc_factor_plan *out) {
    const enc_factor_plan rough = rough_plan(s, (double)budget);
    double least = INFINITY;
    const uint32_t most = ENC_FACTOR_MOST_UNITS;
    for (uint32_t twos = 0; twos <= most / 2; twos++) {
        if (bytes_of(s->texels, n_views, n_lights, twos, 2 * (uint64_t)twos) > budget) {
            break;
        }
        uint32_t ones = 0;
        while (ones + 2 * twos < most &&
               bytes_of(s->texels, n_views, n_lights, ones + 1 + twos, ones + 1 + 2 * twos) <= budget) {
            ones++;
        }
        enc_factor_plan plan = rough;
        const double error = fit_units(s, (uint32_t[2]){ones, twos}, &plan);
        const uint32_t units = enc_factor_all_units(&plan);
        const bool fits = units > 0 && units <= most && enc_factor_u_texels(&plan) <= most &&
                          enc_factor_bytes(&plan, s->texels, n_views, n_lights) <= budget;
        if (fits && error < least) {
            least = error;
            *out = plan;
        }
    }
    return !isinf(least);
}

bool enc_factor_allocate(const enc_factor_energies *energies, size_t texels, size_t n_views,
                         size_t n_lights, uint64_t budget, enc_factor_plan *out_plan) {
    search s = {.energies = energies, .texels = texels, .columns = n_views * n_lights};
    const enc_factor_plan one = {{{ENC_FACTOR_UNIT_WORDS, 0, 0}}};
    bool room = true, found = enc_factor_bytes(&one, texels, n_views, n_lights) <= budget;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        s.sums[c] = calloc(energies->rank[c] + 1, sizeof(double));
        room = room && s.sums[c];
        for (size_t j = 0; j < energies->rank[c] && s.sums[c]; j++) {
            s.sums[c][j + 1] = s.sums[c][j] + energies->energy[c][j];
        }
    }
    *out_plan = one;
    if (room && found) {
        /* black data have no components at all: then one unit of zeros stays */
        allocate(&s, n_views, n_lights, budget, out_plan);
    }
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        free(s.sums[c]);
    }
    return room && found;
}
