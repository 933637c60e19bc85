/* Coordinates of all points (see coordinates.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "coordinates.h"

#include "encoder/math/gemm.h"
#include "encoder/base/scratch.h"
#include "encoder/base/ranks.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct joint_coordinates {
    size_t floats, first; /* first: of the views held */
    float *values;        /* [view - first][floats]; with a scratch file [floats], of the view read last */
    int scratch;          /* -1: all in memory */
};

btf_result joint_coordinates_create(const enc_context *context, size_t views, size_t floats,
                                    joint_coordinates **out_points) {
    size_t first, end;
    enc_ranks_range(context, views, &first, &end);
    views = end - first;
    const uint64_t bytes = (uint64_t)views * floats * sizeof(float);
    const bool in_memory = context->memory == 0 || bytes <= context->memory / 4;
    joint_coordinates *points = malloc(sizeof *points);
    *out_points = points;
    if (!points)
        return BTF_ERROR_MEMORY;
    *points = (joint_coordinates){floats, first, enc_gemm_alloc(in_memory ? views * floats : floats), -1};
    btf_result result = points->values ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK && !in_memory)
        result = enc_scratch_open(context, "joint: projection", bytes, &points->scratch);
    if (result != BTF_OK)
        joint_coordinates_destroy(out_points);
    return result;
}

void joint_coordinates_destroy(joint_coordinates **points) {
    if (!*points)
        return;
    if ((*points)->scratch >= 0)
        close((*points)->scratch);
    free((*points)->values);
    free(*points);
    *points = NULL;
}

btf_result joint_coordinates_store(const enc_context *context, joint_coordinates *points, size_t view,
                                   size_t at, size_t count, const float *values) {
    const size_t first = (view - points->first) * points->floats + at;
    if (points->scratch >= 0)
        return enc_scratch_write(context, points->scratch, (uint64_t)first * sizeof(float),
                                 count * sizeof(float), values);
    memcpy(points->values + first, values, count * sizeof(float));
    return BTF_OK;
}

btf_result joint_coordinates_view(const enc_context *context, joint_coordinates *points, size_t view,
                                  const float **out_values) {
    const size_t first = (view - points->first) * points->floats;
    *out_values = points->values + (points->scratch < 0 ? first : 0);
    if (points->scratch < 0)
        return BTF_OK;
    return enc_scratch_read(context, points->scratch, (uint64_t)first * sizeof(float),
                            points->floats * sizeof(float), points->values);
}
