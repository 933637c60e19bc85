/* Meshes, rays, lights and the ray-cast table of btf-render against known truth.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/tools/render/environment.h"
#include "decoder/tools/render/light_option.h"
#include "decoder/tools/mesh/obj.h"
#include "decoder/tools/render/picture.h"
#include "decoder/tools/render/table.h"
#include "decoder/tools/mesh/tangents.h"
#include "tests/support/test.h"
#include "tests/support/uniform.h"

static const char *const names[] = {"plane", "sphere", "torus", "drape"};

static void close_to(double got, double expected, double tolerance) {
    if (!(fabs(got - expected) <= tolerance)) {
        fail_msg("%.9g, expected %.9g within %g", got, expected, tolerance);
    }
}

static mesh *make(const char *name) {
    mesh *m;
    assert_int_equal(mesh_make(name, NULL, &m), BTF_OK);
    return m;
}

/* Built-in meshes: frames are orthonormal, faces agree with normals, tangents point to growing u, positions are within
 * [-1, 1]. */
TEST(test_built_in) {
    for (size_t k = 0; k < 4; k++) {
        mesh *m = make(names[k]);
        assert_true(mesh_is_built_in(names[k]));
        for (uint32_t i = 0; i < m->vertex_count; i++) {
            const mesh_vertex *v = &m->vertices[i];
            vec3 n = vec_from(v->normal), t = vec_from(v->tangent);
            close_to(vec_length(n), 1, 1e-6);
            close_to(vec_length(t), 1, 1e-6);
            close_to(vec_dot(n, t), 0, 1e-5);
            for (int c = 0; c < 3; c++) {
                assert_true(fabsf(v->position[c]) <= 1);
            }
        }
        for (uint32_t f = 0; f < m->triangle_count; f++) {
            const mesh_vertex *a = &m->vertices[m->triangles[3 * f]],
                              *b = &m->vertices[m->triangles[3 * f + 1]],
                              *c = &m->vertices[m->triangles[3 * f + 2]];
            vec3 e1 = vec_sub(vec_from(b->position), vec_from(a->position));
            vec3 e2 = vec_sub(vec_from(c->position), vec_from(a->position));
            vec3 face = vec_cross(e1, e2);
            if (vec_length(face) > 1e-9) {
                assert_true(vec_dot(face, vec_from(a->normal)) > 0);
            }
            if (vec_length(face) > 1e-9 && b->uv[0] > a->uv[0] && b->uv[1] == a->uv[1]) {
                assert_true(vec_dot(e1, vec_from(a->tangent)) > 0);
            }
        }
        mesh_destroy(&m);
        assert_null(m);
    }
    assert_false(mesh_is_built_in("cube"));
    mesh *m;
    assert_int_equal(mesh_make("cube", NULL, &m), BTF_ERROR_USAGE);
    assert_null(m);
}

/* Frames computed from positions and uv alone agree with those of the formulas. */
TEST(test_computed_frames) {
    for (size_t k = 0; k < 4; k++) {
        mesh *truth = make(names[k]), *m = make(names[k]);
        mesh_compute_normals(m);
        assert_int_equal(mesh_compute_tangents(m), BTF_OK);
        double worst_n = 1, worst_t = 1;
        for (uint32_t i = 0; i < m->vertex_count; i++) {
            const mesh_vertex *a = &truth->vertices[i], *b = &m->vertices[i];
            if (k == 1 && fabsf(a->position[1]) > 0.95f) {
                continue; /* near the poles triangles degenerate */
            }
            worst_n = fmin(worst_n, vec_dot(vec_from(a->normal), vec_from(b->normal)));
            worst_t = fmin(worst_t, vec_dot(vec_from(a->tangent), vec_from(b->tangent)));
            assert_true(b->tangent[3] == 1);
        }
        assert_true(worst_n > 0.99);
        assert_true(worst_t > 0.99);
        mesh_destroy(&truth);
        mesh_destroy(&m);
    }
}

/* Mirrored uv makes a left-handed frame. */
TEST(test_handedness) {
    mesh *m = make("plane");
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        m->vertices[i].uv[0] = -m->vertices[i].uv[0];
    }
    assert_int_equal(mesh_compute_tangents(m), BTF_OK);
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        close_to((double)m->vertices[i].tangent[0], -1, 1e-6);
        close_to((double)m->vertices[i].tangent[3], -1, 0);
    }
    mesh_destroy(&m);
}

/* The bounding-volume hierarchy finds the same hits as a test of every triangle. */
TEST(test_rays) {
    mesh *m = make("torus");
    bvh *b = bvh_create(m);
    uint32_t seed = 7;
    int hits = 0;
    assert_non_null(b);
    for (int i = 0; i < 300; i++) {
        vec3 from = vec(4 * uniform(&seed) - 2, 4 * uniform(&seed) - 2, 3);
        vec3 to = vec(2 * uniform(&seed) - 1, 2 * uniform(&seed) - 1, 0);
        vec3 d = vec_unit(vec_sub(to, from), vec(0, 0, 1));
        bvh_hit hit, best = {INFINITY, 0, 0, UINT32_MAX};
        for (uint32_t f = 0; f < m->triangle_count; f++) {
            mesh one = {m->vertices, m->vertex_count, m->triangles + 3 * (size_t)f, 1};
            vec3 a = vec_from(one.vertices[one.triangles[0]].position);
            vec3 e1 = vec_sub(vec_from(one.vertices[one.triangles[1]].position), a);
            vec3 e2 = vec_sub(vec_from(one.vertices[one.triangles[2]].position), a);
            vec3 n = vec_cross(e1, e2), s = vec_sub(from, a);
            double t = -vec_dot(n, s) / vec_dot(n, d);
            vec3 p = vec_add(s, vec_mul(d, t));
            double u = vec_dot(vec_cross(p, e2), n) / vec_dot(n, n);
            double v = vec_dot(vec_cross(e1, p), n) / vec_dot(n, n);
            if (u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < best.t) {
                best = (bvh_hit){t, u, v, f};
            }
        }
        assert_int_equal(bvh_trace(b, from, d, 0, INFINITY, &hit), best.triangle != UINT32_MAX);
        if (best.triangle != UINT32_MAX) {
            close_to(hit.t, best.t, 1e-9);
            hits++;
            assert_false(bvh_trace(b, from, d, 0, best.t * (1 - 1e-9), &hit));
        }
    }
    assert_true(hits > 50);
    bvh_destroy(&b);
    mesh_destroy(&m);
}

/* A scene seen from above in size x size samples, with the material repeated columns x rows times. */
static table_scene scene_of(mesh *m, bvh *b, int size, double columns, double rows) {
    return (table_scene){.mesh = m,
                         .bvh = b,
                         .camera = {0, 0, 0, 1},
                         .repeat = {columns, rows},
                         .width = size,
                         .height = size,
                         .threads = 2};
}

/* A plane seen along its normal: every sample shows its own texel, with the light at its angles. */
TEST(test_plane_table) {
    enum { SIZE = 8 };
    mesh *m = make("plane");
    bvh *b = bvh_create(m);
    table_scene scene = scene_of(m, b, SIZE, 2, 3);
    table_sample samples[SIZE * SIZE], again[SIZE];
    float inputs[TABLE_INPUTS * SIZE * SIZE], weights[3 * SIZE * SIZE];
    table_cast(&scene, 0, SIZE, samples);
    for (int i = 0; i < SIZE * SIZE; i++) {
        double u = 2 * (i % SIZE + 0.5) / SIZE, v = 3 * (1 - (i / SIZE + 0.5) / SIZE);
        close_to((double)samples[i].uv[0], u - floor(u), 1e-6);
        close_to((double)samples[i].uv[1], v - floor(v), 1e-6);
        close_to((double)samples[i].view[2], 1, 1e-6);
    }
    table_cast(&scene, 5, 1, again);
    assert_memory_equal(again, samples + 5 * SIZE, sizeof again);
    light far = {false, vec_from_angles(30, 90), {2, 1, 0.5}};
    table_light(&scene, &far, SIZE * SIZE, samples, inputs, weights);
    close_to((double)inputs[TABLE_INPUTS * 9 + 6], sin(30 * RENDER_PI / 180), 1e-6);
    close_to((double)inputs[TABLE_INPUTS * 9 + 7], cos(30 * RENDER_PI / 180), 1e-6);
    close_to((double)weights[3 * 9], 2, 0);
    light near = {true, vec_add(vec_from(samples[9].position), vec(0, 0, 2)), {4, 4, 4}};
    table_light(&scene, &near, SIZE * SIZE, samples, inputs, weights);
    close_to((double)inputs[TABLE_INPUTS * 9 + 7], 1, 1e-6);
    close_to((double)weights[3 * 9], 1, 1e-6);
    for (int i = 0; i < SIZE * SIZE; i++) { /* a material of one level */
        assert_true(samples[i].level == 0 && inputs[TABLE_INPUTS * i + 8] == 0);
    }
    scene.camera = (camera){180, 0, 0, 1}; /* from behind: the frame turns over */
    table_cast(&scene, 0, SIZE, samples);
    close_to((double)samples[0].normal[2], -1, 1e-6);
    close_to((double)samples[0].view[2], 1, 1e-6);
    bvh_destroy(&b);
    mesh_destroy(&m);
}

/* Levels of detail follow the footprint: 2 repeats of 64 columns over 8 samples are 16 texels a sample and so level 4,
 * however the picture is rotated; along rows the footprint is shorter. Seen obliquely, far rows take coarser levels. */
TEST(test_levels) {
    enum { SIZE = 8 };
    mesh *m = make("plane");
    bvh *b = bvh_create(m);
    table_scene scene = scene_of(m, b, SIZE, 2, 3);
    scene.texels[0] = 64, scene.texels[1] = 32;
    scene.levels = 7;
    scene.level = -1;
    table_sample samples[SIZE * SIZE];
    for (int turn = 0; turn < 3; turn++) {
        scene.camera.theta = turn < 2 ? 0 : 180;
        scene.repeat[0] = turn == 1 ? 3.9 : 2; /* 31.2 texels round to level 5 */
        table_cast(&scene, 0, SIZE, samples);
        for (int i = 0; i < SIZE * SIZE; i++) {
            assert_int_equal(samples[i].level, turn == 1 ? 5 : 4);
        }
    }
    scene.levels = 3;
    table_cast(&scene, 0, SIZE, samples);
    assert_int_equal(samples[9].level, 2);
    scene.level = 1;
    table_cast(&scene, 0, SIZE, samples);
    assert_int_equal(samples[9].level, 1);
    scene.level = -1;
    scene.repeat[0] = scene.repeat[1] = 0.01; /* magnified */
    table_cast(&scene, 0, SIZE, samples);
    assert_int_equal(samples[9].level, 0);
    scene.levels = 7;
    scene.repeat[0] = scene.repeat[1] = 1;
    scene.camera = (camera){80, -90, 60, 1};
    table_cast(&scene, 0, SIZE, samples);
    int levels = 0, near = 7;
    for (int y = SIZE - 1; y >= 0; y--) {
        const table_sample *sample = &samples[y * SIZE + SIZE / 2];
        if (sample->view[2] == 0) {
            continue;
        }
        assert_true(sample->level >= near || near == 7);
        levels += sample->level != near;
        near = sample->level;
    }
    assert_true(levels >= 2);
    bvh_destroy(&b);
    mesh_destroy(&m);
}

/* The torus casts shadows on its own inside; a sphere casts none on points that face the light. */
TEST(test_cast_shadows) {
    enum { SIZE = 64 };
    static table_sample samples[SIZE * SIZE];
    static float inputs[TABLE_INPUTS * SIZE * SIZE], weights[3 * SIZE * SIZE];
    for (int k = 1; k < 3; k++) {
        mesh *m = make(names[k]);
        bvh *b = bvh_create(m);
        table_scene scene = scene_of(m, b, SIZE, 1, 1);
        scene.camera = (camera){0, 0, 30, 0.9};
        scene.cast_shadows = true;
        light l = {false, vec_from_angles(70, 0), {1, 1, 1}};
        int lit = 0, dark = 0, misses = 0;
        table_cast(&scene, 0, SIZE, samples);
        table_light(&scene, &l, SIZE * SIZE, samples, inputs, weights);
        for (int i = 0; i < SIZE * SIZE; i++) {
            misses += samples[i].view[2] == 0;
            if (inputs[TABLE_INPUTS * i + 7] > 0.05f) {
                *(weights[3 * i] > 0 ? &lit : &dark) += 1;
            }
        }
        assert_true(lit > 100 && misses > 100);
        if (k == 1) {
            assert_int_equal(dark, 0);
        } else {
            assert_true(dark > 20);
        }
        bvh_destroy(&b);
        mesh_destroy(&m);
    }
}

/* Median cut keeps the energy; a single bright pixel is where it was. */
TEST(test_environment) {
    enum { W = 64, H = 32 };
    static float map[W * H * 3];
    light_list list = {0};
    for (int i = 0; i < W * H * 3; i++) {
        map[i] = 1;
    }
    assert_int_equal(light_list_add_environment(&list, W, H, map, 64, 0, 1), BTF_OK);
    assert_int_equal(list.count, 64);
    double sum = 0, lambert = 0;
    for (size_t i = 0; i < list.count; i++) {
        sum += list.lights[i].colour[1];
        lambert += list.lights[i].colour[1] * fmax(0, list.lights[i].at.y);
        close_to(vec_length(list.lights[i].at), 1, 1e-9);
    }
    close_to(sum, 4, 1e-6);     /* 4 pi / pi */
    close_to(lambert, 1, 0.03); /* white Lambertian, white sky: 1, up to the median cut's error */
    light_list_clear(&list);
    memset(map, 0, sizeof map);
    map[3 * (16 * W + 48)] = 100; /* red, to the right: +x */
    map[0] = NAN;
    map[4] = -5;
    assert_int_equal(light_list_add_environment(&list, W, H, map, 16, 0, 2), BTF_OK);
    assert_int_equal(list.count, 1);
    assert_true(list.lights[0].at.x > 0.99 && list.lights[0].colour[0] > 0 &&
                list.lights[0].colour[1] == 0);
    light_list_clear(&list);
    assert_int_equal(light_list_add_environment(&list, W, H, map, 16, -90, 2), BTF_OK);
    assert_true(list.lights[0].at.z < -0.99);
    light_list_clear(&list);
}

TEST(test_light_words) {
    light_list list = {0};
    assert_null(light_parse_directional("90,90,2,1,0.5,0", &list));
    assert_null(light_parse_point("1,2,3", &list));
    close_to(list.lights[0].at.y, 1, 1e-9);
    close_to(list.lights[0].colour[1], 1, 0);
    assert_true(list.lights[1].is_point && list.lights[1].at.z == 3);
    static const char *const bad[] = {
        "",      "1",    "1,2,",  "1,2,x", "1,2,-1", "1,2,3,4", "1,2,3,4,5,6,7,8",
        "nan,0", "-1,0", "200,0", "inf,0", "1e9,0",  "1 2"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_non_null(light_parse_directional(bad[i], &list));
    }
    assert_non_null(light_parse_point("1,2", &list));
    assert_int_equal(list.count, 2);
    light_list_clear(&list);
}

TEST(test_camera) {
    for (int theta = 0; theta <= 180; theta += 30) {
        for (int phi = 0; phi < 360; phi += 30) {
            const camera c = {theta, phi, 30, 1};
            camera_frame f = camera_get_frame(&c);
            close_to(vec_dot(f.right, f.up), 0, 1e-12);
            close_to(vec_dot(f.right, f.back), 0, 1e-12);
            close_to(vec_dot(f.up, f.back), 0, 1e-12);
            close_to(vec_length(f.right), 1, 1e-12);
            assert_true(f.up.y >= 0);
        }
    }
}

TEST(test_picture) {
    assert_int_equal(picture_code(0), 0);
    assert_int_equal(picture_code(1), 255);
    assert_int_equal(picture_code(7), 255);
    assert_int_equal(picture_code(-1), 0);
    assert_int_equal(picture_code(0.2159), 128);
    close_to(picture_tone(TONE_NONE, 3), 3, 0);
    close_to(picture_tone(TONE_REINHARD, 1), 0.5, 0);
    close_to(picture_tone(TONE_FILMIC, 0), 0, 0);
    assert_true(picture_tone(TONE_FILMIC, 1) > 0.7 && picture_tone(TONE_FILMIC, 1) < 0.9);
    float a[6] = {0, 0, 0, 0.5f, 0.5f, 0.5f}, b[6] = {0.1f, 0.1f, 0.1f, 0.5f, 0.5f, 2};
    const picture p = {2, 1, a}, q = {2, 1, b};
    const unsigned char first[2] = {1, 0}, none[2] = {0, 0};
    close_to(picture_psnr(&p, &q, first, false), 20, 1e-5);
    close_to(picture_psnr(&p, &p, NULL, true), 99.99, 0);
    close_to(picture_psnr(&p, &q, none, false), 99.99, 0);
    assert_true(picture_knows("x.png") && picture_knows("x.exr") && !picture_knows("x.jpg") &&
                !picture_knows(".png"));
}

RUN_TESTS(NULL, NULL)
