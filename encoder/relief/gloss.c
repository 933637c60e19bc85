/* The share of the half vector. See gloss.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "gloss.h"

#include "encoder/base/stage.h"
#include "encoder/math/srgb.h"
#include "encoder/nodes/interpolate.h"
#include "encoder/nodes/left_out.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    DRAWN_VIEWS = 20,
    DRAWN_LIGHTS = 16,
    DRAWN_TEXELS = 192, /* of each view */
    SHARES = ENC_GLOSS_SHARES,
    MOST_QUARTERS = 2,
};

/* The neighbours, and their weights, by which one neighbouring view predicts a light left out. */
typedef struct near_lights {
    int index[3];
    float weight[3];
} near_lights;

typedef struct gloss_job {
    const enc_context *context;
    const enc_data *data;
    const enc_seen *seen;
    const enc_warp *warp, *plane;
    const uint8_t *relief_views;
    int views, view[DRAWN_VIEWS];    /* drawn of those left out */
    int lights, light[DRAWN_LIGHTS]; /* drawn of those left out */
    near_lights *near;               /* [view][neighbour][light][share] */
} gloss_job;

void enc_gloss_light(const float near[3], const float view[3], const float light[3], float share,
                     float out[3]) {
    float d[3], h[3], hh = 0, hd = 0, square = 0;
    for (int i = 0; i < 3; i++) {
        d[i] = near[i] - view[i];
        h[i] = light[i] + view[i];
        hh += h[i] * h[i];
        hd += h[i] * d[i];
    }
    const float bounded = hh < 0.5f ? 0.5f : hh > 4 ? 4.0f : hh, k = 2 * hd / bounded;
    for (int i = 0; i < 3; i++) {
        out[i] = light[i] + (h[i] * k - d[i]) * share;
    }
    out[2] = out[2] > 0 ? out[2] : 0.0f;
    for (int i = 0; i < 3; i++) {
        square += out[i] * out[i];
    }
    for (int i = 0; i < 3; i++) {
        out[i] /= sqrtf(square);
    }
}

static near_lights *near_of(const gloss_job *g, int view, int neighbour, int light, int share) {
    return &g->near[((view * 3 + neighbour) * DRAWN_LIGHTS + light) * SHARES + share];
}

/* Finds, for each neighbour, the lights around the direction where it looks up light number `l`, which is
 * left out. */
static btf_result look_up(const gloss_job *g, int l) {
    const int left = g->light[l], count = g->data->n_lights;
    enc_direction *others = malloc((size_t)count * sizeof *others);
    enc_interpolator *blend = NULL;
    enc_weights *w = malloc(sizeof *w);
    btf_result result = others && w ? BTF_OK : BTF_ERROR_MEMORY;
    for (int k = 0, n = 0; k < count && result == BTF_OK; k++) {
        if (k != left) {
            others[n++] = g->data->lights[k];
        }
    }
    if (result == BTF_OK) {
        result = enc_interpolator_create(g->context, "lights", others, count - 1, ENC_INTERPOLATE_LINEAR,
                                         &blend);
    }
    for (int v = 0; v < g->views && result == BTF_OK; v++) {
        const enc_seen_view *s = &g->seen->of[g->view[v]];
        for (int i = 0; i < s->count * SHARES; i++) {
            float around[3];
            near_lights *out = near_of(g, v, i / SHARES, l, i % SHARES);
            enc_gloss_light(g->data->views[s->near[i / SHARES]].xyz, g->data->views[s->view].xyz,
                            g->data->lights[left].xyz, (float)(i % SHARES) / (SHARES - 1), around);
            enc_interpolator_weights(blend, around, w);
            for (int k = 0; k < 3; k++) {
                out->index[k] = k < w->count ? (int)w->index[k] + ((int)w->index[k] >= left) : left;
                out->weight[k] = k < w->count ? w->weight[k] : 0;
            }
        }
    }
    enc_interpolator_destroy(&blend);
    free(others);
    free(w);
    return result;
}

/* Copies the profile of a texel in one view to `out`. */
static btf_result profile_of(const gloss_job *g, size_t texel, int view, float *buffer, float *out) {
    const size_t n = 3 * (size_t)g->data->n_lights;
    const float *samples;
    const btf_result result = enc_data_texels(g->context, g->data, texel, 1, buffer, &samples);
    for (size_t i = 0; i < n && result == BTF_OK; i++) {
        const float x = samples[(size_t)view * n + i];
        out[i] = sqrtf(x > 0 ? x : 0.0f);
    }
    return result;
}

static float clipped(float x) {
    return x > 0 ? x < 1 ? x : 1.0f : 0.0f;
}

static void judge_light(const gloss_job *g, int v, int l, const enc_seen_point *point,
                        const float *profiles, const float *truth, enc_judged_error sums[SHARES]) {
    const enc_seen_view *s = &g->seen->of[g->view[v]];
    const size_t lights = (size_t)g->data->n_lights;
    for (int q = 0; q < SHARES; q++) {
        for (size_t c = 0; c < 3; c++) {
            float root = 0;
            for (int a = 0; a < s->count; a++) {
                const near_lights *near = near_of(g, v, a, l, q);
                const float *from = profiles + ((size_t)a * 3 + c) * lights;
                for (int k = 0; k < 3; k++) {
                    root += (float)point->weight[a] * 0x1p-12f * near->weight[k] * from[near->index[k]];
                }
            }
            const float original = truth[c * lights + (size_t)g->light[l]];
            const float got = clipped(root * root), right = clipped(original * original);
            const double linear = (double)(got - right),
                         srgb = (double)(enc_srgb_encode(got) - enc_srgb_encode(right));
            sums[q].linear += linear * linear;
            sums[q].srgb += srgb * srgb;
        }
    }
}

/* Adds the errors of all lights at one texel of a view, neighbours being fetched at whole texels. */
static btf_result judge_texel(const gloss_job *g, int v, size_t texel, float *work,
                              enc_judged_error sums[SHARES]) {
    const enc_seen_view *s = &g->seen->of[g->view[v]];
    const bool moved = g->relief_views && g->relief_views[s->view];
    const enc_warp *w = moved ? g->warp : g->plane;
    const size_t n = 3 * (size_t)g->data->n_lights, stride = enc_data_texel_stride(g->data);
    float *profiles = work + stride, *truth = profiles + 3 * n;
    enc_seen_point point;
    int32_t at[2];
    enc_warp_middle(w, texel, at);
    enc_seen_find(w, s, at, SIZE_MAX, 0, &point);
    btf_result result = profile_of(g, texel, s->view, work, truth);
    for (int a = 0; a < s->count && result == BTF_OK; a++) {
        result = profile_of(g, enc_warp_texel(w, point.at[a][0], point.at[a][1]), s->near[a], work,
                            profiles + (size_t)a * n);
    }
    for (int l = 0; l < g->lights && result == BTF_OK; l++) {
        judge_light(g, v, l, &point, profiles, truth, sums);
    }
    return result;
}

static btf_result judge_view(const gloss_job *g, int v, enc_judged_error sums[SHARES]) {
    const size_t all = enc_data_texel_count(g->data), count = all < DRAWN_TEXELS ? all : DRAWN_TEXELS;
    float *work = malloc((enc_data_texel_stride(g->data) + 12 * (size_t)g->data->n_lights) * sizeof *work);
    btf_result result = work ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t t = 0; t < count && result == BTF_OK; t++) { /* other texels of each view */
        result =
            enc_cancelled(g->context)
                ? BTF_ERROR_INTERRUPTED
                : judge_texel(g, v, ((2 * t + 1) * all / (2 * count) + 37 * (size_t)v) % all, work, sums);
    }
    free(work);
    return result;
}

static double score(const enc_gloss_choice *c, int q) {
    return enc_judged_gain(c->error[0], c->error[q]);
}

static void decide(enc_gloss_choice *c) {
    int best = 0;
    for (int q = 1; q < SHARES; q++) {
        best = score(c, q) > score(c, best) ? q : best;
    }
    double shift = 0;
    if (best > 0 && best + 1 < SHARES) {
        const double a = score(c, best - 1), b = score(c, best), d = score(c, best + 1),
                     bend = 2 * b - a - d;
        shift = bend > 0 ? 0.5 * (d - a) / bend : 0;
    }
    c->best = ((double)best + shift) / (SHARES - 1);
    const double least = pow(10, ENC_GLOSS_MARGIN / 10);
    c->quarters = 0;
    for (int q = 1; q <= MOST_QUARTERS && c->error[q - 1].linear > least * c->error[q].linear &&
                    c->error[q - 1].srgb > least * c->error[q].srgb;
         q++) {
        c->quarters = q;
    }
}

static btf_result judge(gloss_job *g, enc_gloss_choice *choice) {
    enc_judged_error sums[DRAWN_VIEWS][SHARES] = {{{0, 0}}};
    btf_result result = BTF_OK;
#pragma omp parallel for schedule(dynamic) num_threads(g->context->threads)
    for (int l = 0; l < g->lights; l++) {
        const btf_result mine = look_up(g, l);
        enc_keep_worse(&result, mine);
    }
#pragma omp parallel for schedule(dynamic) num_threads(g->context->threads) if (result == BTF_OK)
    for (int v = 0; v < (result == BTF_OK ? g->views : 0); v++) {
        const btf_result mine = judge_view(g, v, sums[v]);
        enc_keep_worse(&result, mine);
    }
    const size_t all = enc_data_texel_count(g->data), texels = all < DRAWN_TEXELS ? all : DRAWN_TEXELS;
    const double count = (double)texels * 3 * g->views * g->lights;
    for (int v = 0; v < g->views; v++) {
        for (int q = 0; q < SHARES; q++) {
            choice->error[q].linear += sums[v][q].linear / count;
            choice->error[q].srgb += sums[v][q].srgb / count;
        }
    }
    return result;
}

/* Draws the views and lights to leave out, spread over those that can be. */
static btf_result draw(gloss_job *g) {
    enc_left_out *left = malloc(sizeof *left);
    const btf_result result =
        left ? enc_left_out_make(g->context, g->data->lights, g->data->n_lights, left) : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        g->lights = left->count < DRAWN_LIGHTS ? left->count : DRAWN_LIGHTS;
        g->views = g->seen->count < DRAWN_VIEWS ? g->seen->count : DRAWN_VIEWS;
        for (int i = 0; i < g->lights; i++) {
            g->light[i] = left->index[(2 * i + 1) * left->count / (2 * g->lights)];
        }
        for (int i = 0; i < g->views; i++) {
            g->view[i] = (2 * i + 1) * g->seen->count / (2 * g->views);
        }
    }
    free(left);
    return result;
}

btf_result enc_gloss_choose(const enc_context *context, const enc_data *data, const enc_seen *seen,
                            const enc_warp *warp, const uint8_t *relief_views, enc_gloss_choice *out) {
    enc_warp plane = {0};
    gloss_job g = {.context = context,
                   .data = data,
                   .seen = seen,
                   .warp = warp,
                   .plane = &plane,
                   .relief_views = relief_views};
    *out = (enc_gloss_choice){0};
    btf_result result = draw(&g);
    if (result == BTF_OK && g.views > 0 && g.lights > 0) {
        g.near = malloc((size_t)DRAWN_VIEWS * 3 * DRAWN_LIGHTS * SHARES * sizeof *g.near);
        result = g.near ? enc_warp_create(data->width, data->height, 0, 0, &plane) : BTF_ERROR_MEMORY;
        if (result == BTF_OK) {
            result = judge(&g, out);
        }
        out->judged = result == BTF_OK;
    }
    if (out->judged) {
        decide(out);
    }
    enc_warp_clear(&plane);
    free(g.near);
    return result;
}
