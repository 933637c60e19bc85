/* Expected gains and costs of fits, from planted sums.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/nodes/expect.h"
#include "tests/support/test.h"

/* A choice of one candidate. The squared error with samples left out is `error`; `aim` is the cosine between that error
 * and the candidate's move of the blend. */
static enc_fit_choice choice_of(double error, double aim, double move, double moves, enc_fit_error at) {
    const double product = aim * sqrt(move * error);
    const enc_fit_moved moved = {error, error - 2 * product + move, move, moves};
    enc_fit_moved all[ENC_FIT_CANDIDATES] = {[1] = moved};
    enc_fit_choice choice = {.candidate = {[1] = {.judged = true, .at = at}}};
    enc_fit_expect(all, all, &choice);
    return choice;
}

TEST(test_smooth_error_falls_with_the_fourth_power_of_the_gap) {
    const enc_fit_error none = {0, 0};
    /* a fit that removes all of the error: a thirtieth is left between the samples, and the fit removes that */
    enc_fit_choice c = choice_of(3e-3, 1, 3e-3, 1e-4, none);
    assert_true(fabs(c.candidate[0].left_out.linear - 3e-3) < 1e-9);
    assert_true(fabs(c.candidate[1].left_out.srgb) < 1e-9);
    assert_true(fabs(c.candidate[0].between.linear - 1e-4) < 1e-9);
    assert_true(fabs(c.candidate[1].gain.linear - 1e-4) < 1e-9);
    assert_true(fabs(c.candidate[1].between.srgb) < 1e-9);
    /* a fit whose move is at a right angle to the error: half is left, and the fit adds its move to it */
    c = choice_of(3e-3, 0, 1e-4, 1e-4, none);
    assert_true(fabs(c.candidate[0].between.linear - 1.5e-3) < 1e-9);
    assert_true(fabs(c.candidate[1].gain.linear + 1e-4) < 1e-9);
}

TEST(test_the_coder_adds_to_both_places) {
    const enc_fit_choice c = choice_of(3e-3, 0.5, 1e-3, 5e-4, (enc_fit_error){2e-4, 1e-4});
    const enc_fit_error coder = {8e-4, 4e-4};
    const enc_fit_error at = enc_fit_coded_at(&c.candidate[1], coder),
                        between = enc_fit_coded_between(&c.candidate[1], coder);
    assert_true(fabs(at.linear - 1e-3) < 1e-9 && fabs(at.srgb - 5e-4) < 1e-9);
    assert_true(fabs(between.linear - c.candidate[1].between.linear - 2e-4) < 1e-9);
    assert_true(fabs(between.srgb - c.candidate[1].between.srgb - 1e-4) < 1e-9);
}

/* A measurement gives the coder's share of the error, and never a share of 0. */
TEST(test_the_coder_is_known_better_afterwards) {
    enc_fit_choice c = choice_of(3e-3, 0.5, 1e-3, 5e-4, (enc_fit_error){2e-4, 2e-4});
    c.coder = (enc_fit_error){4e-4, 4e-4};
    c.chosen = 1;
    const enc_fit_error worse = enc_fit_coder_measured(&c, (enc_fit_error){9e-4, 6e-4});
    assert_true(fabs(worse.linear - 7e-4) < 1e-9 && fabs(worse.srgb - 4e-4) < 1e-9);
    const enc_fit_error better = enc_fit_coder_measured(&c, (enc_fit_error){3e-4, 1.5e-4});
    assert_true(fabs(better.linear - 2e-4) < 1e-9 && fabs(better.srgb - 1e-4) < 1e-9);
    c.chosen = 0;
    const enc_fit_error alone = enc_fit_coder_measured(&c, (enc_fit_error){9e-4, 1e-4});
    assert_true(fabs(alone.linear - 9e-4) < 1e-9 && fabs(alone.srgb - 1e-4) < 1e-9);
}

TEST(test_a_gain_between_is_weighed_against_the_loss_at_the_samples) {
    enc_fit_choice c = choice_of(3e-3, 0.5, 1e-3, 5e-4, (enc_fit_error){0, 0});
    assert_true(c.candidate[1].gain.linear > 0);
    c.coder = (enc_fit_error){1e-3, 1e-3};
    const double free_of_charge = enc_fit_value(&c, &c.candidate[1]);
    assert_true(free_of_charge > 0);
    c.candidate[1].at = (enc_fit_error){3e-4, 3e-4};
    assert_true(enc_fit_allowed(&c, &c.candidate[1]));
    const double paid = enc_fit_value(&c, &c.candidate[1]);
    const double loss = 10 * log10((1.3e-3 + 1 / 65025.0) / (1e-3 + 1 / 65025.0));
    assert_true(fabs(free_of_charge - paid - loss / 8) < 1e-9);
    c.candidate[1].at = (enc_fit_error){3.1e-4, 3.1e-4};
    assert_false(enc_fit_allowed(&c, &c.candidate[1]));
    c.coder = (enc_fit_error){0, 0};
    c.candidate[1].at = (enc_fit_error){1, 0.3 / 65025.0 * 0.99};
    assert_true(enc_fit_allowed(&c, &c.candidate[1]));
}

RUN_TESTS(NULL, NULL)
