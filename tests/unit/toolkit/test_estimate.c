/* Time left and percent of a whole encode, against recorded core times of its stages and a simulated clock.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/job/cost.h"
#include "encoder/job/job.h"
#include "tests/support/test.h"

typedef struct recorded {
    const char *stage;
    double seconds, part; /* core seconds; the fraction of the stage that was run, where it ended early */
} recorded;

typedef struct recording {
    const char *name;
    enc_extent extent;
    recorded stages[16];
} recording;

/* Core seconds of `btf-encode --preset fast --threads 1 --report` on btf-sample's bricks, one run each on a
 * machine that others used too. */
/* clang-format off */
static const recording recordings[] = {
    {"32x32 texels, 81 directions", {.width = 32, .height = 32, .n_views = 81, .n_lights = 81,
     .origin = ENC_ORIGIN_IMAGES, .pixels = 6718464}, {{"read", 0.415, 1}, {"factorise", 0.385, 1},
     {"cross-validate", 0.248, 1}, {"round factors", 0.034, 1}, {"pack", 0.001, 1}, {"measure", 0.650, 1},
     {"effect errors", 0.239, 1}, {"leave one out", 0.273, 1}, {"save", 0.014, 1}}},
    {"64x64 texels, 81 directions", {.width = 64, .height = 64, .n_views = 81, .n_lights = 81,
     .origin = ENC_ORIGIN_IMAGES, .pixels = 26873856}, {{"read", 1.64, 1}, {"factorise", 3.302, 1},
     {"cross-validate", 2.051, 1}, {"round factors", 0.239, 1}, {"measure", 3.019, 1},
     {"effect errors", 0.359, 1}, {"leave one out", 0.637, 1}, {"save", 0.069, 1}}},
    {"128x128 texels, 25 directions", {.width = 128, .height = 128, .n_views = 25, .n_lights = 25,
     .origin = ENC_ORIGIN_IMAGES, .pixels = 10240000}, {{"read", 0.473, 1}, {"factorise", 1.861, 1},
     {"cross-validate", 0.816, 1}, {"round factors", 0.318, 1}, {"measure", 1.387, 1},
     {"effect errors", 0.359, 1}, {"leave one out", 0.405, 1}, {"save", 0.106, 1}}},
};
/* clang-format on */

/* The planned parts of a recording. */
static size_t plan(const recording *r, estimate_part *parts) {
    enc_job job = {.levels = 1, .joint = enc_joint_options_default()};
    const enc_context context = {.threads = 1};
    job.joint.preset = ENC_PRESET_FAST;
    return enc_cost_parts(&context, &job, &r->extent, parts);
}

static double length_of(const recording *r) {
    double sum = 0;
    for (const recorded *s = r->stages; s->stage; s++) {
        sum += s->seconds;
    }
    return sum;
}

/* Plays a recording in steps of a thousandth of each stage. Writes the time left that is shown after 25, 50 and 75 % of
 * the time, and checks that the fraction never falls and ends at 1. */
static void play(const recording *r, const estimate_part *parts, size_t count, double speed,
                 double left[3]) {
    const double length = length_of(r) * speed;
    double now = 1000, fraction = 0;
    int marks = 0;
    estimate e;
    estimate_begin(&e, parts, count, now);
    for (const recorded *s = r->stages; s->stage; s++) {
        const double begin = now;
        estimate_stage(&e, s->stage, now);
        for (int i = 1; i <= 1000; i++) {
            now = begin + s->seconds * speed * i / 1000;
            estimate_within(&e, s->part * i / 1000, now);
            assert_true(estimate_fraction(&e) >= fraction);
            assert_true(estimate_fraction(&e) <= 1);
            fraction = estimate_fraction(&e);
            while (marks < 3 && now - 1000 >= length * 0.25 * (marks + 1)) {
                left[marks++] = estimate_left(&e, now);
            }
        }
        estimate_stage_end(&e, s->part, now);
        assert_true(estimate_fraction(&e) >= fraction);
        fraction = estimate_fraction(&e);
    }
    assert_true(estimate_fraction(&e) == 1);
    assert_true(estimate_left(&e, now) == 0);
    assert_int_equal(marks, 3);
}

TEST(test_recordings) {
    for (size_t i = 0; i < sizeof recordings / sizeof *recordings; i++) {
        const recording *r = &recordings[i];
        estimate_part parts[ESTIMATE_PARTS];
        const size_t count = plan(r, parts);
        for (double speed = 4; speed <= 64; speed *= 4) { /* too short to tell on a fast machine */
            double left[3];
            play(r, parts, count, speed, left);
            for (int mark = 0; mark < 3; mark++) {
                const double truth = length_of(r) * speed * (1 - 0.25 * (mark + 1));
                if (speed == 4) {
                    print_message("%s: at %d %% of the time %.1f s left, predicted %.1f\n", r->name,
                                  25 * (mark + 1), truth, left[mark]);
                }
                assert_true(fabs(left[mark] / truth - 1) <= 0.35);
            }
        }
    }
}

/* With equal weights the same recordings give estimates that are far off, so the bound above is not trivial. */
TEST(test_equal_weights) {
    double worst = 0;
    for (size_t i = 0; i < sizeof recordings / sizeof *recordings; i++) {
        const recording *r = &recordings[i];
        estimate_part parts[ESTIMATE_PARTS];
        double left[3];
        const size_t count = plan(r, parts);
        for (size_t p = 0; p < count; p++) {
            parts[p].cost = 1;
        }
        play(r, parts, count, 1, left);
        for (int mark = 0; mark < 3; mark++) {
            worst = fmax(worst, fabs(left[mark] / (length_of(r) * (1 - 0.25 * (mark + 1))) - 1));
        }
    }
    print_message("equal weights: up to %.0f %% off\n", 100 * worst);
    assert_true(worst > 0.35);
}

/* A stage that ends early, or is not run at all, moves the fraction forwards and does not change the estimated rate. */
TEST(test_early) {
    const estimate_part parts[] = {{"a", 10}, {"b", 60}, {"c", 20}, {"d", 10}};
    estimate e;
    estimate_begin(&e, parts, 4, 0);
    assert_true(estimate_left(&e, 0) < 0);
    estimate_stage(&e, "a", 0);
    estimate_within(&e, 1, 20); /* two seconds a unit */
    estimate_stage_end(&e, 1, 20);
    assert_float_equal(estimate_fraction(&e), 0.1, 1e-9);
    assert_float_equal(estimate_left(&e, 20), 180, 1e-9);
    estimate_stage(&e, "b", 20);
    estimate_within(&e, 0.25, 50); /* converged */
    estimate_stage_end(&e, 0.25, 50);
    assert_float_equal(estimate_fraction(&e), 0.7, 1e-9);
    assert_float_equal(estimate_left(&e, 50), 60, 1e-9);
    assert_float_equal(estimate_left(&e, 55), 55, 1e-9); /* the clock goes on */
    estimate_stage(&e, "d", 50);                         /* "c" was in a checkpoint */
    assert_float_equal(estimate_fraction(&e), 0.9, 1e-9);
    estimate_stage(&e, "unforeseen", 60);
    estimate_within(&e, 1, 70);
    assert_float_equal(estimate_fraction(&e), 0.9, 1e-9);
    estimate_stage_end(&e, 1, 70);
    estimate_stage(&e, "d", 70);
    estimate_within(&e, 2, 90);
    estimate_stage_end(&e, 1, 90);
    assert_true(estimate_fraction(&e) == 1 && estimate_left(&e, 90) == 0);
}

/* Predicted costs grow with the sizes that they depend on, and are finite and positive for every size. */
TEST(test_sizes) {
    static const int sides[] = {1, 16, 64, 256, 400, 4096, 16384};
    for (int method = 0; method < 2; method++) {
        double before = 0;
        for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
            enc_job job = {
                .levels = 0, .joint = enc_joint_options_default(), .paper = enc_paper_options_default()};
            const enc_context context = {.threads = 1, .memory = (size_t)4 << 30};
            const enc_extent extent = {
                .width = sides[i], .height = sides[i], .n_views = 81, .n_lights = 81};
            estimate_part parts[ESTIMATE_PARTS];
            job.method = method == 0 ? ENC_METHOD_JOINT : ENC_METHOD_PAPER;
            job.pictures = "there";
            const size_t count = enc_cost_parts(&context, &job, &extent, parts);
            const double total = enc_cost_total(parts, count);
            assert_true(count <= ESTIMATE_PARTS && isfinite(total) && total > before);
            for (size_t p = 0; p < count; p++) {
                assert_true(parts[p].cost >= 0 && isfinite(parts[p].cost));
            }
            before = total;
        }
    }
}

RUN_TESTS(NULL, NULL)
