/* Where views see the points of a surface that is given as heights over the texels: the decoder's integer
 * march (FORMAT.md section 9, Relief), of any number of texels at a time.
 *
 * Positions are pairs (u, v) in 1/256 of a texel, v upwards; heights are 1/256 of the width of a texel of
 * level 0, texels as everywhere row * width + column with row 0 at the top.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NODES_WARP_H
#define OPENBTF_ENCODER_NODES_WARP_H

#include "encoder/data/data.h"

enum {
    ENC_WARP_ONE = 256,       /* a texel, as positions and heights count */
    ENC_WARP_WEIGHT = 4096,   /* a weight of 1, and a slope of one texel across for each texel of height */
    ENC_WARP_FARTHEST = 4096, /* texels that a march may leave the image by, on each side: 128 texels of
                                height at the greatest slope, and back along another view */
};

/* A surface. Zeros are a flat one at height 0. */
typedef struct enc_warp {
    int width, height, level;
    int32_t base, top; /* of the least and the greatest code: where a march ends and begins */
    int steps;         /* of a march */
    int32_t *heights;  /* [texel]; NULL: base everywhere */
    int32_t *column;   /* [width + 2 * ENC_WARP_FARTHEST] wrapped columns, from -ENC_WARP_FARTHEST on */
    int32_t *row;      /* likewise for rows from below, times width: the first texel of the row */
} enc_warp;

/* A surface of one height. Errors, not logged: BTF_ERROR_MEMORY. */
btf_result enc_warp_create(int width, int height, int level, int32_t base, enc_warp *out_warp);
/* Gives the surface a height at each texel, from codes: base + ((code * step) >> 8). Errors, not logged:
 * BTF_ERROR_MEMORY. */
btf_result enc_warp_set_codes(enc_warp *warp, int32_t base, int32_t step, int steps, const uint8_t *codes);
void enc_warp_clear(enc_warp *warp);

/* Finds the slope of a view, a unit vector above the horizon: how many texels a point moves across for each
 * texel of its height, times 4096. */
void enc_warp_slope(const float view[3], int32_t out_slope[2]);

/* How far from its foot a point of height z appears in an image. */
static inline int32_t enc_warp_move(const enc_warp *w, int32_t z, int32_t slope) {
    return (z * slope) >> (12 + w->level);
}

static inline size_t enc_warp_texel(const enc_warp *w, int32_t u, int32_t v) {
    return (size_t)(w->row[(v >> 8) + ENC_WARP_FARTHEST] + w->column[(u >> 8) + ENC_WARP_FARTHEST]);
}

/* Finds the height of the point that a view of this slope shows at (u, v). The reference's march would take
 * twice the time (33 ns against 16), since it wraps by division, and it reads codes, which heights that are
 * still sought do not have; that both agree is tested (tests/unit/nodes/test_warp.c). */
static inline int32_t enc_warp_march(const enc_warp *w, int32_t u, int32_t v, const int32_t slope[2]) {
    if (!w->heights) {
        return w->base;
    }
    const int32_t step = (w->top - w->base + w->steps - 1) / w->steps;
    int32_t z = w->top;
    for (int n = 0; n <= w->steps; n++, z -= step) {
        const int32_t t = w->heights[enc_warp_texel(w, u + enc_warp_move(w, z, slope[0]),
                                                    v + enc_warp_move(w, z, slope[1]))];
        if (t >= z) {
            return n == 0 ? z : t < z + step ? t : z + (step >> 1);
        }
    }
    return w->base;
}

/* Share of a view, of 4096, that is left where it shows a point `above` the one that it should show. */
static inline int32_t enc_warp_visible(const enc_warp *w, int32_t above) {
    const int32_t o = 6144 - 8 * (above >> w->level);
    return o < 1229 ? 1229 : o > 4096 ? 4096 : o;
}

/* The four texels around a position and their weights, steep: a texel's middle half is its own. */
typedef struct enc_warp_fetch {
    size_t texel[4];
    float weight[4];
} enc_warp_fetch;

static inline int32_t enc_warp_steep(int32_t f) {
    const int32_t twice = 2 * f - 128;
    return twice < 0 ? 0 : twice > 256 ? 256 : twice;
}

static inline void enc_warp_around(const enc_warp *w, int32_t u, int32_t v, enc_warp_fetch *out) {
    const int32_t cu = (u - 128) >> 8, cv = (v - 128) >> 8;
    const int32_t fu = enc_warp_steep((u - 128) & 255), fv = enc_warp_steep((v - 128) & 255);
    for (int i = 0; i < 4; i++) {
        const int x = i & 1, y = i >> 1;
        out->texel[i] =
            (size_t)(w->row[cv + y + ENC_WARP_FARTHEST] + w->column[cu + x + ENC_WARP_FARTHEST]);
        out->weight[i] = (float)((x ? fu : 256 - fu) * (y ? fv : 256 - fv)) * 0x1p-16f;
    }
}

/* The middle of a texel. */
static inline void enc_warp_middle(const enc_warp *w, size_t texel, int32_t out[2]) {
    out[0] = (int32_t)(texel % (size_t)w->width) * ENC_WARP_ONE + ENC_WARP_ONE / 2;
    out[1] = (w->height - 1 - (int32_t)(texel / (size_t)w->width)) * ENC_WARP_ONE + ENC_WARP_ONE / 2;
}

#endif
