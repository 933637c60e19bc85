/* Optical flow and its vote on translated textures, layers and patches whose shifts are known.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/paper/flow.h"
#include "encoder/paper/flow_prior.h"
#include "tests/sample/sample.h"
#include "tests/support/test.h"

static const enc_context context = {.threads = 2};
static const enc_context one_thread = {.threads = 1};

enum { SIDE = 48, TEXELS = SIDE * SIDE, WAVES = 24 };

/* A periodic texture of waves down to 5 texels long, with values in 0.2 .. 1.8; each seed gives another. */
static void texture(int width, int height, unsigned seed, float *out) {
    uint32_t state = seed * 2654435761u + 12345u;
    double phase[WAVES], weight = 0;
    int fx[WAVES], fy[WAVES];
    for (int k = 0; k < WAVES; k++) {
        int part[3];
        for (int i = 0; i < 3; i++) {
            state = state * 1664525u + 1013904223u;
            part[i] = (int)(state >> 16);
        }
        fx[k] = part[0] % (width / 5 + 1);
        fy[k] = part[1] % (height / 5 + 1) - height / 10;
        phase[k] = part[2] * 1e-3;
        weight += 1;
    }
    for (int r = 0; r < height; r++) {
        for (int c = 0; c < width; c++) {
            double sum = 0;
            for (int k = 0; k < WAVES; k++) {
                sum += cos(6.283185307179586 * ((double)fx[k] * c / width + (double)fy[k] * r / height) +
                           phase[k]);
            }
            const double v = 1 + 3 * sum / weight;
            out[r * width + c] = (float)(v < 0.2 ? 0.2 : v > 1.8 ? 1.8 : v);
        }
    }
}

/* out(x) = in(x + shift) * scale. */
static void translate(int width, int height, const float *in, int columns, int rows, float scale,
                      float *out) {
    for (size_t t = 0; t < (size_t)width * (size_t)height; t++) {
        out[t] = scale * in[enc_occlusion_source(width, height, t, columns, rows)];
    }
}

/* Counts the texels whose flow rounds to (columns, rows). */
static int count_flow(const float *flow, int columns, int rows) {
    int n = 0;
    for (int t = 0; t < TEXELS; t++) {
        n += lrintf(flow[2 * t]) == columns && lrintf(flow[2 * t + 1]) == rows;
    }
    return n;
}

static int count_bytes(const uint8_t *bytes, size_t n) {
    int sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum += bytes[i] != 0;
    }
    return sum;
}

static float top[TEXELS], target[TEXELS], flow[2 * TEXELS];
static uint8_t hidden[TEXELS];

TEST(test_pair_recovers_translation) {
    static const int shifts[][2] = {{0, 0}, {3, -2}, {-4, 1}, {0, 5}};
    for (size_t i = 0; i < sizeof shifts / sizeof *shifts; i++) {
        texture(SIDE, SIDE, 7, top);
        translate(SIDE, SIDE, top, shifts[i][0], shifts[i][1], 1, target);
        assert_int_equal(enc_flow_pair(&context, SIDE, SIDE, target, top, NULL, flow, hidden), BTF_OK);
        /* everywhere, so at the borders too: the texture is periodic */
        assert_true(count_flow(flow, shifts[i][0], shifts[i][1]) >= TEXELS * 98 / 100);
        assert_true(count_bytes(hidden, TEXELS) <= TEXELS / 100);
    }
}

TEST(test_pair_ignores_brightness) {
    texture(SIDE, SIDE, 8, top);
    translate(SIDE, SIDE, top, 2, 2, 3.5f, target);
    assert_int_equal(enc_flow_pair(&context, SIDE, SIDE, target, top, NULL, flow, hidden), BTF_OK);
    assert_true(count_flow(flow, 2, 2) >= TEXELS * 98 / 100);
    assert_true(count_bytes(hidden, TEXELS) <= TEXELS / 100);
}

TEST(test_pair_hides_brightness_jump) {
    texture(SIDE, SIDE, 9, top);
    memcpy(target, top, sizeof target);
    for (int r = 10; r < 22; r++) {
        for (int c = 10; c < 22; c++) {
            target[r * SIDE + c] *= 4;
        }
    }
    assert_int_equal(enc_flow_pair(&context, SIDE, SIDE, target, top, NULL, flow, hidden), BTF_OK);
    int inside = 0;
    for (int r = 10; r < 22; r++) {
        for (int c = 10; c < 22; c++) {
            inside += hidden[r * SIDE + c];
        }
    }
    assert_true(inside >= 144 * 8 / 10);
    assert_true(count_bytes(hidden, TEXELS) - inside <= (TEXELS - 144) / 10);
    /* a tolerance above the jump finds nothing but the flow's own misses */
    const enc_flow_options tolerant = {.difference = 2, .miss = 50};
    assert_int_equal(enc_flow_pair(&context, SIDE, SIDE, target, top, &tolerant, flow, hidden), BTF_OK);
    assert_int_equal(count_bytes(hidden, TEXELS), 0);
}

/* The index of texel t after the tile is mirrored in columns (1), in rows (2), then transposed (4); `how` sums these
 * up. */
static size_t lying(int how, int width, int height, int t) {
    int c = t % width, r = t / width;
    c = how & 1 ? width - 1 - c : c;
    r = how & 2 ? height - 1 - r : r;
    return how & 4 ? (size_t)(c * height + r) : (size_t)(r * width + c);
}

/* Layers that move differently and differ in brightness. The flow cannot find their motion everywhere, but its answer
 * must be the same however the pair is mirrored or transposed. */
TEST(test_pair_lies_anyhow) {
    enum { WIDE = 32, HIGH = 24, N = WIDE * HIGH };
    static float image[2][N], laid[2][N], found[2 * N], laid_flow[2 * N];
    static uint8_t seen[N], laid_hidden[N];
    texture(WIDE, HIGH, 21, image[1]);
    texture(WIDE, HIGH, 22, flow);
    for (int t = 0; t < N; t++) {
        image[0][t] =
            (1 + 0.3f * flow[t]) *
            image[1][enc_occlusion_source(WIDE, HIGH, (size_t)t, t % WIDE < 14 ? 3 : -1, t / WIDE / 9)];
    }
    assert_int_equal(enc_flow_pair(&context, WIDE, HIGH, image[0], image[1], NULL, found, seen), BTF_OK);
    assert_true(count_bytes(seen, N) > N / 10);
    for (int how = 1; how < 8; how++) {
        for (int t = 0; t < N; t++) {
            for (int k = 0; k < 2; k++) {
                laid[k][lying(how, WIDE, HIGH, t)] = image[k][t];
            }
        }
        assert_int_equal(enc_flow_pair(&context, how & 4 ? HIGH : WIDE, how & 4 ? WIDE : HIGH, laid[0],
                                       laid[1], NULL, laid_flow, laid_hidden),
                         BTF_OK);
        int same = 0;
        for (int t = 0; t < N; t++) {
            const size_t at = lying(how, WIDE, HIGH, t);
            const float x = laid_flow[2 * at + (how & 4 ? 1 : 0)],
                        y = laid_flow[2 * at + (how & 4 ? 0 : 1)];
            same += fabsf((how & 1 ? -x : x) - found[2 * t]) < 0.01f &&
                    fabsf((how & 2 ? -y : y) - found[2 * t + 1]) < 0.01f && laid_hidden[at] == seen[t];
        }
        if (same < N * 99 / 100) {
            print_error("lying %d: %d of %d texels the same\n", how, same, N);
        }
        assert_true(same >= N * 99 / 100);
    }
}

TEST(test_pair_without_texture) {
    for (int black = 0; black < 2; black++) {
        for (int t = 0; t < TEXELS; t++) {
            top[t] = 0.5f;
            target[t] = black ? 0.0f : 0.1f;
            flow[2 * t] = flow[2 * t + 1] = NAN;
        }
        memset(hidden, 7, sizeof hidden);
        assert_int_equal(enc_flow_pair(&context, SIDE, SIDE, target, top, NULL, flow, hidden), BTF_OK);
        assert_int_equal(count_flow(flow, 0, 0), TEXELS);
        assert_int_equal(count_bytes(hidden, TEXELS), 0);
    }
}

TEST(test_pair_of_any_size) {
    static const int sizes[][2] = {{1, 1}, {3, 5}, {1, 17}, {40, 2}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        const int width = sizes[i][0], height = sizes[i][1];
        texture(width, height, 3, top);
        texture(width, height, 4, target);
        assert_int_equal(enc_flow_pair(&context, width, height, target, top, NULL, flow, hidden), BTF_OK);
        for (int t = 0; t < 2 * width * height; t++) {
            assert_true(isfinite(flow[t]));
        }
    }
}

/* A BTF of top view and views at 30 degrees, azimuths 0, 90 and 135, under 9 lights, whose images are
 * textures, one a light, moved by shifts[view] (float positions are never needed). */
enum { VIEWS = 4, LIGHTS = 9 };
static enc_data *moved_views(const enc_context *with, int width, int height, const int (*shifts)[2]) {
    enc_direction views[VIEWS] = {enc_direction_from_angles(0, 0), enc_direction_from_angles(30, 0),
                                  enc_direction_from_angles(30, 90), enc_direction_from_angles(30, 135)};
    enc_direction lights[LIGHTS];
    for (int l = 0; l < LIGHTS; l++) {
        lights[l] = enc_direction_from_angles(l == 0 ? 0 : 45, l == 0 ? 0 : 45.0 * (l - 1));
    }
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(with, width, height, VIEWS, views, LIGHTS, lights, &data), BTF_OK);
    const size_t texels = enc_data_texel_count(data), stride = enc_data_texel_stride(data);
    float *image = malloc(texels * sizeof *image), *samples = malloc(texels * stride * sizeof *samples);
    assert_true(image && samples);
    for (int l = 0; l < LIGHTS; l++) {
        texture(width, height, (unsigned)(100 + l), image);
        for (int v = 0; v < VIEWS; v++) {
            for (size_t t = 0; t < texels; t++) {
                for (int c = 0; c < 3; c++) {
                    samples[t * stride + (size_t)((v * 3 + c) * LIGHTS + l)] =
                        image[enc_occlusion_source(width, height, t, shifts[v][0], shifts[v][1])] *
                        (float)(3 - c) / 4;
                }
            }
        }
    }
    assert_int_equal(enc_data_store_texels(with, data, 0, texels, samples), BTF_OK);
    free(image);
    free(samples);
    return data;
}

static int count_shift(const enc_occlusion *o, int view, int columns, int rows) {
    int n = 0;
    for (size_t t = 0; t < o->n_texels; t++) {
        const int8_t *shift = o->shift + 2 * ((size_t)view * o->n_texels + t);
        n += shift[0] == columns && shift[1] == rows;
    }
    return n;
}

/* Points below the plane shift against the azimuth; rows run down, y up. */
static const int along[VIEWS][2] = {{0, 0}, {-3, 0}, {0, 2}, {2, 2}};

TEST(test_vote_recovers_shifts) {
    /* the last shift lies a texel and a half off its view's epipolar line: the flow finds it, the estimate cannot */
    static const int astray[VIEWS][2] = {{0, 0}, {-2, 1}, {1, 2}, {3, 1}};
    for (int plain = 0; plain < 2; plain++) {
        for (int off = 0; off < 2; off++) {
            const int(*shifts)[2] = off ? astray : along;
            const enc_flow_options options = {.plain = plain};
            enc_data *data = moved_views(&context, SIDE, SIDE, shifts);
            enc_occlusion *o = NULL;
            assert_int_equal(enc_flow_vote(&context, data, &options, &o), BTF_OK);
            for (int v = 0; v < VIEWS; v++) {
                assert_true(count_shift(o, v, shifts[v][0], shifts[v][1]) >=
                            TEXELS * (off ? 95 : 99) / 100);
                assert_true(enc_occlusion_hidden_count(o, v) <= TEXELS / 100);
            }
            assert_int_equal(enc_occlusion_hidden_count(o, 0), 0);
            assert_int_equal(count_shift(o, 0, 0, 0), TEXELS);
            assert_memory_equal(o->hidden, o->hidden_voted, VIEWS * TEXELS);
            enc_occlusion_destroy(&o);
            enc_data_destroy(&data);
        }
    }
}

TEST(test_vote_hides_what_the_top_view_lacks) {
    static const int still[VIEWS][2] = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    enc_data *data = moved_views(&context, SIDE, SIDE, still);
    for (int r = 20; r < 32; r++) {
        for (int c = 20; c < 32; c++) {
            for (int k = 0; k < 3 * LIGHTS; k++) { /* view 2 */
                data->samples[((size_t)(r * SIDE + c) * VIEWS + 2) * 3 * LIGHTS + (size_t)k] = 0.1f;
            }
        }
    }
    enc_occlusion *o = NULL;
    assert_int_equal(enc_flow_vote(&context, data, NULL, &o), BTF_OK);
    size_t inside = 0;
    for (int r = 20; r < 32; r++) {
        for (int c = 20; c < 32; c++) {
            inside += o->hidden[2 * TEXELS + r * SIDE + c];
        }
    }
    assert_true(inside >= 144 * 8 / 10);
    assert_true(enc_occlusion_hidden_count(o, 2) - inside <= TEXELS / 10);
    assert_true(enc_occlusion_hidden_count(o, 1) <= TEXELS / 100);
    for (size_t i = 0; i < (size_t)VIEWS * TEXELS; i++) {
        assert_true(o->ratio[i] >= 0 && o->ratio[i] <= 1);
        assert_int_equal(o->hidden[i], o->ratio[i] > 0.7f);
    }
    enc_occlusion_destroy(&o);
    /* a light in three: ratios are thirds */
    const enc_flow_options few = {.lights = 3};
    assert_int_equal(enc_flow_vote(&context, data, &few, &o), BTF_OK);
    for (size_t i = 0; i < (size_t)VIEWS * TEXELS; i++) {
        assert_true(fabsf(3 * o->ratio[i] - rintf(3 * o->ratio[i])) < 1e-6f);
    }
    enc_occlusion_destroy(&o);
    enc_data_destroy(&data);
}

TEST(test_vote_of_a_constant) {
    static const int still[VIEWS][2] = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    for (int value = 0; value < 2; value++) {
        enc_data *data = moved_views(&context, 16, 16, still);
        for (size_t i = 0; i < 256 * enc_data_texel_stride(data); i++) {
            data->samples[i] = 0.25f * (float)value;
        }
        enc_occlusion *o = NULL;
        assert_int_equal(enc_flow_vote(&context, data, NULL, &o), BTF_OK);
        assert_int_equal(enc_occlusion_hidden_count(o, -1), 0);
        for (int v = 0; v < VIEWS; v++) {
            assert_int_equal(count_shift(o, v, 0, 0), 256);
        }
        enc_occlusion_destroy(&o);
        enc_data_destroy(&data);
    }
}

TEST(test_vote_of_any_size_and_thread) {
    static const int sizes[][2] = {{1, 1}, {3, 5}, {21, 9}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        const size_t texels = (size_t)(sizes[i][0] * sizes[i][1]);
        /* the second time from a scratch file */
        const enc_context tight = {.threads = 2, .memory = 1};
        const enc_context *contexts[2] = {&one_thread, &tight};
        enc_occlusion *o[2] = {NULL, NULL};
        for (int k = 0; k < 2; k++) {
            enc_data *data = moved_views(contexts[k], sizes[i][0], sizes[i][1], along);
            assert_int_equal(enc_flow_vote(contexts[k], data, NULL, &o[k]), BTF_OK);
            enc_data_destroy(&data);
        }
        assert_memory_equal(o[0]->shift, o[1]->shift, 2 * VIEWS * texels);
        assert_memory_equal(o[0]->hidden, o[1]->hidden, VIEWS * texels);
        assert_memory_equal(o[0]->ratio, o[1]->ratio, VIEWS * texels * sizeof(float));
        enc_occlusion_destroy(&o[0]);
        enc_occlusion_destroy(&o[1]);
    }
}

/* Two layers: a strip that lies deeper, seen from azimuth 0. */
TEST(test_prior_separates_layers) {
    static float images[2][LIGHTS * TEXELS * 3];
    static float forward[2 * TEXELS], backward[2 * TEXELS];
    int chosen[LIGHTS];
    float *image = malloc(TEXELS * sizeof *image);
    assert_non_null(image);
    for (int l = 0; l < LIGHTS; l++) {
        chosen[l] = l;
        texture(SIDE, SIDE, (unsigned)(200 + l), image);
        for (size_t t = 0; t < TEXELS; t++) {
            const int row = (int)(t / SIDE);
            const size_t source = enc_occlusion_source(SIDE, SIDE, t, row >= 16 && row < 32 ? -5 : 0, 0);
            for (size_t c = 0; c < 3; c++) {
                images[0][((size_t)l * TEXELS + t) * 3 + c] = image[t];
                images[1][((size_t)l * TEXELS + t) * 3 + c] = image[source];
            }
        }
    }
    free(image);
    enc_flow_planes above, aside;
    assert_int_equal(enc_flow_planes_create(SIDE, SIDE, images[0], LIGHTS, chosen, &above), BTF_OK);
    assert_int_equal(enc_flow_planes_create(SIDE, SIDE, images[1], LIGHTS, chosen, &aside), BTF_OK);
    const enc_direction view = enc_direction_from_angles(45, 0);
    assert_int_equal(enc_flow_prior(&aside, &above, &view, 0.15f, 0.03f, forward, backward), BTF_OK);
    int right = 0, back = 0;
    for (int t = 0; t < TEXELS; t++) {
        const int row = t / SIDE, shift = row >= 16 && row < 32 ? -5 : 0;
        right += fabsf(forward[2 * t] - (float)shift) < 0.5f;
        back += fabsf(backward[2 * t] + (float)shift) < 0.5f;
        assert_true(forward[2 * t + 1] == 0);
    }
    assert_true(right >= TEXELS * 98 / 100);
    assert_true(back >= TEXELS * 98 / 100);
    enc_flow_planes_clear(&above);
    enc_flow_planes_clear(&aside);
}

TEST(test_error_report) {
    static const int still[VIEWS][2] = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    enc_data *data = moved_views(&context, 8, 8, still);
    enc_occlusion *o = NULL;
    assert_int_equal(enc_occlusion_create(VIEWS, 64, &o), BTF_OK);
    float *truth = calloc(VIEWS * 64 * 2, sizeof *truth);
    uint8_t *exclude = calloc(VIEWS * 64, 1);
    assert_true(truth && exclude);
    /* ring 30: one point moved by 3 and found to 1 texel, one moved by -3 (5 wrapped) and found exactly,
       one wrong but excluded */
    truth[2 * 64] = 3;
    o->shift[2 * 64] = 2;
    o->hidden_voted[64] = 1;
    truth[2 * 65 + 1] = -3;
    o->shift[2 * 65 + 1] = 5;
    truth[2 * 66] = 4;
    exclude[66] = 1;
    enc_flow_ring rings[2];
    assert_int_equal(enc_flow_error(data, o, truth, exclude, 2, rings, 1), 2);
    assert_int_equal(enc_flow_error(data, o, truth, exclude, 2, rings, 2), 2);
    assert_true(rings[0].theta == 0 && rings[0].points == 64 && rings[0].moved == 0);
    assert_true(rings[0].error == 0 && rings[0].moved_error == 0);
    assert_int_equal(rings[1].points, 3 * 64 - 1);
    assert_int_equal(rings[1].moved, 2);
    assert_int_equal(rings[1].moved_hidden, 1);
    assert_true(fabs(rings[1].moved_error - 0.5) < 1e-12 && fabs(rings[1].moved_zero - 3) < 1e-12);
    assert_true(fabs(rings[1].error * 191 - 1) < 1e-9 && fabs(rings[1].zero * 191 - 6) < 1e-9);
    free(truth);
    free(exclude);
    enc_occlusion_destroy(&o);
    enc_data_destroy(&data);
}

/* The sample bricks: plain mortar between bricks that hardly move. Goal: 2.0 texels at 30 degrees over the
 * points that moved more than 2 texels. */
TEST(test_sample_bricks) {
    enum { BRICK_VIEWS = 9, BRICK_LIGHTS = 13 };
    enc_direction views[BRICK_VIEWS], lights[BRICK_LIGHTS];
    for (int v = 0; v < BRICK_VIEWS; v++) {
        views[v] = v == 0  ? enc_direction_from_angles(0, 0)
                   : v < 7 ? enc_direction_from_angles(30, 60.0 * (v - 1))
                           : enc_direction_from_angles(60, 130.0 * (v - 7));
    }
    for (int l = 0; l < BRICK_LIGHTS; l++) {
        lights[l] = enc_direction_from_angles(l == 0  ? 0
                                              : l < 7 ? 30
                                                      : 60,
                                              l == 0 ? 0 : 60.0 * ((l - 1) % 6));
    }
    const sample_options options = {.context = &context,
                                    .relief = RELIEF_BRICKS,
                                    .supersample = 1,
                                    .views = views,
                                    .n_views = BRICK_VIEWS,
                                    .lights = lights,
                                    .n_lights = BRICK_LIGHTS};
    enc_data *data = NULL;
    sample_truth *truth = NULL;
    enc_occlusion *o = NULL;
    assert_int_equal(sample_render(&options, &data, &truth), BTF_OK);
    assert_int_equal(enc_flow_vote(&context, data, NULL, &o), BTF_OK);
    enc_flow_ring rings[3];
    assert_int_equal(enc_flow_error(data, o, truth->shift, truth->hidden, 2, rings, 3), 3);
    for (int i = 0; i < 3; i++) {
        printf("ring %g: error %.2f, no motion %.2f; of %zu points that moved > 2 texels %.2f, no motion "
               "%.2f\n",
               rings[i].theta, rings[i].error, rings[i].zero, rings[i].moved, rings[i].moved_error,
               rings[i].moved_zero);
    }
    assert_true(rings[1].moved > 1000);
    assert_true(rings[1].moved_error <= 2.0);
    assert_true(rings[1].error < rings[1].zero);
    assert_true(rings[2].moved_error < 0.6 * rings[2].moved_zero);
    enc_occlusion_destroy(&o);
    sample_truth_destroy(&truth);
    enc_data_destroy(&data);
}

static void keep_message(void *user, btf_log_level level, const char *message) {
    (void)level;
    strncpy(user, message, 199);
}

TEST(test_options_are_checked) {
    char message[200] = "";
    const enc_context telling = {.threads = 1, .log = {keep_message, message}};
    const enc_flow_options wrong[] = {{.hidden_threshold = 1.5f},
                                      {.hidden_threshold = NAN},
                                      {.padding = 3},
                                      {.miss = -1},
                                      {.difference = NAN},
                                      {.lights = -2},
                                      {.depth = -1},
                                      {.rise = 1000}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        message[0] = 0;
        assert_int_equal(enc_flow_pair(&telling, SIDE, SIDE, target, top, &wrong[i], flow, hidden),
                         BTF_ERROR_USAGE);
        assert_non_null(strstr(message, "flow: "));
    }
    assert_int_equal(enc_flow_pair(&telling, SIDE, SIDE, target, top, &wrong[2], flow, hidden),
                     BTF_ERROR_USAGE);
    assert_non_null(strstr(message, "padding 3"));
}

TEST(test_shift_arithmetic) {
    for (int size = 1; size <= 256; size++) {
        for (int delta = -600; delta <= 600; delta++) {
            const int w = enc_occlusion_wrap(delta, size);
            assert_true(w >= -128 && w <= 127 && 2 * abs(w) <= size);
            assert_int_equal(enc_occlusion_modulo(w, size), enc_occlusion_modulo(delta, size));
        }
    }
    assert_int_equal(enc_occlusion_source(5, 3, 0, -1, -1), 2 * 5 + 4);
    assert_int_equal(enc_occlusion_source(5, 3, 14, 1, 1), 0);
    assert_int_equal(enc_occlusion_source(5, 3, 7, -128, 127),
                     (size_t)(((1 + 127) % 3) * 5 + (2 - 128 + 130) % 5));
    const int8_t order[][2] = {{0, 0}, {0, -1}, {-1, 0}, {1, 0}, {0, 1}, {-1, -1}, {1, -1}, {2, 0}};
    for (int i = 0; i < 8; i++) {
        for (int j = 0; j < 8; j++) {
            assert_int_equal(enc_occlusion_compare_shift(order[i], order[j]), (i > j) - (i < j));
        }
    }
}

RUN_TESTS(NULL, NULL)
