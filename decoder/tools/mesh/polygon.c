/* Triangles of a polygon. See polygon.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "polygon.h"

#include <stdlib.h>

enum { NONE = -1, MAX_CELLS = 512 };

typedef struct point {
    double x, y;
} point;

/* The part of the polygon that no triangle was cut from yet: a ring of corners. Corners that are not strictly convex
 * are called blunt: they can stand in an ear, and lie in a list and in the cells of a grid. */
typedef struct ring {
    const point *at;
    uint32_t *next, *previous;
    uint32_t *blunt; /* the list, [n_blunt] */
    int64_t *place;  /* of a corner in it, or NONE */
    size_t n_blunt;
    int64_t *cell_first, *cell_next; /* corners of a cell that were blunt at the start */
    int cells;                       /* on a side */
    point low;
    double step[2]; /* cells a unit */
} ring;

/* Twice the area of a triangle, or 0 where rounding decides about its sign. */
static double turn(point a, point b, point c) {
    const double ux = b.x - a.x, uy = b.y - a.y, vx = c.x - a.x, vy = c.y - a.y;
    const double area = ux * vy - uy * vx, size = (fabs(ux) + fabs(uy)) * (fabs(vx) + fabs(vy));
    return fabs(area) <= 1e-14 * size ? 0.0 : area;
}

static double turn_at(const ring *r, uint32_t corner) {
    return turn(r->at[r->previous[corner]], r->at[corner], r->at[r->next[corner]]);
}

static bool is_same(point a, point b) {
    return a.x == b.x && a.y == b.y;
}

static int cell_of(const ring *r, double value, int axis) {
    const double cell = (value - (axis ? r->low.y : r->low.x)) * r->step[axis];
    return cell < 0 ? 0 : cell >= r->cells ? r->cells - 1 : (int)cell;
}

/* Whether p lies beyond corner k of a triangle, between the two edges there. */
static bool is_between_edges(const point t[3], int k, point p) {
    return turn(t[k], t[(k + 1) % 3], p) > 0 && turn(t[(k + 2) % 3], t[k], p) > 0;
}

/* Whether a blunt corner lies in the triangle or on its edge. Where a corner of the triangle is, a polygon
 * touches itself, as one with a hole that is cut open does: there an edge has to lead into the triangle. */
static bool blocks(const ring *r, uint32_t corner, const point t[3]) {
    const point p = r->at[corner];
    if (r->place[corner] == NONE) {
        return false;
    }
    for (int k = 0; k < 3; k++) {
        if (is_same(p, t[k])) {
            return is_between_edges(t, k, r->at[r->previous[corner]]) ||
                   is_between_edges(t, k, r->at[r->next[corner]]);
        }
    }
    return turn(t[0], t[1], p) >= 0 && turn(t[1], t[2], p) >= 0 && turn(t[2], t[0], p) >= 0;
}

static bool is_blocked(const ring *r, const point t[3]) {
    const int left = cell_of(r, fmin(t[0].x, fmin(t[1].x, t[2].x)), 0);
    const int right = cell_of(r, fmax(t[0].x, fmax(t[1].x, t[2].x)), 0);
    const int low = cell_of(r, fmin(t[0].y, fmin(t[1].y, t[2].y)), 1);
    const int high = cell_of(r, fmax(t[0].y, fmax(t[1].y, t[2].y)), 1);
    if ((size_t)(right - left + 1) * (size_t)(high - low + 1) >= r->n_blunt) {
        for (size_t i = 0; i < r->n_blunt; i++) {
            if (blocks(r, r->blunt[i], t)) {
                return true;
            }
        }
        return false;
    }
    for (int y = low; y <= high; y++) {
        for (int x = left; x <= right; x++) {
            for (int64_t c = r->cell_first[y * r->cells + x]; c != NONE; c = r->cell_next[c]) {
                if (blocks(r, (uint32_t)c, t)) {
                    return true;
                }
            }
        }
    }
    return false;
}

/* Whether the triangle at a corner can be cut off: inside, of some area, and nothing of the rest in it; or
 * without area, at a corner that is given twice or at the tip of an edge that is walked to and fro. */
static bool is_ear(const ring *r, uint32_t corner) {
    const point t[3] = {r->at[r->previous[corner]], r->at[corner], r->at[r->next[corner]]};
    if (is_same(t[0], t[1]) || is_same(t[1], t[2]) || is_same(t[2], t[0])) {
        return true;
    }
    return turn_at(r, corner) > 0 && !is_blocked(r, t);
}

static void drop_blunt(ring *r, uint32_t corner) {
    const int64_t place = r->place[corner];
    if (place == NONE) {
        return;
    }
    const uint32_t last = r->blunt[--r->n_blunt];
    r->blunt[place] = last;
    r->place[last] = place;
    r->place[corner] = NONE;
}

static void cut(ring *r, uint32_t corner) {
    const uint32_t before = r->previous[corner], after = r->next[corner];
    r->next[before] = after;
    r->previous[after] = before;
    drop_blunt(r, corner);
    if (turn_at(r, before) > 0) {
        drop_blunt(r, before);
    }
    if (turn_at(r, after) > 0) {
        drop_blunt(r, after);
    }
}

/* Sets up the ring of all corners, its list and its grid. */
static void fill(ring *r, uint32_t count) {
    point high = r->at[0];
    r->low = r->at[0];
    for (uint32_t i = 0; i < count; i++) {
        r->next[i] = i + 1 < count ? i + 1 : 0;
        r->previous[i] = i > 0 ? i - 1 : count - 1;
        r->low = (point){fmin(r->low.x, r->at[i].x), fmin(r->low.y, r->at[i].y)};
        high = (point){fmax(high.x, r->at[i].x), fmax(high.y, r->at[i].y)};
    }
    r->step[0] = high.x > r->low.x ? r->cells / (high.x - r->low.x) : 0;
    r->step[1] = high.y > r->low.y ? r->cells / (high.y - r->low.y) : 0;
    for (int i = 0; i < r->cells * r->cells; i++) {
        r->cell_first[i] = NONE;
    }
    for (uint32_t i = 0; i < count; i++) {
        r->place[i] = NONE;
        if (turn_at(r, i) > 0) {
            continue;
        }
        int64_t *first = &r->cell_first[cell_of(r, r->at[i].y, 1) * r->cells + cell_of(r, r->at[i].x, 0)];
        r->cell_next[i] = *first;
        *first = i;
        r->place[i] = (int64_t)r->n_blunt;
        r->blunt[r->n_blunt++] = i;
    }
}

/* Cuts ear after ear. After an ear the next candidate is the corner behind it, so that convex polygons become fans.
 * Where a whole round finds no ear, the polygon crosses itself or has no area left: then a convex corner is cut, or
 * where there is none any corner. */
static void cut_ears(ring *r, uint32_t count, uint32_t *out) {
    uint32_t corner = 1;
    for (uint32_t left = count; left > 3; left--) {
        uint32_t tried = 0;
        while (tried < left && !is_ear(r, corner)) {
            corner = r->next[corner];
            tried++;
        }
        for (uint32_t i = 0; tried == left && i < left && turn_at(r, corner) <= 0; i++) {
            corner = r->next[corner];
        }
        *out++ = r->previous[corner];
        *out++ = corner;
        *out++ = r->next[corner];
        cut(r, corner);
        corner = r->next[corner];
    }
    *out++ = r->previous[corner];
    *out++ = corner;
    *out++ = r->next[corner];
}

/* Projects the corners onto the plane at right angles to Newell's normal, where they turn left. */
static void project(const vec3 *corners, uint32_t count, point *out) {
    vec3 normal = vec(0, 0, 0);
    /* Seen from the first corner, lest its distance from 0 takes the digits. */
    for (uint32_t i = 1; i + 1 < count; i++) {
        normal = vec_add(normal,
                         vec_cross(vec_sub(corners[i], corners[0]), vec_sub(corners[i + 1], corners[0])));
    }
    const double largest = fmax(fabs(normal.x), fmax(fabs(normal.y), fabs(normal.z)));
    normal = largest > 0 ? vec_unit(vec_mul(normal, 1 / largest), vec(0, 0, 1)) : vec(0, 0, 1);
    const vec3 u = vec_perpendicular(normal), v = vec_cross(normal, u);
    for (uint32_t i = 0; i < count; i++) {
        const vec3 p = vec_sub(corners[i], corners[0]);
        out[i] = (point){vec_dot(p, u), vec_dot(p, v)};
    }
}

bool polygon_triangulate(const vec3 *corners, uint32_t count, uint32_t *out_triangles) {
    if (count == 3) {
        for (uint32_t i = 0; i < 3; i++) {
            out_triangles[i] = i;
        }
        return true;
    }
    const int side = (int)sqrt(count / 4.0);
    ring r = {.cells = side < 1 ? 1 : side > MAX_CELLS ? MAX_CELLS : side};
    point *at = malloc(count * sizeof *at);
    r.at = at;
    r.next = malloc(count * sizeof *r.next);
    r.previous = malloc(count * sizeof *r.previous);
    r.blunt = malloc(count * sizeof *r.blunt);
    r.place = malloc(count * sizeof *r.place);
    r.cell_next = malloc(count * sizeof *r.cell_next);
    r.cell_first = malloc((size_t)r.cells * (size_t)r.cells * sizeof *r.cell_first);
    const bool ok = at && r.next && r.previous && r.blunt && r.place && r.cell_next && r.cell_first;
    if (ok) {
        project(corners, count, at);
        fill(&r, count);
        cut_ears(&r, count, out_triangles);
    }
    free(at);
    free(r.next);
    free(r.previous);
    free(r.blunt);
    free(r.place);
    free(r.cell_next);
    free(r.cell_first);
    return ok;
}
