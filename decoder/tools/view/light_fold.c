/* The fold of a light that rests. See light_fold.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "light_fold.h"

#include <string.h>

static btf_shader_options folding(const btf_shader_options *options) {
    btf_shader_options folded = *options;
    folded.fold = BTF_FOLD_LIGHT;
    return folded;
}

bool light_fold_wanted(const btf_material *material, const btf_shader_options *options, double pixels,
                       const btf_cost_model *costs) {
    const btf_scene scene = {.struct_size = sizeof scene, .costs = costs};
    const btf_shader_options folded = folding(options);
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    return options->fixed & BTF_FIXED_LIGHT && btf_fold_check(&info, &folded, NULL) == BTF_OK &&
           btf_fold_bytes(&info, BTF_FOLD_LIGHT, 1) <= LIGHT_FOLD_BYTES &&
           btf_fold_layers(&info, BTF_FOLD_LIGHT, 1) <= BTF_MAX_DIRECTION_LAYERS && /* that every GL has */
           btf_fold_cost(material, &folded, &scene).pixels <= LIGHT_FOLD_FRAMES * pixels;
}

/* Whether folds for both options hold the same values. Relief and filter do not count: they act on what a fold
 * holds. */
static bool keep_the_same(const btf_shader_options *a, const btf_shader_options *b) {
    const uint32_t kept = BTF_EFFECT_ALL & ~(uint32_t)BTF_EFFECT_RELIEF;
    return (a->leave_out & kept) == (b->leave_out & kept) && a->components == b->components &&
           a->interpolation == b->interpolation && a->math == b->math &&
           memcmp(a->fixed_light, b->fixed_light, sizeof a->fixed_light) == 0;
}

btf_result light_fold_make(light_fold *fold, const btf_material *material, btf_gl *textures,
                           const btf_gl_options *gl, const btf_shader_options *options, uint32_t first_unit,
                           const btf_log *log) {
    if (fold->gl && keep_the_same(&fold->made, options)) {
        return BTF_OK;
    }
    light_fold_clear(fold);
    const btf_shader_options folded = folding(options);
    btf_gl_options of_fold = *gl;
    of_fold.shader = &folded;
    btf_result result = btf_gl_fold_create(material, &of_fold, 1, log, &fold->gl);
    if (!result) {
        result = btf_gl_fold_run(fold->gl, textures, first_unit, 0, options->fixed_light, NULL, log);
    }
    fold->made = *options;
    if (result) {
        light_fold_clear(fold);
    }
    return result;
}

void light_fold_clear(light_fold *fold) {
    btf_gl_fold_destroy(&fold->gl);
    *fold = (light_fold){0};
}
