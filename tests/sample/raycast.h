/* Finds the points of a relief that a view sees, and those that a light reaches.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SAMPLE_RAYCAST_H
#define OPENBTF_SAMPLE_RAYCAST_H

#include "relief.h"

#include <stdbool.h>

/* A point of the surface. */
typedef struct raycast_hit {
    double position[3]; /* x and y unwrapped, z in [-depth, 0] */
    double normal[3];   /* unit, of the bilinear patch it lies on */
} raycast_hit;

/* The point that is seen at (x, y) of the image rectified to the plane z = 0, from far away along the
 * unit vector v (v.z > 0): the first point p of the surface, coming from the viewer, with p.xy = (x, y) +
 * p.z * v.xy / v.z. Exact for the bilinear surface up to rounding in double: cells are walked in order, and
 * in each the intersection is the root of a quadratic. */
raycast_hit raycast_view(const relief *r, double x, double y, const double v[3]);

/* The shadow that one light casts, as a height over (x, y): a point is shadowed where it lies below it. */
typedef struct raycast_shadow {
    int grid;
    bool none;        /* no point is shadowed: the relief is flat, or the light is at the pole */
    bool transposed;  /* height[column][row] instead of [row][column] */
    double low, step; /* height = low + code * step */
    uint16_t *height; /* [grid][grid], at the nodes of the relief's grid */
} raycast_shadow;

/* Sweeps lines parallel to the light over the whole tile, one sample a grid line crossed (own method, after
 * Max 1988, "Horizon mapping"). Edges of shadows are right to about one cell of the grid; heights are
 * stored to depth / 52000. l: unit, l.z > 0. Errors: BTF_ERROR_MEMORY. */
btf_result raycast_shadow_create(const relief *r, const double l[3], raycast_shadow *out_shadow);
void raycast_shadow_destroy(raycast_shadow *shadow);

/* Whether the relief does not occlude the light at the point. The caller has to test the normal itself: a point with
 * n.l <= 0 is unlit as well. */
bool raycast_lit(const raycast_shadow *shadow, const double position[3]);

#endif
