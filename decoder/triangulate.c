/* OpenBTF: Delaunay triangulation and hull of up to 256 integer vertices, in exact integer arithmetic.
 *
 * A sweep in the order of x, then y joins each vertex to the hull edges that it sees; then edges are
 * flipped until no vertex lies inside a neighbour's circumcircle (Lawson 1977). Of four co-circular
 * vertices the diagonal that holds the smallest index stays, so that the result does not depend on the
 * order of flips. Coordinates are at most 2^14, so every determinant stays below 2^62.
 *
 * SPDX-License-Identifier: MIT
 */
#include "triangulate.h"

#include <assert.h>
#include <openbtf/material.h>
#include <stdbool.h>
#include <stdlib.h>

enum { N = BTF_MAX_DIRECTIONS, NONE = -1 };

/* apex[a][b] is the vertex c of the counter-clockwise triangle (a, b, c), or NONE. */
typedef struct mesh {
    uint32_t count;
    const uint16_t (*q)[2];
    int16_t apex[N][N];
    int16_t order[N]; /* vertices by x, then y */
    int16_t next[N];  /* the hull, counter-clockwise, while it grows */
    int16_t previous[N];
} mesh;

/* Twice the area of (a, b, c), positive when counter-clockwise. */
static int64_t area(const mesh *m, int a, int b, int c) {
    int64_t bx = m->q[b][0] - m->q[a][0], by = m->q[b][1] - m->q[a][1];
    int64_t cx = m->q[c][0] - m->q[a][0], cy = m->q[c][1] - m->q[a][1];
    return bx * cy - by * cx;
}

/* Positive when d lies inside the circumcircle of the counter-clockwise (a, b, c), 0 on it. */
static int64_t in_circle(const mesh *m, int a, int b, int c, int d) {
    int64_t ax = m->q[a][0] - m->q[d][0], ay = m->q[a][1] - m->q[d][1];
    int64_t bx = m->q[b][0] - m->q[d][0], by = m->q[b][1] - m->q[d][1];
    int64_t cx = m->q[c][0] - m->q[d][0], cy = m->q[c][1] - m->q[d][1];
    int64_t a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    return a2 * (bx * cy - by * cx) + b2 * (cx * ay - cy * ax) + c2 * (ax * by - ay * bx);
}

static void set_triangle(mesh *m, int a, int b, int c) {
    m->apex[a][b] = (int16_t)c;
    m->apex[b][c] = (int16_t)a;
    m->apex[c][a] = (int16_t)b;
}

static void link_hull(mesh *m, int a, int b) {
    m->next[a] = (int16_t)b;
    m->previous[b] = (int16_t)a;
}

static bool before(const mesh *m, int a, int b) {
    return m->q[a][0] != m->q[b][0] ? m->q[a][0] < m->q[b][0] : m->q[a][1] < m->q[b][1];
}

static void sort_vertices(mesh *m) {
    for (uint32_t i = 0; i < m->count; i++) {
        uint32_t at = i;
        for (; at > 0 && before(m, (int)i, m->order[at - 1]); at--)
            m->order[at] = m->order[at - 1];
        m->order[at] = (int16_t)i;
    }
}

/* Joins the first `k` ordered vertices, all on one line, to the next, which is not. */
static void start_fan(mesh *m, uint32_t k) {
    int p = m->order[k];
    bool left = area(m, m->order[0], m->order[1], p) > 0;
    for (uint32_t i = 0; i + 1 < k; i++) {
        int a = m->order[left ? i : i + 1], b = m->order[left ? i + 1 : i];
        set_triangle(m, a, b, p);
        link_hull(m, a, b);
    }
    link_hull(m, m->order[left ? k - 1 : 0], p);
    link_hull(m, p, m->order[left ? 0 : k - 1]);
}

/* Joins p, which lies outside the hull, to every hull edge that it sees; `last` is the vertex added before.
 */
static void add_vertex(mesh *m, int p, int last) {
    int first = last; /* p sees an edge that begins or ends at the last vertex */
    while (area(m, m->previous[first], first, p) < 0)
        first = m->previous[first];
    int a = first;
    while (area(m, a, m->next[a], p) >= 0)
        a = m->next[a];
    first = a;
    while (area(m, a, m->next[a], p) < 0) {
        int b = m->next[a];
        set_triangle(m, b, a, p);
        a = b;
    }
    link_hull(m, first, p);
    link_hull(m, p, a);
}

/* Flips the diagonal (a, b) when that is better. */
static bool flip(mesh *m, int a, int b) {
    int c = m->apex[a][b], d = m->apex[b][a];
    if (c == NONE || d == NONE)
        return false;
    int64_t inside = in_circle(m, a, b, c, d);
    int ends = a < b ? a : b, others = c < d ? c : d;
    if (inside < 0 || (inside == 0 && ends < others))
        return false;
    assert(area(m, a, d, c) > 0 && area(m, d, b, c) > 0);
    m->apex[a][b] = m->apex[b][a] = NONE;
    set_triangle(m, a, d, c);
    set_triangle(m, d, b, c);
    return true;
}

static void collinear_hull(const mesh *m, uint8_t *hull, uint32_t *out_hull_count) {
    uint32_t count = 0;
    if (m->count > 1) {
        for (uint32_t i = 0; i < m->count; i++)
            hull[count++] = (uint8_t)m->order[i];
        for (uint32_t i = m->count - 2; i > 0; i--)
            hull[count++] = (uint8_t)m->order[i];
    }
    *out_hull_count = count;
}

static void collect(const mesh *m, uint8_t (*triangles)[3], uint32_t *out_triangle_count, uint8_t *hull,
                    uint32_t *out_hull_count) {
    int next[N], n = (int)m->count, start = NONE;
    uint32_t triangle_count = 0, hull_count = 0;
    for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++) {
            int c = m->apex[a][b];
            if (c == NONE)
                continue;
            if (a < b && a < c) {
                triangles[triangle_count][0] = (uint8_t)a;
                triangles[triangle_count][1] = (uint8_t)b;
                triangles[triangle_count++][2] = (uint8_t)c;
            }
            if (m->apex[b][a] == NONE) {
                next[a] = b;
                start = start == NONE ? a : start;
            }
        }
    int a = start;
    do {
        hull[hull_count++] = (uint8_t)a;
        a = next[a];
    } while (a != start);
    *out_triangle_count = triangle_count;
    *out_hull_count = hull_count;
}

btf_result btfi_triangulate(uint32_t count, const uint16_t (*vertices)[2], uint8_t (*triangles)[3],
                            uint32_t *out_triangle_count, uint8_t *hull, uint32_t *out_hull_count) {
    assert(count >= 1 && count <= N);
    mesh *m = malloc(sizeof *m);
    if (!m)
        return BTF_ERROR_MEMORY;
    m->count = count;
    m->q = vertices;
    for (uint32_t a = 0; a < count; a++)
        for (uint32_t b = 0; b < count; b++)
            m->apex[a][b] = NONE;
    sort_vertices(m);

    uint32_t k = 2;
    while (k < count && area(m, m->order[0], m->order[1], m->order[k]) == 0)
        k++;
    if (k >= count) {
        *out_triangle_count = 0;
        collinear_hull(m, hull, out_hull_count);
        free(m);
        return BTF_OK;
    }
    start_fan(m, k);
    for (uint32_t i = k + 1; i < count; i++)
        add_vertex(m, m->order[i], m->order[i - 1]);
    for (bool changed = true; changed;) {
        changed = false;
        for (int a = 0; a < (int)count; a++)
            for (int b = a + 1; b < (int)count; b++)
                changed |= flip(m, a, b);
    }
    collect(m, triangles, out_triangle_count, hull, out_hull_count);
    free(m);
    return BTF_OK;
}
