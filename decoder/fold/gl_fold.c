/* Folds lights into a texture of the current GL context. See openbtf/fold.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "gl_fold.h"
#include "decoder/evaluate/partners.h"
#include "decoder/result.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char light_text[] = "uniform highp vec3 btf_pass_light;\n"
                                 "uniform highp int btf_pass_view, btf_pass_level;\n"
                                 "out highp uvec4 btf_pass_value;\n"
                                 "void main() {\n"
                                 "    vec3 value = btf_fold_light(uvec2(gl_FragCoord.xy), btf_pass_light,\n"
                                 "                                uint(btf_pass_view), btf_pass_level);\n"
                                 "    btf_pass_value = uvec4(floatBitsToUint(value), 0u);\n"
                                 "}\n";
static const char both_text[] =
    "uniform highp vec3 btf_pass_light, btf_pass_viewer;\n"
    "uniform highp int btf_pass_level;\n"
    "out highp uvec4 btf_pass_value;\n"
    "void main() {\n"
    "    vec3 value = btf_fold_both(uvec2(gl_FragCoord.xy), btf_pass_light, btf_pass_viewer,\n"
    "                               btf_pass_level);\n"
    "    btf_pass_value = uvec4(floatBitsToUint(value), 0u);\n"
    "}\n";
static const char neighbour_text[] =
    "uniform highp vec3 btf_pass_light, btf_pass_viewer;\n"
    "uniform highp int btf_pass_view, btf_pass_level;\n"
    "out highp uvec4 btf_pass_value;\n"
    "void main() {\n"
    "    vec3 value = btf_fold_neighbour(uvec2(gl_FragCoord.xy), btf_pass_light, btf_pass_viewer,\n"
    "                                    btf_pass_view, btf_pass_level);\n"
    "    btf_pass_value = uvec4(floatBitsToUint(value), 0u);\n"
    "}\n";

btf_result btfi_fold_texture(const btf_gl_fold *f, uint32_t layers, uint32_t *out_texture,
                             const btf_log *log) {
    const btfi_gl_functions *api = &f->api;
    int32_t side = 0, most_layers = 0, bound = 0;
    btfi_gl_unpack unpack;
    api->GetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
    api->GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
    if ((int64_t)f->width > side || (int64_t)f->height > side || (int64_t)layers > most_layers) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED,
                         "folded: %u x %u texels in %u layers exceed GL_MAX_TEXTURE_SIZE %d or "
                         "GL_MAX_ARRAY_TEXTURE_LAYERS %d",
                         f->width, f->height, layers, side, most_layers);
    }
    api->GetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &bound);
    btfi_gl_save_unpack(api, &unpack); /* else GL would read texels from a bound unpack buffer */
    api->GenTextures(1, out_texture);
    api->BindTexture(GL_TEXTURE_2D_ARRAY, *out_texture);
    api->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER,
                       (int32_t)(f->levels > 1 ? GL_NEAREST_MIPMAP_NEAREST : GL_NEAREST));
    api->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    api->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    api->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    api->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BASE_LEVEL, 0);
    api->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, (int32_t)f->levels - 1);
    for (uint32_t i = 0; i < f->levels; ++i) {
        api->TexImage3D(GL_TEXTURE_2D_ARRAY, (int32_t)i, GL_RGBA32UI, (int32_t)btf_level_size(f->width, i),
                        (int32_t)btf_level_size(f->height, i), (int32_t)layers, 0, GL_RGBA_INTEGER,
                        GL_UNSIGNED_INT, NULL);
    }
    btfi_gl_restore_unpack(api, &unpack);
    api->BindTexture(GL_TEXTURE_2D_ARRAY, (uint32_t)bound);
    const uint32_t error = btfi_gl_errors(api);
    if (error != GL_NO_ERROR) {
        return btfi_fail(log, error == GL_OUT_OF_MEMORY ? BTF_ERROR_MEMORY : BTF_ERROR_UNSUPPORTED,
                         "folded: GL refuses %u x %u x %u texels with error 0x%04x", f->width, f->height,
                         layers, error);
    }
    return BTF_OK;
}

btf_result btfi_fold_program_make(const btfi_gl_functions *api, const char *library, const char *body,
                                  const btf_log *log, btfi_fold_program *out) {
    char version[32];
    btfi_gl_version(api, version, sizeof version);
    const char *parts[] = {version, library, body};
    out->name = btfi_gl_program(api, 3, parts, "fold", log);
    if (!out->name) {
        return BTF_ERROR_UNSUPPORTED;
    }
    out->light = api->GetUniformLocation(out->name, "btf_pass_light");
    out->view = api->GetUniformLocation(out->name, "btf_pass_view");
    out->viewer = api->GetUniformLocation(out->name, "btf_pass_viewer");
    out->level = api->GetUniformLocation(out->name, "btf_pass_level");
    out->weight = api->GetUniformLocation(out->name, "btf_pass_weight");
    out->sum = api->GetUniformLocation(out->name, "btf_pass_sum");
    out->from = api->GetUniformLocation(out->name, "btf_pass_from");
    out->values = api->GetUniformLocation(out->name, "btf_pass_values");
    out->other = api->GetUniformLocation(out->name, "btf_pass_other");
    out->partners = api->GetUniformLocation(out->name, "btf_pass_partners");
    return BTF_OK;
}

static btf_result make_pass(btf_gl_fold *f, const btf_material *material, const btf_shader_options *shader,
                            const btf_log *log) {
    static const char *const bodies[] = {[BTF_FOLD_LIGHT] = light_text,
                                         [BTF_FOLD_BOTH] = both_text,
                                         [BTF_FOLD_NEIGHBOURS] = neighbour_text,
                                         [BTF_FOLD_SUM] = light_text};
    btf_shader_options pass = btf_fold_pass(shader);
    char *library = NULL;
    pass.have_precise = 0; /* the pass is in the newest GLSL of the context: __VERSION__ decides */
    pass.prefix = NULL;
    pass.bindings = BTF_BINDINGS_NONE;
    pass.language = BTF_LANGUAGE_GLSL;
    btf_result result = btf_shader_source(material, &pass, log, &library);
    if (result != BTF_OK) {
        return result;
    }
    result = btfi_fold_program_make(&f->api, library, bodies[f->kind], log, &f->one);
    if (f->kind == BTF_FOLD_BOTH || f->kind == BTF_FOLD_SUM) {
        f->library = library;
    } else {
        btf_free(library);
    }
    return result;
}

btf_result btf_gl_fold_create(const btf_material *material, const btf_gl_options *options, uint32_t lights,
                              const btf_log *log, btf_gl_fold **out_fold) {
    *out_fold = NULL;
    if (!options || options->struct_size < sizeof *options || !options->shader || lights < 1 ||
        options->shader->fold < BTF_FOLD_LIGHT || options->shader->fold > BTF_FOLD_SUM) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "fold: options, their shader, its fold (1 to 4) or a light is missing; lights: %u",
                         (unsigned)lights);
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_result result = btf_material_get_info(material, &info);
    if (result == BTF_OK) {
        result = btf_fold_check(&info, options->shader, log);
    }
    if (result != BTF_OK) {
        return result;
    }
    btf_gl_fold *f = calloc(1, sizeof *f);
    if (!f) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "fold: out of memory");
    }
    f->kind = options->shader->fold;
    f->width = info.width;
    f->height = info.height;
    f->levels = info.levels;
    f->sampled = info.n_views;
    f->views = btf_fold_layers(&info, f->kind, 1);
    f->lights = lights;
    f->bytes = btf_fold_bytes(&info, f->kind, lights);
    result = btfi_gl_load(options, log, &f->api);
    if (result == BTF_OK && f->kind == BTF_FOLD_SUM && info.blend == BTF_BLEND_ROOTS) {
        const btf_directions views = btf_material_views(material);
        if ((result = btfi_fold_partners(&views, &f->partners))) {
            btfi_fail(log, result, "fold: no partners for %u views", (unsigned)info.n_views);
        }
    }
    if (result == BTF_OK) {
        btfi_gl_errors(&f->api);
        result = (uint64_t)f->views * lights > 0x10000
                     ? btfi_fail(log, BTF_ERROR_UNSUPPORTED, "fold: %u lights in %u views are too many",
                                 lights, f->views)
                     : btfi_fold_texture(f, f->views * lights, &f->texture, log);
    }
    if (result == BTF_OK) {
        result = make_pass(f, material, options->shader, log);
    }
    if (result != BTF_OK) {
        btf_gl_fold_destroy(&f);
    }
    *out_fold = f;
    return result;
}

void btfi_fold_begin(const btf_gl_fold *f, const btfi_fold_program *program, const float view[3],
                     btfi_fold_stage *s) {
    const btfi_gl_functions *api = &f->api;
    *s = (btfi_fold_stage){0};
    btfi_gl_save_state(api, &s->saved);
    api->GenFramebuffers(1, &s->framebuffer);
    api->BindFramebuffer(GL_DRAW_FRAMEBUFFER, s->framebuffer);
    api->GenVertexArrays(1, &s->array);
    api->BindVertexArray(s->array);
    api->UseProgram(program->name);
    if (program->viewer >= 0) {
        api->Uniform3f(program->viewer, view[0], view[1], view[2]);
    }
}

btf_result btfi_fold_end(const btf_gl_fold *f, btfi_fold_stage *s, btf_result result, const btf_log *log) {
    const btfi_gl_functions *api = &f->api;
    api->DeleteVertexArrays(1, &s->array);
    api->DeleteFramebuffers(1, &s->framebuffer);
    btfi_gl_restore_state(api, &s->saved);
    const uint32_t error = btfi_gl_errors(api);
    if (result == BTF_OK && error != GL_NO_ERROR) {
        result = btfi_fail(log, error == GL_OUT_OF_MEMORY ? BTF_ERROR_MEMORY : BTF_ERROR_UNSUPPORTED,
                           "fold: GL error 0x%04x while drawing", error);
    }
    return result;
}

btf_result btfi_fold_draw(const btf_gl_fold *f, const btfi_fold_program *program, const float *light,
                          uint32_t texture, uint32_t layer, uint32_t level, const btf_log *log) {
    const btfi_gl_functions *api = &f->api;
    if (program->light >= 0 && light) {
        api->Uniform3f(program->light, light[0], light[1], light[2]);
    }
    if (program->level >= 0) {
        api->Uniform1i(program->level, (int32_t)level);
    }
    btfi_gl_viewport(api, btf_level_size(f->width, level), btf_level_size(f->height, level));
    api->FramebufferTextureLayer(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, texture, (int32_t)level,
                                 (int32_t)layer);
    if (level == 0 && api->CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED, "fold: an RGBA32UI framebuffer of layers is refused");
    }
    api->DrawArrays(GL_TRIANGLES, 0, 3);
    return BTF_OK;
}

btf_result btfi_fold_check_call(const btf_gl_fold *f, uint32_t number, const float *light,
                                const float *view, const btf_log *log) {
    if (number >= f->lights) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "fold: light %u is beyond the %u lights of the fold, which count from 0", number,
                         f->lights);
    }
    if (!light) {
        return btfi_fail(log, BTF_ERROR_USAGE, "fold: the light is missing");
    }
    if (f->kind != BTF_FOLD_LIGHT && f->kind != BTF_FOLD_SUM && !view) {
        return btfi_fail(log, BTF_ERROR_USAGE, "fold: light and view are folded, but the view is missing");
    }
    return BTF_OK;
}

btf_result btf_gl_fold_run(btf_gl_fold *fold, btf_gl *textures, uint32_t first_unit, uint32_t number,
                           const float light[3], const float view[3], const btf_log *log) {
    btfi_fold_stage s;
    if (fold->kind == BTF_FOLD_SUM) {
        static const float whole[3] = {1, 1, 1};
        return btf_gl_fold_run_lights(fold, textures, first_unit, number, 1, light, whole, NULL, log);
    }
    btf_result result = btfi_fold_check_call(fold, number, light, view, log);
    if (result != BTF_OK) {
        return result;
    }
    btfi_gl_errors(&fold->api);
    result = btf_gl_bind(textures, fold->one.name, first_unit, NULL, log, NULL);
    if (result != BTF_OK) {
        return result;
    }
    btfi_fold_begin(fold, &fold->one, view, &s);
    for (uint32_t level = 0; level < fold->levels; ++level) {
        for (uint32_t i = 0; i < fold->views && result == BTF_OK; ++i) {
            if (fold->one.view >= 0) {
                fold->api.Uniform1i(fold->one.view, (int32_t)i);
            }
            result = btfi_fold_draw(fold, &fold->one, light, fold->texture, number * fold->views + i, level,
                                    log);
        }
    }
    return btfi_fold_end(fold, &s, result, log);
}

void btf_gl_fold_bind(btf_gl_fold *fold, uint32_t program, uint32_t unit, const char *prefix) {
    const btfi_gl_functions *api = &fold->api;
    char name[80];
    int32_t current = 0, active = 0, deleted = 0;
    snprintf(name, sizeof name, "%.48s_folded", prefix ? prefix : "btf");
    api->GetIntegerv(GL_CURRENT_PROGRAM, &current);
    if (current) { /* one that was deleted is gone once another is current: it is not put back */
        api->GetProgramiv((uint32_t)current, GL_DELETE_STATUS, &deleted);
    }
    api->GetIntegerv(GL_ACTIVE_TEXTURE, &active);
    api->UseProgram(program);
    const int32_t location = api->GetUniformLocation(program, name);
    if (location >= 0) {
        api->ActiveTexture(GL_TEXTURE0 + unit);
        api->BindTexture(GL_TEXTURE_2D_ARRAY, fold->texture);
        api->BindSampler(unit, 0);
        api->Uniform1i(location, (int32_t)unit);
    }
    if (!deleted) {
        api->UseProgram((uint32_t)current);
    }
    api->ActiveTexture((uint32_t)active);
}

uint32_t btf_gl_fold_texture(const btf_gl_fold *fold) {
    return fold->texture;
}

size_t btf_gl_fold_bytes(const btf_gl_fold *fold) {
    return fold->bytes;
}

void btf_gl_fold_destroy(btf_gl_fold **fold) {
    if (!fold || !*fold) {
        return;
    }
    if ((*fold)->texture) {
        (*fold)->api.DeleteTextures(1, &(*fold)->texture);
    }
    if ((*fold)->one.name) {
        (*fold)->api.DeleteProgram((*fold)->one.name);
    }
    if ((*fold)->sum.name) {
        (*fold)->api.DeleteProgram((*fold)->sum.name);
    }
    btf_free((*fold)->library);
    free((*fold)->partners);
    free(*fold);
    *fold = NULL;
}
