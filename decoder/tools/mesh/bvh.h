/* Rays against a mesh: a bounding volume hierarchy over its triangles, in double precision.
 *
 * Thread rule: immutable once made.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_MESH_BVH_H
#define OPENBTF_MESH_BVH_H

#include "mesh.h"
#include "vec.h"

typedef struct bvh bvh;

typedef struct bvh_hit {
    double t;    /* distance along the direction, in its lengths */
    double b, c; /* barycentric weights of corners 1 and 2 */
    uint32_t triangle;
} bvh_hit;

/* The mesh must outlive it. NULL when out of memory. */
bvh *bvh_create(const mesh *m);
void bvh_destroy(bvh **b);

/* The nearest hit with t in (t_min, t_max), from either side; false: none. Ties go to the lower triangle. */
bool bvh_trace(const bvh *b, vec3 origin, vec3 direction, double t_min, double t_max, bvh_hit *out_hit);

#endif
