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

struct btf_gl_fold {
    btfi_gl_functions api;
    btf_fold kind;
    uint32_t width, height, levels, views, lights; /* views: layers of a light */
    uint32_t texture, program;
    int32_t light, view, viewer, level; /* locations of the program's uniforms; view: the layer, viewer: a direction */
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

static btf_result make_texture(btf_gl_fold *f, uint32_t layers, const btf_log *log) {
    const btfi_gl_functions *api = &f->api;
    int32_t side = 0, most_layers = 0, bound = 0;
    btfi_gl_unpack unpack;
    api->GetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
    api->GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
    if ((int64_t)f->width > side || (int64_t)f->height > side || (int64_t)layers > most_layers)
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED,
                         "folded: %u x %u texels in %u layers exceed GL_MAX_TEXTURE_SIZE %d or "
                         "GL_MAX_ARRAY_TEXTURE_LAYERS %d",
                         f->width, f->height, layers, side, most_layers);
    api->GetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &bound);
    btfi_gl_save_unpack(api, &unpack); /* a bound buffer would be read from */
    api->GenTextures(1, &f->texture);
    api->BindTexture(GL_TEXTURE_2D_ARRAY, f->texture);
    api->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER,
                       (int32_t)(f->levels > 1 ? GL_NEAREST_MIPMAP_NEAREST : GL_NEAREST));
    api->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    api->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    api->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    api->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BASE_LEVEL, 0);
    api->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, (int32_t)f->levels - 1);
    for (uint32_t i = 0; i < f->levels; ++i)
        api->TexImage3D(GL_TEXTURE_2D_ARRAY, (int32_t)i, GL_RGBA32UI, (int32_t)btf_level_size(f->width, i),
                        (int32_t)btf_level_size(f->height, i), (int32_t)layers, 0, GL_RGBA_INTEGER,
                        GL_UNSIGNED_INT, NULL);
    btfi_gl_restore_unpack(api, &unpack);
    api->BindTexture(GL_TEXTURE_2D_ARRAY, (uint32_t)bound);
    const uint32_t error = btfi_gl_errors(api);
    if (error != GL_NO_ERROR)
        return btfi_fail(log, error == GL_OUT_OF_MEMORY ? BTF_ERROR_MEMORY : BTF_ERROR_UNSUPPORTED,
                         "folded: GL refuses %u x %u x %u texels with error 0x%04x", f->width, f->height,
                         layers, error);
    return BTF_OK;
}

static btf_result make_program(btf_gl_fold *f, const btf_material *material,
                               const btf_shader_options *shader, const btf_log *log) {
    btf_shader_options pass = btf_fold_pass(shader);
    char version[32], *library = NULL;
    pass.have_precise = 0; /* the newest version says */
    pass.prefix = NULL;
    pass.bindings = BTF_BINDINGS_NONE;
    btf_result result = btf_shader_source(material, &pass, log, &library);
    if (result != BTF_OK)
        return result;
    btfi_gl_version(&f->api, version, sizeof version);
    static const char *const texts[] = {
        [BTF_FOLD_LIGHT] = light_text, [BTF_FOLD_BOTH] = both_text, [BTF_FOLD_NEIGHBOURS] = neighbour_text};
    const char *parts[] = {version, library, texts[f->kind]};
    f->program = btfi_gl_program(&f->api, 3, parts, "fold", log);
    btf_free(library);
    if (!f->program)
        return BTF_ERROR_UNSUPPORTED;
    f->light = f->api.GetUniformLocation(f->program, "btf_pass_light");
    f->view = f->api.GetUniformLocation(f->program, "btf_pass_view");
    f->viewer = f->api.GetUniformLocation(f->program, "btf_pass_viewer");
    f->level = f->api.GetUniformLocation(f->program, "btf_pass_level");
    return BTF_OK;
}

btf_result btf_gl_fold_create(const btf_material *material, const btf_gl_options *options, uint32_t lights,
                              const btf_log *log, btf_gl_fold **out_fold) {
    *out_fold = NULL;
    if (!options || options->struct_size < sizeof *options || !options->shader || lights < 1 ||
        options->shader->fold < BTF_FOLD_LIGHT || options->shader->fold > BTF_FOLD_NEIGHBOURS)
        return btfi_fail(log, BTF_ERROR_USAGE, "fold: options, their shader, its fold (1 to 3) or a light is missing; lights: %u", (unsigned)lights);
    btf_material_info info = {.struct_size = sizeof info};
    btf_result result = btf_material_get_info(material, &info);
    if (result == BTF_OK)
        result = btf_fold_check(&info, options->shader, log);
    if (result != BTF_OK)
        return result;
    btf_gl_fold *f = calloc(1, sizeof *f);
    if (!f)
        return btfi_fail(log, BTF_ERROR_MEMORY, "fold: out of memory");
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
                     : make_texture(f, f->views * lights, log);
    }
    if (result == BTF_OK)
        result = make_program(f, material, options->shader, log);
    if (result != BTF_OK)
        btf_gl_fold_destroy(&f);
    *out_fold = f;
    return result;
}

/* Draws every layer and level of a light; the program is current. */
static btf_result draw_layers(const btf_gl_fold *f, uint32_t number, const btf_log *log) {
    const btfi_gl_functions *api = &f->api;
    for (uint32_t level = 0; level < f->levels; ++level) {
        api->Viewport(0, 0, (int32_t)btf_level_size(f->width, level),
                      (int32_t)btf_level_size(f->height, level));
        if (f->level >= 0)
            api->Uniform1i(f->level, (int32_t)level);
        for (uint32_t view = 0; view < f->views; ++view) {
            api->FramebufferTextureLayer(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, f->texture,
                                         (int32_t)level, (int32_t)(number * f->views + view));
            if (level + view == 0 &&
                api->CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
                return btfi_fail(log, BTF_ERROR_UNSUPPORTED,
                                 "fold: an RGBA32UI framebuffer of layers is refused");
            if (f->view >= 0)
                api->Uniform1i(f->view, (int32_t)view);
            api->DrawArrays(GL_TRIANGLES, 0, 3);
        }
    }
    return BTF_OK;
}

btf_result btf_gl_fold_run(btf_gl_fold *fold, btf_gl *textures, uint32_t first_unit, uint32_t number,
                           const float light[3], const float view[3], const btf_log *log) {
    const btfi_gl_functions *api = &fold->api;
    if (number >= fold->lights)
        return btfi_fail(log, BTF_ERROR_USAGE, "fold: light %u, but the fold has %u, from 0 on", number, fold->lights);
    if (fold->kind != BTF_FOLD_LIGHT && !view)
        return btfi_fail(log, BTF_ERROR_USAGE, "fold: light and view are folded, but the view is missing");
    btfi_gl_errors(api);
    btf_result result = btf_gl_bind(textures, fold->program, first_unit, NULL, log, NULL);
    if (result != BTF_OK)
        return result;
    btfi_gl_state saved;
    uint32_t framebuffer = 0, array = 0;
    btfi_gl_save_state(api, &saved);
    api->GenFramebuffers(1, &framebuffer);
    api->BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    api->GenVertexArrays(1, &array);
    api->BindVertexArray(array);
    api->UseProgram(fold->program);
    if (fold->light >= 0)
        api->Uniform3f(fold->light, light[0], light[1], light[2]);
    if (fold->viewer >= 0)
        api->Uniform3f(fold->viewer, view[0], view[1], view[2]);
    result = draw_layers(fold, number, log);
    api->DeleteVertexArrays(1, &array);
    api->DeleteFramebuffers(1, &framebuffer);
    btfi_gl_restore_state(api, &saved);
    const uint32_t error = btfi_gl_errors(api);
    if (result == BTF_OK && error != GL_NO_ERROR)
        result = btfi_fail(log, error == GL_OUT_OF_MEMORY ? BTF_ERROR_MEMORY : BTF_ERROR_UNSUPPORTED,
                           "fold: GL error 0x%04x while drawing", error);
    return result;
}

void btf_gl_fold_bind(btf_gl_fold *fold, uint32_t program, uint32_t unit, const char *prefix) {
    const btfi_gl_functions *api = &fold->api;
    char name[80];
    int32_t current = 0, active = 0;
    snprintf(name, sizeof name, "%.48s_folded", prefix ? prefix : "btf");
    api->GetIntegerv(GL_CURRENT_PROGRAM, &current);
    api->GetIntegerv(GL_ACTIVE_TEXTURE, &active);
    api->UseProgram(program);
    const int32_t location = api->GetUniformLocation(program, name);
    if (location >= 0) {
        api->ActiveTexture(GL_TEXTURE0 + unit);
        api->BindTexture(GL_TEXTURE_2D_ARRAY, fold->texture);
        api->BindSampler(unit, 0);
        api->Uniform1i(location, (int32_t)unit);
    }
    api->UseProgram((uint32_t)current);
    api->ActiveTexture((uint32_t)active);
}

uint32_t btf_gl_fold_texture(const btf_gl_fold *fold) {
    return fold->texture;
}

size_t btf_gl_fold_bytes(const btf_gl_fold *fold) {
    return fold->bytes;
}

void btf_gl_fold_destroy(btf_gl_fold **fold) {
    if (!fold || !*fold)
        return;
    if ((*fold)->texture)
        (*fold)->api.DeleteTextures(1, &(*fold)->texture);
    if ((*fold)->program)
        (*fold)->api.DeleteProgram((*fold)->program);
    free(*fold);
    *fold = NULL;
}
