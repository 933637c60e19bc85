/* Folding (openbtf/fold.h) for lists of which every sample has the same light, or light and view.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_SHADE_FOLD_H
#define OPENBTF_RENDER_SHADE_FOLD_H

#include "shader_class.h"
#include <openbtf/evaluate.h>
#include <openbtf/reference.h>

/* Most bytes of a fold; and layers of a sum of lights under a view that moves, as many as GL 4.5 has. A GL that has fewer
 * refuses them, and nothing is folded. */
enum { SHADE_FOLD_BYTES = 1000000000, SHADE_SUM_LAYERS = 2048 };

/* Whether a request folds where that is defined: as it says, but the evaluator on the CPU, which is not the shader of the
 * cost model, on demand alone, and nothing that is decoded stochastically. */
bool shade_fold_wanted(shader_fold fold, const char *device, btf_picks picks);

/* The options of a variant, its fold included: that of btf_fold_best, where the request wants it: where it is cheaper for
 * the samples that are to be shaded, and of at most SHADE_FOLD_BYTES. Where the request has several lights, the fold is
 * BTF_FOLD_BOTH or BTF_FOLD_SUM, of their sum, or none, on the CPU as on a GPU. The device's own settings (have_precise) are not set. Where SHADER_FOLD_ALWAYS is
 * not followed though what is fixed would allow a fold, a warning on log says why. */
btf_shader_options shade_fold_options(const shader_request *request, int variant, const btf_log *log);

/* The fold of level number `level` by the reference, BTF_FOLD_SUM by the evaluator, to be freed: as btf_ref_folded takes it; of the
 * request's lights the sum. NULL when out of memory. */
float *shade_fold_reference(const btf_ref_material *material, const btf_evaluator *evaluator,
                            uint32_t level, const btf_ref_options *options,
                            const btf_shader_options *folded, const shader_request *request);

#endif
