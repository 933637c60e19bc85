/* Triangles of a polygon that may be concave and have any number of corners.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_MESH_POLYGON_H
#define OPENBTF_MESH_POLYGON_H

#include "vec.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Cuts ears off a polygon (G. H. Meisters, "Polygons have ears", 1975), seen along the normal of M. E.
 * Newell, so that the corners need not lie in one plane. A polygon without reflex corners becomes the fan
 * around its first corner. Always count - 2 triangles come out, with the polygon's sense of rotation: where
 * it crosses itself some overlap, and where it has no area (all corners on one line, say) they have none.
 *
 * corners[count], count >= 3; out_triangles[3 * (count - 2)] are numbers of corners. Takes time in
 * proportion to the corners for common shapes. Returns false when out of memory. */
bool polygon_triangulate(const vec3 *corners, uint32_t count, uint32_t *out_triangles);

#endif
