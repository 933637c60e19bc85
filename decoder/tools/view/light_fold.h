/* The fold (openbtf/fold.h) of a light that is the same in every pixel of the model and does not move.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_LIGHT_FOLD_H
#define OPENBTF_VIEW_LIGHT_FOLD_H

#include <openbtf/fold.h>
#include <stdbool.h>

/* All zeros: nothing is folded. */
typedef struct light_fold {
    btf_gl_fold *gl;
    btf_shader_options made; /* the options that the fold was made for */
} light_fold;

/* The most bytes of a fold, and the number of frames within which it must pay. */
enum { LIGHT_FOLD_BYTES = 512000000, LIGHT_FOLD_FRAMES = 10 };

/* Whether a shader of these options, which fix a light, should read a fold where frames have so many pixels: where
 * the fold is defined, takes at most LIGHT_FOLD_BYTES, and pays within LIGHT_FOLD_FRAMES by the prices `costs`
 * (NULL: those of llvmpipe). */
bool light_fold_wanted(const btf_material *material, const btf_shader_options *options, double pixels,
                       const btf_cost_model *costs);

/* Makes the fold for these options from the material's textures, unless it is there. Errors: those of
 * btf_gl_fold_create and _run; there is none then. */
btf_result light_fold_make(light_fold *fold, const btf_material *material, btf_gl *textures,
                           const btf_gl_options *gl, const btf_shader_options *options, uint32_t first_unit,
                           const btf_log *log);
void light_fold_clear(light_fold *fold);

#endif
