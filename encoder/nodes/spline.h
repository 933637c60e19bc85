/* Splines through all directions of a list, in the stereographic plane: radial kernels around the samples
 * and a polynomial of degree 1 (Duchon 1977).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NODES_SPLINE_H
#define OPENBTF_ENCODER_NODES_SPLINE_H

#include "encoder/data/data.h"

typedef enum enc_kernel {
    ENC_KERNEL_THIN_PLATE, /* r^2 log r */
    ENC_KERNEL_CUBIC,      /* r^3 */
} enc_kernel;

enum { ENC_SPLINE_MOST = ENC_MAX_DIRECTIONS + 3 }; /* numbers of a basis, at most */

typedef struct enc_spline enc_spline;

/* Projects a direction stereographically, without rounding to the decoder's steps. */
void enc_stereographic(const float xyz[3], double out[2]);

/* Makes the spline through `count` distinct directions. Errors, not logged: BTF_ERROR_UNSUPPORTED (fewer
 * than three, or nearly in one line of the plane, or nearly the same: the system is singular),
 * BTF_ERROR_MEMORY. */
btf_result enc_spline_create(const enc_direction *directions, int count, enc_kernel kernel,
                             enc_spline **out_spline);
void enc_spline_destroy(enc_spline **spline);

/* Evaluates the functions of which the spline is a weighted sum in direction `to`: out [count + 3]. */
void enc_spline_basis(const enc_spline *spline, const float to[3], double *out);

/* Turns sums of bases into weights of the samples: columns of [count + 3][columns], in place. Of the result
 * the first `count` rows are the weights. */
void enc_spline_solve(const enc_spline *spline, size_t columns, double *io);

/* Weights of the samples in direction `to`, which sum to 1: out [count]. Thread-safe. */
void enc_spline_weights(const enc_spline *spline, const float to[3], float *out);

#endif
