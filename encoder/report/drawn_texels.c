/* Sums over texels that are drawn from a data set. See drawn_texels.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "drawn_texels.h"

#include "encoder/base/ranks.h"

#include <stdlib.h>
#include <string.h>

enum { BATCH = 16 }; /* texels of each rank */

typedef struct job {
    const enc_context *context;
    const enc_data *data;
    size_t draws, length;
    enc_measure_texel *measure;
    const void *user;
} job;

static btf_result measure_one(const job *j, size_t index, double *sums) {
    if (enc_cancelled(j->context)) {
        return BTF_ERROR_INTERRUPTED;
    }
    const size_t count = enc_data_texel_count(j->data), first = index * count / j->draws;
    const size_t texel = first + enc_mix(index) % ((index + 1) * count / j->draws - first);
    float *buffer = malloc(enc_data_texel_stride(j->data) * sizeof *buffer);
    const float *samples;
    btf_result result =
        buffer ? enc_data_texels(j->context, j->data, texel, 1, buffer, &samples) : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = j->measure(j->user, index, texel, samples, sums);
    }
    free(buffer);
    return result;
}

/* Finds the sums of draws first .. first + n - 1, of which each rank makes its share:
 * sums[draw][length]. */
static btf_result measure_batch(const job *j, size_t first, size_t n, double *sums) {
    btf_result result = BTF_OK;
    size_t begin, end;
    enc_ranks_range(j->context, n, &begin, &end);
    memset(sums, 0, n * j->length * sizeof *sums);
#pragma omp parallel for schedule(dynamic) num_threads(j->context->threads)
    for (size_t i = begin; i < end; i++) {
        const btf_result mine = measure_one(j, first + i, sums + i * j->length);
        enc_keep_worse(&result, mine);
    }
    return enc_ranks_gather(j->context, result, sums, j->length * sizeof *sums, n);
}

btf_result enc_drawn_texels_sum(const enc_context *context, const enc_data *data, size_t draws,
                                size_t length, enc_measure_texel *measure, const void *user,
                                double *total) {
    const job j = {context, data, draws, length, measure, user};
    const size_t batch = BATCH * (size_t)enc_ranks_count(context);
    double *sums = malloc(batch * length * sizeof *sums);
    btf_result result = enc_ranks_agree(context, sums ? BTF_OK : BTF_ERROR_MEMORY);
    for (size_t first = 0; result == BTF_OK && first < draws; first += batch) {
        const size_t n = draws - first < batch ? draws - first : batch;
        result = measure_batch(&j, first, n, sums);
        for (size_t i = 0; result == BTF_OK && i < n * length; i++) {
            total[i % length] += sums[i];
        }
    }
    free(sums);
    return result;
}
