/* The OBJ reader: the statements that it reads, and its messages about broken files.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/tools/mesh/obj.h"
#include "decoder/tools/mesh/polygon.h"
#include "decoder/tools/mesh/vec.h"
#include "tests/support/messages.h"
#include "tests/support/test.h"

/* From a buffer of exactly the text's size, so that a sanitiser sees a byte too far. */
static btf_result parse(const char *text, size_t size, mesh **out) {
    char *copy = malloc(size ? size : 1);
    assert_non_null(copy);
    memcpy(copy, text, size);
    last_message[0] = '\0';
    btf_result result = mesh_parse_obj("a.obj", copy, size, &log_keep, out);
    free(copy);
    return result;
}

static const char quad[] = "# a quad\r\n"
                           "mtllib x.mtl\no thing\n"
                           "v -2 -2 0\nv 2 -2 0 1\nv 2 2 0\nv -2 2 0\n"
                           "vt 0 0\nvt 1 0 0\nvt 1 1\nvt 0 1\n"
                           "s 1\nf 1/1 2/2 3/3 \\\n 4/4\n";

TEST(test_quad) {
    mesh *m;
    assert_int_equal(parse(quad, strlen(quad), &m), BTF_OK);
    assert_int_equal(m->vertex_count, 4);
    assert_int_equal(m->triangle_count, 2);
    for (uint32_t i = 0; i < 4; i++) {
        const mesh_vertex *v = &m->vertices[i];
        assert_true(fabs(vec_length(vec_from(v->position)) - 1) < 1e-6);
        assert_true(fabsf(v->normal[2] - 1) < 1e-6f);
        assert_true(fabsf(v->tangent[0] - 1) < 1e-6f && v->tangent[3] == 1);
    }
    assert_true(m->vertices[2].uv[0] == 1 && m->vertices[2].uv[1] == 1);
    mesh_destroy(&m);
}

/* Lines that end in CR alone, a line continued right after a word, and free-form surfaces, of which one warning
 * tells. */
TEST(test_lines) {
    static const char mac[] = "v 0 0 0\rv 1 0 0\rv 0 1 0\r# x\rvt 0 0\rf 1/1\\\r2/1 \\\r 3/1\r";
    static const char joined[] = "v 0 0\\\n0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1\\\r\n2/1 3/1\\\n\n";
    static const char curves[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n"
                                 "surf 0 1 0 1 1 2 3\nend\ncurv 0 1 1 2\n";
    mesh *m;
    assert_int_equal(parse(mac, strlen(mac), &m), BTF_OK);
    assert_int_equal(m->triangle_count, 1);
    mesh_destroy(&m);
    assert_int_equal(parse(joined, strlen(joined), &m), BTF_OK);
    assert_int_equal(m->vertex_count, 3);
    mesh_destroy(&m);
    assert_int_equal(parse(curves, strlen(curves), &m), BTF_OK);
    assert_string_equal(last_message, "a.obj:6: 'surf': free-form curves and surfaces are left out");
    mesh_destroy(&m);
}

/* Negative indices, given normals, and the last line without an end. */
TEST(test_references) {
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 -4\n"
                               "f -3/-3/-1 -2/-2/-1 -1/-1/-1\nf 1/1/1 2/2/1 3/3/1";
    mesh *m;
    assert_int_equal(parse(text, strlen(text), &m), BTF_OK);
    assert_int_equal(m->vertex_count, 3);
    assert_int_equal(m->triangle_count, 2);
    assert_true(m->vertices[0].normal[2] == -1);
    mesh_destroy(&m);
}

/* A seam of uv splits vertices but not the averaged normal. */
TEST(test_seam) {
    static const char text[] = "v 0 0 0\nv 0 1 0\nv 1 0 1\nv -1 0 1\nvt 0 0\nvt 0 1\nvt 1 0\nvt .5 .5\n"
                               "f 1/1 3/3 2/2\nf 1/4 2/2 4/3\n";
    mesh *m;
    assert_int_equal(parse(text, strlen(text), &m), BTF_OK);
    assert_int_equal(m->vertex_count, 5);
    const float *a = m->vertices[m->triangles[0]].normal, *b = m->vertices[m->triangles[3]].normal;
    for (int k = 0; k < 3; k++) {
        assert_true(a[k] == b[k]);
    }
    mesh_destroy(&m);
}

/* Each with what the message must hold. */
TEST(test_broken) {
    static const struct {
        const char *text, *message;
        btf_result result;
    } cases[] = {
        {"", "no face", BTF_ERROR_BAD_FILE},
        {"v 1 2\n", "a.obj:1: vertex: 2 numbers, expected 3", BTF_ERROR_BAD_FILE},
        {"\n\nv 1 2 zwei\n", "a.obj:3: vertex: 'zwei'", BTF_ERROR_BAD_FILE},
        {"v 1 2 nan\n", "'nan'", BTF_ERROR_BAD_FILE},
        {"v 1 2 1e30\n", "'1e30'", BTF_ERROR_BAD_FILE},
        {"vt\n", "texture coordinate: 0 numbers", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/1 1/1\n", "a.obj:3: face: has 2 corners", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nf 1 1 1\n", "'1' has no texture coordinate", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvn 0 0 1\nf 1//1 1//1 1//1\n", "no texture coordinate", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/1 2/1 1/1\n", "vertex 2, but 1 are", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/1 0/1 1/1\n", "vertex 0, but 1 are", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/-2 1/1 1/1\n", "texture coordinate -2, but 1 are", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/1/7 1/1 1/1\n", "normal 7, but 0 are", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/1/1/1 1/1 1/1\n", "normal 1, but 0 are", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nvn 0 0 1\nf 1/1/1/1 1/1 1/1\n", "more than three", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/1 1/1 /1\n", "'/1' is not of the form v, v/t", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf a b c\n", "'a' is not of the form v, v/t", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 99999999999999999999/1 1/1 1/1\n", "but 1 are given so far",
         BTF_ERROR_BAD_FILE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        mesh *m;
        btf_result result = parse(cases[i].text, strlen(cases[i].text), &m);
        if (result != cases[i].result || !strstr(last_message, cases[i].message)) {
            fail_msg("case %zu: result %d, message '%s'", i, (int)result, last_message);
        }
        assert_null(m);
    }
    static const char numbers[] =
        "v 1 2 1.0000000000000000000000000000000000000000000000000000000000000000e5\n";
    mesh *m;
    assert_int_equal(parse(numbers, strlen(numbers), &m), BTF_ERROR_BAD_FILE);
    assert_non_null(strstr(last_message, "is longer than 62 characters"));
}

/* A byte-order mark is no part of the first word; other encodings are named. */
TEST(test_marks) {
    char text[sizeof quad + 3] = "\xef\xbb\xbf";
    mesh *m;
    strcat(text, quad + strlen("# a quad\r\n"
                               "mtllib x.mtl\no thing\n"));
    assert_int_equal(parse(text, strlen(text), &m), BTF_OK);
    assert_int_equal(m->vertex_count, 4);
    mesh_destroy(&m);
    assert_int_equal(parse("\xff\xfev\0 \0", 6, &m), BTF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(last_message, "a.obj:1: the text is UTF-16"));
    assert_int_equal(parse("\0v\0 \0", 5, &m), BTF_ERROR_UNSUPPORTED);
    assert_null(m);
}

/* Twice the sum of the triangles' areas, all taken as positive. */
static double covered(const vec3 *corners, const uint32_t *triangles, uint32_t count) {
    double sum = 0;
    for (uint32_t i = 0; i + 2 < count; i++) {
        const uint32_t *t = triangles + 3 * i;
        sum += vec_length(
            vec_cross(vec_sub(corners[t[1]], corners[t[0]]), vec_sub(corners[t[2]], corners[t[0]])));
    }
    return sum;
}

/* Twice the area of a polygon without crossings. */
static double area_of(const vec3 *corners, uint32_t count) {
    vec3 sum = vec(0, 0, 0);
    for (uint32_t i = 0; i < count; i++) {
        sum = vec_add(sum, vec_cross(corners[i], corners[(i + 1) % count]));
    }
    return vec_length(sum);
}

/* Checks that the triangles of a polygon that does not cross itself cover it once: then the sum of their areas, all
 * taken as positive, is its own. The polygon is given in the plane z = 0 and rotated here. */
static void expect_cover(const char *name, const double *xy, uint32_t count) {
    vec3 *corners = malloc(count * sizeof *corners);
    uint32_t *triangles = malloc(3 * (size_t)(count - 2) * sizeof *triangles);
    for (int turned = 0; turned < 4; turned++) {
        for (uint32_t i = 0; i < count; i++) {
            const double x = xy[2 * (turned & 1 ? count - 1 - i : i)],
                         y = xy[2 * (turned & 1 ? count - 1 - i : i) + 1];
            corners[i] = turned < 2 ? vec(x, y, 0) : vec(7 + 0.6 * x, 0.8 * x - 0.6 * y, -3 + 0.8 * y);
        }
        assert_true(polygon_triangulate(corners, count, triangles));
        const double area = area_of(corners, count), sum = covered(corners, triangles, count);
        if (fabs(sum - area) > 1e-9 * (1 + area)) {
            fail_msg("%s, turned %d: area %.17g, covered %.17g", name, turned, area / 2, sum / 2);
        }
    }
    free(corners);
    free(triangles);
}

TEST(test_concave) {
    enum { MOST = 20000 };
    static const double dart[5][2] = {{1, -1}, {1, 1}, {0, -0.6}, {-1, 1}, {-1, -1}};
    static const double middle[8][2] = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
    /* a square with a square hole, cut open from corner to corner */
    static const double hole[10][2] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0},
                                       {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}};
    static const double twice[6][2] = {{0, 0}, {0, 0}, {2, 0}, {1, 1}, {1, 1}, {0, 2}};
    static const double thrice[12][2] = {{1, -1},   {1, -1}, {1, 1},  {1, 1},   {0, -0.6}, {0, -0.6},
                                         {0, -0.6}, {-1, 1}, {-1, 1}, {-1, -1}, {-1, -1},  {-1, -1}};
    static const double spike[7][2] = {{0, 0}, {4, 0}, {4, 4}, {2, 4}, {2, 8}, {2, 4}, {0, 4}};
    static const double inward[7][2] = {{0, 0}, {4, 0}, {4, 4}, {2, 4}, {2, 1}, {2, 4}, {0, 4}};
    static const double touch[6][2] = {{0, 0}, {2, 0}, {1, 1}, {2, 2}, {0, 2}, {1, 1}};
    static const double corner[8][2] = {{0, 0}, {1, 0}, {1, 1}, {2, 1}, {2, 2}, {1, 2}, {1, 1}, {0, 1}};
    static double xy[MOST][2];
    unsigned random = 1;
    expect_cover("dart", &dart[0][0], 5);
    expect_cover("middle", &middle[0][0], 8);
    expect_cover("hole", &hole[0][0], 10);
    expect_cover("twice", &twice[0][0], 6);
    expect_cover("thrice", &thrice[0][0], 12);
    expect_cover("spike", &spike[0][0], 7);
    expect_cover("spike inward", &inward[0][0], 7);
    expect_cover("touch", &touch[0][0], 6);
    expect_cover("corner", &corner[0][0], 8);
    for (uint32_t count = 4; count < 400; count += count / 7 + 1) {
        for (uint32_t i = 0; i < count; i++) {
            random = random * 1664525u + 1013904223u;
            const double radius = 0.1 + (random >> 8) / 16777216.0, angle = 2 * RENDER_PI * i / count;
            xy[i][0] = radius * cos(angle);
            xy[i][1] = radius * sin(angle);
        }
        expect_cover("star", &xy[0][0], count);
    }
    for (uint32_t i = 0; i < MOST; i++) { /* a ribbon, wound ten times */
        const uint32_t half = MOST / 2, k = i < half ? i : MOST - 1 - i;
        const double angle = 20 * RENDER_PI * k / half, radius = 1 + angle / 10 + (i < half ? 0.3 : 0);
        xy[i][0] = radius * cos(angle);
        xy[i][1] = radius * sin(angle);
    }
    expect_cover("ribbon", &xy[0][0], MOST);
    for (uint32_t i = 0; i < MOST; i++) { /* a comb */
        xy[i][0] = i < MOST - 2 ? (double)i : i == MOST - 2 ? MOST : -1;
        xy[i][1] = i < MOST - 2 ? (double)(i % 2) : -1;
    }
    expect_cover("comb", &xy[0][0], MOST);
}

/* Convex polygons become fans. For polygons without area or with crossings the triangulation ends, too. */
TEST(test_other_polygons) {
    uint32_t triangles[3 * 62];
    vec3 corners[64];
    for (uint32_t i = 0; i < 64; i++) {
        corners[i] = vec(cos(2 * RENDER_PI * i / 64), sin(2 * RENDER_PI * i / 64), 0.01 * (i % 2));
    }
    assert_true(polygon_triangulate(corners, 64, triangles));
    for (uint32_t i = 0; i < 62; i++) {
        assert_true(triangles[3 * i] == 0 && triangles[3 * i + 1] == i + 1 &&
                    triangles[3 * i + 2] == i + 2);
    }
    for (int kind = 0; kind < 3; kind++) {
        for (uint32_t i = 0; i < 64; i++) {
            corners[i] = kind == 0 ? vec(1, 2, 3) /* a point */
                         : kind == 1
                             ? vec(i * 0.1, i * 0.2, i * 0.3) /* a line */
                             : vec(cos(2 * RENDER_PI * 27 * i / 64), sin(2 * RENDER_PI * 27 * i / 64), 0);
        }
        assert_true(polygon_triangulate(corners, 64, triangles));
        bool seen[64] = {false};
        for (uint32_t i = 0; i < 3 * 62; i++) {
            assert_true(triangles[i] < 64);
            seen[triangles[i]] = true;
        }
        for (uint32_t i = 0; i < 64; i++) {
            assert_true(seen[i]);
        }
    }
}

/* A face with more corners than the reader once took, and one that a fan would not cover, from a file. */
TEST(test_faces) {
    char text[20000] = "vt 0 0\n";
    mesh *m;
    for (int i = 0; i < 200; i++) {
        sprintf(text + strlen(text), "v %g %g 0\n", (i % 2 ? 1 : 0.4) * cos(RENDER_PI * i / 100),
                (i % 2 ? 1 : 0.4) * sin(RENDER_PI * i / 100));
    }
    strcat(text, "fo");
    for (int i = 1; i <= 200; i++) {
        sprintf(text + strlen(text), " %d/1", i);
    }
    assert_int_equal(parse(text, strlen(text), &m), BTF_OK);
    assert_int_equal(m->triangle_count, 198);
    double sum = 0;
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        vec3 p[3];
        for (int k = 0; k < 3; k++) {
            p[k] = vec_from(m->vertices[m->triangles[3 * i + k]].position);
        }
        sum += vec_cross(vec_sub(p[1], p[0]), vec_sub(p[2], p[0])).z;
        assert_true(vec_cross(vec_sub(p[1], p[0]), vec_sub(p[2], p[0])).z > 0);
    }
    assert_true(fabs(sum - 200 * 0.4 * sin(RENDER_PI / 100)) < 1e-5);
    mesh_destroy(&m);
}

/* Every prefix, and every byte changed: an answer, no crash, and a mesh only of what is there. */
TEST(test_hostile) {
    static const unsigned char values[] = {0, '\n', '/', '-', '9', '\\', 0xff};
    for (size_t size = 0; size < strlen(quad); size++) {
        mesh *m;
        parse(quad, size, &m);
        mesh_destroy(&m);
    }
    for (size_t i = 0; i < strlen(quad); i++) {
        for (size_t k = 0; k < sizeof values; k++) {
            char text[sizeof quad];
            mesh *m;
            memcpy(text, quad, sizeof quad);
            text[i] = (char)values[k];
            if (parse(text, strlen(quad), &m) == BTF_OK) {
                for (uint32_t c = 0; c < 3 * m->triangle_count; c++) {
                    assert_true(m->triangles[c] < m->vertex_count);
                }
            } else {
                assert_true(last_message[0] != '\0');
            }
            mesh_destroy(&m);
        }
    }
}

TEST(test_missing) {
    mesh *m;
    assert_int_equal(mesh_read_obj("no/such.obj", &log_keep, &m), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "no/such.obj: No such file"));
}

RUN_TESTS(NULL, NULL)
