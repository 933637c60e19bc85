/* Exact search by blocked matrix product (see search.h).
 *
 * Which sources a point looks at is settled by search_set.c. They are normalised and packed in chunks of
 * 256; for one query, the sixteen vector lanes of a chunk
 * are sixteen groups of sixteen sources. The product in floats keeps the largest value of every group, no
 * index; then the groups that can hold the winner, by a bound on the rounding error of the product, are
 * compared source by source in double. So the winner depends neither on the machine's vectors nor on the
 * threads.
 *
 * SPDX-License-Identifier: MIT
 */
#include "search.h"
#include "encoder/math/linear.h"
#include "search_set.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    LANES = 16,
    CHUNK = JOINT_CHUNK,         /* sources whose maxima are taken together */
    PANELS = CHUNK / ENC_GEMM_N, /* panels of a chunk */
    GROUP = CHUNK / LANES,       /* sources of a group */
    STEPS = 2, /* texels that the search follows falling distances, sources being bounded */
};

/* Packed sources of one view. */
typedef struct candidates {
    joint_search_set search_set;
    float *packed;     /* unit vectors, [panel][k][32] */
    float *low, *high; /* [padded] range of gain * |z| */
    double *norm;      /* [texel] |z|^2 */
    uint32_t *before;  /* [texel] choices at the start; with bounded sources */
} candidates;

static void candidates_clear(candidates *set) {
    joint_search_set_clear(&set->search_set);
    free(set->packed);
    free(set->low);
    free(set->high);
    free(set->norm);
    free(set->before);
}

/* One panel of 32 sources as unit vectors, and their ranges; what pads it is 0, and so is its value. */
static void pack_panel(const joint_search *search, const candidates *set, const float *z, size_t panel) {
    const size_t k = search->k;
    float *packed = set->packed + panel * ENC_GEMM_N * k;
    for (size_t i = 0; i < ENC_GEMM_N; i++) {
        const size_t slot = panel * ENC_GEMM_N + i;
        const uint32_t source = set->search_set.source[slot];
        const bool pads = source == JOINT_NO_SOURCE;
        const double norm = pads ? 0.0 : set->norm[source];
        const double length = sqrt(norm), inverse = norm > 0.0 ? 1.0 / length : 0.0;
        for (size_t j = 0; j < k; j++)
            packed[j * ENC_GEMM_N + i] = pads ? 0.0f : (float)(z[source * k + j] * inverse);
        set->low[slot] = (float)(length * search->gains.step * search->gains.low);
        set->high[slot] = (float)(length * search->gains.step * search->gains.high);
    }
}

static btf_result candidates_init(const joint_search *search, const float *z, const uint32_t *match,
                                  candidates *set) {
    const size_t k = search->k, texels = (size_t)search->width * (size_t)search->height;
    const btf_result result = joint_search_set_create(search->width, search->height, search->sources,
                                                      search->window, search->phase, &set->search_set);
    if (result != BTF_OK)
        return result;
    const size_t slots = set->search_set.chunks * CHUNK;
    set->packed = enc_gemm_alloc(slots * k);
    set->low = enc_gemm_alloc(slots);
    set->high = enc_gemm_alloc(slots);
    set->norm = malloc(texels * sizeof(double));
    set->before = set->search_set.complete ? NULL : malloc(texels * sizeof *set->before);
    if (!set->packed || !set->low || !set->high || !set->norm ||
        (!set->search_set.complete && !set->before))
        return BTF_ERROR_MEMORY;
    if (set->before)
        memcpy(set->before, match, texels * sizeof *set->before);
#pragma omp parallel for num_threads(search->threads)
    for (size_t i = 0; i < texels; i++)
        set->norm[i] = enc_dot(k, z + i * k, z + i * k);
#pragma omp parallel for num_threads(search->threads)
    for (size_t panel = 0; panel < set->search_set.chunks * PANELS; panel++)
        pack_panel(search, set, z, panel);
    return BTF_OK;
}

/* best[lane] = max(best[lane], value) for one query and one panel. */
static inline __attribute__((always_inline)) void
panel_maxima_body(const float *tile, const float *low, const float *high, float *best, size_t pitch) {
    for (int m = 0; m < ENC_GEMM_M; m++)
        for (int n = 0; n < ENC_GEMM_N; n++) {
            const float dot = tile[m * ENC_GEMM_N + n];
            float t = dot > low[n] ? dot : low[n];
            t = t < high[n] ? t : high[n];
            const float value = t * (dot + dot - t);
            float *slot = best + (size_t)m * pitch + n % LANES;
            *slot = value > *slot ? value : *slot;
        }
}

typedef void (*panel_maxima_fn)(const float *tile, const float *low, const float *high, float *best,
                                size_t pitch);

static void panel_maxima_plain(const float *tile, const float *low, const float *high, float *best,
                               size_t pitch) {
    panel_maxima_body(tile, low, high, best, pitch);
}

#if defined(__x86_64__)
#include <immintrin.h>

__attribute__((target("avx512f"))) static void
panel_maxima_avx512(const float *tile, const float *low, const float *high, float *best, size_t pitch) {
    for (int m = 0; m < ENC_GEMM_M; m++) {
        __m512 maximum = _mm512_loadu_ps(best + (size_t)m * pitch);
        for (int n = 0; n < ENC_GEMM_N; n += LANES) {
            const __m512 dot = _mm512_loadu_ps(tile + m * ENC_GEMM_N + n);
            __m512 t = _mm512_max_ps(dot, _mm512_loadu_ps(low + n));
            t = _mm512_min_ps(t, _mm512_loadu_ps(high + n));
            maximum = _mm512_max_ps(maximum, _mm512_mul_ps(t, _mm512_sub_ps(_mm512_add_ps(dot, dot), t)));
        }
        _mm512_storeu_ps(best + (size_t)m * pitch, maximum);
    }
}

__attribute__((target("avx2"))) static void
panel_maxima_avx2(const float *tile, const float *low, const float *high, float *best, size_t pitch) {
    for (int m = 0; m < ENC_GEMM_M; m++)
        for (int n = 0; n < ENC_GEMM_N; n += 8) {
            float *slot = best + (size_t)m * pitch + n % LANES;
            const __m256 dot = _mm256_loadu_ps(tile + m * ENC_GEMM_N + n);
            __m256 t = _mm256_max_ps(dot, _mm256_loadu_ps(low + n));
            t = _mm256_min_ps(t, _mm256_loadu_ps(high + n));
            const __m256 value = _mm256_mul_ps(t, _mm256_sub_ps(_mm256_add_ps(dot, dot), t));
            _mm256_storeu_ps(slot, _mm256_max_ps(_mm256_loadu_ps(slot), value));
        }
}
#endif

static panel_maxima_fn select_panel_maxima(void) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f"))
        return panel_maxima_avx512;
    if (__builtin_cpu_supports("avx2"))
        return panel_maxima_avx2;
#endif
    return panel_maxima_plain;
}

bool joint_shift(int width, int height, uint32_t texel, uint32_t source, int *out_dx, int *out_dy) {
    int dx = (int)(source % (uint32_t)width) - (int)(texel % (uint32_t)width);
    int dy = (int)(source / (uint32_t)width) - (int)(texel / (uint32_t)width);
    dx += 2 * dx > width ? -width : 2 * dx < -width ? width : 0;
    dy += 2 * dy > height ? -height : 2 * dy < -height ? height : 0;
    dx = dx == 128 && width == 256 ? -128 : dx;
    dy = dy == 128 && height == 256 ? -128 : dy;
    *out_dx = dx;
    *out_dy = dy;
    return dx >= -128 && dx <= 127 && dy >= -128 && dy <= 127;
}

/* The choice of one query so far. */
typedef struct choice {
    double value, tie; /* values within `tie` of each other count as equal */
    long shift;        /* squared length */
    uint32_t source;
    int code;
} choice;

static void consider(const joint_search *search, const candidates *set, const float *c, const float *z,
                     uint32_t texel, uint32_t source, choice *best) {
    double value;
    const int code = joint_best_gain(&search->gains, enc_dot(search->k, c, z + source * search->k),
                                     set->norm[source], &value);
    if (value < best->value - best->tie)
        return;
    int dx, dy;
    if (!joint_shift(search->width, search->height, texel, source, &dx, &dy))
        return;
    const long shift = (long)dx * dx + (long)dy * dy;
    if (value <= best->value + best->tie &&
        (shift > best->shift || (shift == best->shift && source >= best->source)))
        return;
    *best = (choice){value, best->tie, shift, source, code};
}

/* The source that a point one texel away refers to, shifted along with the point. */
static uint32_t carried(const joint_search *search, const candidates *set, uint32_t texel, int dx, int dy) {
    const int width = search->width, height = search->height;
    const int column = (int)(texel % (uint32_t)width), row = (int)(texel / (uint32_t)width);
    const int from_column = (column + dx + width) % width, from_row = (row + dy + height) % height;
    const uint32_t from = set->before[(size_t)from_row * (size_t)width + (size_t)from_column];
    const int to_column = ((int)(from % (uint32_t)width) - dx + width) % width;
    const int to_row = ((int)(from / (uint32_t)width) - dy + height) % height;
    return (uint32_t)to_row * (uint32_t)width + (uint32_t)to_column;
}

/* Sources that neighbouring points refer to, and those beside the best as long as they are better. */
static void follow(const joint_search *search, const candidates *set, const float *c, const float *z,
                   uint32_t texel, choice *best) {
    static const int aside[4][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};
    const int width = search->width, height = search->height;
    for (int i = 0; i < 4; i++)
        consider(search, set, c, z, texel, carried(search, set, texel, aside[i][0], aside[i][1]), best);
    for (int step = 0; step < STEPS; step++) {
        const uint32_t from = best->source;
        const int column = (int)(from % (uint32_t)width), row = (int)(from / (uint32_t)width);
        for (int i = 0; i < 9; i++) {
            const int x = (column + i % 3 - 1 + width) % width, y = (row + i / 3 - 1 + height) % height;
            if (i != 4)
                consider(search, set, c, z, texel, (uint32_t)y * (uint32_t)width + (uint32_t)x, best);
        }
        if (best->source == from)
            break;
    }
}

/* One point of a block: the sources of every group whose maximum in floats comes near the best. */
static void scan(const joint_search *search, const candidates *set, size_t block, const float *maxima,
                 const float *c, const float *z, float energy, uint32_t texel, uint32_t *match,
                 uint8_t *gain, double *out_value) {
    const size_t groups = set->search_set.chunk_count[block] * LANES;
    const uint32_t *chunks = set->search_set.chunk + set->search_set.first_chunk[block];
    const double length = enc_dot(search->k, c, c);
    const double margin = 2.5e-7 * (double)(search->k + 8) * length + 1e-30;
    choice best = {-DBL_MAX, 1e-9 * energy, 0, texel, search->gains.low};
    consider(search, set, c, z, texel, texel, &best);
    const choice still = best;
    size_t top = 0;
    for (size_t i = 1; i < groups; i++)
        if (maxima[i] > maxima[top])
            top = i;
    /* Leaving the texel's own source must pay; a shift chosen before stays free to change. */
    const double threshold = still.value + (*match == texel ? search->tolerance * energy : 0.0);
    if (maxima[top] + margin > threshold || set->before) {
        consider(search, set, c, z, texel, *match, &best);
        for (size_t step = 0; step <= groups; step++) { /* the top group first, then in order */
            const size_t i = step == 0 ? top : step - 1;
            if ((step > 0 && i == top) || maxima[i] + margin < best.value)
                continue;
            for (size_t j = 0; j < GROUP; j++) {
                const uint32_t source =
                    set->search_set.source[(size_t)chunks[i / LANES] * CHUNK + j * LANES + i % LANES];
                if (source != JOINT_NO_SOURCE)
                    consider(search, set, c, z, texel, source, &best);
            }
        }
        if (set->before)
            follow(search, set, c, z, texel, &best);
        if (best.value <= threshold)
            best = still;
    }
    *match = best.source;
    *gain = (uint8_t)best.code;
    *out_value = best.value;
}

/* Points as a left operand: [panel][k][ENC_GEMM_M], padded with zeros. */
static void pack_queries(size_t count, size_t k, const float *c, const uint32_t *query, float *packed) {
    for (size_t first = 0; first < count; first += ENC_GEMM_M, packed += ENC_GEMM_M * k)
        for (size_t i = 0; i < ENC_GEMM_M; i++)
            for (size_t j = 0; j < k; j++)
                packed[j * ENC_GEMM_M + i] = first + i < count ? c[query[first + i] * k + j] : 0.0f;
}

btf_result joint_search_view(const joint_search *search, const float *c, const float *energy,
                             const float *z, uint32_t *match, uint8_t *gain, double *out_value) {
    const size_t k = search->k;
    const panel_maxima_fn panel_maxima = select_panel_maxima();
    candidates set = {0};
    float *scratch = NULL;
    btf_result result = candidates_init(search, z, match, &set);
    if (result != BTF_OK)
        goto fail;
    const size_t pitch = set.search_set.most_chunks * LANES, per_thread = JOINT_QUERIES * (k + pitch);
    result = BTF_ERROR_MEMORY;
    scratch = enc_gemm_alloc(per_thread * (size_t)search->threads);
    if (!scratch)
        goto fail;
#pragma omp parallel for schedule(dynamic) num_threads(search->threads)
    for (size_t block = 0; block < set.search_set.blocks; block++) {
        _Alignas(64) float tile[ENC_GEMM_M * ENC_GEMM_N];
        float *packed = scratch + per_thread * (size_t)enc_thread_index();
        float *maxima = packed + JOINT_QUERIES * k;
        const uint32_t *query = set.search_set.query + set.search_set.first_query[block];
        const uint32_t *chunks = set.search_set.chunk + set.search_set.first_chunk[block];
        const size_t count = set.search_set.first_query[block + 1] - set.search_set.first_query[block];
        const size_t padded = enc_gemm_panels(count, ENC_GEMM_M) * ENC_GEMM_M;
        pack_queries(count, k, c, query, packed);
        for (size_t i = 0; i < padded * pitch; i++)
            maxima[i] = -FLT_MAX;
        for (size_t chunk = 0; chunk < set.search_set.chunk_count[block]; chunk++)
            for (size_t q = 0; q < padded; q += ENC_GEMM_M)
                for (size_t i = 0; i < PANELS; i++) {
                    const size_t panel = (size_t)chunks[chunk] * PANELS + i;
                    search->tile(k, packed + q * k, set.packed + panel * ENC_GEMM_N * k, tile);
                    panel_maxima(tile, set.low + panel * ENC_GEMM_N, set.high + panel * ENC_GEMM_N,
                                 maxima + q * pitch + chunk * LANES, pitch);
                }
        for (size_t i = 0; i < count; i++) {
            const uint32_t x = query[i];
            scan(search, &set, block, maxima + i * pitch, c + x * k, z, energy[x], x, match + x, gain + x,
                 out_value + x);
        }
    }
    result = BTF_OK;
fail:
    free(scratch);
    candidates_clear(&set);
    return result;
}

void joint_search_gains(const joint_search *search, const float *c, const float *z, const uint32_t *match,
                        uint8_t *gain, double *out_value) {
    const size_t k = search->k, count = (size_t)search->width * (size_t)search->height;
#pragma omp parallel for num_threads(search->threads)
    for (size_t x = 0; x < count; x++) {
        const float *source = z + match[x] * k;
        gain[x] = (uint8_t)joint_best_gain(&search->gains, enc_dot(k, c + x * k, source),
                                           enc_dot(k, source, source), out_value + x);
    }
}
