/* Levels of detail on a device: uploaded as mip levels; btf_level finds one from derivatives; btf_evaluate
 * stays at level 0.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "check.h"
#include "decoder/toolkit/reference_view.h"
#include "tests/support/messages.h"
#include "tests/support/test.h"
#include "variant.h"

enum { WIDTH = 20, HEIGHT = 7, LEVELS = 5 };

static gpu *device;
static const gl_api *api; /* of the device */
static btf_material *material;
static btf_material_info info = {.struct_size = sizeof info};

static GLint texture_parameter(GLenum target, GLenum name) {
    GLint value = -1;
    api->GetTexParameteriv(target, name, &value);
    return value;
}

static GLint level_parameter(GLenum target, GLint level, GLenum name) {
    GLint value = -1;
    api->GetTexLevelParameteriv(target, level, name, &value);
    return value;
}

TEST(uploaded_as_mip_levels) {
    btf_gl_options options = gpu_gl_options(device, NULL);
    btf_gl *gl;
    assert_int_equal(btf_gl_upload(material, &options, &log_print, &gl), BTF_OK);
    assert_int_equal(btf_gl_bytes(gl), info.gpu_bytes + info.table_bytes);
    for (int id = 0; id < BTF_TEXTURE_COUNT; ++id) {
        btf_texture t = btf_material_texture(material, (btf_texture_id)id);
        GLuint name = btf_gl_texture(gl, (btf_texture_id)id);
        assert_int_equal(name != 0, t.format != BTF_FORMAT_NONE);
        if (!name) {
            continue;
        }
        GLenum target = t.is_array ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D;
        api->BindTexture(target, name);
        int levels = btf_material_level_texture(material, 1, (btf_texture_id)id).format ? LEVELS : 1;
        assert_int_equal(texture_parameter(target, GL_TEXTURE_MAX_LEVEL), levels - 1);
        assert_int_equal(texture_parameter(target, GL_TEXTURE_MIN_FILTER),
                         levels > 1 ? GL_NEAREST_MIPMAP_NEAREST : GL_NEAREST);
        for (int level = 0; level < levels; ++level) {
            t = btf_material_level_texture(material, (uint32_t)level, (btf_texture_id)id);
            assert_int_equal(level_parameter(target, level, GL_TEXTURE_WIDTH), t.width);
            assert_int_equal(level_parameter(target, level, GL_TEXTURE_HEIGHT), t.height);
            assert_int_equal(level_parameter(target, level, GL_TEXTURE_DEPTH), t.layers);
        }
        api->BindTexture(target, 0);
    }
    btf_gl_destroy(&gl);
}

/* Four of six components are one of two layers, at every level. */
TEST(uploads_what_a_variant_reads) {
    btf_shader_options shader = {.struct_size = sizeof shader,
                                 .leave_out = BTF_EFFECT_ALL & ~(uint32_t)BTF_EFFECT_RESIDUAL,
                                 .components = 4};
    btf_gl_options options = gpu_gl_options(device, &shader);
    size_t bytes =
        btf_material_texture(material, BTF_TEXTURE_RESIDUAL_DIRECTIONS).size / 2 + info.table_bytes;
    for (uint32_t level = 0; level < LEVELS; ++level) {
        bytes += btf_material_level_texture(material, level, BTF_TEXTURE_SBRDF).size +
                 btf_material_level_texture(material, level, BTF_TEXTURE_RESIDUAL_TEXELS).size / 2;
    }
    btf_gl *gl;
    assert_int_equal(btf_gl_upload(material, &options, &log_print, &gl), BTF_OK);
    assert_int_equal(btf_gl_bytes(gl), bytes);
    btf_gl_destroy(&gl);
}

/* Runs `body` over `count` elements with the material bound. */
static void run(const char *body, size_t count, const uint32_t *inputs, uint32_t *outputs) {
    char *text;
    assert_int_equal(btf_shader_source(material, NULL, &log_print, &text), BTF_OK);
    unsigned program = gpu_program(device, NULL, text, body, &log_print);
    btf_free(text);
    assert_int_not_equal(program, 0);
    btf_gl_options options = gpu_gl_options(device, NULL);
    btf_gl *gl;
    assert_int_equal(btf_gl_upload(material, &options, &log_print, &gl), BTF_OK);
    assert_int_equal(btf_gl_bind(gl, program, GPU_FIRST_UNIT, NULL, &log_print, NULL), BTF_OK);
    assert_int_equal(gpu_run(device, program, count, inputs, outputs, &log_print), BTF_OK);
    gpu_delete_program(device, program);
    btf_gl_destroy(&gl);
}

static float as_float(uint32_t bits) {
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

TEST(level_of_two_steps) {
    static const char body[] = "uvec4 check(uvec4 a, uvec4 b) {\n"
                               "    vec4 d = uintBitsToFloat(a);\n"
                               "    return uvec4(floatBitsToUint(btf_level(d.xy, d.zw)), b.xyz);\n"
                               "}\n";
    static const struct {
        float dx[2], dy[2], level;
    } cases[] = {
        {{0, 0}, {0, 0}, 0},
        {{1.0f / WIDTH, 0}, {0, 1.0f / HEIGHT}, 0},
        {{0.5f / WIDTH, 0}, {0, 0.25f / HEIGHT}, 0},          /* magnified */
        {{4.0f / WIDTH, 0}, {0, 2.0f / HEIGHT}, 2},           /* the longer step counts */
        {{1.0f / WIDTH, 0}, {0, 8.0f / HEIGHT}, 3},           /* in texels, not in uv */
        {{-3.0f / WIDTH, 4.0f / HEIGHT}, {0, 0}, 2.3219281f}, /* five texels */
        {{0, 0}, {6.0f / WIDTH, -8.0f / HEIGHT}, 3.3219281f},
        {{30, 0}, {0, 1}, LEVELS - 1},
        {{1e30f, 1e30f}, {0, 0}, LEVELS - 1},
    };
    enum { COUNT = sizeof cases / sizeof *cases };
    uint32_t inputs[COUNT][GPU_INPUTS] = {{0}}, outputs[COUNT][GPU_OUTPUTS];
    for (int i = 0; i < COUNT; ++i) {
        memcpy(inputs[i], cases[i].dx, sizeof cases[i].dx);
        memcpy(inputs[i] + 2, cases[i].dy, sizeof cases[i].dy);
    }
    run(body, COUNT, inputs[0], outputs[0]);
    for (int i = 0; i < COUNT; ++i) {
        if (!(fabsf(as_float(outputs[i][0]) - cases[i].level) < 1e-3f)) {
            fail_msg("case %d: level %g, not %g", i, (double)as_float(outputs[i][0]),
                     (double)cases[i].level);
        }
    }
}

/* From uv to level: a surface on which one pixel steps over four columns and three rows. */
TEST(level_of_derivatives) {
    static const char body[] =
        "uvec4 check(uvec4 a, uvec4 b) {\n"
        "    vec2 uv = gl_FragCoord.xy * vec2(4.0, 3.0) / vec2(BTF_WIDTH, BTF_HEIGHT);\n"
        "    return uvec4(int(btf_level(dFdx(uv), dFdy(uv)) + 0.5), a.x + b.x, 0, 0);\n"
        "}\n";
    enum { COUNT = GPU_SIDE * 2 };
    uint32_t *inputs = calloc(COUNT, GPU_INPUTS * sizeof *inputs),
             *outputs = calloc(COUNT, GPU_OUTPUTS * sizeof *outputs);
    assert_non_null(inputs);
    assert_non_null(outputs);
    run(body, COUNT, inputs, outputs);
    for (size_t i = 0; i < COUNT; ++i) {
        assert_int_equal(outputs[GPU_OUTPUTS * i], 2);
    }
    free(inputs);
    free(outputs);
}

TEST(evaluate_is_level_0) {
    static const char body[] =
        "uvec4 check(uvec4 a, uvec4 b) {\n"
        "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x)), v = uintBitsToFloat(b.yzw);\n"
        "    return uvec4(floatBitsToUint(btf_evaluate(uintBitsToFloat(a.xy), l, v)), 0u);\n"
        "}\n";
    enum { COUNT = 4096 };
    uint32_t *inputs = calloc(COUNT, GPU_INPUTS * sizeof *inputs),
             *outputs = calloc(COUNT, GPU_OUTPUTS * sizeof *outputs);
    assert_non_null(inputs);
    assert_non_null(outputs);
    random_state r = {78};
    for (size_t i = 0; i < COUNT; ++i) {
        case_make(&r, material, inputs + GPU_INPUTS * i);
    }
    run(body, COUNT, inputs, outputs);
    btf_ref_material reference;
    reference_view(material, 0, &reference);
    const btf_ref_options how = variant_reference_options(&(btf_shader_options){0});
    for (size_t i = 0; i < COUNT; ++i) {
        float f[8], rgb[3];
        memcpy(f, inputs + GPU_INPUTS * i, sizeof f);
        btf_ref_evaluate(&reference, &how, f[0], f[1], f + 2, f + 5, rgb);
        assert_memory_equal(rgb, outputs + GPU_OUTPUTS * i, sizeof rgb);
    }
    free(inputs);
    free(outputs);
}

static int setup(void **state) {
    (void)state;
    device = gpu_create_or_skip(&context_devices[1]);
    api = gpu_api(device);
    /* clang-format off */
    synthetic_spec spec = {
        .seed = 31, .width = WIDTH, .height = HEIGHT, .n_views = 7, .n_lights = 13,
        .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_RGB, .lobes = 2,
        .half_float = 1, .effects = BTF_EFFECT_VERSION_1, .components = 6, .centres = 100,
        .directions = SYNTHETIC_RANDOM, .levels = BTF_MAX_LEVELS,
    };
    /* clang-format on */
    return synthetic_create(&spec, &log_print, &material) != BTF_OK ||
           btf_material_get_info(material, &info) != BTF_OK || info.levels != LEVELS;
}

static int teardown(void **state) {
    (void)state;
    btf_material_close(&material);
    gpu_destroy(&device);
    return 0;
}

RUN_TESTS(setup, teardown)
