/* Fuzz target: bytes as an OBJ file. An accepted file must give a mesh that can be drawn.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include "decoder/tools/mesh/obj.h"

#include <math.h>

static int errors;

/* Counts errors. Warnings about statements that are left out, such as curves, may come with a mesh or without. */
static void count_message(void *user, btf_log_level level, const char *message) {
    (void)user;
    errors += level == BTF_LOG_ERROR && message[0] != 0;
}

static double length(const float v[3]) {
    return sqrt((double)v[0] * v[0] + (double)v[1] * v[1] + (double)v[2] * v[2]);
}

static void check_vertex(const mesh_vertex *v) {
    FUZZ_CHECK(length(v->position) <= 1.001);
    FUZZ_CHECK(fabs(length(v->normal) - 1) < 1e-3);
    FUZZ_CHECK(fabs(length(v->tangent) - 1) < 1e-3);
    FUZZ_CHECK(fabsf(v->tangent[3]) == 1);
    FUZZ_CHECK(fabsf(v->uv[0]) <= 1.001e18f && fabsf(v->uv[1]) <= 1.001e18f);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const btf_log log = {count_message, NULL};
    mesh *m = NULL;
    errors = 0;
    const btf_result result = mesh_parse_obj("fuzz.obj", (const char *)data, size, &log, &m);
    FUZZ_CHECK((result == BTF_OK) == (m != NULL) && errors == (result != BTF_OK));
    if (!m) {
        return 0;
    }
    FUZZ_CHECK(m->triangle_count > 0 && m->vertex_count > 0 && m->vertex_count <= 3 * m->triangle_count);
    for (uint32_t i = 0; i < 3 * m->triangle_count; i++) {
        FUZZ_CHECK(m->triangles[i] < m->vertex_count);
    }
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        check_vertex(&m->vertices[i]);
    }
    mesh_destroy(&m);
    return 0;
}
