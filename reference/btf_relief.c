/* OpenBTF reference decoder: relief, the shift of each neighbouring view along a height map (FORMAT.md,
 * section 9).
 *
 * Heights are in 1/256 of a texel of the level that they were made for, positions in 1/256 of a texel of the level, slopes
 * in 1/4096.
 *
 * SPDX-License-Identifier: MIT
 */
#include "btf_reference_private.h"

#include <stddef.h>

enum { SLOPE_BITS = 12, WEIGHT_BITS = 12, FULL_WEIGHT = 1 << WEIGHT_BITS };

static int32_t slope_component(float component, float k) {
    float s = component * k;
    s = s * 4096.0f;
    s = s + 0.5f;
    /* the bounds are integers, so clamping before the floor is the same, and safe for any float */
    s = s >= -32767.0f ? s : -32767.0f;
    s = s <= 32767.0f ? s : 32767.0f;
    return btf_ref_floor(s);
}

void btf_ref_slope(const float direction[3], int32_t out_slope[2]) {
    float z = direction[2] >= 0.25f ? direction[2] : 0.25f;
    float k = btf_ref_reciprocal(z + z);
    k = k + k;
    out_slope[0] = slope_component(direction[0], k);
    out_slope[1] = slope_component(direction[1], k);
}

/** A slope, times the share of it by which relief acts. */
static void faded_slope(const float direction[3], int32_t share, int32_t out_slope[2]) {
    btf_ref_slope(direction, out_slope);
    for (int i = 0; i < 2; ++i) {
        out_slope[i] = btf_ref_shift_down(out_slope[i] * share, WEIGHT_BITS);
    }
}

/** A position on an axis of `size` texels, modulo its length. */
static int32_t wrap_position(int32_t position, uint32_t size) {
    int32_t length = (int32_t)(size * 256);
    int32_t wrapped = position % length; /* has the sign of the position */
    return wrapped < 0 ? wrapped + length : wrapped;
}

/** How far along an axis a ray goes for a height. */
static int32_t distance(const btf_ref_material *material, int32_t height, int32_t slope) {
    return btf_ref_shift_down(height * slope, SLOPE_BITS + material->level);
}

void btf_ref_move(const btf_ref_material *material, const int32_t position[2], int32_t height,
                  const int32_t slope[2], int32_t out_position[2]) {
    out_position[0] = wrap_position(position[0] + distance(material, height, slope[0]), material->width);
    out_position[1] = wrap_position(position[1] + distance(material, height, slope[1]), material->height);
}

static int32_t height_of_code(const btf_ref_material *material, int32_t code) {
    return material->relief_base + ((code * material->relief_step) >> 8);
}

/** The height of the texel that holds a position. */
static int32_t height_at(const btf_ref_material *material, const int32_t position[2]) {
    size_t column = (size_t)position[0] >> 8, row = material->height - 1 - ((size_t)position[1] >> 8);
    return height_of_code(material, material->heights[row * material->width + column]);
}

int32_t btf_ref_march(const btf_ref_material *material, const int32_t position[2], const int32_t slope[2]) {
    int32_t steps = (int32_t)material->relief_steps;
    int32_t z = height_of_code(material, 255);
    int32_t descent = (z - material->relief_base + steps - 1) / steps;

    for (int32_t n = 0; n <= steps; ++n) {
        int32_t foot[2];
        btf_ref_move(material, position, z, slope, foot);
        int32_t surface = height_at(material, foot);
        if (surface >= z) {
            if (n == 0) {
                return z;
            }
            /* lower than the ray was a step before: it came down on it; higher: it went into its side */
            return surface < z + descent ? surface : z + (descent >> 1);
        }
        z -= descent;
    }
    return material->relief_base; /* not reached: the last step is not above the lowest height */
}

/** o_a of section 9, of 4096: the less, the higher the surface that hides the point in a view rises. */
static int32_t visible_share(const btf_ref_material *material, int32_t shown, int32_t seen, int32_t share) {
    int32_t above =
        btf_ref_shift_down(btf_ref_shift_down((shown - seen) * share, WEIGHT_BITS), material->level);
    int32_t o = 6144 - 8 * above;
    if (o < 1229) {
        return 1229;
    }
    return o > FULL_WEIGHT ? FULL_WEIGHT : o;
}

/** 4096 * part / whole, rounded down; 64 <= whole <= 2^24. */
static uint32_t fraction(uint32_t part, uint32_t whole) {
    return ((part >> 6) << WEIGHT_BITS) / (whole >> 6);
}

void btf_ref_relief(const btf_ref_material *material, const btf_ref_neighbours *views, const float view[3],
                    bool occlusion, const int32_t position[2], int32_t out_positions[3][2],
                    uint32_t out_weights[3]) {
    static const int32_t origin[2] = {0, 0};
    bool flat = material->relief_step == 0;
    uint32_t visible[3], total = 0;
    int32_t share = 0; /* e */
    for (int a = 0; a < 3; ++a) {
        if (material->view_vectors[4 * (size_t)views->index[a] + 3] != 0.0f) {
            share += (int32_t)views->weight[a];
        }
    }

    int32_t slope[2], point[2];
    faded_slope(view, share, slope);
    int32_t z = flat ? material->relief_base : btf_ref_march(material, position, slope);
    btf_ref_move(material, position, z, slope, point);

    for (int a = 0; a < 3; ++a) {
        int32_t slope_a[2], shift[2];
        faded_slope(material->view_vectors + 4 * (size_t)views->index[a], share, slope_a);
        btf_ref_move(material, origin, z, slope_a, shift);
        out_positions[a][0] = wrap_position(point[0] - shift[0], material->width);
        out_positions[a][1] = wrap_position(point[1] - shift[1], material->height);
        visible[a] = 0;
        if (views->weight[a] > 0 && !flat) {
            int32_t shown = btf_ref_march(material, out_positions[a], slope_a);
            visible[a] = views->weight[a] * (uint32_t)visible_share(material, shown, z, share);
        }
        total += visible[a];
        out_weights[a] = views->weight[a];
    }
    if (!occlusion || flat) {
        return;
    }
    /* the last that weighs takes what rounding leaves */
    out_weights[0] = fraction(visible[0], total);
    out_weights[1] = visible[2] > 0 ? fraction(visible[1], total) : FULL_WEIGHT - out_weights[0];
    out_weights[2] = FULL_WEIGHT - out_weights[0] - out_weights[1];
}

bool btf_ref_probe_relief(void) {
    return btf_ref_probe();
}
