/* The tables of light sampling as textures of the current GL context. See openbtf/sampling.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/gl_functions.h"
#include "decoder/result.h"

#include <openbtf/sampling.h>

#include <stdio.h>
#include <stdlib.h>

enum { TEXTURES = 2 };
static const char *const names[TEXTURES] = {"sampling_triangles", "sampling_densities"};

struct btf_gl_light_sampling {
    btfi_gl_functions api;
    uint32_t texture[TEXTURES];
    size_t bytes;
};

/* A table as GL takes it. */
typedef struct picture {
    uint32_t width, height, format[3]; /* internal format, format, type */
    size_t texel;
    const void *data;
} picture;

static btf_result upload(btf_gl_light_sampling *s, int i, const picture *p, const btf_log *log) {
    const btfi_gl_functions *api = &s->api;
    int32_t side = 0;
    api->GetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
    if ((int64_t)p->width > side || (int64_t)p->height > side) {
        return btfi_fail(log, BTF_ERROR_UNSUPPORTED, "%s: %u x %u texels exceed GL_MAX_TEXTURE_SIZE %d",
                         names[i], (unsigned)p->width, (unsigned)p->height, (int)side);
    }
    api->GenTextures(1, &s->texture[i]);
    api->BindTexture(GL_TEXTURE_2D, s->texture[i]);
    api->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    api->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    api->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    api->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    api->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_BASE_LEVEL, 0);
    api->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    api->TexImage2D(GL_TEXTURE_2D, 0, (int32_t)p->format[0], (int32_t)p->width, (int32_t)p->height, 0,
                    p->format[1], p->format[2], p->data);
    s->bytes += p->texel * p->width * p->height;
    const uint32_t error = btfi_gl_errors(api);
    if (error != GL_NO_ERROR) {
        return btfi_fail(log, error == GL_OUT_OF_MEMORY ? BTF_ERROR_MEMORY : BTF_ERROR_UNSUPPORTED,
                         "%s: GL refuses %u x %u texels with error 0x%04x", names[i], (unsigned)p->width,
                         (unsigned)p->height, (unsigned)error);
    }
    return BTF_OK;
}

btf_result btf_gl_light_sampling_create(const btf_light_sampling *sampling, const btf_gl_options *options,
                                        const btf_log *log, btf_gl_light_sampling **out_sampling) {
    if (out_sampling) {
        *out_sampling = NULL;
    }
    if (!sampling || !out_sampling) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "sampling: the pointer to the tables or to the result is NULL");
    }
    btf_gl_light_sampling *s = calloc(1, sizeof *s);
    if (!s) {
        return btfi_fail(log, BTF_ERROR_MEMORY, "sampling: out of memory");
    }
    btf_result result = btfi_gl_load(options, log, &s->api);
    if (result != BTF_OK) {
        free(s);
        return result;
    }
    const picture pictures[TEXTURES] = {
        {sampling->n_triangles,
         sampling->n_views + 1,
         {GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT},
         4 * sizeof(uint32_t),
         sampling->triangles},
        {sampling->n_lights + 1,
         sampling->n_views,
         {GL_R32F, GL_RED, GL_FLOAT},
         sizeof(float),
         sampling->densities},
    };
    int32_t bound = 0;
    btfi_gl_unpack unpack = {0};
    btfi_gl_errors(&s->api);
    s->api.GetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
    btfi_gl_save_unpack(&s->api, &unpack);
    for (int i = 0; i < TEXTURES && result == BTF_OK; ++i) {
        result = upload(s, i, &pictures[i], log);
    }
    btfi_gl_restore_unpack(&s->api, &unpack);
    s->api.BindTexture(GL_TEXTURE_2D, (uint32_t)bound);
    if (result != BTF_OK) {
        btf_gl_light_sampling_destroy(&s);
    }
    *out_sampling = s;
    return result;
}

void btf_gl_light_sampling_bind(btf_gl_light_sampling *sampling, uint32_t program, uint32_t first_unit,
                                const char *prefix, uint32_t *out_units) {
    const btfi_gl_functions *api = &sampling->api;
    uint32_t units = 0;
    int32_t current = 0, active = 0, deleted = 0;
    api->GetIntegerv(GL_CURRENT_PROGRAM, &current);
    if (current) { /* a deleted program cannot be put back: as in btf_gl_bind */
        api->GetProgramiv((uint32_t)current, GL_DELETE_STATUS, &deleted);
    }
    api->GetIntegerv(GL_ACTIVE_TEXTURE, &active);
    api->UseProgram(program);
    for (int i = 0; i < TEXTURES; ++i) {
        char name[96];
        snprintf(name, sizeof name, "%.48s_%s", prefix ? prefix : "btf", names[i]);
        const int32_t location = api->GetUniformLocation(program, name);
        if (location < 0) {
            continue;
        }
        const uint32_t unit = first_unit + units++;
        api->ActiveTexture(GL_TEXTURE0 + unit);
        api->BindTexture(GL_TEXTURE_2D, sampling->texture[i]);
        api->BindSampler(unit, 0);
        api->Uniform1i(location, (int32_t)unit);
    }
    api->UseProgram(deleted ? 0 : (uint32_t)current);
    api->ActiveTexture((uint32_t)active);
    if (out_units) {
        *out_units = units;
    }
}

size_t btf_gl_light_sampling_bytes(const btf_gl_light_sampling *sampling) {
    return sampling->bytes;
}

void btf_gl_light_sampling_destroy(btf_gl_light_sampling **sampling) {
    if (!sampling || !*sampling) {
        return;
    }
    for (int i = 0; i < TEXTURES; ++i) {
        if ((*sampling)->texture[i]) {
            (*sampling)->api.DeleteTextures(1, &(*sampling)->texture[i]);
        }
    }
    free(*sampling);
    *sampling = NULL;
}
