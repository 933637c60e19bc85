/* A material's properties and plans as JSON. See describe.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "describe.h"

#include "decoder/exr_common.h"
#include "decoder/shape.h"
#include <math.h>

static void effects(json *j, const char *key, uint32_t bits) {
    json_array(j, key);
    for (int i = 0; btfi_effect_name(i); i++) {
        if (bits >> i & 1) {
            json_string(j, NULL, btfi_effect_name(i));
        }
    }
    json_end(j);
}

static void model(json *j, const btf_material_info *info) {
    json_string(j, "layout", btfi_layout_words[info->layout]);
    json_string(j, "domain", btfi_domain_words[info->domain]);
    json_string(j, "colour", btfi_colour_words[info->colour]);
    json_string(j, "blend", btfi_blend_words[info->blend]);
    json_bool(j, "halfFloat", info->half_float);
    json_integer(j, "lobes", info->lobes);
    effects(j, "effects", info->effects);
    json_integer(j, "centres", info->centres);
    json_string(j, "store", info->store == BTF_STORE_FACTORS ? "factors" : "components");
    json_integer(j, "components", info->components);
    json_array(j, "factorClasses");
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        json_array(j, NULL);
        for (int i = 0; i < 3; i++) {
            json_integer(j, NULL, info->factor_classes[c][i]);
        }
        json_end(j);
    }
    json_end(j);
    json_string(j, "pointStore", btfi_point_words[info->point_store]);
    json_integer(j, "pointEntries", info->point_entries);
}

static void numbers(json *j, const btf_material_info *info) {
    json_float(j, "radianceScale", info->radiance_scale);
    json_float(j, "shadowScale", info->shadow_scale);
    json_float(j, "gainScale", info->gain_scale);
    json_float(j, "centreScale", info->centre_scale);
    json_float(j, "horizonScale", info->horizon_scale);
    json_float(j, "gainBase", info->gain_base);
    json_float(j, "gainStep", info->gain_step);
    json_integer(j, "reliefBase", info->relief_base);
    json_integer(j, "reliefStep", info->relief_step);
    json_integer(j, "reliefSteps", info->relief_steps);
    json_integer(j, "reliefLevel", info->relief_level);
    json_integer(j, "reliefEnd", info->relief_end);
    json_integer(j, "glossShare", info->gloss_share);
}

static void figures(json *j, float psnr_linear, float psnr_srgb, float gpu_bytes) {
    json_float(j, "psnrLinear", psnr_linear);
    json_float(j, "psnrSrgb", psnr_srgb);
    json_float(j, "gpuBytes", gpu_bytes);
}

static double psnr(float mse) {
    return mse > 1e-10f ? -10 * log10((double)mse) : 100;
}

static void errors(json *j, const btf_material *material) {
    size_t count;
    const btf_material_error *error = btf_material_errors(material, &count);
    json_array(j, "errors");
    for (size_t i = 0; error && i < count; i++) {
        json_object(j, NULL);
        effects(j, "effects", error[i].effects);
        figures(j, error[i].psnr_linear, error[i].psnr_srgb, error[i].gpu_bytes);
        json_end(j);
    }
    json_end(j);
    const btf_level_error *level = btf_material_level_errors(material, &count);
    json_array(j, "levelErrors");
    for (size_t i = 0; level && i < count; i++) {
        json_object(j, NULL);
        json_integer(j, "level", level[i].level);
        figures(j, level[i].psnr_linear, level[i].psnr_srgb, level[i].gpu_bytes);
        json_end(j);
    }
    json_end(j);
}

/* The rows of the estimate between the samples, of all view and light elevations, level by level. */
static void between_errors(json *j, const btf_material *material) {
    static const struct {
        uint32_t bit;
        const char *word;
    } without[] = {{4, "relief"}, {8, "gloss"}};
    static const char *const left_out[4] = {"", "view", "light", "both"};
    const btf_between_errors b = btf_material_between_errors(material);
    json_array(j, "betweenErrors");
    for (uint32_t i = 0; i < b.row_count; i++) {
        const float *row = b.rows + (size_t)i * b.row_stride;
        const uint32_t what = (uint32_t)row[0] % BTF_BETWEEN_NEXT_LEVEL;
        json_object(j, NULL);
        json_integer(j, "level", (uint32_t)row[0] / BTF_BETWEEN_NEXT_LEVEL);
        json_string(j, "leftOut", left_out[what & 3]);
        json_array(j, "without");
        for (size_t k = 0; k < sizeof without / sizeof without[0]; k++) {
            if (what & without[k].bit) {
                json_string(j, NULL, without[k].word);
            }
        }
        json_end(j);
        json_float(j, "psnrLinear", (float)psnr(row[1]));
        json_float(j, "psnrSrgb", (float)psnr(row[2]));
        json_end(j);
    }
    json_end(j);
}

void describe_material(json *j, const btf_material *material) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    json_object(j, NULL);
    json_integer(j, "version", info.version);
    json_integer(j, "width", info.width);
    json_integer(j, "height", info.height);
    json_integer(j, "viewCount", info.n_views);
    json_integer(j, "lightCount", info.n_lights);
    json_integer(j, "levels", info.levels);
    model(j, &info);
    numbers(j, &info);
    json_integer(j, "atlasWidth", info.atlas_width);
    json_integer(j, "atlasHeight", info.atlas_height);
    json_integer(j, "gpuBytes", (int64_t)info.gpu_bytes);
    json_integer(j, "tableBytes", (int64_t)info.table_bytes);
    json_string(j, "method", info.method);
    json_string(j, "options", info.options);
    json_string(j, "source", info.source);
    errors(j, material);
    between_errors(j, material);
    json_end(j);
}

/* The options that the plan's shader takes, as source() and upload() of the module take them. */
static void shader(json *j, const btf_shader_options *o) {
    static const char *const filters[] = {"texel", "bilinear", "steep"};
    json_object(j, "shader");
    effects(j, "leaveOut", o->leave_out);
    json_integer(j, "components", o->components);
    json_string(j, "interpolation", o->interpolation == BTF_INTERPOLATION_NEAREST ? "nearest" : "linear");
    json_string(j, "filter", filters[o->filter]);
    for (int k = 0; k < 2; k++) {
        if (!(o->fixed & (k == 0 ? BTF_FIXED_VIEW : BTF_FIXED_LIGHT))) {
            continue;
        }
        json_array(j, k == 0 ? "fixedView" : "fixedLight");
        for (int i = 0; i < 3; i++) {
            json_float(j, NULL, (k == 0 ? o->fixed_view : o->fixed_light)[i]);
        }
        json_end(j);
    }
    json_end(j);
}

void describe_plan(json *j, const btf_plan *plan) {
    json_object(j, NULL);
    shader(j, &plan->shader);
    effects(j, "effects", plan->effects);
    json_integer(j, "components", plan->components);
    json_integer(j, "level", plan->level);
    json_integer(j, "views", plan->views);
    json_integer(j, "lights", plan->lights);
    json_integer(j, "gpuBytes", (int64_t)plan->gpu_bytes);
    json_integer(j, "fullGpuBytes", (int64_t)plan->full_gpu_bytes);
    json_float(j, "cost", plan->cost);
    json_float(j, "fullCost", plan->full_cost);
    json_bool(j, "measured", plan->measured);
    json_float(j, "psnrLinear", plan->psnr_linear);
    json_float(j, "psnrSrgb", plan->psnr_srgb);
    json_float(j, "fullPsnrLinear", plan->full_psnr_linear);
    json_float(j, "fullPsnrSrgb", plan->full_psnr_srgb);
    json_float(j, "betweenPsnrLinear", plan->between_psnr_linear);
    json_float(j, "betweenPsnrSrgb", plan->between_psnr_srgb);
    json_float(j, "fullBetweenPsnrLinear", plan->full_between_psnr_linear);
    json_float(j, "fullBetweenPsnrSrgb", plan->full_between_psnr_srgb);
    json_end(j);
}
