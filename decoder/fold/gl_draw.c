/* Draws in a GL context of the caller's: programs, and saving and restoring all state that drawing changes.
 *
 * SPDX-License-Identifier: MIT
 */
#include "gl_draw.h"
#include "decoder/result.h"

#include <stdbool.h>
#include <stdio.h>

/* The state that drawing touches: first that of every context, then what desktop ones add, then what
 * compatibility ones add. */
static const uint32_t capabilities[] = {
    GL_CULL_FACE,          GL_DEPTH_TEST,         GL_STENCIL_TEST,
    GL_SCISSOR_TEST,       GL_RASTERIZER_DISCARD, GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_SAMPLE_COVERAGE,    GL_COLOR_LOGIC_OP,     GL_CLIP_DISTANCE0,
    GL_CLIP_DISTANCE0 + 1, GL_CLIP_DISTANCE0 + 2, GL_CLIP_DISTANCE0 + 3,
    GL_CLIP_DISTANCE0 + 4, GL_CLIP_DISTANCE0 + 5, GL_CLIP_DISTANCE0 + 6,
    GL_CLIP_DISTANCE0 + 7, GL_POLYGON_STIPPLE,    GL_ALPHA_TEST,
};
_Static_assert(sizeof capabilities / sizeof *capabilities == BTFI_CAPABILITY_COUNT, "one flag each");
enum { COMPATIBILITY_CAPABILITIES = 2, DESKTOP_CAPABILITIES = 9 }; /* counted from the end of the list */
static const uint32_t pack_names[BTFI_PACK_COUNT] = {GL_PACK_SWAP_BYTES, GL_PACK_ROW_LENGTH,
                                                     GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS};

static int capability_count(const btfi_gl_functions *gl) {
    return BTFI_CAPABILITY_COUNT - (gl->is_compatibility ? 0 : COMPATIBILITY_CAPABILITIES) -
           (gl->is_es ? DESKTOP_CAPABILITIES : 0);
}

/* True for the scissor test where each viewport has its own: then that of the first one is meant. */
static bool is_indexed(const btfi_gl_functions *gl, uint32_t capability) {
    return capability == GL_SCISSOR_TEST && gl->ViewportIndexedf;
}

static void enable(const btfi_gl_functions *gl, uint32_t capability) {
    if (is_indexed(gl, capability)) {
        gl->Enablei(capability, 0);
    } else {
        gl->Enable(capability);
    }
}

static void disable(const btfi_gl_functions *gl, uint32_t capability) {
    if (is_indexed(gl, capability)) {
        gl->Disablei(capability, 0);
    } else {
        gl->Disable(capability);
    }
}

static void set_mask(const btfi_gl_functions *gl, const uint8_t mask[4]) {
    if (gl->ColorMaski) {
        gl->ColorMaski(0, mask[0], mask[1], mask[2], mask[3]);
    } else {
        gl->ColorMask(mask[0], mask[1], mask[2], mask[3]);
    }
}

static void save_viewport(const btfi_gl_functions *gl, float out[4]) {
    int32_t whole[4];
    if (gl->ViewportIndexedf) {
        gl->GetFloati_v(GL_VIEWPORT, 0, out);
        return;
    }
    gl->GetIntegerv(GL_VIEWPORT, whole);
    for (int i = 0; i < 4; ++i) {
        out[i] = (float)whole[i];
    }
}

static void set_viewport(const btfi_gl_functions *gl, const float v[4]) {
    if (gl->ViewportIndexedf) {
        gl->ViewportIndexedf(0, v[0], v[1], v[2], v[3]);
    } else {
        gl->Viewport((int32_t)v[0], (int32_t)v[1], (int32_t)v[2], (int32_t)v[3]);
    }
}

void btfi_gl_viewport(const btfi_gl_functions *gl, uint32_t width, uint32_t height) {
    const float all[4] = {0, 0, (float)width, (float)height};
    set_viewport(gl, all);
}

static void save_polygon_mode(const btfi_gl_functions *gl, btfi_gl_state *s) {
    if (gl->is_es) {
        return;
    }
    gl->GetIntegerv(GL_POLYGON_MODE, s->polygon_mode);
    gl->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

static void restore_polygon_mode(const btfi_gl_functions *gl, const btfi_gl_state *s) {
    if (gl->is_es) {
        return;
    }
    gl->PolygonMode(GL_FRONT_AND_BACK, (uint32_t)s->polygon_mode[0]);
    if (gl->is_compatibility && s->polygon_mode[1] != s->polygon_mode[0]) {
        gl->PolygonMode(GL_BACK, (uint32_t)s->polygon_mode[1]);
    }
}

void btfi_gl_save_state(const btfi_gl_functions *gl, btfi_gl_state *s) {
    for (int i = 0; i < capability_count(gl); ++i) {
        s->enabled[i] = gl->IsEnabled(capabilities[i]);
        disable(gl, capabilities[i]);
    }
    save_polygon_mode(gl, s);
    gl->GetBooleanv(GL_COLOR_WRITEMASK, s->mask);
    static const uint8_t all[4] = {1, 1, 1, 1};
    set_mask(gl, all);
    save_viewport(gl, s->viewport);
    gl->GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &s->draw);
    gl->GetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &s->read);
    gl->GetIntegerv(GL_VERTEX_ARRAY_BINDING, &s->array);
    gl->GetIntegerv(GL_CURRENT_PROGRAM, &s->program);
    gl->GetIntegerv(GL_TEXTURE_BINDING_2D, &s->texture);
    gl->GetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &s->texture_array);
    gl->GetIntegerv(GL_ACTIVE_TEXTURE, &s->unit);
    s->unit -= GL_TEXTURE0;
    gl->GetIntegerv(GL_SAMPLER_BINDING, &s->sampler);
    gl->BindSampler((uint32_t)s->unit, 0);
    gl->GetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &s->pack_buffer);
    gl->BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    btfi_gl_save_unpack(gl, &s->unpack);
    for (int i = gl->is_es; i < BTFI_PACK_COUNT; ++i) {
        gl->GetIntegerv(pack_names[i], &s->pack[i]);
        gl->PixelStorei(pack_names[i], 0);
    }
}

void btfi_gl_restore_state(const btfi_gl_functions *gl, const btfi_gl_state *s) {
    for (int i = gl->is_es; i < BTFI_PACK_COUNT; ++i) {
        gl->PixelStorei(pack_names[i], s->pack[i]);
    }
    btfi_gl_restore_unpack(gl, &s->unpack);
    gl->BindBuffer(GL_PIXEL_PACK_BUFFER, (uint32_t)s->pack_buffer);
    gl->BindTexture(GL_TEXTURE_2D, (uint32_t)s->texture);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, (uint32_t)s->texture_array);
    gl->BindSampler((uint32_t)s->unit, (uint32_t)s->sampler);
    gl->UseProgram((uint32_t)s->program);
    gl->BindVertexArray((uint32_t)s->array);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, (uint32_t)s->read);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, (uint32_t)s->draw);
    set_viewport(gl, s->viewport);
    set_mask(gl, s->mask);
    restore_polygon_mode(gl, s);
    for (int i = 0; i < capability_count(gl); ++i) {
        if (s->enabled[i]) {
            enable(gl, capabilities[i]);
        }
    }
}

static uint32_t compile(const btfi_gl_functions *gl, uint32_t kind, int count, const char *const *text,
                        const char *what, const btf_log *log) {
    uint32_t shader = gl->CreateShader(kind);
    int32_t ok = 0;
    gl->ShaderSource(shader, count, text, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (!ok) {
        char message[400] = "";
        gl->GetShaderInfoLog(shader, (int32_t)sizeof message, NULL, message);
        btfi_fail(log, BTF_ERROR_UNSUPPORTED, "gl: the %s does not compile: %s", what, message);
        gl->DeleteShader(shader);
        return 0;
    }
    return shader;
}

uint32_t btfi_gl_program(const btfi_gl_functions *gl, int count, const char *const *fragment_parts,
                         const char *what, const btf_log *log) {
    static const char vertex_text[] = "void main() {\n"
                                      "    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0,\n"
                                      "                       gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);\n"
                                      "}\n";
    const char *vertex_parts[] = {fragment_parts[0], vertex_text};
    uint32_t vertex = compile(gl, GL_VERTEX_SHADER, 2, vertex_parts, what, log);
    uint32_t fragment = vertex ? compile(gl, GL_FRAGMENT_SHADER, count, fragment_parts, what, log) : 0;
    uint32_t program = 0;
    if (fragment) {
        int32_t ok = 0;
        program = gl->CreateProgram();
        gl->AttachShader(program, vertex);
        gl->AttachShader(program, fragment);
        gl->LinkProgram(program);
        gl->GetProgramiv(program, GL_LINK_STATUS, &ok);
        if (!ok) {
            btfi_fail(log, BTF_ERROR_UNSUPPORTED, "gl: the %s does not link", what);
            gl->DeleteProgram(program);
            program = 0;
        }
    }
    if (fragment) {
        gl->DeleteShader(fragment);
    }
    if (vertex) {
        gl->DeleteShader(vertex);
    }
    return program;
}

void btfi_gl_version(const btfi_gl_functions *gl, char *out_line, size_t size) {
    if (gl->is_es) {
        snprintf(out_line, size, "#version 3%d0 es\n", gl->minor > 2 ? 2 : gl->minor);
    } else {
        snprintf(out_line, size, "#version %d%d0 core\n", gl->major, gl->minor);
    }
}
