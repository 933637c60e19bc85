/* Ceres behind C: the solver of the Lafortune fit, and the plain automatic-derivative problem that it is
 * measured against.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_LAFORTUNE_CERES_BRIDGE_H
#define OPENBTF_ENCODER_LAFORTUNE_CERES_BRIDGE_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Evaluates a least-squares problem at `parameters`: out_normal is the symmetric (P+1) x (P+1) matrix
 * [J f]^T [J f], row-major, f the residuals and J their derivatives. All finite. */
typedef void (*enc_ceres_evaluate)(void *user, const double *parameters, double *out_normal);

typedef struct enc_ceres_options {
    int parameters;      /* P, >= 1 */
    const double *lower; /* [P] box; the start lies in it, and so does every point evaluated */
    const double *upper; /* [P] */
    double tolerance; /* stop after two steps in a row that lower the cost by less than this share of it */
    int max_evaluations;        /* calls of the evaluation at most, >= 1 */
    double trust_region_radius; /* of the first step; ceres::TinySolver's initial_trust_region_radius */
} enc_ceres_options;

typedef struct enc_ceres_summary {
    double cost; /* f^T f at the point returned */
    int evaluations;
} enc_ceres_summary;

/* Minimises f^T f with ceres::TinySolver (Levenberg-Marquardt), which is handed P + 1 rows with the same
 * J^T J, J^T f and f^T f as the whole problem. Each damped step is solved within the box (active set).
 * `parameters` holds the start, then the best point found. Thread-safe. Returns false when out of memory. */
bool enc_ceres_minimize(const enc_ceres_options *options, enc_ceres_evaluate evaluate, void *user,
                        double *parameters, enc_ceres_summary *out_summary);

enum { ENC_CERES_AUTODIFF_LOBES = 3 };

/* The problem as one would write it down first: a ceres::Problem with one automatically differentiated
 * block of 3 residuals a sample, parameters (C_R, C_G, C_B, rho_d), then (Cx, Cy, Cz, n) a lobe, residual
 * multiplier * C * (rho_d + sum_j max(0, Cx x + Cy y + Cz z)^n) - target, n in [min_n, max_n], C in
 * [-max_c, max_c], rho_d >= 0, one thread, DENSE_NORMAL_CHOLESKY. product = l * v by component, planar.
 * Three lobes, the paper's number. Returns false when Ceres fails. out_cost = sum of squared residuals. */
bool enc_ceres_autodiff_fit(size_t n, const float *const product[3], const float *multiplier,
                            const float *const target[3], double min_n, double max_n, double max_c,
                            double function_tolerance, double *parameters, double *out_cost,
                            int *out_iterations);

#ifdef __cplusplus
}
#endif
#endif
