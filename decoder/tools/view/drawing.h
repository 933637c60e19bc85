/* The material on a mesh by rasterisation, in the current GL context.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_DRAWING_H
#define OPENBTF_VIEW_DRAWING_H

#include "decoder/tools/context/gl_api.h"
#include "decoder/tools/mesh/mesh.h"
#include "decoder/tools/render/original.h"
#include "state.h"
#include <openbtf/plan.h>

typedef struct drawing drawing;

/* NULL on failure, told on log. */
drawing *drawing_create(const gl_api *gl, btf_gl_get_proc_address get, void *user, const btf_log *log);
void drawing_destroy(drawing **d);

/* Plans that are kept beside the whole material. */
enum { DRAWING_SLOTS = 4 };

/* Takes another material (which must outlive the drawing or the next call), and the images it was made from
 * (may be NULL; uploaded as RGB9_E5); plans are forgotten. planned: it is uploaded when it is first drawn,
 * beside the images. On failure, told on log, there is none. Errors: those of btf_gl_upload;
 * BTF_ERROR_UNSUPPORTED when the images exceed GL's limits (the material alone is then drawn no more). */
btf_result drawing_set_material(drawing *d, const btf_material *material, const original *images,
                                bool planned, const btf_log *log);

/* Uploads a plan's restriction of the material in a slot, in place of what was there; it must outlive what
 * the slot holds. Then drawing_link_plan compiles the program for a state, and drawing_try_plan draws one
 * pixel with it, on which drivers finish their work: each a part of what would else be one long frame.
 * Errors: those of btf_gl_upload, BTF_ERROR_INTERNAL (GLSL refused). */
btf_result drawing_set_plan(drawing *d, int slot, const btf_material *material, const btf_plan *plan,
                            const btf_log *log);
btf_result drawing_link_plan(drawing *d, int slot, const view_state *s, const btf_log *log);
btf_result drawing_try_plan(drawing *d, int slot, const view_state *s, int width, int height,
                            const btf_log *log);

/* Folds a plan's fixed light into a texture where that pays in frames of so many pixels; then programs that are
 * linked read it. Nothing where the plan fixes no light. Errors: those of btf_gl_fold_create and _run. */
btf_result drawing_fold_plan(drawing *d, int slot, const view_state *s, double pixels, const btf_log *log);

/* The same for the whole material: `light`, of the tangent frame, is that of every pixel until the next call; NULL: there
 * is none. */
btf_result drawing_fold_whole(drawing *d, const float light[3], const view_state *s, double pixels, const btf_log *log);

/* The prices by which a fold pays (NULL, at first: those of llvmpipe); they must outlive the drawing. */
void drawing_set_costs(drawing *d, const btf_cost_model *costs);

/* Whether a light that rests will be folded, where that pays: GL has refused no fold, and the state's picture is not drawn
 * stochastically. */
bool drawing_folds(const drawing *d, const view_state *s);

/* Bytes of the fold that is drawn from, 0: nothing is folded. */
size_t drawing_folded(const drawing *d);

/* Draws this plan from now on. The others keep their programs; their textures go, and come back when they
 * are drawn again. */
void drawing_use_plan(drawing *d, int slot);

/* Bytes of all textures of materials that are uploaded. */
size_t drawing_bytes(const drawing *d);

/* Takes a copy of another mesh; `repeat` copies of the material a unit of uv. */
btf_result drawing_set_mesh(drawing *d, const mesh *m, double repeat, const btf_log *log);

/* Draws what the state says into the current framebuffer of width x height pixels. Programs are compiled
 * when they are first needed. Errors: BTF_ERROR_INTERNAL (GLSL refused), BTF_ERROR_MEMORY. */
btf_result drawing_draw(drawing *d, const view_state *s, int width, int height, const btf_log *log);

/* Samples of a pixel that the last picture of a stochastic state is the mean of; each drawing of the same state adds one. */
int drawing_samples(const drawing *d);

#endif
