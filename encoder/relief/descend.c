/* Coordinate descent on heights. See descend.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "descend.h"

#include "encoder/base/stage.h"
#include "encoder/math/clones.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    K = ENC_RELIEF_NUMBERS,
    APART = 8, /* columns and rows between texels that change at the same time */
    CANDIDATES = 10,
    MOST_STEPS = 32,
    LEAST_STEPS = 8,
};

/* Penalty of the total variation: for a difference of one texel in height between neighbours, as a share of
 * a flat surface's mean squared error at a texel. Measured with the penalties of sweep.c, see there. */
static const double variation = 0.02;
static const int32_t variation_most = 4 * ENC_WARP_ONE;

typedef struct change {
    size_t texel;
    int32_t before, after;
} change;

typedef struct descent {
    const enc_context *context;
    const enc_relief_images *images;
    const enc_seen *seen;
    enc_warp *warp;
    size_t texels;
    float *error;   /* [view left out][texel] squared, at the present heights */
    double unit;    /* sum over the views of a flat surface's mean squared error */
    change *change; /* [texel]: of the texels that change together */
} descent;

/* Adds a neighbour's numbers at a place to out, weighted. */
ENC_CLONES static void add_fetch(const float *images, const enc_warp_fetch *f, float weight, float out[K]) {
    for (int c = 0; c < 4; c++) {
        const float w = weight * f->weight[c], *from = images + f->texel[c] * K;
        if (w != 0) {
            for (size_t k = 0; k < K; k++) {
                out[k] += w * from[k];
            }
        }
    }
}

ENC_CLONES static float square_of(const float a[K], const float b[K]) {
    float square[K], sum = 0;
    for (size_t k = 0; k < K; k++) {
        square[k] = (a[k] - b[k]) * (a[k] - b[k]);
    }
    for (size_t k = 0; k < K; k++) {
        sum += square[k];
    }
    return sum;
}

/* Squared error of view number i at a texel of its image, with another height of one texel of the
 * surface. */
static float error_at(const descent *d, int i, size_t pixel, size_t changed, int32_t height) {
    const enc_seen_view *s = &d->seen->of[i];
    enc_seen_point point;
    enc_warp_fetch fetch;
    float got[K] = {0};
    int32_t at[2];
    enc_warp_middle(d->warp, pixel, at);
    enc_seen_find(d->warp, s, at, changed, height, &point);
    for (int a = 0; a < s->count; a++) {
        enc_warp_around(d->warp, point.at[a][0], point.at[a][1], &fetch);
        add_fetch(enc_relief_numbers(d->images, s->near[a], 0), &fetch, (float)point.weight[a] * 0x1p-12f,
                  got);
    }
    return square_of(got, enc_relief_numbers(d->images, s->view, pixel));
}

/* The texels of a view's image whose rays pass over a texel of the surface between two heights. Each
 * is listed once or, where the way is short, twice. */
typedef struct rays {
    int count;
    size_t pixel[4 * 256];
} rays;

static void find_rays(const enc_warp *w, const enc_seen_view *s, size_t texel, int32_t low, int32_t high,
                      rays *out) {
    int32_t at[2];
    enc_warp_middle(w, texel, at);
    const int32_t across = abs(enc_warp_move(w, high - low, s->slope[0]));
    const int32_t along = abs(enc_warp_move(w, high - low, s->slope[1]));
    const int most = (int)(sizeof out->pixel / sizeof out->pixel[0]);
    const int wanted = 2 + (across > along ? across : along) / (ENC_WARP_ONE / 2);
    const int n = wanted < most ? wanted : most;
    out->count = 0;
    for (int k = 0; k < n; k++) {
        const int32_t z = high - (int32_t)((int64_t)(high - low) * k / (n > 1 ? n - 1 : 1));
        const size_t pixel = enc_warp_texel(w, at[0] - enc_warp_move(w, z, s->slope[0]),
                                            at[1] - enc_warp_move(w, z, s->slope[1]));
        if (out->count == 0 || out->pixel[out->count - 1] != pixel) {
            out->pixel[out->count++] = pixel;
        }
    }
}

static int32_t march_step(const enc_warp *w) {
    return (w->top - w->base + w->steps - 1) / w->steps;
}

static void neighbours_of(const enc_warp *w, size_t texel, size_t out[4]) {
    int32_t at[2];
    enc_warp_middle(w, texel, at);
    out[0] = enc_warp_texel(w, at[0] - ENC_WARP_ONE, at[1]);
    out[1] = enc_warp_texel(w, at[0] + ENC_WARP_ONE, at[1]);
    out[2] = enc_warp_texel(w, at[0], at[1] - ENC_WARP_ONE);
    out[3] = enc_warp_texel(w, at[0], at[1] + ENC_WARP_ONE);
}

static double variation_of(const enc_warp *w, const size_t around[4], int32_t height) {
    int32_t sum = 0;
    for (int i = 0; i < 4; i++) {
        const int32_t off = abs(height - w->heights[around[i]]);
        sum += off < variation_most ? off : variation_most;
    }
    return variation * sum / ENC_WARP_ONE;
}

/* By how much the squared errors would grow if a texel had another height. */
static double added_error(const descent *d, size_t texel, int32_t height, rays *r) {
    const int32_t before = d->warp->heights[texel], step = march_step(d->warp);
    const int32_t low = (before < height ? before : height) - step,
                  high = (before < height ? height : before) + step;
    double sum = 0;
    for (int i = 0; i < d->seen->count; i++) {
        find_rays(d->warp, &d->seen->of[i], texel, low, high, r);
        for (int k = 0; k < r->count; k++) {
            const size_t pixel = r->pixel[k];
            sum += (double)error_at(d, i, pixel, texel, height) -
                   (double)d->error[(size_t)i * d->texels + pixel];
        }
    }
    return sum;
}

/* Finds the best height of a texel: its own, one of `steps` above or below that, or a neighbour's. */
static int32_t try_heights(const descent *d, size_t texel, const int32_t steps[3], rays *r) {
    const enc_warp *w = d->warp;
    const int32_t before = w->heights[texel];
    int32_t candidate[CANDIDATES], best = before;
    size_t around[4];
    int count = 0;
    double least = -1e-6;
    neighbours_of(w, texel, around);
    for (int i = 0; i < 3; i++) {
        candidate[count++] = before + steps[i];
        candidate[count++] = before - steps[i];
    }
    for (int i = 0; i < 4; i++) {
        candidate[count++] = w->heights[around[i]];
    }
    for (int c = 0; c < count; c++) {
        const int32_t to = candidate[c] < w->base ? w->base : candidate[c] > w->top ? w->top : candidate[c];
        bool seen = to == before;
        for (int k = 0; k < c; k++) {
            seen = seen || candidate[k] == to;
        }
        candidate[c] = to;
        if (!seen) {
            const double gain = added_error(d, texel, to, r) / d->unit + variation_of(w, around, to) -
                                variation_of(w, around, before);
            best = gain < least ? to : best;
            least = gain < least ? gain : least;
        }
    }
    return best;
}

/* Fills in the errors of all texels of all views at the present heights; returns their sum. */
static double measure(descent *d) {
    double total = 0;
#pragma omp parallel for schedule(dynamic) num_threads(d->context->threads)
    for (int i = 0; i < d->seen->count; i++) {
        for (size_t t = 0; t < d->texels; t++) {
            d->error[(size_t)i * d->texels + t] = error_at(d, i, t, SIZE_MAX, 0);
        }
    }
    for (size_t k = 0; k < (size_t)d->seen->count * d->texels; k++) {
        total += (double)d->error[k];
    }
    return total;
}

/* Lists the texels of one phase, in every APART-th column and row; returns their number. */
static size_t list_phase(const descent *d, int phase) {
    const int width = d->images->width, height = d->images->height;
    size_t count = 0;
    for (int row = phase / APART; row < height; row += APART) {
        for (int column = phase % APART; column < width; column += APART) {
            d->change[count++].texel = (size_t)row * (size_t)width + (size_t)column;
        }
    }
    return count;
}

/* Sets the heights that were found together, and measures the errors on the rays of those that changed
 * anew. */
static void commit(descent *d, size_t count, rays *work) {
    const int32_t step = march_step(d->warp);
    for (size_t i = 0; i < count; i++) {
        d->warp->heights[d->change[i].texel] = d->change[i].after;
    }
#pragma omp parallel for schedule(dynamic) num_threads(d->context->threads)
    for (int i = 0; i < d->seen->count; i++) {
        rays *r = &work[i];
        for (size_t k = 0; k < count; k++) {
            const change *c = &d->change[k];
            if (c->before != c->after) {
                const int32_t low = c->before < c->after ? c->before : c->after;
                const int32_t high = c->before < c->after ? c->after : c->before;
                find_rays(d->warp, &d->seen->of[i], c->texel, low - step, high + step, r);
                for (int p = 0; p < r->count; p++) {
                    d->error[(size_t)i * d->texels + r->pixel[p]] =
                        error_at(d, i, r->pixel[p], SIZE_MAX, 0);
                }
            }
        }
    }
}

static void sweep(descent *d, const int32_t steps[3], rays *work) {
    for (int phase = 0; phase < APART * APART && !enc_cancelled(d->context); phase++) {
        const size_t count = list_phase(d, phase);
#pragma omp parallel for schedule(dynamic) num_threads(d->context->threads)
        for (size_t i = 0; i < count; i++) {
            rays r;
            d->change[i].before = d->warp->heights[d->change[i].texel];
            d->change[i].after = try_heights(d, d->change[i].texel, steps, &r);
            enc_stage_step(d->context, 1);
        }
        commit(d, count, work);
    }
}

/* Sets the ends of marches half a texel beyond the heights, and so many steps that each is about half a
 * texel. */
static void set_range(enc_warp *w, size_t texels) {
    int32_t low = w->heights[0], high = w->heights[0];
    for (size_t t = 1; t < texels; t++) {
        low = w->heights[t] < low ? w->heights[t] : low;
        high = w->heights[t] > high ? w->heights[t] : high;
    }
    w->base = low - ENC_WARP_ONE / 2;
    w->top = high + ENC_WARP_ONE / 2;
    const int steps = (w->top - w->base) / (ENC_WARP_ONE / 2);
    w->steps = steps < LEAST_STEPS ? LEAST_STEPS : steps > MOST_STEPS ? MOST_STEPS : steps;
}

static btf_result descend(descent *d, int sweeps, rays *work, double *out_share) {
    static const int32_t wide[3] = {512, 256, 128}, fine[3] = {256, 128, 64};
    enc_warp flat = *d->warp, *given = d->warp;
    flat.heights = NULL;
    flat.base = flat.top = 0;
    d->warp = &flat;
    const double plain = measure(d);
    d->warp = given;
    d->unit = plain / (double)d->texels;
    *out_share = 1;
    if (!(plain > 0)) {
        return BTF_OK;
    }
    for (int n = 0; n < sweeps && !enc_cancelled(d->context); n++) {
        set_range(d->warp, d->texels);
        measure(d);
        sweep(d, n < (sweeps + 1) / 2 ? wide : fine, work);
    }
    set_range(d->warp, d->texels);
    *out_share = measure(d) / plain;
    return enc_cancelled(d->context) ? BTF_ERROR_INTERRUPTED : BTF_OK;
}

btf_result enc_relief_descend(const enc_context *context, const enc_relief_images *images,
                              const enc_seen *seen, int sweeps, enc_warp *io_warp, double *out_share) {
    descent d = {.context = context,
                 .images = images,
                 .seen = seen,
                 .warp = io_warp,
                 .texels = (size_t)images->width * (size_t)images->height};
    const size_t views = seen->count > 0 ? (size_t)seen->count : 1;
    rays *work = malloc(views * sizeof *work);
    d.error = malloc(views * d.texels * sizeof *d.error);
    d.change = malloc(d.texels * sizeof *d.change);
    const btf_result result =
        d.error && d.change && work ? descend(&d, sweeps, work, out_share) : BTF_ERROR_MEMORY;
    free(d.error);
    free(d.change);
    free(work);
    return result;
}
