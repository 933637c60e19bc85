/* Weights where they can be judged. See rows.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "rows.h"

#include "left_out.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const double enc_strength_kappa[ENC_STRENGTHS] = {INFINITY, 30, 10, 3, 1, 0.3, 0.1, 0};

enum { LEFT_OUT_POINTS = 1000 }; /* fewer for a fit of the others, of which many are made and each is judged
                                    once */

static float *row_of(const enc_node_rows *r, int strength, int place, int i) {
    return r->weight[strength][place] + (size_t)i * (size_t)r->n;
}

static bool allocate(enc_node_rows *r) {
    bool room = true;
    for (int s = 0; s < ENC_STRENGTHS; s++) {
        for (int p = 0; p < ENC_ROWS_PLACES; p++) {
            r->weight[s][p] =
                calloc((size_t)(r->count[p] > 0 ? r->count[p] : 1) * (size_t)r->n, sizeof *r->weight[s][p]);
            room = room && r->weight[s][p];
        }
    }
    return room;
}

void enc_node_rows_clear(enc_node_rows *r) {
    for (int s = 0; s < ENC_STRENGTHS; s++) {
        for (int p = 0; p < ENC_ROWS_PLACES; p++) {
            free(r->weight[s][p]);
            r->weight[s][p] = NULL;
        }
    }
}

static void one(const enc_node_rows *r, int strength, int place, int i, int sample) {
    row_of(r, strength, place, i)[sample] = 1;
}

static void spread(const enc_weights *w, float *row) {
    for (int k = 0; k < w->count; k++) {
        row[w->index[k]] += w->weight[k];
    }
}

/* Finds the weights of the other samples in the direction of sample i, for every strength:
 * rows[strength][n]. usable[strength]: whether there is such a fit. */
static btf_result leave(const enc_context *context, const enc_direction *directions, int n, int i,
                        const btf_ref_neighbours *near, float *rows, bool usable[ENC_STRENGTHS]) {
    enc_direction others[ENC_MAX_DIRECTIONS];
    float found[ENC_MAX_DIRECTIONS];
    enc_weights w = {.count = 3};
    enc_node_fit *fit = NULL;
    for (int k = 0; k < n - 1; k++) {
        others[k] = directions[k + (k >= i)];
    }
    for (uint32_t k = 0; k < 3; k++) {
        rows[near->index[k]] += (float)near->weight[k] * 0x1p-12f;
        w.index[k] = near->index[k] - (near->index[k] > (uint32_t)i);
        w.weight[k] = (float)near->weight[k] * 0x1p-12f;
    }
    usable[0] = true;
    const btf_result made = enc_node_fit_create(context, others, n - 1, LEFT_OUT_POINTS, &fit);
    btf_result result = made == BTF_ERROR_UNSUPPORTED ? BTF_OK : made;
    for (int s = 1; s < ENC_STRENGTHS && fit && result == BTF_OK; s++) {
        result = enc_node_fit_blend(fit, enc_strength_kappa[s], 1, &w, found);
        usable[s] = result == BTF_OK;
        result = result == BTF_ERROR_UNSUPPORTED ? BTF_OK : result;
        for (int k = 0; k < n - 1 && usable[s]; k++) {
            rows[s * n + k + (k >= i)] = found[k];
        }
    }
    enc_node_fit_destroy(&fit);
    return result;
}

/* Makes the weights in the directions of samples that can be left out, evenly chosen. */
static btf_result make_left_out(const enc_context *context, const enc_direction *directions,
                                const enc_left_out *left, enc_node_rows *r) {
    const size_t n = (size_t)r->n, count = (size_t)r->count[ENC_ROWS_LEFT_OUT];
    btf_result result = BTF_OK;
    float *rows = calloc(count * ENC_STRENGTHS * n, sizeof *rows);
    bool(*usable)[ENC_STRENGTHS] = calloc(count, sizeof *usable);
    if (!rows || !usable) {
        free(rows);
        free(usable);
        return BTF_ERROR_MEMORY;
    }
#pragma omp parallel for schedule(dynamic) num_threads(context->threads)
    for (size_t i = 0; i < count; i++) {
        const size_t at = i * (size_t)left->count / count;
        const btf_result mine = leave(context, directions, r->n, left->index[at], &left->near[at],
                                      rows + i * ENC_STRENGTHS * n, usable[i]);
        enc_keep_worse(&result, mine);
    }
    for (size_t i = 0; i < count; i++) {
        r->sample[ENC_ROWS_LEFT_OUT][i] = left->index[i * (size_t)left->count / count];
        for (int s = 0; s < ENC_STRENGTHS; s++) {
            r->usable[s] = r->usable[s] && usable[i][s];
            memcpy(row_of(r, s, ENC_ROWS_LEFT_OUT, (int)i), rows + (i * ENC_STRENGTHS + (size_t)s) * n,
                   n * sizeof *rows);
        }
    }
    free(rows);
    free(usable);
    return result;
}

/* Makes the weights in directions of the hull, evenly chosen; in those of the nodes where there is no
 * fit. */
static btf_result make_between(const enc_context *context, const enc_direction *directions,
                               const enc_node_fit *fit, enc_node_rows *r) {
    const float(*points)[3];
    const size_t count = (size_t)r->count[ENC_ROWS_BETWEEN], all = (size_t)enc_node_fit_points(fit, &points);
    enc_interpolator *blend = NULL;
    enc_weights *w = malloc(count * sizeof *w);
    btf_result result = w ? enc_interpolator_create(context, "directions", directions, r->n,
                                                    ENC_INTERPOLATE_LINEAR, &blend)
                          : BTF_ERROR_MEMORY;
    for (size_t i = 0; i < count && result == BTF_OK; i++) {
        enc_interpolator_weights(blend, points[(2 * i + 1) * all / (2 * count)], &w[i]);
        spread(&w[i], row_of(r, 0, ENC_ROWS_BETWEEN, (int)i));
        r->sample[ENC_ROWS_BETWEEN][i] = -1;
    }
    for (int s = 1; s < ENC_STRENGTHS && result == BTF_OK; s++) {
        result = enc_node_fit_blend(fit, enc_strength_kappa[s], count, w, r->weight[s][ENC_ROWS_BETWEEN]);
        r->usable[s] = r->usable[s] && result == BTF_OK;
        result = result == BTF_ERROR_UNSUPPORTED ? BTF_OK : result;
    }
    enc_interpolator_destroy(&blend);
    free(w);
    return result;
}

static btf_result make_nodes(const enc_node_fit *fit, enc_node_rows *r) {
    btf_result result = BTF_OK;
    for (int s = 1; s < ENC_STRENGTHS && result == BTF_OK; s++) {
        result = enc_node_fit_weights(fit, enc_strength_kappa[s], r->weight[s][ENC_ROWS_AT]);
        r->usable[s] = r->usable[s] && result == BTF_OK;
        result = result == BTF_ERROR_UNSUPPORTED ? BTF_OK : result;
    }
    return result;
}

static void stand_still(enc_node_rows *r, int place) {
    for (int i = 0; i < r->count[place]; i++) {
        r->sample[place][i] = i;
        for (int s = 0; s < ENC_STRENGTHS; s++) {
            one(r, s, place, i, i);
        }
    }
}

static int smaller(int a, int b) {
    return a < b ? a : b;
}

static btf_result make(const enc_context *context, const enc_direction *directions,
                       const enc_left_out *left, const enc_node_fit *fit, enc_node_rows *r) {
    btf_result result = BTF_OK;
    r->leaves = left->count > 0;
    r->count[ENC_ROWS_LEFT_OUT] = smaller(r->leaves ? left->count : r->n, ENC_ROWS_MOST);
    r->count[ENC_ROWS_BETWEEN] = fit ? ENC_ROWS_MOST : smaller(r->n, ENC_ROWS_MOST);
    r->count[ENC_ROWS_AT] = r->n;
    if (!allocate(r)) {
        return BTF_ERROR_MEMORY;
    }
    for (int s = 0; s < ENC_STRENGTHS; s++) {
        r->usable[s] = s == 0 || (fit && r->leaves);
    }
    for (int i = 0; i < r->n; i++) {
        r->sample[ENC_ROWS_AT][i] = i;
        one(r, 0, ENC_ROWS_AT, i, i);
    }
    if (r->leaves) {
        result = make_left_out(context, directions, left, r);
    } else {
        stand_still(r, ENC_ROWS_LEFT_OUT);
    }
    if (fit && result == BTF_OK) {
        result = make_between(context, directions, fit, r);
        if (result == BTF_OK) {
            result = make_nodes(fit, r);
        }
    } else if (!fit) {
        stand_still(r, ENC_ROWS_BETWEEN);
    }
    return result;
}

btf_result enc_node_rows_make(const enc_context *context, const enc_direction *directions, int count,
                              enc_node_rows *out_rows) {
    enc_node_fit *fit = NULL;
    enc_left_out *left = malloc(sizeof *left);
    *out_rows = (enc_node_rows){.n = count};
    btf_result result = left ? enc_left_out_make(context, directions, count, left) : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        const btf_result made = enc_node_fit_create(context, directions, count, ENC_FIT_POINTS, &fit);
        result = made == BTF_ERROR_UNSUPPORTED ? BTF_OK : made;
    }
    if (result == BTF_OK) {
        result = make(context, directions, left, fit, out_rows);
    }
    if (result != BTF_OK) {
        enc_node_rows_clear(out_rows);
    }
    enc_node_fit_destroy(&fit);
    free(left);
    return result;
}
