/* Householder's reduction and implicit QL (see symmetric.h). Of the matrix v of the literature, v[j] here
 * is column j, so that all inner loops run along memory.
 *
 * SPDX-License-Identifier: MIT
 */
#include "symmetric.h"

#include "clones.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Copies of the hot loops for wider vectors. They hold no sums across lanes but in the lanes that are
 * written out, and are not contracted, so that all copies give the same bits. */

enum { LANES = 8, MOST_STEPS = 60 };

typedef double lanes8 __attribute__((vector_size(64), aligned(8), may_alias));
typedef float floats8 __attribute__((vector_size(32), aligned(4), may_alias));

static inline double sum_lanes(const double *s) {
    return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
}

ENC_CLONES static double dot(size_t n, const double *restrict a, const double *restrict b) {
    double sum[LANES] = {0.0};
    size_t i = 0;
    for (; i + LANES <= n; i += LANES) {
        for (size_t j = 0; j < LANES; j++) {
            sum[j] += a[i + j] * b[i + j];
        }
    }
    for (size_t j = 0; i + j < n; j++) {
        sum[j] += a[i + j] * b[i + j];
    }
    return sum_lanes(sum);
}

/* e[k] += f v[k]; returns the sum of v[k] d[k]. */
ENC_CLONES static double add_and_dot(size_t n, double f, const double *restrict v, const double *restrict d,
                                 double *restrict e) {
    double sum[LANES] = {0.0};
    size_t i = 0;
    for (; i + LANES <= n; i += LANES) {
        for (size_t j = 0; j < LANES; j++) {
            sum[j] += v[i + j] * d[i + j];
            e[i + j] += v[i + j] * f;
        }
    }
    for (size_t j = 0; i + j < n; j++) {
        sum[j] += v[i + j] * d[i + j];
        e[i + j] += v[i + j] * f;
    }
    return sum_lanes(sum);
}

/* v[k] -= f e[k] + g d[k]. */
ENC_CLONES static void subtract_two(size_t n, double f, const double *restrict e, double g,
                                const double *restrict d, double *restrict v) {
    for (size_t k = 0; k < n; k++) {
        v[k] -= f * e[k] + g * d[k];
    }
}

ENC_CLONES static void subtract_scaled(size_t n, double g, const double *restrict d, double *restrict v) {
    for (size_t k = 0; k < n; k++) {
        v[k] -= g * d[k];
    }
}

ENC_CLONES static void rotate(size_t n, double c, double s, double *restrict a, double *restrict b) {
    for (size_t k = 0; k < n; k++) {
        const double h = b[k];
        b[k] = s * a[k] + c * h;
        a[k] = c * a[k] - s * h;
    }
}

/* One Householder step: row i of the matrix is in d. */
static double reflect(size_t n, double *v, size_t i, double scale, double *d, double *e) {
    double h = 0.0, f, g;
    for (size_t k = 0; k < i; k++) {
        d[k] /= scale;
        h += d[k] * d[k];
    }
    f = d[i - 1];
    g = f > 0.0 ? -sqrt(h) : sqrt(h);
    e[i] = scale * g;
    h -= f * g;
    d[i - 1] = f - g;
    memset(e, 0, i * sizeof *e);
    for (size_t j = 0; j < i; j++) {
        double *column = v + j * n;
        v[i * n + j] = d[j];
        e[j] += column[j] * d[j];
        e[j] += add_and_dot(i - j - 1, d[j], column + j + 1, d + j + 1, e + j + 1);
    }
    f = 0.0;
    for (size_t j = 0; j < i; j++) {
        e[j] /= h;
        f += e[j] * d[j];
    }
    subtract_scaled(i, f / (h + h), d, e);
    for (size_t j = 0; j < i; j++) {
        subtract_two(i - j, d[j], e + j, e[j], d + j, v + j * n + j);
    }
    for (size_t j = 0; j < i; j++) {
        d[j] = v[j * n + i - 1];
        v[j * n + i] = 0.0;
    }
    return h;
}

/* To tridiagonal form: diagonal d, beside it e[1 .. n - 1]; v becomes the transformation. */
static void reduce(size_t n, double *v, double *d, double *e) {
    for (size_t j = 0; j < n; j++) {
        d[j] = v[j * n + n - 1];
    }
    for (size_t i = n - 1; i > 0; i--) {
        double scale = 0.0, h = 0.0;
        for (size_t k = 0; k < i; k++) {
            scale += fabs(d[k]);
        }
        if (scale > 0.0) {
            h = reflect(n, v, i, scale, d, e);
        } else {
            e[i] = d[i - 1];
            for (size_t j = 0; j < i; j++) {
                d[j] = v[j * n + i - 1];
                v[j * n + i] = v[i * n + j] = 0.0;
            }
        }
        d[i] = h;
    }
    for (size_t i = 0; i + 1 < n; i++) {
        const double h = d[i + 1];
        double *next = v + (i + 1) * n;
        v[i * n + n - 1] = v[i * n + i];
        v[i * n + i] = 1.0;
        for (size_t k = 0; k <= i && h != 0.0; k++) {
            d[k] = next[k] / h;
        }
        for (size_t j = 0; j <= i && h != 0.0; j++) {
            subtract_scaled(i + 1, dot(i + 1, next, v + j * n), d, v + j * n);
        }
        memset(next, 0, (i + 1) * sizeof *next);
    }
    for (size_t j = 0; j < n; j++) {
        d[j] = v[j * n + n - 1];
        v[j * n + n - 1] = 0.0;
    }
    v[n * n - 1] = 1.0;
    e[0] = 0.0;
}

/* One QL step on rows l .. m, shifted; returns the shift. */
static double ql_step(size_t n, size_t l, size_t m, double *v, double *d, double *e) {
    double g = d[l], p = (d[l + 1] - g) / (2.0 * e[l]);
    const double root = p < 0.0 ? -hypot(p, 1.0) : hypot(p, 1.0);
    d[l] = e[l] / (p + root);
    d[l + 1] = e[l] * (p + root);
    const double next = d[l + 1], beside = e[l + 1], shift = g - d[l];
    for (size_t i = l + 2; i < n; i++) {
        d[i] -= shift;
    }
    double c = 1.0, c2 = 1.0, c3 = 1.0, s = 0.0, s2 = 0.0;
    p = d[m];
    for (size_t i = m; i-- > l;) {
        c3 = c2;
        c2 = c;
        s2 = s;
        g = c * e[i];
        const double h = c * p, r = hypot(p, e[i]);
        e[i + 1] = s * r;
        s = e[i] / r;
        c = p / r;
        p = c * d[i] - s * g;
        d[i + 1] = h + s * (c * g + s * d[i]);
        rotate(n, c, s, v + i * n, v + (i + 1) * n);
    }
    p = -s * s2 * c3 * beside * e[l] / next;
    e[l] = s * p;
    d[l] = c * p;
    return shift;
}

static bool ql(size_t n, double *v, double *d, double *e) {
    double shift = 0.0, size = 0.0;
    memmove(e, e + 1, (n - 1) * sizeof *e);
    e[n - 1] = 0.0;
    for (size_t l = 0; l < n; l++) {
        const double here = fabs(d[l]) + fabs(e[l]);
        size = here > size ? here : size;
        size_t m = l;
        while (m + 1 < n && !(fabs(e[m]) <= 0x1p-52 * size)) {
            m++;
        }
        int steps = 0;
        while (m > l && !(fabs(e[l]) <= 0x1p-52 * size)) {
            if (steps++ == MOST_STEPS) {
                return false;
            }
            shift += ql_step(n, l, m, v, d, e);
        }
        d[l] += shift;
        e[l] = 0.0;
    }
    return true;
}

static void sort_descending(size_t n, double *v, double *d) {
    for (size_t i = 0; i + 1 < n; i++) {
        size_t top = i;
        for (size_t j = i + 1; j < n; j++) {
            top = d[j] > d[top] ? j : top;
        }
        for (size_t k = 0; k < n && top != i; k++) {
            const double x = v[i * n + k];
            v[i * n + k] = v[top * n + k];
            v[top * n + k] = x;
        }
        const double value = d[i];
        d[i] = d[top];
        d[top] = value;
    }
}

bool enc_eigen_symmetric(size_t n, double *a, double *values) {
    double *e = calloc(n + 1, sizeof *e);
    bool done = n == 0;
    if (e && n > 0) {
        reduce(n, a, values, e);
        done = ql(n, a, values, e);
        sort_descending(n, a, values);
    }
    free(e);
    return done;
}

enum { GRAM_SIDE = 4, GRAM_RUN = 1024 };

/* Adds to out the products of `count` numbers of 4 rows a and 4 rows b. */
ENC_CLONES static void gram_tile(size_t count, size_t pitch, const float *a, const float *b, double *out) {
    lanes8 sum[GRAM_SIDE][GRAM_SIDE] = {{{0}}};
    for (size_t k = 0; k + LANES <= count; k += LANES) {
        lanes8 x[GRAM_SIDE], y[GRAM_SIDE];
        for (size_t i = 0; i < GRAM_SIDE; i++) {
            x[i] = __builtin_convertvector(*(const floats8 *)(a + i * pitch + k), lanes8);
            y[i] = __builtin_convertvector(*(const floats8 *)(b + i * pitch + k), lanes8);
        }
        for (size_t i = 0; i < GRAM_SIDE; i++) {
            for (size_t j = 0; j < GRAM_SIDE; j++) {
                sum[i][j] += x[i] * y[j];
            }
        }
    }
    for (size_t i = 0; i < GRAM_SIDE; i++) {
        for (size_t j = 0; j < GRAM_SIDE; j++) {
            double s[LANES];
            memcpy(s, &sum[i][j], sizeof s);
            for (size_t k = count / LANES * LANES; k < count; k++) {
                s[k % LANES] += (double)a[i * pitch + k] * b[j * pitch + k];
            }
            out[i * GRAM_SIDE + j] += sum_lanes(s);
        }
    }
}

/* Fills in the products of rows first .. first + 3 with the rows before them and with one another. */
static void gram_rows(size_t n, size_t count, const float *x, size_t first, double *out) {
    for (size_t other = 0; other <= first; other += GRAM_SIDE) {
        double tile[GRAM_SIDE * GRAM_SIDE] = {0};
        const size_t rows = n - first < GRAM_SIDE ? n - first : GRAM_SIDE;
        if (rows == GRAM_SIDE) {
            for (size_t k = 0; k < count; k += GRAM_RUN) {
                gram_tile(count - k < GRAM_RUN ? count - k : GRAM_RUN, count, x + first * count + k,
                          x + other * count + k, tile);
            }
        }
        for (size_t i = 0; i < rows; i++) {
            for (size_t j = 0; j < GRAM_SIDE && other + j <= first + i; j++) {
                double sum = tile[i * GRAM_SIDE + j];
                for (size_t k = 0; k < count && rows < GRAM_SIDE; k++) {
                    sum += (double)x[(first + i) * count + k] * x[(other + j) * count + k];
                }
                out[(first + i) * n + other + j] = out[(other + j) * n + first + i] = sum;
            }
        }
    }
}

void enc_gram_rows(int threads, size_t n, size_t count, const float *x, double *out) {
    const size_t blocks = (n + GRAM_SIDE - 1) / GRAM_SIDE;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (size_t b = 0; b < blocks; b++) {
        gram_rows(n, count, x, (blocks - 1 - b) * GRAM_SIDE, out); /* the long ones first */
    }
}
