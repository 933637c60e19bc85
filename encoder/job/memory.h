/* The memory that an encode takes: at the least, and as expected with the memory allowed.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MEMORY_H
#define OPENBTF_ENCODER_MEMORY_H

#include "settings.h"

/* The fewest bytes in which data of this size can be encoded, beside the samples, which go to a scratch
 * file where there is no room for them: those of the largest stage, with the smallest blocks, and with one
 * thread where each needs much. The program itself is not counted, but for what grows with the data.
 * --method joint has the default budget. Each function is an enc_least_memory. */
uint64_t enc_memory_least_joint(int width, int height, int n_views, int n_lights, int threads);
uint64_t enc_memory_least_paper(int width, int height, int n_views, int n_lights, int threads);
enc_least_memory enc_memory_least(enc_method method);

/* The least memory for factors that fill `budget`. */
uint64_t enc_memory_of_factors(int width, int height, int n_views, int n_lights, int threads,
                               uint64_t budget);

/* The bytes that an encode is expected to take at its peak with the memory allowed, and those of its
 * scratch files. `budget`: of factors. `made`: samples are made again rather than kept in a file. `fitted`:
 * as many fitted values as samples exist beside them. */
typedef struct enc_memory_use {
    uint64_t peak, scratch;
} enc_memory_use;

enc_memory_use enc_memory_expected(const enc_context *context, enc_method method, int width, int height,
                                   int n_views, int n_lights, uint64_t budget, bool made, bool fitted);

#endif
