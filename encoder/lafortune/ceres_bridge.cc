/* ceres::TinySolver on accumulated rows, bounds included; and ceres::Problem with automatic derivatives.
 *
 * SPDX-License-Identifier: MIT
 */
#include "ceres_bridge.h"
#include <Eigen/Dense>
#include <algorithm>
#include <ceres/ceres.h>
#include <ceres/tiny_solver.h>
#include <cmath>
#include <glog/logging.h>
#include <limits>
#include <new>
#include <vector>

namespace {

/* The box as the running solve sees it, in the solver's own (Jacobi-scaled) steps. One solve a thread. */
struct StepBox {
    const double *low, *high;
};
thread_local StepBox step_box;

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/* The linear solver handed to TinySolver: minimises s^T M s / 2 - g^T s over low <= s <= high by an active
 * set, M being positive definite thanks to the damping. */
class BoxSolver {
  public:
    void compute(const Matrix &matrix) {
        matrix_ = matrix;
    }

    Vector solve(const Vector &g) {
        const int size = int(g.size());
        held_.assign(size_t(size), 0);
        Vector step;
        for (int round = 0; round < 3 * size; round++) {
            step = solve_free(g);
            if (hold(step)) {
                continue;
            }
            /* All free ones inside: let go of the bound that the quadratic model pulls away from most. */
            const Vector pull = g - matrix_ * step;
            int worst = -1;
            double most = 1e-12 * g.cwiseAbs().maxCoeff();
            for (int i = 0; i < size; i++) {
                if (held_[size_t(i)] * -pull[i] > most) {
                    most = held_[size_t(i)] * -pull[i];
                    worst = i;
                }
            }
            if (worst < 0) {
                break;
            }
            held_[size_t(worst)] = 0;
        }
        for (int i = 0; i < size; i++) {
            step[i] = std::min(std::max(step[i], step_box.low[i]), step_box.high[i]);
        }
        return step;
    }

  private:
    /* Moves free variables that left the box to its bounds; true when there were any. */
    bool hold(const Vector &step) {
        bool changed = false;
        for (int i = 0; i < int(step.size()); i++) {
            int &held = held_[size_t(i)];
            if (held == 0 && !(step[i] >= step_box.low[i] && step[i] <= step_box.high[i])) {
                held = step[i] > step_box.high[i] ? 1 : -1;
                changed = true;
            }
        }
        return changed;
    }

    /* The minimum over the free variables with the held ones at their bounds. */
    Vector solve_free(const Vector &g) {
        reduced_ = matrix_;
        Vector right = g;
        for (int i = 0; i < int(g.size()); i++) {
            if (held_[size_t(i)] == 0) {
                continue;
            }
            const double value = held_[size_t(i)] < 0 ? step_box.low[i] : step_box.high[i];
            right -= matrix_.col(i) * value;
            reduced_.row(i).setZero();
            reduced_.col(i).setZero();
            reduced_(i, i) = 1;
        }
        for (int i = 0; i < int(g.size()); i++) {
            if (held_[size_t(i)] != 0) {
                right[i] = held_[size_t(i)] < 0 ? step_box.low[i] : step_box.high[i];
            }
        }
        factor_.compute(reduced_);
        return factor_.solve(right);
    }

    Matrix matrix_, reduced_;
    Eigen::LDLT<Matrix> factor_;
    std::vector<int> held_; /* -1 at the lower bound, 1 at the upper, 0 free */
};

/* The problem as P + 1 rows R with R^T R = [J f]^T [J f]: the Cholesky factor, where a pivot lost in the
 * rounding of the sums (rank-deficient J) leaves an empty row. */
struct AccumulatedRows {
    using Scalar = double;
    using Solver = ceres::TinySolver<AccumulatedRows, BoxSolver>;
    enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = Eigen::Dynamic };
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

    const enc_ceres_options *options;
    enc_ceres_evaluate evaluate;
    void *user;
    Solver *solver;
    int size;
    mutable RowMajor normal;    /* at `seen` */
    mutable RowMajor rows;      /* its factor */
    mutable Vector point, seen; /* the point asked for, the point evaluated last */
    mutable Vector scale;       /* TinySolver's Jacobi scaling, fixed at the first point */
    mutable Vector low, high;   /* the distance to the bounds, over `scale` */
    mutable double last = -1;   /* cost of the last point taken, -1 before the first */
    mutable int slow = 0;       /* small improvements running */
    mutable int evaluated = 0;  /* calls of evaluate */

    AccumulatedRows(const enc_ceres_options *o, enc_ceres_evaluate e, void *u, Solver *s)
        : options(o), evaluate(e), user(u), solver(s), size(o->parameters), normal(size + 1, size + 1),
          rows(size + 1, size + 1), point(size), seen(size), scale(size), low(size), high(size) {}

    int NumResiduals() const {
        return size + 1;
    }
    int NumParameters() const {
        return size;
    }

    bool operator()(const double *parameters, double *residuals, double *jacobian) const {
        for (int i = 0; i < size; i++) {
            point[i] = std::min(std::max(parameters[i], options->lower[i]), options->upper[i]);
        }
        if (evaluated == 0 || point != seen) {
            evaluate(user, point.data(), normal.data());
            seen = point;
            evaluated++;
        }
        if (evaluated >= options->max_evaluations) {
            solver->options.max_num_iterations = 0;
        }
        Eigen::Map<Vector> f(residuals, size + 1);
        f.setZero();
        if (jacobian == nullptr) {
            f[size] = std::sqrt(std::max(normal(size, size), 0.0));
            return true;
        }
        factorise();
        Eigen::Map<Matrix> j(jacobian, size + 1, size);
        j = rows.leftCols(size);
        f = rows.col(size);
        take();
        return true;
    }

    /* Upper Cholesky factor of `normal`, lower part zero. */
    void factorise() const {
        rows = normal;
        for (int i = 0; i <= size; i++) {
            const double pivot = rows(i, i);
            if (!(pivot > (i < size ? 1e-7 : 0.0) * normal(i, i))) {
                rows.row(i).setZero();
                continue;
            }
            rows.row(i) /= std::sqrt(pivot);
            for (int k = i + 1; k <= size; k++) {
                rows.row(k).tail(size + 1 - k) -= rows(i, k) * rows.row(i).tail(size + 1 - k);
            }
            rows.row(i).head(i).setZero();
        }
    }

    /* A point was taken: measure the room to the bounds, and stop the solver when the cost stands still. */
    void take() const {
        if (last < 0) {
            scale = (1.0 + normal.diagonal().head(size).cwiseMax(0.0).cwiseSqrt().array()).inverse();
        }
        low = (Eigen::Map<const Vector>(options->lower, size) - seen).cwiseQuotient(scale);
        high = (Eigen::Map<const Vector>(options->upper, size) - seen).cwiseQuotient(scale);
        step_box.low = low.data();
        step_box.high = high.data();
        const double cost = std::max(normal(size, size), 0.0);
        if (last >= 0) {
            slow = last - cost < options->tolerance * last ? slow + 1 : 0;
            if (slow >= 2) {
                solver->options.cost_threshold = std::numeric_limits<double>::infinity();
            }
        }
        last = cost;
    }
};

void minimize(const enc_ceres_options *options, enc_ceres_evaluate evaluate, void *user, double *parameters,
              enc_ceres_summary *out_summary) {
    AccumulatedRows::Solver solver;
    AccumulatedRows rows(options, evaluate, user, &solver);
    solver.options.max_num_iterations = options->max_evaluations + 1;
    solver.options.gradient_tolerance = 0;
    solver.options.function_tolerance = 0;
    solver.options.parameter_tolerance = 1e-7;
    solver.options.cost_threshold = 0;
    solver.options.initial_trust_region_radius = options->trust_region_radius;
    Vector x = Eigen::Map<const Vector>(parameters, options->parameters);
    solver.Solve(rows, &x);
    for (int i = 0; i < options->parameters; i++) {
        parameters[i] = std::min(std::max(x[i], options->lower[i]), options->upper[i]);
    }
    out_summary->cost = 2 * solver.summary.final_cost;
    out_summary->evaluations = rows.evaluated;
}

/* One sample of the plain problem. */
struct SampleResidual {
    float product[3], multiplier, target[3];

    template <typename T>
    bool operator()(const T *parameters, T *residuals) const {
        T sum = parameters[3];
        for (int j = 0; j < ENC_CERES_AUTODIFF_LOBES; j++) {
            const T *lobe = parameters + 4 + 4 * j;
            const T base =
                lobe[0] * double(product[0]) + lobe[1] * double(product[1]) + lobe[2] * double(product[2]);
            if (base > 1e-4) {
                sum += ceres::pow(base, lobe[3]);
            }
        }
        for (int c = 0; c < 3; c++) {
            residuals[c] = double(multiplier) * parameters[c] * sum - double(target[c]);
        }
        return true;
    }
};

} // namespace

extern "C" bool enc_ceres_minimize(const enc_ceres_options *options, enc_ceres_evaluate evaluate,
                                   void *user, double *parameters, enc_ceres_summary *out_summary) {
    try {
        minimize(options, evaluate, user, parameters, out_summary);
        return true;
    } catch (const std::bad_alloc &) {
        return false;
    }
}

extern "C" bool enc_ceres_autodiff_fit(size_t n, const float *const product[3], const float *multiplier,
                                       const float *const target[3], double min_n, double max_n,
                                       double max_c, double function_tolerance, double *parameters,
                                       double *out_cost, int *out_iterations) {
    constexpr int size = 4 + 4 * ENC_CERES_AUTODIFF_LOBES;
    FLAGS_minloglevel = google::GLOG_FATAL; /* Ceres reports every damping retry as a warning */
    ceres::Problem problem;
    for (size_t i = 0; i < n; i++) {
        auto *sample = new SampleResidual{{product[0][i], product[1][i], product[2][i]},
                                          multiplier[i],
                                          {target[0][i], target[1][i], target[2][i]}};
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<SampleResidual, 3, size>(sample), nullptr,
                                 parameters);
    }
    for (int i = 4; i < size; i++) {
        problem.SetParameterLowerBound(parameters, i, i % 4 < 3 ? -max_c : min_n);
        problem.SetParameterUpperBound(parameters, i, i % 4 < 3 ? max_c : max_n);
    }
    problem.SetParameterLowerBound(parameters, 3, 0.0);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.function_tolerance = function_tolerance;
    options.max_num_iterations = 200;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    *out_cost = 2 * summary.final_cost;
    *out_iterations = int(summary.iterations.size());
    return summary.IsSolutionUsable();
}
