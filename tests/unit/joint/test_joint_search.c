/* The search of the joint method against brute force, its ties, its tolerance, its bounds.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/joint/search_set.h"
#include "encoder/joint/search.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint64_t state = 1;

/* Uniform in -1 .. 1 (xorshift64*, Vigna 2016). */
static float uniform(void) {
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (float)((double)((state * 2685821657736338717u) >> 11) * 0x1p-52 - 1.0);
}

/* One view of random queries near random sources. */
typedef struct problem {
    joint_search search;
    size_t texels;
    float *c, *z, *energy;
    uint32_t *match;
    uint8_t *gain;
    double *value;
} problem;

static problem problem_create(int width, int height, size_t k, bool gain, float noise) {
    const size_t texels = (size_t)width * (size_t)height;
    problem p = {.search = {.width = width,
                            .height = height,
                            .k = k,
                            .gains = {0x1p-7f, gain ? 1 : 128, gain ? 255 : 128},
                            .tile = enc_gemm_select(),
                            .threads = 2},
                 .texels = texels,
                 .c = malloc(texels * k * sizeof(float)),
                 .z = malloc(texels * k * sizeof(float)),
                 .energy = malloc(texels * sizeof(float)),
                 .match = malloc(texels * sizeof(uint32_t)),
                 .gain = malloc(texels),
                 .value = malloc(texels * sizeof(double))};
    assert_true(p.c && p.z && p.energy && p.match && p.gain && p.value);
    for (size_t i = 0; i < texels * k; i++)
        p.z[i] = uniform();
    for (size_t x = 0; x < texels; x++) {
        const size_t source = (size_t)((uniform() + 1.0f) * 0.499f * (float)texels);
        const float g = gain ? 1.1f + uniform() : 1.0f;
        float sum = 0.0f;
        for (size_t j = 0; j < k; j++) {
            const float y = g * p.z[source * k + j] + noise * uniform();
            p.c[x * k + j] = y;
            sum += y * y;
        }
        p.energy[x] = 1.1f * sum; /* what lies outside the basis */
        p.match[x] = (uint32_t)x;
        p.gain[x] = 128;
    }
    return p;
}

static void problem_free(problem *p) {
    free(p->c);
    free(p->z);
    free(p->energy);
    free(p->match);
    free(p->gain);
    free(p->value);
}

static void solve(problem *p) {
    assert_int_equal(joint_search_view(&p->search, p->c, p->energy, p->z, p->match, p->gain, p->value),
                     BTF_OK);
}

/* |row|^2 - |row - g z|^2 by definition. */
static double value_of(const problem *p, size_t x, size_t source, int code) {
    double value = 0.0;
    for (size_t j = 0; j < p->search.k; j++) {
        const double y = p->c[x * p->search.k + j];
        const double d = y - (double)p->search.gains.step * code * p->z[source * p->search.k + j];
        value += y * y - d * d;
    }
    return value;
}

/* The best over all codes, one by one. */
static double best_of_codes(const problem *p, size_t x, size_t source) {
    double best = -HUGE_VAL;
    for (int code = p->search.gains.low; code <= p->search.gains.high; code++)
        best = fmax(best, value_of(p, x, source, code));
    return best;
}

static void check_against_brute_force(int width, int height, size_t k, bool gain, float noise) {
    problem p = problem_create(width, height, k, gain, noise);
    solve(&p);
    for (size_t x = 0; x < p.texels; x++) {
        double best = -HUGE_VAL;
        for (size_t source = 0; source < p.texels; source++) {
            double dot = 0.0, norm = 0.0, value;
            for (size_t j = 0; j < k; j++) {
                dot += (double)p.c[x * k + j] * p.z[source * k + j];
                norm += (double)p.z[source * k + j] * p.z[source * k + j];
            }
            joint_best_gain(&p.search.gains, dot, norm, &value);
            best = fmax(best, value);
        }
        const double found = p.energy[x] - value_of(&p, x, p.match[x], p.gain[x]);
        assert_true(found <= (p.energy[x] - best) * (1.0 + 1e-6));
        assert_true(fabs(p.value[x] - value_of(&p, x, p.match[x], p.gain[x])) <= 1e-6 * p.energy[x]);
    }
    problem_free(&p);
}

static void test_brute_force(void **unused) {
    (void)unused;
    check_against_brute_force(17, 13, 5, true, 0.3f);
    check_against_brute_force(17, 13, 5, false, 0.3f);
    check_against_brute_force(32, 24, 56, true, 1.0f);
    check_against_brute_force(32, 24, 20, false, 0.02f);
    check_against_brute_force(3, 1, 1, true, 0.1f);
    check_against_brute_force(1, 1, 4, true, 0.1f);
}

/* The best gain code is the best of all 255. */
static void test_gain_codes(void **unused) {
    (void)unused;
    problem p = problem_create(16, 4, 7, true, 0.5f);
    solve(&p);
    for (size_t x = 0; x < p.texels; x++)
        assert_true(fabs(best_of_codes(&p, x, p.match[x]) - p.value[x]) <= 1e-6 * p.energy[x]);
    joint_search_gains(&p.search, p.c, p.z, p.match, p.gain, p.value);
    for (size_t x = 0; x < p.texels; x++)
        assert_true(fabs(best_of_codes(&p, x, p.match[x]) - p.value[x]) <= 1e-6 * p.energy[x]);
    problem_free(&p);
}

/* Small multiples of one source differ in the gain alone; a present choice that is better stays. */
static void test_never_worse(void **unused) {
    (void)unused;
    problem p = problem_create(20, 20, 12, true, 0.8f);
    for (size_t x = 0; x < p.texels; x++)
        p.match[x] = (uint32_t)((x * 37) % p.texels);
    for (size_t x = 0; x < p.texels; x++)
        p.value[x] = best_of_codes(&p, x, p.match[x]);
    double *before = malloc(p.texels * sizeof *before);
    assert_non_null(before);
    memcpy(before, p.value, p.texels * sizeof *before);
    p.search.tolerance = 0.05;
    solve(&p);
    for (size_t x = 0; x < p.texels; x++)
        assert_true(p.value[x] >= before[x] - 1e-6 * p.energy[x]);
    free(before);
    problem_free(&p);
}

/* Equal sources everywhere: nothing moves; in two equal halves, the nearer copy is taken. */
static void test_ties(void **unused) {
    (void)unused;
    problem p = problem_create(16, 16, 6, true, 0.0f);
    for (size_t i = 1; i < p.texels; i++)
        memcpy(p.z + i * 6, p.z, 6 * sizeof(float));
    solve(&p);
    for (size_t x = 0; x < p.texels; x++)
        assert_int_equal(p.match[x], x);
    problem_free(&p);

    p = problem_create(16, 16, 6, false, 0.0f);
    for (size_t y = 0; y < 16; y++) /* columns 8..15 repeat 0..7 */
        memcpy(p.z + (y * 16 + 8) * 6, p.z + y * 16 * 6, 8 * 6 * sizeof(float));
    for (size_t x = 0; x < p.texels;
         x++) { /* each wants the source 3 columns on, wherever its copy is nearer */
        const size_t source = x / 16 * 16 + (x % 16 + 3) % 16;
        memcpy(p.c + x * 6, p.z + source * 6, 6 * sizeof(float));
    }
    solve(&p);
    for (size_t x = 0; x < p.texels; x++) {
        int dx, dy;
        assert_true(joint_shift(16, 16, (uint32_t)x, p.match[x], &dx, &dy));
        assert_int_equal(dx, 3);
        assert_int_equal(dy, 0);
    }
    problem_free(&p);
}

/* A shift that gains less than the tolerance is not made. */
static void test_tolerance(void **unused) {
    (void)unused;
    for (int strict = 0; strict < 2; strict++) {
        problem p = problem_create(8, 8, 4, false, 0.0f);
        for (size_t i = 0; i < p.texels * 4; i++)
            p.z[i] = 1.0f + 1e-3f * uniform();
        for (size_t x = 0; x < p.texels; x++) {
            memcpy(p.c + x * 4, p.z + (p.texels - 1 - x) * 4, 4 * sizeof(float));
            p.energy[x] = 4.0f;
        }
        p.search.tolerance = strict ? 1e-5 : 0.0;
        solve(&p);
        for (size_t x = 0; x < p.texels; x++)
            assert_int_equal(p.match[x], strict ? x : p.texels - 1 - x);
        problem_free(&p);
    }
}

/* One thread and two, and the plain tile, choose the same. */
static void test_threads_and_tiles(void **unused) {
    (void)unused;
    problem a = problem_create(40, 20, 24, true, 0.9f);
    uint32_t *match = malloc(a.texels * sizeof *match);
    uint8_t *gain = malloc(a.texels);
    assert_true(match && gain);
    solve(&a);
    memcpy(match, a.match, a.texels * sizeof *match);
    memcpy(gain, a.gain, a.texels);
    for (size_t x = 0; x < a.texels; x++)
        a.match[x] = (uint32_t)x;
    a.search.threads = 1;
    solve(&a);
    assert_memory_equal(match, a.match, a.texels * sizeof *match);
    assert_memory_equal(gain, a.gain, a.texels);
    free(match);
    free(gain);
    problem_free(&a);
}

/* Shifts go the shorter way round and never past what a signed byte holds. */
static void test_shift(void **unused) {
    (void)unused;
    int dx, dy;
    assert_true(joint_shift(64, 64, 0, 63, &dx, &dy));
    assert_int_equal(dx, -1);
    assert_int_equal(dy, 0);
    assert_true(joint_shift(64, 32, 0, 64 * 31 + 5, &dx, &dy));
    assert_int_equal(dx, 5);
    assert_int_equal(dy, -1);
    assert_true(joint_shift(256, 1, 0, 128, &dx, &dy));
    assert_int_equal(dx, -128);
    assert_true(joint_shift(1024, 1, 0, 127, &dx, &dy));
    assert_false(joint_shift(1024, 1, 0, 128, &dx, &dy));
    assert_true(joint_shift(1024, 1, 128, 0, &dx, &dy));
    assert_false(joint_shift(1024, 1, 129, 0, &dx, &dy));

    problem p = problem_create(600, 2, 3, true, 0.0f); /* half of the winners lie too far away */
    solve(&p);
    size_t moved = 0;
    for (size_t x = 0; x < p.texels; x++) {
        assert_true(joint_shift(600, 2, (uint32_t)x, p.match[x], &dx, &dy));
        moved += p.match[x] != x;
    }
    assert_true(moved > p.texels / 2);
    problem_free(&p);
}

static void stay(problem *p) {
    for (size_t x = 0; x < p->texels; x++) {
        p->match[x] = (uint32_t)x;
        p->gain[x] = 128;
    }
}

/* Bounded sources: one search is never better than that of all, never worse than staying, and far better
 * than that; one search for every place of the grid finds what that of all does. */
static void test_reach(void **unused) {
    (void)unused;
    enum { WIDTH = 90, HEIGHT = 50, REACH = 256, PLACES = 25 /* 5 * 5, 5 = ceil(sqrt(4500 / 256)) */ };
    problem p = problem_create(WIDTH, HEIGHT, 9, true, 0.3f);
    double *all = malloc(p.texels * sizeof *all), sum = 0.0, sum_all = 0.0, sum_still = 0.0;
    assert_non_null(all);
    solve(&p);
    memcpy(all, p.value, p.texels * sizeof *all);
    stay(&p);
    p.search.sources = REACH;
    p.search.window = 1;
    for (unsigned phase = 0; phase < PLACES; phase++) {
        p.search.phase = phase + 7;
        solve(&p);
        for (size_t x = 0; x < p.texels && phase == 0; x++) {
            const double still = best_of_codes(&p, x, x);
            assert_true(p.value[x] <= all[x] + 1e-9 * p.energy[x]);
            assert_true(p.value[x] >= still - 1e-6 * p.energy[x]);
            sum += p.value[x];
            sum_all += all[x];
            sum_still += still;
        }
    }
    assert_true(sum - sum_still > 0.5 * (sum_all - sum_still));
    for (size_t x = 0; x < p.texels; x++)
        assert_true(p.value[x] >= all[x] - 1e-6 * p.energy[x]);
    free(all);
    problem_free(&p);
}

static void test_reach_threads(void **unused) {
    (void)unused;
    problem a = problem_create(131, 37, 6, true, 0.3f);
    uint32_t match[131 * 37];
    a.search.sources = 256;
    a.search.window = 1;
    solve(&a);
    memcpy(match, a.match, sizeof match);
    stay(&a);
    a.search.threads = 1;
    solve(&a);
    assert_memory_equal(a.match, match, sizeof match);
    problem_free(&a);
}

/* Every point is in one block, its block looks at its own tile, and no chunk comes twice. */
static void test_reach_blocks(void **unused) {
    (void)unused;
    static const int sizes[][2] = {{90, 50}, {300, 20}, {4099, 1}, {1, 5000}, {257, 255}, {17, 9}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        joint_search_set r;
        assert_int_equal(joint_search_set_create(sizes[i][0], sizes[i][1], 256, 1, 3, &r), BTF_OK);
        assert_true(r.complete == (r.texels <= JOINT_EXACT));
        uint8_t *seen = calloc(r.texels, 1);
        assert_non_null(seen);
        assert_int_equal(r.first_query[r.blocks], r.texels);
        for (size_t b = 0; b < r.blocks; b++) {
            const uint32_t *chunks = r.chunk + r.first_chunk[b];
            assert_true(r.chunk_count[b] <= r.most_chunks);
            for (uint32_t q = r.first_query[b]; q < r.first_query[b + 1]; q++) {
                bool own = false;
                for (size_t c = 0; c < r.chunk_count[b] && !own; c++)
                    for (size_t j = 0; j < JOINT_CHUNK && !own; j++)
                        own = r.source[chunks[c] * JOINT_CHUNK + j] == r.query[q];
                assert_true(own);
                assert_int_equal(seen[r.query[q]]++, 0);
            }
            for (size_t c = 0; c < r.chunk_count[b]; c++)
                for (size_t d = 0; d < c; d++)
                    assert_int_not_equal(chunks[c], chunks[d]);
        }
        for (size_t j = 0; j < r.chunks * JOINT_CHUNK; j++)
            assert_true(r.source[j] < r.texels || r.source[j] == JOINT_NO_SOURCE);
        free(seen);
        joint_search_set_clear(&r);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_brute_force),   cmocka_unit_test(test_gain_codes),
        cmocka_unit_test(test_never_worse),   cmocka_unit_test(test_ties),
        cmocka_unit_test(test_tolerance),     cmocka_unit_test(test_threads_and_tiles),
        cmocka_unit_test(test_shift),         cmocka_unit_test(test_reach),
        cmocka_unit_test(test_reach_threads), cmocka_unit_test(test_reach_blocks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
