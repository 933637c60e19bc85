/* Visibility by walking the cells of a periodic bilinear height field; shadows by one sweep a light.
 *
 * SPDX-License-Identifier: MIT
 */
#include "raycast.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A bilinear patch: h(u, w) = h + a u + b w + c u w for u, w in [0, 1] of the cell. */
typedef struct patch {
    double h, a, b, c;
} patch;

static patch patch_at(const relief *r, int i, int j) {
    const int n = r->grid, mask = n - 1;
    const float *row = r->height + (size_t)(j & mask) * n, *next = r->height + (size_t)((j + 1) & mask) * n;
    double h00 = row[i & mask], h10 = row[(i + 1) & mask], h01 = next[i & mask], h11 = next[(i + 1) & mask];
    return (patch){h00, h10 - h00, h01 - h00, h11 - h10 - h01 + h00};
}

/* The smallest t of [t0, t1] where q2 t^2 + q1 t + q0 reaches 0 from below, or a negative number. */
static double first_root(double q2, double q1, double q0, double t0, double t1) {
    double f0 = (q2 * t0 + q1) * t0 + q0;
    if (f0 >= 0) {
        return t0;
    }
    double roots[2];
    int count = 0;
    if (q2 == 0) {
        if (q1 != 0) {
            roots[count++] = -q0 / q1;
        }
    } else {
        double discriminant = q1 * q1 - 4 * q2 * q0;
        if (discriminant >= 0) {
            double s = -0.5 * (q1 + copysign(sqrt(discriminant), q1));
            if (s != 0) {
                roots[count++] = q0 / s;
            }
            roots[count++] = s / q2;
        }
    }
    double best = -1;
    for (int k = 0; k < count; ++k) {
        if (roots[k] >= t0 && roots[k] <= t1 && (best < 0 || roots[k] < best)) {
            best = roots[k];
        }
    }
    if (best < 0 && (q2 * t1 + q1) * t1 + q0 >= 0) {
        best = t1; /* crossed within rounding of the far end */
    }
    return best;
}

raycast_hit raycast_view(const relief *r, double x, double y, const double v[3]) {
    assert(v[2] > 0);
    const int n = r->grid, mask = n - 1;
    /* The ray at depth t >= 0 below z = 0, in cells: (gx + sx t, gy + sy t). */
    const double gx = x * n, gy = y * n, sx = -v[0] / v[2] * n, sy = -v[1] / v[2] * n;
    const int step_x = sx > 0 ? 1 : -1, step_y = sy > 0 ? 1 : -1;
    int i = (int)floor(gx), j = (int)floor(gy);
    /* Where the ray crosses the next column and row, and how far apart it crosses them. */
    double next_x = sx != 0 ? (i + (sx > 0) - gx) / sx : INFINITY,
           gap_x = sx != 0 ? fabs(1 / sx) : INFINITY;
    double next_y = sy != 0 ? (j + (sy > 0) - gy) / sy : INFINITY,
           gap_y = sy != 0 ? fabs(1 / sy) : INFINITY;
    double t = 0, hit = -1;
    patch p = {0, 0, 0, 0};
    while (true) {
        double exit = fmin(fmin(next_x, next_y), r->depth);
        if (exit < t) {
            exit = t;
        }
        if (r->cell_max[(size_t)(j & mask) * n + (i & mask)] >= -exit) {
            p = patch_at(r, i, j);
            double u = gx - i, w = gy - j;
            double q0 = p.h + p.a * u + p.b * w + p.c * u * w;
            double q1 = p.a * sx + p.b * sy + p.c * (u * sy + w * sx) + 1;
            hit = first_root(p.c * sx * sy, q1, q0, t, exit);
        }
        if (hit >= 0) {
            break;
        }
        if (exit >= r->depth) { /* at the lowest height, and so at the surface, within rounding */
            p = patch_at(r, i, j);
            hit = exit;
            break;
        }
        t = exit;
        if (next_x <= next_y) {
            i += step_x;
            next_x += gap_x;
        } else {
            j += step_y;
            next_y += gap_y;
        }
    }
    double px = gx + sx * hit, py = gy + sy * hit;
    double slope_x = (p.a + p.c * (py - j)) * n, slope_y = (p.b + p.c * (px - i)) * n;
    double scale = 1 / sqrt(1 + slope_x * slope_x + slope_y * slope_y);
    return (raycast_hit){{px / n, py / n, -hit}, {-slope_x * scale, -slope_y * scale, scale}};
}

/* One line of heights, twice over so that reading across the end needs no wrapping. */
static void unroll(const float *line, int n, float *out) {
    memcpy(out, line, (size_t)n * sizeof *out);
    memcpy(out + n, line, (size_t)n * sizeof *out);
    out[2 * n] = line[0];
}

btf_result raycast_shadow_create(const relief *r, const double l[3], raycast_shadow *out_shadow) {
    assert(l[2] > 0);
    const int n = r->grid, mask = n - 1;
    const bool along_x = fabs(l[0]) > fabs(l[1]);
    const double major = along_x ? l[0] : l[1], minor = along_x ? l[1] : l[0];
    *out_shadow = (raycast_shadow){.grid = n, .transposed = along_x};
    if (r->depth <= 0 || fabs(major) < 1e-9) {
        out_shadow->none = true;
        return BTF_OK;
    }
    out_shadow->low = -1.25 * r->depth;
    out_shadow->step = 1.25 * r->depth / 65535;
    /* A step leads one line along the major axis towards the light; lines are numbered so that the light is
     * at +. Line j of the sweep goes through node j of line 0, and through j + k * drift of line k. */
    const int direction = major > 0 ? 1 : -1;
    const double drift = minor / fabs(major), drop = l[2] / fabs(major) / n;
    const float *heights = along_x ? r->height_transposed : r->height;
    const int warm_up =
        (int)ceil(r->depth / drop) + 1; /* the relief beyond these lines is too low to cast a shadow here */
    float *unrolled = malloc((2 * (size_t)n + 1) * sizeof *unrolled);
    float *shadow = malloc((2 * (size_t)n + 1) * sizeof *shadow);
    out_shadow->height = malloc((size_t)n * (size_t)n * sizeof *out_shadow->height);
    if (!unrolled || !shadow || !out_shadow->height) {
        free(unrolled);
        free(shadow);
        raycast_shadow_destroy(out_shadow);
        return BTF_ERROR_MEMORY;
    }
    for (int j = 0; j < n; ++j) {
        shadow[j] = (float)(-2 * r->depth - drop);
    }
    const float fall = (float)drop, low = (float)out_shadow->low, scale = (float)(1 / out_shadow->step);
    for (int k = n + warm_up - 1; k >= 0; --k) {
        /* shadow := the shadow's height at line k, from the one at line k + 1 and the relief there. */
        double offset = (k + 1) * drift;
        int whole = (int)floor(offset);
        float part = (float)(offset - whole);
        unroll(heights + (size_t)((direction * (k + 1)) & mask) * n, n, unrolled);
        const float *line = unrolled + (whole & mask);
        for (int j = 0; j < n; ++j) {
            float h = line[j] + part * (line[j + 1] - line[j]);
            shadow[j] = (h > shadow[j] ? h : shadow[j]) - fall;
        }
        if (k >= n) {
            continue;
        }
        memcpy(shadow + n, shadow, (size_t)n * sizeof *shadow);
        shadow[2 * n] = shadow[0];
        offset = -k * drift;
        whole = (int)floor(offset);
        part = (float)(offset - whole);
        const float *source = shadow + (whole & mask);
        uint16_t *out = out_shadow->height + (size_t)((direction * k) & mask) * n;
        for (int j = 0; j < n; ++j) {
            float s = source[j] + part * (source[j + 1] - source[j]) - low;
            out[j] = s <= 0 ? 0 : (uint16_t)(s * scale + 0.5f);
        }
    }
    free(unrolled);
    free(shadow);
    return BTF_OK;
}

void raycast_shadow_destroy(raycast_shadow *shadow) {
    if (!shadow) {
        return;
    }
    free(shadow->height);
    shadow->height = NULL;
}

bool raycast_lit(const raycast_shadow *shadow, const double position[3]) {
    if (shadow->none) {
        return true;
    }
    const int n = shadow->grid, mask = n - 1;
    double gx = position[shadow->transposed ? 1 : 0] * n, gy = position[shadow->transposed ? 0 : 1] * n;
    double fx = floor(gx), fy = floor(gy);
    int i = (int)fx & mask, j = (int)fy & mask;
    double u = gx - fx, w = gy - fy;
    const uint16_t *row = shadow->height + (size_t)j * n,
                   *next = shadow->height + (size_t)((j + 1) & mask) * n;
    int i1 = (i + 1) & mask;
    double near = row[i] + u * ((int)row[i1] - (int)row[i]),
           far = next[i] + u * ((int)next[i1] - (int)next[i]);
    return position[2] >= shadow->low + shadow->step * (near + w * (far - near));
}
