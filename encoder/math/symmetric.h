/* Eigenvectors of larger symmetric matrices, in double.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MATH_SYMMETRIC_H
#define OPENBTF_ENCODER_MATH_SYMMETRIC_H

#include <stdbool.h>
#include <stddef.h>

/* Eigenvalues (descending) and eigenvectors of a symmetric matrix a [n][n], which the rows of a are
 * afterwards: Householder's reduction to tridiagonal form and implicit QL (Bowdler, Martin, Reinsch and
 * Wilkinson 1968). About 6 n^3 operations; enc_eigen (linear.h) is more accurate for small ones of graded
 * matrices, and takes some twenty times as long. Errors: false when out of memory or where the QL steps do
 * not converge, which takes a matrix that holds no numbers. */
bool enc_eigen_symmetric(size_t n, double *a, double *values);

/* out [n][n] = x x^T of x [n][count], in double, each element one sum in an order that does not depend on
 * `threads`. */
void enc_gram_rows(int threads, size_t n, size_t count, const float *x, double *out);

#endif
