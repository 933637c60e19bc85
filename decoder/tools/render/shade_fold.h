/* Folding (openbtf/fold.h) for lists of which every sample has the same light, or light and view.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_SHADE_FOLD_H
#define OPENBTF_RENDER_SHADE_FOLD_H

#include "shader_class.h"
#include <openbtf/evaluate.h>
#include <openbtf/reference.h>

/* The most bytes of a fold, and the most layers of a sum of lights under a view that moves: as many as GL 4.5 has. A
 * GL that has fewer refuses the fold, and nothing is folded. */
enum { SHADE_FOLD_BYTES = 1000000000, SHADE_SUM_LAYERS = 2048 };

/* Whether a request for `fold` wants a fold where one is defined. SHADER_FOLD_AUTO wants none on the CPU, whose
 * evaluator is not the shader of the cost model, and nothing that is decoded stochastically is folded. */
bool shade_fold_wanted(shader_fold fold, const char *device, btf_picks picks);

/* The options of a variant with its fold. Where the request wants one, that is the fold of btf_fold_best, if it takes
 * at most SHADE_FOLD_BYTES and, unless the request says SHADER_FOLD_ALWAYS, is cheaper for the samples that are to be
 * shaded. Where the request has several lights, it is BTF_FOLD_BOTH or BTF_FOLD_SUM, of their sum, or none, on the CPU
 * as on a GPU. The device's own settings (have_precise) are not set. A warning on log says why SHADER_FOLD_ALWAYS is
 * not followed, though what is fixed would allow a fold. */
btf_shader_options shade_fold_options(const shader_request *request, int variant, const btf_log *log);

/* The fold of level number `level`, to be freed, as btf_ref_folded takes it: BTF_FOLD_SUM is made by the evaluator,
 * any other fold by the reference. Of several lights in the request it is that of the sum. NULL when out of memory. */
float *shade_fold_reference(const btf_ref_material *material, const btf_evaluator *evaluator,
                            uint32_t level, const btf_ref_options *options,
                            const btf_shader_options *folded, const shader_request *request);

#endif
