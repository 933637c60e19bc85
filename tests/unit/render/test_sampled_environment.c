/* A map that is sampled (decoder/tools/render/sampled_environment.h) lights as a light for each of its pixels does.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/tools/render/render.h"
#include "tests/support/test.h"

#include <openbtf/material.h>

enum { WIDTH = 32, HEIGHT = 16, SIDE = 4, SIZE = 24, PIXELS = SIZE * SIZE };

static btf_material *material;

typedef struct sky {
    int width, height, parts; /* lights along each side of a pixel */
    const float *pixels;
} sky;

static float map[HEIGHT][WIDTH][3];
static const sky fine = {WIDTH, HEIGHT, 2, map[0][0]};

static void fill_map(void) {
    /* A sky that brightens to one side, black below, with a small sun. */
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            for (int c = 0; c < 3; c++) {
                map[y][x][c] = y > 11 ? 0 : (float)(x + 4 * c) / 32 + (y == 5 && x == 22 ? 60.0f : 0);
            }
        }
    }
    map[3][3][1] = -1; /* counts as 0 */
}

/* Rings of so many directions each; returns how many in all. */
static uint32_t make_rings(const int rings[][2], int count, float (*out)[3]) {
    uint32_t n = 0;
    for (int r = 0; r < count; r++) {
        for (int i = 0; i < rings[r][1]; i++) {
            vec_store(vec_from_angles(rings[r][0], 360.0 * i / rings[r][1]), out[n++]);
        }
    }
    return n;
}

/* Glossy, texels of unlike brightness. */
static int make(void **state) {
    static const int view_rings[][2] = {{0, 1}, {40, 6}, {70, 12}},
                     light_rings[][2] = {{0, 1}, {20, 6}, {40, 12}, {60, 18}, {75, 24}};
    static const float scales[4] = {0x1p-13f};
    static float views[19][3], lights[61][3];
    static int8_t texels[SIDE * SIDE][4], directions[3][19][61][4];
    (void)state;
    fill_map();
    make_rings(view_rings, 3, views);
    make_rings(light_rings, 5, lights);
    for (int i = 0; i < SIDE * SIDE; i++) {
        texels[i][0] = (int8_t)(40 + 5 * i);
    }
    for (int v = 0; v < 19; v++) {
        for (int l = 0; l < 61; l++) {
            const vec3 half = vec_unit(vec_add(vec_from(views[v]), vec_from(lights[l])), vec(0, 0, 1));
            for (int c = 0; c < 3; c++) {
                directions[c][v][l][0] =
                    (int8_t)(127 * (double)lights[l][2] * (0.1 + 0.05 * c + 0.8 * pow(half.z, 20)));
            }
        }
    }
    btf_material_desc desc = {
        .struct_size = sizeof desc,
        .info = {.struct_size = sizeof desc.info,
                 .width = SIDE,
                 .height = SIDE,
                 .n_views = 19,
                 .n_lights = 61,
                 .layout = BTF_LAYOUT_TIGHT,
                 .domain = BTF_DOMAIN_LINEAR,
                 .colour = BTF_COLOUR_NONE,
                 .effects = BTF_EFFECT_RESIDUAL,
                 .components = 1,
                 .radiance_scale = 1,
                 .shadow_scale = 1,
                 .gain_scale = BTF_GAIN_SCALE,
                 .centre_scale = 1},
        .views = views[0],
        .lights = lights[0],
    };
    desc.texture[BTF_TEXTURE_RESIDUAL_TEXELS] = texels;
    desc.texture[BTF_TEXTURE_RESIDUAL_DIRECTIONS] = directions;
    desc.texture[BTF_TEXTURE_RESIDUAL_SCALES] = scales;
    return btf_material_create(&desc, NULL, &material) != BTF_OK;
}

static int clear(void **state) {
    (void)state;
    btf_material_close(&material);
    return 0;
}

/* A light for each part of each pixel, turned about z. */
static light_list all_lights(const sky *of, double rotate, double gain, double turn) {
    light_list list = {calloc((size_t)(of->width * of->height * of->parts * of->parts), sizeof(light)), 0};
    const int rows = of->height * of->parts, columns = of->width * of->parts;
    assert_non_null(list.lights);
    for (int i = 0; i < rows * columns; i++) {
        const int y = i / columns, x = i % columns;
        const double top = cos(RENDER_PI * y / rows), bottom = cos(RENDER_PI * (y + 1) / rows),
                     up = (top + bottom) / 2, level = sqrt(1 - up * up),
                     longitude = (2 * (x + 0.5) / columns - 1 + rotate / 180) * RENDER_PI,
                     c = cos(turn * RENDER_PI / 180), s = sin(turn * RENDER_PI / 180);
        const vec3 d = vec(level * sin(longitude), up, -level * cos(longitude));
        light l = {.at = vec(c * d.x - s * d.y, s * d.x + c * d.y, d.z)};
        for (int k = 0; k < 3; k++) {
            l.colour[k] = fmax((double)of->pixels[3 * (y / of->parts * of->width + x / of->parts) + k], 0) *
                          gain * (top - bottom) * (2 * RENDER_PI / columns) / RENDER_PI;
        }
        if (l.colour[0] > 0 || l.colour[1] > 0 || l.colour[2] > 0) {
            list.lights[list.count++] = l;
        }
    }
    return list;
}

static picture render(render_scene *scene, const light_list *lights,
                      const sampled_environment *environment) {
    const shader_request request = {.device = "reference",
                                    .material = material,
                                    .variants = 1,
                                    .effects = {BTF_EFFECT_ALL},
                                    .fold = SHADER_FOLD_NEVER,
                                    .threads = scene->table.threads};
    picture out;
    shader *s;
    render_times times = {0};
    scene->lights = lights;
    scene->environment = environment;
    assert_int_equal(shader_create(&request, NULL, &s), BTF_OK);
    const evaluator by = evaluator_of_shader(s, 0);
    assert_int_equal(render_frame(scene, &by, 1, &out, NULL, &times, NULL), BTF_OK);
    shader_destroy(&s);
    return out;
}

/* Each pixel has its own random numbers, so that the differences to the truth are independent and have a mean of 0. */
static void compare(const picture *estimate, const picture *truth, const char *name, int directions) {
    for (int c = 0; c < 3; c++) {
        double sum = 0, squares = 0, all = 0;
        for (int i = 0; i < PIXELS; i++) {
            const double d = (double)estimate->rgb[3 * i + c] - (double)truth->rgb[3 * i + c];
            sum += d;
            squares += d * d;
            all += (double)truth->rgb[3 * i + c];
        }
        const double mean = sum / PIXELS, sigma = sqrt((squares / PIXELS - mean * mean) / PIXELS);
        if (!(fabs(mean) <= 3 * sigma) || (directions > 2 && !(sigma < 0.01 * all / PIXELS))) {
            fail_msg("%s, channel %d: off by %g, sigma %g, of %g", name, c, mean, sigma, all / PIXELS);
        }
    }
}

static void check(const sky *of, const char *mesh_name, bool shadows, double rotate, double gain,
                  double turn) {
    static const int counts[] = {1, 2, 64};
    const light_list none = {0};
    light_list lights = all_lights(of, rotate, gain, turn);
    mesh *m;
    assert_int_equal(mesh_make(mesh_name, NULL, &m), BTF_OK);
    bvh *b = bvh_create(m);
    assert_non_null(b);
    render_scene scene = {.table = {.mesh = m,
                                    .bvh = b,
                                    .camera = {40, 100, 30, 1},
                                    .repeat = {2, 2},
                                    .texels = {SIDE, SIDE},
                                    .levels = 1,
                                    .cast_shadows = shadows,
                                    .threads = 1},
                          .width = SIZE,
                          .height = SIZE,
                          .samples = 1};
    picture truth = render(&scene, &lights, NULL);
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        sampled_environment *e;
        assert_int_equal(sampled_environment_create(of->width, of->height, of->pixels, rotate, gain,
                                                    material, counts[i], NULL, &e),
                         BTF_OK);
        assert_int_equal(sampled_environment_count(e), counts[i]);
        sampled_environment_turn(e, turn);
        picture estimate = render(&scene, &none, e), again;
        compare(&estimate, &truth, mesh_name, counts[i]);
        scene.table.threads = 2;
        again = render(&scene, &none, e);
        scene.table.threads = 1;
        assert_memory_equal(estimate.rgb, again.rgb, PIXELS * 3 * sizeof(float));
        picture_clear(&estimate);
        picture_clear(&again);
        sampled_environment_destroy(&e);
        assert_null(e);
    }
    picture_clear(&truth);
    bvh_destroy(&b);
    mesh_destroy(&m);
    free(lights.lights);
}

TEST(test_plane) {
    check(&fine, "plane", false, 0, 1, 0);
}

TEST(test_turned) {
    check(&fine, "plane", false, 130, 0.5, 40);
}

TEST(test_shadows) {
    check(&fine, "torus", true, -30, 2, 0);
}

/* Within a pixel, too, directions are spread evenly over the solid angle. */
TEST(test_coarse) {
    static const float pixels[1][6][3] = {
        {{1, 0, 2}, {0, 3, 1}, {9, 1, 1}, {2, 2, 0}, {0, 0, 3}, {4, 0, 0}}};
    const sky coarse = {6, 1, 18, pixels[0][0]};
    check(&coarse, "plane", false, 135, 1, 0);
}

/* A direction depends on the sample's place in the picture, not on how many rows are rendered at a time. */
TEST(test_rows) {
    enum { ROWS = 4, ALL = ROWS * SIZE };
    table_sample samples[ALL];
    float inputs[2][ALL][TABLE_INPUTS], weights[2][ALL][3];
    const table_scene scene = {.width = SIZE, .height = ROWS, .threads = 1};
    sampled_environment *e;
    for (int i = 0; i < ALL; i++) {
        samples[i] = (table_sample){.uv = {0.5f, 0.5f},
                                    .view = {0.6f, 0, 0.8f},
                                    .tangent = {1, 0, 0},
                                    .bitangent = {0, 1, 0},
                                    .normal = {0, 0, 1}};
    }
    assert_int_equal(sampled_environment_create(WIDTH, HEIGHT, map[0][0], 0, 1, material, 8, NULL, &e),
                     BTF_OK);
    for (int index = 0; index < 8; index++) {
        sampled_environment_light(e, &scene, index, 0, ROWS, samples, inputs[0][0], weights[0][0]);
        for (int row = 0; row < ROWS; row++) {
            sampled_environment_light(e, &scene, index, row, 1, samples, inputs[1][row * SIZE],
                                      weights[1][row * SIZE]);
        }
        assert_memory_equal(inputs[0], inputs[1], sizeof inputs[0]);
        assert_memory_equal(weights[0], weights[1], sizeof weights[0]);
        assert_memory_not_equal(inputs[0][0], inputs[0][SIZE], sizeof inputs[0][0]);
    }
    sampled_environment_destroy(&e);
}

/* A black map gives a black picture; pixels of a map that are NaN count as black. */
TEST(test_black) {
    static float black[2][4][3];
    black[1][1][0] = NAN;
    black[0][2][1] = INFINITY;
    const light_list none = {0};
    sampled_environment *e;
    mesh *m;
    assert_int_equal(mesh_make("sphere", NULL, &m), BTF_OK);
    bvh *b = bvh_create(m);
    render_scene scene = {.table = {.mesh = m,
                                    .bvh = b,
                                    .camera = {0, 0, 0, 1},
                                    .repeat = {1, 1},
                                    .texels = {SIDE, SIDE},
                                    .levels = 1,
                                    .threads = 1},
                          .width = SIZE,
                          .height = SIZE,
                          .samples = 1};
    assert_int_equal(sampled_environment_create(4, 2, black[0][0], 0, 1, material, 4, NULL, &e), BTF_OK);
    picture out = render(&scene, &none, e);
    for (int i = 0; i < 3 * PIXELS; i++) {
        assert_true(out.rgb[i] == 0);
    }
    picture_clear(&out);
    sampled_environment_destroy(&e);
    sampled_environment_destroy(NULL);
    bvh_destroy(&b);
    mesh_destroy(&m);
}

RUN_TESTS(make, clear)
