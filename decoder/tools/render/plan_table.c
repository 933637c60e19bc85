/* The scene that a picture is. See plan_table.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "plan_table.h"

#include <math.h>
#include <stdlib.h>

static void widen(float z, float bounds[2], bool first) {
    bounds[0] = first || z < bounds[0] ? z : bounds[0];
    bounds[1] = first || z > bounds[1] ? z : bounds[1];
}

/* One row of samples under one light. Lights below a sample's horizon decode to black by any material. */
static void add_row(int width, const float *inputs, const table_sample *samples, bool *lit,
                    plan_range *range) {
    for (int x = 0; x < width; x++) {
        const float view = samples[x].view[2], light = inputs[TABLE_INPUTS * x + 7];
        if (!(view > 0))
            continue;
        widen(view, range->view_z, !range->any);
        range->level = !range->any || samples[x].level < range->level ? samples[x].level : range->level;
        range->any = true;
        if (light > 0) {
            widen(light, range->light_z, !*lit);
            *lit = true;
        }
    }
}

btf_result plan_range_add(const render_scene *scene, plan_range *range) {
    table_scene table = scene->table;
    table.width = scene->width * scene->samples;
    table.height = scene->height * scene->samples;
    const size_t width = (size_t)table.width;
    table_sample *samples = calloc(width, sizeof *samples);
    float *inputs = calloc(width, TABLE_INPUTS * sizeof *inputs),
          *weights = calloc(width, 3 * sizeof *weights);
    const bool ok = samples && inputs && weights;
    bool lit = range->light_z[1] > 0;
    for (int row = 0; ok && row < table.height; row++) {
        table_cast(&table, row, 1, samples);
        for (size_t l = 0; l < scene->lights->count; l++) {
            table_light(&table, &scene->lights->lights[l], width, samples, inputs, weights);
            add_row(table.width, inputs, samples, &lit, range);
        }
    }
    free(weights);
    free(inputs);
    free(samples);
    return ok ? BTF_OK : BTF_ERROR_MEMORY;
}

/* Elevations of cosines. */
static btf_range elevations(const float z[2]) {
    const double degree = 3.14159265358979323846 / 180, margin = 0.01;
    const double low = acos(fmin((double)z[1], 1)) / degree - margin,
                 high = acos((double)z[0]) / degree + margin;
    return (btf_range){.theta = {(float)fmax(low, 0), (float)fmin(high, 90)}};
}

btf_scene plan_range_scene(const plan_range *range) {
    btf_scene scene = {.struct_size = sizeof scene, .pixels = ldexpf(1, -range->level)};
    if (range->any)
        scene.view = elevations(range->view_z);
    if (range->light_z[1] > 0)
        scene.light = elevations(range->light_z);
    return scene;
}
