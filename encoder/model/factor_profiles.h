/* The light profiles that factors give at the sampled directions: sums of level(w) * level(u) as products
 * of matrices, a channel at a time.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_FACTOR_PROFILES_H
#define OPENBTF_ENCODER_MODEL_FACTOR_PROFILES_H

#include "solution.h"

/* A view of a solution whose store is factors. */
typedef struct enc_factor_profiles enc_factor_profiles;

enum { ENC_FACTOR_BLOCK = 48 }; /* texels at a time, at most */

/* Prepares the profiles of one view by the first `units` units (at least one); keeps pointers into the
 * solution. NULL when out of memory. */
enc_factor_profiles *enc_factor_profiles_create(const enc_solution *solution, size_t view, uint32_t units);
void enc_factor_profiles_destroy(enc_factor_profiles **profiles);

/* Decodes the residual (FORMAT.md section 9) of texels sources[0 .. count - 1]: out[i][R, G, B][light]. One
 * thread at a time. */
void enc_factor_profiles_get(enc_factor_profiles *profiles, const size_t *sources, size_t count,
                             float *out);

#endif
