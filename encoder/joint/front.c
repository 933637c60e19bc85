/* SBRDF times shadow. See front.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "front.h"

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
