/* The reference decoder's gloss: where lights are looked up for each view, against reflection and
 * normalisation in double precision. Compiled with the decoder's sources, whose names are hidden.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reference_assert.h"
#include "tests/support/reference_material.h"
#include "tests/support/test.h"

#include "reference/btf_reference_private.h"

/** A material of one view. */
typedef struct one_view {
    btf_ref_material m;
    float vector[4];
} one_view;

static void make_view(const float vector[3], uint32_t share, one_view *out) {
    out->m = (btf_ref_material){.n_views = 1, .view_vectors = out->vector, .gloss_share = share};
    for (int i = 0; i < 3; ++i) {
        out->vector[i] = vector[i];
    }
    out->vector[3] = 1.0f;
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** The point of section 6's plane, not rounded. */
static void plane_point(const double c[3], double out_q[2]) {
    double k = 1 / (fmax(sqrt(dot(c, c)) + c[2], 0.5));
    for (int i = 0; i < 2; ++i) {
        out_q[i] = fmin(fmax(c[i] * k * 8192, -8192), 8192) + 8192;
    }
}

/** l, which is the mirror image of V in the half vector, moved by a share of the way to that of A. */
static void looked_up_in_double(const float l[3], const float v[3], const float a[3], double share,
                                double out_q[2]) {
    double h[3], d[3], c[3];
    for (int i = 0; i < 3; ++i) {
        h[i] = (double)l[i] + (double)v[i];
        d[i] = (double)a[i] - (double)v[i];
    }
    double k = 2 * dot(h, d) / fmin(fmax(dot(h, h), 0.5), 4);
    for (int i = 0; i < 3; ++i) {
        c[i] = (double)l[i] + share * (k * h[i] - d[i]);
    }
    c[2] = fmax(c[2], 0);
    plane_point(c, out_q);
}

TEST(test_against_double) {
    uint32_t random = 3, clamped = 0;
    double worst = 0;
    for (int i = 0; i < 500000; ++i) {
        float l[3], v[3], a[3];
        double truth[2];
        int32_t q[2];
        uint32_t share = 1 + random_below(&random, 2);
        one_view view;
        random_direction(&random, l);
        random_direction(&random, v);
        random_direction(&random, a);
        make_view(a, share, &view);
        btf_ref_gloss(&view.m, 0, l, v, q);
        looked_up_in_double(l, v, a, share / 4.0, truth);
        clamped +=
            (l[0] + v[0]) * (l[0] + v[0]) + (l[1] + v[1]) * (l[1] + v[1]) + (l[2] + v[2]) * (l[2] + v[2]) <
            0.5f;
        for (int k = 0; k < 2; ++k) {
            assert_in_range(q[k], 0, 16384);
            worst = fmax(worst, fabs(q[k] - truth[k]));
        }
    }
    print_message("looked up at most %.4f units of the plane off; %u half vectors below the bound\n", worst,
                  clamped);
    assert_true(worst <= 0.51); /* half a unit of rounding and 1.2e-6 of 8192 */
    assert_true(clamped > 1000);
}

/** The light that has with the sampled view A the half vector of l and V lies as far from l as A from V, on the other
 * side. Gloss moves the look-up by its share of the way there. Rotating light and both views about the normal rotates
 * the look-up. */
TEST(test_geometry) {
    uint32_t random = 5;
    for (int i = 0; i < 20000; ++i) {
        /* in the plane of u and the normal: the view at angle t, the sampled one at t + e, the light at any angle */
        double t = (double)random_float(&random, -0.7f, 1.4f),
               e = (double)random_float(&random, -0.3f, 0.6f),
               p = (double)random_float(&random, -0.7f, 1.4f);
        const float v[3] = {(float)sin(t), 0, (float)cos(t)},
                    a[3] = {(float)sin(t + e), 0, (float)cos(t + e)},
                    l[3] = {(float)sin(p), 0, (float)cos(p)};
        uint32_t share = 1 + (uint32_t)i % 2;
        one_view view;
        int32_t q[2];
        make_view(a, share, &view);
        btf_ref_gloss(&view.m, 0, l, v, q);
        /* on the chord from l to that light */
        double s = share / 4.0, x = (1 - s) * sin(p) + s * sin(p - e),
               z = (1 - s) * cos(p) + s * cos(p - e);
        double angle = atan2(x, z);
        assert_int_equal(q[1], 8192);
        assert_true(fabs(q[0] - (8192 + 8192 * tan(angle / 2))) <= 0.52);
        if (share == 2) { /* half of it: the direction in the middle */
            assert_true(fabs(angle - (p - e / 2)) < 1e-12);
        }

        /* by a quarter of a turn: x to y, y to -x */
        const float turned_v[3] = {-v[1], v[0], v[2]}, turned_a[3] = {-a[1], a[0], a[2]},
                    turned_l[3] = {-l[1], l[0], l[2]};
        int32_t turned[2];
        make_view(turned_a, share, &view);
        btf_ref_gloss(&view.m, 0, turned_l, turned_v, turned);
        assert_int_equal(turned[1], q[0]);
        assert_in_range(turned[0], 8191, 8193);
    }
}

/** At the sampled view the look-up is at the light itself, and also at views that a machine which flushes denormals
 * cannot distinguish from it. */
TEST(test_at_the_sampled_view) {
    uint32_t random = 7;
    static const float nearly[][3] = {
        {0, 0, 0}, {1e-40f, 0, 0}, {0, -1e-40f, 0}, {0x1.fffffep-25f, -0x1.fffffep-25f, 0}};
    for (int i = 0; i < 40000; ++i) {
        float l[3], a[3] = {0, 0, 1}, v[3];
        int32_t q[2], plain[2];
        one_view view;
        random_direction(&random, l);
        if (i % 2) {
            random_direction(&random, a);
        }
        for (int k = 0; k < 3; ++k) {
            v[k] = a[k] + (i % 2 ? 0.0f : nearly[i / 2 % 4][k]);
        }
        make_view(a, 1 + random_below(&random, 2), &view);
        btf_ref_gloss(&view.m, 0, l, v, q);
        btf_ref_project(l, plain);
        assert_memory_equal(q, plain, sizeof q);
    }
}

/** A look-up that would sink below the horizon stays on it, a vanishing half vector shortens the reflection, and the
 * look-up approaches both without a jump. */
TEST(test_limits) {
    const float low[3] = {0.99998f, 0, 0.0063f}, other[3] = {-0.99998f, 0, 0.0063f},
                steep[3] = {-0.5f, 0, 0.8660254f};
    int32_t q[2];
    one_view view;
    make_view(steep, 2, &view);
    btf_ref_gloss(&view.m, 0, low, other, q); /* from grazing, opposed to the light: h is nearly nothing */
    assert_in_range(q[0], 8193, 16384);
    assert_int_equal(q[1], 8192);
    /* a view that coincides with the light mirrors a sampled view on the other side to below the horizon */
    const float l[3] = {0.9f, 0, 0.4358899f}, v[3] = {0.9f, 0, 0.4358899f}, a[3] = {-0.5f, 0, 0.8660254f};
    make_view(a, 2, &view);
    btf_ref_gloss(&view.m, 0, l, v, q);
    assert_int_equal(q[0], 16384);

    int32_t before[2] = {0, 0};
    int step = 0;
    for (int i = 0; i <= 400000;
         ++i) { /* the view goes across the sky, through the sampled one and over the light */
        double t = -1.5707 + 3.1414 * i / 400000;
        const float across[3] = {(float)sin(t), 0, (float)cos(t)};
        make_view(steep, 2, &view);
        btf_ref_gloss(&view.m, 0, i < 200000 ? low : other, across, q);
        if (i > 0 && i != 200000 && abs(q[0] - before[0]) > step) {
            step = abs(q[0] - before[0]);
        }
        before[0] = q[0];
    }
    print_message("looked up at most %d units apart for views 8e-6 apart\n", step);
    assert_true(step <= 2);
}

RUN_TESTS(NULL, NULL)
