/* A material of the library as the reference decoder takes it.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reference_view.h"

int reference_view(const btf_material *material, uint32_t level, btf_ref_material *out) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    *out = (btf_ref_material){
        .width = btf_level_size(info.width, level),
        .height = btf_level_size(info.height, level),
        .n_views = info.n_views,
        .n_lights = info.n_lights,
        .layout_tight = info.layout == BTF_LAYOUT_TIGHT,
        .domain_sqrt = info.domain == BTF_DOMAIN_SQRT,
        .colour = info.colour == BTF_COLOUR_MONO  ? BTF_REF_MONO
                  : info.colour == BTF_COLOUR_RGB ? BTF_REF_RGB
                                                  : BTF_REF_NONE,
        .half_float = info.half_float,
        .lobes = info.lobes,
        .effects = info.effects,
        .centres = info.centres,
        .components = info.components,
        .atlas_width = info.atlas_width,
        .atlas_height = info.atlas_height,
        .radiance_scale = info.radiance_scale,
        .shadow_scale = info.shadow_scale,
        .gain_scale = info.gain_scale,
        .centre_scale = info.centre_scale,
        .sbrdf = btf_material_level_texture(material, level, BTF_TEXTURE_SBRDF).data,
        .maps = btf_material_texture(material, BTF_TEXTURE_MAPS).data,
        .shadow = btf_material_level_texture(material, level, BTF_TEXTURE_SHADOW).data,
        .shift = btf_material_level_texture(material, level, BTF_TEXTURE_SHIFT).data,
        .gain = btf_material_level_texture(material, level, BTF_TEXTURE_GAIN).data,
        .centre = btf_material_texture(material, BTF_TEXTURE_CENTRES).data,
        .residual_texels = btf_material_level_texture(material, level, BTF_TEXTURE_RESIDUAL_TEXELS).data,
        .residual_directions = btf_material_texture(material, BTF_TEXTURE_RESIDUAL_DIRECTIONS).data,
        .residual_scales = btf_material_texture(material, BTF_TEXTURE_RESIDUAL_SCALES).data,
        .view_table = btf_material_texture(material, BTF_TEXTURE_VIEW_TABLE).data,
        .light_table = btf_material_texture(material, BTF_TEXTURE_LIGHT_TABLE).data,
        .view_grid = btf_material_views(material).grid,
        .light_grid = btf_material_lights(material).grid,
        .store = info.store == BTF_STORE_FACTORS ? BTF_REF_FACTORS : BTF_REF_COMPONENTS,
        .blend = info.blend == BTF_BLEND_ROOTS ? BTF_REF_BLEND_ROOTS : BTF_REF_BLEND_RADIANCE,
        .horizon_scale = info.horizon_scale,
        .factor_texels = btf_material_level_texture(material, level, BTF_TEXTURE_FACTOR_TEXELS).data,
        .factor_directions = btf_material_texture(material, BTF_TEXTURE_FACTOR_DIRECTIONS).data,
        .factor_scales = btf_material_texture(material, BTF_TEXTURE_FACTOR_SCALES).data,
        .factor_views = btf_material_texture(material, BTF_TEXTURE_FACTOR_VIEWS).data,
        .points_packed = info.point_store != BTF_POINTS_SEPARATE,
        .gain_base = info.gain_base,
        .gain_step = info.gain_step,
        .points = btf_material_level_texture(material, level, BTF_TEXTURE_POINTS).data,
        .point_lists = btf_material_level_texture(material, level, BTF_TEXTURE_POINT_LISTS).data,
        .point_indices = btf_material_level_texture(material, level, BTF_TEXTURE_POINT_INDICES).data,
        .heights = btf_material_level_texture(material, level, BTF_TEXTURE_HEIGHTS).data,
        .view_vectors = btf_material_texture(material, BTF_TEXTURE_VIEW_VECTORS).data,
        .relief_base = info.relief_base,
        .relief_step = info.relief_step,
        .relief_steps = info.relief_steps,
        .gloss_share = info.gloss_share,
        .level = level + info.relief_level,
        .relief_end = info.relief_end + info.relief_level,
    };
    for (int i = 0; i < BTF_FACTOR_CLASSES; ++i) {
        for (int j = 0; j < 3; ++j) {
            out->factor_classes[i][j] = info.factor_classes[i][j];
        }
    }
    return 0;
}
