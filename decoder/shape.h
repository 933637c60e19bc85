/* OpenBTF: formats, names and shapes of the textures (FORMAT.md section 3).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SHAPE_H
#define OPENBTF_SHAPE_H

#include "result.h"
#include <openbtf/material.h>
#include <stdbool.h>

#pragma GCC visibility push(hidden)

/* The smallest and largest magnitude of a parameter that is not 0 (FORMAT.md section 2). */
#define BTFI_PARAMETER_MIN 0x1p-24f
#define BTFI_PARAMETER_MAX 0x1p24f

/* True when x is 0 or of a magnitude that FORMAT.md section 2 allows. */
static inline bool btfi_is_parameter(float x) {
    float magnitude = x < 0 ? -x : x;
    return x == 0 || (magnitude >= BTFI_PARAMETER_MIN && magnitude <= BTFI_PARAMETER_MAX);
}

/* Channels of a texel and bytes of a channel. */
uint32_t btfi_format_channels(btf_format format);
/* The name of a level's texture: "sbrdf", "level1.sbrdf". */
typedef struct btfi_name {
    char text[32];
} btfi_name;
btfi_name btfi_texture_name(uint32_t level, btf_texture_id id);
/* The effects whose codes layout paper keeps in its atlas. */
enum { BTFI_ATLAS_EFFECTS = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN };
/* The effects that need the texture view_vectors. */
enum { BTFI_VECTOR_EFFECTS = BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS };
/* Names of the effects in the order of FORMAT.md section 3; NULL beyond the last. */
const char *btfi_effect_name(int index);
/* Writes into `out` the classes that are left of the first `units` units of a material whose store is factors. */
void btfi_truncate_classes(const uint32_t classes[BTF_FACTOR_CLASSES][3], uint32_t units,
                           uint32_t out[BTF_FACTOR_CLASSES][3]);
/* Texels of factor_texels, at a texel of the material, of the first `units` units. */
uint32_t btfi_factor_layers(const btf_material_info *info, uint32_t units);
/* The class of a unit, and its number in the class. */
uint32_t btfi_unit_class(const btf_material_info *info, uint32_t unit, uint32_t *out_number);
/* True for a unit that is evaluated word by word, with a scale for each word. */
bool btfi_unit_is_mixed(const btf_material_info *info, uint32_t unit);
/* True for the textures that gpu_bytes leaves out. */
bool btfi_is_table(btf_texture_id id);
/* The oldest version of the format that holds such a material. */
uint32_t btfi_version(const btf_material_info *info);
/* The effects that a version has. */
static inline uint32_t btfi_version_effects(uint32_t version) {
    return version < 2 ? BTF_EFFECT_VERSION_1 : BTF_EFFECT_ALL;
}
/* True where shift and gain of a (texel, view) share two bytes: packed points, and lists of them. */
static inline bool btfi_shares_points(const btf_material_info *info) {
    return info->point_store == BTF_POINTS_PACKED || info->point_store == BTF_POINTS_LISTS;
}
/* True for a level of detail at which the relief that the material has changes nothing. */
static inline bool btfi_relief_has_ended(const btf_material_info *info, uint32_t level) {
    return info->effects & BTF_EFFECT_RELIEF && level >= info->relief_end;
}
/* Bytes of all textures of all levels but tables, as btf_material_info reports them. */
size_t btfi_gpu_bytes(const btf_material_info *info);

#pragma GCC visibility pop

#endif
