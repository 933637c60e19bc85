/* The count of components that are signal, and the bytes that are worth spending, on data whose signal and noise are
 * known, against the truth without noise, which the encoder never sees.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/factor/factor.h"
#include "encoder/factor/signal.h"
#include "tests/support/test.h"

static const enc_context one = {.threads = 1}, two = {.threads = 2};
enum { SIDE = 20, DIRECTIONS = 20, TEXELS = SIDE * SIDE, COLUMNS = DIRECTIONS * DIRECTIONS, FOUND = 60 };
static const bool all[3] = {true, true, true}, luma[3] = {true, false, false};

static double uniform(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return ((double)(*state >> 11) + 0.5) * 0x1p-53;
}

static double normal(uint64_t *state) {
    const double radius = sqrt(-2 * log(uniform(state)));
    return radius * cos(6.283185307179586 * uniform(state));
}

static enc_data *empty(const enc_context *context, int side, int directions) {
    enc_direction at[64];
    for (int i = 0; i < 64; i++) {
        at[i] = enc_direction_from_angles(i, i * 7);
    }
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(context, side, side, directions, at, directions, at, &data), BTF_OK);
    return data;
}

/* Grey data of the spiked model. A root is 0.5 + a sum of `terms` products + noise of `deviation`, of varying strength
 * with `uneven`. The energy of product j is x2[j] times that of the noise in as many samples as the matrix's longer
 * side. `truth` has the same signal without the noise, and may be NULL. */
static void fill(enc_data *data, enc_data *truth, size_t terms, const double *x2, double deviation,
                 bool uneven) {
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights;
    const size_t columns = (size_t)data->n_views * lights, longer = texels > columns ? texels : columns;
    double *u = malloc((terms + 1) * texels * sizeof *u), *w = malloc((terms + 1) * columns * sizeof *w);
    uint64_t state = 5;
    assert_true(u && w);
    for (size_t j = 0; j < terms; j++) {
        const double size = sqrt(x2[j] * (double)longer / (double)(texels * columns)) * deviation;
        for (size_t i = 0; i < texels; i++) {
            u[j * texels + i] = size * normal(&state);
        }
        for (size_t i = 0; i < columns; i++) {
            w[j * columns + i] = normal(&state);
        }
    }
    for (size_t t = 0; t < texels; t++) {
        for (size_t i = 0; i < columns; i++) {
            double root = 0.5;
            for (size_t j = 0; j < terms; j++) {
                root += u[j * texels + t] * w[j * columns + i];
            }
            const size_t at = (t * columns + i / lights * lights) * 3 + i % lights;
            for (size_t c = 0; c < 3; c++) {
                const double heavy = uneven ? (i % 4 == 0 ? 1.9 : 0.35) : 1;
                const double noisy = root + heavy * deviation * normal(&state);
                data->samples[at + c * lights] = (float)(noisy > 0 ? noisy * noisy : 0);
                if (truth) {
                    truth->samples[at + c * lights] = (float)(root > 0 ? root * root : 0);
                }
            }
        }
    }
    free(u);
    free(w);
}

static void find(const enc_context *context, const enc_data *data, size_t luma_rank,
                 enc_components *components, enc_signal *signal) {
    const enc_factor_matrix m = enc_factor_matrix_of(context, data);
    const size_t ranks[3] = {luma_rank, luma_rank / 2, luma_rank / 2};
    *signal = (enc_signal){0};
    memset(components, 0, 3 * sizeof *components);
    assert_int_equal(enc_components_find(&m, ranks, 1, components), BTF_OK);
    assert_int_equal(enc_signal_find(&m, components, all, signal), BTF_OK);
}

static void clear(enc_components *components, enc_signal *signal) {
    for (int c = 0; c < 3; c++) {
        enc_components_clear(&components[c]);
    }
    enc_signal_clear(signal);
}

/* The mean is a component of luma; chroma is noise alone, even or uneven. The noise floor that is found must be the
 * variance of the noise in a sample, in each channel. */
TEST(test_noise_is_no_signal) {
    for (int uneven = 0; uneven < 2; uneven++) {
        enc_data *data = empty(&two, SIDE, DIRECTIONS);
        enc_components components[3];
        enc_signal signal;
        fill(data, NULL, 0, NULL, 0.01, uneven == 1);
        find(&two, data, FOUND, components, &signal);
        assert_int_equal(signal.rank[0], 1);
        assert_int_equal(signal.rank[1] + signal.rank[2], 0);
        assert_true(signal.share[0][0] > 0.99 && signal.share[0][1] < 0 && signal.share[1][0] < 0);
        const double noise = 1e-4 * (uneven ? (1.9 * 1.9 + 3 * 0.35 * 0.35) / 4 : 1) * TEXELS * COLUMNS;
        for (int c = 0; c < 3; c++) {
            /* wider where uneven: columns of each strength are not left out equally often */
            assert_true(fabs(signal.floor[c] / noise - 1) < (uneven ? 0.25 : 0.03));
        }
        clear(components, &signal);
        enc_data_destroy(&data);
    }
}

/* Components far above the noise count, and those far below do not. In square data one is worth keeping from x2 = 3
 * on. */
TEST_OF_NUMBERS(test_counts_what_is_above_the_noise) {
    static const double x2[] = {400, 200, 100, 60, 40, 25, 18, 14, 12, 10, 0.6, 0.5, 0.4, 0.3};
    enc_data *data = empty(&two, SIDE, DIRECTIONS);
    enc_components components[3];
    enc_signal signal;
    for (int i = 0; i < 14; i++) { /* luma has the noise of one channel and three times the energy */
        assert_true(x2[i] > 3.5 || x2[i] * 3 < 2);
    }
    fill(data, NULL, 14, x2, 0.01, false);
    find(&two, data, FOUND, components, &signal);
    assert_int_equal(signal.rank[0], 11);
    assert_int_equal(signal.rank[1] + signal.rank[2], 0);
    for (size_t j = 1; j < FOUND; j++) {
        assert_true(signal.share[0][j] <= signal.share[0][j - 1] && signal.share[0][j] <= 1);
    }
    clear(components, &signal);
    enc_data_destroy(&data);
}

/* The estimated shares add up to the error against the truth that the components remove. */
TEST_OF_NUMBERS(test_shares_are_gains_at_the_truth) {
    double x2[20];
    enc_data *data = empty(&two, SIDE, DIRECTIONS), *truth = empty(&two, SIDE, DIRECTIONS);
    enc_components components[3];
    enc_signal signal;
    for (int j = 0; j < 20; j++) {
        x2[j] = 8 * pow(0.9, j);
    }
    fill(data, truth, 20, x2, 0.01, false);
    find(&two, data, FOUND, components, &signal);
    const enc_factor_matrix m = enc_factor_matrix_of(&two, truth);
    uint8_t columns[COLUMNS];
    double before[3] = {0}, after[3], energy = 0, foretold = 0;
    memset(columns, 1, sizeof columns);
    for (size_t at = 1; at <= 19; at += 6) { /* from the mean on, six components at a time */
        const enc_factor_set u = {{at}, {components[0].u}}, w = {{at}, {components[0].w}};
        assert_int_equal(enc_factor_residual(&m, &u, &w, columns, after), BTF_OK);
        if (at > 1) {
            energy = foretold = 0;
            for (size_t j = at - 6; j < at; j++) {
                energy += components[0].energy[j];
                foretold += components[0].energy[j] * signal.share[0][j];
            }
            assert_true(fabs((before[0] - after[0]) - foretold) < 0.15 * energy);
        }
        before[0] = after[0];
    }
    clear(components, &signal);
    enc_data_destroy(&truth);
    enc_data_destroy(&data);
}

/* In noiseless data with a long tail all components that were computed count as signal. */
TEST_OF_NUMBERS(test_a_tail_is_signal) {
    double x2[300];
    enc_data *data = empty(&two, SIDE, DIRECTIONS);
    enc_components components[3];
    enc_signal signal;
    for (int j = 0; j < 300; j++) {
        x2[j] = 1e5 * pow(j + 1, -2);
    }
    fill(data, NULL, 300, x2, 1e-4, false);
    find(&two, data, 40, components, &signal);
    assert_int_equal(signal.rank[0], 40);
    clear(components, &signal);
    enc_data_destroy(&data);
}

TEST_OF_NUMBERS(test_threads_and_storage_do_not_matter) {
    static const double x2[] = {50, 20, 10, 5};
    static const enc_context small = {.threads = 2, .memory = 1000000};
    enc_data *data = empty(&two, SIDE, 19), *stored = empty(&small, SIDE, 19);
    enc_components components[3][3];
    enc_signal signal[3];
    fill(data, NULL, 4, x2, 0.02, true);
    assert_null(stored->samples);
    assert_int_equal(enc_data_store_texels(&small, stored, 0, TEXELS, data->samples), BTF_OK);
    assert_int_equal(enc_data_complete(&small, stored, BTF_OK), BTF_OK);
    find(&one, data, 30, components[0], &signal[0]);
    find(&two, data, 30, components[1], &signal[1]);
    find(&small, stored, 30, components[2], &signal[2]);
    for (int i = 3; i < 9; i++) {
        const int c = i % 3, k = i / 3;
        assert_int_equal(signal[0].rank[c], signal[k].rank[c]);
        assert_memory_equal(&signal[0].floor[c], &signal[k].floor[c], sizeof(double));
        assert_memory_equal(signal[0].share[c], signal[k].share[c], components[0][c].rank * sizeof(double));
    }
    /* a channel that is not asked for keeps its numbers */
    const double kept = signal[1].floor[1];
    const enc_factor_matrix m = enc_factor_matrix_of(&two, data);
    signal[1].rank[1] = 77;
    assert_int_equal(enc_signal_find(&m, components[1], luma, &signal[1]), BTF_OK);
    assert_true(signal[1].rank[1] == 77 && signal[1].floor[1] == kept);
    assert_memory_equal(signal[0].share[0], signal[1].share[0], components[0][0].rank * sizeof(double));
    clear(components[0], &signal[0]);
    clear(components[1], &signal[1]);
    clear(components[2], &signal[2]);
    enc_data_destroy(&stored);
    enc_data_destroy(&data);
}

TEST(test_the_model) {
    /* square data, x2 = 3: y2 = 16/3, the threshold of M. Gavish and D. Donoho, 2014, below which keeping loses */
    assert_true(fabs(enc_signal_share(3, 100, 100, false)) < 1e-12);
    assert_true(enc_signal_share(2.9, 100, 100, false) < 0 && enc_signal_share(3.1, 100, 100, false) > 0);
    for (int k = 0; k < 2; k++) {
        for (double x2 = 1.2; x2 < 1e5; x2 *= 1.3) {
            assert_true(enc_signal_share(1.3 * x2, 300, 900, k) > enc_signal_share(x2, 300, 900, k));
            assert_true(enc_signal_share(x2, 300, 900, k) == enc_signal_share(x2, 900, 300, k));
        }
        assert_true(fabs(enc_signal_share(1e6, 300, 900, k) - 1) < 1e-4);
    }
}

/* Encodes. */
static enc_factors *encode(const enc_data *data, uint64_t budget, double tolerance) {
    enc_factors *f = NULL;
    const enc_factor_options options = {
        .budget = budget, .sweeps = 2, .tolerance = tolerance, .measure = true};
    assert_int_equal(enc_factor_encode(&two, data, &options, &f), BTF_OK);
    assert_true(f->bytes <= budget);
    return f;
}

TEST_OF_NUMBERS(test_bytes_stop_at_the_noise) {
    static const double x2[] = {900, 300, 100};
    enc_data *data = empty(&two, SIDE, DIRECTIONS);
    fill(data, NULL, 3, x2, 0.02, false);
    const uint64_t least = enc_factor_least_budget(SIDE, SIDE, DIRECTIONS, DIRECTIONS), budget = 8 * least;
    enc_factors *stopped = encode(data, budget, 0.05), *filled = encode(data, budget, 0);
    assert_true(filled->bytes > budget - least && filled->unspent.budget == 0);
    assert_true(stopped->bytes == least && stopped->unspent.bytes == least &&
                stopped->unspent.budget == budget);
    assert_int_equal(stopped->unspent.signal[0], 4);
    assert_true(stopped->unspent.ends[0] && stopped->unspent.gain < 0.05);
    /* the full budget lowers the error at the samples by coding their noise */
    assert_true(filled->error.linear < 0.7 * stopped->error.linear);
    enc_factors_destroy(&stopped);
    enc_factors_destroy(&filled);
    enc_data_destroy(&data);
}

/* Where every byte pays, the whole budget is used; a tolerance that no unit reaches leaves one unit. */
TEST_OF_NUMBERS(test_bytes_that_pay_are_used) {
    double x2[200];
    enc_data *data = empty(&two, SIDE, DIRECTIONS);
    for (int j = 0; j < 200; j++) {
        x2[j] = 1e6 * pow(j + 1, -2);
    }
    fill(data, NULL, 200, x2, 1e-4, false);
    const uint64_t least = enc_factor_least_budget(SIDE, SIDE, DIRECTIONS, DIRECTIONS), budget = 4 * least;
    enc_factors *stopped = encode(data, budget, 0.05), *filled = encode(data, budget, 0),
                *small = encode(data, budget, 50);
    assert_true(stopped->bytes == filled->bytes && stopped->unspent.gain == 0);
    assert_true(stopped->error.linear <= 1.02 * filled->error.linear);
    assert_true(small->bytes == least && small->unspent.gain > 1);
    enc_factors_destroy(&small);
    enc_factors_destroy(&stopped);
    enc_factors_destroy(&filled);
    enc_data_destroy(&data);
}

TEST(test_small_sizes) {
    for (int side = 1; side < 6; side++) {
        for (int directions = 1; directions < 6; directions += 2) {
            enc_data *data = empty(&two, side, directions);
            fill(data, NULL, 0, NULL, 0.05, false);
            enc_factors *f = encode(data, 100000, 0.05);
            enc_factors_destroy(&f);
            memset(data->samples, 0,
                   enc_data_texel_count(data) * enc_data_texel_stride(data) * sizeof(float));
            f = encode(data, 100000, 0.05);
            assert_true(f->error.linear == 0);
            enc_factors_destroy(&f);
            enc_data_destroy(&data);
        }
    }
}

RUN_TESTS(NULL, NULL)
