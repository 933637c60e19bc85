/* Plans against truth. See plan_truth.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "plan_truth.h"

#include "plan_scenes.h"

#include "decoder/toolkit/reference_view.h"

#include <openbtf/reference.h>

static bool has(const btf_range *range, const enc_direction *direction) {
    const bool all = range->theta[0] == 0 && range->theta[1] == 0;
    return !range->fixed && (all || (direction->theta >= (double)range->theta[0] &&
                                     direction->theta <= (double)range->theta[1]));
}

size_t plan_truth(const bench_truth *truth, const btf_material *whole, const btf_material *small,
                  const btf_plan *plan, double planned[2], double full[2]) {
    enum { STEP = 16, ODD = 5 }; /* a texel of every image is another's neighbour */
    const btf_ref_options everything = {BTF_EFFECT_ALL, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL},
                          chosen = plan_reference_options(plan);
    const size_t texels = (size_t)truth->width * (size_t)truth->height;
    btf_ref_material a, b;
    size_t images = 0, values = 0;
    reference_view(whole, 0, &a);
    reference_view(small, 0, &b);
    planned[0] = planned[1] = full[0] = full[1] = 0;
    for (size_t i = 0; i < truth->count && plan->level == 0; i++) {
        const enc_pair *pair = &truth->pair[i];
        if (!has(&plan->scene.view, &pair->view) || !has(&plan->scene.light, &pair->light)) {
            continue;
        }
        images++;
        for (size_t t = i * ODD % STEP; t < texels; t += STEP, values++) {
            const float *rgb = truth->images + 3 * (i * texels + t);
            const double exact[3] = {rgb[0], rgb[1], rgb[2]};
            const uint32_t column = (uint32_t)t % a.width, row = (uint32_t)t / a.width;
            float decoded[3];
            btf_ref_evaluate_texel(&a, &everything, column, row, pair->light.xyz, pair->view.xyz, decoded);
            plan_add_errors(exact, decoded, full);
            btf_ref_evaluate_texel(&b, &chosen, column, row, pair->light.xyz, pair->view.xyz, decoded);
            plan_add_errors(exact, decoded, planned);
        }
    }
    for (int k = 0; k < 2 && values > 0; k++) {
        planned[k] /= (double)values;
        full[k] /= (double)values;
    }
    return images;
}
