/* Small dense linear algebra in double.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MATH_LINEAR_H
#define OPENBTF_ENCODER_MATH_LINEAR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Inner product of floats, exact products summed in double over eight lanes in one order. */
double enc_dot(size_t n, const float *restrict a, const float *restrict b);

/* In place, a = R^T R of a symmetric matrix [n][n]: the part at and above the diagonal is read, and the
 * upper triangular R written there. Returns false when a pivot is not positive. */
bool enc_cholesky(size_t n, double *a);
/* x := R^-T x, then x := R^-1 x, for x [n][columns]: together x := a^-1 x. */
void enc_lower_solve(size_t n, const double *r, double *x, size_t columns);
void enc_upper_solve(size_t n, const double *r, double *x, size_t columns);

/* Orthonormal rows of the span of v [k][row] by modified Gram-Schmidt, twice: v = lower * basis. A
 * dependent row has a zero row in the basis. All of basis and lower are written. Errors: false when out of
 * memory. */
bool enc_orthonormal_rows(size_t k, size_t row, const float *v, float *basis, float *lower);

/* Eigenvalues (descending) and eigenvectors (rows of `vectors`) of a symmetric matrix a [n][n], by
 * cyclic Jacobi rotations (Forsythe and Henrici 1960); a is destroyed. */
void enc_eigen(size_t n, double *a, double *values, double *vectors);

#endif
