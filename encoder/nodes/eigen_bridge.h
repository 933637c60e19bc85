/* Eigen behind C: square systems of linear equations.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NODES_EIGEN_BRIDGE_H
#define OPENBTF_ENCODER_NODES_EIGEN_BRIDGE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The LU decomposition of a matrix, with row exchanges. */
typedef struct enc_solver enc_solver;

/* `matrix` is row-major, [n][n], n >= 1, finite. NULL: out of memory. */
enc_solver *enc_solver_create(size_t n, const double *matrix);
void enc_solver_destroy(enc_solver *solver);

/* Estimate of the reciprocal condition number in the 1-norm: 0 for a singular matrix. */
double enc_solver_rcond(const enc_solver *solver);

/* out = matrix^-1 right, both row-major, [n][count], of a matrix that is not singular; out may be right.
 * One thread, the same bits on every machine. Thread-safe. */
void enc_solver_solve(const enc_solver *solver, size_t count, const double *right, double *out);

#ifdef __cplusplus
}
#endif
#endif
