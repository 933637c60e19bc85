/* Folding (openbtf/fold.h) for lists of which every sample has the same light, or light and view.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_SHADE_FOLD_H
#define OPENBTF_RENDER_SHADE_FOLD_H

#include "shader_class.h"
#include <openbtf/reference.h>

/* The options of a variant, its fold included: that of btf_fold_best, where the request wants it: where it is cheaper for
 * the samples that are to be shaded, and of at most 1 GB. The device's own settings (have_precise) are not set. */
btf_shader_options shade_fold_options(const shader_request *request, int variant);

/* The fold of a level by the reference, to be freed: as btf_ref_folded takes it. NULL when out of memory. */
float *shade_fold_reference(const btf_ref_material *material, const btf_ref_options *options, btf_fold fold,
                            const float light[3], const float view[3], int threads);

#endif
