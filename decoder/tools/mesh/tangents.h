/* Normals and tangents of a mesh from its triangles.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_MESH_TANGENTS_H
#define OPENBTF_MESH_TANGENTS_H

#include "mesh.h"

/* Normals of all vertices from faces, weighted by area. */
void mesh_compute_normals(mesh *m);

/* Tangents of all vertices along growing u (E. Lengyel, "Foundations of Game Engine Development 2", 2019,
 * 7.5): summed over faces, made orthogonal to the normal; where u says nothing, any perpendicular. Errors:
 * BTF_ERROR_MEMORY. */
btf_result mesh_compute_tangents(mesh *m);

#endif
