/* The memory that an encode takes: at the least, and as expected with what it is allowed.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MEMORY_H
#define OPENBTF_ENCODER_MEMORY_H

#include "settings.h"

/* Bytes that an encode of such data takes beside the samples and, by --method joint, the projection, which
 * go to scratch files where there is no room for them: the largest stage, each in its smallest blocks with
 * one thread where a thread needs much. Of the program itself only what grows with the data.
 * Each is an enc_least_memory. */
uint64_t enc_memory_least_joint(int width, int height, int n_views, int n_lights, int threads);
uint64_t enc_memory_least_paper(int width, int height, int n_views, int n_lights, int threads);
/* By the default budget. */
uint64_t enc_memory_least_factors(int width, int height, int n_views, int n_lights, int threads);
enc_least_memory enc_memory_least(enc_method method);

/* The same for factors that fill `budget`. */
uint64_t enc_memory_of_factors(int width, int height, int n_views, int n_lights, int threads,
                               uint64_t budget);

/* Bytes that an encode is expected to take at its peak with what is allowed, and those of its scratch
 * files; `components`: of the joint method's residual; `budget`: of factors; `made`: samples are made again
 * rather than kept in a file; `fitted`: as many fitted values lie beside them. */
typedef struct enc_memory_use {
    uint64_t peak, scratch;
} enc_memory_use;

enc_memory_use enc_memory_expected(const enc_context *context, enc_method method, int width, int height,
                                   int n_views, int n_lights, size_t components, uint64_t budget,
                                   bool made, bool fitted);

#endif
