/* Runs the GLSL self-test on the current context: four pixels into an RGBA32UI framebuffer, state restored.
 *
 * SPDX-License-Identifier: MIT
 */
#include "gl_functions.h"
#include "result.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The state that drawing touches: first that of every context, then what desktop ones add, then what
 * compatibility ones add. */
static const uint32_t capabilities[] = {
    GL_CULL_FACE,
    GL_DEPTH_TEST,
    GL_STENCIL_TEST,
    GL_SCISSOR_TEST,
    GL_RASTERIZER_DISCARD,
    GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_SAMPLE_COVERAGE,
    GL_COLOR_LOGIC_OP,
    GL_CLIP_DISTANCE0,
    GL_CLIP_DISTANCE0 + 1,
    GL_CLIP_DISTANCE0 + 2,
    GL_CLIP_DISTANCE0 + 3,
    GL_CLIP_DISTANCE0 + 4,
    GL_CLIP_DISTANCE0 + 5,
    GL_CLIP_DISTANCE0 + 6,
    GL_CLIP_DISTANCE0 + 7,
    GL_POLYGON_STIPPLE,
    GL_ALPHA_TEST,
};
enum { CAPABILITY_COUNT = sizeof capabilities / sizeof *capabilities, PACK_COUNT = 4 };
enum { COMPATIBILITY_CAPABILITIES = 2, DESKTOP_CAPABILITIES = 9 }; /* so many of them, from the end */
enum { SIDE = 2 }; /* of the framebuffer: pixels are drawn in such blocks */
static const uint32_t pack_names[PACK_COUNT] = {GL_PACK_SWAP_BYTES, GL_PACK_ROW_LENGTH, GL_PACK_SKIP_ROWS,
                                                GL_PACK_SKIP_PIXELS};

typedef struct state {
    uint8_t enabled[CAPABILITY_COUNT], mask[4];
    int32_t polygon_mode[2]; /* front, back; core contexts have one mode, and may fill in only the first */
    int32_t viewport[4], draw, read, array, program, texture, texture_array, unit, sampler, pack_buffer,
        pack[PACK_COUNT];
    btfi_gl_unpack unpack;
} state;

static int capability_count(const btfi_gl_functions *gl) {
    return CAPABILITY_COUNT - (gl->is_compatibility ? 0 : COMPATIBILITY_CAPABILITIES) -
           (gl->is_es ? DESKTOP_CAPABILITIES : 0);
}

static void save_polygon_mode(const btfi_gl_functions *gl, state *s) {
    if (gl->is_es)
        return;
    gl->GetIntegerv(GL_POLYGON_MODE, s->polygon_mode);
    gl->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

static void restore_polygon_mode(const btfi_gl_functions *gl, const state *s) {
    if (gl->is_es)
        return;
    gl->PolygonMode(GL_FRONT_AND_BACK, (uint32_t)s->polygon_mode[0]);
    if (gl->is_compatibility && s->polygon_mode[1] != s->polygon_mode[0])
        gl->PolygonMode(GL_BACK, (uint32_t)s->polygon_mode[1]);
}

static void save_state(const btfi_gl_functions *gl, state *s) {
    for (int i = 0; i < capability_count(gl); ++i) {
        s->enabled[i] = gl->IsEnabled(capabilities[i]);
        gl->Disable(capabilities[i]);
    }
    save_polygon_mode(gl, s);
    gl->GetBooleanv(GL_COLOR_WRITEMASK, s->mask);
    gl->ColorMask(1, 1, 1, 1);
    gl->GetIntegerv(GL_VIEWPORT, s->viewport);
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
    for (int i = gl->is_es; i < PACK_COUNT; ++i) {
        gl->GetIntegerv(pack_names[i], &s->pack[i]);
        gl->PixelStorei(pack_names[i], 0);
    }
}

static void restore_state(const btfi_gl_functions *gl, const state *s) {
    for (int i = gl->is_es; i < PACK_COUNT; ++i)
        gl->PixelStorei(pack_names[i], s->pack[i]);
    btfi_gl_restore_unpack(gl, &s->unpack);
    gl->BindBuffer(GL_PIXEL_PACK_BUFFER, (uint32_t)s->pack_buffer);
    gl->BindTexture(GL_TEXTURE_2D, (uint32_t)s->texture);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, (uint32_t)s->texture_array);
    gl->BindSampler((uint32_t)s->unit, (uint32_t)s->sampler);
    gl->UseProgram((uint32_t)s->program);
    gl->BindVertexArray((uint32_t)s->array);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, (uint32_t)s->read);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, (uint32_t)s->draw);
    gl->Viewport(s->viewport[0], s->viewport[1], s->viewport[2], s->viewport[3]);
    gl->ColorMask(s->mask[0], s->mask[1], s->mask[2], s->mask[3]);
    restore_polygon_mode(gl, s);
    for (int i = 0; i < capability_count(gl); ++i)
        if (s->enabled[i])
            gl->Enable(capabilities[i]);
}

static uint32_t compile(const btfi_gl_functions *gl, uint32_t kind, int count, const char *const *text,
                        const btf_log *log) {
    uint32_t shader = gl->CreateShader(kind);
    int32_t ok = 0;
    gl->ShaderSource(shader, count, text, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (!ok) {
        char message[400] = "";
        gl->GetShaderInfoLog(shader, (int32_t)sizeof message, NULL, message);
        btfi_fail(log, BTF_ERROR_UNSUPPORTED, "gl: the self-test does not compile: %s", message);
        gl->DeleteShader(shader);
        return 0;
    }
    return shader;
}

/* The program of one pass, of the version and the two other pieces of its fragment shader; 0 when GL
 * refuses it. */
static uint32_t make_program(const btfi_gl_functions *gl, const char *const fragment_parts[4],
                             const btf_log *log) {
    static const char vertex_text[] = "void main() {\n"
                                      "    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0,\n"
                                      "                       gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);\n"
                                      "}\n";
    const char *vertex_parts[] = {fragment_parts[0], vertex_text};
    uint32_t vertex = compile(gl, GL_VERTEX_SHADER, 2, vertex_parts, log);
    uint32_t fragment = vertex ? compile(gl, GL_FRAGMENT_SHADER, 4, fragment_parts, log) : 0;
    uint32_t program = 0;
    if (fragment) {
        int32_t ok = 0;
        program = gl->CreateProgram();
        gl->AttachShader(program, vertex);
        gl->AttachShader(program, fragment);
        gl->LinkProgram(program);
        gl->GetProgramiv(program, GL_LINK_STATUS, &ok);
        if (!ok) {
            btfi_fail(log, BTF_ERROR_UNSUPPORTED, "gl: the self-test does not link");
            gl->DeleteProgram(program);
            program = 0;
        }
    }
    if (fragment)
        gl->DeleteShader(fragment);
    if (vertex)
        gl->DeleteShader(vertex);
    return program;
}

/* Draws the pixels and reads them. `unit` is that of the sampler, if there is one. */
static btf_result run_program(const btfi_gl_functions *gl, uint32_t program, int32_t unit,
                              const btf_log *log, uint32_t *failures) {
    if (!program)
        return BTF_ERROR_UNSUPPORTED;
    uint32_t pixels[SIDE * SIDE][4] = {{0}};
    gl->UseProgram(program);
    int32_t location = gl->GetUniformLocation(program, "btf_texels");
    if (location >= 0)
        gl->Uniform1i(location, unit);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->ReadPixels(0, 0, SIDE, SIDE, GL_RGBA_INTEGER, GL_UNSIGNED_INT, pixels);
    gl->DeleteProgram(program);
    uint32_t error = btfi_gl_errors(gl);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        if (error != GL_NO_ERROR || pixels[i][1] != 0x42544621u)
            return btfi_fail(log, BTF_ERROR_UNSUPPORTED,
                             "gl: the context did not draw the self-test (GL error 0x%04x)", error);
        *failures |= pixels[i][0];
    }
    return BTF_OK;
}

static btf_result run_arithmetic(const btfi_gl_functions *gl, const char *version, int without_precise,
                                 const btf_log *log, uint32_t *failures) {
    static const char main_text[] = "uniform highp uint btf_runtime_zero;\n"
                                    "out highp uvec4 btf_result;\n"
                                    "void main() {\n"
                                    "    uint zero = btf_runtime_zero ^ (uint(gl_FragCoord.x) >> 1u);\n"
                                    "    btf_result = uvec4(btf_self_test(zero), 0x42544621u, 0u, 0u);\n"
                                    "}\n";
    const char *parts[] = {version, without_precise ? "#define BTF_HAVE_PRECISE 0\n" : "",
                           btf_shader_self_test(), main_text};
    return run_program(gl, make_program(gl, parts, log), 0, log, failures);
}

/* Four neighbouring pixels fetch from different mip levels, together and while the first of them rests
 * (Mesa's softpipe takes the first one's level for all, what it may be). */
static btf_result run_levels(const btfi_gl_functions *gl, const char *version, int32_t unit,
                             const btf_log *log, uint32_t *failures) {
    static const char head_text[] = "precision highp float;\n"
                                    "precision highp int;\n"
                                    "uniform highp usampler2D btf_texels;\n"
                                    "out highp uvec4 btf_result;\n";
    static const char main_text[] =
        "uint wrong(int level) {\n"
        "    return texelFetch(btf_texels, ivec2(0), level).x ^ (0x1234567u << uint(level));\n"
        "}\n"
        "void main() {\n"
        "    ivec2 p = ivec2(gl_FragCoord.xy);\n"
        "    uint sum = wrong((p.x + 2 * p.y) % 3);\n"
        "    if (p.x + p.y > 0)\n"
        "        sum |= wrong(2 - p.x - p.y) | wrong(0);\n"
        "    btf_result = uvec4(sum != 0u ? 128u : 0u, 0x42544621u, 0u, 0u);\n"
        "}\n";
    uint32_t texture = 0;
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST_MIPMAP_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 2);
    for (int32_t level = 0; level < 3; ++level) {
        uint32_t texels[16][4];
        for (int i = 0; i < 16; ++i)
            texels[i][0] = texels[i][1] = texels[i][2] = texels[i][3] = 0x1234567u << level;
        gl->TexImage2D(GL_TEXTURE_2D, level, GL_RGBA32UI, 4 >> level, 4 >> level, 0, GL_RGBA_INTEGER,
                       GL_UNSIGNED_INT, texels);
    }
    const char *parts[] = {version, head_text, "", main_text};
    btf_result result = run_program(gl, make_program(gl, parts, log), unit, log, failures);
    gl->DeleteTextures(1, &texture);
    return result;
}

/* Four neighbouring pixels fetch texels of 128 bits from different layers of an array, as factors do. */
static btf_result run_array(const btfi_gl_functions *gl, const char *version, int32_t unit,
                            const btf_log *log, uint32_t *failures) {
    static const char head_text[] = "precision highp float;\n"
                                    "precision highp int;\n"
                                    "uniform highp usampler2DArray btf_texels;\n"
                                    "out highp uvec4 btf_result;\n";
    static const char main_text[] =
        "void main() {\n"
        "    ivec2 p = ivec2(gl_FragCoord.xy);\n"
        "    uvec4 wrong = uvec4(0u);\n"
        "    for (int i = 0; i < 3; ++i) {\n"
        "        ivec3 at = ivec3(p, (p.x + 2 * p.y + i) % 3);\n"
        "        uint texel = uint(4 * (2 * (2 * at.z + at.y) + at.x));\n"
        "        wrong |= texelFetch(btf_texels, at, 0) ^ (uvec4(texel) + uvec4(1u, 2u, 3u, 4u)) * "
        "0x9E3779B9u;\n"
        "    }\n"
        "    btf_result = uvec4(wrong != uvec4(0u) ? 256u : 0u, 0x42544621u, 0u, 0u);\n"
        "}\n";
    uint32_t texture = 0, words[3 * SIDE * SIDE * 4];
    for (uint32_t i = 0; i < sizeof words / sizeof *words; ++i)
        words[i] = (i + 1) * 0x9E3779B9u;
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, texture);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, 0);
    gl->TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA32UI, SIDE, SIDE, 3, 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                   words);
    const char *parts[] = {version, head_text, "", main_text};
    btf_result result = run_program(gl, make_program(gl, parts, log), unit, log, failures);
    gl->DeleteTextures(1, &texture);
    return result;
}

/* Four neighbouring pixels fetch half a byte and then the layer that it names, as lists of points do. */
static btf_result run_lists(const btfi_gl_functions *gl, const char *version, int32_t unit, const btf_log *log,
                            uint32_t *failures) {
    static const char head_text[] = "precision highp float;\n"
                                    "precision highp int;\n"
                                    "uniform highp usampler2DArray btf_texels;\n"
                                    "out highp uvec4 btf_result;\n";
    static const char main_text[] =
        "void main() {\n"
        "    uvec2 p = uvec2(gl_FragCoord.xy);\n"
        "    uint wrong = 0u;\n"
        "    for (uint view = 0u; view < 3u; ++view) {\n"
        "        uint layer = (texelFetch(btf_texels, ivec3(p, view >> 1u), 0).x >> ((view & 1u) << 2u)) & 15u;\n"
        "        uvec2 bytes = texelFetch(btf_texels, ivec3(p, layer), 0).xy;\n"
        "        uint named = 2u + (p.x + 2u * p.y + 5u * view) % 14u;\n"
        "        wrong |= layer ^ named;\n"
        "        wrong |= (bytes.x + 256u * bytes.y) ^ ((named * 4u + p.y * 2u + p.x) * 1021u & 0xFFFFu);\n"
        "    }\n"
        "    btf_result = uvec4(wrong != 0u ? 512u : 0u, 0x42544621u, 0u, 0u);\n"
        "}\n";
    enum { LAYERS = 16 };
    uint8_t bytes[LAYERS][SIDE * SIDE][2] = {{{0}}};
    for (uint32_t i = 0; i < SIDE * SIDE; ++i) {
        for (uint32_t view = 0; view < 3; ++view)
            bytes[view / 2][i][0] |= (uint8_t)((2 + (i + 5 * view) % 14) << 4 * (view % 2));
        for (uint32_t layer = 2; layer < LAYERS; ++layer) {
            const uint32_t word = (layer * SIDE * SIDE + i) * 1021;
            bytes[layer][i][0] = (uint8_t)word;
            bytes[layer][i][1] = (uint8_t)(word >> 8);
        }
    }
    uint32_t texture = 0;
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, texture);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, 0);
    gl->TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RG8UI, SIDE, SIDE, LAYERS, 0, GL_RG_INTEGER, GL_UNSIGNED_BYTE, bytes);
    const char *parts[] = {version, head_text, "", main_text};
    btf_result result = run_program(gl, make_program(gl, parts, log), unit, log, failures);
    gl->DeleteTextures(1, &texture);
    return result;
}

btf_result btf_gl_self_test(const btf_gl_options *options, const btf_log *log, uint32_t *out_failures) {
    *out_failures = 0;
    btfi_gl_functions api;
    btf_result result = btfi_gl_load(options, log, &api);
    if (result != BTF_OK)
        return result;
    btfi_gl_errors(&api);
    state saved;
    save_state(&api, &saved);

    uint32_t texture = 0, framebuffer = 0, array = 0;
    api.GenTextures(1, &texture);
    api.BindTexture(GL_TEXTURE_2D, texture);
    api.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    api.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    api.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32UI, SIDE, SIDE, 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT, NULL);
    api.GenFramebuffers(1, &framebuffer);
    api.BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    api.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
    api.FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    api.GenVertexArrays(1, &array);
    api.BindVertexArray(array);
    api.Viewport(0, 0, SIDE, SIDE);
    if (api.CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        result = btfi_fail(log, BTF_ERROR_UNSUPPORTED,
                           "gl: the context refuses a framebuffer of format RGBA32UI");

    char version[32];
    if (api.is_es)
        snprintf(version, sizeof version, "#version 3%d0 es\n", api.minor > 2 ? 2 : api.minor);
    else
        snprintf(version, sizeof version, "#version %d%d0 core\n", api.major, api.minor);
    int has_precise = api.is_es ? 10 * api.major + api.minor >= 32 : api.major >= 4;
    if (result == BTF_OK)
        result = run_arithmetic(&api, version, 1, log, out_failures);
    if (result == BTF_OK && has_precise)
        result = run_arithmetic(&api, version, 0, log, out_failures);
    if (result == BTF_OK)
        result = run_levels(&api, version, saved.unit, log, out_failures);
    if (result == BTF_OK)
        result = run_array(&api, version, saved.unit, log, out_failures);
    if (result == BTF_OK)
        result = run_lists(&api, version, saved.unit, log, out_failures);

    api.DeleteVertexArrays(1, &array);
    api.DeleteFramebuffers(1, &framebuffer);
    restore_state(&api, &saved);
    api.DeleteTextures(1, &texture);
    return result;
}
