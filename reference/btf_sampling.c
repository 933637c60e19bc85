/* OpenBTF reference decoder: directions to the light in proportion to radiance, and their density
 * (decoder/SAMPLING.md).
 *
 * SPDX-License-Identifier: MIT
 */
#include "btf_reference_private.h"

#include <stddef.h>

/** A light is never nearer to the horizon than this. */
#define LEAST_HEIGHT 0x1p-20f

/** 1 / pi, rounded. */
#define INVERSE_PI 0x1.45f306p-2f

/** sin(s * pi / 2) / s and cos(s * pi / 2), -1/2 <= s <= 1/2, as polynomials of s^2: Taylor's coefficients,
 * rounded. */
static const float sine_terms[5] = {0x1.921fb6p+0f, -0x1.4abbcep-1f, 0x1.466bc6p-4f, -0x1.32d2ccp-8f,
                                    0x1.507834p-13f};
static const float cosine_terms[5] = {1.0f, -0x1.3bd3ccp+0f, 0x1.03c1f0p-2f, -0x1.55d3c8p-6f,
                                      0x1.e1f506p-11f};

/** 24 bits of a random number, 0 <= x < 1. */
static float unit_of(uint32_t random) {
    return (float)(random >> 8) * 0x1p-24f;
}

/** A third number, of the two that are given: their sum of products, hashed with the constants of PCG
 * (M. O'Neill, 2014). */
static uint32_t third_number(uint32_t u1, uint32_t u2) {
    uint32_t h = u1 * 747796405u + u2 * 2891336453u + 277803737u;
    h = (h >> 16 ^ h) * 277803737u;
    return h >> 15 ^ h;
}

/** part / whole of 0 <= part < whole, below 1; a whole of 0 stands for 2^32. */
static float share_of(uint32_t part, uint32_t whole) {
    if (whole == 0) {
        return unit_of(part);
    }
    uint32_t drop = 0;
    while (whole >> drop >= 1u << 24) {
        ++drop;
    }
    float p = (float)(part >> drop), w = (float)(whole >> drop);
    uint32_t exponent = (btf_ref_bits(w) >> 23) - 127;
    float down = btf_ref_float((127 - exponent) << 23); /* exact: w * down is in [1, 2) */
    float reciprocal = btf_ref_reciprocal(w * down);
    float share = p * down;
    share = share * reciprocal;
    return share < 0x1.fffffep-1f ? share : 0x1.fffffep-1f;
}

static float polynomial(const float coefficients[5], float x) {
    float p = coefficients[4];
    for (int i = 3; i >= 0; --i) {
        p = p * x;
        p = p + coefficients[i];
    }
    return p;
}

/** A direction whose density is its cosine over pi: the disc below it is hit evenly (N. Malley's method).
 */
static void cosine_direction(float u1, float u2, float out[3]) {
    float quarters = u2 * 4.0f;
    int32_t quarter = btf_ref_floor(quarters);
    float s = quarters - (float)quarter;
    s = s - 0.5f;
    float square = s * s;
    float sine = s * polynomial(sine_terms, square), cosine = polynomial(cosine_terms, square);
    float radius = btf_ref_pow(u1, 0.5f), height = btf_ref_pow(1.0f - u1, 0.5f);
    float x = quarter == 0 ? cosine : quarter == 1 ? -sine : quarter == 2 ? -cosine : sine;
    float y = quarter == 0 ? sine : quarter == 1 ? cosine : quarter == 2 ? -sine : -cosine;
    out[0] = radius * x;
    out[1] = radius * y;
    out[2] = height;
}

/** l0 a + l1 b + l2 c */
static float weighted(const float l[3], float a, float b, float c) {
    float x = l[0] * a;
    float y = l[1] * b;
    float z = l[2] * c;
    float sum = x + y;
    return sum + z;
}

/** Barycentric coordinates whose density is linear, in proportion to d at the corners: of a point that is
 * spread evenly over the triangle, one of the three turns, chosen by its density. */
static void barycentric(float u1, float u2, float u3, const float d[3], float out[3]) {
    float sum = u1 + u2;
    if (sum > 1.0f) { /* the other half of the square */
        u1 = 1.0f - u1;
        u2 = 1.0f - u2;
    }
    float first = 1.0f - u1;
    first = first - u2;
    const float l[5] = {first, u1, u2, first, u1};
    float all = d[0] + d[1];
    all = all + d[2];
    float height = u3 * all;
    float unturned = weighted(l, d[0], d[1], d[2]);
    float once = unturned + weighted(l + 1, d[0], d[1], d[2]);
    int turns = height < unturned ? 0 : height < once ? 1 : 2;
    for (int i = 0; i < 3; ++i) {
        out[i] = l[turns + i];
    }
}

/** The first triangle whose part of 2^32 ends above u; there is one. */
static uint32_t find_triangle(const uint32_t *row, uint32_t count, uint32_t u) {
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        uint32_t middle = (low + high) / 2;
        if (u < row[4 * middle]) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return low;
}

/** The direction at a point of the plane. */
static void unproject(const float q[2], float out[3]) {
    float x = (q[0] - 8192.0f) * 0x1p-13f, y = (q[1] - 8192.0f) * 0x1p-13f;
    float xx = x * x, yy = y * y;
    float rr = xx + yy;
    float k = btf_ref_reciprocal(1.0f + rr);
    float twice = k + k;
    out[0] = x * twice;
    out[1] = y * twice;
    float z = 1.0f - rr;
    z = z * k;
    out[2] = z >= LEAST_HEIGHT ? z : LEAST_HEIGHT;
}

static bool is_above(const float d[3]) {
    for (int i = 0; i < 3; ++i) {
        if ((btf_ref_bits(d[i]) & 0x7FFFFFFFu) > 0x40000000u) { /* beyond 2, infinite, NaN */
            return false;
        }
    }
    return d[2] >= 0x1p-24f;
}

static uint32_t nearest_view(const btf_ref_material *material, const float view[3]) {
    int32_t q[2];
    btf_ref_project(view, q);
    return btf_ref_nearest(btf_ref_lookup(material->view_table, material->view_grid, q)).index[0];
}

float btf_ref_pdf_light(const btf_ref_material *material, const btf_ref_sampling *sampling, float u,
                        float v, const float view[3], const float light[3]) {
    (void)u;
    (void)v;
    if (!is_above(view) || !is_above(light)) {
        return 0.0f;
    }
    const float *of_view =
        sampling->densities + (size_t)nearest_view(material, view) * (material->n_lights + 1);
    int32_t q[2];
    btf_ref_project(light, q);
    btf_ref_neighbours n = btf_ref_lookup(material->light_table, material->light_grid, q);
    float density = 0.0f;
    if (n.index[0] != n.index[2]) { /* a triangle; weights are rounded down but for the last */
        const float weights[3] = {(float)n.weight[0] + 0.5f, (float)n.weight[1] + 0.5f,
                                  (float)n.weight[2] - 1.0f};
        density =
            weighted(weights, of_view[n.index[0]], of_view[n.index[1]], of_view[n.index[2]]) * 0x1p-12f;
        density = density >= 0.0f ? density : 0.0f;
    }
    float z = light[2] <= 1.0f ? light[2] : 1.0f;
    float k = btf_ref_reciprocal(z + 1.0f);
    density = density * k;
    density = density * k;
    float even = of_view[material->n_lights] * z;
    even = even * INVERSE_PI;
    return density + even;
}

void btf_ref_sample_light(const btf_ref_material *material, const btf_ref_sampling *sampling, float u,
                          float v, const float view[3], uint32_t u1, uint32_t u2, float out_light[3],
                          float *out_pdf) {
    out_light[0] = out_light[1] = 0.0f;
    out_light[2] = 1.0f;
    *out_pdf = 0.0f;
    if (!is_above(view)) {
        return;
    }
    uint32_t count = sampling->n_triangles;
    const uint32_t *row = sampling->triangles + 4 * (size_t)count * nearest_view(material, view);
    uint32_t end = row[4 * (size_t)(count - 1)];
    float second = unit_of(u2);
    if (u1 >= end) {
        cosine_direction(share_of(u1 - end, 0u - end), second, out_light);
    } else {
        uint32_t t = find_triangle(row, count, u1);
        uint32_t begin = t > 0 ? row[4 * (size_t)(t - 1)] : 0;
        const uint32_t *corners = sampling->triangles + 4 * ((size_t)count * material->n_views + t);
        float d[3], l[3], q[2];
        for (int i = 0; i < 3; ++i) {
            d[i] = btf_ref_float(row[4 * (size_t)t + 1 + (size_t)i]);
        }
        barycentric(share_of(u1 - begin, row[4 * (size_t)t] - begin), second, unit_of(third_number(u1, u2)),
                    d, l);
        q[0] = weighted(l, (float)(corners[0] & 0xFFFFu), (float)(corners[1] & 0xFFFFu),
                        (float)(corners[2] & 0xFFFFu));
        q[1] = weighted(l, (float)(corners[0] >> 16), (float)(corners[1] >> 16), (float)(corners[2] >> 16));
        unproject(q, out_light);
    }
    *out_pdf = btf_ref_pdf_light(material, sampling, u, v, view, out_light);
}

bool btf_ref_probe_sampling(void) {
    return btf_ref_probe();
}
