/* Direction lists: triangulation, hull, look-up grid and GPU table, against brute force and geometry.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/reference.h>
#include "decoder/directions.h"
#include "decoder/reach.h"
#include "tests/support/random_material.h"
#include "tests/support/test.h"

enum { END = 16384 };

/* A material of one texel whose views are the list. */
static btf_material *with_views(uint32_t count, const float *xyz) {
    random_state r = {count};
    btf_material_desc desc = random_material_desc(1, 1, 1, 1, BTF_LAYOUT_TIGHT, 0);
    const float *spare = desc.views;
    random_material_fill(&r, &desc);
    desc.info.n_views = count;
    desc.views = xyz;
    btf_material *material = NULL;
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    desc.views = spare;
    random_material_free(&desc);
    return material;
}

typedef struct vec {
    int64_t x, y;
} vec;

static vec at(const btf_directions *d, uint32_t i) {
    return (vec){d->vertices[2 * i], d->vertices[2 * i + 1]};
}

static vec sub(vec a, vec b) {
    return (vec){a.x - b.x, a.y - b.y};
}

static int64_t cross(vec a, vec b) {
    return a.x * b.y - a.y * b.x;
}

static int64_t dot(vec a, vec b) {
    return a.x * b.x + a.y * b.y;
}

static int shift_of(int64_t a) {
    int s = 0;
    while (a >> s >= 1 << 19) {
        s++;
    }
    return s;
}

/* The look-up of FORMAT.md section 6 over one record; returns false when it does not accept. */
static bool look_up_record(const btf_directions *d, uint32_t record, vec q, btf_ref_neighbours *out) {
    if (record < d->triangle_count) {
        const uint16_t *t = d->triangles + 3 * record;
        vec a = at(d, t[0]), b = at(d, t[1]), c = at(d, t[2]);
        int64_t area = cross(sub(b, a), sub(c, a));
        int64_t e0 = cross(sub(b, q), sub(c, q)), e1 = cross(sub(c, q), sub(a, q)),
                e2 = cross(sub(a, q), sub(b, q));
        if (e0 < 0 || e1 < 0 || e2 < 0) {
            return false;
        }
        int s = shift_of(area);
        uint32_t w0 = (uint32_t)(((e0 >> s) << 12) / (area >> s)),
                 w1 = (uint32_t)(((e1 >> s) << 12) / (area >> s));
        *out = (btf_ref_neighbours){{t[0], t[1], t[2]}, {w0, w1, 4096 - w0 - w1}};
        return true;
    }
    uint32_t h = record - d->triangle_count, n = d->hull_count;
    uint32_t ia = d->hull[h], ib = d->hull[(h + 1) % n], ic = d->hull[(h + 2) % n];
    vec a = at(d, ia), b = at(d, ib), c = at(d, ic);
    int64_t t = dot(sub(q, a), sub(b, a)), length = dot(sub(b, a), sub(b, a));
    if (t >= 0 && t <= length && cross(sub(b, a), sub(q, a)) <= 0) {
        int s = shift_of(length);
        uint32_t w1 = (uint32_t)(((t >> s) << 12) / (length >> s));
        *out = (btf_ref_neighbours){{ia, ib, ia}, {4096 - w1, w1, 0}};
        return true;
    }
    if (t >= length && dot(sub(q, b), sub(c, b)) <= 0) {
        *out = (btf_ref_neighbours){{ib, ib, ib}, {4096, 0, 0}};
        return true;
    }
    return false;
}

/* The look-up over all records, without the grid. */
static btf_ref_neighbours look_up_all(const btf_directions *d, vec q) {
    btf_ref_neighbours out = {{0, 0, 0}, {4096, 0, 0}};
    for (uint32_t record = 0; record < d->triangle_count + d->hull_count; record++) {
        if (look_up_record(d, record, q, &out)) {
            break;
        }
    }
    return out;
}

/* The look-up through the grid of the header. */
static btf_ref_neighbours look_up_cell(const btf_directions *d, const size_t *starts, vec q) {
    uint32_t g = d->grid;
    uint32_t cx = (uint32_t)(q.x < 16383 ? q.x : 16383) * g >> 14,
             cy = (uint32_t)(q.y < 16383 ? q.y : 16383) * g >> 14;
    const uint16_t *cell = d->cells + starts[cy * g + cx];
    btf_ref_neighbours out = {{0, 0, 0}, {4096, 0, 0}};
    for (uint32_t i = 1; i <= cell[0]; i++) {
        if (look_up_record(d, cell[i], q, &out)) {
            break;
        }
    }
    return out;
}

static void cell_starts(const btf_directions *d, size_t starts[64 * 64]) {
    size_t position = 0;
    for (uint32_t c = 0; c < d->grid * d->grid; c++) {
        starts[c] = position;
        position += 1u + d->cells[position];
    }
    assert_int_equal(position, d->cells_length);
}

/* The point that the weights stand for. */
static void weighted(const btf_directions *d, const btf_ref_neighbours *n, double out[2]) {
    out[0] = out[1] = 0;
    for (int i = 0; i < 3; i++) {
        vec p = at(d, n->index[i]);
        out[0] += (double)n->weight[i] / 4096 * (double)p.x;
        out[1] += (double)n->weight[i] / 4096 * (double)p.y;
    }
}

/* The point of the hull, its inside included, that is nearest to q. */
static void nearest(const btf_directions *d, vec q, double out[2]) {
    double best = INFINITY;
    bool inside = d->triangle_count > 0;
    for (uint32_t h = 0; h < d->hull_count; h++) {
        vec a = at(d, d->hull[h]), b = at(d, d->hull[(h + 1) % d->hull_count]), ab = sub(b, a);
        inside = inside && cross(ab, sub(q, a)) >= 0;
        double t = (double)dot(sub(q, a), ab) / (double)dot(ab, ab);
        t = t < 0 ? 0 : t > 1 ? 1 : t;
        double x = (double)a.x + t * (double)ab.x, y = (double)a.y + t * (double)ab.y;
        double distance = hypot(x - (double)q.x, y - (double)q.y);
        if (distance < best) {
            best = distance;
            out[0] = x;
            out[1] = y;
        }
    }
    if (d->hull_count == 0) {
        out[0] = d->vertices[0];
        out[1] = d->vertices[1];
    }
    if (inside) {
        out[0] = (double)q.x;
        out[1] = (double)q.y;
    }
}

/* The longest edge: one step of a weight moves the weighted point by at most a 4096th of it. */
static double longest_edge(const btf_directions *d) {
    double longest = 0;
    for (uint32_t t = 0; t < d->triangle_count; t++) {
        for (int k = 0; k < 3; k++) {
            vec e = sub(at(d, d->triangles[3 * t + (uint32_t)k]),
                        at(d, d->triangles[3 * t + (uint32_t)(k + 1) % 3]));
            longest = fmax(longest, sqrt((double)dot(e, e)));
        }
    }
    for (uint32_t h = 0; h < d->hull_count; h++) {
        vec e = sub(at(d, d->hull[h]), at(d, d->hull[(h + 1) % d->hull_count]));
        longest = fmax(longest, sqrt((double)dot(e, e)));
    }
    return longest;
}

/* Directions under test. */
typedef struct list {
    btf_directions d;
    const uint16_t *table;
    size_t starts[64 * 64]; /* of the cells */
    bool straight;          /* see has_straight_corner */
} list;

/* Whether a corner of the hull lies on a straight side. Its record accepts a whole line across the hull, also beyond
 * the other side, where cells do not list it: then a look-up over all records differs, and the cells' answer is
 * right. */
static bool has_straight_corner(const btf_directions *d) {
    bool found = false;
    for (uint32_t h = 0; d->triangle_count > 0 && h < d->hull_count; h++) {
        vec a = at(d, d->hull[h]), b = at(d, d->hull[(h + 1) % d->hull_count]),
            c = at(d, d->hull[(h + 2) % d->hull_count]);
        found = found || cross(sub(b, a), sub(c, b)) == 0;
    }
    return found;
}

/* Everything that must hold at one q. */
static void check_point(const list *l, vec q) {
    const btf_directions *d = &l->d;
    btf_ref_neighbours cell = look_up_cell(d, l->starts, q);
    const int32_t q32[2] = {(int32_t)q.x, (int32_t)q.y};
    btf_ref_neighbours gpu = btf_ref_lookup(l->table, d->grid, q32);
    assert_memory_equal(&gpu, &cell, sizeof gpu);
    if (!l->straight) {
        btf_ref_neighbours all = look_up_all(d, q);
        assert_memory_equal(&gpu, &all, sizeof gpu);
    }
    assert_int_equal(gpu.weight[0] + gpu.weight[1] + gpu.weight[2], 4096);
    for (int i = 0; i < 3; i++) {
        assert_true(gpu.weight[i] <= 4096 && gpu.index[i] < d->count);
    }
    double have[2], want[2];
    weighted(d, &gpu, have);
    nearest(d, q, want);
    /* two weights rounded down, each after a shift that keeps at least 18 bits */
    double tolerance = 2.1 * longest_edge(d) / 4096 + 1e-6;
    assert_true(hypot(have[0] - want[0], have[1] - want[1]) <= tolerance);
}

static void check_delaunay(const btf_directions *d) {
    int64_t sum = 0, hull = 0;
    for (uint32_t t = 0; t < d->triangle_count; t++) {
        const uint16_t *i = d->triangles + 3 * t;
        vec a = at(d, i[0]), b = at(d, i[1]), c = at(d, i[2]);
        int64_t area = cross(sub(b, a), sub(c, a));
        assert_true(area > 0);
        sum += area;
        for (uint32_t k = 0; k < d->count; k++) {
            vec p = at(d, k), u = sub(a, p), v = sub(b, p), w = sub(c, p);
            int64_t in = dot(u, u) * cross(v, w) + dot(v, v) * cross(w, u) + dot(w, w) * cross(u, v);
            assert_true(in <= 0);
        }
    }
    for (uint32_t h = 0; h < d->hull_count; h++) {
        hull += cross(at(d, d->hull[h]), at(d, d->hull[(h + 1) % d->hull_count]));
    }
    assert_int_equal(sum, hull); /* the triangles fill the hull */
}

/* At vertex i and around it. */
static void check_vertex(const list *l, uint32_t i) {
    const btf_directions *d = &l->d;
    int32_t q[2];
    btf_ref_project(d->xyz + 3 * i, q);
    assert_int_equal(q[0], d->vertices[2 * i]);
    assert_int_equal(q[1], d->vertices[2 * i + 1]);
    btf_ref_neighbours n = look_up_cell(d, l->starts, at(d, i));
    for (int k = 0; k < 3; k++) {
        assert_true(n.weight[k] == (n.index[k] == i && n.weight[k] ? 4096 : 0));
    }
    for (int dy = -1; dy <= 1; dy++) {
        for (int dx = -1; dx <= 1; dx++) {
            vec near = {d->vertices[2 * i] + dx, d->vertices[2 * i + 1] + dy};
            if (near.x >= 0 && near.x <= END && near.y >= 0 && near.y <= END) {
                check_point(l, near);
            }
        }
    }
}

/* Checks directions and their table, prints what they are, and finds the cells. */
static void check_shape(const char *name, list *l, uint32_t table_height) {
    const btf_directions *d = &l->d;
    cell_starts(d, l->starts);
    size_t records = d->cells_length - d->grid * d->grid;
    assert_true(records <= 65535);
    assert_int_equal(table_height, (d->grid * d->grid + 3 * records + 255) / 256);
    print_message("%s: %u triangles, hull %u, grid %u, %.2f records a cell\n", name,
                  (unsigned)d->triangle_count, (unsigned)d->hull_count, (unsigned)d->grid,
                  (double)records / (d->grid * d->grid));
    check_delaunay(d);
}

/* Checks the middle of every `every`th edge of the hull, and a lattice of points `step` apart. */
static void check_plane(const list *l, uint32_t every, int step) {
    const btf_directions *d = &l->d;
    for (uint32_t h = 0; h < d->hull_count; h += every) {
        vec a = at(d, d->hull[h]), b = at(d, d->hull[(h + 1) % d->hull_count]);
        check_point(l, (vec){(a.x + b.x) / 2, (a.y + b.y) / 2});
    }
    for (int64_t y = 0; y <= END; y += step) {
        for (int64_t x = y * 7 % step; x <= END; x += step) {
            check_point(l, (vec){x, y});
        }
    }
}

/* Checks a list of directions; q on a lattice of `step`, at every vertex and its neighbourhood, on edges. */
static void check_list(const char *name, uint32_t count, const float *xyz, int step) {
    btf_material *material = with_views(count, xyz);
    btf_texture table = btf_material_texture(material, BTF_TEXTURE_VIEW_TABLE);
    list l = {.d = btf_material_views(material), .table = table.data};
    assert_int_equal(l.d.count, count);
    assert_int_equal(table.format, BTF_FORMAT_RGBA16UI);
    assert_int_equal(table.width, 256);
    check_shape(name, &l, table.height);
    for (uint32_t i = 0; i < count; i++) {
        check_vertex(&l, i);
    }
    check_plane(&l, 1, step);
    for (int64_t x = 0; x <= END; x += 64) { /* along the borders of the plane and of cells */
        for (int64_t border = 0; border <= END; border += 4096) {
            check_point(&l, (vec){x, border});
            check_point(&l, (vec){border, x});
            if (border > 0) {
                check_point(&l, (vec){x, border - 1});
            }
        }
    }
    btf_material_close(&material);
}

/* A list that no material of version 1 may have, built as the library builds it: the same checks, at
 * fewer points, and btfi_lookup beside the table. */
static void check_many(const char *name, uint32_t count, const float *xyz, uint32_t every, int step) {
    btfi_directions made;
    assert_int_equal(btfi_directions_build(&(btfi_check){NULL, BTF_ERROR_USAGE}, name, count, xyz, &made),
                     BTF_OK);
    assert_int_equal(btfi_directions_check(&(btfi_check){NULL, BTF_ERROR_USAGE}, name, &made), BTF_OK);
    list l = {.table = made.table};
    l.d = (btf_directions){.count = made.count,
                           .xyz = made.xyz,
                           .vertices = made.vertices,
                           .triangle_count = made.triangle_count,
                           .triangles = made.triangles,
                           .hull_count = made.hull_count,
                           .hull = made.hull,
                           .grid = made.grid,
                           .cells = made.cells,
                           .cells_length = made.cells_length};
    check_shape(name, &l, made.table_height);
    l.straight = has_straight_corner(&l.d);
    for (uint32_t i = 0; i < count; i += every) {
        check_vertex(&l, i);
        uint32_t index[3], weight[3];
        const int32_t q[2] = {made.vertices[2 * i], made.vertices[2 * i + 1]};
        const btf_ref_neighbours n = btf_ref_lookup(made.table, made.grid, q);
        btfi_lookup(&made, xyz + 3 * i, index, weight);
        assert_memory_equal(index, n.index, sizeof index);
        assert_memory_equal(weight, n.weight, sizeof weight);
    }
    check_plane(&l, every, step);
    btfi_directions_clear(&made);
}

TEST(test_measured_sets) {
    float ubo2003[81][3], ubo2014[151][3];
    random_ubo2003(ubo2003);
    random_ubo2014(ubo2014);
    check_list("UBO2003", 81, ubo2003[0], 149);
    check_list("UBO2014", 151, ubo2014[0], 211);
}

TEST(test_random_sets) {
    random_state r = {11};
    static const uint32_t counts[] = {3, 4, 5, 9, 50, 256};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        float xyz[256 * 3];
        char name[32];
        random_directions(&r, counts[i], i % 2 ? 89.9 : 60, xyz);
        snprintf(name, sizeof name, "%u random", (unsigned)counts[i]);
        check_list(name, counts[i], xyz, 293);
    }
}

TEST(test_regular_sets) {
    static const uint32_t counts[] = {7, 19, 37, 91, 217, 256};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        float xyz[256 * 3];
        char name[32];
        random_rings(counts[i], 85, xyz);
        snprintf(name, sizeof name, "%u in rings", (unsigned)counts[i]);
        check_list(name, counts[i], xyz, 293);
    }
}

TEST(test_one_and_two) {
    const float one[3] = {0.6f, 0, 0.8f}, two[2][3] = {{0, 0, 1}, {0.48f, 0.64f, 0.6f}};
    check_list("one", 1, one, 331);
    check_list("two", 2, two[0], 331);
}

TEST(test_collinear) {
    float line[9][3], slanted[5][3];
    static const int order[9] = {4, 3, 5, 2, 6, 1, 7, 0, 8};
    for (int i = 0; i < 9; i++) {
        double angle = (order[i] - 4) * 0.3;
        line[i][0] = (float)sin(angle);
        line[i][1] = 0;
        line[i][2] = (float)cos(angle);
    }
    for (int i = 0; i < 5; i++) {
        double angle = (i - 2) * 0.5;
        slanted[i][0] = slanted[i][1] = (float)(sin(angle) * sqrt(0.5));
        slanted[i][2] = (float)cos(angle);
    }
    check_list("collinear", 9, line[0], 331);
    check_list("collinear, slanted", 5, slanted[0], 331);

    btf_material *material = with_views(9, line[0]);
    btf_directions d = btf_material_views(material);
    assert_int_equal(d.triangle_count, 0);
    assert_int_equal(d.hull_count, 16); /* the hull of a line goes there and back */
    btf_material_close(&material);

    float corner[4][3]; /* three on a line and one beside it: the middle one is on the hull, too */
    memcpy(corner, line, sizeof(float[3][3]));
    corner[3][0] = 0;
    corner[3][1] = 0.6f;
    corner[3][2] = 0.8f;
    check_list("three on a line", 4, corner[0], 331);
}

/* Of co-circular points the triangulation takes the diagonal that holds the smallest index. */
TEST(test_cocircular) {
    static const float square[4][3] = {
        {0.6f, 0, 0.8f}, {0, 0.6f, 0.8f}, {-0.6f, 0, 0.8f}, {0, -0.6f, 0.8f}};
    for (int first = 0; first < 4; first++) {
        float xyz[4][3];
        for (int i = 0; i < 4; i++) {
            memcpy(xyz[i], square[(i * 3 + first) % 4], sizeof xyz[i]);
        }
        btf_material *material = with_views(4, xyz[0]);
        btf_directions d = btf_material_views(material);
        assert_int_equal(d.triangle_count, 2);
        for (uint32_t t = 0; t < 2; t++) { /* both triangles begin with index 0, so the diagonal holds it */
            assert_int_equal(d.triangles[3 * t], 0);
        }
        btf_material_close(&material);
        check_list("square", 4, xyz[0], 331);
    }
    float octagon[8][3];
    static const float pattern[8][2] = {{0.48f, 0.36f},  {0.36f, 0.48f},   {-0.36f, 0.48f},
                                        {-0.48f, 0.36f}, {-0.48f, -0.36f}, {-0.36f, -0.48f},
                                        {0.36f, -0.48f}, {0.48f, -0.36f}};
    for (int i = 0; i < 8; i++) {
        octagon[i][0] = pattern[i * 3 % 8][0];
        octagon[i][1] = pattern[i * 3 % 8][1];
        octagon[i][2] = 0.8f;
    }
    btf_material *material = with_views(8, octagon[0]);
    btf_directions d = btf_material_views(material);
    assert_int_equal(d.triangle_count, 6);
    for (uint32_t t = 0; t < 6; t++) {
        assert_int_equal(d.triangles[3 * t], 0); /* a fan */
    }
    btf_material_close(&material);
    check_list("octagon", 8, octagon[0], 331);
}

/* Moving q by one step moves the weighted point by little more than a step, also across edges and beyond the hull. */
TEST(test_continuity) {
    float xyz[81][3];
    random_ubo2003(xyz);
    btf_material *material = with_views(81, xyz[0]);
    btf_directions d = btf_material_views(material);
    btf_texture table = btf_material_texture(material, BTF_TEXTURE_VIEW_TABLE);
    const double rounding = 4.2 * longest_edge(&d) / 4096;
    for (int32_t y = 5; y <= END; y += 997) {
        double before[2] = {0, 0};
        for (int32_t x = 0; x <= END; x++) {
            const int32_t q[2] = {x, y};
            btf_ref_neighbours n = btf_ref_lookup(table.data, d.grid, q);
            double now[2];
            weighted(&d, &n, now);
            assert_true(x == 0 || hypot(now[0] - before[0], now[1] - before[1]) <= 1 + rounding);
            before[0] = now[0];
            before[1] = now[1];
        }
    }
    btf_material_close(&material);
}

TEST(test_projection) {
    random_state r = {12};
    const float pole[3] = {0, 0, 1}, edge[3] = {1, 0, 0x1p-24f},
                corner[3] = {-0.70710678f, -0.70710678f, 0x1p-24f};
    btf_material *material = with_views(1, pole);
    assert_int_equal(btf_material_views(material).vertices[0], 8192);
    assert_int_equal(btf_material_views(material).vertices[1], 8192);
    btf_material_close(&material);
    material = with_views(1, edge);
    assert_int_equal(btf_material_views(material).vertices[0], 16384);
    btf_material_close(&material);
    material = with_views(1, corner);
    assert_int_equal(btf_material_views(material).vertices[0], 2399); /* 8192 - 5792.6 */
    btf_material_close(&material);
    for (int i = 0; i < 40; i++) {
        float xyz[256 * 3];
        random_directions(&r, 256, 90, xyz);
        material = with_views(256, xyz);
        for (uint32_t k = 0; k < 256; k++) {
            for (int c = 0; c < 2; c++) {
                double exact =
                    (double)xyz[3 * k + (uint32_t)c] / (1 + (double)xyz[3 * k + 2]) * 8192 + 8192;
                assert_true(fabs(btf_material_views(material).vertices[2 * k + (uint32_t)c] - exact) <=
                            0.51);
            }
        }
        btf_material_close(&material);
    }
}

/* Directions whose vertices are those of the plane given; distinct, since the plane's units are. */
static void direction_at(double x, double y, float out[3]) {
    const double px = (x - 8192) / 8192, py = (y - 8192) / 8192, r = px * px + py * py;
    out[0] = (float)(2 * px / (1 + r));
    out[1] = (float)(2 * py / (1 + r));
    out[2] = (float)((1 - r) / (1 + r));
}

TEST(test_many) {
    random_state r = {13};
    static float xyz[BTF_MAX_DIRECTIONS * 3];
    random_directions(&r, 300, 60, xyz);
    check_many("300 random", 300, xyz, 1, 293);
    random_directions(&r, 1000, 89.9, xyz);
    check_many("1000 random", 1000, xyz, 1, 211);
    random_rings(1000, 85, xyz);
    check_many("1000 in rings", 1000, xyz, 3, 293);
    random_directions(&r, BTF_MAX_DIRECTIONS, 89.9, xyz);
    check_many("4096 random", BTF_MAX_DIRECTIONS, xyz, 15, 293);
}

/* The same on a lattice, where all is co-circular, within a triangle; on one ring, nearly all of it hull;
 * on a line, there and back. The edges of the last two reach over so many cells that grids are coarser. */
TEST(test_many_of_a_kind) {
    enum { COUNT = BTF_MAX_DIRECTIONS };
    static float xyz[COUNT * 3];
    for (int i = 0; i < COUNT - 3; i++) {
        direction_at(8192 + 120 * (i % 64 - 32), 8192 + 120 * (i / 64 - 32), xyz + 3 * i);
    }
    for (int i = 0; i < 3; i++) {
        const double phi = 0.3 + 2 * 3.14159265358979323846 * i / 3;
        direction_at(8192 + 8191 * cos(phi), 8192 + 8191 * sin(phi), xyz + 3 * (COUNT - 3 + i));
    }
    check_many("a lattice of 4096", COUNT, xyz, 31, 491);
    for (int i = 0; i < COUNT; i++) {
        const double phi = 2 * 3.14159265358979323846 * i / COUNT;
        direction_at(8192 + 8000 * cos(phi), 8192 + 8000 * sin(phi), xyz + 3 * i);
    }
    check_many("a ring of 4096", COUNT, xyz, 31, 491);
    for (int i = 0; i < COUNT; i++) {
        direction_at(4 * (i < COUNT / 2 ? COUNT / 2 + i : COUNT - 1 - i) + 2, 8192, xyz + 3 * i);
    }
    check_many("a line of 4096", COUNT, xyz, 31, 991);
}

RUN_TESTS(NULL, NULL)
