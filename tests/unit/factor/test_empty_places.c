/* Data of few components: what rounding to 8 bits left goes to the places of a unit that no component needs.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/factor/empty_places.h"
#include "encoder/factor/factor.h"
#include "encoder/factor/measure.h"
#include "encoder/factor/round.h"
#include "tests/support/test.h"
#include "tests/support/uniform.h"

static const enc_context one = {.threads = 1}, two = {.threads = 2};

enum { SIDE = 9, VIEWS = 7, LIGHTS = 8, SWEEPS = 2 };

/* One reflectance, of random values, times the albedo of each texel: the same for all, or random too. */
static enc_data *make(const enc_context *context, bool textured, const float colour[3]) {
    enc_direction directions[LIGHTS];
    enc_data *data = NULL;
    uint32_t state = 3;
    float profile[VIEWS * LIGHTS];
    directions[0] = enc_direction_from_angles(0, 0);
    for (int i = 1; i < LIGHTS; i++) {
        directions[i] = enc_direction_from_angles(10 + 5 * i, i * 40);
    }
    assert_int_equal(enc_data_create(context, SIDE, SIDE, VIEWS, directions, LIGHTS, directions, &data), BTF_OK);
    for (size_t i = 0; i < VIEWS * LIGHTS; i++) {
        profile[i] = 0.1f + 0.8f * uniform(&state);
    }
    for (size_t t = 0; t < SIDE * SIDE; t++) {
        const float albedo = textured ? 0.2f + 0.8f * uniform(&state) : 1.0f;
        for (size_t i = 0; i < VIEWS * LIGHTS; i++) {
            for (size_t c = 0; c < 3; c++) {
                data->samples[((t * VIEWS + i / LIGHTS) * 3 + c) * LIGHTS + i % LIGHTS] =
                    albedo * colour[c] * profile[i];
            }
        }
    }
    return data;
}

/* dB before and after one unit of class 0 is filled. */
typedef struct gain {
    double before, after;
} gain;

static double decibels(const enc_factor_matrix *m, const enc_factor_codes *codes) {
    enc_factor_error error;
    assert_int_equal(enc_factor_measure(m, codes, &error), BTF_OK);
    return -10 * log10(error.linear);
}

/* Fills, and looks that codes and steps that were there are as they were, and that what is added is in levels. */
static void fill(const enc_factor_matrix *m, const enc_components components[3], enc_factor_codes *codes) {
    size_t rank[3];
    float first[3];
    for (int c = 0; c < 3; c++) {
        rank[c] = codes->channel[c].rank;
        first[c] = rank[c] > 0 ? codes->channel[c].u[0] * codes->channel[c].step_w[0] : 0;
    }
    assert_int_equal(enc_factor_fill_places(m, components, codes), BTF_OK);
    for (int c = 0; c < 3; c++) {
        const enc_factor_channel *to = &codes->channel[c];
        assert_int_equal(to->rank, rank[c] > 0 ? 4 * codes->plan.words[0][c] : 0);
        assert_true(rank[c] == 0 || to->u[0] * to->step_w[0] == first[c]);
        for (size_t i = 0; i < to->rank * codes->texels; i++) {
            const float step = to->step_u[i / codes->texels], level = step > 0 ? to->u[i] / step : 0;
            assert_true(fabsf(level - rintf(level)) < 1e-3f && fabsf(level) < 127.5f && (step > 0 || to->u[i] == 0));
        }
        for (size_t j = 1; j < to->rank; j++) { /* a word has one scale */
            assert_true(to->place[j].group != to->place[j - 1].group ||
                        (to->step_u[j] == to->step_u[j - 1] && to->step_w[j] == to->step_w[j - 1]));
        }
    }
}

static gain measure(const enc_context *context, bool textured, const float colour[3], const uint32_t words[3]) {
    const size_t ranks[3] = {20, 20, 20};
    enc_data *data = make(context, textured, colour);
    const enc_factor_matrix m = enc_factor_matrix_of(context, data);
    enc_components components[3] = {{0}};
    const enc_factor_plan plan = {{{words[0], words[1], words[2]}}};
    enc_factor_codes codes;
    gain found;
    assert_int_equal(enc_components_find(&m, ranks, 1, components), BTF_OK);
    for (int c = 0; c < 3; c++) { /* without what rounding of the samples to float makes of one component */
        components[c].rank = components[c].rank > 0 && words[c] > 0;
    }
    assert_int_equal(enc_factor_codes_create(&m, &plan, components, &codes), BTF_OK);
    assert_int_equal(enc_factor_round(&m, components, SWEEPS, &codes), BTF_OK);
    found.before = decibels(&m, &codes);
    fill(&m, components, &codes);
    found.after = decibels(&m, &codes);
    enc_factor_codes_clear(&codes);
    for (int c = 0; c < 3; c++) {
        enc_components_clear(&components[c]);
    }
    enc_data_destroy(&data);
    return found;
}

/* A grey reflectance has three words for itself, which 8 bits more go to. */
TEST(test_one_reflectance) {
    const float grey[3] = {1, 1, 1};
    const gain found = measure(&one, false, grey, (uint32_t[3]){4, 0, 0}), again = measure(&two, false, grey, (uint32_t[3]){4, 0, 0});
    assert_true(found.before < 60);
    assert_true(found.after > 100);
    assert_true(again.after == found.after);
}

/* In colour there is one word for a channel: the places beside the component have its scale. */
TEST(test_one_reflectance_in_colour) {
    const float colour[3] = {0.9f, 0.5f, 0.2f};
    const gain found = measure(&one, false, colour, (uint32_t[3]){2, 1, 1});
    assert_true(found.before < 60);
    assert_true(found.after > 85);
}

/* Texels that differ, whose u are rounded, too. */
TEST(test_textured) {
    const float grey[3] = {1, 1, 1}, colour[3] = {0.9f, 0.5f, 0.2f};
    const gain of_grey = measure(&one, true, grey, (uint32_t[3]){4, 0, 0}),
               of_colour = measure(&one, true, colour, (uint32_t[3]){2, 1, 1});
    assert_true(of_grey.before < 60 && of_grey.after > 100);
    assert_true(of_colour.before < 60 && of_colour.after > 80);
}

/* Channels without a component, and without an empty place, stay as they are. */
TEST(test_nothing_to_fill) {
    const float grey[3] = {1, 1, 1};
    const size_t ranks[3] = {20, 20, 20};
    enc_data *data = make(&one, true, grey);
    const enc_factor_matrix m = enc_factor_matrix_of(&one, data);
    enc_components components[3] = {{0}};
    const enc_factor_plan plan = {{{1, 0, 0}}};
    enc_factor_codes codes;
    assert_int_equal(enc_components_find(&m, ranks, 1, components), BTF_OK);
    assert_true(components[0].rank >= 4);
    assert_int_equal(enc_factor_codes_create(&m, &plan, components, &codes), BTF_OK);
    assert_int_equal(enc_factor_round(&m, components, SWEEPS, &codes), BTF_OK);
    const double before = decibels(&m, &codes);
    const float *u = codes.channel[0].u;
    assert_int_equal(enc_factor_fill_places(&m, components, &codes), BTF_OK);
    assert_ptr_equal(codes.channel[0].u, u);
    assert_int_equal(codes.channel[0].rank, 4);
    assert_true(decibels(&m, &codes) == before);
    enc_factor_codes_clear(&codes);
    for (int c = 0; c < 3; c++) {
        enc_components_clear(&components[c]);
    }
    enc_data_destroy(&data);
}

/* An encode fills its places. */
TEST(test_encode) {
    const float grey[3] = {1, 1, 1};
    enc_data *data = make(&one, false, grey);
    const enc_factor_options options = {.budget = 1000000, .match = ENC_FACTOR_NO_MATCH, .measure = true};
    enc_factors *factors = NULL;
    assert_int_equal(enc_factor_encode(&one, data, &options, &factors), BTF_OK);
    assert_int_equal(factors->n_units, 1);
    assert_true(factors->error.linear < 1e-10);
    enc_factors_destroy(&factors);
    enc_data_destroy(&data);
}

RUN_TESTS(NULL, NULL)
