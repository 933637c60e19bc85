/* Greedy choice of a texel's list. See match_lists.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "match_lists.h"

#include "encoder/math/linear.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A pair that a view of the texel has. */
typedef struct pair {
    uint32_t source;
    uint8_t gain;
} pair;

static size_t distinct_pairs(const enc_match *match, size_t texel, pair *out) {
    size_t count = 0;
    for (size_t v = 0; v < match->views; v++) {
        const pair next = {match->source[v * match->texels + texel],
                           match->gain[v * match->texels + texel]};
        size_t i = 0;
        while (i < count && (out[i].source != next.source || out[i].gain != next.gain)) {
            i++;
        }
        out[i] = next;
        count += i == count;
    }
    return count;
}

/* value[pair][view]: how much of the energy of the view's profile the pair takes. */
static void fill_values(const enc_match *match, const enc_match_coordinates *at, size_t texel, size_t count,
                        const pair *pairs, float *value) {
    for (size_t v = 0; v < match->views; v++) {
        const float *query = at->query + (v * match->texels + texel) * at->k;
        for (size_t i = 0; i < count; i++) {
            const size_t source = v * match->texels + pairs[i].source;
            const float gain = match->gains.base + match->gains.step * (float)pairs[i].gain;
            const float dot = (float)enc_dot(at->k, query, at->source + source * at->k);
            value[i * match->views + v] = gain * (2 * dot - gain * at->norm[source]);
        }
    }
}

/* The pair that adds most to what the views have; *out_sum is what they have with it. */
static size_t best_pair(size_t views, size_t count, const float *value, const float *has, double *out_sum) {
    size_t best = 0;
    *out_sum = -HUGE_VAL;
    for (size_t i = 0; i < count; i++) {
        double sum = 0;
        for (size_t v = 0; v < views; v++) {
            sum += fmaxf(value[i * views + v], has[v]);
        }
        if (sum > *out_sum) {
            *out_sum = sum;
            best = i;
        }
    }
    return best;
}

/* One texel; returns the sum of the values. has [view]: room. */
static double restrict_texel(const enc_match_coordinates *at, size_t entries, size_t texel, pair *pairs,
                             float *value, float *has, enc_match *match) {
    const size_t views = match->views, count = distinct_pairs(match, texel, pairs);
    double total = 0;
    fill_values(match, at, texel, count, pairs, value);
    for (size_t v = 0; v < views; v++) {
        has[v] = -FLT_MAX;
    }
    for (size_t n = 0; n < entries && n < count; n++) {
        const size_t best = best_pair(views, count, value, has, &total);
        for (size_t v = 0; v < views; v++) {
            if (value[best * views + v] > has[v]) {
                has[v] = value[best * views + v];
                match->source[v * match->texels + texel] = pairs[best].source;
                match->gain[v * match->texels + texel] = pairs[best].gain;
            }
        }
    }
    return total;
}

btf_result enc_match_coordinates_create(const enc_factor_matrix *m, size_t k, enc_match_coordinates *out) {
    const size_t points = m->texels * (size_t)m->data->n_views;
    *out = (enc_match_coordinates){.k = k};
    out->query = enc_gemm_alloc(points * k);
    out->source = enc_gemm_alloc(points * k);
    out->norm = enc_gemm_alloc(points);
    if (out->query && out->source && out->norm) {
        return BTF_OK;
    }
    enc_match_coordinates_clear(out);
    return enc_fail(m->context, BTF_ERROR_MEMORY, "match: out of memory for %zu points", points);
}

void enc_match_coordinates_clear(enc_match_coordinates *at) {
    free(at->query);
    free(at->source);
    free(at->norm);
    *at = (enc_match_coordinates){0};
}

btf_result enc_match_restrict(const enc_factor_matrix *m, const enc_match_coordinates *at, size_t entries,
                              enc_match *match, double *out_error) {
    const size_t views = match->views, texels = match->texels, threads = (size_t)m->context->threads;
    pair *pairs = malloc(threads * views * sizeof *pairs);
    float *value = malloc(threads * views * (views + 1) * sizeof *value);
    double *sums = calloc(texels, sizeof *sums);
    const bool room = pairs && value && sums;
#pragma omp parallel for schedule(dynamic, 8) num_threads(m->context->threads) if (room)
    for (size_t x = 0; x < (room ? texels : 0); x++) {
        const size_t t = enc_thread_index();
        float *mine = value + t * views * (views + 1);
        sums[x] = -restrict_texel(at, entries, x, pairs + t * views, mine, mine + views * views, match);
        for (size_t v = 0; v < views; v++) {
            const float *query = at->query + (v * texels + x) * at->k;
            sums[x] += enc_dot(at->k, query, query);
        }
    }
    *out_error = 0;
    for (size_t x = 0; x < texels && room; x++) {
        *out_error += sums[x];
    }
    free(pairs);
    free(value);
    free(sums);
    if (!room) {
        return enc_fail(m->context, BTF_ERROR_MEMORY, "match: out of memory for lists");
    }
    enc_match_count_users(m->context, match);
    return BTF_OK;
}
