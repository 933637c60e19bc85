/* Area filter of a BTF. See level_filter.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "level_filter.h"

#include "encoder/base/ranks.h"
#include "encoder/math/area.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

int enc_level_count(int width, int height) {
    int count = 1;
    for (int side = width > height ? width : height; side > 1; side >>= 1) {
        count++;
    }
    return count;
}

size_t enc_level_further_texels(int width, int height, int count) {
    size_t texels = 0;
    for (int level = 1; level < count; level++) {
        texels += (size_t)enc_level_side(width, level) * (size_t)enc_level_side(height, level);
    }
    return texels;
}

/* Filters one texel; buffer, out and sums have room for a texel each. */
static btf_result filter_texel(const enc_context *context, const enc_data *from, const enc_data *to,
                               size_t texel, float *buffer, double *sums, float *out) {
    const size_t stride = enc_data_texel_stride(from);
    const int column = (int)(texel % (size_t)to->width), row = (int)(texel / (size_t)to->width);
    int x0, x1, y0, y1;
    enc_area_span(from->width, to->width, column, &x0, &x1);
    enc_area_span(from->height, to->height, row, &y0, &y1);
    memset(sums, 0, stride * sizeof *sums);
    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) {
            const float *samples;
            const double weight = (double)enc_area_overlap(from->width, to->width, column, x) *
                                  (double)enc_area_overlap(from->height, to->height, row, y);
            const btf_result result = enc_data_texels(
                context, from, (size_t)y * (size_t)from->width + (size_t)x, 1, buffer, &samples);
            if (result != BTF_OK) {
                return result;
            }
            for (size_t i = 0; i < stride; i++) {
                sums[i] += weight * (double)samples[i];
            }
        }
    }
    const double area = (double)from->width * (double)from->height;
    for (size_t i = 0; i < stride; i++) {
        out[i] = (float)(sums[i] / area);
    }
    return BTF_OK;
}

btf_result enc_level_filter(const enc_context *context, const enc_data *from, int width, int height,
                            enc_data **out_data) {
    assert(width <= from->width && height <= from->height);
    enc_data *to = NULL;
    btf_result result = enc_data_create(context, width, height, from->n_views, from->views, from->n_lights,
                                        from->lights, &to);
    *out_data = NULL;
    if (result == BTF_OK) {
        result = enc_data_copy_lights(from, to);
    }
    if (result != BTF_OK) {
        enc_data_destroy(&to);
        return result;
    }
    const size_t stride = enc_data_texel_stride(from);
    size_t first, end;
    enc_ranks_range(context, enc_data_texel_count(to), &first, &end);
#pragma omp parallel num_threads(context->threads)
    {
        float *buffer = malloc(2 * stride * sizeof *buffer);
        double *sums = malloc(stride * sizeof *sums);
#pragma omp for schedule(dynamic)
        for (size_t t = first; t < end; t++) {
            btf_result mine;
#pragma omp atomic read
            mine = result;
            if (mine != BTF_OK) { /* a parallel loop cannot be left, so the rest is passed over */
                continue;
            }
            mine = !buffer || !sums ? BTF_ERROR_MEMORY
                   : enc_cancelled(context)
                       ? BTF_ERROR_INTERRUPTED
                       : filter_texel(context, from, to, t, buffer, sums, buffer + stride);
            if (mine == BTF_OK) {
                mine = enc_data_store_texels(context, to, t, 1, buffer + stride);
            }
            enc_keep_worse(&result, mine);
        }
        free(buffer);
        free(sums);
    }
    result = enc_data_complete(context, to, result);
    if (result == BTF_OK) {
        *out_data = to;
        return BTF_OK;
    }
    enc_data_destroy(&to);
    return result == BTF_ERROR_MEMORY
               ? enc_fail(context, result, "levels: out of memory to filter %d x %d texels", width, height)
               : result;
}

btf_result enc_level_each(const enc_context *context, const enc_data *data, int count, enc_level_fn fn,
                          void *user) {
    enc_data *before = NULL;
    btf_result result = BTF_OK;
    for (int level = 1; level < count && result == BTF_OK; level++) {
        enc_data *next = NULL;
        const int width = enc_level_side(data->width, level), height = enc_level_side(data->height, level);
        const bool even = before && before->width % width == 0 && before->height % height == 0;
        result = enc_level_filter(context, even ? before : data, width, height, &next);
        if (result == BTF_OK) {
            result = fn(user, level, next);
        }
        enc_data_destroy(&before);
        before = next;
    }
    enc_data_destroy(&before);
    return result;
}
