/* Positions and weights of views along the heights. See relief.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "relief.h"

#include "exact.h"

static int32_t slope_component(float component, float k) {
    float s = component * k * 4096.0f + 0.5f;
    s = s >= -32767.0f ? s : -32767.0f;
    s = s <= 32767.0f ? s : 32767.0f;
    return btfi_floor(s);
}

/* A direction's slope times the share, in 4096ths, with which the relief acts. */
static void faded_slope(const float d[3], int32_t share, int32_t out_slope[2]) {
    const float z = d[2] >= 0.25f ? d[2] : 0.25f, half = btfi_reciprocal(z + z), k = half + half;
    for (int i = 0; i < 2; i++) {
        out_slope[i] = slope_component(d[i], k) * share >> 12;
    }
}

void btfi_relief_slopes(const btf_evaluator *e, const btfi_situation *s, btfi_slopes *out) {
    out->share = 0;
    for (int a = 0; a < s->views.count; a++) {
        if (e->view_vectors[4 * (size_t)s->views.index[a] + 3] != 0.0f) {
            out->share += s->views.weight[a];
        }
    }
    faded_slope(s->view, out->share, out->own);
    for (int a = 0; a < s->views.count; a++) {
        faded_slope(e->view_vectors + 4 * (size_t)s->views.index[a], out->share, out->of_view[a]);
    }
}

/* A position on an axis of `length` 256ths of a texel, modulo that. */
static int32_t wrap(int32_t position, int32_t length) {
    if (position >= 0 && position < length) {
        return position;
    }
    position %= length;
    return position < 0 ? position + length : position;
}

static void move(const btfi_level *l, const int32_t position[2], int32_t height, const int32_t slope[2],
                 int32_t out[2]) {
    const int32_t length[2] = {(int32_t)l->width * 256, (int32_t)l->height * 256};
    for (int i = 0; i < 2; i++) {
        out[i] = wrap(position[i] + (height * slope[i] >> (12 + l->shift)), length[i]);
    }
}

static int32_t march(const btf_evaluator *e, const btfi_level *l, const int32_t position[2],
                     const int32_t slope[2]) {
    const int32_t base = e->info.relief_base, step = e->info.relief_step,
                  steps = (int32_t)e->info.relief_steps;
    int32_t z = base + (255 * step >> 8);
    const int32_t descent = (z - base + steps - 1) / steps;
    for (int32_t n = 0; n <= steps; n++, z -= descent) {
        int32_t foot[2];
        move(l, position, z, slope, foot);
        const size_t row = l->height - 1 - ((size_t)foot[1] >> 8);
        const int32_t surface = base + (l->heights[row * l->width + ((size_t)foot[0] >> 8)] * step >> 8);
        if (surface >= z) {
            return n == 0 ? z : surface < z + descent ? surface : z + (descent >> 1);
        }
    }
    return base;
}

/* o_a of section 9, of 4096: the share of a view that is left after occlusion. */
static int32_t visible_share(const btfi_level *l, int32_t shown, int32_t seen, int32_t share) {
    const int32_t o = 6144 - 8 * ((shown - seen) * share >> 12 >> l->shift);
    return o < 1229 ? 1229 : o > 4096 ? 4096 : o;
}

void btfi_relief(const btf_evaluator *e, const btfi_level *l, const btfi_situation *s,
                 const btfi_slopes *slopes, bool occlusion, const int32_t position[2],
                 int32_t out_positions[3][2], int32_t out_weights[3]) {
    static const int32_t origin[2] = {0, 0};
    const int32_t length[2] = {(int32_t)l->width * 256, (int32_t)l->height * 256};
    const bool flat = e->info.relief_step == 0;
    int32_t point[2], visible[3] = {0, 0, 0}, total = 0;
    const int32_t z = flat ? e->info.relief_base : march(e, l, position, slopes->own);
    move(l, position, z, slopes->own, point);
    for (int a = 0; a < 3; a++) {
        out_weights[a] = s->views.weight[a];
    }
    for (int a = 0; a < s->views.count; a++) {
        int32_t shift[2];
        move(l, origin, z, slopes->of_view[a], shift);
        for (int i = 0; i < 2; i++) {
            out_positions[a][i] = wrap(point[i] - shift[i], length[i]);
        }
        if (flat || !occlusion) {
            continue;
        }
        const int32_t shown = march(e, l, out_positions[a], slopes->of_view[a]);
        visible[a] = s->views.weight[a] * visible_share(l, shown, z, slopes->share);
        total += visible[a];
    }
    if (flat || !occlusion) {
        return;
    }
    /* The last neighbour takes what rounding leaves of 4096; entries behind it have no weight. */
    out_weights[0] = s->views.count == 1 ? 4096 : ((visible[0] >> 6) << 12) / (total >> 6);
    if (s->views.count > 1) {
        out_weights[1] =
            s->views.count == 2 ? 4096 - out_weights[0] : ((visible[1] >> 6) << 12) / (total >> 6);
    }
    out_weights[2] = 4096 - out_weights[0] - out_weights[1];
}
