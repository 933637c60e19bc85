/* Views left out and predicted from the others, as the decoder would with a surface.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RELIEF_SEEN_H
#define OPENBTF_ENCODER_RELIEF_SEEN_H

#include "encoder/nodes/warp.h"

/* A view that is left out, and its neighbours in the decoder's triangulation of the others. */
typedef struct enc_seen_view {
    int view, count; /* of the neighbours that weigh */
    int32_t slope[2];
    int near[3];
    int32_t weight[3]; /* sum ENC_WARP_WEIGHT */
    int32_t near_slope[3][2];
} enc_seen_view;

typedef struct enc_seen {
    int count;
    enc_seen_view of[ENC_MAX_DIRECTIONS];
} enc_seen;

/* All views that can be left out with a theta of least to most degrees. Errors: those of
 * enc_left_out_make. */
btf_result enc_seen_make(const enc_context *context, const enc_direction *views, int count,
                         double least_theta, double most_theta, enc_seen *out_seen);

/* The places where the neighbours show the point that a texel of the view shows, and their weights. */
typedef struct enc_seen_point {
    int32_t at[3][2];
    int32_t weight[3]; /* sum ENC_WARP_WEIGHT */
} enc_seen_point;

/* enc_warp_march with one texel, `changed`, taken to have the height `height` whatever the surface says;
 * SIZE_MAX: none. */
static inline int32_t enc_seen_march(const enc_warp *w, int32_t u, int32_t v, const int32_t slope[2],
                                     size_t changed, int32_t height) {
    if (!w->heights) {
        return w->base;
    }
    const int32_t step = (w->top - w->base + w->steps - 1) / w->steps;
    int32_t z = w->top;
    for (int n = 0; n <= w->steps; n++, z -= step) {
        const size_t texel =
            enc_warp_texel(w, u + enc_warp_move(w, z, slope[0]), v + enc_warp_move(w, z, slope[1]));
        const int32_t t = texel == changed ? height : w->heights[texel];
        if (t >= z) {
            return n == 0 ? z : t < z + step ? t : z + (step >> 1);
        }
    }
    return w->base;
}

static inline void enc_seen_find(const enc_warp *w, const enc_seen_view *s, const int32_t at[2],
                                 size_t changed, int32_t height, enc_seen_point *out) {
    const int32_t z = enc_seen_march(w, at[0], at[1], s->slope, changed, height);
    const int32_t u = at[0] + enc_warp_move(w, z, s->slope[0]),
                  v = at[1] + enc_warp_move(w, z, s->slope[1]);
    int32_t weight[3] = {0}, total = 0;
    for (int a = 0; a < s->count; a++) {
        out->at[a][0] = u - enc_warp_move(w, z, s->near_slope[a][0]);
        out->at[a][1] = v - enc_warp_move(w, z, s->near_slope[a][1]);
        weight[a] = s->weight[a];
        if (w->heights) {
            const int32_t there =
                enc_seen_march(w, out->at[a][0], out->at[a][1], s->near_slope[a], changed, height);
            weight[a] *= enc_warp_visible(w, there - z);
        } else {
            weight[a] *= ENC_WARP_WEIGHT;
        }
        total += weight[a] >> 6;
    }
    int32_t rest = ENC_WARP_WEIGHT;
    for (int a = 0; a < s->count; a++) { /* the last takes what rounding leaves */
        out->weight[a] =
            a + 1 < s->count ? (int32_t)(((uint32_t)(weight[a] >> 6) << 12) / (uint32_t)total) : rest;
        rest -= out->weight[a];
    }
}

#endif
