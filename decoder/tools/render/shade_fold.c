/* Folding for lists. See shade_fold.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "shade_fold.h"

#include "decoder/toolkit/file.h"
#include <omp.h>
#include <openbtf/fold.h>
#include <stdlib.h>
#include <string.h>

bool shade_fold_wanted(shader_fold fold, const char *device, btf_picks picks) {
    return !picks &&
           (fold == SHADER_FOLD_ALWAYS || (fold == SHADER_FOLD_AUTO && strcmp(device, "reference") != 0));
}

/* Whether a fold saves more than it takes. */
static bool pays(const shader_request *request, const btf_shader_options *options) {
    const btf_scene scene = {.struct_size = sizeof scene, .costs = request->costs};
    const btf_fold_costs costs = btf_fold_cost(request->material, options, &scene);
    if (request->lights == 0) {
        return costs.pixels < request->samples;
    }
    /* A fold of a sum takes a pass for each light; a sample then reads one texel for all lights. */
    const double lights = (double)request->lights;
    return lights * costs.pass < request->samples * (lights * (double)costs.unfolded - (double)costs.folded);
}

static bool is_worth_it(const shader_request *request, const btf_shader_options *options,
                        const btf_log *log) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(request->material, &info);
    const size_t bytes = btf_fold_bytes(&info, options->fold, 1);
    if (bytes > SHADE_FOLD_BYTES) {
        if (request->fold == SHADER_FOLD_ALWAYS) {
            file_warn(log, "option --fold always: a fold takes %zu bytes, more than %d: nothing is folded",
                      bytes, (int)SHADE_FOLD_BYTES);
        }
        return false;
    }
    return request->fold == SHADER_FOLD_ALWAYS ||
           (btf_fold_layers(&info, options->fold, 1) <=
                (options->fold == BTF_FOLD_SUM ? (uint32_t)SHADE_SUM_LAYERS
                                               : BTF_MAX_DIRECTION_LAYERS) && /* every GL has so many */
            pays(request, options));
}

/* The fold of which a pixel reads least; for several lights, the fold of their sum or none. */
static btf_fold best_fold(const shader_request *request, const btf_shader_options *options,
                          const btf_log *log) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(request->material, &info);
    const bool view_is_still = request->fixed & BTF_FIXED_VIEW;
    const btf_fold best = request->lights > 0 ? btf_fold_best_sum(&info, options, view_is_still)
                                              : btf_fold_best(&info, options, view_is_still);
    if (best == BTF_FOLD_SUM && !request->sum_of_views) {
        return BTF_FOLD_NONE;
    }
    if (best != BTF_FOLD_NONE) {
        return best;
    }
    if (request->fold == SHADER_FOLD_ALWAYS) {
        file_kept why;
        const btf_log keeps = file_log_keep(&why);
        btf_shader_options refused = *options;
        refused.fold = request->lights == 0 ? BTF_FOLD_LIGHT : view_is_still ? BTF_FOLD_BOTH : BTF_FOLD_SUM;
        btf_fold_check(&info, &refused, &keeps);
        file_warn(log, "option --fold always: %s", why.text);
    }
    return BTF_FOLD_NONE;
}

btf_shader_options shade_fold_options(const shader_request *request, int variant, const btf_log *log) {
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
    /* Sums of lights are folded on the CPU, too: such sums are rounded otherwise than those of pictures, and shall be
     * the same on every device. */
    const bool wanted = request->lights > 0
                            ? request->fold != SHADER_FOLD_NEVER && !request->picks
                            : request->fixed & BTF_FIXED_LIGHT &&
                                  shade_fold_wanted(request->fold, request->device, request->picks);
    if (!wanted) {
        return options;
    }
    options.fold = best_fold(request, &options, log);
    if (options.fold != BTF_FOLD_NONE && !is_worth_it(request, &options, log)) {
        options.fold = BTF_FOLD_NONE;
    }
    return options;
}

/* Folds a row of light and view to radiance: for one light, or the sum of the request's lights. `scratch` has room for
 * a row. */
static void fold_both(const btf_ref_material *material, const btf_ref_options *options,
                      const btf_shader_options *folded, const shader_request *request, uint32_t row,
                      float *scratch, float *out) {
    if (request->lights == 0) {
        btf_ref_fold_both(material, options, folded->fixed_light, folded->fixed_view, row, 1, out);
        return;
    }
    memset(out, 0, (size_t)4 * material->width * sizeof *out);
    for (size_t i = 0; i < request->lights; i++) {
        btf_ref_fold_both(material, options, request->light_directions + 3 * i, folded->fixed_view, row, 1,
                          scratch);
        btf_ref_fold_add(material->width, scratch, request->light_weights + 3 * i, out);
    }
}

/* Folds a level of the sum of lights under a view that moves, by all threads. */
static float *fold_sum(const btf_ref_material *material, const btf_evaluator *evaluator, uint32_t level,
                       const btf_shader_options *folded, const shader_request *request) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(request->material, &info);
    const size_t layers = btf_fold_layers(&info, BTF_FOLD_SUM, 1);
    uint32_t *texels = malloc(layers * material->height * material->width * 4 * sizeof *texels);
    bool ok = texels != NULL;
#pragma omp parallel for schedule(dynamic) num_threads(request->threads)
    for (uint32_t y = 0; y < material->height; y++) {
        if (texels &&
            btf_fold_sum_rows(evaluator, folded, (uint32_t)request->lights, request->light_directions,
                              request->light_weights, level, y, 1, texels) != BTF_OK) {
#pragma omp atomic write
            ok = false;
        }
    }
    if (!ok) {
        free(texels);
        return NULL;
    }
    return (float *)texels;
}

float *shade_fold_reference(const btf_ref_material *material, const btf_evaluator *evaluator,
                            uint32_t level, const btf_ref_options *options,
                            const btf_shader_options *folded, const shader_request *request) {
    const btf_fold fold = folded->fold;
    if (fold == BTF_FOLD_SUM) {
        return fold_sum(material, evaluator, level, folded, request);
    }
    const size_t row = (size_t)4 * material->width;
    const int64_t layers = fold == BTF_FOLD_LIGHT ? material->n_views : fold == BTF_FOLD_NEIGHBOURS ? 3 : 1;
    const int64_t rows = (int64_t)material->height * layers;
    float *values = malloc((size_t)rows * row * sizeof *values);
    float *scratch = malloc((size_t)request->threads * row * sizeof *scratch);
    if (!values || !scratch) {
        free(values);
        free(scratch);
        return NULL;
    }
#pragma omp parallel for schedule(dynamic, 4) num_threads(request->threads)
    for (int64_t i = 0; i < rows; i++) {
        const uint32_t layer = (uint32_t)(i / material->height), y = (uint32_t)(i % material->height);
        float *out = values + (size_t)i * row;
        if (fold == BTF_FOLD_LIGHT) {
            btf_ref_fold_light(material, options, folded->fixed_light, layer, y, 1, out);
        } else if (fold == BTF_FOLD_NEIGHBOURS) {
            btf_ref_fold_neighbour(material, options, folded->fixed_light, folded->fixed_view, layer, y, 1,
                                   out);
        } else {
            fold_both(material, options, folded, request, y, scratch + (size_t)omp_get_thread_num() * row,
                      out);
        }
    }
    free(scratch);
    return values;
}
