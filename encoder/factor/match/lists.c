/* Greedy choice of a texel's list. See lists.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "lists.h"

#include "encoder/math/clones.h"
#include "encoder/math/linear.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

ENC_CLONES float enc_match_dot(size_t k, const float *restrict a, const float *restrict b) {
    float sum[16] = {0}, total = 0;
    size_t i = 0;
    for (; i + 16 <= k; i += 16) {
        for (size_t j = 0; j < 16; j++) {
            sum[j] += a[i + j] * b[i + j];
        }
    }
    for (; i < k; i++) {
        total += a[i] * b[i];
    }
    for (size_t j = 0; j < 8; j++) {
        sum[j] += sum[j + 8];
    }
    for (size_t j = 0; j < 4; j++) {
        sum[j] += sum[j + 4];
    }
    return total + ((sum[0] + sum[2]) + (sum[1] + sum[3]));
}

/* A pair of source and gain that a view of the texel has. */
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

/* The memory that a thread works in. */
typedef struct workspace {
    pair *pairs;  /* [view] */
    float *query; /* [view][k] */
    float *dot;   /* [pair][view] inner product of profile and source */
    float *value; /* [pair][view]: how much of the energy of the view's profile the pair takes */
    float *has;   /* [view]: the value of the pair that it has been given */
} workspace;

static size_t workspace_floats(size_t views, size_t k) {
    return views * (k + 2 * views + 1);
}

/* The first pair of the same source. */
static size_t first_of_source(const pair *pairs, size_t i) {
    size_t first = 0;
    while (pairs[first].source != pairs[i].source) {
        first++;
    }
    return first;
}

static void find_dots(const enc_match_coordinates *at, size_t views, size_t source, const float *query,
                      float *dot) {
    const size_t all = enc_match_area_texels(&at->sources);
    for (size_t v = 0; v < views; v++) {
        dot[v] = enc_match_dot(at->k, query + v * at->k, at->source + (v * all + source) * at->k);
    }
}

/* Fills in the values of all pairs of the texel at `place`. */
static void fill_values(const enc_match *match, const enc_match_coordinates *at, size_t place, size_t count,
                        workspace *w) {
    const size_t texels = enc_match_area_texels(&at->block), all = enc_match_area_texels(&at->sources);
    const size_t views = match->views;
    for (size_t v = 0; v < views; v++) {
        memcpy(w->query + v * at->k, at->query + (v * texels + place) * at->k, at->k * sizeof *w->query);
    }
    for (size_t i = 0; i < count; i++) {
        const size_t source = enc_match_place(match, &at->sources, w->pairs[i].source);
        const size_t first = first_of_source(w->pairs, i);
        const float gain = match->gains.base + match->gains.step * (float)w->pairs[i].gain;
        if (first == i) {
            find_dots(at, views, source, w->query, w->dot + i * views);
        }
        for (size_t v = 0; v < views; v++) {
            w->value[i * views + v] =
                gain * (2 * w->dot[first * views + v] - gain * at->norm[v * all + source]);
        }
    }
}

/* The energy that the views take if each has the better of this pair and the one that it has. */
ENC_CLONES static double taken_with(size_t views, const float *restrict value, const float *restrict has) {
    double sum[8] = {0};
    size_t v = 0;
    for (; v + 8 <= views; v += 8) {
        for (size_t i = 0; i < 8; i++) {
            sum[i] += value[v + i] > has[v + i] ? value[v + i] : has[v + i];
        }
    }
    for (size_t i = 0; v + i < views; i++) {
        sum[i] += value[v + i] > has[v + i] ? value[v + i] : has[v + i];
    }
    return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

/* The pair that adds most to the energy that the views take. */
static size_t best_pair(size_t views, size_t count, const float *value, const float *has) {
    size_t best = 0;
    double most = -HUGE_VAL;
    for (size_t i = 0; i < count; i++) {
        const double sum = taken_with(views, value + i * views, has);
        if (sum > most) {
            most = sum;
            best = i;
        }
    }
    return best;
}

static void restrict_texel(const enc_match_coordinates *at, size_t entries, size_t place, workspace *w,
                           enc_match *match) {
    const size_t texel = enc_match_texel(match, &at->block, place);
    const size_t views = match->views, count = distinct_pairs(match, texel, w->pairs);
    fill_values(match, at, place, count, w);
    for (size_t v = 0; v < views; v++) {
        w->has[v] = -FLT_MAX;
    }
    for (size_t n = 0; n < entries && n < count; n++) {
        const size_t best = best_pair(views, count, w->value, w->has);
        const float *value = w->value + best * views;
        for (size_t v = 0; v < views; v++) {
            if (value[v] > w->has[v]) {
                w->has[v] = value[v];
                match->source[v * match->texels + texel] = w->pairs[best].source;
                match->gain[v * match->texels + texel] = w->pairs[best].gain;
            }
        }
    }
}

/* Blocks.
 * ------------------------------------------------------------------------------------------------ */

enum { BLOCK = 64 }; /* texels along an axis: sources are then four times as many at most */

static int blocks_along(int size) {
    return (size + BLOCK - 1) / BLOCK;
}

int enc_match_blocks(const enc_match *match) {
    return blocks_along(match->width) * blocks_along(match->height);
}

/* Finds the sources along an axis that any of `count` places from *io_first on reaches: *io_first becomes
 * the first of them. Returns their number. */
static int in_reach(int size, int count, int *io_first) {
    const int wanted = count + 2 * ENC_MATCH_REACH - 1;
    if (wanted >= size) {
        *io_first = 0;
        return size;
    }
    *io_first = (*io_first - ENC_MATCH_REACH + size) % size;
    return wanted;
}

enc_match_coordinates enc_match_block(const enc_match *match, size_t k, int block) {
    enc_match_coordinates at = {.k = k};
    const int across = blocks_along(match->width);
    at.block.x = at.sources.x = block % across * BLOCK;
    at.block.y = at.sources.y = block / across * BLOCK;
    at.block.width = match->width - at.block.x < BLOCK ? match->width - at.block.x : BLOCK;
    at.block.height = match->height - at.block.y < BLOCK ? match->height - at.block.y : BLOCK;
    if (match->whole) {
        at.sources = (enc_match_area){0, 0, match->width, match->height};
        return at;
    }
    at.sources.width = in_reach(match->width, at.block.width, &at.sources.x);
    at.sources.height = in_reach(match->height, at.block.height, &at.sources.y);
    return at;
}

uint64_t enc_match_block_memory(int width, int height, size_t views, size_t k, bool whole) {
    const enc_match match = {.width = width, .height = height, .whole = whole};
    const enc_match_coordinates at = enc_match_block(&match, k, 0);
    return sizeof(float) * views *
           (enc_match_area_texels(&at.block) * k + enc_match_area_texels(&at.sources) * (k + 1));
}

btf_result enc_match_coordinates_create(const enc_context *context, size_t views,
                                        enc_match_coordinates *at) {
    const size_t queries = views * enc_match_area_texels(&at->block),
                 sources = views * enc_match_area_texels(&at->sources);
    at->query = enc_gemm_alloc(queries * at->k);
    at->source = enc_gemm_alloc(sources * at->k);
    at->norm = enc_gemm_alloc(sources);
    if (at->query && at->source && at->norm) {
        return BTF_OK;
    }
    enc_match_coordinates_clear(at);
    return enc_fail(context, BTF_ERROR_MEMORY, "match: out of memory for %zu points", queries);
}

void enc_match_coordinates_clear(enc_match_coordinates *at) {
    free(at->query);
    free(at->source);
    free(at->norm);
    at->query = at->source = at->norm = NULL;
}

/* The squared error of a point's samples that its source and gain leave. */
static double left_at(const enc_match *match, const enc_match_coordinates *at, size_t view, size_t place) {
    const size_t texel = enc_match_texel(match, &at->block, place), x = view * match->texels + texel;
    const size_t source = view * enc_match_area_texels(&at->sources) +
                          enc_match_place(match, &at->sources, match->source[x]);
    const float gain = enc_match_gain(match, view, texel);
    const float *query = at->query + (view * enc_match_area_texels(&at->block) + place) * at->k;
    const double dot = enc_dot(at->k, query, at->source + source * at->k);
    return enc_dot(at->k, query, query) - gain * (2 * dot - gain * at->norm[source]);
}

btf_result enc_match_restrict(const enc_context *context, const enc_match_coordinates *at, size_t entries,
                              enc_match *match, double *io_error) {
    const size_t views = match->views, texels = enc_match_area_texels(&at->block);
    const size_t threads = (size_t)context->threads, each = workspace_floats(views, at->k);
    pair *pairs = malloc(threads * views * sizeof *pairs);
    float *work = malloc(threads * each * sizeof *work);
    double *sums = calloc(texels, sizeof *sums);
    const bool room = pairs && work && sums;
#pragma omp parallel for schedule(dynamic, 8) num_threads(context->threads) if (room)
    for (size_t x = 0; x < (room ? texels : 0); x++) {
        const size_t t = enc_thread_index();
        workspace w = {.pairs = pairs + t * views, .query = work + t * each};
        w.dot = w.query + views * at->k;
        w.value = w.dot + views * views;
        w.has = w.value + views * views;
        if (entries > 0) {
            restrict_texel(at, entries, x, &w, match);
        }
        for (size_t v = 0; v < views; v++) {
            sums[x] += left_at(match, at, v, x);
        }
    }
    for (size_t x = 0; x < texels && room; x++) {
        *io_error += sums[x];
    }
    free(pairs);
    free(work);
    free(sums);
    return room ? BTF_OK : enc_fail(context, BTF_ERROR_MEMORY, "match: out of memory for lists");
}
