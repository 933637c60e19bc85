/* Bytes and budgets (see joint_budget.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "joint_budget.h"

#include <openbtf/material.h>

uint64_t joint_bytes(const enc_data *data, const joint_shape *shape) {
    const uint64_t texels = enc_data_texel_count(data), views = (uint64_t)data->n_views;
    const uint64_t lights = (uint64_t)data->n_lights, layers = (shape->components + 3) / 4;
    uint64_t bytes = 0;
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
    for (trial.components = limit / 4 * 4; trial.components > 0; trial.components -= 4)
        if (joint_bytes(data, &trial) <= budget)
            break;
    return trial.components;
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
    if (btf_material_atlas(&info, &width, &height, &room) == BTF_OK)
        return 64 * texels + 4 * (uint64_t)width * height;
    return 64 * texels + 32 * texels * (uint64_t)tiles / 5;
}
