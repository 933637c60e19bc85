/* Fitted nodes: weights for any list of directions, the transform of data against one in double precision, and the
 * choice of a fit by material, against planted functions whose values between the samples are known.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/nodes/choose.h"
#include "encoder/nodes/fit.h"
#include "encoder/nodes/rows.h"
#include "tests/sample/directions.h"
#include "tests/support/random_material.h"
#include "tests/support/test.h"

static const enc_context one = {.threads = 1}, two = {.threads = 2};

/* 30 dB at the samples. */
static const enc_fit_error coder = {1e-3, 1e-3};

typedef struct list {
    enc_direction *at;
    int count;
} list;

static list parse(const char *text) {
    list l;
    assert_int_equal(directions_parse(NULL, text, &l.at, &l.count), BTF_OK);
    return l;
}

/* Returns by how much the sum of a row of weights differs from 1 at most; *out_gain is the largest sum of absolute
 * weights. */
static double sum_error(const float *w, int n, double *out_gain) {
    double worst = 0;
    *out_gain = 0;
    for (int i = 0; i < n; i++) {
        double sum = 0, gain = 0;
        for (int k = 0; k < n; k++) {
            assert_true(isfinite(w[i * n + k]));
            sum += (double)w[i * n + k];
            gain += fabs((double)w[i * n + k]);
        }
        worst = fmax(worst, fabs(sum - 1));
        *out_gain = fmax(*out_gain, gain);
    }
    return worst;
}

static double from_identity(const float *w, int n) {
    double worst = 0;
    for (int i = 0; i < n * n; i++) {
        worst = fmax(worst, fabs((double)w[i] - (i % (n + 1) == 0)));
    }
    return worst;
}

TEST(test_weights_keep_constants_and_kappa_keeps_the_samples) {
    static const char *const lists[] = {"ubo", "ubo2014", "small", "tiny", "256", "0:1,30:3", "45:4,60:7:11"};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
        const list l = parse(lists[i]);
        enc_node_fit *fit = NULL;
        float *w = malloc((size_t)l.count * (size_t)l.count * sizeof *w);
        double gain = 0, before = HUGE_VAL;
        assert_non_null(w);
        assert_int_equal(enc_node_fit_create(&one, l.at, l.count, ENC_FIT_POINTS, &fit), BTF_OK);
        for (int s = ENC_STRENGTHS - 1; s > 0; s--) { /* rising kappa */
            assert_int_equal(enc_node_fit_weights(fit, enc_strength_kappa[s], w), BTF_OK);
            const double sum = sum_error(w, l.count, &gain), far = from_identity(w, l.count);
            assert_true(sum < 1e-5);
            assert_true(gain < 3.0);
            assert_true(far <= before);
            before = far;
        }
        assert_int_equal(enc_node_fit_weights(fit, 1e9, w), BTF_OK);
        assert_true(from_identity(w, l.count) < 1e-6);
        printf("%s: %d directions, at the strongest kappa weights of a node sum to %.2f absolutely\n", lists[i], l.count, gain);
        enc_node_fit_destroy(&fit);
        free(w);
        free(l.at);
    }
}

/* Lists of directions through which no spline goes keep barycentric weights, without an error message. */
TEST(test_lists_without_a_spline_are_refused) {
    enc_node_fit *fit = NULL;
    enc_direction line[9], same[6];
    for (int i = 0; i < 9; i++) {
        line[i] = enc_direction_from_angles(fabs(i * 15.0 - 60), i < 4 ? 180 : 0);
    }
    for (int i = 0; i < 6; i++) {
        same[i] = enc_direction_from_angles(i < 5 ? 30 : 30.02, 72.0 * i);
    }
    for (int n = 1; n <= 9; n++) {
        assert_int_equal(enc_node_fit_create(&one, line, n, ENC_FIT_POINTS, &fit), BTF_ERROR_UNSUPPORTED);
        assert_null(fit);
    }
    /* two directions that nearly coincide: no fit, or one whose weights are not huge */
    const btf_result result = enc_node_fit_create(&one, same, 6, ENC_FIT_POINTS, &fit);
    if (result == BTF_OK) {
        float w[36];
        double gain;
        if (enc_node_fit_weights(fit, 0, w) == BTF_OK) {
            sum_error(w, 6, &gain);
            assert_true(gain <= ENC_FIT_MOST_GAIN);
        }
    } else {
        assert_int_equal(result, BTF_ERROR_UNSUPPORTED);
    }
    enc_node_fit_destroy(&fit);
}

/* A smooth function of a direction; strong: the strength of its curvature. */
static double smooth(const float d[3], double strong) {
    return 0.45 + 0.3 * sin(strong * (double)d[0] + 0.3) * cos(strong * (double)d[1]);
}

/* Squared error of barycentric blends of nodes in random directions up to `most` degrees. */
static double blend_error(const list *l, const double *nodes, double most) {
    enc_interpolator *blend = NULL;
    random_state r = {5};
    double sum = 0;
    assert_int_equal(enc_interpolator_create(&one, "views", l->at, l->count, ENC_INTERPOLATE_LINEAR, &blend),
                     BTF_OK);
    for (int i = 0; i < 500; i++) {
        const enc_direction to =
            enc_direction_from_angles(most * sqrt(random_unit(&r)), 360 * random_unit(&r));
        enc_weights w;
        double x = 0;
        enc_interpolator_weights(blend, to.xyz, &w);
        for (int k = 0; k < w.count; k++) {
            x += (double)w.weight[k] * nodes[w.index[k]];
        }
        assert_true(fabs(x) < 1);
        x -= smooth(to.xyz, 4);
        sum += x * x;
    }
    enc_interpolator_destroy(&blend);
    return sum / 500;
}

/* The fit reduces the error within the hull. Beyond 75 degrees, where decoders show the hull's edge, the error grows
 * little. */
TEST_OF_NUMBERS(test_a_smooth_function_comes_out_better_between) {
    const list l = parse("ubo");
    enc_node_fit *fit = NULL;
    float *w = malloc(81 * 81 * sizeof *w);
    double samples[81], nodes[81];
    assert_non_null(w);
    assert_int_equal(enc_node_fit_create(&one, l.at, l.count, ENC_FIT_POINTS, &fit), BTF_OK);
    for (int i = 0; i < 81; i++) {
        samples[i] = smooth(l.at[i].xyz, 4);
    }
    const double plain = blend_error(&l, samples, 70), beyond = blend_error(&l, samples, 89);
    double before = plain;
    for (int s = 2; s < ENC_STRENGTHS; s++) { /* falling kappa */
        assert_int_equal(enc_node_fit_weights(fit, enc_strength_kappa[s], w), BTF_OK);
        for (int i = 0; i < 81; i++) {
            nodes[i] = 0;
            for (int k = 0; k < 81; k++) {
                nodes[i] += (double)w[i * 81 + k] * samples[k];
            }
        }
        const double error = blend_error(&l, nodes, 70), further = blend_error(&l, nodes, 89);
        printf("kappa %g: squared error %.3g of %.3g, to the horizon %.3g of %.3g\n", enc_strength_kappa[s],
               error, plain, further, beyond);
        assert_true(error < before);
        assert_true(further < 1.1 * beyond);
        before = error;
    }
    assert_true(before < 0.5 * plain);
    enc_node_fit_destroy(&fit);
    free(w);
    free(l.at);
}

/* Data of a planted function of view and light; noise is added to the root of each sample. */
static enc_data *planted(const list *views, const list *lights, int side, double strong, double noise) {
    enc_data *data = NULL;
    random_state r = {9};
    assert_int_equal(enc_data_create(NULL, side, side, views->count, views->at, lights->count, lights->at, &data),
                     BTF_OK);
    for (size_t t = 0; t < enc_data_texel_count(data); t++) {
        float *out = data->samples + t * enc_data_texel_stride(data);
        for (int v = 0; v < views->count; v++) {
            for (int c = 0; c < 3; c++) {
                for (int l = 0; l < lights->count; l++) {
                    const double root = smooth(views->at[v].xyz, strong) * (0.8 + 0.02 * (double)(t % 7)) *
                                            smooth(lights->at[l].xyz, strong * (0.8 + 0.1 * c)) * 1.5 +
                                        noise * (random_unit(&r) - 0.5);
                    *out++ = (float)(root * root);
                }
            }
        }
    }
    return data;
}

TEST_OF_NUMBERS(test_smoothing_is_chosen_where_it_pays) {
    const list views = parse("ubo"), lights = parse("ubo");
    enc_fit_choice choice, again;
    enc_node_tables tables, same;
    enc_data *bent = planted(&views, &lights, 4, 4, 0), *noisy = planted(&views, &lights, 4, 0, 0.2);
    assert_int_equal(enc_fit_choose(&one, bent, true, 0, &coder, &choice, &tables), BTF_OK);
    assert_true(choice.chosen > 0);
    assert_true(choice.candidate[choice.chosen].gain.linear > 0);
    assert_true(choice.candidate[choice.chosen].left_out.linear < choice.candidate[0].left_out.linear);
    assert_int_equal(enc_fit_choose(&two, bent, true, 0, &coder, &again, &same), BTF_OK);
    assert_int_equal(choice.chosen, again.chosen);
    assert_memory_equal(choice.candidate, again.candidate, sizeof choice.candidate);
    assert_memory_equal(tables.views, same.views, 81 * 81 * sizeof(float));
    enc_node_tables_clear(&tables);
    enc_node_tables_clear(&same);
    /* a quality that no fit leaves intact: none is chosen */
    assert_int_equal(enc_fit_choose(&one, bent, true, 99, &coder, &choice, &tables), BTF_OK);
    assert_int_equal(choice.chosen, 0);
    assert_null(tables.views);
    /* noise has no structure that a spline could follow */
    assert_int_equal(enc_fit_choose(&one, noisy, true, 0, &coder, &choice, &tables), BTF_OK);
    printf("noise: kappa %g, gain %g\n", choice.candidate[choice.chosen].kappa_views,
           choice.candidate[choice.chosen].gain.linear);
    for (int k = 5; k < ENC_FIT_CANDIDATES; k++) {
        assert_int_not_equal(choice.chosen, k);
    }
    enc_node_tables_clear(&tables);
    enc_data_destroy(&bent);
    enc_data_destroy(&noisy);
    free(views.at);
    free(lights.at);
}

/* A fit adds little error at the samples compared with the coder's error, or with one level of 255. */
TEST_OF_NUMBERS(test_a_fine_coder_bounds_the_smoothing) {
    static const double errors[] = {0, 1e-5, 1e-4, 1e-3, 1e-2};
    const list views = parse("ubo"), lights = parse("ubo");
    enc_data *bent = planted(&views, &lights, 4, 4, 0);
    int before = 0;
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
        const enc_fit_error error = {errors[i], errors[i]};
        enc_fit_choice choice;
        enc_node_tables tables;
        assert_int_equal(enc_fit_choose(&two, bent, true, 0, &error, &choice, &tables), BTF_OK);
        const enc_fit_candidate *chosen = &choice.candidate[choice.chosen];
        printf("coder %g: candidate %d, which adds %g\n", errors[i], choice.chosen, chosen->at.srgb);
        assert_true(choice.chosen >= before);
        assert_true(chosen->at.srgb <= 0.3 * (errors[i] + 1 / (255.0 * 255)));
        before = choice.chosen;
        enc_node_tables_clear(&tables);
    }
    assert_true(before >= 4);
    enc_fit_choice choice;
    enc_node_tables tables;
    const enc_fit_error none = {0, 0};
    assert_int_equal(enc_fit_choose(&two, bent, true, 0, &none, &choice, &tables), BTF_OK);
    assert_true(choice.chosen < before);
    enc_node_tables_clear(&tables);
    enc_data_destroy(&bent);
    free(views.at);
    free(lights.at);
}

/* Where one list has no fit, that of the other is still used; where neither has, none is. */
TEST(test_lists_without_a_fit_leave_the_others) {
    static const char *const few[] = {"1", "2", "0:1,40:2"};
    const list ubo = parse("ubo");
    for (size_t i = 0; i < 3; i++) {
        const list short_list = parse(few[i]);
        enc_fit_choice choice;
        enc_node_tables tables;
        enc_data *data = planted(&ubo, &short_list, 3, 4, 0);
        assert_int_equal(enc_fit_choose(&two, data, true, 0, &coder, &choice, &tables), BTF_OK);
        assert_true(choice.chosen > 0);
        assert_true(isfinite(choice.candidate[choice.chosen].kappa_views));
        assert_true(isinf(choice.candidate[choice.chosen].kappa_lights));
        assert_true(from_identity(tables.lights, short_list.count) == 0);
        enc_node_tables_clear(&tables);
        enc_data_destroy(&data);
        data = planted(&short_list, &short_list, 3, 4, 0);
        assert_int_equal(enc_fit_choose(&two, data, true, 0, &coder, &choice, &tables), BTF_OK);
        assert_int_equal(choice.chosen, 0);
        enc_data_destroy(&data);
        free(short_list.at);
    }
    free(ubo.at);
}

/* As many views as there may be, and lights of another number that reach down to the horizon. */
TEST_OF_NUMBERS(test_long_and_low_lists_are_judged) {
    static const double rings[] = {75, 80, 85, 89.9};
    const list views = parse("256");
    enc_direction low[1 + 4 * 8] = {enc_direction_from_angles(0, 0)};
    for (int i = 0; i < 32; i++) {
        low[1 + i] = enc_direction_from_angles(rings[i / 8], 45.0 * (i % 8) + 10 * (i / 8));
    }
    const list lights = {low, 33};
    enc_data *data = planted(&views, &lights, 2, 4, 0), *fitted = NULL;
    enc_fit_choice choice;
    enc_node_tables tables;
    double gain;
    assert_int_equal(enc_fit_choose(&two, data, true, 0, &coder, &choice, &tables), BTF_OK);
    for (int k = 0; k < ENC_FIT_CANDIDATES; k++) {
        const enc_fit_candidate *c = &choice.candidate[k];
        assert_true(!c->judged || (isfinite(c->at.srgb) && isfinite(c->gain.linear) && c->between.srgb >= 0));
    }
    assert_true(choice.candidate[1].judged);
    assert_true(choice.chosen > 0);
    assert_true(sum_error(tables.views, 256, &gain) < 1e-5);
    assert_true(gain <= ENC_FIT_MOST_GAIN);
    assert_true(sum_error(tables.lights, 33, &gain) < 1e-5);
    assert_true(gain <= ENC_FIT_MOST_GAIN);
    assert_int_equal(enc_node_apply(&two, &tables, NULL, data, &fitted), BTF_OK);
    for (size_t i = 0; i < enc_data_texel_count(data) * enc_data_texel_stride(data); i++) {
        assert_true(fabsf(fitted->samples[i] - data->samples[i]) < 0.2f);
    }
    printf("256 views, 33 lights: candidate %d\n", choice.chosen);
    enc_node_tables_clear(&tables);
    enc_data_destroy(&fitted);
    enc_data_destroy(&data);
    free(views.at);
}

/* The transform against sums in double, in memory and through a scratch file, by one thread and two. */
TEST(test_data_are_transformed) {
    const list views = parse("tiny"), lights = parse("small");
    const int n = views.count, m = lights.count;
    enc_data *data = planted(&views, &lights, 3, 4, 0.05), *fitted = NULL, *filed = NULL;
    random_state r = {3};
    float w_v[25], w_l[19 * 19];
    for (int i = 0; i < n * n; i++) {
        w_v[i] = (float)(random_unit(&r) - 0.5);
    }
    for (int i = 0; i < m * m; i++) {
        w_l[i] = (float)(random_unit(&r) - 0.5);
    }
    const enc_node_tables tables = {n, m, w_v, w_l, true};
    const size_t stride = enc_data_texel_stride(data), bytes = 9 * stride * sizeof(float);
    const enc_context little = {.threads = 2, .memory = 2 * bytes}; /* the samples, and not as much again */
    float *buffer = malloc(9 * stride * sizeof *buffer);
    const float *read;
    int negative = 0;
    assert_int_equal(enc_node_apply(&one, &tables, NULL, data, &fitted), BTF_OK);
    assert_int_equal(enc_node_apply(&little, &tables, NULL, data, &filed), BTF_OK);
    assert_non_null(fitted->samples);
    assert_null(filed->samples);
    assert_ptr_equal(fitted->original, data);
    assert_int_equal(enc_data_texels(&one, filed, 0, 9, buffer, &read), BTF_OK);
    assert_memory_equal(read, fitted->samples, bytes);
    for (size_t t = 0; t < 9; t++) {
        for (int a = 0; a < n; a++) {
            for (int c = 0; c < 3; c++) {
                for (int k = 0; k < m; k++) {
                    double sum = 0;
                    for (int b = 0; b < n; b++) {
                        for (int j = 0; j < m; j++) {
                            sum += (double)w_v[a * n + b] * (double)w_l[k * m + j] *
                                   sqrt((double)data->samples[t * stride + (size_t)((b * 3 + c) * m + j)]);
                        }
                    }
                    const float got = fitted->samples[t * stride + (size_t)((a * 3 + c) * m + k)];
                    assert_true(fabs((double)got - sum * fabs(sum)) < 1e-5);
                    negative += got < 0;
                }
            }
        }
    }
    assert_true(negative > 0);
    free(buffer);
    enc_data_destroy(&fitted);
    enc_data_destroy(&filed);
    enc_data_destroy(&data);
    free(views.at);
    free(lights.at);
}

RUN_TESTS(NULL, NULL)
