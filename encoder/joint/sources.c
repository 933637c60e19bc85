/* The model of sources and choices. See sources.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "sources.h"

#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

static btf_result out_of_memory(const joint_rows *rows, size_t k) {
    return enc_fail(rows->context, BTF_ERROR_MEMORY,
                    "joint: out of memory for %zu components of %zu points", k, rows->texels * rows->views);
}

btf_result joint_model_init(const joint_rows *rows, size_t k, joint_model *out_model) {
    const size_t points = rows->texels * rows->views;
    *out_model = (joint_model){.texels = rows->texels,
                               .views = rows->views,
                               .row = rows->row,
                               .k = k,
                               .u = calloc(rows->texels * k + 1, sizeof(float)),
                               .v = calloc(rows->views * k * rows->row + 1, sizeof(float)),
                               .match = malloc(points * sizeof(uint32_t)),
                               .gain = malloc(points),
                               .gains = {BTF_GAIN_SCALE, BTF_GAIN_ONE, BTF_GAIN_ONE}};
    if (!out_model->u || !out_model->v || !out_model->match || !out_model->gain)
        return out_of_memory(rows, k);
    memset(out_model->gain, BTF_GAIN_ONE, points);
    for (size_t i = 0; i < points; i++)
        out_model->match[i] = (uint32_t)(i % rows->texels);
    return BTF_OK;
}

void joint_model_clear(joint_model *model) {
    free(model->u);
    free(model->v);
    free(model->match);
    free(model->gain);
    free(model->centre);
    free(model->centre_error);
    free(model->point_error);
    joint_front_destroy(&model->front);
    *model = (joint_model){0};
}
