/* Shares of centres, k-means and codes on points whose clusters are known.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/paper/cluster.h"
#include "encoder/math/kmeans.h"
#include "encoder/paper/cluster_split.h"
#include "encoder/math/simd.h"
#include "tests/support/test.h"
#include "tests/support/uniform.h"

static const enc_context context = {.threads = 2};
static const enc_context one_thread = {.threads = 1};

static uint32_t random_state;

TEST(test_shares_by_largest_remainder) {
    /* quotas of 10 among 47, 16, 158, 81 and 0: 1.556, 0.530, 5.232, 2.682: the second is raised to 1 */
    const size_t hidden[5] = {47, 16, 158, 81, 0};
    size_t shares[5];
    enc_cluster_shares(5, hidden, hidden, 10, shares);
    assert_true(shares[0] + shares[1] + shares[2] + shares[3] == 10 && shares[4] == 0);
    assert_int_equal(shares[1], 1);
    /* of 21: 3.268, 1.113, 10.987, 5.632: whole 3, 1, 10, 5, the two left to the third and the fourth */
    enc_cluster_shares(5, hidden, hidden, 21, shares);
    const size_t expected[5] = {3, 1, 11, 6, 0};
    assert_memory_equal(shares, expected, sizeof expected);
    /* equal remainders: the lower view */
    const size_t equal[3] = {10, 10, 10};
    enc_cluster_shares(3, equal, equal, 7, shares);
    assert_true(shares[0] == 3 && shares[1] == 2 && shares[2] == 2);
    /* fewer centres than views: the fullest */
    enc_cluster_shares(5, hidden, hidden, 2, shares);
    assert_true(shares[0] == 0 && shares[1] == 0 && shares[2] == 1 && shares[3] == 1);
    /* more than points: all of them */
    enc_cluster_shares(5, hidden, hidden, 1000, shares);
    assert_memory_equal(shares, hidden, sizeof hidden);
    /* duplicates bind the third view; the others share what it leaves in proportion 47 : 16 : 81 */
    const size_t distinct[5] = {47, 16, 3, 81, 0};
    enc_cluster_shares(5, hidden, distinct, 75, shares);
    assert_true(shares[2] == 3 && shares[0] + shares[1] + shares[3] == 72);
    assert_true(shares[0] == 23 || shares[0] == 24); /* 23.5 */
    assert_int_equal(shares[1], 8);
    assert_true(shares[3] == 40 || shares[3] == 41); /* 40.5 */
    enc_cluster_shares(5, hidden, distinct, 0, shares);
    for (int v = 0; v < 5; v++) {
        assert_int_equal(shares[v], 0);
    }
}

TEST(test_shares_always_add_up) {
    random_state = 3;
    for (int round = 0; round < 3000; round++) {
        size_t hidden[256], distinct[256], shares[256], all = 0, active = 0, points = 0;
        const int n = 1 + (int)(uniform(&random_state) * 20) * (round % 2 ? 1 : 12);
        for (int v = 0; v < n; v++) {
            hidden[v] = uniform(&random_state) < 0.3f
                            ? 0
                            : 1 + (size_t)(uniform(&random_state) * uniform(&random_state) * 5000);
            distinct[v] =
                hidden[v] == 0 ? 0 : 1 + (size_t)(uniform(&random_state) * (float)(hidden[v] - 1));
            if (uniform(&random_state) < 0.5f) {
                distinct[v] = hidden[v];
            }
            all += distinct[v];
            points += hidden[v];
            active += hidden[v] > 0;
        }
        const size_t k = (size_t)(uniform(&random_state) * 1.2f * (float)all);
        enc_cluster_shares(n, hidden, distinct, k, shares);
        size_t sum = 0;
        bool bound = false;
        for (int v = 0; v < n; v++) {
            sum += shares[v];
            assert_true(shares[v] <= distinct[v]);
            assert_true(hidden[v] == 0 || k < active || shares[v] >= 1);
            const double quota = points > 0 ? (double)k * (double)hidden[v] / (double)points : 0;
            bound = bound || (hidden[v] > 0 && (quota < 1 || quota > (double)distinct[v]));
        }
        assert_int_equal(sum, k < all ? k : all);
        for (int v = 0; v < n && !bound; v++) {
            const double quota = points > 0 ? (double)k * (double)hidden[v] / (double)points : 0;
            assert_true(fabs((double)shares[v] - quota) < 1);
        }
    }
}

/* A BTF of 3 views under 5 lights with all points of views 1 and 2 hidden; profiles are set by the caller. */
enum { VIEWS = 3, LIGHTS = 5, PROFILE = 3 * LIGHTS };
static enc_data *make_data(const enc_context *with, int width, int height, enc_occlusion **out_occlusion) {
    enc_direction views[VIEWS], lights[LIGHTS];
    for (int v = 0; v < VIEWS; v++) {
        views[v] = enc_direction_from_angles(v == 0 ? 0 : 30, 90.0 * v);
    }
    for (int l = 0; l < LIGHTS; l++) {
        lights[l] = enc_direction_from_angles(l == 0 ? 0 : 40, 80.0 * l);
    }
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(with, width, height, VIEWS, views, LIGHTS, lights, &data), BTF_OK);
    const size_t texels = enc_data_texel_count(data);
    assert_int_equal(enc_occlusion_create(VIEWS, texels, out_occlusion), BTF_OK);
    memset((*out_occlusion)->hidden + texels, 1, 2 * texels);
    return data;
}

static float *profile_of(enc_data *data, size_t texel, int view) {
    return data->samples + (texel * VIEWS + (size_t)view) * PROFILE;
}

/* Largest difference of square roots between a point and its centre. */
static float worst_root_error(const enc_data *data, const enc_occlusion *o, const enc_centres *c) {
    float worst = 0;
    for (size_t v = 0; v < VIEWS; v++) {
        for (size_t t = 0; t < o->n_texels; t++) {
            const size_t i = v * o->n_texels + t;
            if (!o->hidden[i]) {
                continue;
            }
            assert_true(o->centre[i] < c->k);
            const float *profile = data->samples + (t * VIEWS + v) * PROFILE;
            for (size_t l = 0; l < LIGHTS; l++) {
                for (size_t k = 0; k < 3; k++) {
                    const float code = (float)c->codes[(o->centre[i] * LIGHTS + l) * 3 + k];
                    worst = fmaxf(worst, fabsf(code * c->scale - sqrtf(profile[k * LIGHTS + l])));
                }
            }
        }
    }
    return worst;
}

TEST(test_separable_clusters) {
    for (int variant = 0; variant < 4; variant++) {
        enc_occlusion *o = NULL;
        enc_data *data = make_data(&context, 12, 10, &o);
        random_state = 17;
        float prototype[2][4][PROFILE];
        for (size_t i = 0; i < 2; i++) {
            for (size_t j = 0; j < 4; j++) {
                for (size_t k = 0; k < PROFILE; k++) {
                    prototype[i][j][k] = 0.1f + 3 * uniform(&random_state);
                }
            }
        }
        for (size_t t = 0; t < 120; t++) {
            for (size_t v = 1; v < VIEWS; v++) {
                for (size_t k = 0; k < PROFILE; k++) {
                    profile_of(data, t, (int)v)[k] =
                        prototype[v - 1][t % 4][k] + 0.01f * uniform(&random_state);
                }
            }
        }
        const enc_cluster_options options = {.linear = variant & 1, .data_points = variant >> 1};
        enc_centres *c = NULL;
        assert_int_equal(enc_cluster(&context, data, &options, 8, o, &c), BTF_OK);
        assert_int_equal(c->k, 8);
        assert_int_equal(c->n_lights, LIGHTS);
        /* 4 centres a view, one a prototype */
        for (size_t v = 1; v < VIEWS; v++) {
            for (size_t t = 0; t < 120; t++) {
                const size_t i = v * 120 + t;
                assert_int_equal(o->centre[i], o->centre[v * 120 + t % 4]);
                assert_true(o->centre[i] / 4 == v - 1);
            }
        }
        for (size_t i = 0; i < 120; i++) {
            assert_int_equal(o->centre[i], 0);
        }
        assert_true(worst_root_error(data, o, c) < c->scale / 2 + 0.01f * 0.5f / sqrtf(0.1f));
        uint8_t most = 0;
        for (size_t i = 0; i < 8 * PROFILE; i++) {
            most = c->codes[i] > most ? c->codes[i] : most;
        }
        assert_int_equal(most, 255);
        enc_centres_destroy(&c);
        enc_occlusion_destroy(&o);
        enc_data_destroy(&data);
    }
}

/* Parts hold every row once, in order, none more than allowed; a set of two kinds falls into its kinds. */
TEST(test_split) {
    enum { ROWS = 1000, STRIDE = 16, MOST = 130 };
    float rows[ROWS][STRIDE] = {{0}};
    size_t order[ROWS], first[ROWS / MOST * 2 + 3], parts;
    uint8_t seen[ROWS] = {0};
    random_state = 5;
    for (size_t i = 0; i < ROWS; i++) {
        for (size_t d = 0; d < 9; d++) {
            rows[i][d] = uniform(&random_state) + (d == 6 && i % 2 ? 4.0f : 0.0f);
        }
    }
    assert_int_equal(enc_cluster_split(ROWS, STRIDE, rows[0], MOST, order, first, &parts), BTF_OK);
    assert_true(parts == 8 && first[0] == 0 && first[parts] == ROWS);
    for (size_t part = 0; part < parts; part++) {
        assert_true(first[part + 1] > first[part] && first[part + 1] - first[part] <= MOST);
        for (size_t i = first[part]; i < first[part + 1]; i++) {
            assert_int_equal(seen[order[i]]++, 0);
            assert_int_equal(order[i] % 2, order[first[part]] % 2);
            assert_true(i == first[part] || order[i] > order[i - 1]);
        }
    }
    assert_int_equal(enc_cluster_split(9, STRIDE, rows[0], MOST, order, first, &parts), BTF_OK);
    assert_true(parts == 1 && first[1] == 9 && order[8] == 8);
}

/* More hidden points than are clustered together: a view's centres still serve the points they were made
 * for. */
TEST(test_parts_of_a_view) {
    enum { TEXELS = 70 * 60 };
    enc_occlusion *o = NULL;
    enc_data *data = make_data(&context, 70, 60, &o);
    random_state = 17;
    float prototype[2][2][PROFILE];
    for (size_t i = 0; i < 4; i++) {
        for (size_t k = 0; k < PROFILE; k++) {
            prototype[i / 2][i % 2][k] = 0.1f + 3 * uniform(&random_state);
        }
    }
    for (size_t t = 0; t < TEXELS; t++) {
        for (size_t v = 1; v < VIEWS; v++) {
            for (size_t k = 0; k < PROFILE; k++) {
                profile_of(data, t, (int)v)[k] =
                    prototype[v - 1][t % 2][k] + 0.01f * uniform(&random_state);
            }
        }
    }
    enc_centres *c = NULL;
    assert_int_equal(enc_cluster(&context, data, NULL, 4, o, &c), BTF_OK);
    assert_int_equal(c->k, 4);
    assert_true(worst_root_error(data, o, c) < c->scale / 2 + 0.01f * 0.5f / sqrtf(0.1f));
    enc_centres_destroy(&c);
    enc_occlusion_destroy(&o);
    enc_data_destroy(&data);
}

TEST(test_more_centres_than_points) {
    enc_occlusion *o = NULL;
    enc_data *data = make_data(&context, 10, 1, &o);
    random_state = 4;
    for (size_t t = 0; t < 10; t++) { /* view 1: 3 different points among 10; view 2: all different */
        for (size_t k = 0; k < PROFILE; k++) {
            profile_of(data, t, 1)[k] = (float)((t % 3) * 7 + k) / 40;
            profile_of(data, t, 2)[k] = uniform(&random_state);
        }
    }
    profile_of(data, 0, 1)[0] = -0.0f; /* the same point as +0 */
    enc_centres *c = NULL;
    assert_int_equal(enc_cluster(&context, data, NULL, 1984, o, &c), BTF_OK);
    assert_int_equal(c->k, 13);
    /* every point is a centre of its own: codes are the only loss */
    assert_true(worst_root_error(data, o, c) <= c->scale * 0.5001f);
    enc_centres_destroy(&c);
    /* K is met exactly on the way there */
    for (int k = 2; k <= 13; k++) {
        assert_int_equal(enc_cluster(&context, data, NULL, k, o, &c), BTF_OK);
        assert_int_equal(c->k, k);
        enc_centres_destroy(&c);
    }
    /* fewer than views: points take what there is */
    assert_int_equal(enc_cluster(&context, data, NULL, 1, o, &c), BTF_OK);
    assert_int_equal(c->k, 1);
    (void)worst_root_error(data, o, c);
    enc_centres_destroy(&c);
    enc_occlusion_destroy(&o);
    enc_data_destroy(&data);
}

TEST(test_nothing_hidden_and_black) {
    enc_occlusion *o = NULL;
    enc_data *data = make_data(&context, 4, 4, &o);
    enc_centres *c = NULL;
    assert_int_equal(enc_cluster(&context, data, NULL, 5, o, &c), BTF_OK); /* all black: one point a view */
    assert_int_equal(c->k, 2);
    assert_true(c->scale > 0 && isfinite(c->scale));
    for (size_t i = 0; i < 2 * PROFILE; i++) {
        assert_int_equal(c->codes[i], 0);
    }
    enc_centres_destroy(&c);
    assert_int_equal(enc_cluster(&context, data, NULL, 0, o, &c), BTF_ERROR_USAGE);
    assert_null(c);
    assert_int_equal(enc_cluster(&context, data, NULL, 65537, o, &c), BTF_ERROR_USAGE);
    memset(o->hidden, 0, VIEWS * 16);
    memset(o->centre, 77, VIEWS * 16 * sizeof *o->centre);
    assert_int_equal(enc_cluster(&context, data, NULL, 0, o, &c), BTF_OK);
    assert_int_equal(c->k, 0);
    for (size_t i = 0; i < VIEWS * 16; i++) {
        assert_int_equal(o->centre[i], 0);
    }
    enc_centres_destroy(&c);
    enc_centres_destroy(&c);
    enc_occlusion_destroy(&o);
    enc_data_destroy(&data);
}

/* Threads, instruction sets and where the samples lie change nothing; the seed does. */
TEST(test_same_result_everywhere) {
    const enc_context tight = {.threads = 2, .memory = 1};
    enc_centres *first = NULL;
    enc_occlusion *first_occlusion = NULL;
    bool seed_matters = false;
    for (int k = 0; k < 5; k++) {
        const enc_context *with = k == 0 ? &one_thread : k == 3 ? &tight : &context;
        const enc_cluster_options options = {.seed = k == 4 ? 12345 : 0};
        enc_isa_limit(k == 1 ? ENC_ISA_BASE : k == 2 ? ENC_ISA_AVX2 : ENC_ISA_AVX512);
        enc_occlusion *o = NULL;
        enc_data *data = make_data(with, 16, 16, &o);
        random_state = 8;
        float samples[VIEWS * PROFILE];
        for (size_t t = 0; t < 256; t++) {
            for (size_t i = 0; i < VIEWS * PROFILE; i++) {
                samples[i] = uniform(&random_state) * uniform(&random_state);
            }
            assert_int_equal(enc_data_store_texels(with, data, t, 1, samples), BTF_OK);
        }
        for (size_t t = 0; t < 256; t++) {
            o->hidden[256 + t] = t % 3 == 0;
        }
        enc_centres *c = NULL;
        assert_int_equal(enc_cluster(with, data, &options, 40, o, &c), BTF_OK);
        if (k == 0) {
            first = c;
            first_occlusion = o;
        } else {
            const bool same =
                c->scale == first->scale && memcmp(c->codes, first->codes, 40 * PROFILE) == 0 &&
                memcmp(o->centre, first_occlusion->centre, VIEWS * 256 * sizeof *o->centre) == 0;
            assert_int_equal(c->k, 40);
            if (k < 4) {
                assert_true(same);
            } else {
                seed_matters = !same;
            }
            enc_centres_destroy(&c);
            enc_occlusion_destroy(&o);
        }
        enc_data_destroy(&data);
    }
    assert_true(seed_matters);
    enc_centres_destroy(&first);
    enc_occlusion_destroy(&first_occlusion);
}

TEST(test_kmeans_with_duplicates) {
    enum { N = 40, STRIDE = 16 };
    static float points[N * STRIDE], centres[4 * STRIDE];
    uint32_t index[N];
    size_t distinct;
    memset(points, 0, sizeof points);
    for (int i = 0; i < N; i++) {
        points[i * STRIDE] = i < 38 ? 1 : i == 38 ? 2 : 1e-20f;
    }
    assert_int_equal(enc_kmeans_distinct(N, STRIDE, points, &distinct), BTF_OK);
    assert_int_equal(distinct, 3);
    /* as many centres as different points: each its own; one more: nothing breaks */
    for (size_t k = 3; k <= 4; k++) {
        assert_int_equal(enc_kmeans(N, STRIDE, points, k, 30, 1, false, centres, index), BTF_OK);
        for (int i = 0; i < N; i++) {
            assert_true(index[i] < k);
            assert_true(centres[index[i] * STRIDE] == points[i * STRIDE]);
        }
    }
    /* one cluster: the mean */
    assert_int_equal(enc_kmeans(N, STRIDE, points, 1, 30, 1, false, centres, index), BTF_OK);
    assert_true(fabsf(centres[0] - 1) < 1e-6f);
}

/* The pruned search for the nearest centre against all of them. */
TEST(test_nearest_against_brute_force) {
    enum { N = 200, K = 60, STRIDE = 48 };
    static float points[N * STRIDE], centres[K * STRIDE], squares[N];
    static uint32_t index[N];
    random_state = 21;
    for (int i = 0; i < N * STRIDE; i++) {
        points[i] = uniform(&random_state) * (float)(1 + i / STRIDE % 5);
    }
    for (int i = 0; i < K * STRIDE; i++) {
        centres[i] = uniform(&random_state) * (float)(1 + i / STRIDE % 5);
    }
    memcpy(centres + 7 * STRIDE, centres + 3 * STRIDE,
           STRIDE * sizeof *centres); /* equals: the lower one */
    memcpy(points, centres + 3 * STRIDE, STRIDE * sizeof *points);
    for (int i = 0; i < N; i++) {
        index[i] = (uint32_t)i % K;
    }
    index[0] = 7;
    assert_int_equal(enc_kmeans_nearest(N, STRIDE, points, K, centres, index, squares, NULL), BTF_OK);
    assert_int_equal(index[0], 3);
    for (int i = 0; i < N; i++) {
        double least = INFINITY;
        uint32_t best = 0;
        for (uint32_t j = 0; j < K; j++) {
            double d = 0;
            for (int k = 0; k < STRIDE; k++) {
                d += pow((double)points[i * STRIDE + k] - (double)centres[j * STRIDE + (uint32_t)k], 2);
            }
            if (d < least) {
                least = d;
                best = j;
            }
        }
        assert_int_equal(index[i], best);
        assert_true(fabs((double)squares[i] - least) <= 1e-5 * least);
    }
}

RUN_TESTS(NULL, NULL)
