/* Products of factors with one another, small beside those with the samples.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_ROWS_H
#define OPENBTF_ENCODER_FACTOR_ROWS_H

#include <stdbool.h>
#include <stddef.h>

/* out [n_a][n_b] = a b^T of a [n_a][count] and b [n_b][count]. The same bits for any number of threads.
 * false: out of memory. */
bool enc_rows_dot(int threads, size_t n_a, const float *a, size_t n_b, const float *b, size_t count,
                  float *out);

/* out [n_out][count] = turn x of turn [n_out][n] and x [n][count]; out may be x where n_out <= n. */
bool enc_rows_turn(int threads, size_t n_out, size_t n, const float *turn, size_t count, const float *x,
                   float *out);

#endif
