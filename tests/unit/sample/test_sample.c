/* The sample generator: axes, visibility and shadows against brute force, truth, determinism, files.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/sample/camera.h"
#include "tests/sample/directions.h"
#include "tests/sample/noise.h"
#include "tests/sample/pairs.h"
#include "tests/sample/sample.h"
#include "tests/sample/truth_files.h"
#include "tests/support/test.h"

#include <unistd.h>

static const double PI = 3.14159265358979323846;

static void unit_vector(double theta, double phi, double out[3]) {
    out[0] = sin(theta * PI / 180) * cos(phi * PI / 180);
    out[1] = sin(theta * PI / 180) * sin(phi * PI / 180);
    out[2] = cos(theta * PI / 180);
}

/* Repeatable numbers of [0, 1). */
static double number(int *state) {
    return noise_hash(4711, (*state)++, 0, 0);
}

/* The height of the bilinear surface, computed independently of the ray caster. */
static double surface_height(const relief *r, double x, double y) {
    int n = r->grid;
    double gx = (x - floor(x)) * n, gy = (y - floor(y)) * n;
    int i = (int)gx % n, j = (int)gy % n, i1 = (i + 1) % n, j1 = (j + 1) % n;
    double u = gx - floor(gx), w = gy - floor(gy);
    return (1 - w) * ((1 - u) * r->height[j * n + i] + u * r->height[j * n + i1]) +
           w * ((1 - u) * r->height[j1 * n + i] + u * r->height[j1 * n + i1]);
}

static void render(relief_kind kind, int size, int supersample, const char *views, const char *lights,
                   int threads, enc_data **out_data, sample_truth **out_truth) {
    enc_context context = {.threads = threads};
    sample_options o = {.context = &context,
                        .relief = kind,
                        .width = size,
                        .height = size,
                        .supersample = supersample,
                        .grid = 512};
    enc_direction *v = NULL, *l = NULL;
    assert_int_equal(directions_parse(NULL, views, &v, &o.n_views), BTF_OK);
    assert_int_equal(directions_parse(NULL, lights, &l, &o.n_lights), BTF_OK);
    o.views = v;
    o.lights = l;
    assert_int_equal(sample_render(&o, out_data, out_truth), BTF_OK);
    free(v);
    free(l);
}

static sample_scene *make_scene(relief_kind kind, const char *views, const char *lights) {
    sample_options o = {.relief = kind, .width = 64, .height = 64, .supersample = 1, .grid = 1024};
    enc_direction *v = NULL, *l = NULL;
    sample_scene *scene = NULL;
    assert_int_equal(directions_parse(NULL, views, &v, &o.n_views), BTF_OK);
    assert_int_equal(directions_parse(NULL, lights, &l, &o.n_lights), BTF_OK);
    o.views = v;
    o.lights = l;
    assert_int_equal(sample_scene_create(&o, &scene), BTF_OK);
    free(v);
    free(l);
    return scene;
}

static float sample_at(const enc_data *d, int column, int row, int view, int channel, int light) {
    size_t texel = (size_t)row * d->width + column;
    return d
        ->samples[texel * enc_data_texel_stride(d) + ((size_t)view * 3 + channel) * d->n_lights + light];
}

TEST(test_white_is_the_cosine) {
    enc_data *data = NULL;
    sample_truth *truth = NULL;
    render(RELIEF_WHITE, 6, 2, "small", "ubo", 1, &data, &truth);
    assert_int_equal(data->n_lights, 81);
    assert_int_equal(data->n_views, 19);
    for (int texel = 0; texel < 36; ++texel) {
        for (int v = 0; v < 19; ++v) {
            for (int c = 0; c < 3; ++c) {
                for (int l = 0; l < 81; ++l) {
                    assert_true(fabs(sample_at(data, texel % 6, texel / 6, v, c, l) -
                                     cos(data->lights[l].theta * PI / 180)) < 1e-6);
                }
            }
        }
    }
    enc_data_destroy(&data);
    sample_truth_destroy(&truth);
}

TEST(test_flat_has_no_shadow_and_no_shift) {
    enc_data *data = NULL;
    sample_truth *truth = NULL;
    render(RELIEF_FLAT, 8, 2, "small", "small", 1, &data, &truth);
    double least = 1e9, most = 0;
    for (size_t i = 0; i < (size_t)19 * 64; ++i) {
        assert_true(truth->shift[2 * i] == 0 && truth->shift[2 * i + 1] == 0);
        assert_true(truth->position[3 * i + 2] == 0);
        assert_int_equal(truth->hidden[i], 0);
    }
    for (size_t i = 0; i < (size_t)19 * 19 * 64; ++i) {
        assert_int_equal(truth->shadow[i], 0);
    }
    for (int texel = 0; texel < 64; ++texel) {
        double value = sample_at(data, texel % 8, texel / 8, 0, 0, 0);
        least = fmin(least, value);
        most = fmax(most, value);
    }
    assert_true(most > 1.3 * least); /* colour varies in space */
    enc_data_destroy(&data);
    sample_truth_destroy(&truth);
}

/* relief.h says what RELIEF_AXES shows; views and lights are 0: pole, 1..4: theta 45, phi 0, 90, 180, 270. */
TEST(test_axes) {
    enc_data *data = NULL;
    sample_truth *truth = NULL;
    render(RELIEF_AXES, 64, 2, "tiny", "tiny", 1, &data, &truth);
    const size_t texels = 64 * 64;
#define AT(x, y) ((size_t)(63 - (int)((y)*64)) * 64 + (size_t)((x)*64))
    /* Light from +x: dark at smaller columns. Light from +y: dark at larger rows, which is smaller y. */
    const double inside = (29.0 - 4) / 64, beyond = (35.0 + 4) / 64;
    assert_int_equal(truth->top_shadow[1 * texels + AT(inside, 0.5)], 1);
    assert_int_equal(truth->top_shadow[1 * texels + AT(beyond, 0.5)], 0);
    assert_int_equal(truth->top_shadow[2 * texels + AT(0.5, inside)], 1);
    assert_int_equal(truth->top_shadow[2 * texels + AT(0.5, beyond)], 0);
    assert_int_equal(truth->top_shadow[3 * texels + AT(inside, 0.5)], 0);
    assert_int_equal(truth->top_shadow[3 * texels + AT(beyond, 0.5)], 1);
    assert_int_equal(truth->top_shadow[4 * texels + AT(0.5, inside)], 0);
    assert_int_equal(truth->top_shadow[4 * texels + AT(0.5, beyond)], 1);
    assert_true(sample_at(data, 25, 31, 0, 1, 1) == 0.0f);
    assert_true(fabs(sample_at(data, 39, 31, 0, 1, 1) - 0.5 * sqrt(0.5)) < 1e-6);
    assert_true(sample_at(data, 31, 39, 0, 1, 2) == 0.0f);
    assert_true(fabs(sample_at(data, 31, 23, 0, 1, 2) - 0.5 * sqrt(0.5)) < 1e-6);
    /* The shadow is as long as the post is high: 8 texels, within half a texel. */
    int length = 0;
    for (int column = 0; column < 29; ++column) {
        length += truth->top_shadow[texels + 31 * 64 + (size_t)column];
    }
    assert_in_range(length, 7, 9);
    /* Ground by parallax: seen from +x its shift is -8 columns, from +y +8 rows; the top stays. */
    for (int view = 1; view <= 4; ++view) {
        static const int along_x[] = {0, -8, 0, 8, 0}, along_y[] = {0, 0, 8, 0, -8};
        size_t ground = (size_t)view * texels + AT(0.6, 0.1), top = (size_t)view * texels + AT(0.5, 0.5);
        assert_true(fabs(truth->shift[2 * ground] - along_x[view]) < 1e-4);
        assert_true(fabs(truth->shift[2 * ground + 1] - along_y[view]) < 1e-4);
        assert_true(fabs(truth->shift[2 * top]) < 1e-4 && fabs(truth->shift[2 * top + 1]) < 1e-4);
    }
    /* The red band, columns 60..63 from the top, is 8 columns further right seen from +x: wrapped, 4..7. */
    assert_true(sample_at(data, 61, 50, 0, 0, 0) > 3 * sample_at(data, 61, 50, 0, 1, 0));
    assert_true(sample_at(data, 5, 50, 1, 0, 0) > 3 * sample_at(data, 5, 50, 1, 1, 0));
    /* The green band, rows 0..3 from the top, is 8 rows further up seen from +y: wrapped, 56..59. */
    assert_true(sample_at(data, 40, 1, 0, 1, 0) > 3 * sample_at(data, 40, 1, 0, 0, 0));
    assert_true(sample_at(data, 40, 57, 2, 1, 0) > 3 * sample_at(data, 40, 57, 2, 0, 0));
    /* The wedge faces -y. */
    assert_true(sample_at(data, 16, 16, 0, 1, 4) > 1.3f * sample_at(data, 16, 16, 0, 1, 2));
#undef AT
    enc_data_destroy(&data);
    sample_truth_destroy(&truth);
}

TEST(test_visibility_against_marching) {
    static const relief_kind kinds[] = {RELIEF_BRICKS, RELIEF_BUMPS, RELIEF_WEAVE, RELIEF_AXES};
    int seed = 0;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k) {
        relief *r = NULL;
        assert_int_equal(relief_create(kinds[k], 3, 256, 1, &r), BTF_OK);
        assert_true(r->depth > 0.05 && r->depth < 0.15);
        for (int i = 0; i < 400; ++i) {
            double v[3], x = number(&seed), y = number(&seed);
            unit_vector(85 * number(&seed), 360 * number(&seed), v);
            raycast_hit hit = raycast_view(r, x, y, v);
            const double *p = hit.position;
            assert_true(p[2] <= 0 && p[2] >= -r->depth - 1e-12);
            assert_true(fabs(x + p[2] * v[0] / v[2] - p[0]) < 1e-12);
            assert_true(fabs(y + p[2] * v[1] / v[2] - p[1]) < 1e-12);
            assert_true(fabs(surface_height(r, p[0], p[1]) - p[2]) < 1e-9);
            double length = hit.normal[0] * hit.normal[0] + hit.normal[1] * hit.normal[1] +
                            hit.normal[2] * hit.normal[2];
            assert_true(fabs(length - 1) < 1e-12 && hit.normal[2] > 0);
            /* nothing lies in front of the point */
            const int steps = 1500;
            for (int s = 0; s < steps; ++s) {
                double z = p[2] * s / steps;
                assert_true(surface_height(r, x + z * v[0] / v[2], y + z * v[1] / v[2]) <= z + 1e-9);
            }
        }
        relief_destroy(&r);
    }
}

TEST(test_normals_are_slopes) {
    relief *r = NULL;
    int seed = 100000;
    assert_int_equal(relief_create(RELIEF_BUMPS, 0, 256, 1, &r), BTF_OK);
    for (int i = 0; i < 300; ++i) {
        double v[3], e = 1e-7;
        unit_vector(60 * number(&seed), 360 * number(&seed), v);
        raycast_hit hit = raycast_view(r, number(&seed), number(&seed), v);
        const double *p = hit.position, *n = hit.normal;
        double edge_x = fabs(p[0] * 256 - nearbyint(p[0] * 256)),
               edge_y = fabs(p[1] * 256 - nearbyint(p[1] * 256));
        if (edge_x < 1e-4 || edge_y < 1e-4) {
            continue; /* two patches meet there */
        }
        double dx = (surface_height(r, p[0] + e, p[1]) - surface_height(r, p[0] - e, p[1])) / (2 * e);
        double dy = (surface_height(r, p[0], p[1] + e) - surface_height(r, p[0], p[1] - e)) / (2 * e);
        assert_true(fabs(-n[0] / n[2] - dx) < 1e-4 && fabs(-n[1] / n[2] - dy) < 1e-4);
    }
    relief_destroy(&r);
}

/* Walks from the point to the light in quarter cells. */
static bool lit_by_marching(const relief *r, const double p[3], const double l[3]) {
    double flat = sqrt(l[0] * l[0] + l[1] * l[1]), step = 0.25 / r->grid;
    for (double s = 4 * step;; s += step) {
        double z = p[2] + s * l[2] / flat;
        if (z > 0) {
            return true;
        }
        if (surface_height(r, p[0] + s * l[0] / flat, p[1] + s * l[1] / flat) > z) {
            return false;
        }
    }
}

TEST(test_shadows_against_marching) {
    static const relief_kind kinds[] = {RELIEF_BRICKS, RELIEF_BUMPS, RELIEF_WEAVE};
    int seed = 200000;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k) {
        relief *r = NULL;
        assert_int_equal(relief_create(kinds[k], 0, 512, 1, &r), BTF_OK);
        int count = 0, wrong = 0, dark = 0;
        for (int i = 0; i < 24; ++i) {
            double l[3];
            raycast_shadow shadow;
            unit_vector(10 + 65 * number(&seed), 360 * number(&seed), l);
            assert_int_equal(raycast_shadow_create(r, l, &shadow), BTF_OK);
            for (int j = 0; j < 300; ++j) {
                double v[3];
                unit_vector(75 * number(&seed), 360 * number(&seed), v);
                raycast_hit hit = raycast_view(r, number(&seed), number(&seed), v);
                if (hit.normal[0] * l[0] + hit.normal[1] * l[1] + hit.normal[2] * l[2] <= 0) {
                    continue; /* faces away: unlit whatever the shadow says */
                }
                bool truly = lit_by_marching(r, hit.position, l);
                wrong += raycast_lit(&shadow, hit.position) != truly;
                dark += !truly;
                ++count;
            }
            raycast_shadow_destroy(&shadow);
        }
        print_message("  %s: %d of %d shadow rays differ from marching, %d dark\n",
                      relief_kind_name(kinds[k]), wrong, count, dark);
        assert_true(count > 3000 && dark > 100);
        assert_true(wrong < 0.06 * dark);
        relief_destroy(&r);
    }
}

TEST(test_periodic) {
    int seed = 300000;
    for (int kind = 0; kind < RELIEF_COUNT; ++kind) {
        relief *r = NULL;
        double l[3];
        raycast_shadow shadow;
        assert_int_equal(relief_create((relief_kind)kind, 7, 128, 1, &r), BTF_OK);
        unit_vector(60, 200, l);
        assert_int_equal(raycast_shadow_create(r, l, &shadow), BTF_OK);
        for (int i = 0; i < 300; ++i) {
            /* Binary fractions, so that moving by a tile rounds nothing away. */
            double x = (floor(number(&seed) * 4096) + 0.5) / 4096,
                   y = (floor(number(&seed) * 4096) + 0.5) / 4096;
            double v[3];
            unit_vector(70 * number(&seed), 360 * number(&seed), v);
            raycast_hit a = raycast_view(r, x, y, v), b = raycast_view(r, x + 1, y - 2, v);
            assert_true(fabs(a.position[2] - b.position[2]) < 1e-10);
            assert_true(fabs(a.position[0] + 1 - b.position[0]) < 1e-10);
            assert_true(fabs(a.position[1] - 2 - b.position[1]) < 1e-10);
            relief_material m, o;
            relief_material_at(r, x, y, &m);
            relief_material_at(r, x - 3, y + 1, &o);
            for (int c = 0; c < 3; ++c) {
                assert_true(fabs(m.albedo[c] - o.albedo[c]) < 1e-9);
                assert_true(m.albedo[c] > 0 && m.albedo[c] <= 1 && m.gloss[c] >= 0);
            }
            double p[3] = {x, y, -0.03}, q[3] = {x + 2, y - 1, -0.03};
            assert_int_equal(raycast_lit(&shadow, p), raycast_lit(&shadow, q));
        }
        raycast_shadow_destroy(&shadow);
        relief_destroy(&r);
    }
}

/* A texel of an image has the shading of its true position, and the view from the pole shows that position at texel +
 * shift. */
TEST(test_truth_agrees_with_the_images) {
    sample_scene *scene = make_scene(RELIEF_BRICKS, "0:1,40:5:20,70:7", "0:1,50:6:11");
    const sample_options *o = sample_scene_options(scene);
    const relief *r = sample_scene_relief(scene);
    sample_truth *truth = NULL;
    assert_int_equal(sample_truth_create(scene, &truth), BTF_OK);
    const size_t texels = 64 * 64;
    float *images = malloc(texels * 3 * (size_t)o->n_lights * sizeof *images);
    assert_non_null(images);
    double moved = 0;
    for (int view = 0; view < o->n_views; view += 3) {
        double v[3], pole[3] = {0, 0, 1};
        unit_vector(o->views[view].theta, o->views[view].phi, v);
        assert_int_equal(sample_scene_view(scene, view, images, truth), BTF_OK);
        for (int texel = 0; texel < 64 * 64; texel += 7) {
            size_t index = view * texels + (size_t)texel;
            int column = texel % 64, row = texel / 64;
            raycast_hit hit = raycast_view(r, (column + 0.5) / 64, 1 - (row + 0.5) / 64, v);
            for (int c = 0; c < 3; ++c) {
                assert_true(truth->position[3 * index + (size_t)c] == (float)hit.position[c]);
            }
            for (int light = 0; light < o->n_lights; ++light) {
                double rgb[3];
                bool lit = sample_shade(scene, &hit, v, light, rgb);
                assert_int_equal(truth->shadow[(view * o->n_lights + light) * texels + (size_t)texel],
                                 !lit);
                for (int c = 0; c < 3; ++c) {
                    assert_true(fabs(images[3 * (light * texels + (size_t)texel) + (size_t)c] - rgb[c]) <
                                1e-6);
                }
            }
            double top_x = (column + 0.5 + truth->shift[2 * index]) / 64;
            double top_y = 1 - (row + 0.5 + truth->shift[2 * index + 1]) / 64;
            raycast_hit top = raycast_view(r, top_x, top_y, pole);
            assert_true(fabs(top.position[0] - hit.position[0]) < 1e-6);
            assert_true(fabs(top.position[1] - hit.position[1]) < 1e-6);
            moved = fmax(moved, fabs(truth->shift[2 * index]) + fabs(truth->shift[2 * index + 1]));
        }
    }
    assert_true(moved > 10); /* the relief is deep enough to matter */
    assert_int_equal(sample_scene_view(scene, o->n_views, NULL, truth), BTF_OK);
    assert_memory_equal(truth->top_shadow, truth->shadow,
                        texels * (size_t)o->n_lights); /* view 0 is the pole */
    free(images);
    sample_truth_destroy(&truth);
    sample_scene_destroy(&scene);
}

/* Bricks have shadow on about a quarter of all samples, and ambient light in it; bumps have exact zeros.
 * (At 64x64 texels and the 81 directions: 23.1 % in shadow, and 12.6 % exactly 0.) */
TEST(test_share_of_shadow) {
    enc_data *data = NULL;
    sample_truth *truth = NULL;
    const size_t points = 48 * 48 * 19 * 19;
    render(RELIEF_BRICKS, 48, 2, "small", "small", 1, &data, &truth);
    size_t dark = 0, zero = 0;
    for (size_t i = 0; i < points; ++i) {
        dark += truth->shadow[i];
    }
    for (size_t i = 0; i < points * 3; ++i) {
        zero += data->samples[i] <= 0;
    }
    print_message("  bricks: %.1f %% in shadow\n", 100.0 * (double)dark / (double)points);
    assert_int_equal(zero, 0);
    assert_true((double)dark > 0.18 * (double)points && (double)dark < 0.28 * (double)points);
    enc_data_destroy(&data);
    sample_truth_destroy(&truth);
    render(RELIEF_BUMPS, 48, 2, "small", "small", 1, &data, &truth);
    for (size_t i = 0; i < points * 3; ++i) {
        zero += data->samples[i] == 0;
    }
    print_message("  bumps: %.1f %% exactly 0\n", 100.0 * (double)zero / (double)(3 * points));
    assert_true((double)zero > 0.04 * 3 * (double)points && (double)zero < 0.18 * 3 * (double)points);
    enc_data_destroy(&data);
    sample_truth_destroy(&truth);
}

TEST(test_threads_and_seeds) {
    enc_data *one = NULL, *two = NULL;
    sample_truth *truth_one = NULL, *truth_two = NULL;
    render(RELIEF_WEAVE, 20, 3, "small", "7", 1, &one, &truth_one);
    render(RELIEF_WEAVE, 20, 3, "small", "7", 2, &two, &truth_two);
    const size_t floats = 400 * enc_data_texel_stride(one);
    assert_memory_equal(one->samples, two->samples, floats * sizeof(float));
    assert_memory_equal(truth_one->position, truth_two->position, (size_t)400 * 19 * 3 * sizeof(float));
    assert_memory_equal(truth_one->shift, truth_two->shift, (size_t)400 * 19 * 2 * sizeof(float));
    assert_memory_equal(truth_one->shadow, truth_two->shadow, (size_t)400 * 19 * 7);
    enc_data_destroy(&two);
    sample_truth_destroy(&truth_one);
    sample_truth_destroy(&truth_two);
    sample_options o = {.relief = RELIEF_WEAVE,
                        .seed = 1,
                        .width = 20,
                        .height = 20,
                        .supersample = 3,
                        .grid = 512,
                        .views = one->views,
                        .n_views = one->n_views,
                        .lights = one->lights,
                        .n_lights = one->n_lights};
    assert_int_equal(sample_render(&o, &two, NULL), BTF_OK);
    assert_memory_not_equal(one->samples, two->samples, floats * sizeof(float));
    enc_data_destroy(&one);
    enc_data_destroy(&two);
}

TEST(test_non_square) {
    sample_options o = {.relief = RELIEF_AXES, .width = 32, .height = 128, .supersample = 1};
    enc_direction *list = NULL;
    sample_truth *truth = NULL;
    enc_data *data = NULL;
    assert_int_equal(directions_parse(NULL, "tiny", &list, &o.n_views), BTF_OK);
    o.views = o.lights = list;
    o.n_lights = o.n_views;
    assert_int_equal(sample_render(&o, &data, &truth), BTF_OK);
    /* An eighth of the tile is 4 columns and 16 rows. */
    size_t texels = 32 * 128, ground = (size_t)115 * 32 + 20;
    assert_true(fabs(truth->shift[2 * (texels + ground)] + 4) < 1e-4);
    assert_true(fabs(truth->shift[2 * (2 * texels + ground) + 1] - 16) < 1e-4);
    free(list);
    sample_truth_destroy(&truth);
    enc_data_destroy(&data);
}

TEST(test_directions) {
    static const struct {
        const char *text;
        int count;
    } good[] = {{"ubo", 81},  {"ubo2014", 151}, {"small", 19},       {"tiny", 5}, {"1", 1},
                {"256", 256}, {"0:1", 1},       {"0:1,45:7:3.5", 8}, {"30:3", 3}};
    static const char *const bad[] = {"",         "0",          "257",          "ubo2",   "0:1,",
                                      "0:1;30:6", "30:6,15:6",  "0:2",          "90:4",   "-5:3",
                                      "0:1,30:0", "0:1,30:300", "0:1,30:6:400", "30:6:x", "nan:3"};
    for (size_t i = 0; i < sizeof good / sizeof *good; ++i) {
        enc_direction *list = NULL;
        int count = 0;
        assert_int_equal(directions_parse(NULL, good[i].text, &list, &count), BTF_OK);
        assert_int_equal(count, good[i].count);
        for (int k = 1; k < count; ++k) {
            assert_true(list[k].theta > list[k - 1].theta ||
                        (list[k].theta == list[k - 1].theta && list[k].phi > list[k - 1].phi));
        }
        for (int k = 0; k < count; ++k) {
            double v[3];
            unit_vector(list[k].theta, list[k].phi, v);
            assert_true(list[k].phi >= 0 && list[k].phi < 360);
            for (int c = 0; c < 3; ++c) {
                assert_true(fabs(v[c] - list[k].xyz[c]) < 1e-6);
            }
        }
        free(list);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        enc_direction *list = NULL;
        int count = 0;
        assert_int_equal(directions_parse(NULL, bad[i], &list, &count), BTF_ERROR_USAGE);
    }
    char text[16];
    directions_format_angle(5, text);
    assert_string_equal(text, "005");
    directions_format_angle(359.99999, text);
    assert_string_equal(text, "360");
    directions_format_angle(23.5, text);
    assert_string_equal(text, "023.5000");
}

TEST(test_bad_options) {
    const sample_options bad[] = {{.relief = RELIEF_COUNT}, {.width = -1}, {.height = 9000},
                                  {.supersample = 5},       {.grid = 100}, {.grid = 8192}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        sample_scene *scene = NULL;
        assert_int_equal(sample_scene_create(&bad[i], &scene), BTF_ERROR_USAGE);
        assert_null(scene);
    }
    enc_direction low = enc_direction_from_angles(88, 0);
    sample_options o = {.views = &low, .n_views = 1, .grid = 64};
    sample_scene *scene = NULL;
    assert_int_equal(sample_scene_create(&o, &scene), BTF_ERROR_USAGE);
    assert_int_equal(relief_kind_from_name("bricks"), RELIEF_BRICKS);
    assert_int_equal(relief_kind_from_name("brick"), RELIEF_COUNT);
}

TEST(test_truth_files) {
    const char *temporary = getenv("TMPDIR");
    char folder[400], path[512];
    snprintf(folder, sizeof folder, "%s/btf-test-sample-XXXXXX", temporary ? temporary : P_tmpdir);
    assert_non_null(mkdtemp(folder));
    sample_options o = {.relief = RELIEF_BUMPS, .width = 9, .height = 5, .grid = 64};
    enc_direction *views = NULL, *lights = NULL;
    assert_int_equal(directions_parse(NULL, "tiny", &views, &o.n_views), BTF_OK);
    assert_int_equal(directions_parse(NULL, "3", &lights, &o.n_lights), BTF_OK);
    o.views = views;
    o.lights = lights;
    sample_scene *scene = NULL;
    sample_truth *truth = NULL;
    assert_int_equal(sample_scene_create(&o, &scene), BTF_OK);
    assert_int_equal(sample_truth_create(scene, &truth), BTF_OK);
    for (int view = 0; view <= 5; ++view) {
        assert_int_equal(sample_scene_view(scene, view, NULL, truth), BTF_OK);
    }
    assert_int_equal(truth_files_write(scene, truth, folder), BTF_OK);
    static const struct {
        const char *name, *dictionary;
        size_t bytes;
    } files[] = {
        {"position.npy", "f4', 'fortran_order': False, 'shape': (5, 5, 9, 3, ), }", 5 * 45 * 12},
        {"shift.npy", "f4', 'fortran_order': False, 'shape': (5, 5, 9, 2, ), }", 5 * 45 * 8},
        {"hidden.npy", "'|u1', 'fortran_order': False, 'shape': (5, 5, 9, ), }", 5 * 45},
        {"shadow.npy", "'|u1', 'fortran_order': False, 'shape': (5, 3, 5, 9, ), }", 15 * 45},
        {"top_shadow.npy", "'|u1', 'fortran_order': False, 'shape': (3, 5, 9, ), }", 3 * 45},
        {"views.npy", "f8', 'fortran_order': False, 'shape': (5, 2, ), }", 80},
        {"lights.npy", "f8', 'fortran_order': False, 'shape': (3, 2, ), }", 48},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        unsigned char bytes[8192] = {0};
        snprintf(path, sizeof path, "%s/%s", folder, files[i].name);
        FILE *file = fopen(path, "rb");
        assert_non_null(file);
        size_t size = fread(bytes, 1, sizeof bytes - 1, file);
        fclose(file);
        assert_memory_equal(bytes, "\x93NUMPY\x01\x00", 8);
        size_t header = 10 + bytes[8] + 256u * bytes[9];
        assert_int_equal(header % 64, 0);
        assert_int_equal(size, header + files[i].bytes);
        assert_int_equal(bytes[header - 1], '\n');
        assert_non_null(strstr((const char *)bytes + 10, files[i].dictionary));
        if (i == 0) {
            assert_memory_equal(bytes + header, truth->position, files[i].bytes);
        }
        unlink(path);
    }
    snprintf(path, sizeof path, "%s/README.txt", folder);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0); /* nothing else was left there */
    assert_int_equal(truth_files_write(scene, truth, folder), BTF_ERROR_IO);
    free(views);
    free(lights);
    sample_truth_destroy(&truth);
    sample_scene_destroy(&scene);
}

/* An image rendered for a single pair has the bits of the same image of a whole grid. */
TEST(test_a_pair_is_as_in_the_grid) {
    enum { FLOATS = 3 * 64 * 64 };
    static float images[5][FLOATS], image[FLOATS];
    sample_scene *scene = make_scene(RELIEF_BRICKS, "tiny", "tiny");
    const sample_options *o = sample_scene_options(scene);
    for (int view = 0; view < 5; view += 2) {
        assert_int_equal(sample_scene_view(scene, view, images[0], NULL), BTF_OK);
        for (int light = 0; light < 5; ++light) {
            assert_int_equal(sample_scene_pair(scene, &o->views[view], &o->lights[light], image), BTF_OK);
            assert_memory_equal(image, images[light], sizeof image);
        }
    }
    sample_scene_destroy(&scene);
}

/* A third of the solid angle up to 74 degrees lies within acos(1 - (1 - cos 74) / 3), and a quarter of all
 * azimuths in a quadrant; names and pairs agree. */
TEST(test_random_pairs) {
    enum { N = 6000 };
    sample_pair *pairs = NULL, *fewer = NULL, *others = NULL;
    assert_int_equal(pairs_random(NULL, N, 0, &pairs), BTF_OK);
    assert_int_equal(pairs_random(NULL, 10, 0, &fewer), BTF_OK);
    assert_int_equal(pairs_random(NULL, 10, 1, &others), BTF_OK);
    const double third = acos(1 - (1 - cos(74 * PI / 180)) / 3) * 180 / PI;
    int inner[2] = {0, 0}, quadrant[2] = {0, 0}, both = 0;
    for (int i = 0; i < N; ++i) {
        const enc_direction *d[2] = {&pairs[i].view, &pairs[i].light};
        for (int k = 0; k < 2; ++k) {
            assert_true(d[k]->theta >= 0 && d[k]->theta <= 74 && d[k]->phi >= 0 && d[k]->phi < 360);
            assert_true(fabs(d[k]->theta * 1e4 - nearbyint(d[k]->theta * 1e4)) < 1e-6);
            inner[k] += d[k]->theta < third;
            quadrant[k] += d[k]->phi >= 90 && d[k]->phi < 180;
        }
        both += pairs[i].view.theta < third && pairs[i].light.theta < third;
    }
    /* five standard deviations and a half of 6000 draws: 200 of a third, 180 of a quarter, 135 of a ninth */
    for (int k = 0; k < 2; ++k) {
        assert_true(abs(inner[k] - N / 3) < 200 && abs(quadrant[k] - N / 4) < 185);
    }
    assert_true(abs(both - N / 9) < 135);
    assert_memory_equal(fewer, pairs, 10 * sizeof *pairs);
    assert_true(memcmp(others, pairs, 10 * sizeof *pairs) != 0);
    char name[PAIRS_NAME], expected[PAIRS_NAME];
    pairs_name(&pairs[3], -1, name);
    snprintf(expected, sizeof expected, "tl%07.4f_pl%08.4f_tv%07.4f_pv%08.4f", pairs[3].light.theta,
             pairs[3].light.phi, pairs[3].view.theta, pairs[3].view.phi);
    assert_string_equal(name, expected);
    free(pairs);
    free(fewer);
    free(others);
}

TEST(test_an_orbit) {
    sample_pair *pairs = NULL;
    assert_int_equal(pairs_turn(NULL, PAIRS_ORBIT_VIEW, 8, 60, enc_direction_from_angles(20, -90), &pairs),
                     BTF_OK);
    for (int i = 0; i < 8; ++i) {
        assert_true(pairs[i].view.theta == 60 && pairs[i].view.phi == 45 * i &&
                    pairs[i].light.theta == 20 && pairs[i].light.phi == 270);
    }
    free(pairs);
}

/* Writes a list, reads it, and returns what came of it. */
static btf_result read_list(const char *text, sample_pair **pairs, int *count) {
    char path[] = "/tmp/btf-pairs-XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0 && write(file, text, strlen(text)) == (ssize_t)strlen(text));
    close(file);
    const btf_result result = pairs_read(NULL, path, pairs, count);
    remove(path);
    return result;
}

TEST(test_lists) {
    static const char *const wrong[] = {"",
                                        "# nothing\n",
                                        "1 2 3\n",
                                        "1 2 3 x\n",
                                        "1 2 3 4\n1 2 3 4\n",
                                        "1 2 86 4\n",
                                        "-1 2 3 4\n",
                                        "1 2 3 nan\n",
                                        "a b 1 2 3 4\n",
                                        "1 2 3 4\nfile,theta_v,phi_v,theta_l,phi_l\n"};
    sample_pair *pairs = NULL;
    int count = 0;
    assert_int_equal(read_list("file,theta_v,phi_v,theta_l,phi_l\na.exr,1,2,30,400\n\n5 -90\t0 77 # c\n",
                               &pairs, &count),
                     BTF_OK);
    assert_int_equal(count, 2);
    assert_true(pairs[0].view.theta == 1 && pairs[0].view.phi == 2 && pairs[0].light.theta == 30 &&
                pairs[0].light.phi == 40);
    assert_true(pairs[1].view.phi == 270 && pairs[1].light.theta == 0 && pairs[1].light.phi == 0);
    free(pairs);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        assert_int_equal(read_list(wrong[i], &pairs, &count), BTF_ERROR_BAD_FILE);
    }
    assert_int_equal(pairs_read(NULL, "/nowhere/list", &pairs, &count), BTF_ERROR_IO);
}

/* Mean, deviation and independence of the camera's noise, over 3 * 4096 values of each of two images. */
TEST(test_camera) {
    enum { COUNT = 3 * 4096 };
    static float images[2][COUNT], again[COUNT];
    const sample_camera camera = {.exposure = 2, .noise = 0.1, .seed = 7};
    double sum = 0, squares = 0, across = 0, along = 0;
    for (int k = 0; k < 2; ++k) {
        for (int i = 0; i < COUNT; ++i) {
            images[k][i] = 0.5f;
        }
        sample_camera_expose(&camera, 5 + k, COUNT, images[k]);
    }
    for (int i = 0; i < COUNT; ++i) {
        const double a = images[0][i] - 1, b = images[1][i] - 1;
        sum += a;
        squares += a * a;
        across += a * b;
        along += i > 0 ? a * (images[0][i - 1] - 1) : 0;
        again[i] = 0.5f;
    }
    const double error = 0.1 / sqrt(COUNT); /* of a mean; 4.5 of them is one in 10^5 */
    assert_true(fabs(sum / COUNT) < 4.5 * error);
    assert_true(fabs(sqrt(squares / COUNT) - 0.1) < 4.5 * error);
    assert_true(fabs(across / COUNT) < 4.5 * 0.1 * error && fabs(along / COUNT) < 4.5 * 0.1 * error);
    sample_camera_expose(&camera, 5, COUNT, again);
    assert_memory_equal(again, images[0], sizeof again);

    float values[] = {0.25f, 0, 3};
    const sample_camera none = {.exposure = 4};
    sample_camera_expose(&none, 0, 3, values);
    assert_true(values[0] == 1 && values[1] == 0 && values[2] == 12);
    int black = 0;
    memset(again, 0, sizeof again);
    sample_camera_expose(&camera, 0, COUNT, again);
    for (int i = 0; i < COUNT; ++i) {
        assert_true(again[i] >= 0);
        black += again[i] == 0;
    }
    assert_in_range(black, COUNT * 45 / 100, COUNT * 55 / 100);
}

RUN_TESTS(NULL, NULL)
