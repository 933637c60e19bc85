/* Exact search by blocked matrix product (see joint_search.h).
 *
 * Sources are normalised and packed in chunks of 256; for one query, the sixteen vector lanes of a chunk
 * are sixteen groups of sixteen sources. The product in floats keeps the largest value of every group, no
 * index; then the groups that can hold the winner, by a bound on the rounding error of the product, are
 * compared source by source in double. So the winner depends neither on the machine's vectors nor on the
 * threads.
 *
 * SPDX-License-Identifier: MIT
 */
#include "joint_search.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    LANES = 16,
    CHUNK = 256,                 /* sources whose maxima are taken together */
    PANELS = CHUNK / ENC_GEMM_N, /* panels of a chunk */
    QUERIES = 10 * ENC_GEMM_M,   /* queries that share a chunk while it is in the cache */
    GROUP = CHUNK / LANES,       /* sources of a group */
};

/* Packed sources of one view. */
typedef struct candidates {
    size_t count, chunks;
    size_t reach;      /* chunks that one query looks at */
    float *packed;     /* unit vectors, [panel][k][32] */
    float *low, *high; /* [padded] range of gain * |z| */
    double *norm;      /* [count] |z|^2 */
} candidates;

static void candidates_clear(candidates *set) {
    free(set->packed);
    free(set->low);
    free(set->high);
    free(set->norm);
}

static bool candidates_init(const joint_search *search, const float *z, candidates *out_set) {
    const size_t k = search->k;
    const size_t count = (size_t)search->width * (size_t)search->height;
    const size_t chunks = (count + CHUNK - 1) / CHUNK;
    float *unit = enc_gemm_alloc(count * k);
    *out_set = (candidates){.count = count,
                            .chunks = chunks,
                            .reach = chunks * CHUNK <= search->reach || search->reach == 0
                                         ? chunks
                                         : (search->reach + CHUNK - 1) / CHUNK,
                            .packed = enc_gemm_alloc(chunks * CHUNK * k),
                            .low = enc_gemm_alloc(chunks * CHUNK),
                            .high = enc_gemm_alloc(chunks * CHUNK),
                            .norm = malloc(count * sizeof(double))};
    const bool ok = unit && out_set->packed && out_set->low && out_set->high && out_set->norm;
    if (ok) {
#pragma omp parallel for num_threads(search->threads)
        for (size_t i = 0; i < count; i++) {
            double norm = 0.0;
            for (size_t j = 0; j < k; j++)
                norm += (double)z[i * k + j] * z[i * k + j];
            const double length = sqrt(norm), inverse = norm > 0.0 ? 1.0 / length : 0.0;
            for (size_t j = 0; j < k; j++)
                unit[i * k + j] = (float)(z[i * k + j] * inverse);
            out_set->norm[i] = norm;
            out_set->low[i] = (float)(length * search->gains.step * search->gains.low);
            out_set->high[i] = (float)(length * search->gains.step * search->gains.high);
        }
        memset(out_set->packed, 0, chunks * CHUNK * k * sizeof(float));
        enc_gemm_pack_rows(count, k, unit, k, ENC_GEMM_N, out_set->packed);
        for (size_t i = count; i < chunks * CHUNK; i++)
            out_set->low[i] = out_set->high[i] = 0.0f; /* value 0: never above a real maximum, see scan */
    }
    free(unit);
    return ok;
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

static double exact_dot(const float *a, const float *b, size_t k) {
    double sum = 0.0;
    for (size_t j = 0; j < k; j++)
        sum += (double)a[j] * b[j];
    return sum;
}

static void consider(const joint_search *search, const candidates *set, const float *c, const float *z,
                     uint32_t texel, uint32_t source, choice *best) {
    double value;
    const int code = joint_best_gain(&search->gains, exact_dot(c, z + source * search->k, search->k),
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

/* Compares the sources of every group whose maximum in floats comes near the best. */
static void scan(const joint_search *search, const candidates *set, size_t base, const float *maxima,
                 const float *c, const float *z, float energy, uint32_t texel, uint32_t *match,
                 uint8_t *gain, double *out_value) {
    const size_t groups = set->reach * LANES;
    const double length = exact_dot(c, c, search->k);
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
    if (maxima[top] + margin > threshold) {
        consider(search, set, c, z, texel, *match, &best);
        for (size_t step = 0; step <= groups; step++) { /* the top group first, then in order */
            const size_t i = step == 0 ? top : step - 1;
            if ((step > 0 && i == top) || maxima[i] + margin < best.value)
                continue;
            for (size_t j = 0; j < GROUP; j++) {
                const size_t source = (base + i / LANES) % set->chunks * CHUNK + j * LANES + i % LANES;
                if (source < set->count)
                    consider(search, set, c, z, texel, (uint32_t)source, &best);
            }
        }
        if (best.value <= threshold)
            best = still;
    }
    *match = best.source;
    *gain = (uint8_t)best.code;
    *out_value = best.value;
}

btf_result joint_search_view(const joint_search *search, const float *c, const float *energy,
                             const float *z, uint32_t *match, uint8_t *gain, double *out_value) {
    const size_t k = search->k;
    const panel_maxima_fn panel_maxima = select_panel_maxima();
    candidates set = {0};
    float *scratch = NULL;
    btf_result result = BTF_ERROR_MEMORY;
    if (!candidates_init(search, z, &set))
        goto fail;
    const size_t groups = set.reach * LANES;
    const size_t per_thread = QUERIES * (k + groups);
    scratch = enc_gemm_alloc(per_thread * (size_t)search->threads);
    if (!scratch)
        goto fail;
#pragma omp parallel for schedule(dynamic) num_threads(search->threads)
    for (size_t first = 0; first < set.count; first += QUERIES) {
        _Alignas(64) float tile[ENC_GEMM_M * ENC_GEMM_N];
        float *packed = scratch + per_thread * (size_t)enc_thread_index();
        float *maxima = packed + QUERIES * k;
        const size_t count = set.count - first < QUERIES ? set.count - first : QUERIES;
        const size_t padded = enc_gemm_panels(count, ENC_GEMM_M) * ENC_GEMM_M;
        enc_gemm_pack_rows(count, k, c + first * k, k, ENC_GEMM_M, packed);
        for (size_t i = 0; i < padded * groups; i++)
            maxima[i] = -FLT_MAX;
        /* The chunks around the queries' own, wrapped. */
        const size_t own = (first + count / 2) / CHUNK;
        const size_t base = set.reach < set.chunks ? (own + set.chunks - set.reach / 2) % set.chunks : 0;
        for (size_t chunk = 0; chunk < set.reach; chunk++)
            for (size_t q = 0; q < padded; q += ENC_GEMM_M)
                for (size_t i = 0; i < PANELS; i++) {
                    const size_t panel = (base + chunk) % set.chunks * PANELS + i;
                    search->tile(k, packed + q * k, set.packed + panel * ENC_GEMM_N * k, tile);
                    panel_maxima(tile, set.low + panel * ENC_GEMM_N, set.high + panel * ENC_GEMM_N,
                                 maxima + q * groups + chunk * LANES, groups);
                }
        for (size_t i = 0; i < count; i++) {
            const size_t x = first + i;
            scan(search, &set, base, maxima + i * groups, c + x * k, z, energy[x], (uint32_t)x, match + x,
                 gain + x, out_value + x);
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
        gain[x] = (uint8_t)joint_best_gain(&search->gains, exact_dot(c + x * k, source, k),
                                           exact_dot(source, source, k), out_value + x);
    }
}
