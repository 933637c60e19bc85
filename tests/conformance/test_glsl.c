/* glslang compiles every variant of the library for every version it claims; SPIR-V keeps every float
 * operation from contraction; and an effect that is absent leaves no code and no fetch behind.
 *
 *     test_glsl           every two settings of options meet, for all versions
 *     test_glsl --long    every four, in some 600 rows, where there are 6 million combinations: conditions of the library
 *                         ask for four options at most
 *
 * SPDX-License-Identifier: MIT
 */
#include "pairwise.h"

#include <glslang/Include/glslang_c_interface.h>
#include <glslang/Public/resource_limits_c.h>
#include <openbtf/shader.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The options that decide which code exists. */
enum factor {
    LAYOUT,
    DOMAIN,
    COLOUR,
    LOBES,
    SHADOW,
    SHIFT,
    HIDDEN,
    GAIN,
    COMPONENTS,
    NEAREST,
    BILINEAR,
    FAST,
    STORE, /* components, factors of all classes, of some */
    ROOTS,
    POINTS, /* packed or in lists: layout tight, without hidden points */
    RELIEF, /* of one height, of a map, of a map that ends before the last level: layout tight */
    GLOSS,  /* of a quarter, of a half: layout tight */
    STEEP,  /* with bilinear filtering */
    PICKS,  /* none, views, lights, all */
    FACTORS
};
static const uint8_t levels[FACTORS] = {2, 2, 3, 4, 2, 2, 3, 2, 4, 2, 2, 2, 3, 2, 3, 4, 3, 2, 4};
static const int components[] = {0, 1, 6, 16};

/* Of each class units, words of C1 and of C2, of the stores after the first. */
static const int classes[][5][3] = {
    {{1, 1, 2}, {2, 1, 3}, {3, 0, 1}, {1, 0, 0}, {2, 4, 4}},
    {{0, 0, 0}, {2, 0, 0}, {0, 0, 0}, {0, 0, 0}, {9, 3, 2}},
};

static int has_factors(const uint8_t *row) {
    return row[STORE] > 0 && components[row[COMPONENTS]] > 0;
}

/* The names that the library defines for a material of version 2. */
static void write_version_2(char *out, size_t size, const uint8_t *row) {
    size_t at =
        (size_t)snprintf(out, size, "%s#define BTF_POINTS %d\n%s",
                         row[ROOTS] && row[DOMAIN] ? "#define BTF_BLEND_ROOTS 1\n" : "", row[POINTS],
                         row[POINTS] ? "#define BTF_GAIN_BASE 0.25\n#define BTF_GAIN_STEP 0.125\n" : "");
    if (row[RELIEF]) {
        at += (size_t)snprintf(
            out + at, size - at,
            "#define BTF_RELIEF %d\n#define BTF_RELIEF_BASE (-300)\n#define BTF_RELIEF_STEP 900\n"
            "#define BTF_RELIEF_STEPS 8\n%s",
            row[RELIEF] == 1 ? 1 : 2, row[RELIEF] == 3 ? "#define BTF_RELIEF_END 2\n" : "");
    }
    if (row[GLOSS]) {
        at += (size_t)snprintf(out + at, size - at, "#define BTF_GLOSS %d\n", row[GLOSS]);
    }
    if (row[STEEP]) {
        at += (size_t)snprintf(out + at, size - at, "#define BTF_STEEP %d\n", row[BILINEAR]);
    }
    if (!has_factors(row)) {
        return;
    }
    const int(*of)[3] = classes[row[STORE] - 1];
    at += (size_t)snprintf(out + at, size - at, "#define BTF_FACTORS 1\n#define BTF_HORIZON_SCALE 3.75\n");
    for (int c = 0; c < 5; ++c) {
        at += (size_t)snprintf(
            out + at, size - at,
            "#define BTF_FACTOR_UNITS_%d %d\n#define BTF_FACTOR_C1_%d %d\n#define BTF_FACTOR_C2_%d %d\n", c,
            of[c][0], c, of[c][1], c, of[c][2]);
    }
}

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

static void write_options(char *out, size_t size, const uint8_t *row) {
    int colour = row[COLOUR];
    snprintf(
        out, size,
        "#define BTF_LAYOUT_TIGHT %d\n#define BTF_DOMAIN_SQRT %d\n#define BTF_COLOUR %d\n#define BTF_LOBES "
        "%d\n"
        "#define BTF_SHADOW %d\n#define BTF_SHIFT %d\n#define BTF_HIDDEN %d\n#define BTF_CODE_ZERO %d\n"
        "#define BTF_GAIN %d\n#define BTF_COMPONENTS %d\n#define BTF_NEAREST %d\n#define BTF_BILINEAR %d\n"
        "#define BTF_FAST_MATH %d\n#define BTF_STOCHASTIC %d\n"
        "#define BTF_WIDTH 64u\n#define BTF_HEIGHT 48u\n#define BTF_LEVELS 3u\n#define BTF_N_LIGHTS "
        "81u\n#define BTF_VIEW_GRID "
        "16u\n"
        "#define BTF_LIGHT_GRID 8u\n#define BTF_ATLAS_WIDTH 1024u\n#define BTF_ATLAS_HEIGHT 512u\n"
        "#define BTF_TILES 81u\n#define BTF_CENTRE_ROWS 100u\n"
        "#define BTF_RADIANCE_SCALE 1.0\n#define BTF_SHADOW_SCALE uintBitsToFloat(0x35808081u)\n"
        "#define BTF_GAIN_SCALE 0.0078125\n#define BTF_CENTRE_SCALE uintBitsToFloat(0x35808081u)\n",
        row[LAYOUT], row[DOMAIN], colour, colour == 2 ? 0 : 1 + row[LOBES], colour == 2 ? 0 : row[SHADOW],
        row[SHIFT], row[HIDDEN] == 2, row[HIDDEN] > 0, row[GAIN], components[row[COMPONENTS]], row[NEAREST],
        row[BILINEAR], row[FAST], row[PICKS]);
}

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
    char options[2000], version_2[1000];
    write_options(options, sizeof options, row);
    write_version_2(version_2, sizeof version_2, row);
    const char *library = btf_shader_library();
    const char *in = v->vulkan ? "#define IN(n) layout(location = n)\n" : "#define IN(n)\n";
    const char *parts[] = {v->line, v->extra, options, version_2,
                           in,      library,  "\n",    row[PICKS] ? stochastic_text : main_text};
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
        {components[row[COMPONENTS]] > 0 && !has_factors(row), {"btf_residual", NULL, NULL}},
        {has_factors(row), {"btf_factor", "s.horizon", NULL}},
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

/* Rows in which every two settings meet. */
static size_t pairs(size_t most, uint8_t (*rows)[PAIRWISE_FACTORS]) {
    /* Every pair without packed points, then with them, which leave fewer layouts and hidden points. */
    uint8_t fewer[FACTORS];
    memcpy(fewer, levels, sizeof fewer);
    fewer[POINTS] = fewer[RELIEF] = fewer[GLOSS] = fewer[STEEP] = 1;
    size_t count = pairwise_rows(1, FACTORS, fewer, most, rows);
    fewer[LAYOUT] = fewer[HIDDEN] = 1;
    fewer[POINTS] = 2;
    const size_t more = pairwise_rows(2, FACTORS, fewer, most - count, rows + count);
    for (size_t i = 0; i < more; ++i, ++count) {
        rows[count][LAYOUT] = 1;
        rows[count][POINTS]++; /* packed, or in lists */
    }
    /* Then relief, gloss and the steep filter. */
    memcpy(fewer, levels, sizeof fewer);
    fewer[LAYOUT] = fewer[LOBES] = 1;
    const size_t last = pairwise_rows(3, FACTORS, fewer, most - count, rows + count);
    for (size_t i = 0; i < last; ++i, ++count) {
        rows[count][LAYOUT] = 1;
        rows[count][POINTS] = rows[count][HIDDEN] ? 0 : rows[count][POINTS];
    }
    return count;
}

/* Rows in which every four settings meet that can, none of them without effect on the text. */
static size_t fours(size_t most, uint8_t (*rows)[PAIRWISE_FACTORS]) {
    static const pairwise_need needs[] = {
        {LOBES, COLOUR, 1 | 2}, {SHADOW, COLOUR, 1 | 2}, {STORE, COMPONENTS, 2 | 4 | 8},
        {ROOTS, DOMAIN, 2},     {POINTS, LAYOUT, 2},     {POINTS, HIDDEN, 1},
        {RELIEF, LAYOUT, 2},    {GLOSS, LAYOUT, 2},      {STEEP, LAYOUT, 2},
        {STEEP, BILINEAR, 2},
    };
    return fourwise_rows(1, FACTORS, levels, needs, sizeof needs / sizeof *needs, most, rows);
}

int main(int argc, char **argv) {
    enum { MOST = 2000 };
    static uint8_t rows[MOST][PAIRWISE_FACTORS];
    const size_t count = argc > 1 && strcmp(argv[1], "--long") == 0 ? fours(MOST, rows) : pairs(MOST, rows);
    if (count == 0 || count == MOST) {
        fprintf(stderr, "rows: no memory for them, or more than %d\n", MOST);
        return 1;
    }
    return check_rows(count, rows) > 0;
}
