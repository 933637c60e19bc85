/* The OBJ reader: what it understands, and what it says of broken files.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/tools/mesh/obj.h"
#include "decoder/tools/mesh/vec.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static char last[1200];

static void keep(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    strncpy(last, message, sizeof last - 1);
}

/* From a buffer of exactly the text's size, so that a sanitiser sees a byte too far. */
static btf_result parse(const char *text, size_t size, mesh **out) {
    const btf_log log = {keep, NULL};
    char *copy = malloc(size ? size : 1);
    assert_non_null(copy);
    memcpy(copy, text, size);
    last[0] = '\0';
    btf_result result = mesh_parse_obj("a.obj", copy, size, &log, out);
    free(copy);
    return result;
}

static const char quad[] = "# a quad\r\n"
                           "mtllib x.mtl\no thing\n"
                           "v -2 -2 0\nv 2 -2 0 1\nv 2 2 0\nv -2 2 0\n"
                           "vt 0 0\nvt 1 0 0\nvt 1 1\nvt 0 1\n"
                           "s 1\nf 1/1 2/2 3/3 \\\n 4/4\n";

static void test_quad(void **state) {
    (void)state;
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

/* Negative indices, given normals, and the last line without an end. */
static void test_references(void **state) {
    (void)state;
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
static void test_seam(void **state) {
    (void)state;
    static const char text[] = "v 0 0 0\nv 0 1 0\nv 1 0 1\nv -1 0 1\nvt 0 0\nvt 0 1\nvt 1 0\nvt .5 .5\n"
                               "f 1/1 3/3 2/2\nf 1/4 2/2 4/3\n";
    mesh *m;
    assert_int_equal(parse(text, strlen(text), &m), BTF_OK);
    assert_int_equal(m->vertex_count, 5);
    const float *a = m->vertices[m->triangles[0]].normal, *b = m->vertices[m->triangles[3]].normal;
    for (int k = 0; k < 3; k++)
        assert_true(a[k] == b[k]);
    mesh_destroy(&m);
}

/* Each with what the message must hold. */
static void test_broken(void **state) {
    (void)state;
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
        {"v 0 0 0\nvt 0 0\nf 1/1 1/1\n", "a.obj:3: face: 2 corners", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nf 1 1 1\n", "'1' has no texture coordinate", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvn 0 0 1\nf 1//1 1//1 1//1\n", "no texture coordinate", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/1 2/1 1/1\n", "vertex 2 of 1", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/1 0/1 1/1\n", "vertex 0 of 1", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/-2 1/1 1/1\n", "texture coordinate -2 of 1", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/1/7 1/1 1/1\n", "normal 7 of 0", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/1/1/1 1/1 1/1\n", "normal 1 of 0", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nvn 0 0 1\nf 1/1/1/1 1/1 1/1\n", "more than three", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 1/1 1/1 /1\n", "'/1' is no reference", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf a b c\n", "'a' is no reference", BTF_ERROR_BAD_FILE},
        {"v 0 0 0\nvt 0 0\nf 99999999999999999999/1 1/1 1/1\n", "of 1", BTF_ERROR_BAD_FILE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        mesh *m;
        btf_result result = parse(cases[i].text, strlen(cases[i].text), &m);
        if (result != cases[i].result || !strstr(last, cases[i].message))
            fail_msg("case %zu: result %d, message '%s'", i, (int)result, last);
        assert_null(m);
    }
    char text[2000] = "v 0 0 0\nvt 0 0\nf";
    for (int i = 0; i < 65; i++)
        strcat(text, " 1/1");
    mesh *m;
    assert_int_equal(parse(text, strlen(text), &m), BTF_ERROR_UNSUPPORTED);
}

/* Every prefix, and every byte changed: an answer, no crash, and a mesh only of what is there. */
static void test_hostile(void **state) {
    (void)state;
    static const unsigned char values[] = {0, '\n', '/', '-', '9', '\\', 0xff};
    for (size_t size = 0; size < strlen(quad); size++) {
        mesh *m;
        parse(quad, size, &m);
        mesh_destroy(&m);
    }
    for (size_t i = 0; i < strlen(quad); i++)
        for (size_t k = 0; k < sizeof values; k++) {
            char text[sizeof quad];
            mesh *m;
            memcpy(text, quad, sizeof quad);
            text[i] = (char)values[k];
            if (parse(text, strlen(quad), &m) == BTF_OK)
                for (uint32_t c = 0; c < 3 * m->triangle_count; c++)
                    assert_true(m->triangles[c] < m->vertex_count);
            else
                assert_true(last[0] != '\0');
            mesh_destroy(&m);
        }
}

static void test_missing(void **state) {
    (void)state;
    const btf_log log = {keep, NULL};
    mesh *m;
    assert_int_equal(mesh_read_obj("no/such.obj", &log, &m), BTF_ERROR_IO);
    assert_non_null(strstr(last, "no/such.obj: No such file"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quad),   cmocka_unit_test(test_references), cmocka_unit_test(test_seam),
        cmocka_unit_test(test_broken), cmocka_unit_test(test_hostile),    cmocka_unit_test(test_missing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
