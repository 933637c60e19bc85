/* The allocation of bits against a bound that no plan can beat: Lagrange's dual of a problem in which each component is
 * coded alone, in any part of a unit. Sizes are such that factors of texels cost less, or more, than those of
 * directions. For small budgets also against all plans.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/allocation/allocate.h"
#include "tests/support/test.h"

enum { MOST = 1200 };
static double energy[3][MOST];

/* Energies that fall with a power, as those of measured materials do; C1 has a tenth of luma's, C2 a hundredth. */
static enc_factor_energies energies_of(size_t luma, size_t chroma, double exponent) {
    enc_factor_energies e = {{luma, chroma, chroma}, {energy[0], energy[1], energy[2]}, NULL};
    for (size_t j = 0; j < MOST; j++) {
        energy[0][j] = j == 0 ? 40 : pow((double)j, -exponent);
        energy[1][j] = 0.1 * energy[0][j];
        energy[2][j] = 0.01 * energy[0][j];
    }
    return e;
}

/* The bound: the greatest value, over all prices of a byte, of the least sum of error and price (every component takes
 * its best class), less the budget at that price. */
static double bound(const enc_factor_energies *e, double texels, double columns, double budget) {
    double best = 0;
    for (double price = 1e-14; price < 1; price *= 1.02) {
        double sum = -price * budget;
        for (int c = 0; c < 3; c++) {
            for (size_t j = 0; j < e->rank[c]; j++) {
                double least = e->energy[c][j];
                for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
                    const enc_factor_class *class = &enc_factor_classes[k];
                    const double bytes =
                        4 * (texels * (double)class->u_texels + columns) / (double)class->word;
                    least = fmin(least, e->energy[c][j] * class->error + price * bytes);
                }
                sum += least;
            }
        }
        best = fmax(best, sum);
    }
    return best;
}

typedef struct size_case {
    size_t side, directions;
    double budget, decibels; /* decibels: that whole units may cost; the fewer there are, the more */
} size_case;

TEST(test_near_the_bound) {
    static const size_case cases[] = {
        {64, 81, 2.36e6, 0.08},  {64, 81, 1.18e6, 0.25}, {128, 81, 7.03e6, 0.05},
        {256, 81, 22.9e6, 0.05}, {256, 81, 6e6, 0.25},   {256, 19, 22.9e6, 0.08},
        {400, 151, 75e6, 0.05},  {400, 151, 15e6, 0.25}, {32, 151, 5e6, 0.08},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (double exponent = 1.3; exponent < 2.5; exponent += 0.5) {
            const size_case *at = &cases[i];
            const size_t texels = at->side * at->side, columns = at->directions * at->directions;
            const size_t side = texels < columns ? texels : columns, luma = side < MOST ? side : MOST;
            const enc_factor_energies e = energies_of(luma, luma, exponent);
            enc_factor_plan plan;
            assert_true(enc_factor_allocate(&e, texels, at->directions, at->directions,
                                            (uint64_t)at->budget, &plan));
            const uint64_t bytes = enc_factor_bytes(&plan, texels, at->directions, at->directions);
            const double error = enc_factor_plan_error(&e, &plan, 0);
            const double least = bound(&e, (double)texels, (double)columns, (double)bytes);
            const double over = 10 * log10(error / least);
            print_message("%zux%zu, %zu directions, %.2f MB, exponent %.1f: %.2f MB in %u units and %u "
                          "texels, %.3f dB "
                          "over the bound\n",
                          at->side, at->side, at->directions, at->budget / 1e6, exponent,
                          (double)bytes / 1e6, enc_factor_all_units(&plan), enc_factor_u_texels(&plan),
                          over);
            assert_true(bytes <= (uint64_t)at->budget && over >= -1e-6 && over < at->decibels);
        }
    }
}

/* The least error of all plans of at most two units of each channel's words. */
TEST(test_best_of_all_small_plans) {
    for (int wide = 0; wide < 2; wide++) {
        const size_t texels = wide ? 100 : 6400, directions = wide ? 80 : 10; /* u or w costs more */
        const enc_factor_energies e = energies_of(60, 60, 1.9);
        const enc_factor_plan unit = {{{4, 0, 0}}};
        const uint64_t budget = 2 * enc_factor_bytes(&unit, texels, directions, directions) + 16;
        double least = INFINITY;
        for (int pair = 0; pair < ENC_FACTOR_CLASSES * ENC_FACTOR_CLASSES; pair++) {
            for (uint32_t words = 0; words < 9 * 9 * 9 * 9; words++) {
                const uint32_t b[4] = {words % 9, words / 9 % 9, words / 81 % 9, words / 729};
                const int p = pair / ENC_FACTOR_CLASSES, q = pair % ENC_FACTOR_CLASSES;
                const uint32_t each = p == q ? 8 : 4;
                enc_factor_plan plan = {{{0}}};
                if (b[0] + b[1] > each || b[2] + b[3] > 4 || p > q || (p == q && b[2] + b[3] > 0)) {
                    continue;
                }
                plan.words[p][0] = each - b[0] - b[1];
                plan.words[p][1] = b[0];
                plan.words[p][2] = b[1];
                if (p != q) {
                    plan.words[q][0] = 4 - b[2] - b[3];
                    plan.words[q][1] = b[2];
                    plan.words[q][2] = b[3];
                }
                bool fits = enc_factor_bytes(&plan, texels, directions, directions) <= budget;
                for (int c = 0; c < 3; c++) {
                    size_t held = 0;
                    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
                        held += enc_factor_held(&plan, k, c, e.rank[c]);
                    }
                    fits = fits && held <= e.rank[c];
                }
                least = fits ? fmin(least, enc_factor_plan_error(&e, &plan, 0)) : least;
            }
        }
        enc_factor_plan plan;
        assert_true(enc_factor_allocate(&e, texels, directions, directions, budget, &plan));
        const double over = 10 * log10(enc_factor_plan_error(&e, &plan, 0) / least);
        print_message("%zu texels, %zu directions: %.4f dB over the best of all plans\n", texels,
                      directions, over);
        assert_true(over > -1e-9 && over < 0.02);
    }
}

RUN_TESTS(NULL, NULL)
