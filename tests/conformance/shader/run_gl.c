/* The decoder on OpenGL and OpenGL ES. See run_gl.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "run_gl.h"

#include "tests/conformance/gpu.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void print(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    fprintf(stderr, "%.2000s\n", message);
}

static GLuint upload(const gl_api *gl, const exported_texture *t, GLenum target) {
    GLuint texture;
    gl->GenTextures(1, &texture);
    gl->BindTexture(target, texture);
    gl->TexParameteri(target, GL_TEXTURE_MIN_FILTER,
                      t->data.levels > 1 ? GL_NEAREST_MIPMAP_NEAREST : GL_NEAREST);
    gl->TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->TexParameteri(target, GL_TEXTURE_MAX_LEVEL, (GLint)t->data.levels - 1);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (uint32_t i = 0; i < t->data.levels; i++) {
        const uint32_t w = t->data.width >> i ? t->data.width >> i : 1,
                       h = t->data.height >> i ? t->data.height >> i : 1;
        if (t->is_array) {
            gl->TexImage3D(target, (GLint)i, (GLint)t->gl_internal, (GLsizei)w, (GLsizei)h,
                           (GLsizei)t->data.layers, 0, t->gl_layout, t->gl_type, t->data.data[i]);
        } else {
            gl->TexImage2D(target, (GLint)i, (GLint)t->gl_internal, (GLsizei)w, (GLsizei)h, 0, t->gl_layout,
                           t->gl_type, t->data.data[i]);
        }
    }
    return texture;
}

/* An input of the grid has eight words. The shader's body derives the rest of a record from the pixel's position. */
static char *make_body(const exported *e) {
    static const char plain[] =
        "uvec4 check(uvec4 a, uvec4 b) {\n"
        "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x));\n"
        "    int level = int(uint(gl_FragCoord.x) %% %uu);\n"
        "    return uvec4(floatBitsToUint(%s_evaluate_level(uintBitsToFloat(a.xy), l, "
        "uintBitsToFloat(b.yzw), level)), 0u);\n"
        "}\n";
    static const char picked[] =
        "uvec4 check(uvec4 a, uvec4 b) {\n"
        "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x));\n"
        "    uvec2 x = uvec2(gl_FragCoord.xy);\n"
        "    float level = float(x.x %% %uu) + 0.25 * float(x.x / 16u %% 4u);\n"
        "    return uvec4(floatBitsToUint(%s_evaluate_stochastic_between(uintBitsToFloat(a.xy), l, "
        "uintBitsToFloat(b.yzw), level, %s_random(uvec3(x, 7u)))), 0u);\n"
        "}\n";
    static char body[1000];
    if (e->picks) {
        snprintf(body, sizeof body, picked, e->levels, e->prefix, e->prefix);
    } else {
        snprintf(body, sizeof body, plain, e->levels, e->prefix);
    }
    return body;
}

void run_gl(const char *name, const exported *e, uint32_t *records, size_t count) {
    const context_device *device = context_devices;
    const btf_log log = {print, NULL};
    while (device->name && strcmp(device->name, name) != 0) {
        device++;
    }
    if (!device->name) {
        fprintf(stderr, "no device '%s'\n", name);
        exit(1);
    }
    gpu *g = gpu_create_or_skip(device);
    const gl_api *gl = gpu_api(g);
    printf("%s\n", gpu_name(g));
    const unsigned program = gpu_program(g, NULL, (const char *)e->text, make_body(e), &log);
    if (!program) {
        exit(4);
    }
    /* Where the language has bindings the textures go where the manifest says, and no uniform is set. */
    const bool bound = !strcmp(e->language, "glsl450") || !strcmp(e->language, "essl310");
    gl->UseProgram(program);
    for (int i = 0; i < e->texture_count; i++) {
        const exported_texture *t = &e->textures[i];
        const uint32_t unit = bound ? t->binding : (uint32_t)(GPU_FIRST_UNIT + i);
        gl->ActiveTexture(GL_TEXTURE0 + unit);
        upload(gl, t, t->is_array ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D);
        if (!bound) {
            gl->Uniform1i(gl->GetUniformLocation(program, t->sampler), (GLint)unit);
        }
    }
    uint32_t *inputs = malloc(count * GPU_INPUTS * sizeof *inputs),
             *outputs = malloc(count * GPU_OUTPUTS * sizeof *outputs);
    if (!inputs || !outputs) {
        exit(4);
    }
    for (size_t i = 0; i < count; i++) {
        memcpy(inputs + i * GPU_INPUTS, records + i * RECORD, GPU_INPUTS * sizeof *inputs);
    }
    if (gpu_run(g, program, count, inputs, outputs, &log) != BTF_OK) {
        exit(4);
    }
    for (size_t i = 0; i < count; i++) {
        memcpy(records + i * RECORD + RESULT, outputs + i * GPU_OUTPUTS, 3 * sizeof *outputs);
    }
    free(inputs);
    free(outputs);
    gpu_destroy(&g);
}
