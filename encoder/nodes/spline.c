/* Splines through all directions of a list. See spline.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "spline.h"

#include "eigen_bridge.h"

#include <math.h>
#include <stdlib.h>

/* Reciprocal condition below which the weights lose digits: rings of 81 directions have 1e-5, 256 random
 * ones 1e-9. */
static const double least_rcond = 1e-12;

struct enc_spline {
    enc_kernel kernel;
    int count;
    double centre[2], scale; /* of the plane: they change no spline, but keep its digits */
    double (*place)[2];      /* [count] */
    double rcond;
    enc_solver *system;
};

void enc_stereographic(const float xyz[3], double out[2]) {
    out[0] = xyz[0] / (1.0 + xyz[2]);
    out[1] = xyz[1] / (1.0 + xyz[2]);
}

static void place(const enc_spline *s, const float xyz[3], double out[2]) {
    enc_stereographic(xyz, out);
    out[0] = (out[0] - s->centre[0]) * s->scale;
    out[1] = (out[1] - s->centre[1]) * s->scale;
}

/* r^2 log r, of which the spline bends least in the plane, or r^3, which is smoother (Duchon 1977: two
 * dimensions, m = 2, s = 0 and 1/2). */
static double kernel(enc_kernel kind, const double a[2], const double b[2]) {
    const double x = a[0] - b[0], y = a[1] - b[1], square = x * x + y * y;
    if (kind == ENC_KERNEL_CUBIC) {
        return square * sqrt(square);
    }
    return square > 0 ? 0.5 * square * log(square) : 0.0;
}

static void basis_at(const enc_spline *s, const double at[2], double *out) {
    for (int i = 0; i < s->count; i++) {
        out[i] = kernel(s->kernel, at, s->place[i]);
    }
    out[s->count] = 1;
    out[s->count + 1] = at[0];
    out[s->count + 2] = at[1];
}

/* Moves and scales the plane so that the samples fill the unit disc about its origin. */
static void settle(enc_spline *s, const enc_direction *directions) {
    double farthest = 0;
    s->scale = 1;
    for (int i = 0; i < s->count; i++) {
        double at[2];
        enc_stereographic(directions[i].xyz, at);
        s->centre[0] += at[0] / s->count;
        s->centre[1] += at[1] / s->count;
    }
    for (int i = 0; i < s->count; i++) {
        place(s, directions[i].xyz, s->place[i]);
        farthest = fmax(farthest, hypot(s->place[i][0], s->place[i][1]));
    }
    s->scale = farthest > 0 ? 1 / farthest : 1;
    for (int i = 0; i < s->count; i++) {
        place(s, directions[i].xyz, s->place[i]);
    }
}

static btf_result make_system(enc_spline *s) {
    const int n = s->count + 3;
    double *matrix = calloc((size_t)n * (size_t)n, sizeof *matrix);
    if (!matrix) {
        return BTF_ERROR_MEMORY;
    }
    for (int i = 0; i < s->count; i++) {
        basis_at(s, s->place[i], matrix + i * n);
        for (int j = 0; j < 3; j++) {
            matrix[(s->count + j) * n + i] = matrix[i * n + s->count + j];
        }
    }
    s->system = enc_solver_create((size_t)n, matrix);
    free(matrix);
    if (!s->system) {
        return BTF_ERROR_MEMORY;
    }
    s->rcond = enc_solver_rcond(s->system);
    return s->rcond > least_rcond ? BTF_OK : BTF_ERROR_UNSUPPORTED;
}

btf_result enc_spline_create(const enc_direction *directions, int count, enc_kernel kind,
                             enc_spline **out_spline) {
    *out_spline = NULL;
    if (count < 3) {
        return BTF_ERROR_UNSUPPORTED;
    }
    enc_spline *s = calloc(1, sizeof *s);
    if (!s) {
        return BTF_ERROR_MEMORY;
    }
    s->kernel = kind;
    s->count = count;
    s->place = malloc((size_t)count * sizeof *s->place);
    btf_result result = s->place ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        settle(s, directions);
        result = make_system(s);
    }
    if (result != BTF_OK) {
        enc_spline_destroy(&s);
    }
    *out_spline = s;
    return result;
}

void enc_spline_destroy(enc_spline **spline) {
    if (spline && *spline) {
        enc_solver_destroy((*spline)->system);
        free((*spline)->place);
        free(*spline);
        *spline = NULL;
    }
}

void enc_spline_basis(const enc_spline *s, const float to[3], double *out) {
    double at[2];
    place(s, to, at);
    basis_at(s, at, out);
}

/* The system is symmetric: weights are its solutions for a basis. */
void enc_spline_solve(const enc_spline *s, size_t columns, double *io) {
    enc_solver_solve(s->system, columns, io, io);
}

void enc_spline_weights(const enc_spline *s, const float to[3], float *out) {
    double x[ENC_SPLINE_MOST];
    enc_spline_basis(s, to, x);
    enc_spline_solve(s, 1, x);
    for (int i = 0; i < s->count; i++) {
        out[i] = (float)x[i];
    }
}
