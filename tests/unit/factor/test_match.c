/* Match and gain of factors: planted sources and gains are found, the errors that the encoder measures are those of the
 * reference decoder, the number of threads does not matter, and both are dropped where they do not pay.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/reference_view.h"
#include "encoder/data/images.h"
#include "encoder/factor/components.h"
#include "encoder/factor/factor.h"
#include "encoder/factor/level.h"
#include "encoder/factor/match/descend.h"
#include "encoder/factor/match/fit.h"
#include "encoder/factor/match/search.h"
#include "encoder/factor/method.h"
#include "encoder/model/pack.h"
#include "tests/sample/sample.h"
#include "tests/support/test.h"
#include "tests/support/uniform.h"

static const enc_context one = {.threads = 1}, two = {.threads = 2};

enum { SIDE = 24, TEXELS = SIDE * SIDE, VIEWS = 13, LIGHTS = 25, COLUMNS = VIEWS * LIGHTS, TERMS = 6 };

/* Samples of few components, of which every point has a source and a gain of its own. */
typedef struct planted {
    enc_data *data;
    size_t source[VIEWS][TEXELS];
    float gain[VIEWS][TEXELS];
    float u[TERMS][TEXELS], w[TERMS][COLUMNS];
} planted;

static enc_data *empty(void) {
    enc_direction views[VIEWS], lights[LIGHTS];
    enc_data *data = NULL;
    for (int i = 0; i < LIGHTS; i++) {
        lights[i] = enc_direction_from_angles(i == 0 ? 0 : 20 + 2 * i, 40 * i % 360);
    }
    for (int i = 0; i < VIEWS; i++) {
        views[i] = lights[i];
    }
    assert_int_equal(enc_data_create(&two, SIDE, SIDE, VIEWS, views, LIGHTS, lights, &data), BTF_OK);
    return data;
}

static void fill(planted *p, float noise, uint32_t *state) {
    for (size_t x = 0; x < TEXELS; x++) {
        for (size_t i = 0; i < COLUMNS; i++) {
            const size_t v = i / LIGHTS;
            float root = 0;
            for (size_t j = 0; j < TERMS; j++) {
                root += p->u[j][p->source[v][x]] * p->w[j][i];
            }
            root *= p->gain[v][x];
            for (size_t c = 0; c < 3; c++) {
                const float value = root + noise * (uniform(state) - 0.5f);
                p->data->samples[(x * COLUMNS + v * LIGHTS) * 3 + c * LIGHTS + i % LIGHTS] =
                    value > 0 ? value * value : 0;
            }
        }
    }
}

/* moved: whether a fifth of all points have sources and gains that differ from their texel and from 1. */
static planted *plant(bool moved, float noise) {
    planted *p = calloc(1, sizeof *p);
    uint32_t state = 5;
    assert_non_null(p);
    p->data = empty();
    for (size_t j = 0; j < TERMS; j++) {
        for (size_t x = 0; x < TEXELS; x++) {
            p->u[j][x] = j == 0 ? 0.5f : 0.6f * (uniform(&state) - 0.5f);
        }
        for (size_t i = 0; i < COLUMNS; i++) {
            p->w[j][i] = j == 0 ? 0.8f + 0.4f * uniform(&state) : uniform(&state) - 0.5f;
        }
    }
    for (size_t v = 0; v < VIEWS; v++) {
        for (size_t x = 0; x < TEXELS; x++) {
            const bool here = moved && v > 0 && uniform(&state) < 0.2f;
            p->source[v][x] = here ? (size_t)(uniform(&state) * TEXELS) : x;
            p->gain[v][x] = here ? 0.5f + uniform(&state) : 1.0f;
        }
    }
    fill(p, noise, &state);
    return p;
}

static void uproot(planted **p) {
    enc_data_destroy(&(*p)->data);
    free(*p);
}

/* The factors that were planted, unrounded: all in Y. */
static enc_factor_codes codes_of(const planted *p, const enc_factor_matrix *m) {
    static const enc_factor_plan plan = {{{4, 0, 0}}};
    enc_components components[3] = {{.rank = TERMS, .u = (float *)p->u, .w = (float *)p->w}};
    enc_factor_codes codes;
    assert_int_equal(enc_factor_codes_create(m, &plan, components, &codes), BTF_OK);
    for (size_t i = 0; i < TERMS * COLUMNS; i++) {
        codes.channel[0].w[i] *= sqrtf(3);
    }
    return codes;
}

/* With the true factors a search finds every planted source, and its gain to half a step. */
TEST(test_search_finds_what_was_planted) {
    planted *p = plant(true, 0);
    enc_factor_matrix m = enc_factor_matrix_of(&two, p->data);
    enc_factor_codes codes = codes_of(p, &m);
    enc_match_bases bases;
    enc_match match;
    double error = 0, energy = 0;
    assert_int_equal(enc_match_create(&two, SIDE, SIDE, VIEWS, true, &match), BTF_OK);
    assert_int_equal(enc_match_find_bases(&m, &bases), BTF_OK);
    assert_int_equal(enc_match_blocks(&match), 1);
    enc_match_coordinates at = enc_match_block(&match, bases.leading, 0);
    assert_int_equal(enc_match_coordinates_create(&two, VIEWS, &at), BTF_OK);
    assert_int_equal(enc_match_locate_points(&m, &bases, &match, &at), BTF_OK);
    assert_int_equal(enc_match_locate_sources(&m, &codes, &bases, &match, &at), BTF_OK);
    assert_int_equal(enc_match_search(&m, &at, &match, &energy), BTF_OK);
    assert_int_equal(enc_match_restrict(&two, &at, 0, &match, &error), BTF_OK);
    for (size_t v = 0; v < VIEWS; v++) {
        for (size_t x = 0; x < TEXELS; x++) {
            assert_int_equal(match.source[v * TEXELS + x], p->source[v][x]);
            assert_true(fabsf(enc_match_gain(&match, v, x) - p->gain[v][x]) <= 0.51f * match.gains.step);
        }
    }
    assert_true(error < 1e-3 * energy);
    enc_match_fit_gains(&two, &match);
    assert_int_equal(match.gains.count, ENC_MATCH_GAINS);
    enc_match_coordinates_clear(&at);
    enc_match_bases_clear(&bases);
    enc_match_clear(&match);
    enc_factor_codes_clear(&codes);
    uproot(&p);
}

/* A texture of several blocks, with sources beyond the edges of blocks. There are so few directions that the
 * coordinates of a profile represent it exactly. */
enum { WIDE = 140, HIGH = 67, FEW = 3, WIDE_RANK = 4 };

static enc_data *wide_data(void) {
    enc_direction directions[FEW];
    enc_data *data = NULL;
    uint32_t seed = 11;
    for (int i = 0; i < FEW; i++) {
        directions[i] = enc_direction_from_angles(20.0f * (float)i, 40.0f * (float)i);
    }
    assert_int_equal(enc_data_create(&two, WIDE, HIGH, FEW, directions, FEW, directions, &data), BTF_OK);
    for (size_t i = 0; i < (size_t)WIDE * HIGH * FEW * FEW * 3; i++) {
        data->samples[i] = uniform(&seed);
    }
    return data;
}

/* The squared error at a point that a source leaves with its best gain. Only Y has factors. */
static double left_of(const enc_factor_matrix *m, const enc_factor_codes *codes, const enc_match *match,
                      size_t view, size_t texel, size_t source) {
    float profile[3][FEW];
    double norm = 0, dot = 0, energy = 0;
    enc_factor_split_profile(m, texel, view, (float *const[3]){profile[0], profile[1], profile[2]});
    for (size_t l = 0; l < FEW; l++) {
        double value = 0;
        for (size_t j = 0; j < WIDE_RANK; j++) {
            value += (double)codes->channel[0].u[j * m->texels + source] *
                     codes->channel[0].w[j * m->columns + view * FEW + l];
        }
        norm += value * value;
        dot += value * profile[0][l];
        for (int c = 0; c < 3; c++) {
            energy += (double)profile[c][l] * profile[c][l];
        }
    }
    double least = energy;
    for (int i = 0; i < match->gains.count; i++) {
        const double gain = match->gains.base + match->gains.step * i;
        least = fmin(least, energy - gain * (2 * dot - gain * norm));
    }
    return least;
}

/* Whether all points of a tile can reach a place along an axis, as match/search.h says. */
static bool reached(int size, int at, int from) {
    const int tile = from / 16 * 16, n = size - tile < 16 ? size - tile : 16;
    const int by = (at - (tile + n - 1 - ENC_MATCH_REACH) + 2 * size) % size;
    return size <= 64 || by <= 2 * ENC_MATCH_REACH - n;
}

/* A search of every block. */
static void search_blocks(const enc_factor_matrix *m, const enc_factor_codes *codes,
                          const enc_match_bases *bases, bool whole, enc_match *out) {
    assert_int_equal(enc_match_create(&two, WIDE, HIGH, FEW, true, out), BTF_OK);
    assert_int_equal(enc_match_blocks(out), 6);
    out->whole = whole;
    for (int b = 0; b < 6; b++) {
        enc_match_coordinates at = enc_match_block(out, bases->leading, b);
        double energy = 0;
        assert_int_equal(enc_match_coordinates_create(&two, FEW, &at), BTF_OK);
        assert_int_equal(enc_match_locate_points(m, bases, out, &at), BTF_OK);
        assert_int_equal(enc_match_locate_sources(m, codes, bases, out, &at), BTF_OK);
        assert_int_equal(enc_match_search(m, &at, out, &energy), BTF_OK);
        enc_match_coordinates_clear(&at);
    }
}

/* In every block, at its edges too, no source in reach is nearer than the one found, and with the sources
 * of the whole texture the same ones are found. */
TEST(test_blocks_search_all_sources_in_reach) {
    enc_data *data = wide_data();
    const enc_factor_matrix m = enc_factor_matrix_of(&two, data);
    const enc_factor_plan plan = {{{4, 0, 0}}};
    uint32_t seed = 3;
    float *u = malloc(sizeof(float) * WIDE_RANK * m.texels), w[WIDE_RANK * FEW * FEW];
    enc_components components[3] = {{.rank = WIDE_RANK, .u = u, .w = w}};
    enc_factor_codes codes;
    enc_match_bases bases;
    enc_match match, whole;
    assert_non_null(u);
    for (size_t i = 0; i < WIDE_RANK * m.texels; i++) {
        u[i] = uniform(&seed);
    }
    for (size_t i = 0; i < WIDE_RANK * FEW * FEW; i++) {
        w[i] = uniform(&seed) - 0.2f;
    }
    assert_int_equal(enc_factor_codes_create(&m, &plan, components, &codes), BTF_OK);
    assert_int_equal(enc_match_find_bases(&m, &bases), BTF_OK);
    search_blocks(&m, &codes, &bases, false, &match);
    search_blocks(&m, &codes, &bases, true, &whole);
    assert_memory_equal(match.source, whole.source, FEW * m.texels * sizeof *match.source);
    assert_memory_equal(match.gain, whole.gain, FEW * m.texels);
    for (size_t i = 0; i < FEW * m.texels; i += 97) {
        const size_t view = i / m.texels, texel = i % m.texels;
        const double found = left_of(&m, &codes, &match, view, texel, match.source[i]);
        assert_true(reached(WIDE, (int)match.source[i] % WIDE, (int)texel % WIDE) &&
                    reached(HIGH, (int)match.source[i] / WIDE, (int)texel / WIDE));
        for (size_t z = 0; z < m.texels; z++) {
            if (reached(WIDE, (int)z % WIDE, (int)texel % WIDE) &&
                reached(HIGH, (int)z / WIDE, (int)texel / WIDE)) {
                assert_true(left_of(&m, &codes, &match, view, texel, z) > found - 1e-4);
            }
        }
    }
    free(u);
    enc_match_bases_clear(&bases);
    enc_match_clear(&whole);
    enc_match_clear(&match);
    enc_factor_codes_clear(&codes);
    enc_data_destroy(&data);
}

/* Users and weights are those of the sources. */
TEST(test_users_are_counted) {
    enc_match match;
    uint32_t seed = 9;
    assert_int_equal(enc_match_create(&two, 5, 3, 4, true, &match), BTF_OK);
    for (size_t i = 0; i < 60; i++) {
        match.source[i] = (uint32_t)(uniform(&seed) * 15);
        match.gain[i] = (uint8_t)(uniform(&seed) * 100);
    }
    enc_match_count_users(&two, &match);
    for (size_t z = 0; z < 15; z++) {
        for (size_t v = 0; v < 4; v++) {
            uint32_t at = match.first[z * 4 + v];
            double weight = 0;
            for (size_t x = 0; x < 15; x++) {
                if (match.source[v * 15 + x] == z) {
                    assert_int_equal(match.user[at++], x);
                    weight += pow(enc_match_gain(&match, v, x), 2);
                }
            }
            assert_int_equal(at, match.first[z * 4 + v + 1]);
            assert_true(fabs(weight - match.weight[z * 4 + v]) < 1e-4);
        }
    }
    enc_match_clear(&match);
}

/* The squared distance of the samples' roots from those that the factors give; chroma is 0. */
static double distance(const planted *p, const enc_factor_codes *codes, const enc_match *match) {
    double sum = 0;
    for (size_t x = 0; x < TEXELS; x++) {
        for (size_t i = 0; i < COLUMNS; i++) {
            const size_t v = i / LIGHTS, source = match->source[v * TEXELS + x];
            double root = 0;
            for (size_t j = 0; j < codes->channel[0].rank; j++) {
                root +=
                    (double)codes->channel[0].u[j * TEXELS + source] * codes->channel[0].w[j * COLUMNS + i];
            }
            const double e =
                sqrt(3 * (double)p->data->samples[(x * COLUMNS + v * LIGHTS) * 3 + i % LIGHTS]) -
                enc_match_gain(match, v, x) * root;
            sum += e * e;
        }
    }
    return sum;
}

/* Descent with the planted sources fixed finds the factors again from disturbed ones, and no step increases the
 * error. */
TEST(test_descent_lowers_the_error) {
    planted *p = plant(true, 0);
    enc_factor_matrix m = enc_factor_matrix_of(&two, p->data);
    enc_factor_codes codes = codes_of(p, &m);
    enc_match match;
    uint32_t seed = 3;
    assert_int_equal(enc_match_create(&two, SIDE, SIDE, VIEWS, true, &match), BTF_OK);
    for (size_t i = 0; i < VIEWS * TEXELS; i++) {
        match.source[i] = (uint32_t)p->source[i / TEXELS][i % TEXELS];
        match.gain[i] =
            (uint8_t)lrintf((p->gain[i / TEXELS][i % TEXELS] - match.gains.base) / match.gains.step);
    }
    enc_match_count_users(&two, &match);
    const double still = distance(p, &codes, &match);
    for (size_t i = 0; i < TERMS * TEXELS; i++) {
        codes.channel[0].u[i] *= 0.7f + 0.6f * uniform(&seed);
    }
    m.match = &match;
    double before = distance(p, &codes, &match);
    assert_true(before > 10 * still);
    for (int i = 0; i < 12; i++) {
        assert_int_equal(enc_match_descend(&m, &codes, false, 2), BTF_OK);
        const double now = distance(p, &codes, &match);
        assert_true(now < before * (1 + 1e-4));
        before = now;
    }
    assert_true(before < 2 * still);
    enc_match_clear(&match);
    enc_factor_codes_clear(&codes);
    uproot(&p);
}

static enc_factors *encode(const enc_context *context, const enc_data *data, bool match, bool gain,
                           uint64_t budget) {
    const enc_factor_options options = {.budget = budget,
                                        .sweeps = ENC_FACTOR_SWEEPS,
                                        .match = match ? ENC_FACTOR_MATCH : ENC_FACTOR_NO_MATCH,
                                        .gain = gain,
                                        .measure = true};
    enc_factors *f = NULL;
    assert_int_equal(enc_factor_encode(context, data, &options, &f), BTF_OK);
    assert_true(f->bytes <= budget && f->error.linear > 0);
    assert_true((f->shift != NULL) == match && (f->gain != NULL) == match);
    return f;
}

enum { BUDGET = 36000 };

/* Where sources and gains were planted, shift alone reduces the error, and shift with gain more so; elsewhere both only
 * cost bytes. */
TEST_OF_NUMBERS(test_pays_where_it_was_planted) {
    for (int moved = 0; moved < 2; moved++) {
        planted *p = plant(moved, 0.02f);
        enc_factors *f[3];
        for (int i = 0; i < 3; i++) {
            f[i] = encode(&two, p->data, i > 0, i > 1, BUDGET);
        }
        assert_true(moved ? f[2]->error.linear < 0.5 * f[0]->error.linear
                          : f[2]->error.linear > f[0]->error.linear);
        assert_true(!moved || f[2]->error.linear < f[1]->error.linear);
        for (int i = 0; i < 3; i++) {
            enc_factors_destroy(&f[i]);
        }
        uproot(&p);
    }
}

TEST_OF_NUMBERS(test_threads_do_not_matter) {
    planted *p = plant(true, 0.02f);
    enc_factors *a = encode(&one, p->data, true, true, BUDGET),
                *b = encode(&two, p->data, true, true, BUDGET);
    assert_memory_equal(a->shift, b->shift, 2 * VIEWS * TEXELS);
    assert_memory_equal(a->gain, b->gain, VIEWS * TEXELS);
    assert_memory_equal(a->classes, b->classes, sizeof a->classes);
    assert_memory_equal(a->texels, b->texels, (size_t)a->n_u_texels * TEXELS * 16);
    assert_memory_equal(a->directions, b->directions, (size_t)a->n_units * COLUMNS * 16);
    assert_true(a->error.linear == b->error.linear && a->error.srgb == b->error.srgb);
    enc_factors_destroy(&a);
    enc_factors_destroy(&b);
    uproot(&p);
}

/* Mean squared error of what the reference decodes at the samples, clipped. */
static double reference_error(const enc_data *data, const enc_solution *solution) {
    const enc_pack_options options = {.layout = BTF_LAYOUT_TIGHT, .method = "test"};
    btf_material *material = NULL;
    enc_reference_images images = {.shape = data,
                                   .options = {.components = UINT32_MAX, .effects = BTF_EFFECT_ALL}};
    const size_t image = 3 * TEXELS;
    float *is = malloc(image * LIGHTS * sizeof *is), *was = malloc(image * LIGHTS * sizeof *was);
    double sum = 0;
    assert_true(is && was);
    assert_int_equal(enc_pack(&two, data, solution, &options, &material), BTF_OK);
    reference_view(material, 0, &images.material);
    const enc_image_source source = enc_reference_image_source(&images);
    for (int v = 0; v < VIEWS; v++) {
        assert_int_equal(source.view(source.user, v, is), BTF_OK);
        assert_int_equal(enc_data_view(&two, data, v, was), BTF_OK);
        for (size_t i = 0; i < image * LIGHTS; i++) {
            const double e = fmin(is[i], 1) - fmin(was[i], 1);
            sum += e * e;
        }
    }
    free(is);
    free(was);
    btf_material_close(&material);
    return sum / (double)(image * LIGHTS * VIEWS);
}

/* Shifts are within -32 .. 31, gains are of a scale of sixteen, and the reference's error is the one that the encoder
 * measured. */
TEST(test_reference_decodes_what_was_measured) {
    planted *p = plant(true, 0.02f);
    const enc_factors_settings settings = {.budget = BUDGET,
                                           .sweeps = ENC_FACTOR_SWEEPS,
                                           .effects =
                                               BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL};
    enc_factors *f = encode(&two, p->data, true, true, BUDGET);
    enc_solution solution;
    enc_factors_stats stats;
    bool seen[256] = {false};
    int gains = 0;
    assert_int_equal(enc_factors_solve(&two, p->data, &settings, &solution, &stats), BTF_OK);
    assert_int_equal(solution.effects, settings.effects);
    for (size_t i = 0; i < VIEWS * TEXELS; i++) {
        gains += !seen[solution.gain[i]];
        seen[solution.gain[i]] = true;
        assert_in_range(solution.gain[i], 0, ENC_MATCH_GAINS - 1);
        assert_in_range(solution.shift[2 * i] + 32, 0, 63);
        assert_in_range(solution.shift[2 * i + 1] + 32, 0, 63);
    }
    assert_in_range(gains, 2, ENC_MATCH_GAINS);
    const double error = reference_error(p->data, &solution);
    assert_true(fabs(error - f->error.linear) <= 1e-3 * error);
    enc_factors_destroy(&f);
    enc_solution_clear(&solution);
    uproot(&p);
}

/* The method, when it may choose, keeps match and gain where they were planted, and nowhere else. */
TEST_OF_NUMBERS(test_is_kept_where_it_pays) {
    for (int moved = 0; moved < 2; moved++) {
        planted *p = plant(moved, 0.02f);
        const enc_factors_settings settings = {
            .budget = BUDGET, .sweeps = ENC_FACTOR_SWEEPS, .choose = true};
        const uint32_t match = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN;
        enc_solution solution;
        enc_factors_stats stats;
        assert_int_equal(enc_factors_solve(&two, p->data, &settings, &solution, &stats), BTF_OK);
        assert_int_equal(solution.effects, BTF_EFFECT_RESIDUAL | (moved ? match : 0));
        assert_true(stats.trials_count == 2 || !moved);
        assert_string_equal(stats.trials[moved].verdict, "best");
        enc_solution_clear(&solution);
        uproot(&p);
    }
}

/* The reason why match was not tried is reported, and differs from that of a survey that found no gain. */
TEST_OF_NUMBERS(test_says_why_it_was_not_tried) {
    enum { SURVEY, MEMORY, BYTES, REASONS };
    static const char *const told[REASONS] = {"given up after a first search, which left too much error",
                                              "not tried: it needs more memory than is allowed",
                                              "not tried: the budget does not hold its lists and one unit of factors"};
    for (int reason = 0; reason < REASONS; reason++) {
        planted *p = plant(false, 0.02f);
        enc_context context = two;
        enc_factors_settings settings = {.budget = BUDGET, .sweeps = 1, .choose = true};
        enc_solution solution;
        enc_factors_stats stats;
        context.memory = reason == MEMORY ? 1 : 0;
        if (reason == BYTES) {
            settings.budget = enc_factor_least_budget(p->data->width, p->data->height, VIEWS, LIGHTS);
        }
        assert_int_equal(enc_factors_solve(&context, p->data, &settings, &solution, &stats), BTF_OK);
        assert_int_equal(stats.trials_count, 2);
        assert_string_equal(stats.trials[1].verdict, told[reason]);
        enc_solution_clear(&solution);
        uproot(&p);
    }
}

static void count_searches(void *user, btf_log_level level, const char *message) {
    int *searches = user;
    (void)level;
    *searches += strstr(message, "of the energy is left by") != NULL;
}

/* The survey ends after the first search where that reduces the error by almost nothing. Where it reduces it by more,
 * descent and a second search follow, though the gain may still not pay. */
TEST(test_a_survey_ends_early) {
    static const double most = 1e-4; /* neither pays */
    for (int moved = 0; moved < 2; moved++) {
        planted *p = plant(moved, moved ? 0.02f : 0.3f);
        enc_context context = two;
        int searches = 0;
        context.log = (btf_log){count_searches, &searches};
        const enc_factor_matrix m = enc_factor_matrix_of(&context, p->data);
        static const size_t ranks[3] = {16, 4, 4};
        enc_components components[3] = {{0}};
        enc_factor_plan plan = {{{4, 0, 0}}};
        enc_match match;
        enc_match_bases bases;
        double share = 0;
        assert_int_equal(enc_components_find(&m, ranks, 1, components), BTF_OK);
        assert_int_equal(enc_match_create(&context, SIDE, SIDE, VIEWS, true, &match), BTF_OK);
        assert_int_equal(enc_match_find_bases(&m, &bases), BTF_OK);
        assert_int_equal(enc_match_fit(&m, BUDGET, &bases, most, &match, components, &plan, &share), BTF_OK);
        printf("%s: %d searches, %.3f is left\n", moved ? "planted" : "noise", searches, share);
        assert_int_equal(searches, moved ? 2 : 1);
        assert_true(moved ? share < 0.9 : share > 0.97);
        enc_match_bases_clear(&bases);
        enc_match_clear(&match);
        for (int c = 0; c < 3; c++) {
            enc_components_clear(&components[c]);
        }
        uproot(&p);
    }
}

/* The rounds end with as many components as the plan before them holds. The allocation fills whole units; where it
 * would hold fewer components in another plan, the earlier plan stays, so that the budget is used. */
TEST_OF_NUMBERS(test_rounds_leave_no_unit_unused) {
    static const size_t ranks[3] = {96, 48, 48};
    enum { UNIT = 16 * (16 * 16 + COLUMNS) };
    enc_data *data;
    assert_int_equal(sample_render_small(&two, RELIEF_BUMPS, "0:1,40:6,65:6", "0:1,30:6,50:8,70:10", 16, &data),
                     BTF_OK);
    const enc_factor_matrix m = enc_factor_matrix_of(&two, data);
    int kept = 0;
    for (int units = 3; units <= 7; units++) {
        enc_components components[3] = {{0}};
        enc_factor_plan before, plan, anew;
        enc_match match;
        enc_match_bases bases;
        double share = 0;
        assert_int_equal(enc_components_find(&m, ranks, 1, components), BTF_OK);
        enc_factor_energies energies = enc_components_energies(components);
        const uint64_t budget = (uint64_t)units * UNIT + 2000;
        assert_true(enc_factor_allocate(&energies, m.texels, VIEWS, LIGHTS, budget, &before));
        plan = before;
        assert_int_equal(enc_match_create(&two, 16, 16, VIEWS, true, &match), BTF_OK);
        assert_int_equal(enc_match_find_bases(&m, &bases), BTF_OK);
        assert_int_equal(enc_match_fit(&m, budget, &bases, HUGE_VAL, &match, components, &plan, &share), BTF_OK);
        energies = enc_components_energies(components);
        assert_true(enc_factor_allocate(&energies, m.texels, VIEWS, LIGHTS, budget, &anew));
        const double error = enc_factor_plan_error(&energies, &plan, 0);
        assert_true(error <= enc_factor_plan_error(&energies, &before, 0));
        assert_true(error <= enc_factor_plan_error(&energies, &anew, 0));
        kept += error < enc_factor_plan_error(&energies, &anew, 0);
        enc_match_bases_clear(&bases);
        enc_match_clear(&match);
        for (int c = 0; c < 3; c++) {
            enc_components_clear(&components[c]);
        }
    }
    printf("the earlier plan stays in %d of 5 budgets\n", kept);
    assert_true(kept > 0);
    enc_data_destroy(&data);
}

/* Coarser levels have no match and decode with the factors that all levels share. */
TEST(test_levels_have_no_match) {
    planted *p = plant(true, 0.02f);
    const enc_factors_settings settings = {.budget = BUDGET,
                                           .sweeps = ENC_FACTOR_SWEEPS,
                                           .effects =
                                               BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL};
    enc_solution solution, level;
    enc_factors_stats stats;
    assert_int_equal(enc_factors_solve(&two, p->data, &settings, &solution, &stats), BTF_OK);
    assert_int_equal(enc_factors_level(&two, p->data, &solution, &level), BTF_OK);
    for (size_t i = 0; i < VIEWS * TEXELS; i++) {
        assert_true(level.shift[2 * i] == 0 && level.shift[2 * i + 1] == 0);
        assert_true(enc_solution_gain(&level, level.gain[i]) == 1);
    }
    /* twice the size of level 0 at most: its own texels, fitted without the sources */
    assert_true(reference_error(p->data, &level) < 40 * reference_error(p->data, &solution));
    enc_level_clear(&level);
    enc_solution_clear(&solution);
    uproot(&p);
}

RUN_TESTS(NULL, NULL)
