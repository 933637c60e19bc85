/* Random and extreme arguments.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"

#include <math.h>

float case_coordinate(random_state *r, uint32_t size) {
    static const uint32_t extremes[] = {
        0x00000000, 0x80000000, 0x00000001, 0x807FFFFF, 0x00800000,
        0x80800000,                                                 /* zeros, denormals, 2^-126 */
        0x3F800000, 0xBF800000, 0x3F7FFFFF, 0x3F800001, 0xBF7FFFFF, /* around 1 */
        0x45800000, 0xC5800000, 0x45800001, 0x457FFFFF, 0xC5800001,
        0xC57FFFFF, /* around 4096 */
        0x7F800000, 0xFF800000, 0x7FC00000, 0x7F800001, 0xFFFFFFFF,
        0x7F7FFFFF, /* infinite, NaN, largest */
        0x36800000, 0xB6800000, 0x367FFFFF, 0xB67FFFFF, 0x4F000000,
        0xCF000000, /* around 2^-18, 2^31 */
    };
    switch (random_below(r, 16)) {
    case 0:
        return float_of_bits(extremes[random_below(r, sizeof extremes / sizeof *extremes)]);
    case 1: { /* an edge or the middle of a texel, and beside it */
        float c = (float)random_below(r, 2 * size + 1) / (float)(2 * size);
        return float_of_bits(bits_of_float(c) + random_below(r, 3) - (c > 0 ? 1 : 0));
    }
    case 2:
        return (float)random_between(r, -4097, 4097);
    case 3:
        return (float)random_between(r, -2, 2);
    default:
        return (float)random_between(r, 0, 1);
    }
}

/* The direction at a point of the plane of FORMAT.md section 6. */
static void unproject(double qx, double qy, float out[3]) {
    double x = (qx - 8192) / 8192, y = (qy - 8192) / 8192, s = 1 + x * x + y * y;
    out[0] = (float)(2 * x / s);
    out[1] = (float)(2 * y / s);
    out[2] = (float)((1 - x * x - y * y) / s);
}

static void from_angles(double theta, double phi, float out[3]) {
    out[0] = (float)(sin(theta) * cos(phi));
    out[1] = (float)(sin(theta) * sin(phi));
    out[2] = (float)cos(theta);
}

/* Points on, and one unit beside, the edges and corners of triangles and hull. */
static void on_edge(random_state *r, const btf_directions *list, float out[3]) {
    uint32_t a, b;
    if (list->triangle_count > 0 && random_below(r, 3)) {
        const uint16_t *triangle = list->triangles + 3 * (size_t)random_below(r, list->triangle_count);
        uint32_t corner = random_below(r, 3);
        a = triangle[corner];
        b = triangle[(corner + 1) % 3];
    } else if (list->hull_count > 0) {
        uint32_t i = random_below(r, list->hull_count);
        a = list->hull[i];
        b = list->hull[(i + 1) % list->hull_count];
    } else {
        a = b = 0;
    }
    double t = random_below(r, 3) == 0 ? random_below(r, 2) : random_between(r, 0, 1);
    double x = (1 - t) * list->vertices[2 * a] + t * list->vertices[2 * b];
    double y = (1 - t) * list->vertices[2 * a + 1] + t * list->vertices[2 * b + 1];
    unproject(nearbyint(x) + (double)random_below(r, 3) - 1, nearbyint(y) + (double)random_below(r, 3) - 1,
              out);
}

static void extreme_direction(random_state *r, const btf_directions *list, float out[3]) {
    static const uint32_t components[] = {
        0x00000000, 0x80000000, 0x00000001, 0x007FFFFF, 0x3F800000, 0xBF800000, 0x33800000, 0x337FFFFF,
        0xB3800000, 0x40000000, 0xC0000000, 0x40000001, 0x7F800000, 0xFF800000, 0x7FC00000, 0xFFC00001,
    };
    double phi = random_between(r, 0, 2 * M_PI);
    switch (random_below(r, 8)) {
    case 0:
        from_angles(0, 0, out);
        return;
    case 1:
        from_angles(89.9 * M_PI / 180, phi, out);
        return;
    case 2:
    case 3: {
        const float *sample = list->xyz + 3 * (size_t)random_below(r, list->count);
        for (int i = 0; i < 3; ++i) {
            out[i] = sample[i];
        }
        return;
    }
    case 4:
    case 5:
        on_edge(r, list, out);
        return;
    case 6: /* within a degree of the horizon, and below it */
        from_angles(random_between(r, 89, 90.2) * M_PI / 180, phi, out);
        return;
    default: /* arguments that no caller should hand over */
        for (int i = 0; i < 3; ++i) {
            out[i] = random_below(r, 2) ? (float)random_between(r, -2, 2)
                                        : float_of_bits(components[random_below(r, 16)]);
        }
        return;
    }
}

void case_direction(random_state *r, const btf_directions *list, float out[3]) {
    if (random_below(r, 4) == 0) {
        extreme_direction(r, list, out);
        return;
    }
    /* Uniform over the hemisphere. */
    double z = random_between(r, 0, 1), phi = random_between(r, 0, 2 * M_PI), s = sqrt(1 - z * z);
    out[0] = (float)(s * cos(phi));
    out[1] = (float)(s * sin(phi));
    out[2] = (float)z;
}

void case_in_range(random_state *r, const btf_range *range, const btf_directions *list, float out[3]) {
    if (range->fixed) {
        memcpy(out, range->direction, 3 * sizeof *out);
        return;
    }
    const double degree = M_PI / 180;
    const int all = range->theta[0] == 0 && range->theta[1] == 0;
    const double low = (double)range->theta[0], high = fmin(all ? 90 : (double)range->theta[1], 89.99);
    double turn = fmod((double)range->phi[1] - (double)range->phi[0] + 720, 360);
    turn = turn > 0 ? turn : 360;
    const uint32_t kind = random_below(r, 8);
    if (kind == 0) {
        const float *d = list->xyz + 3 * (size_t)random_below(r, list->count);
        const double theta = acos(fmin((double)d[2], 1)) / degree;
        const double phi =
            fmod(atan2((double)d[1], (double)d[0]) / degree - (double)range->phi[0] + 1080, 360);
        if (theta >= low && theta <= high && phi <= turn) {
            memcpy(out, d, 3 * sizeof *out);
            return;
        }
    }
    const double theta = kind == 1 ? low : kind == 2 ? high : random_between(r, low, high);
    const double part = kind == 3 ? 0 : kind == 4 ? turn : random_between(r, 0, turn);
    from_angles(theta * degree, ((double)range->phi[0] + part) * degree, out);
}

/* A view within 15 degrees of the horizon, and a light anywhere, on the other side, or on the view's side: such pairs
 * have half vectors that vanish, or make gloss move look-ups below the horizon. */
static void grazing(random_state *r, float light[3], float view[3]) {
    const double theta = random_between(r, 75, 90) * M_PI / 180, phi = random_between(r, 0, 2 * M_PI);
    from_angles(theta, phi, view);
    const uint32_t kind = random_below(r, 4);
    if (kind > 1) { /* now and then exactly opposed */
        from_angles(random_below(r, 2) ? theta : random_between(r, 75, 90) * M_PI / 180,
                    phi + (kind == 2 ? M_PI : 0) + random_below(r, 2) * random_between(r, -0.1, 0.1),
                    light);
    }
}

void case_make(random_state *r, const btf_material *material, uint32_t out[CASE_WORDS]) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    btf_directions lights = btf_material_lights(material), views = btf_material_views(material);
    float f[CASE_WORDS];
    f[0] = case_coordinate(r, info.width);
    f[1] = case_coordinate(r, info.height);
    case_direction(r, &lights, f + 2);
    case_direction(r, &views, f + 5);
    if (info.effects & (BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS) && random_below(r, 4) == 0) {
        grazing(r, f + 2, f + 5);
    }
    memcpy(out, f, sizeof f);
}
