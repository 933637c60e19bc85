/* Plane sweep and semi-global matching. See sweep.h.
 *
 * H. Hirschmüller, Stereo Processing by Semiglobal Matching and Mutual Information, IEEE Transactions on
 * Pattern Analysis and Machine Intelligence 30 (2008): costs of a texel's heights are summed along eight
 * paths, on which a small change of height costs little and any larger one a fixed amount.
 *
 * SPDX-License-Identifier: MIT
 */
#include "sweep.h"

#include "encoder/nodes/warp.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    K = ENC_RELIEF_NUMBERS,
    STEPS_A_TEXEL = 4,
    PATHS = 8,
};

/* Penalties of semi-global matching (P1 and P2 of Hirschmüller 2008, section 2.2), in units of one minus a
 * correlation. With them the heights of BRICKS64 are off by 1.13 texels RMS after the descent. */
static const float small_change = 0.003f, large_change = 0.03f;
static const double least_theta = 10, most_theta = 65;

typedef struct volume {
    const enc_context *context;
    const enc_relief_images *images;
    int top_view, reach, heights; /* heights: steps of the sweep, 2 * reach * STEPS_A_TEXEL + 1 */
    int views, view[ENC_MAX_DIRECTIONS];
    int32_t slope[ENC_MAX_DIRECTIONS][2];
    float *mean;     /* [view of the images][K] */
    float weight[K]; /* of a product of numbers: variance^(-1/4), so that the leading component does not
                        decide alone; on which data the power was chosen is not recorded */
    enc_warp plane;
    float *cost; /* [texel][height]: 1 - correlation */
} volume;

static void find_means(volume *s) {
    const size_t texels = (size_t)s->images->width * (size_t)s->images->height;
    double square[K] = {0};
    for (int v = 0; v < s->images->n_views; v++) {
        double sum[K] = {0};
        for (size_t t = 0; t < texels; t++) {
            const float *x = enc_relief_numbers(s->images, v, t);
            for (size_t k = 0; k < K; k++) {
                sum[k] += (double)x[k];
            }
        }
        for (size_t k = 0; k < K; k++) {
            s->mean[(size_t)v * K + k] = (float)(sum[k] / (double)texels);
        }
    }
    for (size_t t = 0; t < texels; t++) {
        const float *x = enc_relief_numbers(s->images, s->top_view, t);
        for (size_t k = 0; k < K; k++) {
            const double off = (double)x[k] - (double)s->mean[(size_t)s->top_view * K + k];
            square[k] += off * off;
        }
    }
    for (size_t k = 0; k < K; k++) {
        s->weight[k] = (float)pow(square[k] / square[0] + 1e-6, -0.25);
    }
}

/* Correlates a texel's numbers less their mean, `own`, with the numbers that view number i shows if the
 * texel has height z. */
static float correlation(const volume *s, int i, const int32_t at[2], int32_t z, const float own[K],
                         float own_square) {
    const int v = s->view[i];
    const float *mean = s->mean + (size_t)v * K;
    const int32_t u = at[0] - enc_warp_move(&s->plane, z, s->slope[i][0]) - 128,
                  w = at[1] - enc_warp_move(&s->plane, z, s->slope[i][1]) - 128;
    const float fu = (float)(u & 255) * 0x1p-8f, fw = (float)(w & 255) * 0x1p-8f;
    const float weight[4] = {(1 - fu) * (1 - fw), fu * (1 - fw), (1 - fu) * fw, fu * fw};
    float x[K], product[K], square[K], sum[2] = {0, 0};
    for (size_t k = 0; k < K; k++) {
        x[k] = -mean[k];
    }
    for (int c = 0; c < 4; c++) {
        const float *from = enc_relief_numbers(
            s->images, v, enc_warp_texel(&s->plane, u + (c & 1) * 256, w + (c >> 1) * 256));
        for (size_t k = 0; k < K; k++) {
            x[k] += weight[c] * from[k];
        }
    }
    for (size_t k = 0; k < K; k++) {
        product[k] = x[k] * own[k] * s->weight[k];
        square[k] = x[k] * x[k] * s->weight[k];
    }
    for (size_t k = 0; k < K; k++) {
        sum[0] += product[k];
        sum[1] += square[k];
    }
    return sum[0] / sqrtf(sum[1] * own_square + 1e-12f);
}

static int falling(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x < y) - (x > y);
}

/* Fills in the cost of each height: 1 less the mean correlation of the better half of the views, so that
 * those from which the texel is hidden do not count. */
static void fill_costs(const volume *s, size_t texel) {
    float own[K], own_square = 0, of[ENC_MAX_DIRECTIONS];
    const float *top = enc_relief_numbers(s->images, s->top_view, texel);
    const int half = (s->views + 1) / 2;
    int32_t at[2];
    enc_warp_middle(&s->plane, texel, at);
    for (size_t k = 0; k < K; k++) {
        own[k] = top[k] - s->mean[(size_t)s->top_view * K + k];
        own_square += own[k] * own[k] * s->weight[k];
    }
    for (int h = 0; h < s->heights; h++) {
        const int32_t z = (h - s->reach * STEPS_A_TEXEL) * (ENC_WARP_ONE / STEPS_A_TEXEL);
        float sum = 0;
        for (int i = 0; i < s->views; i++) {
            of[i] = correlation(s, i, at, z, own, own_square);
        }
        qsort(of, (size_t)s->views, sizeof *of, falling);
        for (int i = 0; i < half; i++) {
            sum += of[i];
        }
        s->cost[texel * (size_t)s->heights + (size_t)h] = 1 - sum / (float)half;
    }
}

/* One step along a path: costs of its texel, given those of the texel before (Hirschmüller 2008,
 * section 2.2): the least cost there is taken off, so that sums stay small. */
static void step_path(int heights, const float *cost, const float *before, float *here, float *sum) {
    float least = before[0];
    for (int h = 1; h < heights; h++) {
        least = before[h] < least ? before[h] : least;
    }
    for (int h = 0; h < heights; h++) {
        float best = least + large_change;
        const float down = h > 0 ? before[h - 1] + small_change : best;
        const float up = h + 1 < heights ? before[h + 1] + small_change : best;
        best = before[h] < best ? before[h] : best;
        best = down < best ? down : best;
        best = up < best ? up : best;
        here[h] = cost[h] + best - least;
        sum[h] += here[h];
    }
}

/* All paths of one direction, each once around the periodic image and a half more, so that its start does
 * not matter. Paths of one direction share no texel. */
static void add_paths(const volume *s, int across, int down, float *sums, float *work) {
    const int width = s->images->width, height = s->images->height, heights = s->heights;
    const int starts = across != 0 && down == 0 ? height : width, length = down == 0 ? width : height;
#pragma omp parallel for schedule(static) num_threads(s->context->threads)
    for (int start = 0; start < starts; start++) {
        float *before = work + (size_t)start * 2 * (size_t)heights, *here = before + heights;
        float *unused = NULL;
        int column = down == 0 ? 0 : start, row = down == 0 ? start : 0;
        memset(before, 0, (size_t)heights * sizeof *before);
        unused = work + ((size_t)starts * 2 + (size_t)start) * (size_t)heights;
        for (int n = -length / 2; n < length; n++) {
            column = (start * (down != 0) + n * across + 2 * width * length) % width;
            row = (start * (down == 0) + n * down + 2 * height * length) % height;
            const size_t texel = (size_t)row * (size_t)width + (size_t)column;
            step_path(heights, s->cost + texel * (size_t)heights, before, here,
                      n < 0 ? unused : sums + texel * (size_t)heights);
            float *swap = before;
            before = here;
            here = swap;
        }
    }
}

/* The height of least cost, between the steps by a parabola. */
static float best_height(const volume *s, const float *cost) {
    int best = 0;
    for (int h = 1; h < s->heights; h++) {
        best = cost[h] < cost[best] ? h : best;
    }
    float shift = 0;
    if (best > 0 && best + 1 < s->heights) {
        const float a = cost[best - 1], b = cost[best], c = cost[best + 1], bend = a - 2 * b + c;
        shift = bend > 0 ? 0.5f * (a - c) / bend : 0;
    }
    return ((float)best + shift) / STEPS_A_TEXEL - (float)s->reach;
}

static btf_result match(volume *s, float *out) {
    static const int way[PATHS][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}};
    const size_t texels = (size_t)s->images->width * (size_t)s->images->height;
    const size_t side =
        (size_t)(s->images->width > s->images->height ? s->images->width : s->images->height);
    float *sums = calloc(texels * (size_t)s->heights, sizeof *sums);
    float *work = calloc(3 * side * (size_t)s->heights, sizeof *work);
    s->cost = malloc(texels * (size_t)s->heights * sizeof *s->cost);
    btf_result result = sums && work && s->cost ? BTF_OK : BTF_ERROR_MEMORY;
#pragma omp parallel for schedule(dynamic, 16) num_threads(s->context->threads) if (result == BTF_OK)
    for (size_t t = 0; t < (result == BTF_OK ? texels : 0); t++) {
        if (!enc_cancelled(s->context)) {
            fill_costs(s, t);
        }
    }
    if (result == BTF_OK && enc_cancelled(s->context)) {
        result = BTF_ERROR_INTERRUPTED;
    }
    for (int p = 0; p < PATHS && result == BTF_OK; p++) {
        add_paths(s, way[p][0], way[p][1], sums, work);
    }
    for (size_t t = 0; t < texels && result == BTF_OK; t++) {
        out[t] = best_height(s, sums + t * (size_t)s->heights);
    }
    free(sums);
    free(work);
    free(s->cost);
    return result;
}

btf_result enc_relief_sweep(const enc_context *context, const enc_relief_images *images,
                            const enc_direction *views, int top_view, int reach, float *out) {
    volume s = {.context = context,
                .images = images,
                .top_view = top_view,
                .reach = reach,
                .heights = 2 * reach * STEPS_A_TEXEL + 1};
    for (int v = 0; v < images->n_views; v++) {
        if (views[v].theta >= least_theta && views[v].theta <= most_theta) {
            enc_warp_slope(views[v].xyz, s.slope[s.views]);
            s.view[s.views++] = v;
        }
    }
    memset(out, 0, (size_t)images->width * (size_t)images->height * sizeof *out);
    if (s.views == 0) {
        return BTF_OK;
    }
    s.mean = malloc((size_t)images->n_views * K * sizeof *s.mean);
    btf_result result =
        s.mean ? enc_warp_create(images->width, images->height, 0, 0, &s.plane) : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        find_means(&s);
        result = match(&s, out);
    }
    enc_warp_clear(&s.plane);
    free(s.mean);
    return result;
}
