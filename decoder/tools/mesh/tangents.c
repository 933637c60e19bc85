/* Normals and tangents of a mesh that came without them.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tangents.h"

#include "vec.h"
#include <stdlib.h>

static vec3 position(const mesh *m, uint32_t vertex) {
    return vec_from(m->vertices[vertex].position);
}

void mesh_compute_normals(mesh *m) {
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        vec_store(vec(0, 0, 0), m->vertices[i].normal);
    }
    for (uint32_t f = 0; f < m->triangle_count; f++) {
        const uint32_t *t = m->triangles + 3 * (size_t)f;
        vec3 a = position(m, t[0]);
        vec3 n = vec_cross(vec_sub(position(m, t[1]), a), vec_sub(position(m, t[2]), a));
        for (int k = 0; k < 3; k++) {
            float *normal = m->vertices[t[k]].normal;
            vec_store(vec_add(vec_from(normal), n), normal);
        }
    }
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        float *normal = m->vertices[i].normal;
        vec_store(vec_unit(vec_from(normal), vec(0, 0, 1)), normal);
    }
}

btf_result mesh_compute_tangents(mesh *m) {
    vec3 *sums = calloc(m->vertex_count ? 2 * (size_t)m->vertex_count : 1, sizeof *sums);
    if (!sums) {
        return BTF_ERROR_MEMORY;
    }
    for (uint32_t f = 0; f < m->triangle_count; f++) {
        const uint32_t *t = m->triangles + 3 * (size_t)f;
        const float *w0 = m->vertices[t[0]].uv, *w1 = m->vertices[t[1]].uv, *w2 = m->vertices[t[2]].uv;
        vec3 e1 = vec_sub(position(m, t[1]), position(m, t[0]));
        vec3 e2 = vec_sub(position(m, t[2]), position(m, t[0]));
        double u1 = (double)w1[0] - (double)w0[0], u2 = (double)w2[0] - (double)w0[0];
        double v1 = (double)w1[1] - (double)w0[1], v2 = (double)w2[1] - (double)w0[1];
        double area = u1 * v2 - u2 * v1;
        if (!(fabs(area) > 1e-30)) {
            continue;
        }
        vec3 along_u = vec_mul(vec_sub(vec_mul(e1, v2), vec_mul(e2, v1)), 1 / area);
        vec3 along_v = vec_mul(vec_sub(vec_mul(e2, u1), vec_mul(e1, u2)), 1 / area);
        for (int k = 0; k < 3; k++) {
            sums[2 * (size_t)t[k]] = vec_add(sums[2 * (size_t)t[k]], along_u);
            sums[2 * (size_t)t[k] + 1] = vec_add(sums[2 * (size_t)t[k] + 1], along_v);
        }
    }
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        mesh_vertex *vertex = &m->vertices[i];
        vec3 n = vec_from(vertex->normal), along_u = sums[2 * (size_t)i], along_v = sums[2 * (size_t)i + 1];
        vec3 across = vec_sub(along_u, vec_mul(n, vec_dot(n, along_u)));
        vec3 tangent = vec_unit(across, vec_perpendicular(n));
        vec_store(tangent, vertex->tangent);
        vertex->tangent[3] = vec_dot(vec_cross(n, tangent), along_v) < 0 ? -1.0f : 1.0f;
    }
    free(sums);
    return BTF_OK;
}
