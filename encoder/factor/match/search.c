/* Search by blocked matrix product. See search.h.
 *
 * |c - g z|^2 = |c|^2 - g (2 <c, z> - g |z|^2): a search wants, for each query c, the source z and the gain
 * g of the scale that make the last term greatest. A product of matrices finds <c, z> in the first few
 * coordinates alone, a tile of twelve queries by 32 sources at a time. As the distance in all of them is no
 * less, only sources that are near enough there are looked at in full.
 *
 * SPDX-License-Identifier: MIT
 */
#include "search.h"

#include "encoder/base/ranks.h"
#include "encoder/math/linear.h"
#include "locate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

enum {
    SCREEN = 16, /* coordinates that suffice to rule out most sources */
    SIDE = 16,   /* of a tile of texels that look at the same sources */
    EXACT = 64,  /* an axis of up to so many texels is looked at as a whole */
};

/* One search of a block in one view, with the memory of its thread. */
typedef struct view_search {
    const enc_factor_matrix *m;
    enc_match *match;
    const enc_match_coordinates *at;
    size_t k, view;
    const float *query, *source, *norm; /* of the view */
    float *inverse;                     /* [source]: 1 / (its squared length times the step of gains) */
    size_t screen;                      /* coordinates of panels */
    float *panels;     /* sources of a tile of texels, [panel][screen][32], as unit vectors */
    float *low, *high; /* their lengths times the least and the greatest gain */
    uint32_t *list;    /* the sources in the panels */
    uint32_t (*screener)(const float *dot, const float *low, const float *high, float threshold);
    double energy;
} view_search;

/* The source and the gain found for a point. */
typedef struct choice {
    uint32_t source; /* its place */
    float index;     /* of the gain */
    float value;
} choice;

/* The index of the gain, within the scale, that suits an inner product best. */
static float gain_index(const enc_match_gains *g, float dot, float inverse) {
    const float top = (float)(g->count - 1);
    float index = g->step > 0 ? dot * inverse - g->base / g->step : 0.0f;
    index = index > 0 ? index : 0.0f;
    index = index < top ? index : top;
    return (index + 0x1.8p23f) - 0x1.8p23f;
}

static choice look_at(const view_search *s, const float *query, uint32_t source) {
    const enc_match_gains *g = &s->match->gains;
    const float dot = enc_match_dot(s->k, query, s->source + source * s->k);
    const float index = gain_index(g, dot, s->inverse[source]), gain = g->base + g->step * index;
    return (choice){source, index, gain * (2 * dot - gain * s->norm[source])};
}

/* Which of 32 sources may be nearer than a threshold: t (2 d - t) over it, d their inner products as unit
 * vectors, t = d within low .. high. */
typedef uint32_t (*screen_fn)(const float *dot, const float *low, const float *high, float threshold);

static uint32_t screen_plain(const float *dot, const float *low, const float *high, float threshold) {
    uint32_t mask = 0;
    for (unsigned i = 0; i < ENC_GEMM_N; i++) {
        float t = dot[i] > low[i] ? dot[i] : low[i];
        t = t < high[i] ? t : high[i];
        mask |= (uint32_t)(t * (dot[i] + dot[i] - t) > threshold) << i;
    }
    return mask;
}

#if defined(__x86_64__)
__attribute__((target("avx512f"))) static uint32_t screen_avx512(const float *dot, const float *low,
                                                                 const float *high, float threshold) {
    uint32_t mask = 0;
    for (unsigned i = 0; i < ENC_GEMM_N; i += 16) {
        const __m512 d = _mm512_loadu_ps(dot + i);
        const __m512 t =
            _mm512_min_ps(_mm512_max_ps(d, _mm512_loadu_ps(low + i)), _mm512_loadu_ps(high + i));
        const __m512 value = _mm512_mul_ps(t, _mm512_sub_ps(_mm512_add_ps(d, d), t));
        mask |= (uint32_t)_mm512_cmp_ps_mask(value, _mm512_set1_ps(threshold), _CMP_GT_OQ) << i;
    }
    return mask;
}

__attribute__((target("avx2"))) static uint32_t screen_avx2(const float *dot, const float *low,
                                                            const float *high, float threshold) {
    uint32_t mask = 0;
    for (unsigned i = 0; i < ENC_GEMM_N; i += 8) {
        const __m256 d = _mm256_loadu_ps(dot + i);
        const __m256 t =
            _mm256_min_ps(_mm256_max_ps(d, _mm256_loadu_ps(low + i)), _mm256_loadu_ps(high + i));
        const __m256 value = _mm256_mul_ps(t, _mm256_sub_ps(_mm256_add_ps(d, d), t));
        mask |= (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(value, _mm256_set1_ps(threshold), _CMP_GT_OQ))
                << i;
    }
    return mask;
}
#endif

static screen_fn select_screen(void) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f")) {
        return screen_avx512;
    }
    if (__builtin_cpu_supports("avx2")) {
        return screen_avx2;
    }
#endif
    return screen_plain;
}

/* Finds the sources along an axis that each of the places first .. first + n - 1 reaches: *count of them,
 * from the place returned, around the circle. */
static int reach(int size, int first, int n, int *count) {
    if (size <= EXACT) {
        *count = size;
        return 0;
    }
    *count = 2 * ENC_MATCH_REACH - n + 1;
    return first + n - 1 - ENC_MATCH_REACH + size;
}

/* Packs the sources that the tile's texels look at; returns their panels. */
static size_t pack_sources(view_search *s, int column, int row, int columns, int rows) {
    const enc_match_gains *g = &s->match->gains;
    const int width = s->match->width, height = s->match->height;
    int across, down;
    const int x0 = reach(width, column, columns, &across), y0 = reach(height, row, rows, &down);
    const size_t count = (size_t)across * (size_t)down, panels = enc_gemm_panels(count, ENC_GEMM_N);
    for (size_t i = 0; i < panels * ENC_GEMM_N; i++) {
        /* Panels are filled up with the first source, which cannot win a second time. */
        const size_t at = i < count ? i : 0;
        const int x = (x0 + (int)at % across) % width, y = (y0 + (int)at / across) % height;
        const size_t source = enc_match_place(s->match, &s->at->sources, (size_t)(y * width + x));
        const float *from = s->source + source * s->k;
        float *to = s->panels + i / ENC_GEMM_N * ENC_GEMM_N * s->screen + i % ENC_GEMM_N;
        const float length = sqrtf(enc_match_dot(s->screen, from, from)),
                    inverse = length > 0 ? 1 / length : 0.0f;
        s->list[i] = (uint32_t)source;
        s->low[i] = length * g->base;
        s->high[i] = length * (g->base + g->step * (float)(g->count - 1));
        for (size_t d = 0; d < s->screen; d++) {
            to[d * ENC_GEMM_N] = from[d] * inverse;
        }
    }
    return panels;
}

/* Searches for `count` texels of the tile, at most ENC_GEMM_M. place: where each lies in the block. */
static void search_panel(view_search *s, size_t panels, size_t count, const uint32_t *texel,
                         const uint32_t *place, float *left) {
    _Alignas(64) float tile[ENC_GEMM_M * ENC_GEMM_N];
    choice best[ENC_GEMM_M];
    float margin[ENC_GEMM_M]; /* the most that coordinates beyond `screen` add to a value */
    double energy[ENC_GEMM_M];
    memset(left, 0, s->screen * ENC_GEMM_M * sizeof *left);
    for (size_t q = 0; q < count; q++) {
        const float *query = s->query + place[q] * s->k;
        energy[q] = enc_dot(s->k, query, query);
        margin[q] = (float)(energy[q] * (1 + 1e-5) - enc_dot(s->screen, query, query));
        const uint32_t now = s->match->source[s->view * s->m->texels + texel[q]];
        best[q] = look_at(s, query, (uint32_t)enc_match_place(s->match, &s->at->sources, now));
        for (size_t d = 0; d < s->screen; d++) {
            left[d * ENC_GEMM_M + q] = query[d];
        }
    }
    for (size_t p = 0; p < panels; p++) {
        s->m->tile(s->screen, left, s->panels + p * ENC_GEMM_N * s->screen, tile);
        for (size_t q = 0; q < count; q++) {
            uint32_t mask = s->screener(tile + q * ENC_GEMM_N, s->low + p * ENC_GEMM_N,
                                        s->high + p * ENC_GEMM_N, best[q].value - margin[q]);
            for (; mask; mask &= mask - 1) {
                const choice next = look_at(s, s->query + place[q] * s->k,
                                            s->list[p * ENC_GEMM_N + (size_t)__builtin_ctz(mask)]);
                best[q] = next.value > best[q].value ? next : best[q];
            }
        }
    }
    for (size_t q = 0; q < count; q++) {
        const size_t point = s->view * s->m->texels + texel[q];
        s->match->source[point] = (uint32_t)enc_match_texel(s->match, &s->at->sources, best[q].source);
        s->match->gain[point] = (uint8_t)best[q].index;
        s->energy += energy[q];
    }
}

static void search_tile(view_search *s, int column, int row, float *left) {
    const enc_match_area *block = &s->at->block;
    const int columns = block->x + block->width - column < SIDE ? block->x + block->width - column : SIDE,
              rows = block->y + block->height - row < SIDE ? block->y + block->height - row : SIDE;
    const size_t panels = pack_sources(s, column, row, columns, rows),
                 count = (size_t)columns * (size_t)rows;
    uint32_t texel[SIDE * SIDE], place[SIDE * SIDE];
    for (size_t i = 0; i < count; i++) {
        const int x = column + (int)i % columns, y = row + (int)i / columns;
        texel[i] = (uint32_t)(y * s->match->width + x);
        place[i] = (uint32_t)enc_match_place(s->match, block, texel[i]);
    }
    for (size_t i = 0; i < count; i += ENC_GEMM_M) {
        const size_t n = count - i < ENC_GEMM_M ? count - i : ENC_GEMM_M;
        search_panel(s, panels, n, texel + i, place + i, left);
    }
}

/* Searches for all texels of the block in one view. */
static void search_view(view_search *s, size_t most, float *work) {
    const enc_match_area *block = &s->at->block;
    const size_t sources = enc_match_area_texels(&s->at->sources);
    const float step = s->match->gains.step;
    s->inverse = work;
    float *left = enc_gemm_aligned(s->inverse + sources);
    s->panels = enc_gemm_aligned(left + ENC_GEMM_M * s->screen);
    s->low = s->panels + most * s->screen;
    s->high = s->low + most;
    s->list = (uint32_t *)(s->high + most);
    for (size_t z = 0; z < sources; z++) {
        s->inverse[z] = s->norm[z] > 0 && step > 0 ? 1 / (s->norm[z] * step) : 0.0f;
    }
    for (int row = block->y; row < block->y + block->height; row += SIDE) {
        for (int column = block->x; column < block->x + block->width; column += SIDE) {
            search_tile(s, column, row, left);
        }
    }
}

/* The most sources that a tile has, in whole panels. */
static size_t most_sources(const enc_match *match) {
    const size_t across = match->width <= EXACT ? (size_t)match->width : 2 * ENC_MATCH_REACH;
    const size_t down = match->height <= EXACT ? (size_t)match->height : 2 * ENC_MATCH_REACH;
    return enc_gemm_panels(across * down, ENC_GEMM_N) * ENC_GEMM_N;
}

btf_result enc_match_search(const enc_factor_matrix *m, const enc_match_coordinates *at, enc_match *match,
                            double *io_energy) {
    const size_t most = most_sources(match), views = match->views;
    const size_t texels = enc_match_area_texels(&at->block), sources = enc_match_area_texels(&at->sources);
    const size_t screen = at->k < SCREEN ? at->k : SCREEN;
    const size_t each = (sources + ENC_GEMM_M * screen + most * (screen + 3) + 64) / 16 * 16;
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    /* by view, and added up in the order of views, whatever thread or rank searched which */
    double *energy = calloc(views, sizeof *energy);
    const bool room = work && energy;
    size_t begin, end;
    enc_ranks_range(m->context, views, &begin, &end);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads) if (room)
    for (size_t v = begin; v < (room ? end : begin); v++) {
        view_search s = {.m = m,
                         .match = match,
                         .at = at,
                         .k = at->k,
                         .view = v,
                         .query = at->query + v * texels * at->k,
                         .source = at->source + v * sources * at->k,
                         .norm = at->norm + v * sources,
                         .screen = screen,
                         .screener = select_screen()};
        if (!enc_cancelled(m->context)) {
            search_view(&s, most, work + enc_thread_index() * each);
        }
        energy[v] = s.energy;
    }
    btf_result result = enc_ranks_agree(m->context, enc_match_outcome(m, room));
    if (result == BTF_OK) {
        result = enc_ranks_gather(m->context, result, energy, sizeof *energy, views);
        result =
            enc_ranks_gather(m->context, result, match->source, m->texels * sizeof *match->source, views);
        result = enc_ranks_gather(m->context, result, match->gain, m->texels, views);
    }
    for (size_t v = 0; v < views && result == BTF_OK; v++) {
        *io_energy += energy[v];
    }
    free(work);
    free(energy);
    return result;
}
