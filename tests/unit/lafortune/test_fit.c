/* The Lafortune fit: its sums against plain double arithmetic, its derivatives against differences, known materials
 * that it must recover, and data that no model fits.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/lafortune/ceres_bridge.h"
#include "encoder/lafortune/texel_fit.h"
#include "encoder/lafortune/gram.h"
#include "encoder/lafortune/normal_equations.h"
#include "encoder/math/simd.h"
#include "tests/support/fit_data.h"
#include "tests/support/test.h"

#include <float.h>
#include <openbtf/reference.h>

enum { PADDED = (PAIRS + 255) / 256 * 256 };

/* Every pair of the paper's directions, view-major, with a target that a test fills in. */
typedef struct pairs {
    _Alignas(64) float product[3][PADDED];
    _Alignas(64) float multiplier[PADDED];
    _Alignas(64) float target[3][PADDED];
} pairs;

static pairs *make_pairs(void) {
    enc_direction directions[DIRECTIONS];
    fit_directions(directions);
    pairs *p = aligned_alloc(64, sizeof *p);
    assert_non_null(p);
    memset(p, 0, sizeof *p);
    for (int v = 0; v < DIRECTIONS; v++) {
        for (int l = 0; l < DIRECTIONS; l++) {
            for (int k = 0; k < 3; k++) {
                p->product[k][v * DIRECTIONS + l] = directions[v].xyz[k] * directions[l].xyz[k];
            }
            p->multiplier[v * DIRECTIONS + l] = directions[l].xyz[2];
        }
    }
    return p;
}

static enc_fit_samples samples_of(const pairs *p, size_t n) {
    return (enc_fit_samples){
        .n = n,
        .product = {p->product[0], p->product[1], p->product[2]},
        .multiplier = p->multiplier,
        .target = {p->target[0], p->target[1], p->target[2]},
    };
}

static double pair_value(const float *parameters, int lobes, bool rgb, const pairs *p, size_t i,
                         int channel) {
    const double product[3] = {(double)p->product[0][i], (double)p->product[1][i],
                               (double)p->product[2][i]};
    return (double)p->multiplier[i] * fit_model_value(parameters, lobes, rgb, product, channel);
}

static void fill_targets(pairs *p, const float *parameters, int lobes, bool rgb) {
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < PAIRS; i++) {
            p->target[c][i] = (float)pair_value(parameters, lobes, rgb, p, i, c);
        }
    }
}

static double cost_of(const float *parameters, int lobes, bool rgb, const pairs *p, size_t n) {
    double cost = 0;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++) {
            const double r = pair_value(parameters, lobes, rgb, p, i, c) - (double)p->target[c][i];
            cost += r * r;
        }
    }
    return cost;
}

/* Fits the first n pairs with the default options but for lobes, rgb and tolerance. */
static enc_fit_result fit_pairs(const pairs *p, size_t n, int lobes, bool rgb, double tolerance,
                                float *out) {
    enc_fit_options options = enc_fit_options_default();
    options.lobes = lobes;
    options.rgb = rgb;
    options.tolerance = tolerance;
    options.max_evaluations = 200;
    enc_fit_workspace *workspace;
    assert_int_equal(enc_fit_workspace_create(n, &workspace), BTF_OK);
    const enc_fit_samples samples = samples_of(p, n);
    enc_fit_result result;
    assert_int_equal(enc_fit_texel(workspace, &samples, &options, NULL, options.starts, out, &result),
                     BTF_OK);
    enc_fit_workspace_destroy(&workspace);
    assert_null(workspace);
    fit_assert_storable(out, enc_sbrdf_stride(lobes, rgb));
    assert_true(isfinite(result.cost));
    return result;
}

static const float three_lobes[16] = {0.8f, 1, 0.6f, 0.3f, -0.7f, -0.7f, 0.8f, 20,
                                      0.6f, 0, 0.7f, 3,    0,     -0.5f, 0.8f, 5};
static const float three_rgb[24] = {0.3f,  0.2f, 0.1f, 0.4f, 0.4f, 0.5f,  0.1f, 0.2f,
                                    0.05f, 0.2f, 0.1f, 0.1f, -1,   -1,    1,    20,
                                    1,     0,    1,    3,    0,    -0.8f, 1,    5};

/* As FORMAT.md section 8 writes it, which the reference decoder does one number at a time. */
TEST(test_pow_bits) {
    fit_random_state = 3;
    for (int round = 0; round < 60000; round++) {
        float base[ENC_LANES], power[ENC_LANES];
        const float n = round % 2 ? 200 * fit_random() : exp2f(12 * fit_random() - 2);
        for (int i = 0; i < ENC_LANES; i++) {
            const float u = fit_random();
            base[i] = round % 3 == 0 ? 3 * u : round % 3 == 1 ? exp2f(40 * u - 28) : 1e-6f * u - 3e-7f;
        }
        enc_v16 b, result;
        memcpy(&b, base, sizeof b);
        enc_v16_pow(&b, n, &result);
        memcpy(power, &result, sizeof power);
        for (int i = 0; i < ENC_LANES; i++) {
            const float want = btf_ref_pow(base[i], n);
            assert_memory_equal(&power[i], &want, sizeof want);
        }
    }
}

TEST(test_evaluate) {
    enc_direction directions[DIRECTIONS];
    fit_directions(directions);
    float light[3][DIRECTIONS], out[3][3 * DIRECTIONS];
    for (int l = 0; l < DIRECTIONS; l++) {
        for (int k = 0; k < 3; k++) {
            light[k][l] = directions[l].xyz[k];
        }
    }
    for (int rgb = 0; rgb < 2; rgb++) {
        enc_sbrdf *sbrdf;
        assert_int_equal(enc_sbrdf_create(2, 3, rgb != 0, &sbrdf), BTF_OK);
        const size_t stride = enc_sbrdf_stride(3, rgb != 0);
        memcpy(sbrdf->values + stride, rgb ? three_rgb : three_lobes, stride * sizeof(float));
        for (int n = 0; n <= DIRECTIONS; n += n < 34 ? 1 : 47) {
            for (int isa = ENC_ISA_BASE; isa <= ENC_ISA_AVX512; isa++) {
                enc_isa_limit((enc_isa)isa);
                enc_sbrdf_evaluate(sbrdf, 1, directions[50].xyz, n, light[0], light[1], light[2], out[isa]);
                assert_memory_equal(out[isa], out[0], (size_t)(3 * n) * sizeof(float));
            }
            for (int i = 0; i < 3 * n; i++) {
                double product[3];
                for (int k = 0; k < 3; k++) {
                    product[k] = (double)directions[50].xyz[k] * (double)light[k][i % n];
                }
                const double want = fit_model_value(sbrdf->values + stride, 3, rgb != 0, product, i / n);
                assert_true(fabs((double)out[0][i] - want) < 2e-6 * fabs(want) + 1e-9);
            }
        }
        enc_sbrdf_evaluate(sbrdf, 0, directions[50].xyz, DIRECTIONS, light[0], light[1], light[2], out[0]);
        for (int i = 0; i < 3 * DIRECTIONS; i++) {
            assert_true(out[0][i] == 0);
        }
        enc_sbrdf_destroy(&sbrdf);
        assert_null(sbrdf);
    }
    enc_sbrdf *none;
    assert_int_equal(enc_sbrdf_create(0, 3, false, &none), BTF_ERROR_USAGE);
    assert_int_equal(enc_sbrdf_create(1, 5, false, &none), BTF_ERROR_USAGE);
    assert_int_equal(enc_sbrdf_create(SIZE_MAX / 8, 4, true, &none), BTF_ERROR_USAGE);
    assert_null(none);
}

static double product_at(const pairs *p, size_t i, const float *shape) {
    return (double)shape[0] * (double)p->product[0][i] + (double)shape[1] * (double)p->product[1][i] +
           (double)shape[2] * (double)p->product[2][i];
}

/* Every entry against double sums of columns whose derivatives come from central differences of pow. */
TEST(test_gram) {
    pairs *p = make_pairs();
    fill_targets(p, three_lobes, 3, false);
    const enc_gram_samples samples = {
        .n = PAIRS,
        .product = {p->product[0], p->product[1], p->product[2]},
        .multiplier = p->multiplier,
        .target = {p->target[0], p->target[1], p->target[2]},
    };
    enc_gram_point point = {
        .shape = {{-0.9f, -0.8f, 1.1f, 9}, {0.7f, -0.2f, 0.6f, 2}, {0.1f, 0.8f, 0.5f, 0.7f}, {0, 0, 1, 1}},
        .colour = {{0.3f, 0.5f, 0.2f, 0.1f, 0.2f},
                   {0.2f, 0.4f, 0.1f, 0.3f, 0},
                   {0.1f, 0.1f, 0.1f, 0.1f, 1}},
    };
    for (int lobes = 1; lobes <= ENC_MAX_LOBES; lobes++) {
        const int columns = enc_gram_columns(lobes);
        double *column = calloc((size_t)columns * PAIRS, sizeof *column);
        double gram[3][ENC_GRAM_MAX_COLUMNS * ENC_GRAM_MAX_COLUMNS];
        assert_non_null(column);
        for (size_t i = 0; i < PAIRS; i++) {
            const double m = (double)p->multiplier[i];
            double model[3];
            column[i] = m;
            for (int c = 0; c < 3; c++) {
                model[c] = m * (double)point.colour[c][0];
            }
            for (int j = 0; j < lobes; j++) {
                const float *shape = point.shape[j];
                const double base = product_at(p, i, shape), n = (double)shape[3], h = 1e-5;
                const bool on = base >= (double)ENC_GRAM_MIN_BASE;
                const double value = on ? m * pow(base, n) : 0;
                for (int k = 0; k < 4 && on; k++) {
                    const double step = k < 3 ? h * (double)p->product[k][i] : 0, dn = k < 3 ? 0 : h;
                    const double up = pow(fmax(base + step, 0), n + dn),
                                 down = pow(fmax(base - step, 0), n - dn);
                    const double derivative = m * (up - down) / (2 * h);
                    column[(size_t)(4 + 4 * j + k) * PAIRS + i] = k < 3 ? derivative / n : derivative;
                }
                for (int c = 0; c < 3; c++) {
                    model[c] += (double)point.colour[c][1 + j] * value;
                }
            }
            for (size_t c = 0; c < 3; c++) {
                column[(1 + c) * PAIRS + i] = model[c] - (double)p->target[c][i];
            }
        }
        for (int isa = ENC_ISA_BASE; isa <= ENC_ISA_AVX512; isa++) {
            enc_isa_limit((enc_isa)isa);
            enc_gram_accumulate(&samples, lobes, &point, gram[isa]);
            assert_memory_equal(gram[isa], gram[0], sizeof(double) * (size_t)(columns * columns));
        }
        for (int a = 0; a < columns; a++) {
            for (int b = 0; b < columns; b++) {
                double want = 0, aa = 0, bb = 0;
                for (size_t i = 0; i < PAIRS; i++) {
                    const double x = column[(size_t)a * PAIRS + i], y = column[(size_t)b * PAIRS + i];
                    want += x * y, aa += x * x, bb += y * y;
                }
                assert_true(fabs(gram[0][a * columns + b] - want) <= 2e-6 * sqrt(aa * bb));
            }
        }
        free(column);
    }
    const float c[3] = {1, -1, 0.5f};
    float want = ENC_GRAM_MIN_BASE;
    for (size_t i = 0; i < PAIRS; i++) {
        want = fmaxf(want, (c[0] * p->product[0][i] + c[1] * p->product[1][i]) + c[2] * p->product[2][i]);
    }
    assert_true(enc_gram_peak(&samples, c) == want);
    free(p);
}

/* J^T f of the projected problem is half the gradient of the cost: compared with central differences of the cost. */
TEST(test_normal_equations) {
    pairs *p = make_pairs();
    for (int rgb = 0; rgb < 2; rgb++) {
        fill_targets(p, rgb ? three_rgb : three_lobes, 3, rgb != 0);
        for (size_t i = 0; i < PAIRS; i++) {
            for (int c = 0; c < 3; c++) {
                p->target[c][i] += 0.05f * fit_random();
            }
        }
        enc_fit_problem problem = {
            .samples = {.n = PAIRS,
                        .product = {p->product[0], p->product[1], p->product[2]},
                        .multiplier = p->multiplier,
                        .target = {p->target[0], p->target[1], p->target[2]}},
            .lobes = 3,
            .rgb = rgb != 0,
            .scale = 1,
            .overshoot = {100, 100, 100, 100},
        };
        const int size = rgb ? 12 : 13;
        double parameters[13] = {0.5, -0.9, -0.8, 1.1, 2.2, 0.7, -0.2, 0.6, 0.9, 0.2, 0.7, 0.6, 0.4};
        double normal[14 * 14], scratch[14 * 14];
        double *at = parameters + rgb;
        /* Twice: the second time residuals are taken at the solved colours. */
        for (int pass = 0; pass < 2; pass++) {
            problem.best.cost = DBL_MAX;
            enc_fit_evaluate(&problem, at, normal);
        }
        const double cost = normal[(size + 1) * (size + 1) - 1];
        assert_true(cost > 0 && fabs(cost - problem.best.cost) < 1e-12 * cost);
        double largest = 0;
        for (int i = 0; i < size; i++) {
            largest = fmax(largest, fabs(normal[i * (size + 1) + size]));
            assert_true(normal[i * (size + 1) + i] >= 0);
        }
        for (int i = 0; i < size; i++) {
            const double keep = at[i], h = 1e-3;
            double side[2];
            for (int s = 0; s < 2; s++) {
                at[i] = keep + (s ? h : -h);
                enc_fit_evaluate(&problem, at, scratch);
                side[s] = scratch[(size + 1) * (size + 1) - 1];
            }
            at[i] = keep;
            const double slope = (side[1] - side[0]) / (2 * h) / 2;
            assert_true(fabs(slope - normal[i * (size + 1) + size]) < 2e-3 * largest);
        }
    }
    free(p);
}

static double psnr(double cost) {
    return -10 * log10(cost / (3.0 * PAIRS) + 1e-30);
}

TEST(test_recovers_lobes) {
    static const float one[8] = {0.2f, 0.5f, 1, 0.4f, -0.8f, -0.8f, 0.9f, 30};
    static const float two[12] = {1, 0.5f, 0.3f, 0.2f, -0.7f, -0.7f, 0.7f, 12, 0.5f, 0.4f, 0.6f, 2};
    static const float *const known[3] = {one, two, three_lobes};
    pairs *p = make_pairs();
    for (int lobes = 1; lobes <= 3; lobes++) {
        float out[31];
        fill_targets(p, known[lobes - 1], lobes, false);
        const enc_fit_result result = fit_pairs(p, PAIRS, lobes, false, 1e-4, out);
        const double cost = cost_of(out, lobes, false, p, PAIRS);
        assert_true(psnr(cost) > 60);
        assert_true(fabs(sqrt(cost) - sqrt(result.cost)) < 1e-5 * sqrt(3.0 * PAIRS));
        assert_false(result.diffuse);
        assert_true(fmaxf(fmaxf(out[0], out[1]), out[2]) == 1);
    }
    float out[31];
    fill_targets(p, three_rgb, 3, true);
    fit_pairs(p, PAIRS, 3, true, 1e-4, out);
    assert_true(psnr(cost_of(out, 3, true, p, PAIRS)) > 60);
    for (int i = 0; i < 12; i++) {
        assert_true(out[i] >= 0);
    }
    free(p);
}

/* The fit's cost is at most 2 % above the one that Ceres reaches with automatic derivatives and without a limit of
 * steps. */
TEST(test_against_ceres) {
    pairs *p = make_pairs();
    fill_targets(p, three_lobes, 3, false);
    fit_random_state = 11;
    for (size_t i = 0; i < PAIRS; i++) {
        const float shadow = i % DIRECTIONS % 5 == 0 ? 0.3f : 1;
        for (int c = 0; c < 3; c++) {
            p->target[c][i] *= shadow * (0.8f + 0.4f * fit_random());
        }
    }
    float start[16], out[31];
    double parameters[16], ceres_cost;
    int iterations;
    enc_fit_fixed_start(0, 3, start);
    for (int i = 0; i < 16; i++) {
        parameters[i] = (double)start[i];
    }
    const float *const product[3] = {p->product[0], p->product[1], p->product[2]};
    const float *const target[3] = {p->target[0], p->target[1], p->target[2]};
    assert_true(enc_ceres_autodiff_fit(PAIRS, product, p->multiplier, target, ENC_FIT_MIN_N, ENC_FIT_MAX_N,
                                       ENC_FIT_MAX_C, 1e-6, parameters, &ceres_cost, &iterations));
    float ceres[16];
    for (int i = 0; i < 16; i++) {
        ceres[i] = (float)parameters[i];
    }
    assert_true(fabs(cost_of(ceres, 3, false, p, PAIRS) / ceres_cost - 1) < 1e-3);
    const enc_fit_result result = fit_pairs(p, PAIRS, 3, false, 1e-3, out);
    assert_true(result.cost < 1.02 * ceres_cost);
    assert_true(fabs(cost_of(out, 3, false, p, PAIRS) / result.cost - 1) < 1e-3);
    free(p);
}

TEST(test_lambertian) {
    static const float albedo[3] = {0.9f, 0.3f, 0.05f};
    pairs *p = make_pairs();
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < PAIRS; i++) {
            p->target[c][i] = albedo[c] * p->multiplier[i];
        }
    }
    for (int rgb = 0; rgb < 2; rgb++) {
        float out[31];
        fit_pairs(p, PAIRS, 3, rgb != 0, 1e-3, out);
        for (int c = 0; c < 3; c++) {
            for (size_t i = 0; i < PAIRS; i++) {
                assert_true(fabs(pair_value(out, 3, rgb != 0, p, i, c) - (double)p->target[c][i]) < 2e-5);
            }
        }
    }
    free(p);
}

TEST(test_hopeless_data) {
    static const float none[31];
    pairs *p = make_pairs();
    float out[31];
    for (int rgb = 0; rgb < 2; rgb++) {
        for (int kind = 0; kind < 8; kind++) {
            for (size_t i = 0; i < PAIRS; i++) {
                const float noise = fit_random();
                const float value = kind == 0   ? 0
                                    : kind == 1 ? 0.5f
                                    : kind == 2 ? 1e30f * noise
                                    : kind == 3 ? 1e-30f * noise
                                    : kind == 4 ? (i == 1234 ? 1e6f : 0)
                                    : kind == 5 ? (i % 97 == 0 ? 1e9f * noise : noise)
                                    : kind == 6 ? 1e-44f
                                                : FLT_MAX * noise;
                for (int c = 0; c < 3; c++) {
                    p->target[c][i] = c == kind % 3 ? value : 0.5f * value;
                }
            }
            const enc_fit_result result = fit_pairs(p, PAIRS, 3, rgb != 0, 1e-3, out);
            if (kind == 0) {
                assert_memory_equal(out, none, enc_sbrdf_stride(3, rgb != 0) * sizeof(float));
                assert_true(result.cost == 0);
            }
            if (kind == 1) { /* better than the best diffuse model, whose cost is known in closed form */
                double mm = 0, m = 0;
                for (size_t i = 0; i < PAIRS; i++) {
                    mm += (double)p->multiplier[i] * (double)p->multiplier[i];
                    m += (double)p->multiplier[i];
                }
                const double diffuse = (0.25 + 2 * 0.0625) * (PAIRS - m * m / mm);
                assert_true(result.cost <= diffuse * (1 + 1e-6));
                assert_true(cost_of(out, 3, rgb != 0, p, PAIRS) <= diffuse * (1 + 1e-5));
            }
        }
    }
    /* all multipliers are 0: no model has any effect */
    memset(p->multiplier, 0, sizeof p->multiplier);
    const enc_fit_result result = fit_pairs(p, PAIRS, 2, false, 1e-3, out);
    assert_true(result.diffuse);
    free(p);
}

TEST(test_few_samples) {
    pairs *p = make_pairs();
    fill_targets(p, three_lobes, 3, false);
    for (size_t n = 1; n < 12; n++) {
        for (int rgb = 0; rgb < 2; rgb++) {
            float out[31];
            const enc_fit_result result = fit_pairs(p, n, 4, rgb != 0, 1e-3, out);
            double energy = 0;
            for (int c = 0; c < 3; c++) {
                for (size_t i = 0; i < n; i++) {
                    energy += (double)p->target[c][i] * (double)p->target[c][i];
                }
            }
            assert_true(result.cost < energy);
            assert_true(fabs(cost_of(out, 4, rgb != 0, p, n) - result.cost) < 1e-4 * energy);
        }
    }
    free(p);
}

/* Two lobes that start equal, on data of one: the Gram matrix is singular all the way. */
TEST(test_rank_deficient) {
    static const float one[8] = {1, 1, 1, 0.2f, -0.7f, -0.7f, 0.7f, 6};
    static const float start[12] = {1, 1, 1, 0.5f, -0.5f, -0.5f, 0.5f, 3, -0.5f, -0.5f, 0.5f, 3};
    static const float start_rgb[17] = {0.5f, 0.5f, 0.5f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f,
                                        -1,   -1,   1,    3,    -1,   -1,   1,    3};
    pairs *p = make_pairs();
    fill_targets(p, one, 1, false);
    for (int rgb = 0; rgb < 2; rgb++) {
        enc_fit_options options = enc_fit_options_default();
        options.lobes = 2;
        options.rgb = rgb != 0;
        enc_fit_workspace *workspace;
        assert_int_equal(enc_fit_workspace_create(PAIRS, &workspace), BTF_OK);
        const enc_fit_samples samples = samples_of(p, PAIRS);
        enc_fit_result result;
        float out[17];
        const float *from = rgb ? start_rgb : start;
        assert_int_equal(enc_fit_texel(workspace, &samples, &options, from, 0, out, &result), BTF_OK);
        fit_assert_storable(out, enc_sbrdf_stride(2, rgb != 0));
        assert_true(psnr(cost_of(out, 2, rgb != 0, p, PAIRS)) > 50);
        enc_fit_workspace_destroy(&workspace);
    }
    free(p);
}

/* From any start, the end is at least as good; weights count as repeated samples. */
TEST(test_start_and_weights) {
    pairs *p = make_pairs(), *twice = make_pairs();
    float *weight = malloc(PAIRS * sizeof *weight);
    assert_non_null(weight);
    enc_fit_workspace *workspace;
    assert_int_equal(enc_fit_workspace_create(PAIRS, &workspace), BTF_OK);
    for (int round = 0; round < 24; round++) {
        const bool rgb = round % 2 != 0;
        float from[31] = {0}, out[31];
        for (size_t i = 0; i < enc_sbrdf_stride(3, rgb); i++) {
            from[i] = fit_random();
        }
        float *shape = from + (rgb ? 12 : 4);
        for (int j = 0; j < 3; j++) {
            const bool dead = round % 6 == 4 && j == 1;
            for (int k = 0; k < 3; k++) {
                shape[4 * j + k] = dead ? 0 : 2 * fit_random() - (k < 2 ? 1 : 0);
            }
            shape[4 * j + 3] = dead ? 0 : 0.6f + 50 * fit_random() * fit_random();
        }
        for (size_t i = 0; i < PAIRS; i++) {
            for (int c = 0; c < 3; c++) {
                p->target[c][i] = fit_random() * p->multiplier[i] * (i % 7 == 0 ? 3 : 1);
            }
        }
        enc_fit_options options = enc_fit_options_default();
        options.rgb = rgb;
        enc_fit_samples samples = samples_of(p, PAIRS);
        enc_fit_result result;
        double energy = 0;
        for (int c = 0; c < 3; c++) {
            for (size_t i = 0; i < PAIRS; i++) {
                energy += (double)p->target[c][i] * (double)p->target[c][i];
            }
        }
        assert_int_equal(enc_fit_texel(workspace, &samples, &options, from, 0, out, &result), BTF_OK);
        const double before = cost_of(from, 3, rgb, p, PAIRS), after = cost_of(out, 3, rgb, p, PAIRS);
        assert_true(after <= before + 1e-6 * energy);
        assert_true(fabs(after - result.cost) < 1e-5 * energy);

        /* The end as a start: no worse. */
        memcpy(from, out, sizeof from);
        assert_int_equal(enc_fit_texel(workspace, &samples, &options, from, 0, out, &result), BTF_OK);
        assert_true(cost_of(out, 3, rgb, p, PAIRS) <= after + 1e-6 * energy);
    }
    fill_targets(p, three_lobes, 3, false);
    const size_t sources = PAIRS / 3 * 3;
    size_t n = 0;
    for (size_t i = 0; i < sources; i++) {
        weight[i] = (float)(i % 3);
        for (size_t repeat = 0; repeat < i % 3; repeat++, n++) {
            for (int k = 0; k < 3; k++) {
                p->target[k][i] += 0.1f * fit_random();
                twice->product[k][n] = p->product[k][i];
            }
            twice->multiplier[n] = p->multiplier[i];
        }
    }
    n = 0;
    for (size_t i = 0; i < sources; i++) {
        for (size_t repeat = 0; repeat < i % 3; repeat++, n++) {
            for (int k = 0; k < 3; k++) {
                twice->target[k][n] = p->target[k][i];
            }
        }
    }
    assert_int_equal(n, sources);
    const enc_fit_options options = enc_fit_options_default();
    enc_fit_samples weighted = samples_of(p, sources);
    const enc_fit_samples repeated = samples_of(twice, n);
    weighted.weight = weight;
    float a[16], b[16];
    enc_fit_result weighted_result, repeated_result;
    assert_int_equal(enc_fit_texel(workspace, &weighted, &options, three_lobes, 0, a, &weighted_result),
                     BTF_OK);
    assert_int_equal(enc_fit_texel(workspace, &repeated, &options, three_lobes, 0, b, &repeated_result),
                     BTF_OK);
    assert_true(weighted_result.cost > 1);
    assert_true(fabs(weighted_result.cost / repeated_result.cost - 1) < 1e-4);
    enc_fit_workspace_destroy(&workspace);
    free(weight);
    free(p);
    free(twice);
}

/* A lobe must not overshoot between or beyond the samples; here one bright sample lies at the edge of the grid. */
TEST(test_overshoot) {
    pairs *p = make_pairs();
    for (int rgb = 0; rgb < 2; rgb++) {
        for (size_t i = 0; i < PAIRS; i++) {
            for (int c = 0; c < 3; c++) {
                p->target[c][i] = 0.3f * p->multiplier[i];
            }
        }
        p->target[rgb][80 * DIRECTIONS + 80] = 1;
        p->target[2][80 * DIRECTIONS + 79] = 1;
        float out[31];
        fit_pairs(p, PAIRS, 3, rgb != 0, 1e-3, out);
        const float *shape = out + (rgb ? 12 : 4);
        for (int j = 0; j < 3; j++, shape += 4) {
            double largest = 0;
            for (size_t i = 0; i < PAIRS; i++) {
                largest = fmax(largest, product_at(p, i, shape));
            }
            const double widest =
                fmax(fmax(fabs((double)shape[0]), fabs((double)shape[1])), (double)shape[2]);
            if (largest > 1e-4) {
                assert_true(pow(widest / largest, (double)shape[3]) < 4.01);
            }
        }
    }
    free(p);
}

RUN_TESTS(NULL, NULL)
