/* OpenBTF as a WebAssembly module. See exports.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "exports.h"

#include "decoder/shape.h"
#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/reference_view.h"
#include "describe.h"
#include <openbtf/evaluate.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* module.js writes these records word by word. */
_Static_assert(sizeof(btf_web_options) == 18 * 4, "words of options");
_Static_assert(sizeof(btf_web_scene) == 20 * 4, "words of a scene");
_Static_assert(sizeof(btf_web_evaluations) == 9 * 4, "words of evaluations");
_Static_assert(sizeof(btf_web_texture) == 7 * 4, "words of a texture");

struct btf_web_material {
    btf_material *material;
    btf_evaluator *evaluator; /* NULL until the library evaluates */
};

static btf_result last_result;
static char last_message[1400];

static void keep_error(void *user, btf_log_level level, const char *message) {
    (void)user;
    if (level == BTF_LOG_ERROR) {
        snprintf(last_message, sizeof last_message, "%s", message);
    }
}

static const btf_log error_log = {keep_error, NULL};

static void begin(void) {
    last_result = BTF_OK;
    last_message[0] = 0;
}

/* Keeps the result; where no message came with an error, its text is one. */
static btf_result end(btf_result result) {
    last_result = result;
    if (result != BTF_OK && !last_message[0]) {
        snprintf(last_message, sizeof last_message, "%s", btf_result_text(result));
    }
    return result;
}

BTF_WEB_EXPORT(btf_web_interface) uint32_t btf_web_interface(void) {
    return BTF_WEB_INTERFACE;
}

BTF_WEB_EXPORT(btf_web_allocate) void *btf_web_allocate(uint32_t size) {
    return malloc(size ? size : 1);
}

BTF_WEB_EXPORT(btf_web_release) void btf_web_release(void *memory) {
    free(memory);
}

BTF_WEB_EXPORT(btf_web_result) uint32_t btf_web_result(void) {
    return last_result;
}

BTF_WEB_EXPORT(btf_web_message) const char *btf_web_message(void) {
    return last_message;
}

BTF_WEB_EXPORT(btf_web_result_text) const char *btf_web_result_text(uint32_t result) {
    return btf_result_text((btf_result)result);
}

/* Takes over a material that a call made, where it did. */
static btf_web_material *wrap(btf_result result, btf_material *material) {
    btf_web_material *m = result == BTF_OK ? calloc(1, sizeof *m) : NULL;
    if (m) {
        m->material = material;
    } else {
        btf_material_close(&material);
    }
    end(result == BTF_OK && !m ? BTF_ERROR_MEMORY : result);
    return m;
}

BTF_WEB_EXPORT(btf_web_open) btf_web_material *btf_web_open(const void *data, uint32_t size) {
    btf_material *material = NULL;
    begin();
    const btf_result result = btf_material_open_memory(data, size, &error_log, &material);
    return wrap(result, material);
}

BTF_WEB_EXPORT(btf_web_close) void btf_web_close(btf_web_material *material) {
    if (!material) {
        return;
    }
    btf_evaluator_destroy(&material->evaluator);
    btf_material_close(&material->material);
    free(material);
}

/* The text of j, which is freed by the next call; NULL and an error when memory ran out. */
static const char *keep_json(json *j) {
    static char *kept;
    free(kept);
    const char *text = json_text(j);
    kept = text ? strdup(text) : NULL;
    json_free(j);
    end(kept ? BTF_OK : BTF_ERROR_MEMORY);
    return kept;
}

BTF_WEB_EXPORT(btf_web_info) const char *btf_web_info(const btf_web_material *material) {
    json j = {0};
    begin();
    describe_material(&j, material->material);
    return keep_json(&j);
}

BTF_WEB_EXPORT(btf_web_directions)
const float *btf_web_directions(const btf_web_material *material, uint32_t lights) {
    return lights ? btf_material_lights(material->material).xyz
                  : btf_material_views(material->material).xyz;
}

/* Layers of a texture that so many components, or units, need: they are a prefix, as btf_gl_upload takes it. */
static uint32_t layers_of(const btf_material_info *info, btf_texture_id id, uint32_t layers,
                          uint32_t components) {
    const uint32_t n = components && components < info->components ? components : info->components;
    switch (id) {
    case BTF_TEXTURE_RESIDUAL_TEXELS:
        return (n + 3) / 4;
    case BTF_TEXTURE_RESIDUAL_DIRECTIONS:
        return 3 * ((n + 3) / 4);
    case BTF_TEXTURE_FACTOR_TEXELS:
        return btfi_factor_layers(info, n);
    case BTF_TEXTURE_FACTOR_DIRECTIONS:
        return n;
    default:
        return layers;
    }
}

BTF_WEB_EXPORT(btf_web_get_texture)
const btf_web_texture *btf_web_get_texture(const btf_web_material *material, uint32_t level, uint32_t id,
                                           uint32_t components) {
    static btf_web_texture out;
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material->material, &info);
    memset(&out, 0, sizeof out);
    if (id >= BTF_TEXTURE_COUNT) {
        return &out;
    }
    const btf_texture t = btf_material_level_texture(material->material, level, (btf_texture_id)id);
    if (t.format == BTF_FORMAT_NONE) {
        return &out;
    }
    out.format = t.format;
    out.is_array = (uint32_t)t.is_array;
    out.width = t.width;
    out.height = t.height;
    out.layers = layers_of(&info, (btf_texture_id)id, t.layers, components);
    out.data = t.data;
    out.size = (uint32_t)btf_format_size(t.format) * t.width * t.height * out.layers;
    return &out;
}

BTF_WEB_EXPORT(btf_web_texture_name) const char *btf_web_texture_name(uint32_t id) {
    return id < BTF_TEXTURE_COUNT ? btf_texture_name((btf_texture_id)id) : NULL;
}

static btf_shader_options shader_options(const btf_web_options *o) {
    btf_shader_options out = {.struct_size = sizeof out,
                              .leave_out = o->leave_out,
                              .components = o->components,
                              .interpolation = (btf_interpolation)o->interpolation,
                              .filter = (btf_filter)o->filter,
                              .math = (btf_math)o->math,
                              .have_precise = (int)o->have_precise,
                              .prefix = o->prefix,
                              .fixed = o->fixed,
                              .picks = (btf_picks)o->picks,
                              .language = (btf_language)o->language,
                              .descriptor_set = o->descriptor_set,
                              .first_binding = o->first_binding};
    memcpy(out.fixed_view, o->fixed_view, sizeof out.fixed_view);
    memcpy(out.fixed_light, o->fixed_light, sizeof out.fixed_light);
    return out;
}

BTF_WEB_EXPORT(btf_web_textures_read)
uint32_t btf_web_textures_read(const btf_web_material *material, const btf_web_options *options) {
    btf_material_info info = {.struct_size = sizeof info};
    const btf_shader_options shader = shader_options(options);
    btf_material_get_info(material->material, &info);
    return btf_shader_textures(&info, &shader);
}

BTF_WEB_EXPORT(btf_web_source)
const char *btf_web_source(const btf_web_material *material, const btf_web_options *options) {
    static char *kept;
    const btf_shader_options shader = shader_options(options);
    btf_free(kept);
    kept = NULL;
    begin();
    end(btf_shader_source(material->material, &shader, &error_log, &kept));
    return kept;
}

BTF_WEB_EXPORT(btf_web_self_test_source) const char *btf_web_self_test_source(void) {
    return btf_shader_self_test();
}

BTF_WEB_EXPORT(btf_web_self_test_wgsl) const char *btf_web_self_test_wgsl(void) {
    static char *kept;
    btf_free(kept);
    kept = NULL;
    begin();
    end(btf_shader_wgsl(btf_shader_self_test(), &error_log, &kept));
    return kept;
}

BTF_WEB_EXPORT(btf_web_self_test_names) const char *btf_web_self_test_names(uint32_t failures) {
    static char names[200];
    btf_self_test_names(failures, names, sizeof names);
    return names;
}

static btf_range range_of(const btf_web_range *r) {
    btf_range out = {.fixed = (int)r->fixed};
    memcpy(out.theta, r->theta, sizeof out.theta);
    memcpy(out.phi, r->phi, sizeof out.phi);
    memcpy(out.direction, r->direction, sizeof out.direction);
    return out;
}

/* The plan for a scene. */
static btf_result find_plan(const btf_web_material *material, const btf_web_scene *scene,
                            btf_plan *out_plan) {
    const btf_scene s = {.struct_size = sizeof s,
                         .view = range_of(&scene->view),
                         .light = range_of(&scene->light),
                         .pixels = scene->pixels,
                         .lights = scene->lights,
                         .interpolate = (int)scene->interpolate,
                         .no_fold = 1}; /* the module makes no folds */
    memset(out_plan, 0, sizeof *out_plan);
    out_plan->struct_size = sizeof *out_plan;
    const btf_result result = btf_plan_effects(material->material, &s, scene->tolerance, out_plan);
    if (result != BTF_OK) {
        keep_error(NULL, BTF_LOG_ERROR,
                   "the scene: a range holds no direction, or a number is negative or infinite");
    }
    return result;
}

BTF_WEB_EXPORT(btf_web_plan)
const char *btf_web_plan(const btf_web_material *material, const btf_web_scene *scene) {
    btf_plan plan;
    begin();
    if (end(find_plan(material, scene, &plan)) != BTF_OK) {
        return NULL;
    }
    json j = {0};
    describe_plan(&j, &plan);
    return keep_json(&j);
}

BTF_WEB_EXPORT(btf_web_predict)
const char *btf_web_predict(const btf_web_material *material, const btf_web_scene *scene, uint32_t effects,
                            uint32_t components) {
    btf_plan plan;
    float linear = 0, srgb = 0;
    begin();
    btf_result result = find_plan(material, scene, &plan);
    if (result == BTF_OK) {
        result = btf_plan_predict(material->material, &plan, effects, components, &linear, &srgb);
        if (result != BTF_OK) {
            keep_error(NULL, BTF_LOG_ERROR, "the encoder did not measure these effects and components");
        }
    }
    if (end(result) != BTF_OK) {
        return NULL;
    }
    json j = {0};
    json_object(&j, NULL);
    json_float(&j, "psnrLinear", linear);
    json_float(&j, "psnrSrgb", srgb);
    json_end(&j);
    return keep_json(&j);
}

BTF_WEB_EXPORT(btf_web_restrict)
btf_web_material *btf_web_restrict(const btf_web_material *material, const btf_web_scene *scene) {
    btf_plan plan;
    btf_material *out = NULL;
    begin();
    btf_result result = find_plan(material, scene, &plan);
    if (result == BTF_OK) {
        result = btf_material_restrict(material->material, &plan, &error_log, &out);
    }
    return wrap(result, out);
}

BTF_WEB_EXPORT(btf_web_to_tight) btf_web_material *btf_web_to_tight(const btf_web_material *material) {
    btf_material *out = NULL;
    begin();
    const btf_result result = btf_material_to_tight(material->material, &error_log, &out);
    return wrap(result, out);
}

/* Evaluates by the reference decoder, one evaluation after the other. */
static void evaluate_reference(const btf_material *material, const btf_web_options *options,
                               const btf_web_evaluations *e) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    btf_ref_material reference;
    reference_view(material, e->level < info.levels ? e->level : info.levels - 1, &reference);
    const btf_ref_options how = {.effects = BTF_EFFECT_ALL & ~options->leave_out,
                                 .components = options->components ? options->components : UINT32_MAX,
                                 .interpolation = options->interpolation == BTF_INTERPOLATION_NEAREST
                                                      ? BTF_REF_NEAREST
                                                      : BTF_REF_LINEAR,
                                 .filter = filter_of_reference((btf_filter)options->filter)};
    for (size_t i = 0; i < e->count; i++) {
        const float *uv = e->uv + 2 * i;
        const float *light = e->lights + (e->fixed & BTF_FIXED_LIGHT ? 0 : 3 * i);
        const float *view = e->views + (e->fixed & BTF_FIXED_VIEW ? 0 : 3 * i);
        if (options->picks) {
            btf_ref_evaluate_stochastic(&reference, &how, (int)options->picks, uv[0], uv[1], light, view,
                                        e->random + 3 * i, e->rgb + 3 * i);
        } else {
            btf_ref_evaluate(&reference, &how, uv[0], uv[1], light, view, e->rgb + 3 * i);
        }
    }
}

/* Evaluates by the library. One level for all is a table of levels of one entry each. */
static btf_result evaluate_many(btf_web_material *material, const btf_web_options *options,
                                const btf_web_evaluations *e) {
    if (!material->evaluator) {
        const btf_result result =
            btf_evaluator_create(material->material, &error_log, &material->evaluator);
        if (result != BTF_OK) {
            return result;
        }
    }
    int32_t *levels = NULL;
    if (e->level && e->count) {
        levels = malloc(e->count * sizeof *levels);
        if (!levels) {
            return BTF_ERROR_MEMORY;
        }
        for (size_t i = 0; i < e->count; i++) {
            levels[i] = (int32_t)e->level;
        }
    }
    const btf_evaluate_options how = {.struct_size = sizeof how,
                                      .leave_out = options->leave_out,
                                      .components = options->components,
                                      .interpolation = (btf_interpolation)options->interpolation,
                                      .filter = (btf_filter)options->filter};
    const btf_evaluations list = {.struct_size = sizeof list,
                                  .count = e->count,
                                  .uv = e->uv,
                                  .lights = e->lights,
                                  .views = e->views,
                                  .levels = levels,
                                  .fixed = e->fixed,
                                  .rgb = e->rgb};
    const btf_result result = btf_evaluate_many(material->evaluator, &how, &list);
    free(levels);
    return result;
}

BTF_WEB_EXPORT(btf_web_evaluate)
uint32_t btf_web_evaluate(btf_web_material *material, const btf_web_options *options,
                          const btf_web_evaluations *evaluations) {
    begin();
    if (!evaluations->reference && !options->picks) {
        return end(evaluate_many(material, options, evaluations));
    }
    evaluate_reference(material->material, options, evaluations);
    return end(BTF_OK);
}
