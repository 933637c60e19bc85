/* Relief and gloss that the encoder finds in images alone: planted surfaces, and materials without any.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/nodes/fit.h"
#include "encoder/nodes/apply.h"
#include "encoder/relief/relief.h"
#include "tests/sample/directions.h"
#include "tests/support/test.h"

#include <openbtf/material.h>

static const enc_context one = {.threads = 1}, two = {.threads = 2};
static const enc_relief_options both = {.relief = true, .gloss = -1};

enum { SIDE = 24 };

static float random_of(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) * 0x1p-24f;
}

/* A material under three lights whose texels have random grey albedos and the heights (in texels) that `height` gives,
 * rendered by the decoder's march, plus uniform noise. */
static enc_data *planted(const char *views, double (*height)(int column, int row), float noise) {
    enc_direction *view, *light;
    enc_data *data = NULL;
    enc_warp w;
    int n_views, n_lights;
    uint32_t state = 7;
    float albedo[SIDE * SIDE];
    uint8_t codes[SIDE * SIDE];
    assert_int_equal(directions_parse(NULL, views, &view, &n_views), BTF_OK);
    assert_int_equal(directions_parse(NULL, "0:1,40:2", &light, &n_lights), BTF_OK);
    assert_int_equal(enc_data_create(&one, SIDE, SIDE, n_views, view, n_lights, light, &data), BTF_OK);
    for (int t = 0; t < SIDE * SIDE; t++) {
        albedo[t] = 0.1f + 0.8f * random_of(&state);
        codes[t] = (uint8_t)(height ? 4 * (height(t % SIDE, t / SIDE) + 8) : 0); /* quarters from -8 on */
    }
    assert_int_equal(enc_warp_create(SIDE, SIDE, 0, 0, &w), BTF_OK);
    if (height) {
        assert_int_equal(enc_warp_set_codes(&w, -8 * ENC_WARP_ONE, ENC_WARP_ONE * 64, 64, codes), BTF_OK);
    }
    for (int v = 0; v < n_views; v++) {
        int32_t slope[2];
        enc_warp_slope(view[v].xyz, slope);
        for (size_t t = 0; t < SIDE * SIDE; t++) {
            int32_t at[2];
            enc_warp_middle(&w, t, at);
            const int32_t z = enc_warp_march(&w, at[0], at[1], slope);
            const size_t from = enc_warp_texel(&w, at[0] + enc_warp_move(&w, z, slope[0]),
                                               at[1] + enc_warp_move(&w, z, slope[1]));
            for (int i = 0; i < 3 * n_lights; i++) {
                const float value =
                    albedo[from] * light[i % n_lights].xyz[2] + noise * (random_of(&state) - 0.5f);
                data->samples[(t * (size_t)n_views + (size_t)v) * 3 * (size_t)n_lights + (size_t)i] =
                    value > 0 ? value : 0;
            }
        }
    }
    enc_warp_clear(&w);
    free(view);
    free(light);
    return data;
}

static const char rings[] = "0:1,30:6,45:8,60:10", more[] = "0:1,15:6,30:10,45:12,60:14";

static double step(int column, int row) {
    (void)row;
    return column < SIDE / 2 ? -2 : 0;
}

/* A plane with towers on a few texels. */
static double towers(int column, int row) {
    return column % 8 < 2 && row % 8 < 2 ? 3 : 0;
}

static double sunk(int column, int row) {
    (void)column;
    (void)row;
    return 1.25;
}

static double raised(int column, int row) {
    (void)column;
    (void)row;
    return 1;
}

static double high(int column, int row) {
    return 8 * raised(column, row);
}

TEST(test_a_step_is_found) {
    enc_data *data = planted(more, step, 0);
    enc_relief_choice choice;
    enc_relief_store store;
    double error = 0;
    int off = 0;
    assert_int_equal(enc_relief_choose(&two, data, &both, &choice, &store), BTF_OK);
    assert_true(choice.chosen > 0 && store.effects & BTF_EFFECT_RELIEF && store.heights);
    assert_true(store.steps >= 8 && store.steps <= BTF_MAX_RELIEF_STEPS);
    for (int t = 0; t < SIDE * SIDE; t++) {
        const double z = (store.base + ((store.heights[t] * store.step) >> 8)) / 256.0;
        const double far = fabs(z - step(t % SIDE, t / SIDE));
        error += far;
        off += far > 0.5;
    }
    printf("mean error %.3f texels, %d of %d off by more than half a texel\n", error / (SIDE * SIDE), off,
           SIDE * SIDE);
    assert_true(error / (SIDE * SIDE) < 0.35);
    assert_true(off < SIDE * SIDE / 6); /* the foot of the step is wrong, as few views show it */
    enc_relief_clear(&store);
    enc_data_destroy(&data);
}

/* The last candidate is the best map with its extreme heights drawn in, so that the march's steps cover a smaller
 * range. It is chosen where it gains more than the best map. */
TEST_OF_NUMBERS(test_extremes_are_drawn_in) {
    for (int tall = 0; tall < 2; tall++) {
        enc_data *data = planted(more, tall ? towers : step, 0);
        enc_relief_choice choice;
        enc_relief_store store;
        int best = 0;
        assert_int_equal(enc_relief_choose(&two, data, &both, &choice, &store), BTF_OK);
        for (int k = 1; k < 5; k++) {
            best = choice.candidate[k].gain > choice.candidate[best].gain ? k : best;
        }
        const enc_relief_candidate *drawn = &choice.candidate[ENC_RELIEF_CANDIDATES - 1];
        printf("%s: the best map gains %.3f dB, drawn in %.3f; %.2f to %.2f, %u steps\n", tall ? "towers" : "step",
               choice.candidate[best].gain, drawn->gain, choice.least, choice.most, store.steps);
        assert_true(best > 0 && drawn->judged && drawn->drawn_in && drawn->scale == choice.candidate[best].scale);
        assert_int_equal(choice.chosen, drawn->gain > choice.candidate[best].gain ? ENC_RELIEF_CANDIDATES - 1 : best);
        /* the extremes are noise around the step's two heights, which may go, or the few towers, which stay */
        assert_int_equal(choice.chosen == ENC_RELIEF_CANDIDATES - 1, !tall);
        assert_true(tall ? choice.most > 2.5 : choice.least > -2.5 && choice.most < 0.5);
        enc_relief_clear(&store);
        enc_data_destroy(&data);
    }
}

TEST(test_one_height_has_no_map) {
    enc_data *data = planted(rings, sunk, 0);
    enc_relief_choice choice;
    enc_relief_store store;
    assert_int_equal(enc_relief_choose(&two, data, &both, &choice, &store), BTF_OK);
    printf("height %.3f, gain %.2f dB\n", choice.least, choice.candidate[choice.chosen].gain);
    assert_true(choice.chosen > 0 && choice.candidate[choice.chosen].constant);
    assert_true(!store.heights && store.step == 0 && store.steps == 1);
    assert_true(fabs(store.base / 256.0 - 1.25) < 0.3);
    enc_relief_clear(&store);
    enc_data_destroy(&data);
}

TEST_OF_NUMBERS(test_flat_and_noise_stay_flat) {
    static const float noises[] = {0, 0.1f};
    for (size_t i = 0; i < sizeof noises / sizeof *noises; i++) {
        enc_data *data = planted(rings, NULL, noises[i]);
        enc_relief_choice choice;
        enc_relief_store store;
        assert_int_equal(enc_relief_choose(&two, data, &both, &choice, &store), BTF_OK);
        printf("noise %.2f: heights leave %.3f, gloss %d\n", (double)noises[i], choice.share,
               choice.gloss.quarters);
        assert_int_equal(choice.chosen, 0);
        assert_int_equal(store.effects & BTF_EFFECT_RELIEF, 0);
        assert_null(store.heights);
        assert_non_null(choice.reason);
        enc_relief_clear(&store);
        enc_data_destroy(&data);
    }
}

TEST_OF_NUMBERS(test_threads_give_the_same) {
    enc_data *data = planted("0:1,30:6,60:8", step, 0.02f);
    enc_relief_choice a, b;
    enc_relief_store first, second;
    assert_int_equal(enc_relief_choose(&one, data, &both, &a, &first), BTF_OK);
    assert_int_equal(enc_relief_choose(&two, data, &both, &b, &second), BTF_OK);
    assert_int_equal(a.chosen, b.chosen);
    assert_true(a.share == b.share);
    assert_int_equal(!first.heights, !second.heights);
    if (first.heights) {
        assert_memory_equal(first.heights, second.heights, SIDE * SIDE);
    }
    enc_relief_clear(&first);
    enc_relief_clear(&second);
    enc_data_destroy(&data);
}

TEST(test_what_is_not_asked_for_is_not_there) {
    static const enc_relief_options none = {.relief = false, .gloss = 2};
    enc_data *data = planted("0:1,30:6", step, 0);
    enc_relief_choice choice;
    enc_relief_store store;
    assert_int_equal(enc_relief_choose(&one, data, &none, &choice, &store), BTF_OK);
    assert_false(choice.tried);
    assert_int_equal(store.effects, BTF_EFFECT_GLOSS);
    assert_int_equal(store.gloss_share, 2);
    enc_relief_clear(&store);
    enc_data_destroy(&data);
}

/* The lobe about the mirrored light moves with the half vector, so gloss is found; a Lambertian plane has no lobe, and
 * no gloss. */
TEST_OF_NUMBERS(test_gloss_is_found_where_there_is_a_lobe) {
    for (int shiny = 0; shiny < 2; shiny++) {
        enc_direction *at;
        enc_data *data;
        int n;
        enc_relief_choice choice;
        enc_relief_store store;
        static const enc_relief_options gloss = {.relief = false, .gloss = -1};
        assert_int_equal(directions_parse(NULL, "0:1,20:6,40:10,60:12", &at, &n), BTF_OK);
        assert_int_equal(enc_data_create(&one, 8, 8, n, at, n, at, &data), BTF_OK);
        for (size_t i = 0; i < enc_data_texel_count(data) * enc_data_texel_stride(data); i++) {
            const float *l = at[i % (size_t)n].xyz, *v = at[i / (3 * (size_t)n) % (size_t)n].xyz;
            const float mirrored = -l[0] * v[0] - l[1] * v[1] + l[2] * v[2];
            const float lobe = mirrored > 0 ? powf(mirrored, 12) : 0;
            data->samples[i] = l[2] * (0.2f + (shiny ? 0.6f * lobe : 0));
        }
        assert_int_equal(enc_relief_choose(&two, data, &gloss, &choice, &store), BTF_OK);
        printf("shiny %d: best share %.2f, chosen %d\n", shiny, choice.gloss.best, choice.gloss.quarters);
        assert_int_equal(choice.gloss.quarters > 0, shiny);
        enc_relief_clear(&store);
        enc_data_destroy(&data);
        free(at);
    }
}

/* The values at a node come from the spline through the views that show the same point. Where all views show a surface
 * alike, moved by whole texels, every node keeps its own samples. */
TEST(test_nodes_follow_the_surface) {
    enc_data *data = planted("0:1,45:4", raised, 0), *fitted = NULL, *plain = NULL;
    const int n = data->n_views, lights = data->n_lights;
    float *views = malloc((size_t)(n * n) * sizeof *views),
          *none = calloc((size_t)(lights * lights), sizeof *none);
    uint8_t act[64];
    enc_node_fit *fit = NULL;
    enc_warp w;
    assert_int_equal(enc_node_fit_create(&one, data->views, n, 1000, &fit), BTF_OK);
    assert_int_equal(enc_node_fit_weights(fit, 1, views), BTF_OK);
    for (int i = 0; i < lights; i++) {
        none[i * lights + i] = 1;
    }
    memset(act, 1, sizeof act);
    const enc_node_tables tables = {
        .n_views = n, .n_lights = lights, .views = views, .lights = none, .roots = true};
    const enc_node_relief relief = {&w, act};
    assert_int_equal(enc_warp_create(SIDE, SIDE, 0, ENC_WARP_ONE, &w), BTF_OK);
    assert_int_equal(enc_node_apply(&one, &tables, &relief, data, &fitted), BTF_OK);
    assert_int_equal(enc_node_apply(&one, &tables, NULL, data, &plain), BTF_OK);
    double moved = 0, stays = 0;
    const size_t count = enc_data_texel_count(data) * enc_data_texel_stride(data);
    for (size_t i = 0; i < count; i++) {
        const double m = (double)fitted->samples[i] - (double)data->samples[i];
        const double p = (double)plain->samples[i] - (double)data->samples[i];
        moved += m * m;
        stays += p * p;
    }
    printf("squared change: %.2e with the surface, %.2e without\n", moved / (double)count,
           stays / (double)count);
    assert_true(moved / (double)count < 1e-12 && stays / (double)count > 1e-5);
    enc_node_fit_destroy(&fit);
    enc_warp_clear(&w);
    enc_data_destroy(&plain);
    enc_data_destroy(&fitted);
    enc_data_destroy(&data);
    free(views);
    free(none);
}

TEST(test_levels_filter_heights) {
    uint8_t codes[25] = {0, 100, 0, 0, 200, 100, 0, 0, 0, 200};
    enc_relief_store store = {
        .width = 5, .height = 5, .heights = codes, .base = -100, .step = 256, .steps = 8};
    uint8_t *level = NULL;
    enc_warp w;
    assert_int_equal(enc_relief_level(&store, 5, 5, 0, &level, &w), BTF_OK);
    assert_memory_equal(level, codes, 25);
    enc_warp_clear(&w);
    free(level);
    assert_int_equal(enc_relief_level(&store, 2, 2, 1, &level, &w), BTF_OK);
    assert_int_equal(level[0], 32); /* (100 + 100) / 6.25 */
    assert_int_equal(level[1], 64); /* (200 + 200) / 6.25 */
    assert_int_equal(level[2], 0);
    assert_int_equal(w.heights[0], -100 + 32);
    enc_warp_clear(&w);
    free(level);
}

/* The encoder judges whether relief pays at each level until one does not gain, with the same result for any number of
 * threads. With a single level it judges none. */
TEST_OF_NUMBERS(test_where_relief_ends) {
    enc_data *data = planted(more, step, 0);
    enc_relief_choice a, b;
    enc_relief_store first, second;
    enc_relief_options options = {.relief = true, .gloss = 0, .levels = 4};
    assert_int_equal(enc_relief_choose(&two, data, &options, &a, &first), BTF_OK);
    options.levels = 0;
    assert_int_equal(enc_relief_choose(&two, data, &options, &b, &second), BTF_OK);
    for (int k = 0; k < a.end.judged; k++) {
        const enc_relief_judged_level *l = &a.end.level[k];
        printf("level %d: gain %.2f dB, linear %.5f -> %.5f, sRGB %.5f -> %.5f\n", k + 1, l->gain,
               l->plain.linear, l->moved.linear, l->plain.srgb, l->moved.srgb);
    }
    assert_int_equal(a.end.judged, 1); /* level 1 does not gain: the step is only a texel deep there */
    assert_false(a.end.level[0].on);
    assert_int_equal(a.end.end, 1);
    assert_int_equal(first.end, 1);
    assert_int_equal(b.end.judged, 0);
    assert_int_equal(second.end, 1);
    enc_relief_clear(&first);
    enc_relief_clear(&second);
    enc_data_destroy(&data);
}

/* The judge alone: a true surface keeps relief as long as it is deep in texels, a wrong one loses it at once, and views
 * on which relief does not act do not count. */
TEST(test_levels_are_judged) {
    enc_data *data = planted(rings, high, 0);
    uint8_t on[64], off[64] = {0};
    enc_seen *seen = malloc(sizeof *seen);
    enc_relief_end same, end;
    memset(on, 1, sizeof on);
    assert_int_equal(enc_seen_make(&one, data->views, data->n_views, 0, 90, seen), BTF_OK);
    enc_relief_store store = {
        .width = SIDE, .height = SIDE, .views = on, .base = 8 * ENC_WARP_ONE, .steps = 1};
    assert_int_equal(enc_relief_find_end(&one, data, seen, 5, &store, &end), BTF_OK);
    assert_int_equal(enc_relief_find_end(&two, data, seen, 5, &store, &same), BTF_OK);
    assert_int_equal(end.end, same.end);
    assert_int_equal(end.judged, same.judged);
    for (int i = 0; i < end.judged; i++) {
        const enc_relief_judged_level *a = &end.level[i], *b = &same.level[i];
        assert_memory_equal(&a->plain, &b->plain, sizeof a->plain);
        assert_memory_equal(&a->moved, &b->moved, sizeof a->moved);
        assert_true(a->gain == b->gain && a->on == b->on);
    }
    printf("eight texels high: level 1 gains %.2f dB, ends at %d\n", end.level[0].gain, end.end);
    assert_true(end.level[0].on && end.end > 1);
    store.base = -4 * ENC_WARP_ONE;
    assert_int_equal(enc_relief_find_end(&two, data, seen, 5, &store, &end), BTF_OK);
    printf("twelve texels too deep: level 1 gains %.2f dB\n", end.level[0].gain);
    assert_true(end.judged == 1 && end.end == 1 && end.level[0].gain < 0);
    store.base = 8 * ENC_WARP_ONE;
    store.views = off;
    assert_int_equal(enc_relief_find_end(&two, data, seen, 5, &store, &end), BTF_OK);
    assert_true(end.end == 1 && end.level[0].plain.linear == 0);
    free(seen);
    enc_data_destroy(&data);
}

RUN_TESTS(NULL, NULL)
