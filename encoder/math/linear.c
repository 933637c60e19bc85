/* Cholesky, Gram-Schmidt and Jacobi in double (see linear.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "linear.h"

#include "clones.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Copies of the hot loops for wider vectors. They hold no sums across lanes and are not contracted, so that
 * all copies give the same bits. */

/* to[i] -= factor * from[i]. */
ENC_CLONES static void subtract_scaled(size_t n, double factor, const double *restrict from,
                                         double *restrict to) {
    for (size_t i = 0; i < n; i++) {
        to[i] -= factor * from[i];
    }
}

ENC_CLONES double enc_dot(size_t n, const float *restrict a, const float *restrict b) {
    double sum[8] = {0.0};
    size_t i = 0;
    for (; i + 8 <= n; i += 8) {
        for (size_t j = 0; j < 8; j++) {
            sum[j] += (double)a[i + j] * (double)b[i + j];
        }
    }
    for (size_t j = 0; i + j < n; j++) {
        sum[j] += (double)a[i + j] * (double)b[i + j];
    }
    return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

/* One step of Cholesky's factorisation a = R^T R: row j becomes row j of R, and its products are taken off
 * rows j + 1 .. end - 1. False where the pivot is not positive. */
ENC_CLONES static bool eliminate(size_t n, double *a, size_t j, size_t end) {
    double *restrict row = a + j * n;
    if (!(row[j] > 0.0)) {
        return false;
    }
    const double pivot = sqrt(row[j]), inverse = 1.0 / pivot;
    row[j] = pivot;
    for (size_t m = j + 1; m < n; m++) {
        row[m] *= inverse;
    }
    for (size_t i = j + 1; i < end; i++) {
        const double factor = row[i];
        double *restrict to = a + i * n;
        for (size_t m = i; m < n; m++) {
            to[m] -= factor * row[m];
        }
    }
    return true;
}

/* Eliminates four rows at a time, so that those below are read and written a quarter as often. Each element
 * still has its products taken off in the order of rows. */
ENC_CLONES bool enc_cholesky(size_t n, double *a) {
    size_t j = 0;
    for (; j + 4 <= n; j += 4) {
        for (size_t p = j; p < j + 4; p++) {
            if (!eliminate(n, a, p, j + 4)) {
                return false;
            }
        }
        const double *restrict r0 = a + j * n, *restrict r1 = r0 + n, *restrict r2 = r1 + n,
                               *restrict r3 = r2 + n;
        for (size_t i = j + 4; i < n; i++) {
            const double f0 = r0[i], f1 = r1[i], f2 = r2[i], f3 = r3[i];
            double *restrict to = a + i * n;
            for (size_t m = i; m < n; m++) {
                to[m] = to[m] - f0 * r0[m] - f1 * r1[m] - f2 * r2[m] - f3 * r3[m];
            }
        }
    }
    for (; j < n; j++) {
        if (!eliminate(n, a, j, n)) {
            return false;
        }
    }
    return true;
}

void enc_lower_solve(size_t n, const double *r, double *x, size_t columns) {
    for (size_t i = 0; i < n; i++) {
        double *row = x + i * columns;
        const double inverse = 1.0 / r[i * n + i];
        for (size_t c = 0; c < columns; c++) {
            row[c] *= inverse;
        }
        if (columns == 1) {
            subtract_scaled(n - i - 1, row[0], r + i * n + i + 1, x + i + 1);
        } else {
            for (size_t m = i + 1; m < n; m++) {
                subtract_scaled(columns, r[i * n + m], row, x + m * columns);
            }
        }
    }
}

void enc_upper_solve(size_t n, const double *r, double *x, size_t columns) {
    for (size_t i = n; i-- > 0;) {
        double *row = x + i * columns;
        for (size_t m = i + 1; m < n && columns == 1; m++) {
            row[0] -= r[i * n + m] * x[m];
        }
        for (size_t m = i + 1; m < n && columns > 1; m++) {
            subtract_scaled(columns, r[i * n + m], x + m * columns, row);
        }
        const double inverse = 1.0 / r[i * n + i];
        for (size_t c = 0; c < columns; c++) {
            row[c] *= inverse;
        }
    }
}

bool enc_orthonormal_rows(size_t k, size_t row, const float *v, float *basis, float *lower) {
    double *q = malloc((k * row + k) * sizeof *q);
    if (!q) {
        return false;
    }
    double *factors = q + k * row;
    memset(lower, 0, k * k * sizeof *lower);
    for (size_t i = 0; i < k; i++) {
        double *mine = q + i * row;
        double before = 0.0, norm = 0.0;
        for (size_t p = 0; p < row; p++) {
            mine[p] = v[i * row + p];
            before += mine[p] * mine[p];
        }
        memset(factors, 0, k * sizeof *factors);
        /* a second pass takes off what rounding left of the others in the first: twice is enough (Parlett 1980) */
        for (int pass = 0; pass < 2; pass++) {
            for (size_t j = 0; j < i; j++) {
                const double *other = q + j * row;
                double dot = 0.0;
                for (size_t p = 0; p < row; p++) {
                    dot += mine[p] * other[p];
                }
                factors[j] += dot;
                for (size_t p = 0; p < row; p++) {
                    mine[p] -= dot * other[p];
                }
            }
        }
        for (size_t p = 0; p < row; p++) {
            norm += mine[p] * mine[p];
        }
        const bool dependent = !(norm > 1e-20 * before);
        const double inverse = dependent ? 0.0 : 1.0 / sqrt(norm);
        for (size_t p = 0; p < row; p++) {
            mine[p] *= inverse;
            basis[i * row + p] = (float)mine[p];
        }
        for (size_t j = 0; j < i; j++) {
            lower[i * k + j] = (float)factors[j];
        }
        lower[i * k + i] = dependent ? 0.0f : (float)sqrt(norm);
    }
    free(q);
    return true;
}

void enc_eigen(size_t n, double *a, double *values, double *vectors) {
    memset(vectors, 0, n * n * sizeof *vectors);
    for (size_t i = 0; i < n; i++) {
        vectors[i * n + i] = 1.0;
    }
    for (int sweep = 0; sweep < 40; sweep++) {
        double off = 0.0, on = 0.0;
        for (size_t i = 0; i < n; i++) {
            for (size_t j = 0; j < n; j++) {
                *(i == j ? &on : &off) += a[i * n + j] * a[i * n + j];
            }
        }
        if (off <= 1e-26 * on) {
            break;
        }
        for (size_t p = 0; p + 1 < n; p++) {
            for (size_t q = p + 1; q < n; q++) {
                const double apq = a[p * n + q];
                if (apq == 0.0) {
                    continue;
                }
                const double theta = (a[q * n + q] - a[p * n + p]) / (2.0 * apq);
                const double t = (theta >= 0.0 ? 1.0 : -1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
                const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
                for (size_t i = 0; i < n; i++) {
                    const double x = a[i * n + p], y = a[i * n + q];
                    a[i * n + p] = c * x - s * y;
                    a[i * n + q] = s * x + c * y;
                }
                for (size_t i = 0; i < n; i++) {
                    const double x = a[p * n + i], y = a[q * n + i];
                    a[p * n + i] = c * x - s * y;
                    a[q * n + i] = s * x + c * y;
                }
                for (size_t i = 0; i < n; i++) {
                    const double x = vectors[p * n + i], y = vectors[q * n + i];
                    vectors[p * n + i] = c * x - s * y;
                    vectors[q * n + i] = s * x + c * y;
                }
            }
        }
    }
    for (size_t i = 0; i < n; i++) {
        values[i] = a[i * n + i];
    }
    for (size_t i = 0; i + 1 < n; i++) { /* selection sort, descending */
        size_t top = i;
        for (size_t j = i + 1; j < n; j++) {
            if (values[j] > values[top]) {
                top = j;
            }
        }
        if (top != i) {
            const double value = values[i];
            values[i] = values[top];
            values[top] = value;
            for (size_t j = 0; j < n; j++) {
                const double x = vectors[i * n + j];
                vectors[i * n + j] = vectors[top * n + j];
                vectors[top * n + j] = x;
            }
        }
    }
}
