/* Rays against a mesh: median split on the longest axis, up to LEAF triangles a leaf.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bvh.h"

#include <stdlib.h>

enum { LEAF = 4, MAX_DEPTH = 64 };

typedef struct node {
    double low[3], high[3];
    uint32_t first, count; /* a leaf: entries of `order`; count 0: children are the next node and `first` */
} node;

struct bvh {
    const mesh *mesh;
    node *nodes;
    uint32_t node_count;
    uint32_t *order;
    vec3 *centres;
};

static vec3 corner(const bvh *b, uint32_t triangle, int k) {
    return vec_from(b->mesh->vertices[b->mesh->triangles[3 * (size_t)triangle + (size_t)k]].position);
}

static double component(vec3 a, int axis) {
    return axis == 0 ? a.x : axis == 1 ? a.y : a.z;
}

static void bound(const bvh *b, node *n, uint32_t first, uint32_t count) {
    for (int axis = 0; axis < 3; axis++) {
        n->low[axis] = INFINITY;
        n->high[axis] = -INFINITY;
    }
    for (uint32_t i = first; i < first + count; i++) {
        for (int k = 0; k < 3; k++) {
            vec3 p = corner(b, b->order[i], k);
            for (int axis = 0; axis < 3; axis++) {
                n->low[axis] = fmin(n->low[axis], component(p, axis));
                n->high[axis] = fmax(n->high[axis], component(p, axis));
            }
        }
    }
}

/* Whether triangle p comes before q: by centre, then by number, so that the order is total. */
static bool before(const bvh *b, uint32_t p, uint32_t q, int axis) {
    double cp = component(b->centres[p], axis), cq = component(b->centres[q], axis);
    return cp < cq || (cp == cq && p < q);
}

/* Moves the k-th of order[first .. first + count) to its place, with smaller ones before it (C. A. R. Hoare,
 * "Algorithm 65: Find", 1961). */
static void select_nth(bvh *b, uint32_t first, uint32_t count, uint32_t k, int axis) {
    int64_t low = first, high = (int64_t)first + count - 1;
    const int64_t target = (int64_t)first + k;
    while (low < high) {
        const uint32_t pivot = b->order[low + (high - low) / 2];
        int64_t i = low, j = high;
        while (i <= j) {
            while (before(b, b->order[i], pivot, axis)) {
                i++;
            }
            while (before(b, pivot, b->order[j], axis)) {
                j--;
            }
            if (i <= j) {
                uint32_t swap = b->order[i];
                b->order[i++] = b->order[j];
                b->order[j--] = swap;
            }
        }
        if (target <= j) {
            high = j;
        } else if (target >= i) {
            low = i;
        } else {
            return;
        }
    }
}

static uint32_t build(bvh *b, uint32_t first, uint32_t count) {
    const uint32_t self = b->node_count++;
    node *n = &b->nodes[self];
    bound(b, n, first, count);
    n->first = first;
    n->count = count;
    if (count <= LEAF) {
        return self;
    }
    int axis = 0;
    for (int k = 1; k < 3; k++) {
        if (n->high[k] - n->low[k] > n->high[axis] - n->low[axis]) {
            axis = k;
        }
    }
    const uint32_t half = count / 2;
    select_nth(b, first, count, half, axis);
    build(b, first, half);
    const uint32_t right = build(b, first + half, count - half);
    b->nodes[self].first = right;
    b->nodes[self].count = 0;
    return self;
}

bvh *bvh_create(const mesh *m) {
    bvh *b = calloc(1, sizeof *b);
    if (!b) {
        return NULL;
    }
    const size_t count = m->triangle_count ? m->triangle_count : 1;
    b->mesh = m;
    b->nodes = calloc(2 * count, sizeof *b->nodes);
    b->order = calloc(count, sizeof *b->order);
    b->centres = calloc(count, sizeof *b->centres);
    if (!b->nodes || !b->order || !b->centres) {
        bvh_destroy(&b);
        return NULL;
    }
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        b->order[i] = i;
        b->centres[i] = vec_add(vec_add(corner(b, i, 0), corner(b, i, 1)), corner(b, i, 2));
    }
    build(b, 0, m->triangle_count);
    return b;
}

void bvh_destroy(bvh **b) {
    if (!b || !*b) {
        return;
    }
    free((*b)->nodes);
    free((*b)->order);
    free((*b)->centres);
    free(*b);
    *b = NULL;
}

static bool meets_box(const node *n, const double origin[3], const double inverse[3], double t_min,
                      double t_max) {
    for (int axis = 0; axis < 3; axis++) {
        double near = (n->low[axis] - origin[axis]) * inverse[axis];
        double far = (n->high[axis] - origin[axis]) * inverse[axis];
        if (near > far) {
            double swap = near;
            near = far;
            far = swap;
        }
        const double slack = 1e-12 * (fabs(near) + fabs(far));
        if (near - slack > t_min) {
            t_min = near - slack;
        }
        if (far + slack < t_max) {
            t_max = far + slack;
        }
        if (t_min > t_max) {
            return false;
        }
    }
    return true;
}

/* Intersects a ray with a triangle (T. Moeller and B. Trumbore, "Fast, minimum storage ray/triangle intersection",
 * 1997). */
static void meet_triangle(const bvh *b, uint32_t triangle, vec3 origin, vec3 direction, double t_min,
                          bvh_hit *best) {
    vec3 a = corner(b, triangle, 0), e1 = vec_sub(corner(b, triangle, 1), a),
         e2 = vec_sub(corner(b, triangle, 2), a);
    vec3 p = vec_cross(direction, e2);
    double determinant = vec_dot(e1, p);
    if (determinant == 0) {
        return;
    }
    double inverse = 1 / determinant;
    vec3 s = vec_sub(origin, a);
    double u = vec_dot(s, p) * inverse;
    vec3 q = vec_cross(s, e1);
    double v = vec_dot(direction, q) * inverse, t = vec_dot(e2, q) * inverse;
    const double edge = -1e-9; /* so that no ray slips between two triangles */
    if (!(u >= edge && v >= edge && u + v <= 1 - edge && t > t_min)) {
        return;
    }
    if (t < best->t || (t == best->t && triangle < best->triangle)) {
        *best = (bvh_hit){t, u, v, triangle};
    }
}

bool bvh_trace(const bvh *b, vec3 origin, vec3 direction, double t_min, double t_max, bvh_hit *out_hit) {
    const double from[3] = {origin.x, origin.y, origin.z};
    double along[3] = {direction.x, direction.y, direction.z}, inverse[3];
    for (int axis = 0; axis < 3; axis++) {
        inverse[axis] = 1 / (fabs(along[axis]) > 1e-300 ? along[axis] : 1e-300);
    }
    uint32_t stack[MAX_DEPTH];
    int depth = 0;
    *out_hit = (bvh_hit){t_max, 0, 0, UINT32_MAX};
    if (b->mesh->triangle_count) {
        stack[depth++] = 0;
    }
    while (depth > 0) {
        const uint32_t self = stack[--depth];
        const node *n = &b->nodes[self];
        if (!meets_box(n, from, inverse, t_min, out_hit->t)) {
            continue;
        }
        for (uint32_t i = 0; i < n->count; i++) {
            meet_triangle(b, b->order[n->first + i], origin, direction, t_min, out_hit);
        }
        if (n->count == 0) {
            stack[depth++] = n->first;
            stack[depth++] = self + 1;
        }
    }
    return out_hit->triangle != UINT32_MAX;
}
