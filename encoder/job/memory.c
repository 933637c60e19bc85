/* Sums of the memory that stages allocate (see memory.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "memory.h"

#include "encoder/data/data.h"
#include "encoder/factor/factor.h"
#include "encoder/paper/flow.h"

enum { PROGRAM = 24 << 20 }; /* the program itself, with its libraries */

/* The extent of a data set. */
typedef struct extent {
    uint64_t texels, side, views, lights, points, row, image_view, threads; /* side: the longer one */
} extent;

static uint64_t larger(uint64_t a, uint64_t b) {
    return a > b ? a : b;
}

/* Bytes that every method takes: to read, one image for each thread and the planes of one view; to measure,
 * two views. */
static uint64_t common(const extent *e) {
    return larger(e->image_view + e->texels * 12 * (1 + 3 * e->threads),
                  2 * e->image_view + e->texels * 24);
}

static uint64_t paper(const extent *e) {
    const uint64_t lanes = (e->lights + 15) / 16 * 16;
    const uint64_t held =
        e->texels * (68 + 56 + e->lights) + e->points * (2 + 1 + 1 + 4 + 2) + 3 * e->points;
    const uint64_t fit = e->threads * e->views * e->lights * (13 * 4 + 1 + 16 * 12);
    const uint64_t flow = enc_flow_bytes(e->texels, e->side, e->lights) +
                          e->texels * (ENC_FLOW_PRIOR_LIGHTS * 12 + 11 * e->lights);
    const uint64_t refine = e->image_view + e->texels * (2 * 12 * lanes + 2 * 4 * 48 + 4);
    return held + larger(larger(fit, flow), larger(refine, common(e)));
}

static extent extent_of(int width, int height, int n_views, int n_lights, int threads) {
    extent e = {.texels = (uint64_t)width * (uint64_t)height,
                .side = (uint64_t)(width > height ? width : height),
                .views = (uint64_t)n_views,
                .lights = (uint64_t)n_lights,
                .threads = threads > 0 ? (uint64_t)threads : 1};
    e.points = e.texels * e.views;
    e.row = 3 * e.lights;
    e.image_view = 4 * e.texels * e.row;
    return e;
}

/* Adds a third for what the allocator wastes. */
static uint64_t with_slack(uint64_t sum) {
    return sum + sum / 3;
}

uint64_t enc_memory_least_paper(int width, int height, int n_views, int n_lights, int threads) {
    const extent e = extent_of(width, height, n_views, n_lights, threads);
    return with_slack(paper(&e));
}

/* Bytes that factors take in the larger of two stages: the analysis, which has few and large arrays, and
 * decoding, which has the profiles of a view and the maps of every point. */
static uint64_t factors(const extent *e, int width, int height, uint64_t budget, int threads) {
    const uint64_t analysis =
        enc_factor_memory(width, height, (int)e->views, (int)e->lights, budget, threads);
    const uint64_t held = 3 * budget + 5 * e->points,
                   components = budget * 8 / 2 / (e->texels + e->views * e->lights);
    const uint64_t levels = 2 * e->views * e->lights * components; /* levels of w while errors are measured */
    return larger(analysis + analysis / 16, with_slack(held + levels + common(e)));
}

uint64_t enc_memory_of_factors(int width, int height, int n_views, int n_lights, int threads,
                               uint64_t budget) {
    const extent e = extent_of(width, height, n_views, n_lights, threads);
    return factors(&e, width, height, budget, threads > 0 ? threads : 1);
}

uint64_t enc_memory_least_joint(int width, int height, int n_views, int n_lights, int threads) {
    return enc_memory_of_factors(width, height, n_views, n_lights, threads,
                                 enc_default_budget(width, height, n_views, n_lights));
}

enc_least_memory enc_memory_least(enc_method method) {
    static const enc_least_memory least[ENC_METHODS] = {enc_memory_least_joint, enc_memory_least_paper};
    return least[method];
}

enc_memory_use enc_memory_expected(const enc_context *context, enc_method method, int width, int height,
                                   int n_views, int n_lights, uint64_t budget, bool made, bool fitted) {
    const extent e = extent_of(width, height, n_views, n_lights, context->threads);
    const uint64_t samples = e.image_view * e.views;
    const bool kept = enc_data_fits(context, width, height, n_views, n_lights);
    enc_memory_use use = {PROGRAM, 0};
    use.peak += method == ENC_METHOD_PAPER ? paper(&e)
                                           : factors(&e, width, height, budget, context->threads);
    if (kept) {
        use.peak += samples;
    }
    if (kept && method == ENC_METHOD_JOINT) {
        const uint64_t match = enc_factor_match_memory(width, height, n_views, budget, false),
                       whole = enc_factor_match_memory(width, height, n_views, budget, true);
        const uint64_t left = context->memory == 0         ? UINT64_MAX
                              : use.peak < context->memory ? context->memory - use.peak
                                                           : 0;
        use.peak += whole <= left ? whole : match <= left ? match : 0;
    }
    else if (!made) {
        use.scratch += samples;
    }
    if (fitted && kept && (context->memory == 0 || samples <= (context->memory - samples) / 2)) {
        use.peak += samples;
    } else if (fitted) {
        use.scratch += samples;
    }
    return use;
}
