/* Splitting rows by their principal directions (see cluster_split.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "cluster_split.h"

#include <stdlib.h>
#include <string.h>

enum { POWER_STEPS = 4 }; /* the direction need not be exact */

typedef struct placed_row {
    double along;
    size_t row;
} placed_row;

typedef struct splitter {
    size_t stride, most;
    const float *points;
    size_t *order, *first, parts;
    double *mean, *direction, *next; /* [stride] */
    placed_row *placed;              /* [n] */
} splitter;

static int by_place(const void *a, const void *b) {
    const placed_row *x = a, *y = b;
    if (x->along != y->along) {
        return x->along < y->along ? -1 : 1;
    }
    return (x->row > y->row) - (x->row < y->row);
}

static int by_row(const void *a, const void *b) {
    const size_t x = *(const size_t *)a, y = *(const size_t *)b;
    return (x > y) - (x < y);
}

/* The inner product of a row, less the mean, with the direction. */
static double along(const splitter *s, const float *row) {
    double sum = 0;
    for (size_t d = 0; d < s->stride; d++) {
        sum += ((double)row[d] - s->mean[d]) * s->direction[d];
    }
    return sum;
}

/* Finds the direction of largest variance by power iteration, which starts at the row farthest from the
 * mean. */
static void find_direction(splitter *s, const size_t *rows, size_t n) {
    double farthest = -1;
    memset(s->mean, 0, s->stride * sizeof *s->mean);
    for (size_t i = 0; i < n; i++) {
        for (size_t d = 0; d < s->stride; d++) {
            s->mean[d] += (double)s->points[rows[i] * s->stride + d] / (double)n;
        }
    }
    for (size_t i = 0; i < n; i++) {
        const float *row = s->points + rows[i] * s->stride;
        double square = 0;
        for (size_t d = 0; d < s->stride; d++) {
            square += ((double)row[d] - s->mean[d]) * ((double)row[d] - s->mean[d]);
        }
        if (square > farthest) {
            farthest = square;
            for (size_t d = 0; d < s->stride; d++) {
                s->direction[d] = (double)row[d] - s->mean[d];
            }
        }
    }
    for (int step = 0; step < POWER_STEPS; step++) {
        double largest = 0;
        memset(s->next, 0, s->stride * sizeof *s->next);
        for (size_t i = 0; i < n; i++) {
            const float *row = s->points + rows[i] * s->stride;
            const double weight = along(s, row);
            for (size_t d = 0; d < s->stride; d++) {
                s->next[d] += weight * ((double)row[d] - s->mean[d]);
            }
        }
        for (size_t d = 0; d < s->stride; d++) {
            const double size = s->next[d] < 0 ? -s->next[d] : s->next[d];
            largest = size > largest ? size : largest;
        }
        for (size_t d = 0; d < s->stride && largest > 0; d++) {
            s->direction[d] = s->next[d] / largest;
        }
    }
}

/* Splits rows begin .. end - 1 into parts by recursion, about log2(n / most) deep. */
static void split(splitter *s, size_t begin, size_t end) {
    const size_t n = end - begin;
    size_t *rows = s->order + begin;
    if (n <= s->most) {
        qsort(rows, n, sizeof *rows, by_row);
        s->first[s->parts++] = begin;
        return;
    }
    find_direction(s, rows, n);
    for (size_t i = 0; i < n; i++) {
        s->placed[i] = (placed_row){along(s, s->points + rows[i] * s->stride), rows[i]};
    }
    qsort(s->placed, n, sizeof *s->placed, by_place);
    for (size_t i = 0; i < n; i++) {
        rows[i] = s->placed[i].row;
    }
    split(s, begin, begin + n / 2);
    split(s, begin + n / 2, end);
}

btf_result enc_cluster_split(size_t n, size_t stride, const float *points, size_t most, size_t *out_order,
                             size_t *out_first, size_t *out_parts) {
    splitter s = {.stride = stride, .most = most, .points = points, .order = out_order, .first = out_first};
    s.mean = malloc(3 * stride * sizeof *s.mean);
    s.placed = malloc((n + 1) * sizeof *s.placed);
    const btf_result result = s.mean && s.placed ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        s.direction = s.mean + stride;
        s.next = s.direction + stride;
        for (size_t i = 0; i < n; i++) {
            out_order[i] = i;
        }
        split(&s, 0, n);
        out_first[s.parts] = n;
        *out_parts = s.parts;
    }
    free(s.mean);
    free(s.placed);
    return result;
}
