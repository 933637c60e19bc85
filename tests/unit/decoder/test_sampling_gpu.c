/* Light sampling on a device against the reference, bit for bit. The argument names the device.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/reference_view.h"
#include "tests/conformance/cases.h"
#include "tests/conformance/gpu.h"
#include "tests/conformance/sabotage/tamper.h"
#include "tests/conformance/synthetic.h"

#include <openbtf/sampling.h>

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COUNT = 20000, FIRST_OWN_UNIT = 14 };

/* a: view, u1; b: u2, light. Where u1 is even or not: the sample, or the density of the light. */
static const char body[] = "uvec4 check(uvec4 a, uvec4 b) {\n"
                           "    vec3 v = uintBitsToFloat(a.xyz);\n"
                           "    float pdf;\n"
                           "    if ((a.w & 1u) != 0u)\n"
                           "        return uvec4(floatBitsToUint(btf_pdf_light(vec2(0.0), v, "
                           "uintBitsToFloat(b.yzw))), 0u, 0u, 0u);\n"
                           "    vec3 l = btf_sample_light(vec2(0.0), v, a.w, b.x, pdf);\n"
                           "    return uvec4(floatBitsToUint(l), floatBitsToUint(pdf));\n"
                           "}\n";

/* Deliberate breaks of the text: each must show. */
static const char *const breaks[][2] = {
    {"h >> 16u ^ h", "h >> 15u ^ h"},
    {"drop >= 16777216u", "drop >= 33554432u"},
    {"0x3F7FFFFFu", "0x3F000000u"},
    {"0xBB996966u", "0xBB996066u"},
    {"0xBCAAE9E4u", "0xBCAAE0E4u"},
    {"quarter == 2 ? -sine", "quarter == 2 ? sine"},
    {"btf_add(u1, u2) > 1.0", "btf_add(u1, u2) > 1.5"},
    {"height < once ? l.yzx : l.zxy", "height < once ? l.zxy : l.yzx"},
    {"n.index.x != n.index.z", "n.index.x != n.index.y"},
    {"btf_add(float(n.weight.z), -1.0)", "float(n.weight.z)"},
    {"density = btf_mul(btf_mul(density, k), k)", "density = btf_mul(density, k)"},
    {"ivec2(int(BTF_N_LIGHTS), view)", "ivec2(int(BTF_N_LIGHTS) - 1, view)"},
    {"if (u1 >= end)", "if (u1 > end + 65536u)"},
    {"low = middle + 1", "low = middle + 1 + middle % 2"},
    {"low > 0 ? btf_part_end(low - 1, view)", "low > 1 ? btf_part_end(low - 1, view)"},
    {"ivec2(low, size.y - 1)", "ivec2(low, size.y - 2)"},
    {"vec3(corners >> 16u)", "vec3(corners & 65535u)"},
    {"btf_mul(x, twice), btf_mul(y, twice)", "btf_mul(x, k), btf_mul(y, twice)"},
    {"if (!btf_is_above(l) || !btf_is_above(v))\n        return 0.0;",
     "if (!btf_is_above(v))\n        return 0.0;"},
    {"    if (!btf_is_above(v))\n        return l;", ""},
};
enum { BREAKS = sizeof breaks / sizeof *breaks };

typedef struct subject {
    btf_material *material;
    btf_evaluator *evaluator;
    btf_light_sampling *tables;
    btf_ref_material reference;
    btf_gl *gl;
    unsigned textures[2];
    uint32_t *inputs, *expected, *actual;
} subject;

/* The text with `from` replaced by `to` where it stands first behind the beginning of sampling.glsl. */
static char *replaced(const char *text, const char *from, const char *to) {
    const char *start = strstr(text, "float btf_unit(uint random)");
    return start ? tamper_text(text, (size_t)(start - text), 1, from, to) : NULL;
}

static void upload(const gl_api *gl, const btf_light_sampling *tables, unsigned textures[2]) {
    gl->GenTextures(2, textures);
    for (int i = 0; i < 2; i++) {
        gl->ActiveTexture((GLenum)(GL_TEXTURE0 + FIRST_OWN_UNIT + i));
        gl->BindTexture(GL_TEXTURE_2D, textures[i]);
        gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    }
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, (GLsizei)tables->n_lights + 1, (GLsizei)tables->n_views, 0,
                   GL_RED, GL_FLOAT, tables->densities);
    gl->ActiveTexture(GL_TEXTURE0 + FIRST_OWN_UNIT);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32UI, (GLsizei)tables->n_triangles,
                   (GLsizei)tables->n_views + 1, 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT, tables->triangles);
}

static void make_cases(subject *s, uint64_t seed) {
    const btf_directions views = btf_material_views(s->material), lights = btf_material_lights(s->material);
    const btf_ref_sampling sampling = {s->tables->n_triangles, s->tables->triangles, s->tables->densities};
    random_state r = {seed};
    for (size_t i = 0; i < COUNT; i++) {
        uint32_t *in = s->inputs + GPU_INPUTS * i, *out = s->expected + GPU_OUTPUTS * i;
        float view[3], light[3], result[4] = {0};
        case_direction(&r, &views, view);
        case_direction(&r, &lights, light);
        memcpy(in, view, sizeof view);
        in[3] = (uint32_t)random_bits(&r);
        in[4] = (uint32_t)random_bits(&r);
        if (random_below(&r, 8) == 0) /* the ends of parts, and of all */
            in[3] =
                s->tables->triangles[4 * random_below(&r, s->tables->n_triangles)] - random_below(&r, 3);
        if (random_below(&r, 8) == 0)
            in[4] = random_below(&r, 2) ? 0xFFFFFFFFu : random_below(&r, 300);
        memcpy(in + 5, light, sizeof light);
        if (in[3] & 1)
            result[0] = btf_ref_pdf_light(&s->reference, &sampling, 0, 0, view, light);
        else
            btf_ref_sample_light(&s->reference, &sampling, 0, 0, view, in[3], in[4], result, &result[3]);
        memcpy(out, result, sizeof result);
    }
}

/* Differing elements of a text; -1 where it does not compile. */
static long run(gpu *g, const subject *s, const char *text) {
    const gl_api *gl = gpu_api(g);
    const unsigned program = gpu_program(g, "#define BTF_SAMPLING 1\n", text, body, NULL);
    if (!program)
        return -1;
    btf_result result = btf_gl_bind(s->gl, program, GPU_FIRST_UNIT, NULL, NULL, NULL);
    gl->UseProgram(program);
    gl->Uniform1i(gl->GetUniformLocation(program, "btf_sampling_triangles"), FIRST_OWN_UNIT);
    gl->Uniform1i(gl->GetUniformLocation(program, "btf_sampling_densities"), FIRST_OWN_UNIT + 1);
    for (int i = 0; i < 2; i++) {
        gl->ActiveTexture((GLenum)(GL_TEXTURE0 + FIRST_OWN_UNIT + i));
        gl->BindTexture(GL_TEXTURE_2D, s->textures[i]);
    }
    if (result == BTF_OK)
        result = gpu_run(g, program, COUNT, s->inputs, s->actual, NULL);
    gpu_delete_program(g, program);
    long different = result == BTF_OK ? 0 : -1;
    for (size_t i = 0; i < COUNT && result == BTF_OK; i++)
        different += memcmp(s->expected + GPU_OUTPUTS * i, s->actual + GPU_OUTPUTS * i,
                            GPU_OUTPUTS * sizeof(uint32_t)) != 0;
    return different;
}

/* A material on the device; the breaks too, where asked for. Returns the number of failures. */
static int check_material(gpu *g, const synthetic_spec *spec, bool broken) {
    subject s = {0};
    char *text = NULL;
    const btf_shader_options shader = {.struct_size = sizeof shader};
    const btf_gl_options options = gpu_gl_options(g, &shader);
    s.inputs = calloc(COUNT, GPU_INPUTS * sizeof *s.inputs);
    s.expected = calloc(COUNT, GPU_OUTPUTS * sizeof *s.expected);
    s.actual = calloc(COUNT, GPU_OUTPUTS * sizeof *s.actual);
    int failures = 0;
    if (!s.inputs || !s.expected || !s.actual || synthetic_create(spec, NULL, &s.material) ||
        btf_evaluator_create(s.material, NULL, &s.evaluator) ||
        btf_light_sampling_create(s.material, s.evaluator, NULL, &s.tables) ||
        btf_shader_source(s.material, &shader, NULL, &text) ||
        btf_gl_upload(s.material, &options, NULL, &s.gl)) {
        printf("[  FAILED  ] %u views, %u lights: cannot be set up\n", spec->n_views, spec->n_lights);
        failures = 1;
    } else {
        reference_view(s.material, 0, &s.reference);
        make_cases(&s, spec->seed);
        upload(gpu_api(g), s.tables, s.textures);
        const long different = run(g, &s, text);
        printf("[ %s ] %u views, %u lights: %ld of %d differ\n", different ? " FAILED " : "      OK",
               spec->n_views, spec->n_lights, different, (int)COUNT);
        failures = different != 0;
    }
    for (int i = 0; i < BREAKS && broken && !failures; i++) {
        char *wrong = replaced(text, breaks[i][0], breaks[i][1]);
        const long different = wrong ? run(g, &s, wrong) : -1;
        if (different <= 0) {
            printf("[  FAILED  ] \"%s\" for \"%s\": %s\n", breaks[i][1], breaks[i][0],
                   different < 0 ? "cannot be put in" : "nobody notices");
            failures++;
        }
        free(wrong);
    }
    btf_gl_destroy(&s.gl);
    btf_free(text);
    btf_light_sampling_destroy(&s.tables);
    btf_evaluator_destroy(&s.evaluator);
    btf_material_close(&s.material);
    free(s.inputs);
    free(s.expected);
    free(s.actual);
    return failures;
}

int main(int argc, char **argv) {
    const context_device *device = context_devices;
    while (device->name && (argc < 2 || strcmp(device->name, argv[1]) != 0))
        device++;
    if (!device->name) {
        fprintf(stderr, "test_sampling_gpu: expected the name of a device\n");
        return 1;
    }
    context_prepare(device);
    gpu *g = gpu_create_or_skip(device);
    synthetic_spec spec = {.seed = 4,
                           .width = 8,
                           .height = 8,
                           .n_views = 37,
                           .n_lights = 81,
                           .layout = BTF_LAYOUT_TIGHT,
                           .colour = BTF_COLOUR_RGB,
                           .lobes = 2,
                           .levels = 1};
    int failures = check_material(g, &spec, argc > 2 && strcmp(argv[2], "--broken") == 0);
    spec.n_views = 3;
    spec.n_lights = 300;
    spec.directions = SYNTHETIC_RANDOM;
    failures += check_material(g, &spec, false);
    spec.n_views = spec.n_lights = 2;
    spec.directions = SYNTHETIC_COLLINEAR;
    failures += check_material(g, &spec, false);
    gpu_destroy(&g);
    return failures != 0;
}
