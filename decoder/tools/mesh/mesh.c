/* Meshes made by formula: plane, sphere, torus, drape.
 *
 * SPDX-License-Identifier: MIT
 */
#include "mesh.h"

#include "vec.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

mesh *mesh_allocate(uint32_t vertex_count, uint32_t triangle_count) {
    mesh *m = calloc(1, sizeof *m);
    if (!m) {
        return NULL;
    }
    m->vertex_count = vertex_count;
    m->triangle_count = triangle_count;
    m->vertices = calloc(vertex_count ? vertex_count : 1, sizeof *m->vertices);
    m->triangles = calloc(triangle_count ? triangle_count : 1, 3 * sizeof *m->triangles);
    if (!m->vertices || !m->triangles) {
        mesh_destroy(&m);
    }
    return m;
}

void mesh_destroy(mesh **m) {
    if (!m || !*m) {
        return;
    }
    free((*m)->vertices);
    free((*m)->triangles);
    free(*m);
    *m = NULL;
}

bool mesh_is_flat(const mesh *m) {
    for (uint32_t i = 1; i < m->vertex_count; i++) {
        if (memcmp(m->vertices[i].normal, m->vertices[0].normal, sizeof m->vertices[0].normal) ||
            memcmp(m->vertices[i].tangent, m->vertices[0].tangent, sizeof m->vertices[0].tangent)) {
            return false;
        }
    }
    return true;
}

/* A surface at (s, t) in [0, 1]^2: position, unit normal, and unit tangent in the direction in which u grows. */
typedef struct surface_point {
    vec3 position, normal, tangent;
} surface_point;

typedef struct surface {
    const char *name;
    surface_point (*at)(double s, double t);
    int columns, rows;       /* of quadrilaterals, along s and t */
    double u_scale, v_scale; /* texture coordinates are (s * u_scale, t * v_scale) */
} surface;

static surface_point plane_at(double s, double t) {
    return (surface_point){vec(2 * s - 1, 2 * t - 1, 0), vec(0, 0, 1), vec(1, 0, 0)};
}

/* The unit sphere. Its seam is at the back; s grows eastwards, t from the south pole to the north pole. */
static surface_point sphere_at(double s, double t) {
    double longitude = (2 * s - 1) * RENDER_PI, latitude = (t - 0.5) * RENDER_PI;
    vec3 p = vec(cos(latitude) * sin(longitude), sin(latitude), cos(latitude) * cos(longitude));
    return (surface_point){p, p, vec(cos(longitude), 0, -sin(longitude))};
}

/* A torus that leans towards the default camera on +z, so that its hole is seen. */
static surface_point torus_at(double s, double t) {
    const double major = 0.68, minor = 0.3, lean = 0.9;
    double a = 2 * RENDER_PI * s, b = 2 * RENDER_PI * t;
    vec3 radial = vec(cos(a), sin(a), 0), n = vec_add(vec_mul(radial, cos(b)), vec(0, 0, sin(b)));
    vec3 p = vec_add(vec_mul(radial, major), vec_mul(n, minor)), tangent = vec(-sin(a), cos(a), 0);
    const double c = cos(lean), d = sin(lean);
    surface_point out = {vec(p.x, c * p.y + d * p.z, c * p.z - d * p.y),
                         vec(n.x, c * n.y + d * n.z, c * n.z - d * n.y),
                         vec(tangent.x, c * tangent.y + d * tangent.z, c * tangent.z - d * tangent.y)};
    return out;
}

/* A hanging cloth: folds along y that grow towards the lower edge. */
static double drape_height(double x, double y) {
    double hang = 0.5 * (1 - y);
    return 0.13 * hang * sin(5.5 * x + 0.8 * sin(2.1 * y)) + 0.035 * hang * cos(9 * x - 1.7 * y) +
           0.1 * cos(1.9 * x + 0.4) + 0.05 * sin(2.3 * y);
}

static surface_point drape_at(double s, double t) {
    const double step = 1e-5;
    double x = 2 * s - 1, y = 2 * t - 1;
    double dx = (drape_height(x + step, y) - drape_height(x - step, y)) / (2 * step);
    double dy = (drape_height(x, y + step) - drape_height(x, y - step)) / (2 * step);
    return (surface_point){vec(0.9 * x, 0.9 * y, 0.9 * drape_height(x, y)),
                           vec_unit(vec(-dx, -dy, 1), vec(0, 0, 1)), vec_unit(vec(1, 0, dx), vec(1, 0, 0))};
}

static const surface surfaces[] = {
    {"plane", plane_at, 1, 1, 1, 1},
    {"sphere", sphere_at, 128, 64, 2, 1},
    {"torus", torus_at, 128, 64, 2, 1},
    {"drape", drape_at, 128, 128, 1, 1},
};
enum { SURFACES = sizeof surfaces / sizeof surfaces[0] };

static const surface *find(const char *name) {
    for (int i = 0; i < SURFACES; i++) {
        if (!strcmp(surfaces[i].name, name)) {
            return &surfaces[i];
        }
    }
    return NULL;
}

bool mesh_is_built_in(const char *name) {
    return find(name) != NULL;
}

static void tessellate(const surface *shape, mesh *m) {
    mesh_vertex *out = m->vertices;
    for (int j = 0; j <= shape->rows; j++) {
        for (int i = 0; i <= shape->columns; i++, out++) {
            double s = (double)i / shape->columns, t = (double)j / shape->rows;
            surface_point p = shape->at(s, t);
            vec_store(p.position, out->position);
            vec_store(p.normal, out->normal);
            vec_store(p.tangent, out->tangent);
            out->tangent[3] = 1;
            out->uv[0] = (float)(s * shape->u_scale);
            out->uv[1] = (float)(t * shape->v_scale);
        }
    }
    uint32_t *index = m->triangles;
    const uint32_t stride = (uint32_t)shape->columns + 1;
    for (uint32_t j = 0; j < (uint32_t)shape->rows; j++) {
        for (uint32_t i = 0; i < (uint32_t)shape->columns; i++) {
            const uint32_t a = j * stride + i;
            const uint32_t corners[6] = {a, a + 1, a + stride + 1, a, a + stride + 1, a + stride};
            memcpy(index, corners, sizeof corners);
            index += 6;
        }
    }
}

btf_result mesh_make(const char *name, const btf_log *log, mesh **out_mesh) {
    const surface *shape = find(name);
    *out_mesh = NULL;
    if (!shape) {
        char text[300];
        snprintf(text, sizeof text, "mesh '%.100s': expected plane, sphere, torus, drape or a file *.obj",
                 name);
        if (log && log->callback) {
            log->callback(log->user, BTF_LOG_ERROR, text);
        }
        return BTF_ERROR_USAGE;
    }
    *out_mesh = mesh_allocate((uint32_t)((shape->columns + 1) * (shape->rows + 1)),
                              (uint32_t)(2 * shape->columns * shape->rows));
    if (!*out_mesh) {
        return BTF_ERROR_MEMORY;
    }
    tessellate(shape, *out_mesh);
    return BTF_OK;
}
