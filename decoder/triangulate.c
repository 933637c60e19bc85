/* OpenBTF: Delaunay triangulation and hull of integer vertices, in exact integer arithmetic.
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

/* Fewer than two triangles a vertex; half-edge e is a side of triangle e / 3, whose sides follow each other
 * counter-clockwise. */
enum { N = BTF_MAX_DIRECTIONS, HALVES = 6 * N, NONE = -1 };

typedef struct mesh {
    uint32_t count;
    const uint16_t (*q)[2];
    int halves;             /* in use */
    int16_t origin[HALVES]; /* where a half-edge begins */
    int16_t twin[HALVES];   /* the same edge seen from the other triangle, or NONE */
    int16_t order[N];       /* vertices by x, then y */
    int16_t next[N];        /* the hull, counter-clockwise, while it grows */
    int16_t previous[N];
    int16_t inner[N];        /* the half-edge of hull edge (a, next[a]) */
    int16_t pending[HALVES]; /* a stack: edges whose diagonal may not be the better one */
    int pending_count;
    bool waits[HALVES]; /* is on the stack */
} mesh;

_Static_assert(HALVES <= INT16_MAX, "half-edges have numbers of 16 bits");

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

static int following(int e) {
    return e % 3 == 2 ? e - 2 : e + 1;
}

/* Returns the half-edge from a to b; the next two are from b to c and from c to a. */
static int add_triangle(mesh *m, int a, int b, int c) {
    const int e = m->halves;
    assert(e + 3 <= HALVES);
    m->origin[e] = (int16_t)a;
    m->origin[e + 1] = (int16_t)b;
    m->origin[e + 2] = (int16_t)c;
    m->twin[e] = m->twin[e + 1] = m->twin[e + 2] = NONE;
    m->halves += 3;
    return e;
}

static void join(mesh *m, int e, int twin) {
    m->twin[e] = (int16_t)twin;
    if (twin != NONE) {
        m->twin[twin] = (int16_t)e;
    }
}

static void link_hull(mesh *m, int a, int b, int inner) {
    m->next[a] = (int16_t)b;
    m->previous[b] = (int16_t)a;
    m->inner[a] = (int16_t)inner;
}

static bool before(const mesh *m, int a, int b) {
    return m->q[a][0] != m->q[b][0] ? m->q[a][0] < m->q[b][0] : m->q[a][1] < m->q[b][1];
}

static void sort_vertices(mesh *m) {
    for (uint32_t i = 0; i < m->count; i++) {
        uint32_t at = i;
        for (; at > 0 && before(m, (int)i, m->order[at - 1]); at--) {
            m->order[at] = m->order[at - 1];
        }
        m->order[at] = (int16_t)i;
    }
}

/* Joins the first `k` ordered vertices, all on one line, to the next, which is not. */
static void start_fan(mesh *m, uint32_t k) {
    const int p = m->order[k];
    const bool left = area(m, m->order[0], m->order[1], p) > 0;
    for (uint32_t i = 0; i + 1 < k; i++) { /* counter-clockwise around p */
        const int a = m->order[left ? i : k - 1 - i], b = m->order[left ? i + 1 : k - 2 - i];
        const int e = add_triangle(m, a, b, p);
        link_hull(m, a, b, e);
        if (i == 0) {
            link_hull(m, p, a, e + 2);
        } else {
            join(m, e + 2, e - 2); /* the triangle before ends on the edge from a to p */
        }
        link_hull(m, b, p, e + 1);
    }
}

/* Joins p, which lies outside the hull, to every hull edge that it sees; `last` is the vertex added before. */
static void add_vertex(mesh *m, int p, int last) {
    int first = last; /* p sees an edge that begins or ends at the last vertex */
    while (area(m, m->previous[first], first, p) < 0) {
        first = m->previous[first];
    }
    while (area(m, first, m->next[first], p) >= 0) {
        first = m->next[first];
    }
    int a = first, from_first = NONE, to_p = NONE;
    while (area(m, a, m->next[a], p) < 0) {
        const int b = m->next[a], e = add_triangle(m, b, a, p);
        join(m, e, m->inner[a]);
        if (to_p == NONE) {
            from_first = e + 1;
        } else {
            join(m, e + 1, to_p);
        }
        to_p = e + 2;
        a = b;
    }
    link_hull(m, first, p, from_first);
    link_hull(m, p, a, to_p);
}

static void push(mesh *m, int e) {
    if (m->waits[e]) {
        return;
    }
    m->waits[e] = true;
    m->pending[m->pending_count++] = (int16_t)e;
}

/* Flips the diagonal of half-edge e when that is better; the four sides around it then wait. */
static void flip(mesh *m, int e) {
    const int f = m->twin[e];
    if (f == NONE) {
        return;
    }
    const int b_c = following(e), c_a = following(b_c), a_d = following(f), d_b = following(a_d);
    const int a = m->origin[e], b = m->origin[f], c = m->origin[c_a], d = m->origin[d_b];
    const int64_t inside = in_circle(m, a, b, c, d);
    const int ends = a < b ? a : b, others = c < d ? c : d;
    if (inside < 0 || (inside == 0 && ends < others)) {
        return;
    }
    assert(area(m, a, d, c) > 0 && area(m, d, b, c) > 0);
    const int beyond_db = m->twin[d_b], beyond_ca = m->twin[c_a];
    m->origin[e] = (int16_t)d; /* (a, b, c) becomes (d, b, c), and (b, a, d) becomes (c, a, d) */
    m->origin[f] = (int16_t)c;
    join(m, e, beyond_db);
    join(m, f, beyond_ca);
    join(m, c_a, d_b); /* from c to d, and back */
    push(m, e);
    push(m, f);
    push(m, b_c);
    push(m, a_d);
}

static void flip_all(mesh *m) {
    m->pending_count = 0;
    for (int e = m->halves - 1; e >= 0; e--) {
        m->waits[e] = false;
        push(m, e);
    }
    while (m->pending_count > 0) {
        const int e = m->pending[--m->pending_count];
        m->waits[e] = false;
        flip(m, e);
    }
}

static void collinear_hull(const mesh *m, uint16_t *hull, uint32_t *out_hull_count) {
    uint32_t count = 0;
    if (m->count > 1) {
        for (uint32_t i = 0; i < m->count; i++) {
            hull[count++] = (uint16_t)m->order[i];
        }
        for (uint32_t i = m->count - 2; i > 0; i--) {
            hull[count++] = (uint16_t)m->order[i];
        }
    }
    *out_hull_count = count;
}

static int compare_triangles(const void *a, const void *b) {
    const uint16_t *p = a, *q = b;
    return p[0] != q[0] ? p[0] - q[0] : p[1] - q[1];
}

static void collect(const mesh *m, uint16_t (*triangles)[3], uint32_t *out_triangle_count, uint16_t *hull,
                    uint32_t *out_hull_count) {
    const uint32_t triangle_count = (uint32_t)m->halves / 3;
    for (uint32_t t = 0; t < triangle_count; t++) {
        int e = 3 * (int)t;
        while (m->origin[e] > m->origin[following(e)] ||
               m->origin[e] > m->origin[following(following(e))]) {
            e++;
        }
        for (int k = 0; k < 3; k++, e = following(e)) {
            triangles[t][k] = (uint16_t)m->origin[e];
        }
    }
    qsort(triangles, triangle_count, sizeof *triangles, compare_triangles);

    uint32_t hull_count = 0;
    int start = m->order[0]; /* the leftmost vertex is on the hull */
    for (int a = m->next[start]; a != m->order[0]; a = m->next[a]) {
        start = a < start ? a : start;
    }
    int a = start;
    do {
        hull[hull_count++] = (uint16_t)a;
        a = m->next[a];
    } while (a != start);
    *out_triangle_count = triangle_count;
    *out_hull_count = hull_count;
}

btf_result btfi_triangulate(uint32_t count, const uint16_t (*vertices)[2], uint16_t (*triangles)[3],
                            uint32_t *out_triangle_count, uint16_t *hull, uint32_t *out_hull_count) {
    assert(count >= 1 && count <= N);
    mesh *m = malloc(sizeof *m);
    if (!m) {
        return BTF_ERROR_MEMORY;
    }
    m->count = count;
    m->q = vertices;
    m->halves = 0;
    sort_vertices(m);

    uint32_t k = 2;
    while (k < count && area(m, m->order[0], m->order[1], m->order[k]) == 0) {
        k++;
    }
    if (k >= count) {
        *out_triangle_count = 0;
        collinear_hull(m, hull, out_hull_count);
        free(m);
        return BTF_OK;
    }
    start_fan(m, k);
    for (uint32_t i = k + 1; i < count; i++) {
        add_vertex(m, m->order[i], m->order[i - 1]);
    }
    flip_all(m);
    collect(m, triangles, out_triangle_count, hull, out_hull_count);
    free(m);
    return BTF_OK;
}
