/* From GLSL to other languages. See translate.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "translate.h"

#include "cross_text.h"
#include "decoder/toolkit/file.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef HAVE_GLSLANG
#include <glslang/Include/glslang_c_interface.h>
#include <glslang/Public/resource_limits_c.h>
#endif
#ifdef HAVE_SPIRV_CROSS
#include <spirv_cross_c.h>
#endif

#ifdef HAVE_GLSLANG

/* Declares textures without samplers, as HLSL and Metal have them: with one a texture there would be up to 20, and
 * Direct3D 11 has 16. */
static const char separate_textures[] = "#extension GL_EXT_samplerless_texture_functions : require\n"
                                        "#define sampler2D texture2D\n"
                                        "#define sampler2DArray texture2DArray\n"
                                        "#define usampler2D utexture2D\n"
                                        "#define usampler2DArray utexture2DArray\n"
                                        "#define isampler2DArray itexture2DArray\n";

/* The entry point evaluates an array of records. They are words, so that no device rounds or flushes what only passes
 * through. P_ stands for the prefix. */
static const char entry_begin[] =
    "layout(local_size_x = 64) in;\n"
    "layout(set = %u, binding = 0, std430) buffer P_entry { uint P_words[]; };\n"
    "void main() {\n"
    "    uint at = 12u * gl_GlobalInvocationID.x;\n"
    "    vec2 uv = uintBitsToFloat(uvec2(P_words[at], P_words[at + 1u]));\n"
    "    vec3 l = uintBitsToFloat(uvec3(P_words[at + 2u], P_words[at + 3u], P_words[at + 4u]));\n"
    "    vec3 v = uintBitsToFloat(uvec3(P_words[at + 5u], P_words[at + 6u], P_words[at + 7u]));\n"
    "    float level = uintBitsToFloat(P_words[at + 8u]);\n"
    "    vec3 radiance;\n";
static const char entry_random[] =
    "    uvec3 random = uvec3(P_words[at + 9u], P_words[at + 10u], P_words[at + 11u]);\n";
static const char entry_one[] = "    radiance = P_evaluate_level(uv, l, v, int(level));\n";
static const char entry_one_random[] =
    "    radiance = P_evaluate_stochastic_between(uv, l, v, level, random);\n";
/* SPIRV-Cross writes only functions that are called, so this calls all that programs may want. */
static const char entry_all[] = "    if (level == -1.0)\n"
                                "        radiance = P_evaluate(uv, l, v);\n"
                                "    else if (level == -2.0)\n"
                                "        radiance = P_evaluate_nearest(uv, l, v);\n"
                                "    else if (level == -3.0)\n"
                                "        radiance = vec3(P_level(uv, l.xy));\n"
                                "    else\n"
                                "        radiance = P_evaluate_level(uv, l, v, int(level));\n";
static const char entry_all_random[] =
    "    if (level == -1.0)\n"
    "        radiance = P_evaluate_stochastic(uv, l, v, P_random(random));\n"
    "    else if (level == -2.0)\n"
    "        radiance = P_evaluate_stochastic_level(uv, l, v, 1, random);\n"
    "    else if (level == -3.0)\n"
    "        radiance = vec3(P_level(uv, l.xy));\n"
    "    else if (level == -4.0)\n"
    "        radiance = P_evaluate_radiance_blend(uv, l, v);\n"
    "    else if (level == -5.0)\n"
    "        radiance = P_evaluate_radiance_blend_level(uv, l, v, 1);\n"
    "    else if (level == -6.0)\n"
    "        radiance = P_evaluate_radiance_blend_between(uv, l, v, 0.5);\n"
    "    else\n"
    "        radiance = P_evaluate_stochastic_between(uv, l, v, level, random);\n";
static const char entry_end[] = "    P_words[at + 9u] = floatBitsToUint(radiance.x);\n"
                                "    P_words[at + 10u] = floatBitsToUint(radiance.y);\n"
                                "    P_words[at + 11u] = floatBitsToUint(radiance.z);\n"
                                "}\n";

/* The whole compute shader, freed by the caller; NULL without memory. */
static char *make_shader(const translate_source *source, int separate, int all) {
    char begin[sizeof entry_begin + 16];
    snprintf(begin, sizeof begin, entry_begin, source->descriptor_set + 1);
    const char *one = source->stochastic ? entry_one_random : entry_one;
    const char *every = source->stochastic ? entry_all_random : entry_all;
    char *entry = cross_join((const char *const[]){begin, source->stochastic ? entry_random : "",
                                                   all ? every : one, entry_end, NULL});
    char *named = entry ? cross_replace_prefix(entry, "P_", source->prefix) : NULL;
    char *text = !named
                     ? NULL
                     : cross_join((const char *const[]){"#version 450\n", separate ? separate_textures : "",
                                                        source->decoder, "\n", named, NULL});
    free(entry);
    free(named);
    return text;
}

static btf_result compile(const char *text, const btf_log *log, uint32_t **out_words, size_t *out_count) {
    const glslang_input_t input = {.language = GLSLANG_SOURCE_GLSL,
                                   .stage = GLSLANG_STAGE_COMPUTE,
                                   .client = GLSLANG_CLIENT_VULKAN,
                                   .client_version = GLSLANG_TARGET_VULKAN_1_0,
                                   .target_language = GLSLANG_TARGET_SPV,
                                   .target_language_version = GLSLANG_TARGET_SPV_1_0,
                                   .code = text,
                                   .default_version = 100,
                                   .default_profile = GLSLANG_NO_PROFILE,
                                   .messages = GLSLANG_MSG_SPV_RULES_BIT | GLSLANG_MSG_VULKAN_RULES_BIT,
                                   .resource = glslang_default_resource()};
    btf_result result = BTF_ERROR_INTERNAL;
    if (!glslang_initialize_process()) {
        file_say(log, "glslang does not start");
        return result;
    }
    glslang_shader_t *shader = glslang_shader_create(&input);
    glslang_program_t *program = glslang_program_create();
    if (!shader || !program) {
        file_say(log, "glslang does not start");
    } else if (!glslang_shader_preprocess(shader, &input) || !glslang_shader_parse(shader, &input)) {
        file_say(log, "glslang refuses the decoder: %.400s", glslang_shader_get_info_log(shader));
    } else {
        glslang_program_add_shader(program, shader);
        if (!glslang_program_link(program, (int)input.messages)) {
            file_say(log, "glslang refuses the decoder: %.400s", glslang_program_get_info_log(program));
        } else {
            glslang_program_SPIRV_generate(program, input.stage);
            *out_count = glslang_program_SPIRV_get_size(program);
            *out_words = malloc(*out_count * sizeof **out_words);
            if (*out_words) {
                memcpy(*out_words, glslang_program_SPIRV_get_ptr(program), *out_count * sizeof **out_words);
            }
            result = *out_words ? BTF_OK : BTF_ERROR_MEMORY;
        }
    }
    if (program) {
        glslang_program_delete(program);
    }
    if (shader) {
        glslang_shader_delete(shader);
    }
    glslang_finalize_process();
    return result;
}

static btf_result to_spirv(const translate_source *source, int separate, int all, const btf_log *log,
                           uint32_t **out_words, size_t *out_count) {
    char *text = make_shader(source, separate, all);
    const btf_result result = text ? compile(text, log, out_words, out_count) : BTF_ERROR_MEMORY;
    free(text);
    if (result == BTF_ERROR_MEMORY) {
        file_say(log, "out of memory for a shader");
    }
    return result;
}

#else

static btf_result to_spirv(const translate_source *source, int separate, int all, const btf_log *log,
                           uint32_t **out_words, size_t *out_count) {
    (void)source;
    (void)separate;
    (void)all;
    *out_words = NULL;
    *out_count = 0;
    file_say(log, "this program was built without glslang (Debian: glslang-dev), which compiles to SPIR-V");
    return BTF_ERROR_UNSUPPORTED;
}

#endif

btf_result translate_to_spirv(const translate_source *source, const btf_log *log, uint32_t **out_words,
                              size_t *out_count) {
    *out_words = NULL;
    return to_spirv(source, 0, 0, log, out_words, out_count);
}

#ifdef HAVE_SPIRV_CROSS

static int set_options(spvc_compiler compiler, translate_target target) {
    spvc_compiler_options options;
    if (spvc_compiler_create_compiler_options(compiler, &options)) {
        return 0;
    }
    if (target == TRANSLATE_HLSL) {
        spvc_compiler_options_set_uint(options, SPVC_COMPILER_OPTION_HLSL_SHADER_MODEL, 51);
    } else {
        spvc_compiler_options_set_uint(options, SPVC_COMPILER_OPTION_MSL_VERSION,
                                       SPVC_MAKE_MSL_VERSION(2, 1, 0));
        spvc_compiler_options_set_bool(options, SPVC_COMPILER_OPTION_MSL_ENABLE_DECORATION_BINDING,
                                       SPVC_TRUE);
    }
    return !spvc_compiler_install_compiler_options(compiler, options);
}

static btf_result cross(const translate_source *source, const uint32_t *words, size_t count,
                        translate_target target, const btf_log *log, char **out_text) {
    spvc_context context;
    spvc_parsed_ir module;
    spvc_compiler compiler;
    char name[64];
    const char *text = NULL;
    if (spvc_context_create(&context)) {
        file_say(log, "out of memory for a shader");
        return BTF_ERROR_MEMORY;
    }
    snprintf(name, sizeof name, "%s_evaluate_many", source->prefix);
    btf_result result = BTF_OK;
    if (spvc_context_parse_spirv(context, words, count, &module) ||
        spvc_context_create_compiler(context,
                                     target == TRANSLATE_HLSL ? SPVC_BACKEND_HLSL : SPVC_BACKEND_MSL,
                                     module, SPVC_CAPTURE_MODE_TAKE_OWNERSHIP, &compiler) ||
        !set_options(compiler, target) ||
        spvc_compiler_rename_entry_point(compiler, "main", name, SpvExecutionModelGLCompute) ||
        spvc_compiler_compile(compiler, &text)) {
        file_say(log, "SPIRV-Cross refuses the decoder: %.400s",
                 spvc_context_get_last_error_string(context));
        result = BTF_ERROR_INTERNAL;
    }
    if (!result) {
        result = target == TRANSLATE_HLSL ? cross_hlsl(text, source->prefix, log, out_text)
                                          : cross_msl(text, source->prefix, log, out_text);
    }
    spvc_context_destroy(context);
    return result;
}

#else

static btf_result cross(const translate_source *source, const uint32_t *words, size_t count,
                        translate_target target, const btf_log *log, char **out_text) {
    (void)source;
    (void)words;
    (void)count;
    (void)target;
    (void)out_text;
    file_say(log, "this program was built without SPIRV-Cross (Debian: libspirv-cross-c-shared-dev), which "
                  "translates "
                  "to HLSL and Metal");
    return BTF_ERROR_UNSUPPORTED;
}

#endif

btf_result translate_to_text(const translate_source *source, translate_target target, const btf_log *log,
                             char **out_text) {
    uint32_t *words = NULL;
    size_t count = 0;
    *out_text = NULL;
    btf_result result = to_spirv(source, 1, 1, log, &words, &count);
    if (!result) {
        result = cross(source, words, count, target, log, out_text);
    }
    free(words);
    return result;
}
