/* Interpolation between samples: weights against what must hold of them, blends of data whose truth between
 * the samples is known.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/between/blend.h"
#include "tests/sample/directions.h"
#include "tests/support/messages.h"
#include "tests/support/random_material.h"
#include "tests/support/test.h"

static const enc_context context = {.threads = 2};

static void plane(const float xyz[3], double q[2]) {
    q[0] = xyz[0] / (1.0 + xyz[2]);
    q[1] = xyz[1] / (1.0 + xyz[2]);
}

static enc_direction somewhere(random_state *r, double most) {
    return enc_direction_from_angles(acos(1 - random_unit(r) * (1 - cos(most * 3.14159265358979 / 180))) *
                                         180 / 3.14159265358979,
                                     random_unit(r) * 360);
}

static enc_interpolator *make(const enc_direction *list, int count, enc_interpolation kind) {
    enc_interpolator *made = NULL;
    assert_int_equal(enc_interpolator_create(&context, "views", list, count, kind, &made), BTF_OK);
    return made;
}

/* The error with which the weights sum up to 1 and reproduce the direction's own point in the plane. */
static double affine_error(const enc_weights *w, const enc_direction *list, const float to[3]) {
    double q[2], sum[3] = {-1, 0, 0};
    plane(to, q);
    sum[1] = -q[0];
    sum[2] = -q[1];
    for (int i = 0; i < w->count; i++) {
        plane(list[w->index[i]].xyz, q);
        sum[0] += (double)w->weight[i];
        sum[1] += (double)w->weight[i] * q[0];
        sum[2] += (double)w->weight[i] * q[1];
    }
    return fmax(fabs(sum[0]), fmax(fabs(sum[1]), fabs(sum[2])));
}

static double weight_of(const enc_weights *w, uint32_t sample) {
    double sum = 0;
    for (int i = 0; i < w->count; i++) {
        sum += w->index[i] == sample ? (double)w->weight[i] : 0;
    }
    return sum;
}

TEST(test_affine_functions_are_kept) {
    enc_direction *list;
    int count;
    random_state r = {7};
    assert_int_equal(directions_parse(NULL, "ubo", &list, &count), BTF_OK);
    for (int kind = ENC_INTERPOLATE_LINEAR; kind <= ENC_INTERPOLATE_SPLINE; kind++) {
        enc_interpolator *made = make(list, count, (enc_interpolation)kind);
        double worst = 0;
        for (int i = 0; i < 2000; i++) {
            const enc_direction to = somewhere(&r, 74);
            enc_weights w;
            enc_interpolator_weights(made, to.xyz, &w);
            assert_int_equal(kind == ENC_INTERPOLATE_LINEAR ? w.count <= 3 : w.count == 81, 1);
            worst = fmax(worst, affine_error(&w, list, to.xyz));
        }
        /* the plane of the table has steps of 1/8192, its weights of 1/4096 */
        assert_true(worst < (kind == ENC_INTERPOLATE_LINEAR ? 3e-4 : 2e-5));
        enc_interpolator_destroy(&made);
    }
    free(list);
}

TEST(test_samples_are_kept) {
    enc_direction *list;
    int count;
    assert_int_equal(directions_parse(NULL, "small", &list, &count), BTF_OK);
    for (int kind = ENC_INTERPOLATE_NEAREST; kind <= ENC_INTERPOLATE_SPLINE; kind++) {
        enc_interpolator *made = make(list, count, (enc_interpolation)kind);
        for (int i = 0; i < count; i++) {
            enc_weights w;
            enc_interpolator_weights(made, list[i].xyz, &w);
            for (int k = 0; k < count; k++) {
                assert_true(fabs(weight_of(&w, (uint32_t)k) - (k == i)) < 1e-5);
            }
        }
        enc_interpolator_destroy(&made);
    }
    free(list);
}

/* Four samples on a square and one in its middle: by symmetry the spline that is 1 in the middle and 0 at
 * the corners has a closed form, and it is the weight of the middle. */
TEST(test_a_spline_of_five) {
    const double side = 0.4;
    enc_direction list[5];
    const double theta = 2 * atan(side * sqrt(2)) * 180 / 3.14159265358979;
    list[0] = enc_direction_from_angles(0, 0);
    for (int i = 0; i < 4; i++) {
        list[i + 1] = enc_direction_from_angles(theta, 45 + 90 * i);
    }
    enc_interpolator *made = make(list, 5, ENC_INTERPOLATE_SPLINE);
    /* The thin-plate spline (J. Duchon, 1977) is c (4 k(d) - sum over corners of k(d - corner)) + constant with k(r) =
     * r^2 log r: the coefficients of the kernels sum to zero, and so do their moments. The bracket in the middle and at
     * a corner: */
    const double s2 = side * side, corner = 2 * s2, edge = 4 * s2, across = 8 * s2;
    const double k_corner = 0.5 * corner * log(corner), k_edge = 0.5 * edge * log(edge),
                 k_across = 0.5 * across * log(across);
    const double at_middle = -4 * k_corner, at_corner = 4 * k_corner - 2 * k_edge - k_across;
    const double c = 1 / (at_middle - at_corner);
    for (int i = 0; i <= 20; i++) {
        const double x = -side + 2 * side * i / 20, y = side * 0.3;
        const double square = x * x + y * y;
        double value = square > 0 ? 4 * 0.5 * square * log(square) : 0;
        for (int k = 0; k < 4; k++) {
            const double dx = x - (k & 1 ? side : -side), dy = y - (k & 2 ? side : -side);
            value -= 0.5 * (dx * dx + dy * dy) * log(dx * dx + dy * dy);
        }
        const double bump = c * (value - at_corner);
        const double scale = 2 / (1 + square);
        const float to[3] = {(float)(x * scale), (float)(y * scale), (float)(scale - 1)};
        enc_weights w;
        enc_interpolator_weights(made, to, &w);
        assert_true(fabs(weight_of(&w, 0) - bump) < 1e-5);
    }
    enc_interpolator_destroy(&made);
}

TEST(test_a_line_has_no_spline) {
    const enc_context telling = {.threads = 1, .log = log_keep};
    enc_direction list[3];
    for (int i = 0; i < 3; i++) {
        list[i] = enc_direction_from_angles(30 * i, 0);
    }
    enc_interpolator *made = NULL;
    assert_int_equal(enc_interpolator_create(&telling, "lights", list, 3, ENC_INTERPOLATE_SPLINE, &made),
                     BTF_ERROR_UNSUPPORTED);
    assert_null(made);
    assert_non_null(strstr(last_message, "3 lights"));
    made = make(list, 1, ENC_INTERPOLATE_SPLINE); /* a single sample has all the weight everywhere */
    enc_weights w;
    enc_interpolator_weights(made, list[2].xyz, &w);
    assert_true(w.count == 1 && w.weight[0] == 1);
    enc_interpolator_destroy(&made);
}

TEST(test_nearest_angle) {
    const enc_direction list[2] = {enc_direction_from_angles(0, 0), enc_direction_from_angles(60, 90)};
    const enc_direction near = enc_direction_from_angles(47.5, 90);
    assert_true(fabs(enc_nearest_angle(list, 2, near.xyz) - 12.5) < 1e-4);
    assert_true(enc_nearest_angle(list, 2, list[1].xyz) == 0);
}

/* A positive function of both directions that barycentric weights reproduce. */
static double affine(const float view[3], const float light[3], size_t texel, size_t channel) {
    double v[2], l[2];
    plane(view, v);
    plane(light, l);
    const double t = 0.1 * (double)texel, c = 0.3 * (double)channel;
    return (2 + t + 0.5 * v[0] - 0.7 * v[1]) * (1.5 + c + 0.6 * l[0] + 0.2 * l[1]);
}

static enc_data *affine_data(bool squared, size_t memory) {
    enc_direction *views, *lights;
    int n_views, n_lights;
    enc_data *data = NULL;
    const enc_context least = {.threads = 2, .memory = memory};
    assert_int_equal(directions_parse(NULL, "small", &views, &n_views), BTF_OK);
    assert_int_equal(directions_parse(NULL, "tiny", &lights, &n_lights), BTF_OK);
    assert_int_equal(enc_data_create(&least, 3, 2, n_views, views, n_lights, lights, &data), BTF_OK);
    float *one = malloc(enc_data_texel_stride(data) * sizeof *one);
    for (size_t t = 0; t < 6; t++) {
        size_t i = 0;
        for (int v = 0; v < n_views; v++) {
            for (size_t c = 0; c < 3; c++) {
                for (int l = 0; l < n_lights; l++) {
                    const double f = affine(views[v].xyz, lights[l].xyz, t, c);
                    one[i++] = (float)(squared ? f * f : f);
                }
            }
        }
        assert_int_equal(enc_data_store_texels(&least, data, t, 1, one), BTF_OK);
    }
    assert_int_equal(enc_data_complete(&least, data, BTF_OK), BTF_OK);
    free(one);
    free(views);
    free(lights);
    return data;
}

enum { PAIRS = 50, FLOATS = 3 * 6 };

static void random_pairs(enc_pair pairs[PAIRS]) {
    random_state r = {11};
    for (int p = 0; p < PAIRS; p++) {
        pairs[p] = (enc_pair){.view = somewhere(&r, 55), .light = somewhere(&r, 25)};
    }
}

static void blend(const enc_data *data, enc_interpolation kind, const enc_pair *pairs, float *out) {
    enc_blend *made = NULL;
    assert_int_equal(enc_blend_create(&context, data, kind, &made), BTF_OK);
    assert_int_equal(enc_blend_images(&context, made, pairs, PAIRS, out), BTF_OK);
    enc_blend_destroy(&made);
}

/* Radiance is blended barycentrically, its square roots by the spline. */
TEST(test_blends_of_known_truth) {
    static enc_pair pairs[PAIRS];
    static float images[PAIRS * FLOATS];
    random_pairs(pairs);
    for (int kind = ENC_INTERPOLATE_LINEAR; kind <= ENC_INTERPOLATE_SPLINE; kind++) {
        const bool spline = kind == ENC_INTERPOLATE_SPLINE;
        enc_data *data = affine_data(spline, 0);
        blend(data, (enc_interpolation)kind, pairs, images);
        for (size_t i = 0; i < PAIRS * FLOATS; i++) {
            const enc_pair *p = &pairs[i / FLOATS];
            const double f = affine(p->view.xyz, p->light.xyz, i % FLOATS / 3, i % 3);
            const double truth = spline ? f * f : f;
            assert_true(fabs(images[i] - truth) < (spline ? 1e-4 : 1e-3) * truth);
        }
        enc_data_destroy(&data);
    }
}

TEST(test_nearest_takes_one_sample) {
    static enc_pair pairs[PAIRS];
    static float images[PAIRS * FLOATS];
    random_pairs(pairs);
    enc_data *data = affine_data(false, 0);
    blend(data, ENC_INTERPOLATE_NEAREST, pairs, images);
    for (size_t i = 0; i < PAIRS * FLOATS; i++) {
        const float *samples = data->samples + i % FLOATS / 3 * enc_data_texel_stride(data);
        bool found = false;
        for (int v = 0; v < data->n_views; v++) {
            for (int l = 0; l < data->n_lights; l++) {
                found = found || samples[(v * 3 + (int)(i % 3)) * data->n_lights + l] == images[i];
            }
        }
        assert_true(found);
    }
    enc_data_destroy(&data);
}

/* Samples that lie in a file give the same bits as those in memory. */
TEST(test_scratch) {
    static enc_pair pairs[PAIRS];
    static float images[2][PAIRS * FLOATS];
    random_pairs(pairs);
    for (int i = 0; i < 2; i++) {
        enc_data *data = affine_data(true, i == 0 ? 0 : 4096);
        assert_true((data->scratch_fd >= 0) == (i == 1));
        blend(data, ENC_INTERPOLATE_SPLINE, pairs, images[i]);
        enc_data_destroy(&data);
    }
    assert_memory_equal(images[0], images[1], sizeof images[0]);
}

RUN_TESTS(NULL, NULL)
