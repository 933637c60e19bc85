/* Eigen::PartialPivLU. See eigen_bridge.h.
 *
 * SPDX-License-Identifier: MIT
 */
#define EIGEN_DONT_PARALLELIZE /* callers run many small systems side by side */
#include "eigen_bridge.h"

#include <Eigen/Dense>
#include <new>

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct enc_solver {
    Eigen::PartialPivLU<Matrix> lu;
};

enc_solver *enc_solver_create(size_t n, const double *matrix) {
    try {
        const auto size = Eigen::Index(n);
        return new enc_solver{Eigen::PartialPivLU<Matrix>(Eigen::Map<const Matrix>(matrix, size, size))};
    } catch (const std::bad_alloc &) {
        return nullptr;
    }
}

void enc_solver_destroy(enc_solver *solver) {
    delete solver;
}

double enc_solver_rcond(const enc_solver *solver) {
    /* A pivot of 0 would give infinities or NaN. */
    const auto diagonal = solver->lu.matrixLU().diagonal();
    if (diagonal.cwiseAbs().minCoeff() == 0) {
        return 0;
    }
    const double rcond = solver->lu.rcond();
    return rcond > 0 ? rcond : 0;
}

void enc_solver_solve(const enc_solver *solver, size_t count, const double *right, double *out) {
    const auto rows = solver->lu.rows();
    const auto columns = Eigen::Index(count);
    Eigen::Map<Matrix> to(out, rows, columns);
    if (out != right) {
        to = Eigen::Map<const Matrix>(right, rows, columns);
    }
    to = (solver->lu.permutationP() * to).eval();
    solver->lu.matrixLU().triangularView<Eigen::UnitLower>().solveInPlace(to);
    solver->lu.matrixLU().triangularView<Eigen::Upper>().solveInPlace(to);
}
