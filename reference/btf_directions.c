/* OpenBTF reference decoder: neighbours and weights of a direction (FORMAT.md, section 6).
 *
 * SPDX-License-Identifier: MIT
 */
#include "btf_reference_private.h"

typedef struct point {
    int32_t x, y;
} point;

/** A record of a table: a triangle, or an edge of the hull and the vertex that follows it. */
typedef struct record {
    point a, b, c;
    uint32_t ia, ib, ic;
    uint32_t shift;
    bool edge;
} record;

static point subtract(point p, point q) {
    return (point){p.x - q.x, p.y - q.y};
}

static int32_t cross(point p, point q) {
    return p.x * q.y - p.y * q.x;
}

static int32_t dot(point p, point q) {
    return p.x * q.x + p.y * q.y;
}

static int32_t project_component(float component, float k) {
    float q = component * k;
    q = q * 8192.0f;
    q = q + 0.5f;
    /* the bounds are integers, so clamping before the floor is the same, and safe for any float */
    q = q >= -8192.0f ? q : -8192.0f;
    q = q <= 8192.0f ? q : 8192.0f;
    return btf_ref_floor(q) + 8192;
}

void btf_ref_project_by(const float direction[3], float k, int32_t out_q[2]) {
    out_q[0] = project_component(direction[0], k);
    out_q[1] = project_component(direction[1], k);
}

void btf_ref_project(const float direction[3], int32_t out_q[2]) {
    btf_ref_project_by(direction, btf_ref_reciprocal(direction[2] + 1.0f), out_q);
}

enum { RECORD_TEXELS = 3 };

/** Reads the record that begins in texel `texel` of a table. */
static record read_record(const uint16_t *table, uint32_t texel) {
    const uint16_t *t = table + 4 * texel;
    record r;
    r.a = (point){t[0], t[1]};
    r.b = (point){t[2], t[3]};
    r.c = (point){t[4], t[5]};
    r.ic = t[6];
    r.edge = t[7] % 2 != 0;
    r.shift = t[7] / 2u;
    r.ia = t[8];
    r.ib = t[9];
    return r;
}

/** 4096 * part / whole, rounded down; 0 <= part <= whole, whole >> shift below 2^19. */
static uint32_t fraction(int32_t part, int32_t whole, uint32_t shift) {
    return ((uint32_t)part >> shift << 12) / ((uint32_t)whole >> shift);
}

/** @return whether the triangle holds q; then sets *out_neighbours. */
static bool try_triangle(const record *r, point q, btf_ref_neighbours *out_neighbours) {
    point a = subtract(r->a, q), b = subtract(r->b, q), c = subtract(r->c, q);
    int32_t e0 = cross(b, c), e1 = cross(c, a), e2 = cross(a, b);
    if (e0 < 0 || e1 < 0 || e2 < 0) {
        return false;
    }
    int32_t area = cross(subtract(r->b, r->a), subtract(r->c, r->a));
    uint32_t w0 = fraction(e0, area, r->shift);
    uint32_t w1 = fraction(e1, area, r->shift);
    *out_neighbours = (btf_ref_neighbours){{r->ia, r->ib, r->ic}, {w0, w1, 4096 - w0 - w1}};
    return true;
}

/** @return whether the hull's nearest point to q, which lies outside, is on the edge or is its end; then sets
 * *out_neighbours. */
static bool try_edge(const record *r, point q, btf_ref_neighbours *out_neighbours) {
    point along = subtract(r->b, r->a), from_a = subtract(q, r->a);
    int32_t t = dot(from_a, along), n = dot(along, along);
    if (t >= 0 && t <= n && cross(along, from_a) <= 0) {
        uint32_t w1 = fraction(t, n, r->shift);
        *out_neighbours = (btf_ref_neighbours){{r->ia, r->ib, r->ia}, {4096 - w1, w1, 0}};
        return true;
    }
    if (t >= n && dot(subtract(q, r->b), subtract(r->c, r->b)) <= 0) {
        *out_neighbours = (btf_ref_neighbours){{r->ib, r->ib, r->ib}, {4096, 0, 0}};
        return true;
    }
    return false;
}

btf_ref_neighbours btf_ref_lookup(const uint16_t *table, uint32_t grid, const int32_t q[2]) {
    uint32_t cell_x = (uint32_t)(q[0] < 16383 ? q[0] : 16383) * grid >> 14;
    uint32_t cell_y = (uint32_t)(q[1] < 16383 ? q[1] : 16383) * grid >> 14;
    const uint16_t *cell = table + 4 * (cell_y * grid + cell_x);
    uint32_t first = cell[0], count = cell[1];
    point p = {q[0], q[1]};

    btf_ref_neighbours neighbours = {{0, 0, 0}, {4096, 0, 0}};
    for (uint32_t i = first; i < first + count; ++i) {
        record r = read_record(table, grid * grid + RECORD_TEXELS * i);
        if (r.edge ? try_edge(&r, p, &neighbours) : try_triangle(&r, p, &neighbours)) {
            break;
        }
    }
    return neighbours;
}

btf_ref_neighbours btf_ref_nearest(btf_ref_neighbours neighbours) {
    uint32_t best = 0;
    for (uint32_t i = 1; i < 3; ++i) {
        if (neighbours.weight[i] > neighbours.weight[best]) {
            best = i;
        }
    }
    uint32_t index = neighbours.index[best];
    return (btf_ref_neighbours){{index, index, index}, {4096, 0, 0}};
}

bool btf_ref_probe_directions(void) {
    return btf_ref_probe();
}
