/* Lights that are the same in every sample. See still_lights.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "still_lights.h"

#include <stdlib.h>
#include <string.h>

static bool may_be_still(const render_scene *scene) {
    const light_list *lights = scene->lights;
    if (lights->count < 2 || scene->environment || scene->table.cast_shadows ||
        !mesh_is_flat(scene->table.mesh)) {
        return false;
    }
    for (size_t i = 0; i < lights->count; i++) {
        if (lights->lights[i].is_point) {
            return false;
        }
    }
    return true;
}

static bool same_frame(const table_sample *a, const table_sample *b) {
    return memcmp(a->tangent, b->tangent, sizeof a->tangent) == 0 &&
           memcmp(a->bitangent, b->bitangent, sizeof a->bitangent) == 0 &&
           memcmp(a->normal, b->normal, sizeof a->normal) == 0;
}

/* Finds whether all samples have one tangent frame, in which a light far away has one direction, and whether they have
 * one view; *first is one of the samples. */
static btf_result find_frame(const render_scene *scene, table_sample *first, bool *out_same,
                             bool *out_same_view) {
    table_scene table = scene->table;
    table.width = scene->width * scene->samples;
    table.height = scene->height * scene->samples;
    table_sample *row = calloc((size_t)table.width, sizeof *row);
    bool any = false;
    *out_same = *out_same_view = true;
    for (int y = 0; row && *out_same && y < table.height; y++) {
        table_cast(&table, y, 1, row);
        for (int x = 0; x < table.width && *out_same; x++) {
            if (!(row[x].view[2] > 0)) {
                continue;
            }
            if (!any) {
                *first = row[x];
                any = true;
            }
            *out_same = same_frame(first, &row[x]);
            *out_same_view = *out_same_view && memcmp(first->view, row[x].view, sizeof first->view) == 0;
        }
    }
    *out_same = *out_same && any;
    free(row);
    return row ? BTF_OK : BTF_ERROR_MEMORY;
}

btf_result still_lights_find(const render_scene *scene, still_lights *out) {
    table_sample frame = {0};
    bool same = false, same_view = false;
    *out = (still_lights){0};
    if (!may_be_still(scene)) {
        return BTF_OK;
    }
    btf_result result = find_frame(scene, &frame, &same, &same_view);
    if (result || !same) {
        return result;
    }
    const light_list *lights = scene->lights;
    out->directions = malloc(3 * lights->count * sizeof *out->directions);
    out->weights = malloc(3 * lights->count * sizeof *out->weights);
    if (!out->directions || !out->weights) {
        still_lights_clear(out);
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < lights->count; i++) {
        const light *l = &lights->lights[i];
        const vec3 local = table_to_local(&frame, l->at);
        if (!((float)local.z > 0)) { /* decodes to black */
            continue;
        }
        if (out->count == 0) {
            out->together = (light){.at = l->at, .colour = {1, 1, 1}};
        }
        vec_store(local, out->directions + 3 * out->count);
        for (size_t c = 0; c < 3; c++) {
            out->weights[3 * out->count + c] = (float)l->colour[c];
        }
        out->count++;
    }
    out->same_view = same_view;
    memcpy(out->view, frame.view, sizeof out->view);
    if (out->count < 2) {
        still_lights_clear(out);
    }
    return BTF_OK;
}

void still_lights_clear(still_lights *lights) {
    free(lights->directions);
    free(lights->weights);
    *lights = (still_lights){0};
}
