/* OpenBTF: the atlas of layout `paper` taken apart into the textures of layout `tight` (FORMAT.md section
 * 5).
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/plan.h>

btf_result btf_material_to_tight(const btf_material *material, const btf_log *log,
                                 btf_material **out_material) {
    btf_material_info info = {.struct_size = sizeof info};
    *out_material = NULL;
    const btf_result result = btf_material_get_info(material, &info);
    if (result != BTF_OK)
        return result;
    const btf_plan everything = {.struct_size = sizeof everything,
                                 .scene = {.struct_size = sizeof everything.scene},
                                 .effects = info.effects,
                                 .components = info.components};
    return btf_material_restrict(material, &everything, log, out_material);
}
