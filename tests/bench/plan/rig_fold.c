/* Folded shaders to measure. See rig_fold.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "rig_fold.h"

enum { UNIT_FOLDED = 31 };

rig_variant rig_folded_create(decode_rig *rig, const btf_material *material,
                              const btf_shader_options *options, btf_gl_fold **out_fold) {
    btf_gl_options all = gpu_gl_options(rig->gpu, NULL);
    btf_gl *textures = NULL;
    btf_result result = btf_gl_upload(material, &all, rig->log, &textures);
    all.shader = options;
    if (result == BTF_OK) {
        result = btf_gl_fold_create(material, &all, 1, rig->log, out_fold);
    }
    if (result == BTF_OK) {
        result = btf_gl_fold_run(*out_fold, textures, RIG_FOLD_UNITS, 0, options->fixed_light,
                                 options->fixed_view, rig->log);
    }
    btf_gl_destroy(&textures);
    if (result != BTF_OK) {
        return (rig_variant){0};
    }
    const rig_variant made = rig_variant_create(rig, material, options, gpu_evaluate_body, RIG_FOLD_UNITS);
    if (made.program) {
        btf_gl_fold_bind(*out_fold, made.program, UNIT_FOLDED, NULL);
    }
    return made;
}
