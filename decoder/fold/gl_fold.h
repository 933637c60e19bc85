/* OpenBTF: a fold in a GL context, and how its layers are drawn.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_GL_FOLD_H
#define OPENBTF_GL_FOLD_H

#include "gl_draw.h"
#include <openbtf/fold.h>

#pragma GCC visibility push(hidden)

/* A program that folds (name 0: none), and the locations of its uniforms, of which `view` is a layer and `viewer` the
 * direction to the viewer. */
typedef struct btfi_fold_program {
    uint32_t name;
    int32_t light, view, viewer, level, weight, sum, from, values, other, partners;
} btfi_fold_program;

struct btf_gl_fold {
    btfi_gl_functions api;
    btf_fold kind;
    uint32_t width, height, levels, views, lights; /* views: layers of a light */
    uint32_t sampled;                              /* views of the material */
    uint32_t texture;
    btfi_fold_program one, sum; /* of one light; of several, made when it is asked for */
    char *library;              /* the text that it is made from; NULL where only one light can be folded */
    uint32_t *partners;         /* [sampled], of a sum of products (partners.h); else NULL */
    size_t bytes;
};

/* The objects that drawing binds, and the caller's state to put back afterwards. */
typedef struct btfi_fold_stage {
    btfi_gl_state saved;
    uint32_t framebuffer, array;
} btfi_fold_stage;

/* A texture of the fold's size, of so many layers. On error, too, *out_texture is a name to delete, or 0. */
btf_result btfi_fold_texture(const btf_gl_fold *fold, uint32_t layers, uint32_t *out_texture,
                             const btf_log *log);

/* A program of the library's text and a main function. */
btf_result btfi_fold_program_make(const btfi_gl_functions *api, const char *library, const char *body,
                                  const btf_log *log, btfi_fold_program *out);

/* The first makes ready to draw, and the program current; the second puts the caller's state back, and says what GL
 * found wrong. */
void btfi_fold_begin(const btf_gl_fold *fold, const btfi_fold_program *program, const float view[3],
                     btfi_fold_stage *stage);
btf_result btfi_fold_end(const btf_gl_fold *fold, btfi_fold_stage *stage, btf_result result,
                         const btf_log *log);

/* Draws a level of a layer of a texture with the program that is current; light: where it has one. */
btf_result btfi_fold_draw(const btf_gl_fold *fold, const btfi_fold_program *program, const float *light,
                          uint32_t texture, uint32_t layer, uint32_t level, const btf_log *log);

/* Checks the arguments that all calls of a fold have. */
btf_result btfi_fold_check_call(const btf_gl_fold *fold, uint32_t number, const float *light,
                                const float *view, const btf_log *log);

#pragma GCC visibility pop

#endif
