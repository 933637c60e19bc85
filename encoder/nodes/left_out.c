/* Each direction of a list seen by the others. See left_out.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "left_out.h"

#include "interpolate.h"
#include "spline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Whether the point that the weights stand for, in the stereographic plane, is near enough to direction
 * i. */
static bool reaches(const enc_direction *directions, int count, int i, const enc_weights *w) {
    double own[2], other[2], found[2] = {0, 0}, least = HUGE_VAL;
    enc_stereographic(directions[i].xyz, own);
    for (int k = 0; k < count; k++) {
        enc_stereographic(directions[k].xyz, other);
        if (k != i) {
            least = fmin(least, hypot(other[0] - own[0], other[1] - own[1]));
        }
    }
    for (int k = 0; k < w->count; k++) {
        enc_stereographic(directions[w->index[k]].xyz, other);
        found[0] += (double)w->weight[k] * other[0];
        found[1] += (double)w->weight[k] * other[1];
    }
    return hypot(found[0] - own[0], found[1] - own[1]) < least / 2;
}

/* Weights that interpolation has as floats become 4096ths, as the decoder has them. */
static btf_ref_neighbours to_neighbours(const enc_weights *w) {
    btf_ref_neighbours near = {.index = {0}, .weight = {0}};
    for (int k = 0; k < 3; k++) {
        near.index[k] = w->index[k < w->count ? k : 0];
        near.weight[k] = k < w->count ? (uint32_t)(w->weight[k] * 4096.0f) : 0;
    }
    return near;
}

/* Finds the weights of the other directions in direction i. */
static btf_result without(const enc_context *context, const enc_direction *directions, int count, int i,
                          enc_weights *out) {
    enc_direction others[ENC_MAX_DIRECTIONS];
    enc_interpolator *made = NULL;
    for (int k = 0, n = 0; k < count; k++) {
        if (k != i) {
            others[n++] = directions[k];
        }
    }
    const btf_result result =
        enc_interpolator_create(context, "directions", others, count - 1, ENC_INTERPOLATE_LINEAR, &made);
    if (result == BTF_OK) {
        enc_interpolator_weights(made, directions[i].xyz, out);
    }
    for (int k = 0; result == BTF_OK && k < out->count; k++) {
        out->index[k] += out->index[k] >= (uint32_t)i;
    }
    enc_interpolator_destroy(&made);
    return result;
}

btf_result enc_left_out_make(const enc_context *context, const enc_direction *directions, int count,
                             enc_left_out *out) {
    static const enc_context alone = {.threads = 1};
    const enc_context *used = context ? context : &alone;
    btf_result result = BTF_OK;
    enc_weights *w = malloc((size_t)count * sizeof *w);
    out->count = 0;
    if (!w) {
        return enc_fail(context, BTF_ERROR_MEMORY, "leave-one-out: out of memory");
    }
#pragma omp parallel for schedule(dynamic) num_threads(used->threads)
    for (int i = 0; i < count; i++) {
        const btf_result mine = count > 1 ? without(context, directions, count, i, &w[i]) : BTF_OK;
        enc_keep_worse(&result, mine);
    }
    for (int i = 0; result == BTF_OK && count > 1 && i < count; i++) {
        if (reaches(directions, count, i, &w[i])) {
            out->near[out->count] = to_neighbours(&w[i]);
            out->index[out->count++] = i;
        }
    }
    free(w);
    return result;
}
