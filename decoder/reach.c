/* OpenBTF: which sampled directions a range of directions needs. See reach.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reach.h"

#include <math.h>
#include <string.h>

#define DEGREE (3.14159265358979323846 / 180)

/* Units of the plane around a range that belong to it: rounding moves a direction by less than one. */
static const double margin = 2;

enum { MOST_CORNERS = 16 };

/* Relative to the pole. */
typedef struct point {
    double x, y;
} point;

typedef struct polygon {
    int count;
    point corner[MOST_CORNERS];
} polygon;

/* A range in the plane: an annulus, cut to a sector by two rays when `sector`. */
typedef struct region {
    double low, high;  /* radii */
    bool sector, wide; /* wide: more than half a turn */
    point from, to;    /* unit vectors of the rays */
} region;

static point vertex(const btfi_directions *d, uint32_t i) {
    return (point){d->vertices[2 * i] - BTFI_PLANE, d->vertices[2 * i + 1] - BTFI_PLANE};
}

static double dot(point p, point q) {
    return p.x * q.x + p.y * q.y;
}

static double cross(point p, point q) {
    return p.x * q.y - p.y * q.x;
}

static point minus(point p, point q) {
    return (point){p.x - q.x, p.y - q.y};
}

/* Keeps the part with dot(normal, p) >= least. */
static polygon clip(const polygon *p, point normal, double least) {
    polygon out = {0};
    for (int i = 0; i < p->count; i++) {
        const point a = p->corner[i], b = p->corner[(i + 1) % p->count];
        const double da = dot(normal, a) - least, db = dot(normal, b) - least;
        if (da >= 0 && out.count < MOST_CORNERS) {
            out.corner[out.count++] = a;
        }
        if ((da >= 0) != (db >= 0) && out.count < MOST_CORNERS) {
            const double t = da / (da - db);
            out.corner[out.count++] = (point){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)};
        }
    }
    return out;
}

/* Distance of the pole from a convex polygon whose corners run counter-clockwise or are collinear. */
static double distance(const polygon *p) {
    double least = INFINITY;
    bool inside = p->count > 2;
    for (int i = 0; i < p->count; i++) {
        const point a = p->corner[i], ab = minus(p->corner[(i + 1) % p->count], a);
        const double length = dot(ab, ab), t = length > 0 ? fmin(fmax(-dot(a, ab) / length, 0), 1) : 0;
        least = fmin(least, hypot(a.x + t * ab.x, a.y + t * ab.y));
        inside = inside && cross(ab, (point){-a.x, -a.y}) >= 0;
    }
    return inside ? 0 : least;
}

static bool annulus_meets(const region *r, const polygon *p) {
    double far = 0;
    for (int i = 0; i < p->count; i++) {
        far = fmax(far, hypot(p->corner[i].x, p->corner[i].y));
    }
    return p->count > 0 && far >= r->low - margin && distance(p) <= r->high + margin;
}

/* False only when no point of the region lies in the polygon. */
static bool meets(const region *r, const polygon *p) {
    if (!r->sector) {
        return annulus_meets(r, p);
    }
    const point left = {-r->from.y, r->from.x}, right = {r->to.y, -r->to.x};
    polygon a = clip(p, left, -margin);
    if (!r->wide) {
        a = clip(&a, right, -margin);
    }
    if (annulus_meets(r, &a)) {
        return true;
    }
    if (!r->wide) {
        return false;
    }
    a = clip(p, right, -margin);
    return annulus_meets(r, &a);
}

static point ray(double degrees) {
    return (point){cos(degrees * DEGREE), sin(degrees * DEGREE)};
}

static region make_region(const btf_range *range) {
    const bool all = range->theta[0] == 0 && range->theta[1] == 0;
    const double low = all ? 0 : range->theta[0], high = all ? 90 : range->theta[1];
    region r = {.low = BTFI_PLANE * tan(low * DEGREE / 2), .high = BTFI_PLANE * tan(high * DEGREE / 2)};
    double turn = fmod((double)range->phi[1] - range->phi[0], 360);
    turn = turn < 0 ? turn + 360 : turn;
    r.sector = turn > 0;
    r.wide = turn > 180;
    r.from = ray(range->phi[0]);
    r.to = ray(range->phi[1]);
    return r;
}

static bool is_angle(float x, float low, float high) {
    return x >= low && x <= high;
}

bool btfi_direction_is_legal(const float direction[3]) {
    const double x = direction[0], y = direction[1], z = direction[2];
    return fabs(sqrt(x * x + y * y + z * z) - 1) <= 1e-3 && z >= 0x1p-24;
}

bool btfi_range_is_legal(const btf_range *r) {
    if (r->fixed) {
        return btfi_direction_is_legal(r->direction);
    }
    return is_angle(r->theta[0], 0, 90) && is_angle(r->theta[1], r->theta[0], 90) &&
           is_angle(r->phi[0], -360, 360) && is_angle(r->phi[1], -360, 360);
}

static uint32_t hull_at(const btfi_directions *d, uint32_t i) {
    return d->hull[i % d->hull_count];
}

/* Everything that could be asked for. */
static polygon whole_plane(void) {
    const double far = 4 * BTFI_PLANE;
    return (polygon){4, {{-far, -far}, {far, -far}, {far, far}, {-far, far}}};
}

/* The points that hull edge h answers along its length, and those at its end (section 6, "Edge"). */
static void edge_regions(const btfi_directions *d, uint32_t h, polygon *strip, polygon *cone) {
    const point a = vertex(d, hull_at(d, h)), b = vertex(d, hull_at(d, h + 1)),
                c = vertex(d, hull_at(d, h + 2));
    const point ab = minus(b, a), ba = minus(a, b), bc = minus(c, b), out = {ab.y, -ab.x};
    const polygon plane = whole_plane();
    *strip = clip(&plane, ab, dot(ab, a));
    *strip = clip(strip, ba, dot(ba, b));
    *strip = clip(strip, out, dot(out, a));
    *cone = clip(&plane, ab, dot(ab, b));
    *cone = clip(cone, (point){-bc.x, -bc.y}, -dot(bc, b));
}

static void reach_records(const btfi_directions *d, const region *r, btfi_reach *out) {
    for (uint32_t t = 0; t < d->triangle_count; t++) {
        const uint16_t *i = d->triangles + 3 * (size_t)t;
        const polygon triangle = {3, {vertex(d, i[0]), vertex(d, i[1]), vertex(d, i[2])}};
        if (!meets(r, &triangle)) {
            continue;
        }
        out->record[t] = BTFI_REACH_RECORD;
        for (int k = 0; k < 3; k++) {
            out->keep[i[k]] = true;
        }
    }
    for (uint32_t h = 0; h < d->hull_count; h++) {
        polygon strip, cone;
        edge_regions(d, h, &strip, &cone);
        uint8_t *record = &out->record[d->triangle_count + h];
        *record = (uint8_t)((meets(r, &strip) ? BTFI_REACH_RECORD : 0) |
                            (meets(r, &cone) ? BTFI_REACH_CORNER : 0));
        if (*record) {
            out->keep[hull_at(d, h)] = out->keep[hull_at(d, h + 1)] = true;
        }
        if (*record & BTFI_REACH_CORNER) {
            out->keep[hull_at(d, h + 2)] = true;
        }
    }
}

/* Directions that one direction's record names: the one direction that has all the weight, an edge's two,
 * or the triangle, whose weights follow from all three. */
static void reach_direction(const btfi_directions *d, const float direction[3], btfi_reach *out) {
    uint32_t index[3], weight[3];
    const uint32_t record = btfi_lookup(d, direction, index, weight);
    const bool triangle = record < d->triangle_count;
    const bool one = (weight[0] == 4096) + (weight[1] == 4096) + (weight[2] == 4096) > 0;
    for (int k = 0; k < 3; k++) {
        if ((triangle && !one) || weight[k] > 0) {
            out->keep[index[k]] = true;
        }
    }
}

void btfi_reach_range(const btfi_directions *d, const btf_range *range, btfi_reach *out) {
    memset(out, 0, sizeof *out);
    if (range->fixed) {
        reach_direction(d, range->direction, out);
    } else {
        const region r = make_region(range);
        reach_records(d, &r, out);
        out->keep[0] = out->keep[0] || d->count == 1;
    }
    for (uint32_t i = 0; i < d->count; i++) {
        out->count += out->keep[i];
    }
}

/* The integer vectors of section 6. */
typedef struct vector {
    int32_t x, y;
} vector;

static vector subtract(const uint16_t *p, const uint16_t *q) {
    return (vector){p[0] - q[0], p[1] - q[1]};
}

static int32_t cross_integer(vector p, vector q) {
    return p.x * q.y - p.y * q.x;
}

static int32_t dot_integer(vector p, vector q) {
    return p.x * q.x + p.y * q.y;
}

static uint32_t fraction(int32_t part, int32_t whole) {
    uint32_t s = 0;
    while (whole >> s >= 1 << 19) {
        s++;
    }
    return ((uint32_t)(part >> s) << 12) / (uint32_t)(whole >> s);
}

static void answer(uint32_t index[3], uint32_t weight[3], uint32_t i0, uint32_t w0, uint32_t i1,
                   uint32_t w1, uint32_t i2) {
    index[0] = i0;
    index[1] = i1;
    index[2] = i2;
    weight[0] = w0;
    weight[1] = w1;
    weight[2] = 4096 - w0 - w1;
}

static bool try_triangle(const btfi_directions *d, uint32_t t, const uint16_t q[2], uint32_t index[3],
                         uint32_t weight[3]) {
    const uint16_t *i = d->triangles + 3 * (size_t)t;
    const uint16_t *a = d->vertices + 2 * i[0], *b = d->vertices + 2 * i[1], *c = d->vertices + 2 * i[2];
    const int32_t e0 = cross_integer(subtract(b, q), subtract(c, q));
    const int32_t e1 = cross_integer(subtract(c, q), subtract(a, q));
    const int32_t e2 = cross_integer(subtract(a, q), subtract(b, q));
    if (e0 < 0 || e1 < 0 || e2 < 0) {
        return false;
    }
    const int32_t area = cross_integer(subtract(b, a), subtract(c, a));
    answer(index, weight, i[0], fraction(e0, area), i[1], fraction(e1, area), i[2]);
    return true;
}

static bool try_edge(const btfi_directions *d, uint32_t h, const uint16_t q[2], uint32_t index[3],
                     uint32_t weight[3]) {
    const uint32_t ia = hull_at(d, h), ib = hull_at(d, h + 1), ic = hull_at(d, h + 2);
    const uint16_t *a = d->vertices + 2 * ia, *b = d->vertices + 2 * ib, *c = d->vertices + 2 * ic;
    const vector ab = subtract(b, a), aq = subtract(q, a);
    const int32_t t = dot_integer(aq, ab), n = dot_integer(ab, ab);
    if (t >= 0 && t <= n && cross_integer(ab, aq) <= 0) {
        const uint32_t w1 = fraction(t, n);
        answer(index, weight, ia, 4096 - w1, ib, w1, ia);
        return true;
    }
    if (t >= n && dot_integer(subtract(q, b), subtract(c, b)) <= 0) {
        answer(index, weight, ib, 4096, ib, 0, ib);
        return true;
    }
    return false;
}

uint32_t btfi_lookup(const btfi_directions *d, const float direction[3], uint32_t index[3],
                     uint32_t weight[3]) {
    uint16_t q[2];
    btfi_project(direction, q);
    const uint32_t cx = ((q[0] < 16383u ? q[0] : 16383u) * d->grid) >> 14;
    const uint32_t cy = ((q[1] < 16383u ? q[1] : 16383u) * d->grid) >> 14;
    const uint16_t *cell = d->cells;
    for (uint32_t i = 0; i < cy * d->grid + cx; i++) {
        cell += 1 + cell[0];
    }
    for (uint32_t i = 1; i <= cell[0]; i++) {
        const uint32_t r = cell[i];
        if (r < d->triangle_count ? try_triangle(d, r, q, index, weight)
                                  : try_edge(d, r - d->triangle_count, q, index, weight)) {
            return r;
        }
    }
    answer(index, weight, 0, 4096, 0, 0, 0);
    return UINT32_MAX;
}

btfi_neighbours btfi_neighbours_of(const btfi_directions *d, const float direction[3], bool nearest) {
    uint32_t index[3], weight[3], best = 0;
    btfi_neighbours n = {0};
    btfi_lookup(d, direction, index, weight);
    for (uint32_t k = 1; k < 3; k++) {
        best = weight[k] > weight[best] ? k : best;
    }
    for (uint32_t k = 0; k < 3; k++) {
        if (nearest ? k != best : weight[k] == 0) {
            continue;
        }
        n.index[n.count] = index[k];
        n.weight[n.count++] = nearest ? 4096 : weight[k];
    }
    return n;
}
