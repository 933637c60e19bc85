/* The tables of light sampling in a GL context (openbtf/sampling.h): what is uploaded, bound, left as it was, refused.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/conformance/gpu.h"
#include "tests/conformance/synthetic.h"
#include "tests/support/test.h"

#include <openbtf/sampling.h>

static gpu *device;
static const gl_api *api;
static btf_material *material;
static btf_light_sampling *tables;
static char said[400];

static void hear(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    snprintf(said, sizeof said, "%s", message);
}
static const btf_log hearing = {hear, NULL};

/* Words of both tables, by the index of the element: texels of the first, then of the second. */
static const char body[] = "uniform highp usampler2D stone_sampling_triangles;\n"
                           "uniform highp sampler2D stone_sampling_densities;\n"
                           "uvec4 check(uvec4 a, uvec4 b) {\n"
                           "    if (b.x == 0u)\n"
                           "        return texelFetch(stone_sampling_triangles, ivec2(a.xy), 0);\n"
                           "    return uvec4(floatBitsToUint(texelFetch(stone_sampling_densities, "
                           "ivec2(a.xy), 0).x), 0u, 0u, 0u);\n"
                           "}\n";
static const char other[] = "uvec4 check(uvec4 a, uvec4 b) {\n    return a + b;\n}\n";

static int setup(void **state) {
    const synthetic_spec spec = {.seed = 4,
                                 .width = 4,
                                 .height = 4,
                                 .n_views = 37,
                                 .n_lights = 12,
                                 .layout = BTF_LAYOUT_TIGHT,
                                 .colour = BTF_COLOUR_RGB,
                                 .lobes = 1};
    btf_evaluator *evaluator = NULL;
    (void)state;
    device = gpu_create_or_skip(&context_devices[0]);
    api = gpu_api(device);
    int failed = synthetic_create(&spec, NULL, &material) ||
                 btf_evaluator_create(material, NULL, &evaluator) ||
                 btf_light_sampling_create(material, evaluator, NULL, &tables);
    btf_evaluator_destroy(&evaluator);
    return failed;
}

static int teardown(void **state) {
    (void)state;
    btf_light_sampling_destroy(&tables);
    btf_material_close(&material);
    gpu_destroy(&device);
    return 0;
}

static GLint get(GLenum name) {
    GLint value = 0;
    api->GetIntegerv(name, &value);
    return value;
}

/* Sets the pixel-unpacking state as an application may have left it, and binds a texture of the application's. */
static void set_state(bool odd, GLuint texture) {
    api->ActiveTexture(odd ? GL_TEXTURE5 : GL_TEXTURE0);
    api->BindTexture(GL_TEXTURE_2D, texture);
    api->PixelStorei(GL_UNPACK_ALIGNMENT, odd ? 8 : 4);
    api->PixelStorei(GL_UNPACK_ROW_LENGTH, odd ? 3 : 0);
    api->PixelStorei(GL_UNPACK_SKIP_PIXELS, odd ? 1 : 0);
}

/* Every texel is uploaded, whatever GL state the application left, and that state is restored. */
TEST(test_upload) {
    const btf_gl_options options = gpu_gl_options(device, NULL);
    btf_gl_light_sampling *s = NULL;
    GLuint texture, sampler;
    api->GenTextures(1, &texture);
    api->GenSamplers(1, &sampler);
    set_state(true, texture);
    assert_int_equal(btf_gl_light_sampling_create(tables, &options, &hearing, &s), BTF_OK);
    assert_int_equal(get(GL_ACTIVE_TEXTURE), GL_TEXTURE5);
    assert_int_equal(get(GL_TEXTURE_BINDING_2D), texture);
    assert_int_equal(get(GL_UNPACK_ALIGNMENT), 8);
    assert_int_equal(get(GL_UNPACK_ROW_LENGTH), 3);
    assert_int_equal(get(GL_UNPACK_SKIP_PIXELS), 1);
    set_state(false, 0);
    const size_t triangles = (size_t)(tables->n_views + 1) * tables->n_triangles,
                 densities = (size_t)tables->n_views * (tables->n_lights + 1);
    assert_int_equal(btf_gl_light_sampling_bytes(s), 16 * triangles + 4 * densities);

    const unsigned program = gpu_program(device, NULL, "", body, &hearing),
                   plain = gpu_program(device, NULL, "", other, &hearing);
    assert_true(program && plain);
    uint32_t units = 9;
    api->UseProgram(plain);
    api->BindSampler(GPU_FIRST_UNIT + 1, sampler); /* it filters, which an integer texture forbids */
    btf_gl_light_sampling_bind(s, program, GPU_FIRST_UNIT, "stone", &units);
    assert_int_equal(units, 2);
    assert_int_equal(get(GL_CURRENT_PROGRAM), (GLint)plain);
    assert_int_equal(get(GL_ACTIVE_TEXTURE), GL_TEXTURE0);
    api->ActiveTexture(GL_TEXTURE0 + GPU_FIRST_UNIT + 1);
    assert_int_equal(get(GL_SAMPLER_BINDING), 0);
    api->ActiveTexture(GL_TEXTURE0);
    btf_gl_light_sampling_bind(s, plain, GPU_FIRST_UNIT + 4, "stone", &units);
    assert_int_equal(units, 0);
    btf_gl_light_sampling_bind(s, program, GPU_FIRST_UNIT + 4, NULL, NULL); /* no names of this prefix */

    static uint32_t in[2000][GPU_INPUTS], out[2000][GPU_OUTPUTS];
    assert_true(triangles + densities <= 2000);
    for (size_t i = 0; i < triangles + densities; i++) {
        const size_t at = i < triangles ? i : i - triangles,
                     width = i < triangles ? tables->n_triangles : tables->n_lights + 1;
        in[i][0] = (uint32_t)(at % width);
        in[i][1] = (uint32_t)(at / width);
        in[i][4] = i >= triangles;
    }
    assert_int_equal(gpu_run(device, program, triangles + densities, in[0], out[0], &hearing), BTF_OK);
    assert_memory_equal(out, tables->triangles, 16 * triangles);
    for (size_t i = 0; i < densities; i++) {
        assert_memory_equal(out[triangles + i], tables->densities + i, sizeof(float));
    }
    btf_gl_light_sampling_destroy(&s);
    assert_null(s);
    btf_gl_light_sampling_destroy(&s);
    btf_gl_light_sampling_destroy(NULL);
    assert_int_equal(api->GetError(), GL_NO_ERROR);
    gpu_delete_program(device, program);
    gpu_delete_program(device, plain);
    api->DeleteSamplers(1, &sampler);
    api->DeleteTextures(1, &texture);
}

static GLint most;
static int live;

static void APIENTRY fake_get_integer(GLenum name, GLint *value) {
    api->GetIntegerv(name, value);
    if (name == GL_MAX_TEXTURE_SIZE) {
        *value = most;
    }
}
static void APIENTRY fake_gen_textures(GLsizei count, GLuint *names) {
    live += count;
    api->GenTextures(count, names);
}
static void APIENTRY fake_delete_textures(GLsizei count, const GLuint *names) {
    live -= count;
    api->DeleteTextures(count, names);
}

static btf_gl_function fake_get_proc_address(void *user, const char *name) {
    const btf_gl_options real = gpu_gl_options(user, NULL);
    if (strcmp(name, "glGetIntegerv") == 0) {
        return (btf_gl_function)fake_get_integer;
    }
    if (strcmp(name, "glGenTextures") == 0) {
        return (btf_gl_function)fake_gen_textures;
    }
    if (strcmp(name, "glDeleteTextures") == 0) {
        return (btf_gl_function)fake_delete_textures;
    }
    return real.get_proc_address(real.user, name);
}

/* Refusals say why and leave nothing behind. */
TEST(test_refusals) {
    const btf_gl_options faked = {sizeof faked, fake_get_proc_address, device, NULL},
                         none = {.struct_size = sizeof none};
    const GLint limits[] = {(GLint)tables->n_triangles - 1, (GLint)tables->n_views};
    btf_gl_light_sampling *s;
    assert_true(tables->n_views > tables->n_triangles && tables->n_triangles > tables->n_lights);
    for (size_t i = 0; i < 2; i++) {
        char number[40];
        most = limits[i];
        s = (btf_gl_light_sampling *)&live;
        assert_int_equal(btf_gl_light_sampling_create(tables, &faked, &hearing, &s), BTF_ERROR_UNSUPPORTED);
        assert_null(s);
        assert_int_equal(live, 0);
        snprintf(number, sizeof number, "GL_MAX_TEXTURE_SIZE %d", (int)most);
        assert_non_null(strstr(said, "sampling_triangles: "));
        assert_non_null(strstr(said, number));
    }
    most = 4096;
    assert_int_equal(btf_gl_light_sampling_create(tables, &faked, &hearing, &s), BTF_OK);
    assert_int_equal(live, 2);
    btf_gl_light_sampling_destroy(&s);
    assert_int_equal(live, 0);
    assert_int_equal(btf_gl_light_sampling_create(NULL, &faked, &hearing, &s), BTF_ERROR_USAGE);
    assert_null(s);
    assert_int_equal(btf_gl_light_sampling_create(tables, &faked, &hearing, NULL), BTF_ERROR_USAGE);
    assert_int_equal(btf_gl_light_sampling_create(tables, NULL, &hearing, &s), BTF_ERROR_USAGE);
    assert_int_equal(btf_gl_light_sampling_create(tables, &none, &hearing, &s), BTF_ERROR_USAGE);
    assert_null(s);
}

RUN_TESTS(setup, teardown)
