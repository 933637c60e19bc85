/* Triangle meshes with texture coordinates and tangent frames, and those that are made by formula.
 *
 * World: x to the right, y up, z towards the default camera. Built-in meshes lie within [-1, 1] on each
 * axis.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_MESH_MESH_H
#define OPENBTF_MESH_MESH_H

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Ready for a vertex buffer. tangent[3] is the handedness: bitangent = tangent[3] * cross(normal, tangent). */
typedef struct mesh_vertex {
    float position[3], normal[3], uv[2], tangent[4];
} mesh_vertex;

typedef struct mesh {
    mesh_vertex *vertices;
    uint32_t vertex_count;
    uint32_t *triangles; /* [triangle_count][3], counter-clockwise from outside */
    uint32_t triangle_count;
} mesh;

void mesh_destroy(mesh **m);

/* Makes a built-in mesh, "plane|sphere|torus|drape". u and v are 0..1 over the plane and the drape; u is 0..2 round
 * the sphere's equator and the torus, v is 0..1 there. Errors: BTF_ERROR_USAGE (name, told on log),
 * BTF_ERROR_MEMORY. */
btf_result mesh_make(const char *name, const btf_log *log, mesh **out_mesh);

/* True when name is one of the above. */
bool mesh_is_built_in(const char *name);

/* Whether normal and tangent are the same all over the mesh: a light far away then has one direction in its frame. */
bool mesh_is_flat(const mesh *m);

/* Room for a mesh of these sizes, zeroed. NULL when out of memory. */
mesh *mesh_allocate(uint32_t vertex_count, uint32_t triangle_count);

#endif
