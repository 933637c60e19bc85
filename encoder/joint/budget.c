/* Bytes of layout `tight`, and what fits a budget (see budget.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "budget.h"
#include "search_set.h"

#include <openbtf/material.h>

joint_shape joint_solution_shape(const enc_solution *s) {
    return (joint_shape){.effects = s->effects,
                         .components = s->n_components,
                         .centres = s->n_centres,
                         .lobes = s->sbrdf ? s->sbrdf->lobes : 0,
                         .rgb = s->sbrdf && s->sbrdf->rgb,
                         .half = s->half_parameters};
}

uint64_t joint_bytes(const enc_data *data, const joint_shape *shape) {
    const uint64_t texels = enc_data_texel_count(data), views = (uint64_t)data->n_views;
    const uint64_t lights = (uint64_t)data->n_lights, layers = (shape->components + 3) / 4;
    uint64_t bytes = 0;
    if (shape->lobes > 0) {
        const uint64_t lobes = (uint64_t)shape->lobes;
        bytes +=
            (shape->half ? 8 : 16) * texels * (shape->rgb ? (3 + 3 * lobes + 3) / 4 + lobes : 1 + lobes);
    }
    if (shape->effects & BTF_EFFECT_SHADOW)
        bytes += texels * lights;
    if (shape->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN))
        bytes += 2 * texels * views;
    if (shape->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN))
        bytes += texels * views;
    if (shape->effects & BTF_EFFECT_HIDDEN) {
        const uint64_t blocks = (shape->centres + 4095) / 4096;
        bytes += blocks ? 4 * lights * blocks * ((shape->centres + blocks - 1) / blocks) : 0;
    }
    if (shape->effects & BTF_EFFECT_RESIDUAL)
        bytes += 4 * layers * (texels + 3 * views * lights);
    return bytes;
}

size_t joint_components_for(const enc_data *data, const joint_shape *shape, uint64_t budget, size_t limit) {
    joint_shape trial = *shape;
    if (enc_data_texel_count(data) > JOINT_EXACT && limit > JOINT_MOST_BEYOND) {
        enc_data exact = *data; /* its samples are not looked at */
        exact.width = exact.height = 64;
        const size_t there = joint_components_for(&exact, shape, joint_default_budget(&exact), limit);
        limit = there > JOINT_MOST_BEYOND ? there : JOINT_MOST_BEYOND;
    }
    for (trial.components = limit / 4 * 4; trial.components > 0; trial.components -= 4)
        if (joint_bytes(data, &trial) <= budget)
            break;
    /* the data of a few texels or images have no higher rank */
    const size_t texels = enc_data_texel_count(data);
    const size_t columns = (size_t)data->n_views * (size_t)data->n_lights * 3;
    const size_t rank = texels < columns ? texels : columns;
    return trial.components < rank ? trial.components : rank;
}

uint64_t joint_default_budget(const enc_data *data) {
    const uint64_t texels = enc_data_texel_count(data);
    const int tiles = data->n_views > data->n_lights ? data->n_views : data->n_lights;
    uint32_t width, height, room;
    const btf_material_info info = {.struct_size = sizeof info,
                                    .width = (uint32_t)data->width,
                                    .height = (uint32_t)data->height,
                                    .n_views = (uint32_t)data->n_views,
                                    .n_lights = (uint32_t)data->n_lights,
                                    .layout = BTF_LAYOUT_PAPER,
                                    .lobes = 3,
                                    .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN};
    /* materials of a few texels: enough for the least residual all the same */
    const joint_shape least = {.effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL,
                               .components = 4};
    const uint64_t needed = joint_bytes(data, &least);
    const bool has_atlas = btf_material_atlas(&info, &width, &height, &room) == BTF_OK;
    const uint64_t paper =
        64 * texels + (has_atlas ? 4 * (uint64_t)width * height : 32 * texels * (uint64_t)tiles / 5);
    return paper > needed ? paper : needed;
}
