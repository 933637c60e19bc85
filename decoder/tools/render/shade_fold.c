/* Folding for lists. See shade_fold.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "shade_fold.h"

#include <openbtf/fold.h>
#include <stdlib.h>
#include <string.h>

static const size_t most_bytes = 1000000000;

static bool is_worth_it(const shader_request *request, const btf_shader_options *options) {
    btf_material_info info = {.struct_size = sizeof info};
    const btf_scene scene = {.struct_size = sizeof scene, .costs = request->costs};
    btf_material_get_info(request->material, &info);
    if (btf_fold_bytes(&info, options->fold, 1) > most_bytes) {
        return false;
    }
    return request->fold == SHADER_FOLD_ALWAYS ||
           (btf_fold_layers(&info, options->fold, 1) <= BTF_MAX_DIRECTION_LAYERS && /* that every GL has */
            btf_fold_cost(request->material, options, &scene).pixels < request->samples);
}

btf_shader_options shade_fold_options(const shader_request *request, int variant) {
    btf_shader_options options = {.struct_size = sizeof options,
                                  .leave_out = BTF_EFFECT_ALL & ~request->effects[variant],
                                  .components = request->components,
                                  .interpolation = request->interpolation,
                                  .filter = request->filter,
                                  .math = request->math,
                                  .fixed = request->fixed,
                                  .picks = request->picks};
    memcpy(options.fixed_view, request->fixed_view, sizeof options.fixed_view);
    memcpy(options.fixed_light, request->fixed_light, sizeof options.fixed_light);
    /* The evaluator on the CPU is not the shader of the model, and its folds are the reference's. */
    const bool wanted = request->fold == SHADER_FOLD_ALWAYS ||
                        (request->fold == SHADER_FOLD_AUTO && strcmp(request->device, "reference") != 0);
    if (!(request->fixed & BTF_FIXED_LIGHT) || !wanted || request->picks) {
        return options;
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(request->material, &info);
    options.fold = btf_fold_best(&info, &options, (request->fixed & BTF_FIXED_VIEW) != 0);
    if (options.fold != BTF_FOLD_NONE && !is_worth_it(request, &options)) {
        options.fold = BTF_FOLD_NONE;
    }
    return options;
}

float *shade_fold_reference(const btf_ref_material *material, const btf_ref_options *options, btf_fold fold,
                            const float light[3], const float view[3], int threads) {
    const size_t row = (size_t)4 * material->width;
    const int64_t layers = fold == BTF_FOLD_LIGHT ? material->n_views : fold == BTF_FOLD_NEIGHBOURS ? 3 : 1;
    const int64_t rows = (int64_t)material->height * layers;
    float *values = malloc((size_t)rows * row * sizeof *values);
    if (!values) {
        return NULL;
    }
#pragma omp parallel for schedule(dynamic, 4) num_threads(threads)
    for (int64_t i = 0; i < rows; i++) {
        const uint32_t layer = (uint32_t)(i / material->height), y = (uint32_t)(i % material->height);
        float *out = values + (size_t)i * row;
        if (fold == BTF_FOLD_LIGHT) {
            btf_ref_fold_light(material, options, light, layer, y, 1, out);
        } else if (fold == BTF_FOLD_NEIGHBOURS) {
            btf_ref_fold_neighbour(material, options, light, view, layer, y, 1, out);
        } else {
            btf_ref_fold_both(material, options, light, view, y, 1, out);
        }
    }
    return values;
}
