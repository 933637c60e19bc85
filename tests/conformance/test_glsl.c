/* glslang compiles every variant of the library for every version it claims; SPIR-V keeps every float
 * operation from contraction; and an effect that is absent leaves no code and no fetch behind.
 *
 *     test_glsl           every two settings of options meet, for all versions
 *     test_glsl --long    every four, in some 600 rows, where there are 6 million combinations: conditions of the library
 *                         ask for four options at most
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/conformance/variants/variant_rows.h"

#include <glslang/Include/glslang_c_interface.h>
#include <glslang/Public/resource_limits_c.h>
#include <openbtf/shader.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct version {
    const char *name, *line, *extra; /* `extra` stands before the library */
    int vulkan;
} version;

static const version versions[] = {
    {"GLSL 330", "#version 330 core\n", "", 0},
    {"GLSL 450", "#version 450 core\n", "", 0},
    {"ESSL 300", "#version 300 es\n", "", 0},
    {"ESSL 310", "#version 310 es\n", "", 0},
    {"Vulkan", "#version 450 core\n", "#define BTF_UNIFORM(n) layout(set = 0, binding = n) uniform\n", 1},
};
enum { VERSIONS = sizeof versions / sizeof *versions };

/* The whole fragment shader; the caller frees it. */
static char *make_shader(const version *v, const uint8_t *row) {
    static const char main_text[] =
        "IN(0) in vec2 uv;\nIN(1) in vec3 l;\nIN(2) in vec3 v;\nIN(0) out vec4 colour;\n"
        "void main() {\n"
        "    colour = vec4(btf_evaluate(uv, l, v) + btf_evaluate_nearest(uv, l, v), 1.0);\n"
        "    colour.xyz -= btf_evaluate_level(uv, l, v, int(btf_level(dFdx(uv), dFdy(uv)) + 0.5));\n"
        "}\n";
    static const char stochastic_text[] =
        "IN(0) in vec2 uv;\nIN(1) in vec3 l;\nIN(2) in vec3 v;\nIN(0) out vec4 colour;\n"
        "void main() {\n"
        "    uvec3 random = btf_random(uvec3(gl_FragCoord.xyz));\n"
        "    float level = btf_level(dFdx(uv), dFdy(uv));\n"
        "    colour = vec4(btf_evaluate_stochastic(uv, l, v, random) + btf_evaluate_radiance_blend(uv, l, "
        "v), 1.0);\n"
        "    colour.xyz += btf_evaluate_stochastic_level(uv, l, v, 1, random);\n"
        "    colour.xyz += btf_evaluate_radiance_blend_level(uv, l, v, 1);\n"
        "    colour.xyz += btf_evaluate_stochastic_between(uv, l, v, level, random);\n"
        "    colour.xyz += btf_evaluate_radiance_blend_between(uv, l, v, level);\n"
        "}\n";
    char macros[ROW_MACROS];
    row_macros(row, macros);
    const char *library = btf_shader_library();
    const char *in = v->vulkan ? "#define IN(n) layout(location = n)\n" : "#define IN(n)\n";
    const char *parts[] = {
        v->line, v->extra, macros, in, library, "\n", row[PICKS] ? stochastic_text : main_text};
    size_t length = 1;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) {
        length += strlen(parts[i]);
    }
    char *text = malloc(length);
    if (!text) {
        exit(4);
    }
    *text = 0;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) {
        strcat(text, parts[i]);
    }
    return text;
}

/* Float additions, subtractions and multiplications of a SPIR-V module that lack NoContraction. */
static int contractible(const unsigned *words, size_t count) {
    enum { DECORATE = 71, NO_CONTRACTION = 42, ADD = 129, SUBTRACT = 131, MULTIPLY = 133, SCALE = 142 };
    unsigned bound = words[3];
    unsigned char *decorated = calloc(bound, 1);
    int missing = 0;
    if (!decorated) {
        exit(4);
    }
    for (size_t i = 5; i < count && words[i] >> 16; i += words[i] >> 16) {
        unsigned op = words[i] & 0xFFFF;
        if (op == DECORATE && words[i + 2] == NO_CONTRACTION) {
            decorated[words[i + 1]] = 1;
        }
        if (op == ADD || op == SUBTRACT || op == MULTIPLY || op == SCALE) {
            missing += !decorated[words[i + 2]];
        }
    }
    free(decorated);
    return missing;
}

/* Names that only the code of an effect has, and the option that brings it. */
static int check_absence(const char *preprocessed, const uint8_t *row) {
    const struct {
        int present;
        const char *words[3];
    } effects[] = {
        {row[SHADOW] && row[COLOUR] != 2, {"btf_shadow_code", "btf_shadow_factor", NULL}},
        {row[HIDDEN] == 2, {"btf_centre_radiance", "btf_centre_index", "btf_centres"}},
        {row_components(row) > 0 && !row_has_factors(row), {"btf_residual", NULL, NULL}},
        {row_has_factors(row), {"btf_factor", "s.horizon", NULL}},
        {row[COLOUR] != 2, {"btf_lafortune", "btf_sbrdf", NULL}},
        {row[SHIFT], {"btf_wrap(x", NULL, NULL}},
        {row[GAIN], {"float(gain)", "float ( gain", NULL}},
        {row[POINTS] == 1 && (row[SHIFT] || row[GAIN]), {"btf_points", NULL, NULL}},
        {row[POINTS] == 2 && (row[SHIFT] || row[GAIN]), {"btf_point_lists", "btf_point_indices", NULL}},
        {row[RELIEF], {"btf_slope", "btf_shifted_views", "s.shown"}},
        {row[RELIEF] > 1, {"btf_heights", "btf_march", "btf_occlude"}},
        {row[RELIEF] == 3, {"level >= 2", "unmoved", NULL}},
        {row[GLOSS], {"btf_gloss", "s.lights_of", NULL}},
        {row[RELIEF] || row[GLOSS], {"btf_view_vector", NULL, NULL}},
        {!row[POINTS], {"texelFetch(btf_shift", "texelFetch(btf_gain", NULL}},
    };
    int wrong = 0;
    for (size_t e = 0; e < sizeof effects / sizeof *effects; ++e) {
        for (int w = 0; w < 3 && effects[e].words[w]; ++w) {
            if (!effects[e].present && strstr(preprocessed, effects[e].words[w])) {
                fprintf(stderr, "%s is left behind\n", effects[e].words[w]);
                ++wrong;
            }
        }
    }
    int maps = row[LAYOUT] == 0 &&
               ((row[SHADOW] && row[COLOUR] != 2) || row[SHIFT] || row[HIDDEN] == 2 || row[GAIN]);
    if (!maps && strstr(preprocessed, "btf_maps")) {
        fprintf(stderr, "btf_maps is left behind\n");
        ++wrong;
    }
    return wrong;
}

/* Compiles one variant for one version; returns how many things are wrong. */
static int check_variant(const version *v, const uint8_t *row) {
    char *text = make_shader(v, row);
    glslang_input_t input = {
        .language = GLSLANG_SOURCE_GLSL,
        .stage = GLSLANG_STAGE_FRAGMENT,
        .client = v->vulkan ? GLSLANG_CLIENT_VULKAN : GLSLANG_CLIENT_NONE,
        .client_version = v->vulkan ? GLSLANG_TARGET_VULKAN_1_0 : GLSLANG_TARGET_OPENGL_450,
        .target_language = v->vulkan ? GLSLANG_TARGET_SPV : GLSLANG_TARGET_NONE,
        .target_language_version = GLSLANG_TARGET_SPV_1_0,
        .code = text,
        .default_version = 100,
        .default_profile = GLSLANG_NO_PROFILE,
        .messages =
            v->vulkan ? GLSLANG_MSG_SPV_RULES_BIT | GLSLANG_MSG_VULKAN_RULES_BIT : GLSLANG_MSG_DEFAULT_BIT,
        .resource = glslang_default_resource()};
    glslang_shader_t *shader = glslang_shader_create(&input);
    glslang_program_t *program = NULL;
    int wrong = 0;
    const char *message = "";
    if (!glslang_shader_preprocess(shader, &input) || !glslang_shader_parse(shader, &input) ||
        strstr(glslang_shader_get_info_log(shader), "WARNING")) {
        ++wrong;
        message = glslang_shader_get_info_log(shader);
    } else {
        wrong += check_absence(glslang_shader_get_preprocessed_code(shader), row);
        program = glslang_program_create();
        glslang_program_add_shader(program, shader);
        if (!glslang_program_link(program, (int)input.messages)) {
            ++wrong;
            message = glslang_program_get_info_log(program);
        } else if (v->vulkan) {
            glslang_program_SPIRV_generate(program, GLSLANG_STAGE_FRAGMENT);
            int missing = contractible(glslang_program_SPIRV_get_ptr(program),
                                       glslang_program_SPIRV_get_size(program));
            /* main and btf_level, which is not exact, have some of their own; fast math may contract all.
             */
            const int own = row[PICKS] ? 8 : 6;
            if (row[FAST] ? missing <= own : missing != own) {
                ++wrong;
                fprintf(stderr, "%d float operations lack NoContraction\n", missing);
            }
        }
    }
    if (wrong) {
        fprintf(stderr, "%s, levels", v->name);
        for (int f = 0; f < FACTORS; ++f) {
            fprintf(stderr, " %d", row[f]);
        }
        fprintf(stderr, ": %.400s\n", message);
    }
    if (program) {
        glslang_program_delete(program);
    }
    glslang_shader_delete(shader);
    free(text);
    return wrong;
}

/* Compiles every row for every version; returns how many things are wrong. */
static int check_rows(size_t count, uint8_t (*rows)[PAIRWISE_FACTORS]) {
    int wrong = 0;
    size_t compiled = 0;
    glslang_initialize_process();
    for (size_t i = 0; i < count && wrong < 10; ++i) {
        for (int v = 0; v < VERSIONS; ++v, ++compiled) {
            wrong += check_variant(&versions[v], rows[i]);
        }
    }
    glslang_finalize_process();
    printf("%zu shaders compiled, %d wrong\n", compiled, wrong);
    return wrong;
}

int main(int argc, char **argv) {
    enum { MOST = 2000 };
    static uint8_t rows[MOST][PAIRWISE_FACTORS];
    const size_t count =
        argc > 1 && strcmp(argv[1], "--long") == 0 ? rows_of_fours(MOST, rows) : rows_of_pairs(MOST, rows);
    if (count == 0 || count == MOST) {
        fprintf(stderr, "rows: no memory for them, or more than %d\n", MOST);
        return 1;
    }
    return check_rows(count, rows) > 0;
}
