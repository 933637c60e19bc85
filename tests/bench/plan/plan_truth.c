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

/* A texel of an image, box-filtered to a level of width x height texels. */
static void filtered_texel(const bench_truth *truth, size_t image, uint32_t width, uint32_t height,
                           size_t texel, double out[3]) {
    const size_t across = (size_t)truth->width / width, down = (size_t)truth->height / height;
    const size_t first = texel / width * down * (size_t)truth->width + texel % width * across;
    const float *rgb = truth->images + 3 * image * (size_t)truth->width * (size_t)truth->height;
    out[0] = out[1] = out[2] = 0;
    for (size_t i = 0; i < across * down; i++) {
        for (size_t c = 0; c < 3; c++) {
            out[c] += (double)rgb[3 * (first + i / across * (size_t)truth->width + i % across) + c];
        }
    }
    for (int c = 0; c < 3; c++) {
        out[c] /= (double)(across * down);
    }
}

/* Images whose view and light the scene has. */
static size_t count_images(const bench_truth *truth, const btf_scene *scene) {
    size_t images = 0;
    for (size_t i = 0; i < truth->count; i++) {
        images += has(&scene->view, &truth->pair[i].view) && has(&scene->light, &truth->pair[i].light);
    }
    return images;
}

size_t plan_truth(const bench_truth *truth, const btf_material *whole, const btf_material *small,
                  const btf_plan *plan, double planned[2], double full[2]) {
    enum { ENOUGH = 50000 }; /* values of all images together */
    const btf_ref_options everything = {BTF_EFFECT_ALL, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL},
                          chosen = plan_reference_options(plan);
    btf_ref_material a, b;
    size_t values = 0;
    reference_view(whole, plan->level, &a);
    reference_view(small, 0, &b);
    const bool even = truth->count > 0 && (uint32_t)truth->width % a.width == 0 &&
                      (uint32_t)truth->height % a.height == 0;
    const size_t images = even ? count_images(truth, &plan->scene) : 0;
    const size_t texels = (size_t)a.width * a.height, all = images * texels,
                 step = all > 2 * ENOUGH ? all / ENOUGH : 1;
    planned[0] = planned[1] = full[0] = full[1] = 0;
    for (size_t i = 0; i < truth->count && images > 0; i++) {
        const enc_pair *pair = &truth->pair[i];
        if (!has(&plan->scene.view, &pair->view) || !has(&plan->scene.light, &pair->light)) {
            continue;
        }
        for (size_t t = i % step; t < texels; t += step, values++) {
            double exact[3];
            filtered_texel(truth, i, a.width, a.height, t, exact);
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
