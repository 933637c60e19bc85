/* Products of factors with one another, and the exchange of factors of which each rank has computed a part.
 *
 * The products are small beside those with the samples: every rank does all of them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_ROWS_H
#define OPENBTF_ENCODER_FACTOR_ROWS_H

#include "encoder/base/ranks.h"

/* Computes out [n_a][n_b] = a b^T of a [n_a][count] and b [n_b][count]. The same bits for any number of
 * threads. false: out of memory. */
bool enc_rows_dot(int threads, size_t n_a, const float *a, size_t n_b, const float *b, size_t count,
                  float *out);

/* Computes out [n_out][count] = turn x of turn [n_out][n] and x [n][count]; out may be x where n_out <=
 * n. */
bool enc_rows_turn(int threads, size_t n_out, size_t n, const float *turn, size_t count, const float *x,
                   float *out);

/* Finds this rank's columns: first .. end - 1 of `count`. Ranks share columns `unit` at a time. */
void enc_rows_range(const enc_context *context, size_t count, size_t unit, size_t *out_first,
                    size_t *out_end);

/* Completes rows [n][count] of items of `item_bytes`, of which each rank has filled the columns of its
 * range. `result` is that of this rank's part. Errors: those of any rank; BTF_ERROR_MEMORY. */
btf_result enc_rows_complete(const enc_context *context, btf_result result, size_t n, size_t count,
                             size_t unit, size_t item_bytes, void *rows);

#endif
