/* Search by blocked matrix product. See match_search.h.
 *
 * |c - g z|^2 = |c|^2 - g (2 <c, z> - g |z|^2): for each query c, the source z and the gain g of the scale that make
 * the last term greatest are wanted. A tile of the product has twelve queries by 32 sources; each lane keeps its best.
 *
 * SPDX-License-Identifier: MIT
 */
#include "match_search.h"

#include "encoder/math/linear.h"
#include "vectors.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    LANES = 16,
    SIDE = 16,  /* of a tile of texels that look at the same sources */
    EXACT = 64, /* texels along an axis up to which all are looked at */
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
static void power_step(size_t k, size_t length, size_t count, const float *rows, const float *q, float *out) {
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

/* work: profiles, and twice the basis. */
static bool find_basis(const enc_factor_matrix *m, size_t view, size_t k, size_t length, float *work, float *basis) {
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
    return room;
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
        return no_memory(m);
    }
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads)
    for (size_t v = 0; v < views; v++) {
        if (!find_basis(m, v, k, length, work + enc_thread_index() * each, out->basis + v * k * length)) {
#pragma omp atomic write
            room = false;
        }
    }
    free(work);
    return room ? BTF_OK : no_memory(m);
}

void enc_match_bases_clear(enc_match_bases *bases) {
    free(bases->basis);
    *bases = (enc_match_bases){0};
}

/* Coordinates.
 * ------------------------------------------------------------------------------------------------ */

/* One search of one view, with what a thread works in. */
typedef struct view_search {
    const enc_factor_matrix *m;
    const enc_factor_codes *codes;
    const float *packed_u; /* [panel of ENC_GEMM_M texels][channel, component][ENC_GEMM_M] */
    size_t components, k, view;
    const float *basis;
    enc_match *match;
    float *query, *source; /* [texel][k] */
    float *norm, *inverse; /* [texel] of sources: squared length; its inverse over the step of gains */
    float *panels, *lows;  /* packed sources of a tile of texels, [panel][k][32]; their norms and inverses */
    uint32_t *list;        /* which sources they are */
    double error, energy;
} view_search;

static size_t thread_floats(const enc_factor_matrix *m, size_t k, size_t length, size_t components, size_t most) {
    const size_t queries = 2 * m->texels * (k + 1) + 4 * ENC_GEMM_M * k;
    const size_t coordinates = components * 2 * ENC_GEMM_N + (length + k) * 2 * ENC_GEMM_N + ENC_GEMM_M * length * 2;
    return (queries + coordinates + most * (k + 3) + 256) / 16 * 16 + 4096;
}

/* out [count][k] = rows [count][length] basis^T, count at most ENC_GEMM_M. */
static void project(const view_search *s, size_t count, const float *rows, size_t length, const float *packed_basis,
                    float *left, float *out) {
    enc_gemm_pack_rows(count, length, rows, length, ENC_GEMM_M, left);
    enc_gemm_multiply(s->m->tile, count, s->k, length, left, packed_basis, out, s->k, 0);
}

static float *aligned(float *at) {
    return (float *)(((uintptr_t)at + 63) / 64 * 64);
}

/* Coordinates of the texels' profiles. */
static void find_queries(const view_search *s, size_t length, float *work) {
    const size_t lights = length / 3;
    float *basis = aligned(work), *left = aligned(basis + 2 * ENC_GEMM_N * length), *rows = left + ENC_GEMM_M * length;
    enc_gemm_pack_rows(s->k, length, s->basis, length, ENC_GEMM_N, basis);
    for (size_t first = 0; first < s->m->texels; first += ENC_GEMM_M) {
        const size_t n = s->m->texels - first < ENC_GEMM_M ? s->m->texels - first : ENC_GEMM_M;
        for (size_t i = 0; i < n; i++) {
            float *row = rows + i * length;
            enc_factor_split_profile(s->m, first + i, s->view, (float *const[3]){row, row + lights, row + 2 * lights});
        }
        project(s, n, rows, length, basis, left, s->query + first * s->k);
    }
}

/* Coordinates of what the sources' factors give: u times the view's w in the basis. */
static void find_sources(const view_search *s, size_t length, float *work) {
    const size_t lights = length / 3, panels = enc_gemm_panels(s->k, ENC_GEMM_N);
    float *turned = aligned(work); /* [panel][component][ENC_GEMM_N] */
    memset(turned, 0, panels * ENC_GEMM_N * s->components * sizeof *turned);
    for (size_t c = 0, row = 0; c < ENC_FACTOR_CHANNELS; c++) {
        for (size_t j = 0; j < s->codes->channel[c].rank; j++, row++) {
            const float *w = s->codes->channel[c].w + j * s->codes->columns + s->view * lights;
            for (size_t d = 0; d < s->k; d++) {
                turned[(d / ENC_GEMM_N * s->components + row) * ENC_GEMM_N + d % ENC_GEMM_N] =
                    (float)enc_dot(lights, w, s->basis + d * length + c * lights);
            }
        }
    }
    enc_gemm_multiply(s->m->tile, s->m->texels, s->k, s->components, s->packed_u, turned, s->source, s->k, 0);
    const float step = s->match->gains.step;
    for (size_t z = 0; z < s->m->texels; z++) {
        s->norm[z] = (float)enc_dot(s->k, s->source + z * s->k, s->source + z * s->k);
        s->inverse[z] = s->norm[z] > 0 && step > 0 ? 1 / (s->norm[z] * step) : 0.0f;
    }
}

/* The nearest.
 * ------------------------------------------------------------------------------------------------ */

typedef struct nearest {
    float value[ENC_GEMM_M][LANES], gain[ENC_GEMM_M][LANES], at[ENC_GEMM_M][LANES];
} nearest;

/* The index of the gain of the scale for inner products, and the term that it makes great. */
static inline __attribute__((always_inline)) float gain_index(float dot, float inverse, float offset, float top) {
    float index = dot * inverse - offset;
    index = index > 0 ? index : 0.0f;
    index = index < top ? index : top;
    return (index + 0x1.8p23f) - 0x1.8p23f;
}

ENC_FACTOR_CLONES static void take_tile(const float *restrict tile, const float *restrict norm,
                                        const float *restrict inverse, float base, float step, float offset, float top,
                                        float at, nearest *restrict best) {
    for (size_t q = 0; q < ENC_GEMM_M; q++) {
        for (size_t half = 0; half < ENC_GEMM_N; half += LANES) {
            for (size_t i = 0; i < LANES; i++) {
                const float dot = tile[q * ENC_GEMM_N + half + i];
                const float index = gain_index(dot, inverse[half + i], offset, top);
                const float gain = base + step * index;
                const float value = gain * (2 * dot - gain * norm[half + i]);
                const int better = value > best->value[q][i];
                best->value[q][i] = better ? value : best->value[q][i];
                best->gain[q][i] = better ? index : best->gain[q][i];
                best->at[q][i] = better ? at + (float)half : best->at[q][i];
            }
        }
    }
}

/* What a point has, and what was found for it. */
static void take_point(view_search *s, size_t texel, const nearest *best, size_t q) {
    const enc_match_gains *g = &s->match->gains;
    const size_t point = s->view * s->m->texels + texel;
    const float *c = s->query + texel * s->k;
    const uint32_t now = s->match->source[point];
    const float offset = g->step > 0 ? g->base / g->step : 0.0f;
    const float dot = (float)enc_dot(s->k, c, s->source + now * s->k);
    const float index = gain_index(dot, s->inverse[now], offset, (float)(g->count - 1));
    const float gain = g->base + g->step * index;
    float value = gain * (2 * dot - gain * s->norm[now]);
    const double energy = enc_dot(s->k, c, c);
    s->match->gain[point] = (uint8_t)index;
    size_t lane = 0;
    for (size_t i = 1; i < LANES; i++) {
        const bool equal = best->value[q][i] == best->value[q][lane];
        if (best->value[q][i] > best->value[q][lane] || (equal && best->at[q][i] < best->at[q][lane])) {
            lane = i;
        }
    }
    if (best->value[q][lane] > value + 1e-6f * (float)energy) {
        value = best->value[q][lane];
        s->match->source[point] = s->list[(size_t)best->at[q][lane] + lane];
        s->match->gain[point] = (uint8_t)best->gain[q][lane];
    }
    s->error += energy - value;
    s->energy += energy;
}

/* Sources along an axis that all of the places first .. first + n - 1 reach: out of them `count`, from the return
 * value on, around the circle. */
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
    const int width = s->match->width, height = s->match->height;
    int across, down;
    const int x0 = reach(width, column, columns, &across), y0 = reach(height, row, rows, &down);
    const size_t count = (size_t)across * (size_t)down, panels = enc_gemm_panels(count, ENC_GEMM_N);
    float *norm = s->lows, *inverse = s->lows + panels * ENC_GEMM_N;
    for (size_t i = 0; i < panels * ENC_GEMM_N; i++) {
        const size_t at = i < count ? i : 0; /* the first again, which then never wins */
        const int x = (x0 + (int)at % across) % width, y = (y0 + (int)at / across) % height;
        const uint32_t source = (uint32_t)(y * width + x);
        float *to = s->panels + i / ENC_GEMM_N * ENC_GEMM_N * s->k + i % ENC_GEMM_N;
        s->list[i] = source;
        norm[i] = s->norm[source];
        inverse[i] = s->inverse[source];
        for (size_t d = 0; d < s->k; d++) {
            to[d * ENC_GEMM_N] = s->source[source * s->k + d];
        }
    }
    return panels;
}

/* `count` texels of the tile, at most ENC_GEMM_M. */
static void search_panel(view_search *s, size_t panels, size_t count, const uint32_t *texel, float *left) {
    const enc_match_gains *g = &s->match->gains;
    const float offset = g->step > 0 ? g->base / g->step : 0.0f, top = (float)(g->count - 1);
    _Alignas(64) float tile[ENC_GEMM_M * ENC_GEMM_N];
    nearest best;
    memset(&best, 0, sizeof best);
    for (size_t q = 0; q < ENC_GEMM_M; q++) {
        for (size_t i = 0; i < LANES; i++) {
            best.value[q][i] = -FLT_MAX;
        }
        for (size_t d = 0; d < s->k; d++) {
            left[d * ENC_GEMM_M + q] = q < count ? s->query[texel[q] * s->k + d] : 0.0f;
        }
    }
    for (size_t p = 0; p < panels; p++) {
        s->m->tile(s->k, left, s->panels + p * ENC_GEMM_N * s->k, tile);
        take_tile(tile, s->lows + p * ENC_GEMM_N, s->lows + (panels + p) * ENC_GEMM_N, g->base, g->step, offset, top,
                  (float)(p * ENC_GEMM_N), &best);
    }
    for (size_t q = 0; q < count; q++) {
        take_point(s, texel[q], &best, q);
    }
}

static void search_tile(view_search *s, int column, int row, float *left) {
    const int width = s->match->width, height = s->match->height;
    const int columns = width - column < SIDE ? width - column : SIDE, rows = height - row < SIDE ? height - row : SIDE;
    const size_t panels = pack_sources(s, column, row, columns, rows), count = (size_t)columns * (size_t)rows;
    uint32_t texel[SIDE * SIDE];
    for (size_t i = 0; i < count; i++) {
        const int x = column + (int)i % columns, y = row + (int)i / columns;
        texel[i] = (uint32_t)(y * width + x);
    }
    for (size_t i = 0; i < count; i += ENC_GEMM_M) {
        search_panel(s, panels, count - i < ENC_GEMM_M ? count - i : ENC_GEMM_M, texel + i, left);
    }
}

/* All of one view. */
static void search_view(view_search *s, size_t length, size_t most, float *work) {
    const size_t texels = s->m->texels;
    s->query = work;
    s->source = s->query + texels * s->k;
    s->norm = s->source + texels * s->k;
    s->inverse = s->norm + texels;
    float *left = aligned(s->inverse + texels);
    s->panels = aligned(left + ENC_GEMM_M * s->k);
    s->lows = s->panels + most * s->k;
    s->list = (uint32_t *)(s->lows + 2 * most);
    float *rest = aligned(s->lows + 3 * most);
    find_queries(s, length, rest);
    find_sources(s, length, rest);
    for (int row = 0; row < s->match->height; row += SIDE) {
        for (int column = 0; column < s->match->width; column += SIDE) {
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

/* u of all channels, texels in panels. */
static void pack_u(const enc_factor_matrix *m, const enc_factor_codes *codes, size_t components, float *out) {
#pragma omp parallel for schedule(static) num_threads(m->context->threads)
    for (size_t first = 0; first < m->texels; first += ENC_GEMM_M) {
        const size_t n = m->texels - first < ENC_GEMM_M ? m->texels - first : ENC_GEMM_M;
        float *to = out + first * components;
        for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
            const enc_factor_channel *channel = &codes->channel[c];
            enc_gemm_pack_columns(n, channel->rank, channel->u + first, m->texels, ENC_GEMM_M, to);
            to += channel->rank * ENC_GEMM_M;
        }
    }
}

btf_result enc_match_search(const enc_factor_matrix *m, const enc_factor_codes *codes, const enc_match_bases *bases,
                            size_t first, size_t stride, enc_match *match, double *out_error, double *out_energy) {
    const size_t components = codes->channel[0].rank + codes->channel[1].rank + codes->channel[2].rank;
    const size_t most = most_sources(match), views = match->views;
    const size_t each = thread_floats(m, bases->leading, bases->length, components, most);
    float *packed = enc_gemm_alloc((m->texels + ENC_GEMM_M) * components);
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    double *sums = calloc(2 * views, sizeof *sums);
    btf_result result = packed && work && sums ? BTF_OK : no_memory(m);
    if (result == BTF_OK) {
        pack_u(m, codes, components, packed);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads)
        for (size_t v = first; v < views; v += stride) {
            view_search s = {.m = m, .codes = codes, .packed_u = packed, .components = components,
                             .k = bases->leading, .view = v, .match = match,
                             .basis = bases->basis + v * bases->leading * bases->length};
            if (!enc_cancelled(m->context)) {
                search_view(&s, bases->length, most, work + enc_thread_index() * each);
            }
            sums[2 * v] = s.error;
            sums[2 * v + 1] = s.energy;
        }
        for (size_t v = 0; v < views; v++) {
            *out_error += sums[2 * v];
            *out_energy += sums[2 * v + 1];
        }
        enc_match_count_users(m->context, match);
        result = enc_cancelled(m->context) ? BTF_ERROR_INTERRUPTED : BTF_OK;
    }
    free(packed);
    free(work);
    free(sums);
    return result;
}
