/* Folds by the reference. See folds.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "folds.h"

#include <stdio.h>
#include <stdlib.h>

char folds_said[400];
static void hear(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    snprintf(folds_said, sizeof folds_said, "%s", message);
}
const btf_log folds_log = {hear, NULL};

const synthetic_spec folds_of_roots = {
    FOLDS_ROOTS,
    .seed = 31,
    .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS,
    .components = 2,
    .classes = {{0}, {0}, {2, 1, 0}},
    .relief = SYNTHETIC_GENTLE,
    .gloss_share = 1,
};

uint32_t folds_layers(const btf_ref_material *m, int fold) {
    return fold == BTF_REF_FOLD_LIGHT ? m->n_views : fold == BTF_REF_FOLD_NEIGHBOURS ? 3 : 1;
}

float *folds_reference(const btf_ref_material *m, const btf_ref_options *o, int fold, const float light[3],
                       const float view[3]) {
    const size_t layer = (size_t)4 * m->width * m->height;
    const uint32_t layers = folds_layers(m, fold);
    float *values = malloc(layer * layers * sizeof *values);
    if (!values) {
        return NULL;
    }
    if (fold == BTF_REF_FOLD_BOTH) {
        const uint32_t half = m->height / 2; /* in two calls, as threads would do */
        btf_ref_fold_both(m, o, light, view, half, m->height - half, values + (size_t)4 * m->width * half);
        btf_ref_fold_both(m, o, light, view, 0, half, values);
        return values;
    }
    for (uint32_t i = 0; i < layers; ++i) {
        if (fold == BTF_REF_FOLD_LIGHT) {
            btf_ref_fold_light(m, o, light, i, 0, m->height, values + i * layer);
        } else {
            btf_ref_fold_neighbour(m, o, light, view, i, 0, m->height, values + i * layer);
        }
    }
    return values;
}
