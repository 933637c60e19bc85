/* A framebuffer, an input texture and a full-screen triangle.
 *
 * SPDX-License-Identifier: MIT
 */
#include "gpu.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct gpu {
    const context_device *device;
    context *context;
    char name[200];
    uint32_t *padded; /* a full grid of inputs, then of outputs */
    GLuint inputs, outputs, framebuffer, array;
    gl_api api;
};

/* The reason why a device cannot be used, from the log. */
typedef struct reason {
    char *text;
    size_t size;
} reason;

static void keep_reason(void *user, btf_log_level level, const char *message) {
    const reason *r = user;
    (void)level;
    snprintf(r->text, r->size, "%s", message);
}

static bool load(gpu *g, char *why, size_t why_size) {
    reason r = {why, why_size};
    const btf_log log = {keep_reason, &r};
    return gl_api_load(&g->api, context_get_proc_address, g->context, &log) == BTF_OK;
}

static GLuint make_texture(gpu *g, int width, int height) {
    GLuint texture = 0;
    g->api.GenTextures(1, &texture);
    g->api.ActiveTexture(GL_TEXTURE0);
    g->api.BindTexture(GL_TEXTURE_2D, texture);
    g->api.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    g->api.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    g->api.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32UI, width, height, 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                      NULL);
    return texture;
}

gpu *gpu_create(const context_device *device, char *why, size_t why_size) {
    gpu *g = calloc(1, sizeof *g);
    size_t elements = (size_t)GPU_SIDE * GPU_SIDE;
    if (g) {
        g->padded = calloc(elements * (GPU_INPUTS + GPU_OUTPUTS), sizeof *g->padded);
    }
    if (!g || !g->padded) {
        snprintf(why, why_size, "out of memory");
        free(g);
        return NULL;
    }
    g->device = device;
    g->context = context_create(device, why, why_size);
    if (!g->context || !load(g, why, why_size)) {
        gpu_destroy(&g);
        return NULL;
    }
    snprintf(g->name, sizeof g->name, "%s, %s", (const char *)g->api.GetString(GL_RENDERER),
             (const char *)g->api.GetString(GL_VERSION));
    g->outputs = make_texture(g, GPU_SIDE, GPU_SIDE);
    g->inputs = make_texture(g, 2 * GPU_SIDE, GPU_SIDE);
    g->api.GenFramebuffers(1, &g->framebuffer);
    g->api.BindFramebuffer(GL_FRAMEBUFFER, g->framebuffer);
    g->api.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, g->outputs, 0);
    g->api.GenVertexArrays(1, &g->array);
    g->api.BindVertexArray(g->array);
    g->api.Viewport(0, 0, GPU_SIDE, GPU_SIDE);
    if (g->api.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE ||
        g->api.GetError() != GL_NO_ERROR) {
        snprintf(why, why_size, "%s refuses an RGBA32UI framebuffer", g->name);
        gpu_destroy(&g);
    }
    return g;
}

gpu *gpu_of_group;

int gpu_group_setup(void **state) {
    (void)state;
    gpu_of_group = gpu_create_or_skip(&context_devices[0]);
    return 0;
}

int gpu_group_teardown(void **state) {
    (void)state;
    gpu_destroy(&gpu_of_group);
    return 0;
}

gpu *gpu_create_or_skip(const context_device *device) {
    char why[300];
    context_prepare(device);
    gpu *made = gpu_create(device, why, sizeof why);
    if (!made) {
        fprintf(stderr, "skipped: %s\n", why);
        exit(77);
    }
    return made;
}

const char gpu_evaluate_body[] =
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    vec2 uv = uintBitsToFloat(a.xy);\n"
    "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x));\n"
    "    return uvec4(floatBitsToUint(btf_evaluate(uv, l, uintBitsToFloat(b.yzw))), 0u);\n"
    "}\n";

void gpu_destroy(gpu **g) {
    if (!g || !*g) {
        return;
    }
    context_destroy(&(*g)->context); /* with its programs and textures */
    free((*g)->padded);
    free(*g);
    *g = NULL;
}

const char *gpu_name(const gpu *g) {
    return g->name;
}

const gl_api *gpu_api(const gpu *g) {
    return &g->api;
}

btf_gl_options gpu_gl_options(gpu *g, const btf_shader_options *shader) {
    return (btf_gl_options){sizeof(btf_gl_options), context_get_proc_address, g->context, shader};
}

unsigned gpu_program(gpu *g, const char *preamble, const char *library, const char *body,
                     const btf_log *log) {
    static const char vertex_text[] = "void main() {\n"
                                      "    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0,\n"
                                      "                       gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);\n"
                                      "}\n";
    static const char interface_text[] = "precision highp float;\n"
                                         "precision highp int;\n"
                                         "uniform highp usampler2D check_inputs;\n"
                                         "out highp uvec4 check_result;\n";
    static const char main_text[] =
        "void main() {\n"
        "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
        "    check_result = check(texelFetch(check_inputs, ivec2(2 * at.x, at.y), 0),\n"
        "                         texelFetch(check_inputs, ivec2(2 * at.x + 1, at.y), 0));\n"
        "}\n";
    char version[120];
    snprintf(version, sizeof version, "#version %s\n%s", g->device->glsl,
             g->device->enable_gpu_shader5 ? "#extension GL_ARB_gpu_shader5 : require\n" : "");
    const char *vertex_parts[] = {vertex_text, NULL};
    const char *fragment_parts[] = {
        preamble ? preamble : "", interface_text, library, body, main_text, NULL};
    return gl_api_program(&g->api, version, vertex_parts, fragment_parts, log);
}

void gpu_delete_program(gpu *g, unsigned program) {
    g->api.DeleteProgram(program);
}

btf_result gpu_run(gpu *g, unsigned program, size_t count, const uint32_t *inputs, uint32_t *outputs,
                   const btf_log *log) {
    size_t elements = (size_t)GPU_SIDE * GPU_SIDE;
    GLsizei rows = (GLsizei)((count + GPU_SIDE - 1) / GPU_SIDE);
    uint32_t *read = g->padded + elements * GPU_INPUTS;
    memset(g->padded, 0, (size_t)rows * GPU_SIDE * GPU_INPUTS * sizeof *inputs);
    memcpy(g->padded, inputs, count * GPU_INPUTS * sizeof *inputs);
    g->api.ActiveTexture(GL_TEXTURE0);
    g->api.BindTexture(GL_TEXTURE_2D, g->inputs);
    g->api.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 2 * GPU_SIDE, rows, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                         g->padded);
    g->api.UseProgram(program);
    g->api.Uniform1i(g->api.GetUniformLocation(program, "check_inputs"), 0);
    g->api.Viewport(0, 0, GPU_SIDE, rows);
    g->api.DrawArrays(GL_TRIANGLES, 0, 3);
    g->api.ReadPixels(0, 0, GPU_SIDE, rows, GL_RGBA_INTEGER, GL_UNSIGNED_INT, read);
    g->api.UseProgram(0);
    memcpy(outputs, read, count * GPU_OUTPUTS * sizeof *outputs);
    GLenum error = g->api.GetError();
    if (error != GL_NO_ERROR) {
        char message[80];
        snprintf(message, sizeof message, "GL: error 0x%04x while drawing", error);
        if (log && log->callback) {
            log->callback(log->user, BTF_LOG_ERROR, message);
        }
        return BTF_ERROR_INTERNAL;
    }
    return BTF_OK;
}

btf_result gpu_draw(gpu *g, unsigned program, int side, int repeats) {
    g->api.ActiveTexture(GL_TEXTURE0);
    g->api.BindTexture(GL_TEXTURE_2D, g->inputs);
    g->api.UseProgram(program);
    g->api.Uniform1i(g->api.GetUniformLocation(program, "check_inputs"), 0);
    g->api.Viewport(0, 0, side, side);
    for (int i = 0; i < repeats; ++i) {
        g->api.DrawArrays(GL_TRIANGLES, 0, 3);
    }
    g->api.Finish();
    return g->api.GetError() == GL_NO_ERROR ? BTF_OK : BTF_ERROR_INTERNAL;
}
