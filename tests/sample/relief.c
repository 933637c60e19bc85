/* The reliefs: heights and materials as functions of (x, y), and the tabulation of the heights.
 *
 * SPDX-License-Identifier: MIT
 */
#include "relief.h"

#include "noise.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Height before the highest point is moved to z = 0; any range. */
typedef double (*height_function)(uint32_t seed, double x, double y);
typedef void (*material_function)(uint32_t seed, double x, double y, relief_material *m);

static double clamp(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

static double smoothstep(double low, double high, double x) {
    double t = clamp((x - low) / (high - low), 0, 1);
    return t * t * (3 - 2 * t);
}

/* To [0, 1). */
static double wrap_unit(double x) {
    x -= floor(x);
    return x < 1 ? x : 0;
}

/* albedo = from + t * (to - from), times scale. */
static void blend(double out[3], const double from[3], const double to[3], double t, double scale) {
    for (int c = 0; c < 3; ++c) {
        out[c] = clamp((from[c] + t * (to[c] - from[c])) * scale, 0.01, 1);
    }
}

static void set_gloss(relief_material *m, double r, double g, double b, int exponent) {
    m->gloss[0] = r;
    m->gloss[1] = g;
    m->gloss[2] = b;
    m->exponent = exponent;
}

/* ---- bricks ---- */

enum { COURSES = 4, BRICKS = 2 };
static const double BRICK_DEPTH = 0.10, JOINT = 0.024, BEVEL = 0.022;

typedef struct brick {
    int course, index;
    double x, y;   /* offset from its centre */
    double inside; /* distance to the brick's edge, negative in the joint */
} brick;

static brick brick_at(uint32_t seed, double x, double y) {
    brick b;
    x = wrap_unit(x);
    y = wrap_unit(y);
    double course = floor(y * COURSES);
    b.course = (int)course;
    double along = wrap_unit(x + (b.course & 1 ? 0.5 / BRICKS : 0)) * BRICKS;
    b.index = (int)floor(along);
    b.x = (along - b.index - 0.5) / BRICKS;
    b.y = y - (course + 0.5) / COURSES;
    /* noise displaces the edges a little, and so the bricks differ in size */
    double wander = 0.004 * noise_fractal(seed + 11, x, y, 12, 12, 2);
    double half_x = 0.5 / BRICKS - JOINT + 0.006 * (noise_hash(seed, b.course, b.index, 3) - 0.5);
    double half_y = 0.5 / COURSES - JOINT + 0.006 * (noise_hash(seed, b.course, b.index, 4) - 0.5);
    const double corner = 0.015; /* rounded corners */
    double dx = fabs(b.x) - half_x + corner, dy = fabs(b.y) - half_y + corner;
    double outside = sqrt(fmax(dx, 0) * fmax(dx, 0) + fmax(dy, 0) * fmax(dy, 0));
    b.inside = corner - outside - fmin(fmax(dx, dy), 0) + wander;
    return b;
}

static double bricks_height(uint32_t seed, double x, double y) {
    brick b = brick_at(seed, x, y);
    double mortar = -BRICK_DEPTH + 0.005 * noise_fractal(seed + 1, x, y, 16, 16, 3);
    if (b.inside <= 0) {
        return mortar;
    }
    double t = 1 - fmin(b.inside / BEVEL, 1);
    double profile = sqrt(sqrt(1 - t * t * t * t));
    double top = -0.008 * noise_hash(seed, b.course, b.index, 0);
    double tilt_x = 0.02 * (noise_hash(seed, b.course, b.index, 1) - 0.5);
    double tilt_y = 0.04 * (noise_hash(seed, b.course, b.index, 2) - 0.5);
    double rough = 0.004 * noise_fractal(seed + 2, x, y, 16, 16, 3);
    double pit = 0.006 * smoothstep(0.42, 0.75, noise_gradient(seed + 3, x, y, 22, 22));
    double height = top + b.x * tilt_x + b.y * tilt_y + rough - pit;
    return mortar + (height - mortar) * profile;
}

static void bricks_material(uint32_t seed, double x, double y, relief_material *m) {
    static const double clay[5][3] = {
        {0.58, 0.20, 0.12}, {0.42, 0.14, 0.10}, {0.66, 0.36, 0.20}, {0.34, 0.17, 0.16}, {0.50, 0.27, 0.18}};
    static const double sand[3] = {0.54, 0.51, 0.46}, cement[3] = {0.36, 0.35, 0.34};
    static const double soot[3] = {0.10, 0.08, 0.08};
    brick b = brick_at(seed, x, y);
    double fine = noise_fractal(seed + 4, x, y, 24, 24, 2), broad = noise_fractal(seed + 5, x, y, 6, 6, 2);
    if (b.inside <=
        -0.001) { /* the walls are brick down to the mortar, cells that straddle their foot included */
        blend(m->albedo, cement, sand, clamp(0.5 + 0.8 * broad, 0, 1), 1 + 0.3 * fine);
        set_gloss(m, 0, 0, 0, 1);
        return;
    }
    int colour = (int)(5 * noise_hash(seed, b.course, b.index, 5));
    double shade = 0.72 + 0.4 * noise_hash(seed, b.course, b.index, 6);
    double base[3];
    blend(base, clay[colour], clay[(colour + 1) % 5], clamp(0.4 + 0.9 * broad, 0, 1),
          shade * (1 + 0.25 * fine));
    double stain = smoothstep(0.25, 0.75, noise_gradient(seed + 6, x, y, 11, 11));
    double grain = smoothstep(0.35, 0.6, noise_gradient(seed + 7, x, y, 28, 28));
    blend(m->albedo, base, soot, 0.5 * stain, 1);
    blend(m->albedo, m->albedo, sand, 0.3 * grain, 1);
    double gloss = 0.10 + 0.12 * noise_hash(seed, b.course, b.index, 7);
    set_gloss(m, gloss, gloss, gloss, 9);
}

/* ---- bumps ---- */

enum { PEBBLES = 5 };
static const double PEBBLE_DEPTH = 0.085;

typedef struct pebble {
    int i, j, layer; /* lattice cell, wrapped; i = -1 on the ground between pebbles */
    double height;   /* above the ground */
} pebble;

/* The higher of `best` and one layer's pebbles: one a lattice cell, an ellipsoid of its own size and
 * orientation. Layer 1 lies in the gaps of layer 0: smaller, lower, half a cell off. */
static pebble pebble_layer(uint32_t seed, double x, double y, int layer, pebble best) {
    const double pi = 3.14159265358979323846, largest = layer ? 0.52 : 0.72;
    seed += 50 * (uint32_t)layer;
    double px = wrap_unit(x + 0.5 * layer / PEBBLES) * PEBBLES,
           py = wrap_unit(y + 0.5 * layer / PEBBLES) * PEBBLES;
    int ci = (int)px, cj = (int)py;
    for (int dj = -1; dj <= 1; ++dj) {
        for (int di = -1; di <= 1; ++di) {
            int i = (ci + di + PEBBLES) % PEBBLES, j = (cj + dj + PEBBLES) % PEBBLES;
            double ox = px - (ci + di + 0.5 + 0.7 * (noise_hash(seed, i, j, 0) - 0.5));
            double oy = py - (cj + dj + 0.5 + 0.7 * (noise_hash(seed, i, j, 1) - 0.5));
            if (ox * ox + oy * oy >= largest * largest) {
                continue;
            }
            double angle = pi * noise_hash(seed, i, j, 2), c = cos(angle), s = sin(angle);
            double long_axis = largest * (0.8 + 0.2 * noise_hash(seed, i, j, 3));
            double short_axis = long_axis * (0.68 + 0.28 * noise_hash(seed, i, j, 4));
            double u = (c * ox + s * oy) / long_axis, w = (c * oy - s * ox) / short_axis;
            double q = u * u + w * w;
            if (q >= 1) {
                continue;
            }
            double rise = PEBBLE_DEPTH * (layer ? 0.55 : 0.75) * (1 + 0.33 * noise_hash(seed, i, j, 5));
            double height = rise * sqrt(1 - q);
            if (height > best.height) {
                best = (pebble){i, j, layer, height};
            }
        }
    }
    return best;
}

static pebble pebble_at(uint32_t seed, double x, double y) {
    pebble ground = {-1, -1, 0, 0};
    return pebble_layer(seed, x, y, 1, pebble_layer(seed, x, y, 0, ground));
}

static double bumps_height(uint32_t seed, double x, double y) {
    return pebble_at(seed, x, y).height + 0.0025 * noise_fractal(seed + 1, x, y, 20, 20, 2);
}

static void bumps_material(uint32_t seed, double x, double y, relief_material *m) {
    static const double stone[6][3] = {{0.56, 0.53, 0.48}, {0.24, 0.25, 0.28}, {0.50, 0.33, 0.22},
                                       {0.70, 0.67, 0.62}, {0.33, 0.38, 0.34}, {0.42, 0.22, 0.18}};
    static const double earth[3] = {0.16, 0.12, 0.08}, vein[3] = {0.88, 0.86, 0.82};
    pebble p = pebble_at(seed, x, y);
    double fine = noise_fractal(seed + 2, x, y, 22, 22, 2);
    if (p.i < 0) {
        blend(m->albedo, earth, earth, 0, 1 + 0.6 * fine);
        set_gloss(m, 0, 0, 0, 1);
        return;
    }
    uint32_t own = seed + 50 * (uint32_t)p.layer;
    int colour = (int)(6 * noise_hash(own, p.i, p.j, 6));
    double shade = 0.75 + 0.5 * noise_hash(own, p.i, p.j, 7);
    double band = noise_fractal(seed + 3, x, y, 9, 9, 2) + 0.3 * fine;
    blend(m->albedo, stone[colour], stone[(colour + 1) % 6], clamp(0.5 + 0.7 * band, 0, 1) * 0.5,
          shade * (0.85 + 0.25 * fine));
    if (noise_hash(own, p.i, p.j, 8) < 0.4) {
        blend(m->albedo, m->albedo, vein, smoothstep(0.10, 0.02, fabs(band - 0.1)) * 0.7, 1);
    }
    double gloss = 0.15 + 0.35 * noise_hash(own, p.i, p.j, 9);
    set_gloss(m, gloss, gloss, gloss, 14);
}

/* ---- weave ---- */

enum { THREADS = 8 };
static const double THREAD_RISE = 0.022, THREAD_ROUND = 0.030;

typedef struct thread_point {
    bool warp;            /* along y; else weft, along x */
    int index;            /* which thread */
    double along, across; /* position along it in tiles, across it in -1..1 of its half width */
    double height;
} thread_point;

/* A thread runs along `along`, up and down as a cosine; it is over at the crossings where its index and the
 * other's have equal parity (warp) or unequal parity (weft). */
static thread_point thread_at(uint32_t seed, bool warp, double along, double position) {
    const double pi = 3.14159265358979323846;
    thread_point t = {.warp = warp, .along = along};
    double lane = wrap_unit(position) * THREADS;
    t.index = (int)lane;
    double wobble = 0.06 * noise_gradient(seed + 31 + warp, along, (t.index + 0.5) / THREADS, 10, THREADS);
    double width = 0.90 + 0.08 * noise_hash(seed, t.index, warp, 0);
    t.across = (lane - t.index - 0.5 + wobble) / (0.5 * width);
    double phase = cos(pi * (along * THREADS - 0.5)) * ((t.index & 1) == (warp ? 0 : 1) ? 1 : -1);
    double fibre = 0.0016 * sin(2 * pi * (40 * along + 0.9 * t.across));
    if (fabs(t.across) >= 1) {
        t.height = -1;
    } else {
        t.height = THREAD_RISE * phase + THREAD_ROUND * sqrt(1 - t.across * t.across) + fibre;
    }
    return t;
}

static thread_point weave_at(uint32_t seed, double x, double y) {
    x = wrap_unit(x);
    y = wrap_unit(y);
    thread_point warp = thread_at(seed, true, y, x), weft = thread_at(seed, false, x, y);
    return warp.height >= weft.height ? warp : weft;
}

static double weave_height(uint32_t seed, double x, double y) {
    return fmax(weave_at(seed, x, y).height, -THREAD_RISE - 0.012);
}

static void weave_material(uint32_t seed, double x, double y, relief_material *m) {
    static const double indigo[3] = {0.07, 0.12, 0.34}, navy[3] = {0.10, 0.20, 0.46};
    static const double cream[3] = {0.78, 0.70, 0.54}, ochre[3] = {0.62, 0.42, 0.20};
    const double pi = 3.14159265358979323846;
    thread_point t = weave_at(seed, x, y);
    double fibre = 0.5 + 0.5 * sin(2 * pi * (40 * t.along + 0.9 * t.across));
    double own = noise_hash(seed, t.index, t.warp, 1);
    double worn = noise_fractal(seed + 8, x, y, 12, 12, 3);
    double scale =
        (0.72 + 0.36 * fibre) * (0.85 + 0.3 * noise_hash(seed, t.index, t.warp, 2)) * (1 + 0.3 * worn);
    if (t.warp) {
        blend(m->albedo, indigo, navy, own, scale);
    } else {
        blend(m->albedo, cream, ochre, own * own, scale);
    }
    double gloss = t.warp ? 0.22 : 0.16;
    set_gloss(m, gloss * (0.6 + 0.4 * m->albedo[0]), gloss * (0.6 + 0.4 * m->albedo[1]),
              gloss * (0.6 + 0.4 * m->albedo[2]), 8);
}

/* ---- flat, white ---- */

static double zero_height(uint32_t seed, double x, double y) {
    (void)seed;
    (void)x;
    (void)y;
    return 0;
}

static void flat_material(uint32_t seed, double x, double y, relief_material *m) {
    static const double warm[3] = {0.75, 0.42, 0.18}, cold[3] = {0.16, 0.34, 0.62},
                        pale[3] = {0.85, 0.82, 0.74};
    double broad = noise_fractal(seed + 1, x, y, 5, 5, 3), fine = noise_fractal(seed + 2, x, y, 18, 18, 2);
    blend(m->albedo, warm, cold, smoothstep(-0.25, 0.25, broad), 1 + 0.35 * fine);
    blend(m->albedo, m->albedo, pale, smoothstep(0.3, 0.6, noise_gradient(seed + 3, x, y, 10, 10)), 0.8);
    double gloss = 0.25 + 0.35 * smoothstep(-0.4, 0.4, noise_gradient(seed + 4, x, y, 8, 8));
    int exponent = 6 + (int)(12 * smoothstep(-0.4, 0.4, noise_gradient(seed + 5, x, y, 6, 6)));
    set_gloss(m, gloss * m->albedo[0], gloss * m->albedo[1], gloss * m->albedo[2], exponent);
}

static void white_material(uint32_t seed, double x, double y, relief_material *m) {
    (void)seed;
    (void)x;
    (void)y;
    m->albedo[0] = m->albedo[1] = m->albedo[2] = 1;
    set_gloss(m, 0, 0, 0, 1);
}

/* ---- axes ---- */

static bool on_post(double x, double y) {
    return x >= 29.0 / 64 && x <= 35.0 / 64 && y >= 29.0 / 64 && y <= 35.0 / 64;
}

static double axes_height(uint32_t seed, double x, double y) {
    (void)seed;
    x = wrap_unit(x);
    y = wrap_unit(y);
    double h = -RELIEF_AXES_DEPTH;
    if (on_post(x, y)) {
        h = 0;
    } else if (x >= 51.0 / 64 && x <= 54.0 / 64 && y >= 10.0 / 64 && y <= 32.0 / 64) {
        h = -RELIEF_AXES_DEPTH / 2;
    } else if (x >= 10.0 / 64 && x <= 22.0 / 64 && y >= 42.0 / 64 && y <= 54.0 / 64) {
        h = -RELIEF_AXES_DEPTH * (1 - (y * 64 - 42) / 12 / 2);
    }
    return h;
}

static void axes_material(uint32_t seed, double x, double y, relief_material *m) {
    (void)seed;
    x = wrap_unit(x);
    y = wrap_unit(y);
    double grey = on_post(x, y) ? 0.9 : 0.5;
    m->albedo[0] = m->albedo[1] = m->albedo[2] = grey;
    if (x > 60.0 / 64) {
        m->albedo[1] = m->albedo[2] = 0.1;
    } else if (y > 60.0 / 64) {
        m->albedo[0] = m->albedo[2] = 0.1;
    }
    set_gloss(m, 0, 0, 0, 1);
}

/* ---- all of them ---- */

static const struct {
    height_function height;
    material_function material;
    double ambient;
} RELIEFS[RELIEF_COUNT] = {
    [RELIEF_BRICKS] = {bricks_height, bricks_material, 0.05},
    [RELIEF_BUMPS] = {bumps_height, bumps_material, 0},
    [RELIEF_WEAVE] = {weave_height, weave_material, 0.04},
    [RELIEF_FLAT] = {zero_height, flat_material, 0},
    [RELIEF_WHITE] = {zero_height, white_material, 0},
    [RELIEF_AXES] = {axes_height, axes_material, 0},
};

static const char *const NAMES[RELIEF_COUNT] = {
#define RELIEF_NAME(id, name, text) name,
    RELIEF_LIST(RELIEF_NAME)
#undef RELIEF_NAME
};

relief_kind relief_kind_from_name(const char *name) {
    int k = 0;
    while (k < RELIEF_COUNT && strcmp(NAMES[k], name) != 0) {
        ++k;
    }
    return (relief_kind)k;
}

const char *relief_kind_name(relief_kind kind) {
    assert(kind >= 0 && kind < RELIEF_COUNT);
    return NAMES[kind];
}

void relief_material_at(const relief *r, double x, double y, relief_material *out_material) {
    RELIEFS[r->kind].material(r->seed, x, y, out_material);
}

/* height, its transpose and cell_max from the function; heights end at exactly 0. */
static void tabulate(relief *r, int threads) {
    const int n = r->grid;
    const height_function height = RELIEFS[r->kind].height;
#pragma omp parallel for schedule(dynamic, 16) num_threads(threads)
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            r->height[(size_t)j * n + i] = (float)height(r->seed, (double)i / n, (double)j / n);
        }
    }
    float low = r->height[0], high = r->height[0];
    for (size_t i = 1; i < (size_t)n * n; ++i) {
        low = r->height[i] < low ? r->height[i] : low;
        high = r->height[i] > high ? r->height[i] : high;
    }
    float lowest = 0;
    for (size_t i = 0; i < (size_t)n * n; ++i) {
        r->height[i] -= high;
        lowest = r->height[i] < lowest ? r->height[i] : lowest;
    }
    r->depth = -(double)lowest;
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const float *row = r->height + (size_t)j * n,
                        *next = r->height + (size_t)((j + 1) & (n - 1)) * n;
            int i1 = (i + 1) & (n - 1);
            float a = row[i] > row[i1] ? row[i] : row[i1], b = next[i] > next[i1] ? next[i] : next[i1];
            r->cell_max[(size_t)j * n + i] = a > b ? a : b;
            r->height_transposed[(size_t)i * n + j] = row[i];
        }
    }
}

btf_result relief_create(relief_kind kind, uint32_t seed, int grid, int threads, relief **out_relief) {
    if (kind < 0 || kind >= RELIEF_COUNT || grid < 64 || grid > 4096 || (grid & (grid - 1)) != 0) {
        return BTF_ERROR_USAGE;
    }
    relief *r = calloc(1, sizeof *r);
    if (!r) {
        return BTF_ERROR_MEMORY;
    }
    size_t count = (size_t)grid * (size_t)grid;
    r->kind = kind;
    r->seed = seed;
    r->grid = grid;
    r->ambient = RELIEFS[kind].ambient;
    r->height = malloc(count * sizeof *r->height);
    r->height_transposed = malloc(count * sizeof *r->height_transposed);
    r->cell_max = malloc(count * sizeof *r->cell_max);
    if (!r->height || !r->height_transposed || !r->cell_max) {
        relief_destroy(&r);
        return BTF_ERROR_MEMORY;
    }
    tabulate(r, threads < 1 ? 1 : threads);
    *out_relief = r;
    return BTF_OK;
}

void relief_destroy(relief **r) {
    if (!r || !*r) {
        return;
    }
    free((*r)->height);
    free((*r)->height_transposed);
    free((*r)->cell_max);
    free(*r);
    *r = NULL;
}
