/* Greedy choice of a texel's list. See match_lists.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "match_lists.h"

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

/* value[pair][view]: how much of the energy of the view's profile the pair takes. place: of the texel. */
static void fill_values(const enc_match *match, const enc_match_coordinates *at, size_t place, size_t count,
                        const pair *pairs, float *value) {
    const size_t texels = enc_match_area_texels(&at->block), all = enc_match_area_texels(&at->sources);
    for (size_t i = 0; i < count; i++) {
        const size_t source = enc_match_place(match, &at->sources, pairs[i].source);
        const float gain = match->gains.base + match->gains.step * (float)pairs[i].gain;
        for (size_t v = 0; v < match->views; v++) {
            const float *query = at->query + (v * texels + place) * at->k;
            const float dot = enc_match_dot(at->k, query, at->source + (v * all + source) * at->k);
            value[i * match->views + v] = gain * (2 * dot - gain * at->norm[v * all + source]);
        }
    }
}

/* The pair that adds most to what the views have. */
static size_t best_pair(size_t views, size_t count, const float *value, const float *has) {
    size_t best = 0;
    double most = -HUGE_VAL;
    for (size_t i = 0; i < count; i++) {
        double sum = 0;
        for (size_t v = 0; v < views; v++) {
            sum += fmaxf(value[i * views + v], has[v]);
        }
        if (sum > most) {
            most = sum;
            best = i;
        }
    }
    return best;
}

/* One texel. has [view]: room. */
static void restrict_texel(const enc_match_coordinates *at, size_t entries, size_t place, pair *pairs,
                             float *value, float *has, enc_match *match) {
    const size_t texel = enc_match_texel(match, &at->block, place);
    const size_t views = match->views, count = distinct_pairs(match, texel, pairs);
    fill_values(match, at, place, count, pairs, value);
    for (size_t v = 0; v < views; v++) {
        has[v] = -FLT_MAX;
    }
    for (size_t n = 0; n < entries && n < count; n++) {
        const size_t best = best_pair(views, count, value, has);
        for (size_t v = 0; v < views; v++) {
            if (value[best * views + v] > has[v]) {
                has[v] = value[best * views + v];
                match->source[v * match->texels + texel] = pairs[best].source;
                match->gain[v * match->texels + texel] = pairs[best].gain;
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

/* Sources in reach of `count` places from *io_first on: their number, and *io_first of them. */
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
    at.sources.width = in_reach(match->width, at.block.width, &at.sources.x);
    at.sources.height = in_reach(match->height, at.block.height, &at.sources.y);
    return at;
}

uint64_t enc_match_block_memory(int width, int height, size_t views, size_t k) {
    const enc_match match = {.width = width, .height = height};
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
    const size_t threads = (size_t)context->threads;
    pair *pairs = malloc(threads * views * sizeof *pairs);
    float *value = malloc(threads * views * (views + 1) * sizeof *value);
    double *sums = calloc(texels, sizeof *sums);
    const bool room = pairs && value && sums;
#pragma omp parallel for schedule(dynamic, 8) num_threads(context->threads) if (room)
    for (size_t x = 0; x < (room ? texels : 0); x++) {
        const size_t t = enc_thread_index();
        float *mine = value + t * views * (views + 1);
        if (entries > 0) {
            restrict_texel(at, entries, x, pairs + t * views, mine, mine + views * views, match);
        }
        for (size_t v = 0; v < views; v++) {
            sums[x] += left_at(match, at, v, x);
        }
    }
    for (size_t x = 0; x < texels && room; x++) {
        *io_error += sums[x];
    }
    free(pairs);
    free(value);
    free(sums);
    return room ? BTF_OK : enc_fail(context, BTF_ERROR_MEMORY, "match: out of memory for lists");
}
