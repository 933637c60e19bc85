/* The fit of the cost model: it finds the prices from which timings were made, and none below 0.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/bench/plan/cost_fit.h"
#include "tests/conformance/random.h"
#include "tests/support/test.h"

enum { SAMPLES = 60 };

/* Prices as a GPU might have them; two of the counts cost nothing. */
static const btf_cost_model made = {.struct_size = sizeof made,
                                    .pixel = 3,
                                    .look_up = 7,
                                    .point = 0.9,
                                    .move = 4,
                                    .step = 0,
                                    .fetch = 1.2,
                                    .byte = 0,
                                    .integer = 0.02,
                                    .real = 0.03,
                                    .masked = 0.01};

static btf_decode_counts random_counts(random_state *r) {
    return (btf_decode_counts){.pixels = 1,
                               .look_ups = random_below(r, 4),
                               .points = 1 + random_below(r, 12),
                               .moves = random_below(r, 2) * 4,
                               .steps = random_below(r, 60),
                               .fetches = 10 + random_below(r, 200),
                               .bytes = 10 + random_below(r, 3000),
                               .integers = random_below(r, 9000),
                               .floats = random_below(r, 900),
                               .masked = random_below(r, 2) * random_below(r, 5000)};
}

static void make_samples(double noise, cost_sample samples[SAMPLES]) {
    random_state r = {3};
    for (int i = 0; i < SAMPLES; i++) {
        samples[i].counts = random_counts(&r);
        samples[i].ns = btf_cost_of(&samples[i].counts, &made) * (1 + noise * random_between(&r, -1, 1));
    }
}

TEST(prices_are_found_again) {
    cost_sample samples[SAMPLES];
    btf_cost_model found;
    make_samples(0, samples);
    const cost_deviation d = cost_fit(samples, SAMPLES, &found);
    assert_int_equal(d.count, SAMPLES);
    assert_true(d.worst < 1e-6 && d.mean <= d.worst);
#define SAME(price, name, count) assert_true(fabs(found.price - made.price) < 1e-5 * (made.price + 0.01));
    BTF_COST_LIST(SAME)
}

TEST(noise_moves_them_little) {
    cost_sample samples[SAMPLES];
    btf_cost_model found;
    make_samples(0.05, samples);
    const cost_deviation d = cost_fit(samples, SAMPLES, &found);
    assert_true(d.mean > 0.01 && d.mean < 0.04 && d.worst < 0.08);
#define POSITIVE(price, name, count) assert_true(found.price >= 0);
    BTF_COST_LIST(POSITIVE)
    assert_true(fabs(found.integer / made.integer - 1) < 0.1 && fabs(found.fetch / made.fetch - 1) < 0.1);
}

/* A count whose least-squares price would be negative costs nothing, and the other prices make up for it. */
TEST(none_is_below_zero) {
    cost_sample samples[SAMPLES];
    btf_cost_model found;
    make_samples(0, samples);
    for (int i = 0; i < SAMPLES; i++) {
        samples[i].ns -= 0.3 * samples[i].counts.look_ups * made.look_up +
                         0.8 * samples[i].counts.look_ups * made.look_up;
    }
    for (int i = 0; i < SAMPLES; i++) {
        samples[i].ns = fmax(samples[i].ns, 1);
    }
    cost_fit(samples, SAMPLES, &found);
    assert_true(found.look_up == 0 && found.integer > 0);
}

/* A count that is 0 in every sample gets the price 0. */
TEST(unknown_counts_cost_nothing) {
    cost_sample samples[SAMPLES];
    btf_cost_model found;
    make_samples(0, samples);
    for (int i = 0; i < SAMPLES; i++) {
        samples[i].ns -= samples[i].counts.moves * made.move;
        samples[i].counts.moves = 0;
    }
    assert_true(cost_fit(samples, SAMPLES, &found).worst < 1e-6);
    assert_true(found.move == 0 && fabs(found.look_up - made.look_up) < 1e-4);
}

RUN_TESTS(NULL, NULL)
