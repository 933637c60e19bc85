/* Draws the material on a mesh by rasterisation, in the current GL context.
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

/* Returns NULL on failure, with the reason on log. */
drawing *drawing_create(const gl_api *gl, btf_gl_get_proc_address get, void *user, const btf_log *log);
void drawing_destroy(drawing **d);

/* The number of plans that are kept beside the whole material. */
enum { DRAWING_SLOTS = 4 };

/* Takes another material (which must outlive the drawing or the next call), and the images that it was made from
 * (may be NULL; uploaded as RGB9_E5); forgets all plans. planned: the material is uploaded only once it is drawn
 * beside the images. After a failure, with the reason on log, the drawing has no material. Errors: those of
 * btf_gl_upload; BTF_ERROR_UNSUPPORTED when the images exceed GL's limits. */
btf_result drawing_set_material(drawing *d, const btf_material *material, const original *images,
                                bool planned, const btf_log *log);

/* Uploads a plan's restriction of the material into a slot, in place of the plan that was there; `material` must
 * stay until the slot takes another. Then drawing_link_plan compiles the program for a state, and drawing_try_plan
 * draws one pixel with it, since drivers finish their work at the first draw: three steps, so that no frame takes
 * long. Errors: those of btf_gl_upload, BTF_ERROR_INTERNAL (GLSL refused). */
btf_result drawing_set_plan(drawing *d, int slot, const btf_material *material, const btf_plan *plan,
                            const btf_log *log);
btf_result drawing_link_plan(drawing *d, int slot, const view_state *s, const btf_log *log);
btf_result drawing_try_plan(drawing *d, int slot, const view_state *s, int width, int height,
                            const btf_log *log);

/* Folds a plan's fixed light into a texture where that pays in frames of so many pixels; programs that are linked
 * afterwards read the texture. Does nothing where the plan fixes no light. Errors: those of btf_gl_fold_create and
 * _run. */
btf_result drawing_fold_plan(drawing *d, int slot, const view_state *s, double pixels, const btf_log *log);

/* Folds a light into a texture for the whole material: `light`, of the tangent frame, is that of every pixel until
 * the next call; NULL ends that. */
btf_result drawing_fold_whole(drawing *d, const float light[3], const view_state *s, double pixels, const btf_log *log);

/* Sets the prices by which is decided whether a fold pays (NULL, as at first: those of llvmpipe); they must outlive
 * the drawing. */
void drawing_set_costs(drawing *d, const btf_cost_model *costs);

/* Whether a light that rests is folded where that pays: not after GL refused a fold, nor where the state's picture
 * is drawn stochastically. */
bool drawing_folds(const drawing *d, const view_state *s);

/* Bytes of the folded texture that the picture is drawn from; 0: nothing is folded. */
size_t drawing_folded(const drawing *d);

/* Draws by this plan from now on. The other plans keep their programs, but their textures are deleted, and uploaded
 * again when they are next drawn. */
void drawing_use_plan(drawing *d, int slot);

/* Bytes of all textures of materials that are uploaded. */
size_t drawing_bytes(const drawing *d);

/* Takes a copy of another mesh, to be covered with `repeat` copies of the material a unit of uv. */
btf_result drawing_set_mesh(drawing *d, const mesh *m, double repeat, const btf_log *log);

/* Draws what the state says into the current framebuffer of width x height pixels. Programs are compiled
 * when they are first needed. Errors: BTF_ERROR_INTERNAL (GLSL refused), BTF_ERROR_MEMORY. */
btf_result drawing_draw(drawing *d, const view_state *s, int width, int height, const btf_log *log);

/* The number of samples of a pixel whose mean the last picture of a stochastic state is; each drawing of the same
 * state adds one. */
int drawing_samples(const drawing *d);

#endif
