/* Search by blocked matrix product. See match_search.h.
 *
 * |c - g z|^2 = |c|^2 - g (2 <c, z> - g |z|^2): for each query c, the source z and the gain g of the scale
 * that make the last term greatest are wanted. A product of matrices finds <c, z> in the first few
 * coordinates alone, a tile of twelve queries by 32 sources at a time. As the distance in all of them is no
 * less, only sources that are near enough there are looked at in full.
 *
 * SPDX-License-Identifier: MIT
 */
#include "match_search.h"

#include "encoder/base/ranks.h"
#include "encoder/math/clones.h"
#include "encoder/math/linear.h"
#include "encoder/math/symmetric.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

enum {
    SCREEN = 16, /* coordinates that suffice to rule out most sources */
    SIDE = 16,   /* of a tile of texels that look at the same sources */
    EXACT = 64,  /* texels along an axis up to which all are looked at */
    SAMPLE = 512,
    POWER_STEPS = 2,
};

static btf_result no_memory(const enc_factor_matrix *m) {
    return enc_fail(m->context, BTF_ERROR_MEMORY, "match: out of memory for a search");
}

/* Leading directions.
 * ------------------------------------------------------------------------------------------------ */

/* Profiles of texels spread over the texture: [SAMPLE at most][length]. */
static size_t sample_profiles(const enc_factor_matrix *m, size_t view, float *out) {
    const size_t lights = (size_t)m->data->n_lights, step = m->texels > SAMPLE ? m->texels / SAMPLE : 1;
    size_t count = 0;
    for (size_t at = 0; at < m->texels && count < SAMPLE; at += step, count++) {
        float *row = out + count * 3 * lights;
        const size_t texel = (at + count * 7 % step) % m->texels;
        enc_factor_split_profile(m, texel, view, (float *const[3]){row, row + lights, row + 2 * lights});
    }
    return count;
}

/* out [k][length] += sum over rows of (q row) row, with q [k][length]. */
static void power_step(size_t k, size_t length, size_t count, const float *rows, const float *q,
                       float *out) {
    memset(out, 0, k * length * sizeof *out);
    for (size_t i = 0; i < count; i++) {
        const float *row = rows + i * length;
        for (size_t j = 0; j < k; j++) {
            float dot = 0, *to = out + j * length;
            dot = (float)enc_dot(length, q + j * length, row);
            for (size_t p = 0; p < length; p++) {
                to[p] += dot * row[p];
            }
        }
    }
}

/* Turns the basis so that falling energy of the rows' coordinates comes first. */
static bool order_basis(size_t k, size_t length, size_t count, const float *rows, const float *from,
                        float *basis) {
    double *gram = calloc(k * k, sizeof *gram), *at = malloc(2 * k * sizeof *at);
    bool done = gram && at;
    for (size_t i = 0; i < count && done; i++) {
        for (size_t j = 0; j < k; j++) {
            at[j] = enc_dot(length, from + j * length, rows + i * length);
            for (size_t p = 0; p <= j; p++) {
                gram[j * k + p] = gram[p * k + j] += at[j] * at[p];
            }
        }
    }
    done = done && enc_eigen_symmetric(k, gram, at + k);
    for (size_t j = 0; j < k && done; j++) {
        memset(basis + j * length, 0, length * sizeof *basis);
        for (size_t p = 0; p < k; p++) {
            for (size_t i = 0; i < length; i++) {
                basis[j * length + i] += (float)gram[j * k + p] * from[p * length + i];
            }
        }
    }
    free(gram);
    free(at);
    return done;
}

/* work: profiles, and twice the basis. */
static bool find_basis(const enc_factor_matrix *m, size_t view, size_t k, size_t length, float *work,
                       float *basis) {
    float *rows = work, *q = work + SAMPLE * length, *lower = q + k * length;
    const size_t count = sample_profiles(m, view, rows);
    uint64_t state = view + 1;
    bool room = true;
    for (size_t i = 0; i < k * length; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        q[i] = (float)(int32_t)(state >> 32) * 0x1p-31f;
    }
    for (int step = 0; step < POWER_STEPS && room; step++) {
        power_step(k, length, count, rows, q, basis);
        memcpy(q, basis, k * length * sizeof *q);
        room = enc_orthonormal_rows(k, length, q, basis, lower);
        memcpy(q, basis, k * length * sizeof *q);
    }
    return room && order_basis(k, length, count, rows, q, basis);
}

btf_result enc_match_find_bases(const enc_factor_matrix *m, enc_match_bases *out) {
    const size_t length = 3 * (size_t)m->data->n_lights, views = (size_t)m->data->n_views;
    const size_t k = length < ENC_MATCH_LEADING ? length : ENC_MATCH_LEADING;
    const size_t each = (SAMPLE + k) * length + k * k;
    bool room = true;
    *out = (enc_match_bases){.leading = k, .length = length, .basis = enc_gemm_alloc(views * k * length)};
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    if (!out->basis || !work) {
        free(work);
        enc_match_bases_clear(out);
        return enc_ranks_agree(m->context, no_memory(m));
    }
    size_t begin, end;
    enc_ranks_range(m->context, views, &begin, &end);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads)
    for (size_t v = begin; v < end; v++) {
        if (!find_basis(m, v, k, length, work + enc_thread_index() * each, out->basis + v * k * length)) {
#pragma omp atomic write
            room = false;
        }
    }
    free(work);
    return enc_ranks_gather(m->context, room ? BTF_OK : no_memory(m), out->basis,
                            k * length * sizeof(float), views);
}

void enc_match_bases_clear(enc_match_bases *bases) {
    free(bases->basis);
    *bases = (enc_match_bases){0};
}

/* Coordinates.
 * ------------------------------------------------------------------------------------------------ */

/* One view of a block while its profiles are projected. */
typedef struct projector {
    const enc_factor_matrix *m;
    const enc_factor_codes *codes;
    const enc_match *match;
    const enc_match_coordinates *at;
    const float *packed_u; /* [panel of ENC_GEMM_M sources][channel, component][ENC_GEMM_M] */
    size_t components, view, length;
    const float *basis;
} projector;

static float *aligned(float *at) {
    return (float *)(((uintptr_t)at + 63) / 64 * 64);
}

/* out [count][k] = rows [count][length] basis^T, count at most ENC_GEMM_M. */
static void project(const projector *p, size_t count, const float *rows, const float *packed_basis,
                    float *left, float *out) {
    enc_gemm_pack_rows(count, p->length, rows, p->length, ENC_GEMM_M, left);
    enc_gemm_multiply(p->m->tile, count, p->at->k, p->length, left, packed_basis, out, p->at->k, 0);
}

/* Coordinates of the profiles of the block's texels. */
static void find_queries(const projector *p, float *work) {
    const size_t length = p->length, lights = length / 3, texels = enc_match_area_texels(&p->at->block);
    float *basis = aligned(work), *left = aligned(basis + 2 * ENC_GEMM_N * length),
          *rows = left + ENC_GEMM_M * length, *out = p->at->query + p->view * texels * p->at->k;
    enc_gemm_pack_rows(p->at->k, length, p->basis, length, ENC_GEMM_N, basis);
    for (size_t first = 0; first < texels; first += ENC_GEMM_M) {
        const size_t n = texels - first < ENC_GEMM_M ? texels - first : ENC_GEMM_M;
        for (size_t i = 0; i < n; i++) {
            float *row = rows + i * length;
            enc_factor_split_profile(p->m, enc_match_texel(p->match, &p->at->block, first + i), p->view,
                                     (float *const[3]){row, row + lights, row + 2 * lights});
        }
        project(p, n, rows, basis, left, out + first * p->at->k);
    }
}

/* Coordinates of the sources' profiles as their factors give them: u times the view's w in the basis. */
static void find_sources(const projector *p, float *work) {
    const size_t lights = p->length / 3, k = p->at->k, panels = enc_gemm_panels(k, ENC_GEMM_N);
    const size_t sources = enc_match_area_texels(&p->at->sources);
    float *turned = aligned(work); /* [panel][component][ENC_GEMM_N] */
    float *out = p->at->source + p->view * sources * k, *norm = p->at->norm + p->view * sources;
    memset(turned, 0, panels * ENC_GEMM_N * p->components * sizeof *turned);
    for (size_t c = 0, row = 0; c < ENC_FACTOR_CHANNELS; c++) {
        for (size_t j = 0; j < p->codes->channel[c].rank; j++, row++) {
            const float *w = p->codes->channel[c].w + j * p->codes->columns + p->view * lights;
            for (size_t d = 0; d < k; d++) {
                turned[(d / ENC_GEMM_N * p->components + row) * ENC_GEMM_N + d % ENC_GEMM_N] =
                    (float)enc_dot(lights, w, p->basis + d * p->length + c * lights);
            }
        }
    }
    enc_gemm_multiply(p->m->tile, sources, k, p->components, p->packed_u, turned, out, k, 0);
    for (size_t z = 0; z < sources; z++) {
        norm[z] = (float)enc_dot(k, out + z * k, out + z * k);
    }
}

/* u of all channels, sources in panels. */
static void pack_u(const enc_factor_matrix *m, const enc_factor_codes *codes, const enc_match *match,
                   const enc_match_area *area, size_t components, float *out) {
    const size_t sources = enc_match_area_texels(area);
#pragma omp parallel for schedule(static) num_threads(m->context->threads)
    for (size_t first = 0; first < sources; first += ENC_GEMM_M) {
        float *to = out + first * components;
        memset(to, 0, ENC_GEMM_M * components * sizeof *to);
        for (size_t i = 0; i < ENC_GEMM_M && first + i < sources; i++) {
            const size_t texel = enc_match_texel(match, area, first + i);
            for (size_t c = 0, row = 0; c < ENC_FACTOR_CHANNELS; c++) {
                for (size_t j = 0; j < codes->channel[c].rank; j++, row++) {
                    to[row * ENC_GEMM_M + i] = codes->channel[c].u[j * m->texels + texel];
                }
            }
        }
    }
}

/* The result of an allocation, or BTF_ERROR_INTERRUPTED where the user wants to stop. */
static btf_result outcome(const enc_factor_matrix *m, bool room) {
    return !room ? no_memory(m) : enc_cancelled(m->context) ? BTF_ERROR_INTERRUPTED : BTF_OK;
}

static const float *basis_of(const enc_match_bases *bases, size_t view) {
    return bases->basis + view * bases->leading * bases->length;
}

/* Ranks share the views. */
btf_result enc_match_locate_points(const enc_factor_matrix *m, const enc_match_bases *bases,
                                   const enc_match *match, enc_match_coordinates *at) {
    const size_t each = ((2 * ENC_GEMM_N + 2 * ENC_GEMM_M) * bases->length + 64) / 16 * 16;
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    size_t begin, end;
    enc_ranks_range(m->context, match->views, &begin, &end);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads) if (work)
    for (size_t v = begin; v < (work ? end : begin); v++) {
        const projector p = {.m = m,
                             .match = match,
                             .at = at,
                             .view = v,
                             .length = bases->length,
                             .basis = basis_of(bases, v)};
        if (!enc_cancelled(m->context)) {
            find_queries(&p, work + enc_thread_index() * each);
        }
    }
    const btf_result result = outcome(m, work);
    free(work);
    return enc_ranks_gather(m->context, result, at->query,
                            enc_match_area_texels(&at->block) * at->k * sizeof *at->query, match->views);
}

btf_result enc_match_locate_sources(const enc_factor_matrix *m, const enc_factor_codes *codes,
                                    const enc_match_bases *bases, const enc_match *match,
                                    enc_match_coordinates *at) {
    const size_t components = codes->channel[0].rank + codes->channel[1].rank + codes->channel[2].rank;
    const size_t sources = enc_match_area_texels(&at->sources);
    const size_t each = ((bases->leading + ENC_GEMM_N) * components + 64) / 16 * 16;
    float *packed = enc_gemm_alloc((sources + ENC_GEMM_M) * components);
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    const bool room = packed && work;
    size_t begin, end;
    enc_ranks_range(m->context, match->views, &begin, &end);
    if (room) {
        pack_u(m, codes, match, &at->sources, components, packed);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads)
        for (size_t v = begin; v < end; v++) {
            const projector p = {.m = m,
                                 .codes = codes,
                                 .match = match,
                                 .at = at,
                                 .packed_u = packed,
                                 .components = components,
                                 .view = v,
                                 .length = bases->length,
                                 .basis = basis_of(bases, v)};
            if (!enc_cancelled(m->context)) {
                find_sources(&p, work + enc_thread_index() * each);
            }
        }
    }
    free(packed);
    free(work);
    const btf_result result = enc_ranks_gather(m->context, outcome(m, room), at->source,
                                               sources * at->k * sizeof *at->source, match->views);
    return enc_ranks_gather(m->context, result, at->norm, sources * sizeof *at->norm, match->views);
}

/* The nearest.
 * ------------------------------------------------------------------------------------------------ */

/* One search of a block in one view, with the memory of its thread. */
typedef struct view_search {
    const enc_factor_matrix *m;
    enc_match *match;
    const enc_match_coordinates *at;
    size_t k, view;
    const float *query, *source, *norm; /* of the view */
    float *inverse;                     /* [source]: of its squared length times the step of gains */
    size_t screen;                      /* coordinates of panels */
    float *panels;                      /* sources of a tile of texels, [panel][screen][32], as unit vectors */
    float *low, *high;                  /* their lengths times the least and the greatest gain */
    uint32_t *list;                     /* the sources in the panels */
    uint32_t (*screener)(const float *dot, const float *low, const float *high, float threshold);
    double energy;
} view_search;

/* The source and the gain found for a point. */
typedef struct choice {
    uint32_t source; /* its place */
    float index; /* of the gain */
    float value;
} choice;

/* The index of the gain of the scale that suits an inner product best. */
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

/* Sources along an axis that all of the places first .. first + n - 1 reach: out of them `count`, from the
 * return value on, around the circle. */
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
        const size_t at = i < count ? i : 0; /* the first again, which then never wins */
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

/* `count` texels of the tile, at most ENC_GEMM_M: texel, and where they lie in the block. */
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

/* All of the block in one view. */
static void search_view(view_search *s, size_t most, float *work) {
    const enc_match_area *block = &s->at->block;
    const size_t sources = enc_match_area_texels(&s->at->sources);
    const float step = s->match->gains.step;
    s->inverse = work;
    float *left = aligned(s->inverse + sources);
    s->panels = aligned(left + ENC_GEMM_M * s->screen);
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

/* The sources of a tile at most, whole panels. */
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
    btf_result result = enc_ranks_agree(m->context, outcome(m, room));
    if (result == BTF_OK) {
        result = enc_ranks_gather(m->context, result, energy, sizeof *energy, views);
        result = enc_ranks_gather(m->context, result, match->source, m->texels * sizeof *match->source,
                                  views);
        result = enc_ranks_gather(m->context, result, match->gain, m->texels, views);
    }
    for (size_t v = 0; v < views && result == BTF_OK; v++) {
        *io_energy += energy[v];
    }
    free(work);
    free(energy);
    return result;
}
