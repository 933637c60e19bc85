/* OpenBTF: direction lists as FORMAT.md section 6 wants them: vertices, triangles, hull, look-up grid, GPU
 * table.
 *
 * SPDX-License-Identifier: MIT
 */
#include "directions.h"

#include "triangulate.h"
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Mean records a cell at which the grid is fine enough. */
#define WANTED_RECORDS 3.0

/* One rounding an operation, whatever the compiler's flags (FORMAT.md section 8). */
static float mul(float a, float b) {
    volatile float product = a * b;
    return product;
}

static float add(float a, float b) {
    volatile float sum = a + b;
    return sum;
}

static float reciprocal(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits = 0x7EF311C7u - bits;
    float r;
    memcpy(&r, &bits, sizeof r);
    for (int i = 0; i < 4; i++) {
        r = mul(r, add(2.0f, -mul(x, r)));
    }
    return r;
}

static uint16_t quantise(float x, float k) {
    float q = floorf(add(mul(mul(x, k), (float)BTFI_PLANE), 0.5f));
    q = q < -(float)BTFI_PLANE ? -(float)BTFI_PLANE : q > (float)BTFI_PLANE ? (float)BTFI_PLANE : q;
    return (uint16_t)((int)q + BTFI_PLANE);
}

void btfi_project(const float d[3], uint16_t out_q[2]) {
    float k = reciprocal(add(d[2], 1.0f));
    out_q[0] = quantise(d[0], k);
    out_q[1] = quantise(d[1], k);
}

void btfi_directions_clear(btfi_directions *directions) {
    free(directions->xyz);
    free(directions->vertices);
    free(directions->triangles);
    free(directions->hull);
    free(directions->cells);
    free(directions->table);
    *directions = (btfi_directions){0};
}

typedef struct point {
    int64_t x, y;
} point;

static point vertex(const btfi_directions *d, uint32_t i) {
    return (point){d->vertices[2 * i], d->vertices[2 * i + 1]};
}

static point minus(point p, point q) {
    return (point){p.x - q.x, p.y - q.y};
}

static int64_t cross(point p, point q) {
    return p.x * q.y - p.y * q.x;
}

static int64_t dot(point p, point q) {
    return p.x * q.x + p.y * q.y;
}

/* The vertices of hull edge h and the one after. */
static void hull_edge(const btfi_directions *d, uint32_t h, uint32_t out[3]) {
    for (uint32_t i = 0; i < 3; i++) {
        out[i] = d->hull[(h + i) % d->hull_count];
    }
}

/* A cell: every q with low <= q <= high. */
typedef struct cell {
    point low, high;
} cell;

static cell cell_at(uint32_t grid, uint32_t cx, uint32_t cy) {
    const int64_t side = 16384 / grid, end = 2 * BTFI_PLANE;
    cell c = {{cx * side, cy * side}, {(cx + 1) * side - 1, (cy + 1) * side - 1}};
    if (cx == grid - 1) {
        c.high.x = end; /* 16384 itself belongs to the last cell */
    }
    if (cy == grid - 1) {
        c.high.y = end;
    }
    return c;
}

/* The largest value of n.q over the cell. */
static int64_t largest(const cell *c, point n) {
    return n.x * (n.x > 0 ? c->high.x : c->low.x) + n.y * (n.y > 0 ? c->high.y : c->low.y);
}

/* True unless n.(q - p) < 0 for every q of the cell. */
static bool reaches(const cell *c, point n, point p) {
    return largest(c, n) >= dot(n, p);
}

static int64_t min3(int64_t a, int64_t b, int64_t c) {
    int64_t m = a < b ? a : b;
    return m < c ? m : c;
}

static int64_t max3(int64_t a, int64_t b, int64_t c) {
    int64_t m = a > b ? a : b;
    return m > c ? m : c;
}

/* True when the closed triangle and the cell meet: no side of either separates them. */
static bool triangle_meets(const btfi_directions *d, uint32_t t, const cell *cell) {
    point a = vertex(d, d->triangles[3 * t]), b = vertex(d, d->triangles[3 * t + 1]),
          c = vertex(d, d->triangles[3 * t + 2]);
    if (max3(a.x, b.x, c.x) < cell->low.x || min3(a.x, b.x, c.x) > cell->high.x ||
        max3(a.y, b.y, c.y) < cell->low.y || min3(a.y, b.y, c.y) > cell->high.y) {
        return false;
    }
    const point corner[4] = {a, b, c, a};
    for (int i = 0; i < 3; i++) {
        point side = minus(corner[i + 1], corner[i]);
        if (!reaches(cell, (point){-side.y, side.x}, corner[i])) {
            return false;
        }
    }
    return true;
}

/* False only when edge h accepts no q of the cell: each of its two regions is an intersection of half
 * planes, and some half plane of each misses the cell. */
static bool edge_meets(const btfi_directions *d, uint32_t h, const cell *cell) {
    uint32_t index[3];
    hull_edge(d, h, index);
    point a = vertex(d, index[0]), b = vertex(d, index[1]), c = vertex(d, index[2]);
    point ab = minus(b, a), ba = minus(a, b), cb = minus(b, c);
    bool strip = reaches(cell, ab, a) && reaches(cell, ba, b) && reaches(cell, (point){ab.y, -ab.x}, a);
    bool cone = reaches(cell, ab, b) && reaches(cell, cb, b);
    if (strip || !cone || d->triangle_count == 0) {
        return strip || cone;
    }
    /* Inside the hull, directions belong to triangles; outside, a corner's cone is beyond one of its edges. */
    point bc = minus(c, b);
    return reaches(cell, (point){ab.y, -ab.x}, b) || reaches(cell, (point){bc.y, -bc.x}, b);
}

/* A record that a cell lists. */
typedef struct listing {
    uint16_t record, cell;
} listing;

/* The cells along one axis that hold the coordinates low .. high. */
static void cell_span(uint32_t grid, int64_t low, int64_t high, uint32_t out[2]) {
    const int64_t last = 2 * BTFI_PLANE - 1;
    out[0] = (uint32_t)((low < last ? low : last) * grid >> 14);
    out[1] = (uint32_t)((high < last ? high : last) * grid >> 14);
}

/* The cells that could list a record: all of them for an edge, which reaches to the border of the plane. */
static void record_span(const btfi_directions *d, uint32_t record, uint32_t grid, uint32_t x[2],
                        uint32_t y[2]) {
    x[0] = y[0] = 0;
    x[1] = y[1] = grid - 1;
    if (record >= d->triangle_count) {
        return;
    }
    const uint16_t *i = d->triangles + 3 * (size_t)record;
    const point a = vertex(d, i[0]), b = vertex(d, i[1]), c = vertex(d, i[2]);
    cell_span(grid, min3(a.x, b.x, c.x), max3(a.x, b.x, c.x), x);
    cell_span(grid, min3(a.y, b.y, c.y), max3(a.y, b.y, c.y), y);
}

/* Writes the pairs of a record and a cell that lists it, by rising record. Returns their number, BTFI_MAX_RECORDS +
 * 1 when there are more. */
static uint32_t list_records(const btfi_directions *d, uint32_t grid, listing *out) {
    uint32_t count = 0;
    for (uint32_t r = 0; r < d->triangle_count + d->hull_count; r++) {
        const bool is_edge = r >= d->triangle_count;
        uint32_t x[2], y[2];
        record_span(d, r, grid, x, y);
        for (uint32_t cy = y[0]; cy <= y[1]; cy++) {
            for (uint32_t cx = x[0]; cx <= x[1]; cx++) {
                const cell c = cell_at(grid, cx, cy);
                if (!(is_edge ? edge_meets(d, r - d->triangle_count, &c) : triangle_meets(d, r, &c))) {
                    continue;
                }
                if (count == BTFI_MAX_RECORDS) {
                    return BTFI_MAX_RECORDS + 1;
                }
                out[count++] = (listing){(uint16_t)r, (uint16_t)(cy * grid + cx)};
            }
        }
    }
    return count;
}

/* For each cell the count, then its record numbers, which rise as those of the list do. */
static btf_result sort_into_cells(const btfi_check *check, const char *name, const listing *list,
                                  uint32_t count, btfi_directions *d) {
    const uint32_t n_cells = d->grid * d->grid;
    uint32_t start[BTFI_MAX_GRID * BTFI_MAX_GRID] = {0};
    d->cells_length = n_cells + count;
    d->cells = calloc(d->cells_length, sizeof *d->cells);
    if (!d->cells) {
        return btfi_fail(check->log, BTF_ERROR_MEMORY, "%s: out of memory for the look-up grid", name);
    }
    for (uint32_t i = 0; i < count; i++) {
        start[list[i].cell]++;
    }
    for (uint32_t c = 0, at = 0; c < n_cells; c++) {
        const uint32_t n = start[c];
        start[c] = at;
        at += 1 + n;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint16_t *cell = d->cells + start[list[i].cell];
        cell[++cell[0]] = list[i].record;
    }
    return BTF_OK;
}

/* The coarsest grid with few records a cell, or else the finest of which all records have numbers: with
 * one cell they always have, since triangles and hull edges are fewer than twice the directions. */
static btf_result build_grid(const btfi_check *check, const char *name, btfi_directions *d) {
    listing *list = malloc(BTFI_MAX_RECORDS * sizeof *list),
            *best = malloc(BTFI_MAX_RECORDS * sizeof *best);
    btf_result result = BTF_OK;
    uint32_t count = 0;
    d->grid = 0;
    if (!list || !best) {
        result = btfi_fail(check->log, BTF_ERROR_MEMORY, "%s: out of memory for the look-up grid", name);
    }
    for (uint32_t grid = 1; result == BTF_OK && grid <= BTFI_MAX_GRID; grid *= 2) {
        const uint32_t records = list_records(d, grid, list);
        if (records > BTFI_MAX_RECORDS) {
            break;
        }
        listing *swap = best;
        best = list;
        list = swap;
        d->grid = grid;
        count = records;
        if (records <= WANTED_RECORDS * grid * grid) {
            break;
        }
    }
    if (result == BTF_OK) {
        result = sort_into_cells(check, name, best, count, d);
    }
    free(list);
    free(best);
    return result;
}

/* Unit within 1e-3 and above the horizon. */
static btf_result check_unit(const btfi_check *check, const char *name, uint32_t count, const float *xyz) {
    for (uint32_t i = 0; i < count; i++) {
        const float *d = xyz + 3 * (size_t)i;
        double length = sqrt((double)d[0] * d[0] + (double)d[1] * d[1] + (double)d[2] * d[2]);
        if (!(fabs(length - 1) <= 1e-3) || !(d[2] > 0)) {
            return btfi_fail(check->log, check->code,
                             "%s: direction %u (%g, %g, %g) is not a unit vector above the horizon", name,
                             (unsigned)i, (double)d[0], (double)d[1], (double)d[2]);
        }
    }
    return BTF_OK;
}

static btf_result check_distinct(const btfi_check *check, const char *name, uint32_t count,
                                 const uint16_t *vertices) {
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t j = 0; j < i; j++) {
            if (vertices[2 * i] == vertices[2 * j] && vertices[2 * i + 1] == vertices[2 * j + 1]) {
                return btfi_fail(check->log, check->code, "%s: directions %u and %u coincide", name,
                                 (unsigned)j, (unsigned)i);
            }
        }
    }
    return BTF_OK;
}

btf_result btfi_directions_build(const btfi_check *check, const char *name, uint32_t count,
                                 const float *xyz, btfi_directions *out) {
    assert(count >= 1 && count <= BTF_MAX_DIRECTIONS);
    btf_result result;
    *out = (btfi_directions){.count = count};
    if ((result = check_unit(check, name, count, xyz))) {
        return result;
    }
    out->xyz = malloc((size_t)count * 3 * sizeof *out->xyz);
    out->vertices = malloc((size_t)count * 2 * sizeof *out->vertices);
    out->triangles = malloc((size_t)count * 2 * 3 * sizeof *out->triangles);
    out->hull = malloc((size_t)count * 2 * sizeof *out->hull);
    if (!out->xyz || !out->vertices || !out->triangles || !out->hull) {
        result = btfi_fail(check->log, BTF_ERROR_MEMORY, "%s: out of memory", name);
        goto fail;
    }
    memcpy(out->xyz, xyz, (size_t)count * 3 * sizeof *xyz);
    for (uint32_t i = 0; i < count; i++) {
        btfi_project(out->xyz + 3 * (size_t)i, out->vertices + 2 * (size_t)i);
    }
    if ((result = check_distinct(check, name, count, out->vertices))) {
        goto fail;
    }
    result = btfi_triangulate(count, (const uint16_t(*)[2])out->vertices, (uint16_t(*)[3])out->triangles,
                              &out->triangle_count, out->hull, &out->hull_count);
    if (result) {
        btfi_fail(check->log, result, "%s: out of memory for the triangulation", name);
        goto fail;
    }
    if ((result = build_grid(check, name, out)) || (result = btfi_directions_make_table(check->log, out))) {
        goto fail;
    }
    return BTF_OK;
fail:
    btfi_directions_clear(out);
    return result;
}

static btf_result check_vertices(const btfi_check *check, const char *name, const btfi_directions *d) {
    for (uint32_t i = 0; i < d->count; i++) {
        uint16_t q[2];
        btfi_project(d->xyz + 3 * (size_t)i, q);
        for (int k = 0; k < 2; k++) {
            if (abs((int)d->vertices[2 * i + k] - (int)q[k]) > 1) {
                return btfi_fail(check->log, check->code,
                                 "%s: vertex %u (%u, %u) is not the projection (%u, %u) of its direction",
                                 name, (unsigned)i, (unsigned)d->vertices[2 * i],
                                 (unsigned)d->vertices[2 * i + 1], (unsigned)q[0], (unsigned)q[1]);
            }
        }
    }
    return check_distinct(check, name, d->count, d->vertices);
}

static btf_result check_triangles(const btfi_check *check, const char *name, const btfi_directions *d) {
    for (uint32_t t = 0; t < d->triangle_count; t++) {
        const uint16_t *i = d->triangles + 3 * (size_t)t;
        for (int k = 0; k < 3; k++) {
            if (i[k] >= d->count) {
                return btfi_fail(check->log, check->code, "%s: triangle %u names direction %u of %u", name,
                                 (unsigned)t, (unsigned)i[k], (unsigned)d->count);
            }
        }
        point a = vertex(d, i[0]);
        if (cross(minus(vertex(d, i[1]), a), minus(vertex(d, i[2]), a)) <= 0) {
            return btfi_fail(check->log, check->code, "%s: triangle %u is not counter-clockwise", name,
                             (unsigned)t);
        }
    }
    return BTF_OK;
}

/* Every vertex lies to the left of every hull edge or on it, and no edge has length 0. */
static btf_result check_hull(const btfi_check *check, const char *name, const btfi_directions *d) {
    if ((d->hull_count == 0) != (d->count == 1) || d->hull_count == 1) {
        return btfi_fail(check->log, check->code,
                         "%s: the hull has %u vertices, which %u directions cannot have", name,
                         (unsigned)d->hull_count, (unsigned)d->count);
    }
    for (uint32_t h = 0; h < d->hull_count; h++) {
        if (d->hull[h] >= d->count) {
            return btfi_fail(check->log, check->code, "%s: the hull names direction %u of %u", name,
                             (unsigned)d->hull[h], (unsigned)d->count);
        }
    }
    for (uint32_t h = 0; h < d->hull_count; h++) {
        uint32_t index[3];
        hull_edge(d, h, index);
        point a = vertex(d, index[0]), ab = minus(vertex(d, index[1]), a);
        if (index[0] == index[1]) {
            return btfi_fail(check->log, check->code, "%s: hull edge %u has no length", name, (unsigned)h);
        }
        for (uint32_t i = 0; i < d->count; i++) {
            if (cross(ab, minus(vertex(d, i), a)) < 0) {
                return btfi_fail(check->log, check->code, "%s: vertex %u lies outside hull edge %u", name,
                                 (unsigned)i, (unsigned)h);
            }
        }
    }
    return BTF_OK;
}

static btf_result check_cells(const btfi_check *check, const char *name, const btfi_directions *d) {
    if (d->grid < 1 || d->grid > BTFI_MAX_GRID || (d->grid & (d->grid - 1)) != 0) {
        return btfi_fail(check->log, check->code, "%s: grid %u is not a power of two within 1 to %d", name,
                         (unsigned)d->grid, BTFI_MAX_GRID);
    }
    const uint32_t n_cells = d->grid * d->grid, n_records = d->triangle_count + d->hull_count;
    size_t at = 0, records = 0;
    for (uint32_t c = 0; c < n_cells; c++) {
        if (at >= d->cells_length || d->cells[at] > d->cells_length - at - 1) {
            return btfi_fail(check->log, check->code, "%s: the list of cell %u of %u ends early", name,
                             (unsigned)c, (unsigned)n_cells);
        }
        size_t count = d->cells[at++];
        for (size_t i = 0; i < count; i++) {
            uint32_t record = d->cells[at + i];
            if (record >= n_records) {
                return btfi_fail(check->log, check->code, "%s: cell %u lists record %u of %u", name,
                                 (unsigned)c, (unsigned)record, (unsigned)n_records);
            }
            if (i > 0 && record <= d->cells[at + i - 1]) {
                return btfi_fail(check->log, check->code, "%s: the records of cell %u are not in order",
                                 name, (unsigned)c);
            }
        }
        at += count;
        records += count;
    }
    if (at != d->cells_length) {
        return btfi_fail(check->log, check->code, "%s: %zu numbers follow the last cell", name,
                         d->cells_length - at);
    }
    if (records > BTFI_MAX_RECORDS) {
        return btfi_fail(check->log, check->code, "%s: the cells list %zu records, more than %d", name,
                         records, BTFI_MAX_RECORDS);
    }
    return BTF_OK;
}

btf_result btfi_directions_check(const btfi_check *check, const char *name, const btfi_directions *d) {
    btf_result result;
    if ((result = check_unit(check, name, d->count, d->xyz)) || (result = check_vertices(check, name, d)) ||
        (result = check_triangles(check, name, d)) || (result = check_hull(check, name, d)) ||
        (result = check_cells(check, name, d))) {
        return result;
    }
    return BTF_OK;
}

/* The smallest s with x >> s below 2^19. */
static uint32_t record_shift(int64_t x) {
    uint32_t s = 0;
    while (x >> s >= 1 << 19) {
        s++;
    }
    return s;
}

/* One record of the GPU table. */
static void write_record(const btfi_directions *d, uint32_t record, uint16_t out[4 * BTFI_RECORD_TEXELS]) {
    const bool is_edge = record >= d->triangle_count;
    uint32_t i[3];
    if (is_edge) {
        hull_edge(d, record - d->triangle_count, i);
    } else {
        for (int k = 0; k < 3; k++) {
            i[k] = d->triangles[3 * (size_t)record + k];
        }
    }
    point a = vertex(d, i[0]), ab = minus(vertex(d, i[1]), a), ac = minus(vertex(d, i[2]), a);
    uint32_t s = record_shift(is_edge ? dot(ab, ab) : cross(ab, ac));
    for (int k = 0; k < 3; k++) {
        out[2 * k] = d->vertices[2 * i[k]];
        out[2 * k + 1] = d->vertices[2 * i[k] + 1];
    }
    out[6] = (uint16_t)i[2];
    out[7] = (uint16_t)((is_edge ? 1 : 0) + 2 * s);
    out[8] = (uint16_t)i[0];
    out[9] = (uint16_t)i[1];
    out[10] = out[11] = 0;
}

btf_result btfi_directions_make_table(const btf_log *log, btfi_directions *d) {
    const uint32_t n_cells = d->grid * d->grid;
    const size_t records = d->cells_length - n_cells, texels = n_cells + BTFI_RECORD_TEXELS * records;
    d->table_height = (uint32_t)((texels + BTFI_TABLE_WIDTH - 1) / BTFI_TABLE_WIDTH);
    d->table = calloc((size_t)d->table_height * BTFI_TABLE_WIDTH, 4 * sizeof *d->table);
    if (!d->table) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "out of memory for a direction table of %zu texels",
                         texels);
    }
    size_t at = 0, record = 0;
    for (uint32_t c = 0; c < n_cells; c++) {
        uint16_t count = d->cells[at++];
        d->table[4 * (size_t)c] = (uint16_t)record;
        d->table[4 * (size_t)c + 1] = count;
        for (uint16_t i = 0; i < count; i++, record++) {
            write_record(d, d->cells[at++], d->table + 4 * (n_cells + BTFI_RECORD_TEXELS * record));
        }
    }
    return BTF_OK;
}
