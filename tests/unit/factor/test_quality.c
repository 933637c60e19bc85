/* The search for the fewest bytes that reach a quality: it finds them in few tries, also where results differ from what
 * the search expects.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/allocation/quality.h"
#include "tests/support/test.h"

enum { SIDE = 24, DIRECTIONS = 20, RANK = 200, UNITS = 12 };

enum { TEXELS = SIDE * SIDE };

static void begin(const enc_factor_energies *energies, double quality, double decibels, uint64_t least,
                  enc_quality_search *out) {
    assert_true(enc_quality_begin(energies, TEXELS, DIRECTIONS, DIRECTIONS, UNITS * least, least, quality,
                                  decibels, out));
}

/* The quality in dB that a budget gives: a share of what the allocation predicts, and an offset. */
static double outcome(const enc_quality_search *s, size_t i, double share) {
    return share * s->expected[i] + 21;
}

static int search(enc_quality_search *s, double share) {
    int tries = 0;
    for (size_t next; (next = enc_quality_next(s)) < s->count; tries++) {
        assert_true(next > s->reaches && next < s->fails && tries < 20);
        enc_quality_note(s, next, outcome(s, next, share));
    }
    return tries;
}

TEST(test_ends_at_the_fewest_bytes) {
    static double energy[RANK];
    const enc_factor_energies energies = {.rank = {RANK}, .energy = {energy, energy, energy}};
    const enc_factor_plan unit = {{{4}}};
    const uint64_t least = enc_factor_bytes(&unit, TEXELS, DIRECTIONS, DIRECTIONS);
    int tries = 0, searches = 0;
    for (size_t j = 0; j < RANK; j++) {
        energy[j] = j == 0 ? 4000 : pow((double)j, -1.6);
    }
    for (double share = 0.9; share < 1.15; share += 0.1) {
        enc_quality_search s;
        for (double quality = 20; quality < 60; quality += 0.4) {
            begin(&energies, quality, 0, least, &s);
            if (outcome(&s, 0, share) < quality) {
                break;
            }
            begin(&energies, quality, outcome(&s, 0, share), least, &s);
            assert_true(s.count > 8 && s.budget[0] <= UNITS * least && s.budget[s.count - 1] == least);
            for (size_t i = 1; i < s.count; i++) {
                assert_true(s.budget[i] < s.budget[i - 1]);
            }
            tries += search(&s, share);
            searches++;
            assert_true(outcome(&s, s.reaches, share) >= quality);
            assert_true(s.reaches + 1 == s.count || outcome(&s, s.reaches + 1, share) < quality);
        }
    }
    printf("%d searches, %d tries\n", searches, tries);
    assert_true(searches > 30 && tries < 3 * searches);
}

RUN_TESTS(NULL, NULL)
