/* Folds lights into a texture of the current GL context. See openbtf/fold.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/gl_functions.h"
#include "decoder/result.h"
#include "gl_draw.h"
#include <openbtf/fold.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A program that folds, 0: none, and the locations of its uniforms; view: the layer, viewer: a direction. */
typedef struct fold_program {
    uint32_t name;
    int32_t light, view, viewer, level, weight, sum, from;
} fold_program;

struct btf_gl_fold {
    btfi_gl_functions api;
    btf_fold kind;
    uint32_t width, height, levels, views, lights; /* views: layers of a light */
    uint32_t texture;
    fold_program one, sum; /* of one light; of several, made when it is asked for */
    char *library;         /* the text that it is made from; NULL where only one light can be folded */
    size_t bytes;
};

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

/* The pass that adds one light to the sum of those before, which lies in a layer of another texture (or there is none). */
static const char sum_text[] =
    "uniform highp vec3 btf_pass_light, btf_pass_viewer, btf_pass_weight;\n"
    "uniform highp int btf_pass_level, btf_pass_from;\n"
    "uniform highp usampler2DArray btf_pass_sum;\n"
    "out highp uvec4 btf_pass_value;\n"
    "void main() {\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    vec3 sum = vec3(0.0);\n"
    "    if (btf_pass_from >= 0)\n"
    "        sum = uintBitsToFloat(texelFetch(btf_pass_sum, ivec3(at, btf_pass_from), "
    "btf_pass_level).xyz);\n"
    "    vec3 value = btf_fold_both(uvec2(at), btf_pass_light, btf_pass_viewer, btf_pass_level);\n"
    "    btf_pass_value = uvec4(floatBitsToUint(btf_fold_add(sum, value, btf_pass_weight)), 0u);\n"
    "}\n";

static btf_result make_texture(const btf_gl_fold *f, uint32_t layers, uint32_t *out_texture,
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
    btfi_gl_save_unpack(api, &unpack); /* a bound buffer would be read from */
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

static btf_result make_program(const btfi_gl_functions *api, const char *library, const char *body,
                               const btf_log *log, fold_program *out) {
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
    return BTF_OK;
}

static btf_result make_pass(btf_gl_fold *f, const btf_material *material, const btf_shader_options *shader,
                            const btf_log *log) {
    static const char *const bodies[] = {
        [BTF_FOLD_LIGHT] = light_text, [BTF_FOLD_BOTH] = both_text, [BTF_FOLD_NEIGHBOURS] = neighbour_text};
    btf_shader_options pass = btf_fold_pass(shader);
    char *library = NULL;
    pass.have_precise = 0; /* the newest version says */
    pass.prefix = NULL;
    pass.bindings = BTF_BINDINGS_NONE;
    pass.language = BTF_LANGUAGE_GLSL;
    btf_result result = btf_shader_source(material, &pass, log, &library);
    if (result != BTF_OK) {
        return result;
    }
    result = make_program(&f->api, library, bodies[f->kind], log, &f->one);
    if (f->kind == BTF_FOLD_BOTH) {
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
        options->shader->fold < BTF_FOLD_LIGHT || options->shader->fold > BTF_FOLD_NEIGHBOURS) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "fold: options, their shader, its fold (1 to 3) or a light is missing; lights: %u",
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
    f->views = btf_fold_layers(&info, f->kind, 1);
    f->lights = lights;
    f->bytes = btf_fold_bytes(&info, f->kind, lights);
    result = btfi_gl_load(options, log, &f->api);
    if (result == BTF_OK) {
        btfi_gl_errors(&f->api);
        result = (uint64_t)f->views * lights > 0x10000
                     ? btfi_fail(log, BTF_ERROR_UNSUPPORTED, "fold: %u lights in %u views are too many",
                                 lights, f->views)
                     : make_texture(f, f->views * lights, &f->texture, log);
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

/* The objects that drawing binds, and the caller's state to put back afterwards. */
typedef struct stage {
    btfi_gl_state saved;
    uint32_t framebuffer, array;
} stage;

static void begin(const btf_gl_fold *f, const fold_program *program, const float view[3], stage *s) {
    const btfi_gl_functions *api = &f->api;
    *s = (stage){0};
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

static btf_result end(const btf_gl_fold *f, stage *s, btf_result result, const btf_log *log) {
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

/* Draws a level of a layer; the program is current. */
static btf_result draw_layer(const btf_gl_fold *f, const fold_program *program, const float light[3],
                             uint32_t texture, uint32_t layer, uint32_t level, const btf_log *log) {
    const btfi_gl_functions *api = &f->api;
    if (program->light >= 0) {
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

/* Checks the arguments that all calls of a fold have. */
static btf_result check_call(const btf_gl_fold *f, uint32_t number, const float *light, const float *view,
                             const btf_log *log) {
    if (number >= f->lights) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "fold: light %u is beyond the %u lights of the fold, which count from 0", number,
                         f->lights);
    }
    if (!light) {
        return btfi_fail(log, BTF_ERROR_USAGE, "fold: the light is missing");
    }
    if (f->kind != BTF_FOLD_LIGHT && !view) {
        return btfi_fail(log, BTF_ERROR_USAGE, "fold: light and view are folded, but the view is missing");
    }
    return BTF_OK;
}

btf_result btf_gl_fold_run(btf_gl_fold *fold, btf_gl *textures, uint32_t first_unit, uint32_t number,
                           const float light[3], const float view[3], const btf_log *log) {
    stage s;
    btf_result result = check_call(fold, number, light, view, log);
    if (result != BTF_OK) {
        return result;
    }
    btfi_gl_errors(&fold->api);
    result = btf_gl_bind(textures, fold->one.name, first_unit, NULL, log, NULL);
    if (result != BTF_OK) {
        return result;
    }
    begin(fold, &fold->one, view, &s);
    for (uint32_t level = 0; level < fold->levels; ++level) {
        for (uint32_t i = 0; i < fold->views && result == BTF_OK; ++i) {
            if (fold->one.view >= 0) {
                fold->api.Uniform1i(fold->one.view, (int32_t)i);
            }
            result =
                draw_layer(fold, &fold->one, light, fold->texture, number * fold->views + i, level, log);
        }
    }
    return end(fold, &s, result, log);
}

/* Every light draws what the one before left in the other of two textures; the last draws into the fold's. */
static btf_result draw_sum(const btf_gl_fold *f, uint32_t other, uint32_t unit, uint32_t number,
                           uint32_t count, const float *lights, const float *weights, const btf_log *log) {
    const btfi_gl_functions *api = &f->api;
    const fold_program *p = &f->sum;
    const uint32_t texture[2] = {f->texture, other}, layer[2] = {number, 0};
    btf_result result = BTF_OK;
    api->Uniform1i(p->sum, (int32_t)unit);
    api->ActiveTexture(GL_TEXTURE0 + unit);
    api->BindSampler(unit, 0);
    for (uint32_t level = 0; level < f->levels; ++level) {
        for (uint32_t i = 0; i < count && result == BTF_OK; ++i) {
            const uint32_t to = (count - 1 - i) % 2;
            api->BindTexture(GL_TEXTURE_2D_ARRAY, texture[1 - to]);
            api->Uniform1i(p->from, i == 0 ? -1 : (int32_t)layer[1 - to]);
            api->Uniform3f(p->weight, weights[3 * (size_t)i], weights[3 * (size_t)i + 1],
                           weights[3 * (size_t)i + 2]);
            result = draw_layer(f, p, lights + 3 * (size_t)i, texture[to], layer[to], level, log);
        }
    }
    api->BindTexture(GL_TEXTURE_2D_ARRAY, 0);
    return result;
}

btf_result btf_gl_fold_run_lights(btf_gl_fold *fold, btf_gl *textures, uint32_t first_unit, uint32_t number,
                                  uint32_t count, const float *lights, const float *weights,
                                  const float view[3], const btf_log *log) {
    stage s;
    uint32_t units = 0, other = 0;
    btf_result result = check_call(fold, number, lights, view, log);
    if (result != BTF_OK) {
        return result;
    }
    if (fold->kind != BTF_FOLD_BOTH || count < 1 || !weights) {
        return btfi_fail(
            log, BTF_ERROR_USAGE,
            "fold: lights are added up where light and view are folded to radiance, with weights; fold %d, "
            "%u lights",
            (int)fold->kind, (unsigned)count);
    }
    btfi_gl_errors(&fold->api);
    if (!fold->sum.name) {
        result = make_program(&fold->api, fold->library, sum_text, log, &fold->sum);
    }
    if (result == BTF_OK) {
        result = make_texture(fold, 1, &other, log);
    }
    if (result == BTF_OK) {
        result = btf_gl_bind(textures, fold->sum.name, first_unit, NULL, log, &units);
    }
    if (result == BTF_OK) {
        begin(fold, &fold->sum, view, &s);
        result = draw_sum(fold, other, first_unit + units, number, count, lights, weights, log);
        fold->api.ActiveTexture(GL_TEXTURE0 + (uint32_t)s.saved.unit);
        result = end(fold, &s, result, log);
    }
    if (other) {
        fold->api.DeleteTextures(1, &other);
    }
    return result;
}

void btf_gl_fold_bind(btf_gl_fold *fold, uint32_t program, uint32_t unit, const char *prefix) {
    const btfi_gl_functions *api = &fold->api;
    char name[80];
    int32_t current = 0, active = 0, deleted = 0;
    snprintf(name, sizeof name, "%.48s_folded", prefix ? prefix : "btf");
    api->GetIntegerv(GL_CURRENT_PROGRAM, &current);
    if (current) { /* one that is deleted while current ends when another takes its place */
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
    free(*fold);
    *fold = NULL;
}
