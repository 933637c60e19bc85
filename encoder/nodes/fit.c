/* Fitted nodes. See fit.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fit.h"

#include "eigen_bridge.h"
#include "spline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* How far a blend of directions may lie from the one asked for, in the stereographic plane, where the hull
 * holds it: the decoder's plane has steps of 1/8192, its weights of 1/4096. */
static const double hull_slack = 3e-4;

/* Added to kappa, so that nodes on which no point of the hull depends keep their samples. */
static const double least_kappa = 1e-3;

struct enc_node_fit {
    int count;
    float (*point)[3]; /* [points] */
    int points;
    double *square; /* B^T B, [count][count], of the points' barycentric weights B */
    double *target; /* B^T R, [count][count], of their spline weights R */
};

/* Point k of n that spread evenly over the cap about the pole down to z: a spiral that turns by the golden
 * angle (Swinbank and Purser 2006). */
static void cap_point(int k, int n, double z, float out[3]) {
    static const double turn = 2.39996322972865332; /* the golden angle */
    const double height = 1 - (k + 0.5) / n * (1 - z), radius = sqrt(fmax(0, 1 - height * height));
    out[0] = (float)(radius * cos(k * turn));
    out[1] = (float)(radius * sin(k * turn));
    out[2] = (float)height;
}

static bool inside(const enc_direction *directions, const enc_weights *w, const float to[3]) {
    double own[2], at[2], off[2] = {0, 0};
    enc_stereographic(to, own);
    for (int i = 0; i < w->count; i++) {
        enc_stereographic(directions[w->index[i]].xyz, at);
        off[0] += (double)w->weight[i] * (at[0] - own[0]);
        off[1] += (double)w->weight[i] * (at[1] - own[1]);
    }
    return hypot(off[0], off[1]) < hull_slack;
}

/* Adds a point to the normal equations: B^T B of its weights to `square`, B^T times the spline's basis to
 * `bases` [count][count + 3]. */
static void add_point(enc_node_fit *f, const enc_spline *spline, const enc_weights *w, const float to[3],
                      double *bases) {
    const int n = f->count, length = n + 3;
    double basis[ENC_SPLINE_MOST];
    enc_spline_basis(spline, to, basis);
    for (int i = 0; i < w->count; i++) {
        double *row = bases + (size_t)w->index[i] * (size_t)length;
        for (int k = 0; k < length; k++) {
            row[k] += (double)w->weight[i] * basis[k];
        }
        for (int j = 0; j < w->count; j++) {
            f->square[(size_t)w->index[i] * (size_t)n + w->index[j]] +=
                (double)w->weight[i] * (double)w->weight[j];
        }
    }
}

/* Counts the points of a cap of `n` that lie in the hull, and writes them to `points` unless it is NULL. */
static int points_inside(const enc_direction *directions, const enc_interpolator *blend, int n, double z,
                         float (*points)[3]) {
    int found = 0;
    for (int k = 0; k < n; k++) {
        float to[3];
        enc_weights w;
        cap_point(k, n, z, to);
        enc_interpolator_weights(blend, to, &w);
        if (inside(directions, &w, to)) {
            if (points) {
                memcpy(points[found], to, sizeof to);
            }
            found++;
        }
    }
    return found;
}

static btf_result find_points(const enc_direction *directions, const enc_interpolator *blend, int wanted,
                              enc_node_fit *f) {
    double z = 1;
    for (int i = 0; i < f->count; i++) {
        z = fmin(z, (double)directions[i].xyz[2]);
    }
    const int first = points_inside(directions, blend, wanted, z, NULL);
    if (first == 0) {
        return BTF_ERROR_UNSUPPORTED;
    }
    /* where the hull is a small part of the cap, more points are made */
    const double more = fmin(64, (double)wanted / first);
    const int n = (int)(wanted * more);
    f->point = malloc((size_t)n * sizeof *f->point);
    if (!f->point) {
        return BTF_ERROR_MEMORY;
    }
    f->points = points_inside(directions, blend, n, z, f->point);
    return f->points > f->count ? BTF_OK : BTF_ERROR_UNSUPPORTED;
}

/* Turns rows of bases into rows of spline weights: B^T R. */
static btf_result solve_target(const enc_spline *spline, const double *bases, enc_node_fit *f) {
    const size_t n = (size_t)f->count, length = n + 3;
    double *columns = malloc(length * n * sizeof *columns);
    if (!columns) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < length; k++) {
            columns[k * n + i] = bases[i * length + k];
        }
    }
    enc_spline_solve(spline, n, columns);
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < n; k++) {
            f->target[i * n + k] = columns[k * n + i];
        }
    }
    free(columns);
    return BTF_OK;
}

static btf_result make(const enc_direction *directions, const enc_interpolator *blend,
                       const enc_spline *spline, int wanted, enc_node_fit *f) {
    const size_t n = (size_t)f->count;
    double *bases = calloc(n * (n + 3), sizeof *bases);
    f->square = calloc(n * n, sizeof *f->square);
    f->target = calloc(n * n, sizeof *f->target);
    btf_result result = bases && f->square && f->target ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = find_points(directions, blend, wanted, f);
    }
    for (int p = 0; result == BTF_OK && p < f->points; p++) {
        enc_weights w;
        enc_interpolator_weights(blend, f->point[p], &w);
        add_point(f, spline, &w, f->point[p], bases);
    }
    if (result == BTF_OK) {
        result = solve_target(spline, bases, f);
    }
    free(bases);
    return result;
}

btf_result enc_node_fit_create(const enc_context *context, const enc_direction *directions, int count,
                               int points, enc_node_fit **out_fit) {
    enc_spline *spline = NULL;
    enc_interpolator *blend = NULL;
    enc_node_fit *f = calloc(1, sizeof *f);
    *out_fit = NULL;
    btf_result result = f ? enc_spline_create(directions, count, ENC_KERNEL_CUBIC, &spline) : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        f->count = count;
        result = enc_interpolator_create(context, "directions", directions, count, ENC_INTERPOLATE_LINEAR,
                                         &blend);
    }
    if (result == BTF_OK) {
        result = make(directions, blend, spline, points, f);
    }
    enc_interpolator_destroy(&blend);
    enc_spline_destroy(&spline);
    if (result != BTF_OK) {
        enc_node_fit_destroy(&f);
    }
    *out_fit = f;
    return result;
}

void enc_node_fit_destroy(enc_node_fit **fit) {
    if (fit && *fit) {
        free((*fit)->point);
        free((*fit)->square);
        free((*fit)->target);
        free(*fit);
        *fit = NULL;
    }
}

static double weight_of_nodes(const enc_node_fit *f, double kappa) {
    return (least_kappa + kappa) * f->points / f->count;
}

/* Decomposes B^T B + l, which l makes positive definite. NULL: out of memory. */
static enc_solver *normal_equations(const enc_node_fit *f, double l) {
    const size_t n = (size_t)f->count;
    double *matrix = malloc(n * n * sizeof *matrix);
    if (!matrix) {
        return NULL;
    }
    memcpy(matrix, f->square, n * n * sizeof *matrix);
    for (size_t i = 0; i < n; i++) {
        matrix[i * n + i] += l;
    }
    enc_solver *solver = enc_solver_create(n, matrix);
    free(matrix);
    return solver;
}

/* Rounds one row of weights to float. BTF_ERROR_UNSUPPORTED: they are larger than ENC_FIT_MOST_GAIN
 * allows. */
static btf_result deliver(const double *row, size_t n, float *out) {
    double gain = 0;
    for (size_t k = 0; k < n; k++) {
        gain += fabs(row[k]);
        out[k] = (float)row[k];
    }
    return gain <= ENC_FIT_MOST_GAIN ? BTF_OK : BTF_ERROR_UNSUPPORTED;
}

btf_result enc_node_fit_weights(const enc_node_fit *f, double kappa, float *out) {
    const size_t n = (size_t)f->count;
    const double l = weight_of_nodes(f, kappa);
    enc_solver *solver = normal_equations(f, l);
    double *w = malloc(n * n * sizeof *w);
    btf_result result = solver && w ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        memcpy(w, f->target, n * n * sizeof *w);
        for (size_t i = 0; i < n; i++) { /* at the nodes the spline equals the samples */
            w[i * n + i] += l;
        }
        enc_solver_solve(solver, n, w, w);
    }
    for (size_t i = 0; i < n && result == BTF_OK; i++) {
        result = deliver(w + i * n, n, out + i * n);
    }
    enc_solver_destroy(solver);
    free(w);
    return result;
}

/* Finds the blends by the adjoint system, which needs no W: b^T W = y^T (B^T R + l) with (B^T B + l) y =
 * b. */
btf_result enc_node_fit_blend(const enc_node_fit *f, double kappa, size_t n_at, const enc_weights *at,
                              float *out) {
    const size_t n = (size_t)f->count;
    const double l = weight_of_nodes(f, kappa);
    enc_solver *solver = normal_equations(f, l);
    double *y = calloc(n * n_at + n, sizeof *y), *row = y ? y + n * n_at : NULL;
    btf_result result = solver && y ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t i = 0; i < n_at && y; i++) {
        for (int k = 0; k < at[i].count; k++) {
            y[at[i].index[k] * n_at + i] += (double)at[i].weight[k];
        }
    }
    if (result == BTF_OK) {
        enc_solver_solve(solver, n_at, y, y);
    }
    for (size_t i = 0; i < n_at && result == BTF_OK; i++) {
        for (size_t k = 0; k < n; k++) {
            row[k] = l * y[k * n_at + i];
        }
        for (size_t j = 0; j < n; j++) {
            for (size_t k = 0; k < n; k++) {
                row[k] += y[j * n_at + i] * f->target[j * n + k];
            }
        }
        result = deliver(row, n, out + i * n);
    }
    enc_solver_destroy(solver);
    free(y);
    return result;
}

int enc_node_fit_points(const enc_node_fit *f, const float (**out_points)[3]) {
    *out_points = (const float (*)[3])f->point;
    return f->points;
}
