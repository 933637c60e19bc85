/* Runs the GLSL self-test on the current context: four pixels into an RGBA32UI framebuffer, state restored.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/fold/gl_draw.h"
#include "gl_functions.h"
#include "result.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 2 }; /* of the framebuffer: pixels are drawn in such blocks */

/* Draws the pixels and reads them. `unit` is that of the sampler, if there is one. */
static btf_result run_program(const btfi_gl_functions *gl, uint32_t program, int32_t unit,
                              const btf_log *log, uint32_t *failures) {
    if (!program) {
        return BTF_ERROR_UNSUPPORTED;
    }
    uint32_t pixels[SIDE * SIDE][4] = {{0}};
    gl->UseProgram(program);
    int32_t location = gl->GetUniformLocation(program, "btf_texels");
    if (location >= 0) {
        gl->Uniform1i(location, unit);
    }
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->ReadPixels(0, 0, SIDE, SIDE, GL_RGBA_INTEGER, GL_UNSIGNED_INT, pixels);
    gl->DeleteProgram(program);
    uint32_t error = btfi_gl_errors(gl);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        if (error != GL_NO_ERROR || pixels[i][1] != 0x42544621u) {
            return btfi_fail(log, BTF_ERROR_UNSUPPORTED,
                             "gl: the context did not draw the self-test (GL error 0x%04x)", error);
        }
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
    return run_program(gl, btfi_gl_program(gl, 4, parts, "self-test", log), 0, log, failures);
}

/* A new texture of so many mip levels, bound, for fetches of single texels. */
static uint32_t make_texture(const btfi_gl_functions *gl, uint32_t target, int32_t levels) {
    uint32_t texture = 0;
    gl->GenTextures(1, &texture);
    gl->BindTexture(target, texture);
    gl->TexParameteri(target, GL_TEXTURE_MIN_FILTER, levels > 1 ? GL_NEAREST_MIPMAP_NEAREST : GL_NEAREST);
    gl->TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->TexParameteri(target, GL_TEXTURE_MAX_LEVEL, levels - 1);
    return texture;
}

/* Runs a program that fetches from the sampler btf_texels, a `sampler` ("usampler2D"), and deletes the texture. */
static btf_result run_with_texture(const btfi_gl_functions *gl, const char *version, const char *sampler,
                                   const char *main_text, uint32_t texture, int32_t unit,
                                   const btf_log *log, uint32_t *failures) {
    const char *parts[] = {version,
                           "precision highp float;\n"
                           "precision highp int;\n"
                           "out highp uvec4 btf_result;\n"
                           "uniform highp ",
                           sampler, " btf_texels;\n", main_text};
    const uint32_t program = btfi_gl_program(gl, 5, parts, "self-test", log);
    const btf_result result = run_program(gl, program, unit, log, failures);
    gl->DeleteTextures(1, &texture);
    return result;
}

/* Four neighbouring pixels fetch from different mip levels, first all together, then behind a branch that the first
 * pixel does not take (Mesa's softpipe fetches for all four from the first pixel's level, even where that one is
 * masked). */
static btf_result run_levels(const btfi_gl_functions *gl, const char *version, int32_t unit,
                             const btf_log *log, uint32_t *failures) {
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
    enum { LEVELS = 3 };
    const uint32_t texture = make_texture(gl, GL_TEXTURE_2D, LEVELS);
    for (int32_t level = 0; level < LEVELS; ++level) {
        uint32_t texels[16][4];
        for (int i = 0; i < 16; ++i) {
            texels[i][0] = texels[i][1] = texels[i][2] = texels[i][3] = 0x1234567u << level;
        }
        gl->TexImage2D(GL_TEXTURE_2D, level, GL_RGBA32UI, 4 >> level, 4 >> level, 0, GL_RGBA_INTEGER,
                       GL_UNSIGNED_INT, texels);
    }
    return run_with_texture(gl, version, "usampler2D", main_text, texture, unit, log, failures);
}

/* Four neighbouring pixels fetch texels of 128 bits from different layers of an array, as factors do. */
static btf_result run_array(const btfi_gl_functions *gl, const char *version, int32_t unit,
                            const btf_log *log, uint32_t *failures) {
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
    uint32_t words[3 * SIDE * SIDE * 4];
    for (uint32_t i = 0; i < sizeof words / sizeof *words; ++i) {
        words[i] = (i + 1) * 0x9E3779B9u;
    }
    const uint32_t texture = make_texture(gl, GL_TEXTURE_2D_ARRAY, 1);
    gl->TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA32UI, SIDE, SIDE, 3, 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                   words);
    return run_with_texture(gl, version, "usampler2DArray", main_text, texture, unit, log, failures);
}

/* Four neighbouring pixels fetch half a byte and then the layer that it names, as lists of points do. */
static btf_result run_lists(const btfi_gl_functions *gl, const char *version, int32_t unit,
                            const btf_log *log, uint32_t *failures) {
    static const char main_text[] =
        "void main() {\n"
        "    uvec2 p = uvec2(gl_FragCoord.xy);\n"
        "    uint wrong = 0u;\n"
        "    for (uint view = 0u; view < 3u; ++view) {\n"
        "        uint layer = (texelFetch(btf_texels, ivec3(p, view >> 1u), 0).x >> ((view & 1u) << 2u)) & "
        "15u;\n"
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
        for (uint32_t view = 0; view < 3; ++view) {
            bytes[view / 2][i][0] |= (uint8_t)((2 + (i + 5 * view) % 14) << 4 * (view % 2));
        }
        for (uint32_t layer = 2; layer < LAYERS; ++layer) {
            const uint32_t word = (layer * SIDE * SIDE + i) * 1021;
            bytes[layer][i][0] = (uint8_t)word;
            bytes[layer][i][1] = (uint8_t)(word >> 8);
        }
    }
    const uint32_t texture = make_texture(gl, GL_TEXTURE_2D_ARRAY, 1);
    gl->TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RG8UI, SIDE, SIDE, LAYERS, 0, GL_RG_INTEGER, GL_UNSIGNED_BYTE,
                   bytes);
    return run_with_texture(gl, version, "usampler2DArray", main_text, texture, unit, log, failures);
}

btf_result btf_gl_self_test(const btf_gl_options *options, const btf_log *log, uint32_t *out_failures) {
    *out_failures = 0;
    btfi_gl_functions api;
    btf_result result = btfi_gl_load(options, log, &api);
    if (result != BTF_OK) {
        return result;
    }
    btfi_gl_errors(&api);
    btfi_gl_state saved;
    btfi_gl_save_state(&api, &saved);

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
    btfi_gl_viewport(&api, SIDE, SIDE);
    if (api.CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        result = btfi_fail(log, BTF_ERROR_UNSUPPORTED,
                           "gl: the context refuses a framebuffer of format RGBA32UI");
    }

    char version[32];
    btfi_gl_version(&api, version, sizeof version);
    int has_precise = api.is_es ? 10 * api.major + api.minor >= 32 : api.major >= 4;
    if (result == BTF_OK) {
        result = run_arithmetic(&api, version, 1, log, out_failures);
    }
    if (result == BTF_OK && has_precise) {
        result = run_arithmetic(&api, version, 0, log, out_failures);
    }
    if (result == BTF_OK) {
        result = run_levels(&api, version, saved.unit, log, out_failures);
    }
    if (result == BTF_OK) {
        result = run_array(&api, version, saved.unit, log, out_failures);
    }
    if (result == BTF_OK) {
        result = run_lists(&api, version, saved.unit, log, out_failures);
    }

    api.DeleteVertexArrays(1, &array);
    api.DeleteFramebuffers(1, &framebuffer);
    btfi_gl_restore_state(&api, &saved);
    api.DeleteTextures(1, &texture);
    return result;
}
