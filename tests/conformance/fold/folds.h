/* Folds by the reference, for the tests of folds.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_FOLDS_H
#define OPENBTF_CONFORMANCE_FOLDS_H

#include "tests/conformance/synthetic.h"
#include <openbtf/reference.h>

/* A log that keeps the last message in folds_said. */
extern const btf_log folds_log;
extern char folds_said[400];

/* A small material of factors, roots, relief, gloss and three levels. */
extern const synthetic_spec folds_of_roots;

/* Layers of a fold (btf_fold, BTF_REF_FOLD_...) of one light. */
uint32_t folds_layers(const btf_ref_material *m, int fold);

/* A fold of one light, or of light and view, of a level, as btf_ref_folded takes it, to be freed; NULL when out of
 * memory. */
float *folds_reference(const btf_ref_material *m, const btf_ref_options *o, int fold, const float light[3],
                       const float view[3]);

#endif
