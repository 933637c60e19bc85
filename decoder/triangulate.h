/* OpenBTF: the Delaunay triangulation of a direction list.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TRIANGULATE_H
#define OPENBTF_TRIANGULATE_H

#include <openbtf/result.h>
#include <stdint.h>

#pragma GCC visibility push(hidden)

/* Delaunay triangulation of count <= BTF_MAX_DIRECTIONS distinct vertices (x, y in 0..16384): triangles
 * (room for 2 * count), counter-clockwise, each beginning with its smallest index, sorted; and the closed
 * hull (room for 2 * count), beginning with its smallest index, or there and back when all are collinear.
 * Ties of co-circular vertices go to the diagonal with the smallest index. Errors: BTF_ERROR_MEMORY. */
btf_result btfi_triangulate(uint32_t count, const uint16_t (*vertices)[2], uint16_t (*triangles)[3],
                            uint32_t *out_triangle_count, uint16_t *hull, uint32_t *out_hull_count);

#pragma GCC visibility pop

#endif
