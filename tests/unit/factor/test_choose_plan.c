/* Plans of few units are chosen by trial: the allocation's plan is replaced where another leaves less error, and stays
 * where there are many units.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/factor/choose_plan.h"
#include "encoder/factor/components.h"
#include "encoder/factor/measure.h"
#include "encoder/factor/round.h"
#include "encoder/math/symmetric.h"
#include "tests/support/test.h"
#include "tests/support/uniform.h"

static const enc_context one = {.threads = 1}, two = {.threads = 2};

enum { SIDE = 20, VIEWS = 14, LIGHTS = 15, WEAK = 40, SWEEPS = 2 };

/* Grey data: one strong component and WEAK others of amplitude `weak`, more than 16 codes of 8 bits hold. */
static enc_data *make(const enc_context *context, float weak) {
    enc_direction directions[LIGHTS];
    enc_data *data = NULL;
    uint32_t state = 1;
    float *u = malloc(SIDE * SIDE * WEAK * sizeof *u), *w = malloc(VIEWS * LIGHTS * WEAK * sizeof *w);
    directions[0] = enc_direction_from_angles(0, 0);
    for (int i = 1; i < LIGHTS; i++) {
        directions[i] = enc_direction_from_angles(15 + i, i * 7);
    }
    assert_int_equal(enc_data_create(context, SIDE, SIDE, VIEWS, directions, LIGHTS, directions, &data), BTF_OK);
    assert_true(u && w);
    for (size_t i = 0; i < SIDE * SIDE * WEAK; i++) {
        u[i] = uniform(&state) - 0.5f;
    }
    for (size_t i = 0; i < VIEWS * LIGHTS * WEAK; i++) {
        w[i] = uniform(&state) - 0.5f;
    }
    for (size_t t = 0; t < SIDE * SIDE; t++) {
        for (size_t v = 0; v < VIEWS; v++) {
            for (size_t l = 0; l < LIGHTS; l++) {
                float root = 0.6f;
                for (size_t j = 0; j < WEAK; j++) {
                    root += weak * u[t * WEAK + j] * w[(v * LIGHTS + l) * WEAK + j];
                }
                for (size_t c = 0; c < 3; c++) {
                    data->samples[((t * VIEWS + v) * 3 + c) * LIGHTS + l] = root * root;
                }
            }
        }
    }
    free(u);
    free(w);
    return data;
}

static double error_of(const enc_factor_matrix *m, const enc_components components[3],
                       const enc_factor_plan *plan) {
    enc_factor_codes codes;
    enc_factor_error error;
    assert_int_equal(enc_factor_codes_create(m, plan, components, &codes), BTF_OK);
    assert_int_equal(enc_factor_round(m, components, SWEEPS, &codes), BTF_OK);
    assert_int_equal(enc_factor_measure(m, &codes, &error), BTF_OK);
    enc_factor_codes_clear(&codes);
    return error.linear;
}

/* Makes the allocation's plan for the bytes of `units` units of one texel of u each, and the plan that is chosen. */
static void plan(const enc_factor_matrix *m, const enc_components components[3], unsigned units,
                 enc_factor_plan *out_was, enc_factor_plan *out_is) {
    const enc_factor_plan all = {.words = {{4 * units, 0, 0}}};
    const uint64_t budget = enc_factor_bytes(&all, SIDE * SIDE, VIEWS, LIGHTS);
    enc_factor_energies energies = {.rounding = NULL};
    for (int c = 0; c < 3; c++) {
        energies.rank[c] = components[c].rank;
        energies.energy[c] = components[c].energy;
    }
    assert_true(enc_factor_allocate(&energies, SIDE * SIDE, VIEWS, LIGHTS, budget, out_was));
    *out_is = *out_was;
    assert_int_equal(enc_choose_plan(m, components, budget, SWEEPS, out_is), BTF_OK);
    assert_true(enc_factor_bytes(out_is, SIDE * SIDE, VIEWS, LIGHTS) <= budget);
}

TEST(test_trial_beats_expectation) {
    const size_t ranks[3] = {120, 8, 8};
    const enc_context *contexts[2] = {&one, &two};
    enc_factor_plan chosen[2];
    for (int i = 0; i < 2; i++) {
        enc_data *data = make(contexts[i], 0.3f);
        const enc_factor_matrix m = enc_factor_matrix_of(contexts[i], data);
        enc_components components[3] = {{0}};
        enc_factor_plan was, is;
        assert_int_equal(enc_components_find(&m, ranks, 1, components), BTF_OK);
        plan(&m, components, 1, &was, &chosen[i]);
        assert_int_equal(enc_factor_units(&was, 0), 1); /* 16 of 41 components, as 8 bits are thought to pay */
        assert_int_equal(enc_factor_units(&chosen[i], 0), 0);
        assert_true(error_of(&m, components, &chosen[i]) < 0.8 * error_of(&m, components, &was));
        plan(&m, components, ENC_CHOOSE_MOST_UNITS + 1, &was, &is);
        assert_memory_equal(&was, &is, sizeof was);
        for (int c = 0; c < 3; c++) {
            enc_components_clear(&components[c]);
        }
        enc_data_destroy(&data);
    }
    assert_memory_equal(&chosen[0], &chosen[1], sizeof chosen[0]);
}

/* The random product with a matrix of one component, such as an all-white channel, has rows that are multiples of one
 * another. They must become orthonormal all the same and span that row; two rounds of orthogonalisation do not reach
 * this. */
TEST(test_multiples_of_one_row) {
    enum { RANK = 96, COUNT = 240 };
    enc_data *data = make(&two, 0);
    const enc_factor_matrix m = enc_factor_matrix_of(&two, data);
    float *x = malloc(RANK * COUNT * sizeof *x), row[COUNT];
    double *gram = malloc(RANK * RANK * sizeof *gram), square = 0, held = 0, far = 0;
    uint32_t random = 9;
    assert_true(x && gram);
    for (size_t i = 0; i < COUNT; i++) {
        row[i] = 0.7f;
        square += (double)row[i] * row[i];
    }
    for (size_t j = 0; j < RANK; j++) {
        const float factor = uniform(&random) - 0.5f;
        for (size_t i = 0; i < COUNT; i++) {
            x[j * COUNT + i] = factor * row[i];
        }
    }
    assert_true(enc_components_orthonormalise(&m, RANK, COUNT, x));
    enc_gram_rows(1, RANK, COUNT, x, gram);
    for (size_t i = 0; i < RANK * RANK; i++) {
        far = fmax(far, i % (RANK + 1) == 0 ? fmin(fabs(gram[i] - 1), gram[i]) : fabs(gram[i]));
    }
    for (size_t j = 0; j < RANK; j++) {
        double part = 0;
        for (size_t i = 0; i < COUNT; i++) {
            part += (double)x[j * COUNT + i] * row[i];
        }
        held += part * part / square;
    }
    printf("%.2g from orthonormal, %.9f of the row is held\n", far, held);
    assert_true(far < 0.02 && fabs(held - 1) < 1e-3); /* two rounds: 0.09, 1.034 */
    free(x);
    free(gram);
    enc_data_destroy(&data);
}

RUN_TESTS(NULL, NULL)
