/* The plan of a scene that btf-info prints. See info_plan.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "info_plan.h"

#include "info_facts.h"
#include "info_json.h"
#include <stdio.h>

static void json_range(json *j, const char *key, const btf_range *r) {
    json_object(j, key);
    json_bool(j, "fixed", r->fixed);
    json_array(j, r->fixed ? "direction" : "theta");
    for (int i = 0; i < (r->fixed ? 3 : 2); i++) {
        json_float(j, NULL, r->fixed ? r->direction[i] : r->theta[i]);
    }
    json_end(j);
    if (!r->fixed) {
        json_array(j, "phi");
        json_float(j, NULL, r->phi[0]);
        json_float(j, NULL, r->phi[1]);
        json_end(j);
    }
    json_end(j);
}

static btf_result print_json_plan(const cli_program *program, const char *path, const btf_plan *plan,
                                  float tolerance) {
    json j = {0};
    json_object(&j, NULL);
    json_string(&j, "file", path);
    json_range(&j, "view", &plan->scene.view);
    json_range(&j, "light", &plan->scene.light);
    json_float(&j, "tolerance", tolerance);
    json_effect_list(&j, "effects", plan->effects);
    json_integer(&j, "components", plan->components);
    json_string(&j, "store", store_names[plan->textures >> BTF_TEXTURE_FACTOR_DIRECTIONS & 1]);
    json_bool(&j, "nearest", plan->shader.interpolation == BTF_INTERPOLATION_NEAREST);
    json_bool(&j, "bilinear", plan->shader.filter == BTF_FILTER_BILINEAR);
    json_integer(&j, "level", plan->level);
    json_array(&j, "textures");
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        if (plan->textures >> id & 1) {
            json_string(&j, NULL, btf_texture_name((btf_texture_id)id));
        }
    }
    json_end(&j);
    json_integer(&j, "views", plan->views);
    json_integer(&j, "lights", plan->lights);
    json_integer(&j, "gpu", (int64_t)plan->gpu_bytes);
    json_integer(&j, "full_gpu", (int64_t)plan->full_gpu_bytes);
    json_float(&j, "cost", plan->cost);
    json_float(&j, "full_cost", plan->full_cost);
    json_bool(&j, "measured", plan->measured);
    json_float(&j, "linear", plan->psnr_linear);
    json_float(&j, "srgb", plan->psnr_srgb);
    json_float(&j, "full_linear", plan->full_psnr_linear);
    json_float(&j, "full_srgb", plan->full_psnr_srgb);
    json_float(&j, "between_linear", plan->between_psnr_linear);
    json_float(&j, "between_srgb", plan->between_psnr_srgb);
    json_float(&j, "full_between_linear", plan->full_between_psnr_linear);
    json_float(&j, "full_between_srgb", plan->full_between_psnr_srgb);
    static const char *const folds[] = {"none", "light", "both", "neighbours"};
    json_string(&j, "fold", folds[plan->fold]);
    json_integer(&j, "fold_bytes", (int64_t)plan->fold_bytes);
    json_float(&j, "folded_cost", plan->folded_cost);
    json_number(&j, "fold_pixels", plan->fold_pixels);
    json_end(&j);
    return put_json(program, &j);
}

btf_result print_plan(const cli_program *program, const char *path, const btf_material *material,
                      const scene_option *scene, bool as_json) {
    btf_plan plan;
    btf_result result = btf_plan_effects(material, &scene->scene, scene->tolerance, &plan);
    if (result) {
        return cli_error(program, result, "option --plan: no plan can be made for this scene");
    }
    if (as_json) {
        return print_json_plan(program, path, &plan, scene->tolerance);
    }
    scene_plan_print(stdout, "", material, &plan);
    printf("textures");
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        if (plan.textures >> id & 1) {
            printf(" %s", btf_texture_name((btf_texture_id)id));
        }
    }
    printf("\n");
    return BTF_OK;
}
