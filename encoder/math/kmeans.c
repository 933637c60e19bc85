/* k-means of rows of floats (see kmeans.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "kmeans.h"

#include "simd.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const float norm_rounding = 1e-5f; /* more than rounding moves a norm, relative to it */

/* Squared distance of two rows, the same bits from each instruction set. */
typedef float (*square_kernel)(const float *a, const float *b, size_t stride);

ENC_INLINE float square_body(const float *a, const float *b, size_t stride) {
    enc_v16 even = {0}, odd = {0};
    size_t i = 0;
    for (; i + 2 * ENC_LANES <= stride; i += 2 * ENC_LANES) {
        const enc_v16 d = *(const enc_v16u *)(a + i) - *(const enc_v16u *)(b + i);
        const enc_v16 e = *(const enc_v16u *)(a + i + ENC_LANES) - *(const enc_v16u *)(b + i + ENC_LANES);
        even += d * d;
        odd += e * e;
    }
    if (i < stride) {
        const enc_v16 d = *(const enc_v16u *)(a + i) - *(const enc_v16u *)(b + i);
        even += d * d;
    }
    even += odd;
    float half[8];
    for (int k = 0; k < 8; k++) {
        half[k] = even[k] + even[k + 8];
    }
    for (int k = 0; k < 4; k++) {
        half[k] += half[k + 4];
    }
    return (half[0] + half[2]) + (half[1] + half[3]);
}

static float square_base(const float *a, const float *b, size_t stride) {
    return square_body(a, b, stride);
}
#ifdef ENC_HAVE_X86_DISPATCH
ENC_TARGET_AVX2 static float square_avx2(const float *a, const float *b, size_t stride) {
    return square_body(a, b, stride);
}
ENC_TARGET_AVX512 static float square_avx512(const float *a, const float *b, size_t stride) {
    return square_body(a, b, stride);
}
#endif

static square_kernel choose_square(void) {
#ifdef ENC_HAVE_X86_DISPATCH
    const enc_isa isa = enc_isa_current();
    if (isa == ENC_ISA_AVX512) {
        return square_avx512;
    }
    if (isa == ENC_ISA_AVX2) {
        return square_avx2;
    }
#endif
    return square_base;
}

/* A row and a hash of its bits, for sorting. */
typedef struct hashed_row {
    uint64_t hash;
    const float *row;
    size_t bytes;
} hashed_row;

static int compare_rows(const void *a, const void *b) {
    const hashed_row *x = a, *y = b;
    if (x->hash != y->hash) {
        return x->hash < y->hash ? -1 : 1;
    }
    return memcmp(x->row, y->row, x->bytes);
}

btf_result enc_kmeans_distinct(size_t n, size_t stride, const float *points, size_t *out_distinct) {
    *out_distinct = 0;
    if (n == 0) {
        return BTF_OK;
    }
    hashed_row *rows = malloc(n * sizeof *rows);
    if (!rows) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < n; i++) {
        uint64_t hash = 0;
        for (size_t d = 0; d < stride; d++) {
            uint32_t bits;
            memcpy(&bits, points + i * stride + d, sizeof bits);
            hash = (hash ^ bits) * UINT64_C(0x9E3779B97F4A7C15);
            hash ^= hash >> 29;
        }
        rows[i] = (hashed_row){.hash = hash, .row = points + i * stride, .bytes = stride * sizeof(float)};
    }
    qsort(rows, n, sizeof *rows, compare_rows);
    *out_distinct = 1;
    for (size_t i = 1; i < n; i++) {
        *out_distinct += compare_rows(&rows[i - 1], &rows[i]) != 0;
    }
    free(rows);
    return BTF_OK;
}

btf_result enc_kmeans_nearest(size_t n, size_t stride, const float *points, size_t k, const float *centres,
                              uint32_t *index, float *out_squares, size_t *out_changed) {
    assert(k >= 1 && stride % ENC_LANES == 0);
    const square_kernel square = choose_square();
    float *norms = malloc(k * sizeof *norms);
    float *zero = calloc(stride, sizeof *zero);
    if (!norms || !zero) {
        free(norms);
        free(zero);
        return BTF_ERROR_MEMORY;
    }
    for (size_t j = 0; j < k; j++) {
        norms[j] = sqrtf(square(centres + j * stride, zero, stride));
    }
    size_t changed = 0;
    for (size_t i = 0; i < n; i++) {
        const float *point = points + i * stride;
        const float norm = sqrtf(square(point, zero, stride));
        uint32_t nearest = index[i];
        float least = square(point, centres + nearest * stride, stride);
        for (size_t j = 0; j < k; j++) {
            /* || p - c || >= | ||p|| - ||c|| | */
            const float gap = fabsf(norm - norms[j]) - norm_rounding * (norm + norms[j]);
            if (j == index[i] || (gap > 0 && gap * gap > least)) {
                continue;
            }
            const float d = square(point, centres + j * stride, stride);
            if (d < least || (d == least && j < nearest)) {
                least = d;
                nearest = (uint32_t)j;
            }
        }
        changed += nearest != index[i];
        index[i] = nearest;
        if (out_squares) {
            out_squares[i] = least;
        }
    }
    free(norms);
    free(zero);
    if (out_changed) {
        *out_changed = changed;
    }
    return BTF_OK;
}

/* splitmix64 (Steele, Lea and Flood 2014), as a number in [0, 1). */
static double next_random(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    z ^= z >> 31;
    return (double)(z >> 11) * 0x1p-53;
}

/* A point drawn with probability proportional to weights[n]; `n` when all are 0. */
static size_t draw(size_t n, const float *weights, uint64_t *state) {
    double total = 0;
    for (size_t i = 0; i < n; i++) {
        total += weights[i];
    }
    double left = next_random(state) * total;
    size_t last = n;
    for (size_t i = 0; i < n; i++) {
        if (weights[i] <= 0) {
            continue;
        }
        last = i;
        left -= weights[i];
        if (left < 0) {
            break;
        }
    }
    return last;
}

/* k-means++: each next centre is a point drawn in proportion to its squared distance from those chosen.
 * squares[n] is scratch; index[n] receives the nearest chosen centre. */
static void far_apart(size_t n, size_t stride, const float *points, size_t k, uint64_t seed, float *centres,
                      uint32_t *index, float *squares) {
    const square_kernel square = choose_square();
    uint64_t state = seed;
    for (size_t i = 0; i < n; i++) {
        squares[i] = FLT_MAX;
    }
    size_t chosen = (size_t)(next_random(&state) * (double)n);
    for (size_t j = 0; j < k; j++) {
        memcpy(centres + j * stride, points + chosen * stride, stride * sizeof *centres);
        for (size_t i = 0; i < n; i++) {
            const float d = square(points + i * stride, centres + j * stride, stride);
            if (d < squares[i]) {
                squares[i] = d;
                index[i] = (uint32_t)j;
            }
        }
        chosen = draw(n, squares, &state);
        if (chosen == n) { /* every point is a centre already */
            chosen = (j + 1) % n;
        }
    }
}

/* Means of the members; a cluster without any takes over the point farthest from its centre. squares[n] are
 * the points' squared distances. Returns the number of such clusters. */
static size_t move_centres(size_t n, size_t stride, const float *points, size_t k, uint32_t *index,
                           float *squares, double *sums, size_t *counts, float *centres) {
    size_t empty = 0;
    memset(counts, 0, k * sizeof *counts);
    for (size_t i = 0; i < n; i++) {
        counts[index[i]]++;
    }
    for (size_t j = 0; j < k; j++) {
        if (counts[j] > 0) {
            continue;
        }
        size_t farthest = n;
        for (size_t i = 0; i < n; i++) {
            if (squares[i] > 0 && counts[index[i]] > 1 &&
                (farthest == n || squares[i] > squares[farthest])) {
                farthest = i;
            }
        }
        if (farthest == n) {
            continue;
        }
        counts[index[farthest]]--;
        index[farthest] = (uint32_t)j;
        squares[farthest] = 0;
        counts[j] = 1;
        empty++;
    }
    memset(sums, 0, k * stride * sizeof *sums);
    for (size_t i = 0; i < n; i++) {
        double *sum = sums + index[i] * stride;
        for (size_t d = 0; d < stride; d++) {
            sum[d] += (double)points[i * stride + d];
        }
    }
    for (size_t j = 0; j < k; j++) {
        for (size_t d = 0; d < stride && counts[j] > 0; d++) {
            centres[j * stride + d] = (float)(sums[j * stride + d] / (double)counts[j]);
        }
    }
    return empty;
}

/* Replaces each centre by its member nearest to it, the first among equals. members[k] is scratch. */
static void snap_centres(size_t n, size_t stride, const float *points, size_t k, const uint32_t *index,
                         const float *squares, size_t *members, float *centres) {
    for (size_t j = 0; j < k; j++) {
        members[j] = n;
    }
    for (size_t i = 0; i < n; i++) {
        if (members[index[i]] == n || squares[i] < squares[members[index[i]]]) {
            members[index[i]] = i;
        }
    }
    for (size_t j = 0; j < k; j++) {
        if (members[j] < n) {
            memcpy(centres + j * stride, points + members[j] * stride, stride * sizeof *centres);
        }
    }
}

btf_result enc_kmeans(size_t n, size_t stride, const float *points, size_t k, int iterations, uint64_t seed,
                      bool data_points, float *out_centres, uint32_t *index) {
    assert(k >= 1 && k <= n);
    float *squares = malloc(n * sizeof *squares);
    double *sums = malloc(k * stride * sizeof *sums);
    size_t *counts = malloc(k * sizeof *counts);
    btf_result result = squares && sums && counts ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        far_apart(n, stride, points, k, seed, out_centres, index, squares);
    }
    size_t changed = 1, empty = 1;
    for (int round = 0; result == BTF_OK && round < iterations && (changed > 0 || empty > 0); round++) {
        empty = move_centres(n, stride, points, k, index, squares, sums, counts, out_centres);
        result = enc_kmeans_nearest(n, stride, points, k, out_centres, index, squares, &changed);
    }
    if (result == BTF_OK && data_points) {
        snap_centres(n, stride, points, k, index, squares, counts, out_centres);
    }
    free(squares);
    free(sums);
    free(counts);
    return result;
}
