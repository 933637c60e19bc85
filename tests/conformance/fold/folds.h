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

/* Members of synthetic_spec that small materials of factors, blended roots and three levels have in common. */
#define FOLDS_ROOTS                                                                                        \
    .width = 13, .height = 7, .n_views = 9, .n_lights = 11, .layout = BTF_LAYOUT_TIGHT,                    \
    .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE, .directions = SYNTHETIC_RANDOM, .levels = 3,     \
    .blend = BTF_BLEND_ROOTS, .horizon_scale = 4

/* One of them, of two units, with relief and gloss. */
extern const synthetic_spec folds_of_roots;

/* Layers of a fold (btf_fold, BTF_REF_FOLD_...) of one light. */
uint32_t folds_layers(const btf_ref_material *m, int fold);

/* A fold of one light, or of light and view, of a level, as btf_ref_folded takes it, to be freed; NULL when out of
 * memory. */
float *folds_reference(const btf_ref_material *m, const btf_ref_options *o, int fold, const float light[3],
                       const float view[3]);

#endif
