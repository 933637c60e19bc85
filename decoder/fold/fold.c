/* The folds that a material and its options allow, and their cost. See openbtf/fold.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fold.h"
#include "decoder/evaluate/partners.h"
#include "decoder/restrict.h"
#include "decoder/result.h"

#include <stdint.h>
#include <string.h>

static btf_shader_options read_options(const btf_shader_options *options) {
    btf_shader_options all = {.struct_size = sizeof all};
    if (options) {
        memcpy(&all, options, options->struct_size < sizeof all ? options->struct_size : sizeof all);
    }
    return all;
}

btf_material_info btfi_folded_info(const btf_material_info *info, btf_fold fold) {
    btf_material_info shown = {.struct_size = sizeof shown};
    memcpy(&shown, info, info->struct_size < sizeof shown ? info->struct_size : sizeof shown);
    if (fold == BTF_FOLD_NONE) {
        return shown;
    }
    shown.layout = BTF_LAYOUT_TIGHT;
    shown.effects &= fold == BTF_FOLD_BOTH || fold == BTF_FOLD_SUM ? 0u : (uint32_t)BTF_EFFECT_RELIEF;
    shown.colour = BTF_COLOUR_NONE;
    shown.lobes = shown.components = 0;
    shown.store = BTF_STORE_COMPONENTS;
    shown.point_store = BTF_POINTS_SEPARATE;
    return shown;
}

btf_result btf_fold_check(const btf_material_info *info, const btf_shader_options *options,
                          const btf_log *log) {
    const btf_shader_options all = read_options(options);
    const uint32_t effects = info->effects & ~all.leave_out;
    const bool of_lights = all.fold == BTF_FOLD_LIGHT || all.fold == BTF_FOLD_SUM;
    if ((unsigned)all.fold > BTF_FOLD_SUM) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED, "fold: kind %d is unknown, expected 0 to 4",
                         (int)all.fold);
    }
    if (all.fold != BTF_FOLD_NONE && all.picks != BTF_PICK_NONE) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED, "fold: a stochastic decode is not folded");
    }
    if (of_lights && info->colour != BTF_COLOUR_NONE) {
        return btfi_fail(
            log, BTF_ERROR_UNSUPPORTED,
            "fold: the material has an SBRDF, which depends on the viewer: a light alone is not folded");
    }
    if (of_lights && effects & BTF_EFFECT_GLOSS) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED,
                         "fold: the material has gloss, by which look-ups of lights follow the viewer: a "
                         "light alone is not folded");
    }
    if (all.fold == BTF_FOLD_BOTH && effects & BTF_EFFECT_RELIEF) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED,
                         "fold: with relief a pixel shows parts of texels: light and view are not folded "
                         "to radiance, but to "
                         "neighbouring views");
    }
    if (all.fold == BTF_FOLD_SUM && effects & BTF_EFFECT_RELIEF) {
        return btfi_fail(
            log, BTF_ERROR_UNSUPPORTED,
            "fold: with relief neighbouring views show other texels: products of views are not "
            "those of one texel, and a sum of lights is not folded");
    }
    if (all.fold == BTF_FOLD_SUM && info->blend == BTF_BLEND_ROOTS && info->n_views > BTFI_MOST_PARTNERED) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED,
                         "fold: the material has %u views, the sum of lights is folded for at most %d",
                         (unsigned)info->n_views, (int)BTFI_MOST_PARTNERED);
    }
    return BTF_OK;
}

btf_fold btf_fold_best(const btf_material_info *info, const btf_shader_options *options,
                       int view_is_still) {
    static const btf_fold by_reading[] = {BTF_FOLD_BOTH, BTF_FOLD_NEIGHBOURS, BTF_FOLD_LIGHT};
    btf_shader_options all = read_options(options);
    for (int i = view_is_still ? 0 : 2; i < 3; i++) {
        all.fold = by_reading[i];
        if (btf_fold_check(info, &all, NULL) == BTF_OK) {
            return all.fold;
        }
    }
    return BTF_FOLD_NONE;
}

btf_fold btf_fold_best_sum(const btf_material_info *info, const btf_shader_options *options,
                           int view_is_still) {
    btf_shader_options all = read_options(options);
    all.fold = view_is_still ? BTF_FOLD_BOTH : BTF_FOLD_SUM;
    return btf_fold_check(info, &all, NULL) == BTF_OK ? all.fold : BTF_FOLD_NONE;
}

btf_shader_options btf_fold_pass(const btf_shader_options *options) {
    btf_shader_options all = read_options(options);
    all.leave_out |= BTF_EFFECT_RELIEF;
    all.filter = BTF_FILTER_TEXEL;
    all.fixed = 0;
    all.fold = BTF_FOLD_NONE;
    all.picks = BTF_PICK_NONE;
    return all;
}

uint32_t btf_fold_layers(const btf_material_info *info, btf_fold fold, uint32_t lights) {
    switch (fold) {
    case BTF_FOLD_LIGHT:
        return lights * info->n_views;
    case BTF_FOLD_SUM:
        return lights * info->n_views * (info->blend == BTF_BLEND_ROOTS ? 1 + BTFI_PARTNERS : 1);
    case BTF_FOLD_NEIGHBOURS:
        return lights * 3;
    default:
        return lights;
    }
}

bool btfi_fold_fits(const btf_material_info *info, btf_fold fold, uint32_t lights) {
    double texels = 0;
    for (uint32_t i = 0; i < info->levels; i++) {
        texels += (double)btf_level_size(info->width, i) * btf_level_size(info->height, i);
    }
    return texels * btf_fold_layers(info, fold, 1) * lights * (double)btf_format_size(BTF_FORMAT_RGBA32UI) <
           (double)(SIZE_MAX / 2);
}

size_t btf_fold_bytes(const btf_material_info *info, btf_fold fold, uint32_t lights) {
    size_t texels = 0;
    for (uint32_t i = 0; i < info->levels; i++) {
        texels += (size_t)btf_level_size(info->width, i) * btf_level_size(info->height, i);
    }
    return texels * btf_fold_layers(info, fold, lights) * btf_format_size(BTF_FORMAT_RGBA32UI);
}

btf_fold_costs btf_fold_cost(const btf_material *material, const btf_shader_options *options,
                             const btf_scene *scene) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    const btf_shader_options all = read_options(options), pass = btf_fold_pass(options);
    btf_shader_options unfolded = all;
    unfolded.fold = BTF_FOLD_NONE;
    const btf_scene anywhere = {.struct_size = sizeof anywhere, .costs = btfi_costs_of(scene)};
    /* A pass over a view does a third of the work of a pixel, which blends three neighbouring views. */
    const bool of_views = all.fold == BTF_FOLD_LIGHT || all.fold == BTF_FOLD_SUM;
    const double views =
        of_views ? info.n_views / (all.interpolation == BTF_INTERPOLATION_NEAREST ? 1.0 : 3.0) : 1;
    const btf_decode_counts product = {.fetches = 3, .bytes = 48, .floats = 12};
    const double added = all.fold == BTF_FOLD_SUM ? btf_fold_layers(&info, BTF_FOLD_SUM, 1) *
                                                        btf_cost_of(&product, anywhere.costs)
                                                  : 0;
    btf_fold_costs costs = {
        .pass = info.width * (double)info.height *
                (views * (double)btf_plan_cost(material, &pass, scene ? &anywhere : NULL) + added),
        .unfolded = btf_plan_cost(material, &unfolded, scene),
        .folded = btf_plan_cost(material, &all, scene)};
    const double saved = (double)costs.unfolded - (double)costs.folded;
    costs.pixels = saved > 0 ? costs.pass / saved : 1e30;
    return costs;
}

void btfi_fold_plan(const btf_material *material, btf_plan *plan) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    plan->fold = BTF_FOLD_NONE;
    plan->fold_bytes = 0;
    plan->folded_cost = plan->cost;
    plan->fold_pixels = 0;
    btf_shader_options options = plan->shader;
    const btf_scene *scene = &plan->scene;
    if (scene->no_fold) {
        return;
    }
    if (scene->light.fixed) {
        options.fold = btf_fold_best(&info, &options, scene->view.fixed);
    } else if (scene->still_lights) {
        options.fold = btf_fold_best_sum(&info, &options, scene->view.fixed);
    }
    if (options.fold == BTF_FOLD_NONE) {
        return;
    }
    const btf_material_info small = btfi_restricted_info(&info, plan->effects, plan->components,
                                                         plan->level, plan->views, plan->lights);
    const float lights = (float)(plan->scene.lights ? plan->scene.lights : 1);
    const btf_fold_costs costs = btf_fold_cost(material, &options, &plan->scene);
    /* The restriction has fewer views and fewer texels to fold. */
    const bool of_views = options.fold == BTF_FOLD_LIGHT || options.fold == BTF_FOLD_SUM;
    const double share = (of_views ? (double)small.n_views / info.n_views : 1) *
                         ((double)small.width * small.height) / ((double)info.width * info.height);
    /* The sum of several lights is read once; other folds are read once for each light. */
    const float read = options.fold == BTF_FOLD_BOTH || options.fold == BTF_FOLD_SUM ? 1 : lights;
    const double saved = (double)(costs.unfolded * lights) - (double)(costs.folded * read);
    const double pixels = (saved > 0 ? costs.pass * (double)lights / saved : 1e30) * share;
    const size_t bytes = btf_fold_bytes(&small, options.fold, 1);
    if ((plan->scene.folded_pixels > 0 && pixels > plan->scene.folded_pixels) ||
        (plan->scene.folded_bytes > 0 && bytes > plan->scene.folded_bytes)) {
        return;
    }
    plan->fold = options.fold;
    plan->fold_bytes = bytes;
    plan->folded_cost = costs.folded * read;
    plan->fold_pixels = pixels;
}
