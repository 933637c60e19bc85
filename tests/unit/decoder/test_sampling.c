/* Light sampling: the density integrates to one, samples follow it, estimates agree with quadrature, and materials that
 * reflect nothing or have few lights are sampled too.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/reference_view.h"
#include "tests/conformance/random.h"
#include "tests/conformance/synthetic.h"
#include "tests/support/test.h"

#include <openbtf/reference.h>
#include <openbtf/sampling.h>

#define PI 3.14159265358979323846

typedef struct subject {
    btf_material *material;
    btf_evaluator *evaluator;
    btf_light_sampling *tables;
    btf_ref_material reference;
    btf_ref_sampling sampling;
} subject;

static void open_subject(const synthetic_spec *spec, subject *s) {
    assert_int_equal(synthetic_create(spec, NULL, &s->material), BTF_OK);
    assert_int_equal(btf_evaluator_create(s->material, NULL, &s->evaluator), BTF_OK);
    assert_int_equal(btf_light_sampling_create(s->material, s->evaluator, NULL, &s->tables), BTF_OK);
    reference_view(s->material, 0, &s->reference);
    s->sampling = (btf_ref_sampling){s->tables->n_triangles, s->tables->triangles, s->tables->densities};
}

static void close_subject(subject *s) {
    btf_light_sampling_destroy(&s->tables);
    assert_null(s->tables);
    btf_evaluator_destroy(&s->evaluator);
    btf_material_close(&s->material);
}

static synthetic_spec shiny(void) {
    return (synthetic_spec){.seed = 4,
                            .width = 8,
                            .height = 8,
                            .n_views = 37,
                            .n_lights = 81,
                            .layout = BTF_LAYOUT_TIGHT,
                            .colour = BTF_COLOUR_RGB,
                            .lobes = 2,
                            .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT,
                            .levels = 1};
}

static float pdf(const subject *s, const float view[3], const float light[3]) {
    return btf_ref_pdf_light(&s->reference, &s->sampling, 0.5f, 0.5f, view, light);
}

/* Rings and sectors of the plane of the directions: the middle of cell (i, j) of n x n, and its solid
 * angle. */
static double plane_cell(int i, int j, int n, float out[3]) {
    const double r = (i + 0.5) / n, phi = 2 * PI * (j + 0.5) / n, k = 2 / (1 + r * r);
    out[0] = (float)(k * r * cos(phi));
    out[1] = (float)(k * r * sin(phi));
    out[2] = (float)(k - 1);
    return k * k * r * (1.0 / n) * (2 * PI / n);
}

enum { BINS = 12, FINE = 120 };

/* Writes the expected share of samples in each of BINS x BINS bins, and returns their sum. */
static double integrate(const subject *s, const float view[3], double expected[BINS][BINS]) {
    double total = 0;
    const int n = BINS * FINE;
    memset(expected, 0, BINS * sizeof *expected);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            float light[3];
            const double solid = plane_cell(i, j, n, light), p = solid * (double)pdf(s, view, light);
            expected[i / FINE][j / FINE] += p;
            total += p;
        }
    }
    return total;
}

static void bin_of(const float light[3], int *i, int *j) {
    const double r = sqrt((1 - (double)light[2]) / (1 + (double)light[2]));
    double phi = atan2((double)light[1], (double)light[0]) / (2 * PI);
    phi = phi < 0 ? phi + 1 : phi;
    *i = (int)fmin(r * BINS, BINS - 1);
    *j = (int)fmin(phi * BINS, BINS - 1);
}

/* Whether pdf integrates to 1 and samples follow it. */
static void check_density(const subject *s, const float view[3], uint64_t seed) {
    enum { SAMPLES = 200000 };
    static double expected[BINS][BINS];
    double seen[BINS][BINS] = {{0}}, chi = 0;
    int degrees = -1;
    const double total = integrate(s, view, expected);
    assert_true(fabs(total - 1) < 1e-4);
    random_state r = {seed};
    for (int i = 0; i < SAMPLES; i++) {
        float light[3], p;
        const uint64_t bits = random_bits(&r);
        int a, b;
        btf_ref_sample_light(&s->reference, &s->sampling, 0.5f, 0.5f, view, (uint32_t)bits,
                             (uint32_t)(bits >> 32), light, &p);
        assert_true(fabs(sqrt((double)light[0] * (double)light[0] + (double)light[1] * (double)light[1] +
                              (double)light[2] * (double)light[2]) -
                         1) < 2e-6);
        assert_true(light[2] > 0 && p > 0 && p == pdf(s, view, light));
        bin_of(light, &a, &b);
        seen[a][b]++;
    }
    for (int a = 0; a < BINS; a++) {
        for (int b = 0; b < BINS; b++) {
            const double mean = expected[a][b] * SAMPLES;
            if (mean < 5) {
                continue;
            }
            chi += (seen[a][b] - mean) * (seen[a][b] - mean) / mean;
            degrees++;
        }
    }
    /* Wilson and Hilferty, 1931: of 144 bins, 4 sigma is one in 30000. */
    const double z = (cbrt(chi / degrees) - (1 - 2.0 / (9 * degrees))) / sqrt(2.0 / (9 * degrees));
    if (!(z < 4)) {
        fail_msg("chi-square %.1f of %d degrees: %.1f sigma", chi, degrees, z);
    }
}

/* Reflected radiance under a white sky: the mean of radiance over density, against quadrature. */
static void check_estimate(const subject *s, const float view[3], uint64_t seed) {
    enum { SAMPLES = 20000, SIDE = 400 };
    const btf_ref_options everything = {BTF_EFFECT_ALL, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
    double truth = 0, sum = 0, squares = 0;
    float rgb[3];
    for (int i = 0; i < SIDE; i++) {
        for (int j = 0; j < SIDE; j++) {
            float light[3];
            const double solid = plane_cell(i, j, SIDE, light);
            btf_ref_evaluate(&s->reference, &everything, 0.5f, 0.5f, light, view, rgb);
            truth += solid * (double)rgb[1];
        }
    }
    random_state r = {seed};
    for (int i = 0; i < SAMPLES; i++) {
        float light[3], p;
        const uint64_t bits = random_bits(&r);
        btf_ref_sample_light(&s->reference, &s->sampling, 0.5f, 0.5f, view, (uint32_t)bits,
                             (uint32_t)(bits >> 32), light, &p);
        btf_ref_evaluate(&s->reference, &everything, 0.5f, 0.5f, light, view, rgb);
        sum += (double)rgb[1] / (double)p;
        squares += (double)rgb[1] / (double)p * ((double)rgb[1] / (double)p);
    }
    const double mean = sum / SAMPLES, sigma = sqrt(fmax(squares / SAMPLES - mean * mean, 0) / SAMPLES);
    if (!(fabs(mean - truth) <= 3 * sigma + 1e-4 * truth)) {
        fail_msg("estimate %g, by quadrature %g, sigma %g", mean, truth, sigma);
    }
}

static const float views[][3] = {{0, 0, 1}, {0.6f, 0, 0.8f}, {-0.3f, 0.8660254f, 0.4f}};

TEST(test_density) {
    const synthetic_spec spec = shiny();
    subject s;
    open_subject(&spec, &s);
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        check_density(&s, views[i], 3 + i);
    }
    close_subject(&s);
}

TEST(test_estimate) {
    const synthetic_spec spec = shiny();
    subject s;
    open_subject(&spec, &s);
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        check_estimate(&s, views[i], 5 + i);
    }
    close_subject(&s);
}

/* Without triangles the density is that of the cosine. Lights on one meridian may have thin triangles, because the
 * plane's coordinates are rounded. */
TEST(test_few_lights) {
    for (uint32_t n = 1; n <= 5; n++) {
        synthetic_spec spec = shiny();
        subject s;
        spec.n_views = spec.n_lights = n;
        spec.directions = SYNTHETIC_COLLINEAR;
        open_subject(&spec, &s);
        const float light[3] = {0.48f, 0.36f, 0.8f};
        if (n < 3) {
            assert_int_equal(s.tables->triangles[0], 0);
        }
        if (btf_material_lights(s.material).triangle_count == 0) {
            assert_true(fabs((double)pdf(&s, views[1], light) - 0.8 / PI) < 1e-7);
        }
        check_density(&s, views[1], n);
        close_subject(&s);
    }
}

/* A material whose tables hold nothing but zeros. */
TEST(test_black) {
    const synthetic_spec spec = shiny();
    subject s;
    open_subject(&spec, &s);
    const size_t numbers = (size_t)s.tables->n_views * (s.tables->n_lights + 1);
    float *densities = calloc(numbers, sizeof *densities);
    uint32_t *triangles =
        calloc(4 * (size_t)s.tables->n_triangles * (s.tables->n_views + 1), sizeof *triangles);
    assert_true(densities && triangles);
    for (size_t v = 1; v <= s.tables->n_views; v++) {
        densities[v * (s.tables->n_lights + 1) - 1] = 1.0f;
    }
    s.sampling.densities = densities;
    s.sampling.triangles = triangles;
    check_density(&s, views[2], 9);
    free(densities);
    free(triangles);
    close_subject(&s);
}

TEST(test_arguments) {
    const synthetic_spec spec = shiny();
    subject s;
    btf_light_sampling *none = NULL;
    open_subject(&spec, &s);
    assert_int_equal(btf_light_sampling_create(NULL, s.evaluator, NULL, &none), BTF_ERROR_USAGE);
    assert_int_equal(btf_light_sampling_create(s.material, NULL, NULL, &none), BTF_ERROR_USAGE);
    assert_int_equal(btf_light_sampling_create(s.material, s.evaluator, NULL, NULL), BTF_ERROR_USAGE);
    btf_light_sampling_destroy(NULL);
    const float bad[][3] = {{0, 0, -1}, {0, 0, 0}, {NAN, 0, 1}, {3, 0, 1}, {0, INFINITY, 1}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        float light[3], p = 7;
        btf_ref_sample_light(&s.reference, &s.sampling, 0, 0, bad[i], 1, 2, light, &p);
        assert_true(p == 0 && light[2] == 1);
        assert_true(pdf(&s, bad[i], views[0]) == 0 && pdf(&s, views[0], bad[i]) == 0);
    }
    for (int i = 0; i < 64; i++) { /* the least and the greatest random numbers */
        static const uint32_t ends[] = {0,          1,          0x7FFFFFFF, 0x80000000,
                                        0xBFFFFFFF, 0xC0000000, 0xFFFFFF00, 0xFFFFFFFF};
        float light[3], p;
        btf_ref_sample_light(&s.reference, &s.sampling, 0, 0, views[1], ends[i % 8], ends[i / 8], light,
                             &p);
        assert_true(light[2] > 0 && light[2] <= 1 && p > 0 && p < 1e6f);
    }
    close_subject(&s);
}

RUN_TESTS(NULL, NULL)
