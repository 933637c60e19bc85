/* The material on a mesh by rasterisation, in the current GL context.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_DRAWING_H
#define OPENBTF_VIEW_DRAWING_H

#include "../render/gl_api.h"
#include "../render/mesh.h"
#include "../render/original.h"
#include "state.h"

typedef struct drawing drawing;

/* NULL on failure, told on log. */
drawing *drawing_create(const gl_api *gl, btf_gl_get_proc_address get, void *user, const btf_log *log);
void drawing_destroy(drawing **d);

/* Takes another material (which must outlive the drawing or the next call), and the images it was made from
 * (may be NULL; uploaded as RGB9_E5). On failure, told on log, there is none. Errors: those of
 * btf_gl_upload; BTF_ERROR_UNSUPPORTED when the images exceed GL's limits (the material alone is then drawn
 * no more). */
btf_result drawing_set_material(drawing *d, const btf_material *material, const original *images,
                                const btf_log *log);

/* Takes a copy of another mesh; `repeat` copies of the material a unit of uv. */
btf_result drawing_set_mesh(drawing *d, const mesh *m, double repeat, const btf_log *log);

/* Draws what the state says into the current framebuffer of width x height pixels. Programs are compiled
 * when they are first needed. Errors: BTF_ERROR_INTERNAL (GLSL refused), BTF_ERROR_MEMORY. */
btf_result drawing_draw(drawing *d, const view_state *s, int width, int height, const btf_log *log);

#endif
