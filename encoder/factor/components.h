/* The leading components of each channel of a BTF: A = sum of u_j w_j, by falling energy.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_COMPONENTS_H
#define OPENBTF_ENCODER_FACTOR_COMPONENTS_H

#include "matrix.h"

#include <stdbool.h>

typedef struct enc_components {
    size_t rank;
    float *u, *w; /* [rank][texel], [rank][column]: u_j and w_j have one length, the root of the singular
                     value */
    double *energy; /* [rank]: squared singular values, falling; none is 0 */
    size_t sought;  /* components that were asked for, at most the smaller side of the matrix */
} enc_components;

/* Share of the first component's energy below which a component is rounding of products in float. */
#define ENC_COMPONENTS_ROUNDING 1e-11

/* Finds rank[channel] components of each channel by a randomised range finder with `power_steps` steps of
 * subspace iteration (Halko, Martinsson and Tropp 2011, algorithms 4.4 and 5.1); channels of rank 0 are
 * left as they are. The same bits for any number of threads and ranks. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO,
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_components_find(const enc_factor_matrix *matrix, const size_t rank[ENC_FACTOR_CHANNELS],
                               int power_steps, enc_components io_components[ENC_FACTOR_CHANNELS]);
/* Orthonormal rows of the span of x [rank][count]. Errors: false when out of memory. */
bool enc_components_orthonormalise(const enc_factor_matrix *matrix, size_t rank, size_t count, float *x);
/* The energies of all channels, for plans. */
enc_factor_energies enc_components_energies(const enc_components components[ENC_FACTOR_CHANNELS]);
/* Copies all channels. Errors: BTF_ERROR_MEMORY; the caller clears out then, too. */
btf_result enc_components_copy(const enc_factor_matrix *matrix,
                               const enc_components from[ENC_FACTOR_CHANNELS],
                               enc_components out[ENC_FACTOR_CHANNELS]);
void enc_components_clear(enc_components *components);

#endif
