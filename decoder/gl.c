/* Uploads a material's textures to OpenGL and points a program's samplers at them.
 *
 * SPDX-License-Identifier: MIT
 */
#include "gl_functions.h"
#include "material.h"
#include "result.h"
#include "shape.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct btf_gl {
    btfi_gl_functions api;
    uint32_t name[BTF_TEXTURE_COUNT]; /* 0: not uploaded */
    int is_array[BTF_TEXTURE_COUNT];
    size_t bytes;
};

/* Bits of the textures to upload, and how many components of the residual. */
static uint32_t choose_textures(const btf_material_info *info, const btf_shader_options *shader,
                                uint32_t *out_components) {
    *out_components = info->components;
    if (!shader) {
        return (1u << BTF_TEXTURE_COUNT) - 1;
    }
    if (shader->components && shader->components < info->components) {
        *out_components = shader->components;
    }
    return btf_shader_textures(info, shader);
}

/* Refuses a material whose textures exceed the limits of the context. */
static btf_result check_limits(const btfi_gl_functions *gl, const char *name, const btf_texture *texture,
                               const btf_log *log) {
    int32_t side = 0, layers = 0;
    gl->GetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
    gl->GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &layers);
    const char *advice = strcmp(name, btf_texture_name(BTF_TEXTURE_MAPS)) == 0
                             ? " (btf_material_to_tight takes it apart)"
                             : "";
    if ((int64_t)texture->width > side) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED, "%s: width %u exceeds GL_MAX_TEXTURE_SIZE %d%s", name,
                         texture->width, side, advice);
    }
    if ((int64_t)texture->height > side) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED, "%s: height %u exceeds GL_MAX_TEXTURE_SIZE %d%s", name,
                         texture->height, side, advice);
    }
    if (texture->is_array && (int64_t)texture->layers > layers) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED, "%s: %u layers exceed GL_MAX_ARRAY_TEXTURE_LAYERS %d",
                         name, texture->layers, layers);
    }
    return BTF_OK;
}

/* Internal format, format and type of a texture. */
static void gl_format(btf_format format, uint32_t out[3]) {
    static const struct {
        btf_format format;
        uint32_t gl[3];
    } table[] = {
        {BTF_FORMAT_R8UI, {GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE}},
        {BTF_FORMAT_RG8UI, {GL_RG8UI, GL_RG_INTEGER, GL_UNSIGNED_BYTE}},
        {BTF_FORMAT_RGBA8UI, {GL_RGBA8UI, GL_RGBA_INTEGER, GL_UNSIGNED_BYTE}},
        {BTF_FORMAT_RGBA8I, {GL_RGBA8I, GL_RGBA_INTEGER, GL_BYTE}},
        {BTF_FORMAT_RGBA16UI, {GL_RGBA16UI, GL_RGBA_INTEGER, GL_UNSIGNED_SHORT}},
        {BTF_FORMAT_RGBA16F, {GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT}},
        {BTF_FORMAT_RGBA32F, {GL_RGBA32F, GL_RGBA, GL_FLOAT}},
        {BTF_FORMAT_RGBA32UI, {GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT}},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; ++i) {
        if (table[i].format == format) {
            memcpy(out, table[i].gl, sizeof table[i].gl);
        }
    }
}

/* Makes one texture of `levels` mip levels, the first of which is the largest, on the active unit,
 * unpacking tightly. */
static btf_result upload(btf_gl *gl, btf_texture_id id, const btf_texture *texture, uint32_t levels,
                         const btf_log *log) {
    const btfi_gl_functions *api = &gl->api;
    const char *name = btf_texture_name(id);
    btf_result result = check_limits(api, name, texture, log);
    if (result != BTF_OK) {
        return result;
    }
    uint32_t target = texture->is_array ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D;
    uint32_t format[3] = {0};
    gl_format(texture->format, format);
    api->GenTextures(1, &gl->name[id]);
    gl->is_array[id] = texture->is_array;
    api->BindTexture(target, gl->name[id]);
    api->TexParameteri(target, GL_TEXTURE_MIN_FILTER,
                       (int32_t)(levels > 1 ? GL_NEAREST_MIPMAP_NEAREST : GL_NEAREST));
    api->TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    api->TexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    api->TexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    api->TexParameteri(target, GL_TEXTURE_BASE_LEVEL, 0);
    api->TexParameteri(target, GL_TEXTURE_MAX_LEVEL, (int32_t)levels - 1);
    for (uint32_t i = 0; i < levels; ++i) {
        const btf_texture *t = &texture[i];
        int32_t level = (int32_t)i, w = (int32_t)t->width, h = (int32_t)t->height, d = (int32_t)t->layers;
        if (t->is_array) {
            api->TexImage3D(target, level, (int32_t)format[0], w, h, d, 0, format[1], format[2], t->data);
        } else {
            api->TexImage2D(target, level, (int32_t)format[0], w, h, 0, format[1], format[2], t->data);
        }
        gl->bytes += btf_format_size(t->format) * t->width * t->height * t->layers;
    }
    uint32_t error = btfi_gl_errors(api);
    if (error != GL_NO_ERROR) {
        return btfi_fail(log, error == GL_OUT_OF_MEMORY ? BTF_ERROR_MEMORY : BTF_ERROR_UNSUPPORTED,
                         "%s: GL refuses %u x %u x %u texels with error 0x%04x", name, texture->width,
                         texture->height, texture->layers, error);
    }
    return BTF_OK;
}

/* The levels of a texture as they are uploaded; returns their number. */
static uint32_t list_levels(const btf_material *material, btf_texture_id id, uint32_t count,
                            uint32_t components, btf_texture *out_levels) {
    /* Components are stored four a layer, and units in whole layers, so that the first ones are a prefix. */
    const uint32_t groups = (components + 3) / 4;
    for (uint32_t i = 0; i < count; ++i) {
        out_levels[i] = btf_material_level_texture(material, i, id);
        if (out_levels[i].format == BTF_FORMAT_NONE) {
            return i;
        }
        if (id == BTF_TEXTURE_RESIDUAL_TEXELS) {
            out_levels[i].layers = groups;
        } else if (id == BTF_TEXTURE_RESIDUAL_DIRECTIONS) {
            out_levels[i].layers = 3 * groups;
        } else if (id == BTF_TEXTURE_FACTOR_TEXELS) {
            out_levels[i].layers = btfi_factor_layers(&material->info, components);
        } else if (id == BTF_TEXTURE_FACTOR_DIRECTIONS) {
            out_levels[i].layers = components;
        }
    }
    return count;
}

btf_result btf_gl_fits(const btf_material *material, const btf_gl_options *options, const btf_log *log,
                       int *out_fits) {
    btfi_gl_functions api;
    btf_material_info info = {.struct_size = sizeof info};
    *out_fits = 0;
    btf_result result = btfi_gl_load(options, log, &api);
    if (result == BTF_OK) {
        result = btf_material_get_info(material, &info);
    }
    if (result != BTF_OK) {
        return result;
    }
    const btf_shader_options *shader =
        options->struct_size > offsetof(btf_gl_options, shader) ? options->shader : NULL;
    uint32_t components;
    const uint32_t wanted = choose_textures(&info, shader, &components);
    *out_fits = 1;
    for (int id = 0; id < BTF_TEXTURE_COUNT; ++id) {
        btf_texture texture[BTF_MAX_LEVELS];
        if (wanted >> id & 1 && list_levels(material, (btf_texture_id)id, 1, components, texture) > 0 &&
            check_limits(&api, btf_texture_name((btf_texture_id)id), texture, NULL) != BTF_OK) {
            *out_fits = 0;
        }
    }
    return BTF_OK;
}

btf_result btf_gl_upload(const btf_material *material, const btf_gl_options *options, const btf_log *log,
                         btf_gl **out_gl) {
    *out_gl = NULL;
    btf_gl *gl = calloc(1, sizeof *gl);
    if (!gl) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "gl: out of memory");
    }
    const btfi_gl_functions *api = &gl->api;
    btf_result result = btfi_gl_load(options, log, &gl->api);
    btf_material_info info = {.struct_size = sizeof info};
    if (result == BTF_OK) {
        result = btf_material_get_info(material, &info);
    }
    if (result != BTF_OK) {
        free(gl);
        return result;
    }
    btfi_gl_errors(api);
    int32_t bound_2d = 0, bound_array = 0;
    btfi_gl_unpack unpack = {0};
    api->GetIntegerv(GL_TEXTURE_BINDING_2D, &bound_2d);
    api->GetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &bound_array);
    btfi_gl_save_unpack(api, &unpack);

    const btf_shader_options *shader =
        options->struct_size > offsetof(btf_gl_options, shader) ? options->shader : NULL;
    uint32_t components, wanted = choose_textures(&info, shader, &components);
    for (int id = 0; id < BTF_TEXTURE_COUNT && result == BTF_OK; ++id) {
        btf_texture texture[BTF_MAX_LEVELS];
        const uint32_t levels =
            wanted >> id & 1 ? list_levels(material, (btf_texture_id)id, info.levels, components, texture)
                             : 0;
        if (levels > 0) {
            result = upload(gl, (btf_texture_id)id, texture, levels, log);
        }
    }

    btfi_gl_restore_unpack(api, &unpack);
    api->BindTexture(GL_TEXTURE_2D, (uint32_t)bound_2d);
    api->BindTexture(GL_TEXTURE_2D_ARRAY, (uint32_t)bound_array);
    if (result != BTF_OK) {
        btf_gl_destroy(&gl);
    }
    *out_gl = gl;
    return result;
}

btf_result btf_gl_bind(btf_gl *gl, uint32_t program, uint32_t first_unit, const char *prefix,
                       const btf_log *log, uint32_t *out_units) {
    const btfi_gl_functions *api = &gl->api;
    btf_result result = BTF_OK;
    uint32_t units = 0;
    int32_t current = 0, active = 0, deleted = 0;
    api->GetIntegerv(GL_CURRENT_PROGRAM, &current);
    if (current) { /* one that was deleted is gone once another is current: it is not put back */
        api->GetProgramiv((uint32_t)current, GL_DELETE_STATUS, &deleted);
    }
    api->GetIntegerv(GL_ACTIVE_TEXTURE, &active);
    api->UseProgram(program);
    for (int id = 0; id < BTF_TEXTURE_COUNT && result == BTF_OK; ++id) {
        char name[96];
        snprintf(name, sizeof name, "%.48s_%s", prefix ? prefix : "btf",
                 btf_texture_name((btf_texture_id)id));
        int32_t location = api->GetUniformLocation(program, name);
        if (location < 0) {
            continue;
        }
        if (!gl->name[id]) {
            result = btfi_fail(log, BTF_ERROR_USAGE, "gl: program %u reads %s, which was not uploaded",
                               program, name);
            continue;
        }
        uint32_t unit = first_unit + units++;
        api->ActiveTexture(GL_TEXTURE0 + unit);
        api->BindTexture(gl->is_array[id] ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D, gl->name[id]);
        api->BindSampler(unit, 0);
        api->Uniform1i(location, (int32_t)unit);
    }
    api->UseProgram(deleted ? 0 : (uint32_t)current);
    api->ActiveTexture((uint32_t)active);
    if (out_units) {
        *out_units = units;
    }
    return result;
}

uint32_t btf_gl_texture(const btf_gl *gl, btf_texture_id id) {
    return (unsigned)id < BTF_TEXTURE_COUNT ? gl->name[id] : 0;
}

size_t btf_gl_bytes(const btf_gl *gl) {
    return gl->bytes;
}

void btf_gl_destroy(btf_gl **gl) {
    if (!gl || !*gl) {
        return;
    }
    for (int id = 0; id < BTF_TEXTURE_COUNT; ++id) {
        if ((*gl)->name[id]) {
            (*gl)->api.DeleteTextures(1, &(*gl)->name[id]);
        }
    }
    free(*gl);
    *gl = NULL;
}
