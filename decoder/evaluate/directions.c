/* Light and view of an evaluation. See directions.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "directions.h"

#include "exact.h"

enum { RECORD = 12 }; /* numbers of a record in a direction table: three texels */

/* Section 9, Directions. */
static bool above_horizon(const float light[3], const float view[3]) {
    uint32_t most = 0;
    for (int i = 0; i < 3; i++) {
        const uint32_t l = btfi_bits(light[i]) & 0x7FFFFFFFu, v = btfi_bits(view[i]) & 0x7FFFFFFFu;
        most = l > most ? l : most;
        most = v > most ? v : most;
    }
    return most <= 0x40000000u && light[2] >= 0x1p-24f && view[2] >= 0x1p-24f;
}

static int32_t plane_coordinate(float component, float k) {
    float q = component * k * 8192.0f + 0.5f;
    q = q >= -8192.0f ? q : -8192.0f;
    q = q <= 8192.0f ? q : 8192.0f;
    return btfi_floor(q) + 8192;
}

static int32_t cross(int32_t px, int32_t py, int32_t qx, int32_t qy) {
    return px * qy - py * qx;
}

static int32_t fraction(int32_t part, int32_t whole, uint32_t shift) {
    return (int32_t)(((uint32_t)part >> shift << 12) / ((uint32_t)whole >> shift));
}

/* Keeps those of three neighbours whose weight is not 0, or, unless `linear`, that of the greatest weight
 * alone. */
static void keep(bool linear, const uint32_t index[3], const int32_t weight[3], btfi_neighbours *out) {
    if (!linear) {
        int best = 0;
        for (int i = 1; i < 3; i++) {
            best = weight[i] > weight[best] ? i : best;
        }
        *out = (btfi_neighbours){1, {index[best], index[best], index[best]}, {4096, 0, 0}, {0}};
        return;
    }
    int count = 0;
    for (int i = 0; i < 3; i++) {
        if (weight[i] == 0) {
            continue;
        }
        out->index[count] = index[i];
        out->place[count] = (uint8_t)i;
        out->weight[count++] = weight[i];
    }
    out->count = count;
    for (; count < 3; count++) {
        out->index[count] = out->index[0];
        out->place[count] = 0;
        out->weight[count] = 0;
    }
}

/* Section 6, the look-up of q = k d.xy. */
static void look_up(const uint16_t *table, uint32_t grid, bool linear, const float d[3], float k,
                    btfi_neighbours *out) {
    const int32_t x = plane_coordinate(d[0], k), y = plane_coordinate(d[1], k);
    const uint32_t cell_x = (uint32_t)(x < 16383 ? x : 16383) * grid >> 14,
                   cell_y = (uint32_t)(y < 16383 ? y : 16383) * grid >> 14;
    const uint16_t *cell = table + 4 * (cell_y * grid + cell_x);
    const uint16_t *r = table + 4 * (size_t)(grid * grid) + RECORD * (size_t)cell[0];
    for (uint32_t i = 0; i < cell[1]; i++, r += RECORD) {
        const int32_t ax = r[0] - x, ay = r[1] - y, bx = r[2] - x, by = r[3] - y, cx = r[4] - x,
                      cy = r[5] - y;
        const uint32_t shift = r[7] / 2u;
        if (r[7] % 2 == 0) {
            const int32_t e0 = cross(bx, by, cx, cy), e1 = cross(cx, cy, ax, ay),
                          e2 = cross(ax, ay, bx, by);
            if ((e0 | e1 | e2) < 0) {
                continue;
            }
            const int32_t area = e0 + e1 + e2;
            const int32_t w0 = fraction(e0, area, shift), w1 = fraction(e1, area, shift);
            keep(linear, (const uint32_t[3]){r[8], r[9], r[6]}, (const int32_t[3]){w0, w1, 4096 - w0 - w1},
                 out);
            return;
        }
        const int32_t along_x = bx - ax, along_y = by - ay;
        const int32_t t = -ax * along_x - ay * along_y, n = along_x * along_x + along_y * along_y;
        if (t >= 0 && t <= n && cross(along_x, along_y, -ax, -ay) <= 0) {
            const int32_t w1 = fraction(t, n, shift);
            keep(linear, (const uint32_t[3]){r[8], r[9], r[8]}, (const int32_t[3]){4096 - w1, w1, 0}, out);
            return;
        }
        if (t >= n && -bx * (cx - bx) - by * (cy - by) <= 0) {
            keep(linear, (const uint32_t[3]){r[9], r[9], r[9]}, (const int32_t[3]){4096, 0, 0}, out);
            return;
        }
    }
    keep(linear, (const uint32_t[3]){0, 0, 0}, (const int32_t[3]){4096, 0, 0}, out);
}

static float dot(const float a[3], const float b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static float within(float value, float low, float high) {
    value = value >= low ? value : low;
    return value <= high ? value : high;
}

/* Section 9, Gloss: the lights of one neighbouring view. */
static void gloss(const btf_evaluator *e, bool linear, const float sampled[3], const float light[3],
                  const float view[3], const btfi_neighbours *plain, btfi_neighbours *out) {
    float d[3], h[3], c[3];
    bool differs = false;
    for (int i = 0; i < 3; i++) {
        d[i] = sampled[i] - view[i];
        h[i] = light[i] + view[i];
        differs |= d[i] >= 0x1p-24f || d[i] <= -0x1p-24f;
    }
    if (!differs) {
        *out = *plain;
        return;
    }
    const float r = btfi_reciprocal(within(dot(h, h), 0.5f, 4.0f)), hd = dot(h, d), k = (hd + hd) * r;
    const float share = (float)e->info.gloss_share * 0.25f;
    for (int i = 0; i < 3; i++) {
        c[i] = light[i] + (h[i] * k + -d[i]) * share;
    }
    c[2] = c[2] >= 0.0f ? c[2] : 0.0f;
    const float n = btfi_pow(dot(c, c), 0.5f);
    look_up(e->light_table, e->light_grid, linear, c, btfi_reciprocal(within(n + c[2], 0.5f, 4.0f)), out);
}

bool btfi_look_up(const btf_evaluator *e, const btfi_way *way, const float light[3], const float view[3],
                  btfi_situation *out) {
    if (!above_horizon(light, view)) {
        return false;
    }
    const bool root = e->info.domain == BTF_DOMAIN_SQRT;
    look_up(e->view_table, e->view_grid, way->linear, view, btfi_reciprocal(view[2] + 1.0f), &out->views);
    look_up(e->light_table, e->light_grid, way->linear, light, btfi_reciprocal(light[2] + 1.0f),
            &out->lights[0]);
    const btfi_neighbours plain = out->lights[0];
    for (int a = 0; a < out->views.count; a++) {
        if (way->effects & BTF_EFFECT_GLOSS) {
            gloss(e, way->linear, e->view_vectors + 4 * (size_t)out->views.index[a], light, view, &plain,
                  &out->lights[a]);
        } else {
            out->lights[a] = plain;
        }
    }
    for (int i = 0; i < 3; i++) {
        out->view[i] = view[i];
        out->product[i] = light[i] * view[i];
    }
    out->cosine = root ? btfi_pow(light[2], 0.5f) : light[2];
    const float q = light[2] * e->info.horizon_scale;
    out->horizon = q < 1.0f ? root ? btfi_pow(q, 0.5f) : q : 1.0f;
    return true;
}
