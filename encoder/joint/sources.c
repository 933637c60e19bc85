/* Fronts, and the model of sources and choices. See sources.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "sources.h"

#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

static const float shadow_range = 2.0f; /* a source of some gain may be brighter than its SBRDF */

static btf_result no_memory(const joint_rows *rows) {
    return enc_fail(rows->context, BTF_ERROR_MEMORY, "joint: out of memory for %zu sources", rows->texels);
}

btf_result joint_front_create(const joint_rows *rows, const joint_front_kind *kind,
                              joint_front **out_front) {
    const size_t texels = rows->texels, lights = rows->row / 3;
    joint_front *front = calloc(1, sizeof *front);
    *out_front = front;
    if (!front)
        return no_memory(rows);
    *front = (joint_front){.kind = *kind,
                           .shadow_scale = shadow_range / JOINT_SHADOW_MAX,
                           .shadow = kind->shadow ? malloc(texels * lights) : NULL,
                           .light = {malloc(3 * lights * sizeof(float))}};
    if (enc_sbrdf_create(texels, kind->lobes, kind->rgb, &front->sbrdf) != BTF_OK || !front->light[0] ||
        (kind->shadow && !front->shadow)) {
        joint_front_destroy(out_front);
        return no_memory(rows);
    }
    front->light[1] = front->light[0] + lights;
    front->light[2] = front->light[1] + lights;
    for (size_t l = 0; l < lights; l++)
        for (int axis = 0; axis < 3; axis++)
            front->light[axis][l] = rows->data->lights[l].xyz[axis];
    if (front->shadow)
        memset(front->shadow, 128, texels * lights); /* 1, to a code */
    return BTF_OK;
}

btf_result joint_front_copy(const joint_rows *rows, const joint_front *from, joint_front **out_front) {
    const btf_result result = joint_front_create(rows, &from->kind, out_front);
    if (result != BTF_OK)
        return result;
    memcpy((*out_front)->sbrdf->values, from->sbrdf->values,
           rows->texels * enc_sbrdf_stride(from->kind.lobes, from->kind.rgb) * sizeof(float));
    if (from->shadow)
        memcpy((*out_front)->shadow, from->shadow, rows->texels * (rows->row / 3));
    return BTF_OK;
}

void joint_front_destroy(joint_front **front) {
    if (*front) {
        enc_sbrdf_destroy(&(*front)->sbrdf);
        free((*front)->shadow);
        free((*front)->light[0]);
        free(*front);
        *front = NULL;
    }
}

void joint_front_row_lit(const joint_rows *rows, const joint_front *front, size_t source, size_t view,
                         float *out) {
    enc_sbrdf_evaluate(front->sbrdf, source, rows->data->views[view].xyz, (int)(rows->row / 3),
                       front->light[0], front->light[1], front->light[2], out);
    for (size_t p = 0; p < rows->row; p++)
        out[p] *= rows->multiplier[p];
}

void joint_front_row(const joint_rows *rows, const joint_front *front, size_t source, size_t view,
                     float *out) {
    const size_t lights = rows->row / 3;
    joint_front_row_lit(rows, front, source, view, out);
    if (!front->shadow)
        return;
    const uint8_t *code = front->shadow + source * lights;
    for (size_t channel = 0; channel < 3; channel++)
        for (size_t l = 0; l < lights; l++)
            out[channel * lights + l] *= (float)code[l] * front->shadow_scale;
}

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
