/* The loader: what it uploads, restores, refuses and frees; and two materials in one program.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "check.h"
#include "decoder/toolkit/reference_view.h"
#include "tests/support/refusals.h"
#include "tests/support/test.h"
#include "variant.h"

static gpu *device;
static const gl_api *api; /* of the device */
static btf_material *tight, *paper;

static btf_gl_function real(const char *name) {
    btf_gl_options o = gpu_gl_options(device, NULL);
    return o.get_proc_address(o.user, name);
}

/* Answers that a faked context gives in place of the real one's. */
static struct {
    const char *missing;
    GLint texture_size, layers, major, minor; /* 0: as it is */
    const char *version;
    int live;         /* textures made and not deleted */
    int wrong_levels; /* mip levels get other texels than those uploaded */
    int wrong_layers; /* array layers get other texels than those uploaded */
} fake;

static int as_it_is(void **state) {
    (void)state;
    memset(&fake, 0, sizeof fake);
    return 0;
}
#define FAKE_TEST(name) TEST_WITH(name, as_it_is, NULL)

static void APIENTRY fake_get_integer(GLenum name, GLint *value) {
    api->GetIntegerv(name, value);
    if (name == GL_MAX_TEXTURE_SIZE && fake.texture_size) {
        *value = fake.texture_size;
    }
    if (name == GL_MAX_ARRAY_TEXTURE_LAYERS && fake.layers) {
        *value = fake.layers;
    }
    if (name == GL_MAJOR_VERSION && fake.major) {
        *value = fake.major;
    }
    if (name == GL_MINOR_VERSION && fake.major) {
        *value = fake.minor;
    }
}

static const GLubyte *APIENTRY fake_get_string(GLenum name) {
    if (name == GL_VERSION && fake.version) {
        return (const GLubyte *)fake.version;
    }
    return api->GetString(name);
}

static void APIENTRY fake_gen_textures(GLsizei count, GLuint *names) {
    fake.live += count;
    api->GenTextures(count, names);
}

static void APIENTRY fake_delete_textures(GLsizei count, const GLuint *names) {
    fake.live -= count;
    api->DeleteTextures(count, names);
}

static void APIENTRY fake_tex_image(GLenum target, GLint level, GLint internal, GLsizei width,
                                    GLsizei height, GLint border, GLenum format, GLenum type,
                                    const void *data) {
    static const uint32_t zeros[64];
    api->TexImage2D(target, level, internal, width, height, border, format, type,
                    fake.wrong_levels && level > 0 ? zeros : data);
}

static void APIENTRY fake_tex_image_3d(GLenum target, GLint level, GLint internal, GLsizei width,
                                       GLsizei height, GLsizei depth, GLint border, GLenum format,
                                       GLenum type, const void *data) {
    static const uint32_t zeros[64];
    api->TexImage3D(target, level, internal, width, height, depth, border, format, type,
                    fake.wrong_layers ? zeros : data);
}

static btf_gl_function fake_get_proc_address(void *user, const char *name) {
    static const struct {
        const char *name;
        btf_gl_function function;
    } ours[] = {{"glGetIntegerv", (btf_gl_function)fake_get_integer},
                {"glGetString", (btf_gl_function)fake_get_string},
                {"glGenTextures", (btf_gl_function)fake_gen_textures},
                {"glTexImage2D", (btf_gl_function)fake_tex_image},
                {"glTexImage3D", (btf_gl_function)fake_tex_image_3d},
                {"glDeleteTextures", (btf_gl_function)fake_delete_textures}};
    (void)user;
    if (fake.missing && strcmp(name, fake.missing) == 0) {
        return NULL;
    }
    for (size_t i = 0; i < sizeof ours / sizeof *ours; ++i) {
        if (strcmp(name, ours[i].name) == 0) {
            return ours[i].function;
        }
    }
    return real(name);
}

static const btf_gl_options faked = {sizeof faked, fake_get_proc_address, NULL, NULL};

/* An upload through the faked context must fail with this result and message, and leave no texture. */
static void expect_refusal(const btf_material *material, btf_result result, const char *words) {
    btf_gl *gl = (btf_gl *)&fake;
    fake.live = 0;
    assert_int_equal(btf_gl_upload(material, &faked, &log_keep, &gl), result);
    assert_null(gl);
    assert_int_equal(fake.live, 0);
    if (!strstr(last_message, words)) {
        fail_msg("\"%s\" does not say \"%s\"", last_message, words);
    }
}

FAKE_TEST(limits_are_told_with_both_numbers) {
    fake.texture_size = 16;
    expect_refusal(tight, BTF_ERROR_UNSUPPORTED, "sbrdf: width 24 exceeds GL_MAX_TEXTURE_SIZE 16");
    fake.texture_size = 100;
    expect_refusal(paper, BTF_ERROR_UNSUPPORTED, "exceeds GL_MAX_TEXTURE_SIZE 100 (btf_material_to_tight");
    fake.texture_size = 0;
    fake.layers = 12;
    expect_refusal(tight, BTF_ERROR_UNSUPPORTED, "shadow: 13 layers exceed GL_MAX_ARRAY_TEXTURE_LAYERS 12");
}

/* An atlas that is larger than the context allows is uploaded in layout tight. */
FAKE_TEST(an_atlas_too_large_is_taken_apart) {
    int fits = -1;
    btf_material *whole = NULL, *apart = NULL;
    btf_gl *gl = NULL;
    const synthetic_spec spec = {.seed = 3,
                                 .width = 64,
                                 .height = 40,
                                 .n_views = 60,
                                 .n_lights = 50,
                                 .layout = BTF_LAYOUT_PAPER,
                                 .lobes = 1,
                                 .effects = 11};
    assert_int_equal(synthetic_create(&spec, &log_keep, &whole), BTF_OK);
    assert_true(btf_material_texture(whole, BTF_TEXTURE_MAPS).width >
                256); /* which the direction tables need */
    assert_int_equal(btf_gl_fits(whole, &faked, &log_keep, &fits), BTF_OK);
    assert_int_equal(fits, 1);
    fake.texture_size = 256;
    assert_int_equal(btf_gl_fits(whole, &faked, &log_keep, &fits), BTF_OK);
    assert_int_equal(fits, 0);
    assert_int_equal(btf_material_to_tight(whole, &log_keep, &apart), BTF_OK);
    assert_int_equal(btf_gl_fits(apart, &faked, &log_keep, &fits), BTF_OK);
    assert_int_equal(fits, 1);
    assert_int_equal(btf_gl_upload(apart, &faked, &log_keep, &gl), BTF_OK);
    btf_gl_destroy(&gl);
    btf_material_close(&apart);
    btf_material_close(&whole);
}

FAKE_TEST(old_and_partial_contexts_are_refused) {
    fake.missing = "glTexImage3D";
    expect_refusal(tight, BTF_ERROR_UNSUPPORTED, "lacks the function glTexImage3D");
    fake.missing = NULL;
    fake.version = "OpenGL ES 2.0 old";
    fake.major = 2;
    expect_refusal(tight, BTF_ERROR_UNSUPPORTED, "but OpenGL ES 3.0 or later is needed");
    fake.version = "3.2 old";
    fake.major = 3;
    fake.minor = 2;
    expect_refusal(tight, BTF_ERROR_UNSUPPORTED, "but OpenGL 3.3 or later is needed");
    btf_gl *gl;
    btf_gl_options none = {.struct_size = sizeof none};
    assert_int_equal(btf_gl_upload(tight, &none, &log_keep, &gl), BTF_ERROR_USAGE);
    assert_int_equal(btf_gl_upload(tight, NULL, NULL, &gl), BTF_ERROR_USAGE);
}

/* Wrong mip levels set a bit of the self-test of their own: the device can still decode materials of one level. */
FAKE_TEST(wrong_mip_levels_are_told) {
    uint32_t failures;
    char names[200];
    assert_int_equal(btf_gl_self_test(&faked, &log_keep, &failures), BTF_OK);
    assert_int_equal(failures, 0);
    fake.wrong_levels = 1;
    assert_int_equal(btf_gl_self_test(&faked, &log_keep, &failures), BTF_OK);
    assert_int_equal(failures, BTF_SELF_TEST_LEVELS);
    btf_self_test_names(failures, names, sizeof names);
    assert_string_equal(names, "levels");
    assert_int_equal(fake.live, 0);
    fake.wrong_layers = 1;
    assert_int_equal(btf_gl_self_test(&faked, &log_keep, &failures), BTF_OK);
    assert_int_equal(failures, BTF_SELF_TEST_LEVELS | BTF_SELF_TEST_FACTORS | BTF_SELF_TEST_LISTS);
    btf_self_test_names(failures, names, sizeof names);
    assert_string_equal(names, "levels, factors, lists");
    assert_int_equal(fake.live, 0);
}

FAKE_TEST(frees_what_it_made) {
    btf_gl *gl;
    assert_int_equal(btf_gl_upload(tight, &faked, &log_keep, &gl), BTF_OK);
    assert_int_equal(fake.live, 10); /* all but `maps` */
    btf_material_info info = accepted_info(tight);
    assert_int_equal(btf_gl_bytes(gl), info.gpu_bytes + info.table_bytes);
    GLuint name = btf_gl_texture(gl, BTF_TEXTURE_SHADOW);
    assert_true(api->IsTexture(name));
    assert_int_equal(btf_gl_texture(gl, BTF_TEXTURE_MAPS), 0);
    btf_gl_destroy(&gl);
    assert_null(gl);
    btf_gl_destroy(&gl);
    btf_gl_destroy(NULL);
    assert_int_equal(fake.live, 0);
    assert_false(api->IsTexture(name));
}

TEST(uploads_what_a_variant_reads) {
    btf_shader_options shader = {.struct_size = sizeof shader,
                                 .leave_out = BTF_EFFECT_SHADOW | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN,
                                 .components = 4};
    btf_gl_options options = gpu_gl_options(device, &shader);
    btf_material_info info = accepted_info(tight);
    btf_gl *gl;
    assert_int_equal(btf_gl_upload(tight, &options, &log_keep, &gl), BTF_OK);
    /* decoding the shift needs the gain's codes, which say which points are hidden */
    uint32_t expected = 1u << BTF_TEXTURE_SBRDF | 1u << BTF_TEXTURE_SHIFT | 1u << BTF_TEXTURE_GAIN |
                        1u << BTF_TEXTURE_RESIDUAL_TEXELS | 1u << BTF_TEXTURE_RESIDUAL_DIRECTIONS |
                        1u << BTF_TEXTURE_RESIDUAL_SCALES | 1u << BTF_TEXTURE_VIEW_TABLE |
                        1u << BTF_TEXTURE_LIGHT_TABLE;
    assert_int_equal(btf_shader_textures(&info, &shader), expected);
    size_t bytes = 0;
    for (int id = 0; id < BTF_TEXTURE_COUNT; ++id) {
        assert_int_equal(btf_gl_texture(gl, (btf_texture_id)id) != 0, expected >> id & 1);
        btf_texture t = btf_material_texture(tight, (btf_texture_id)id);
        if (expected >> id & 1) {
            bytes += id == BTF_TEXTURE_RESIDUAL_TEXELS || id == BTF_TEXTURE_RESIDUAL_DIRECTIONS ? t.size / 2
                                                                                                : t.size;
        }
    }
    assert_int_equal(btf_gl_bytes(gl), bytes); /* four of six components are one of two layers */
    /* A program that reads more is refused at binding. */
    char *text;
    assert_int_equal(btf_shader_source(tight, NULL, &log_keep, &text), BTF_OK);
    static const char body[] =
        "uvec4 check(uvec4 a, uvec4 b) {\n"
        "    vec3 d = uintBitsToFloat(a.xyz);\n"
        "    return floatBitsToUint(btf_evaluate(d.xy, d, uintBitsToFloat(b.xyz))).xyzz;\n"
        "}\n";
    unsigned program = gpu_program(device, NULL, text, body, &log_keep);
    btf_free(text);
    assert_int_not_equal(program, 0);
    assert_int_equal(btf_gl_bind(gl, program, GPU_FIRST_UNIT, NULL, &log_keep, NULL), BTF_ERROR_USAGE);
    assert_non_null(strstr(last_message, "btf_shadow, which was not uploaded"));
    gpu_delete_program(device, program);
    btf_gl_destroy(&gl);
}

static GLint layers_on_device(const btf_gl *gl, btf_texture_id id, GLint level) {
    GLint layers = -1;
    api->BindTexture(GL_TEXTURE_2D_ARRAY, btf_gl_texture(gl, id));
    api->GetTexLevelParameteriv(GL_TEXTURE_2D_ARRAY, level, GL_TEXTURE_DEPTH, &layers);
    api->BindTexture(GL_TEXTURE_2D_ARRAY, 0);
    return layers;
}

/* A unit is one layer of factor_texels, two in classes 1 and 3, at every level. A context with few layers holds the
 * first units. */
FAKE_TEST(uploads_the_first_units) {
    enum { UNITS = 9, WIDTH = 8, HEIGHT = 6, LEVELS = 3, VIEWS = 5, LIGHTS = 4 };
    static const GLint layers[UNITS + 1] = {0, 1, 2, 4, 5, 6, 7, 9, 10, 11};
    synthetic_spec spec = {.seed = 23,
                           .width = WIDTH,
                           .height = HEIGHT,
                           .n_views = VIEWS,
                           .n_lights = LIGHTS,
                           .layout = BTF_LAYOUT_TIGHT,
                           .colour = BTF_COLOUR_MONO,
                           .lobes = 1,
                           .effects = BTF_EFFECT_RESIDUAL,
                           .components = UNITS,
                           .levels = LEVELS,
                           .classes = {{2, 3, 2}, {1, 1, 1}, {3, 0, 0}, {1, 2, 0}, {2, 0, 1}}};
    btf_material *material = NULL;
    assert_int_equal(synthetic_create(&spec, &log_keep, &material), BTF_OK);
    btf_material_info info = accepted_info(material);
    for (uint32_t units = 1; units <= UNITS; ++units) {
        const btf_shader_options shader = {.struct_size = sizeof shader, .components = units};
        btf_gl_options options = faked;
        options.shader = &shader;
        btf_gl *gl;
        assert_int_equal(btf_gl_upload(material, &options, &log_keep, &gl), BTF_OK);
        assert_int_equal(fake.live, 7); /* the SBRDF, four of factors, two tables */
        size_t bytes = info.table_bytes + (size_t)16 * VIEWS * LIGHTS * units;
        for (GLint level = 0; level < LEVELS; ++level) {
            assert_int_equal(layers_on_device(gl, BTF_TEXTURE_FACTOR_TEXELS, level), layers[units]);
            bytes += (size_t)16 * (WIDTH >> level) * (HEIGHT >> level) * (size_t)(2 + layers[units]);
        }
        assert_int_equal(layers_on_device(gl, BTF_TEXTURE_FACTOR_DIRECTIONS, 0), units);
        assert_int_equal(btf_gl_bytes(gl), bytes);
        btf_gl_destroy(&gl);
        assert_int_equal(fake.live, 0);
        for (fake.layers = 2; fake.layers < 14; ++fake.layers) {
            int fits = -1;
            assert_int_equal(btf_gl_fits(material, &options, &log_keep, &fits), BTF_OK);
            assert_int_equal(fits, fake.layers >= layers[units]);
        }
        fake.layers = 0;
    }
    fake.layers = 10;
    expect_refusal(material, BTF_ERROR_UNSUPPORTED,
                   "factor_texels: 11 layers exceed GL_MAX_ARRAY_TEXTURE_LAYERS 10");
    btf_material_close(&material);
}

/* State that a program may have set: every entry must be as it was. */
static const GLenum state_names[] = {
    GL_ACTIVE_TEXTURE,
    GL_SAMPLER_BINDING,
    GL_TEXTURE_BINDING_2D,
    GL_TEXTURE_BINDING_2D_ARRAY,
    GL_UNPACK_ALIGNMENT,
    GL_UNPACK_ROW_LENGTH,
    GL_UNPACK_SKIP_ROWS,
    GL_UNPACK_SKIP_PIXELS,
    GL_UNPACK_SKIP_IMAGES,
    GL_UNPACK_IMAGE_HEIGHT,
    GL_UNPACK_SWAP_BYTES,
    GL_PIXEL_UNPACK_BUFFER_BINDING,
    GL_PIXEL_PACK_BUFFER_BINDING,
    GL_PACK_ROW_LENGTH,
    GL_PACK_SKIP_ROWS,
    GL_PACK_SKIP_PIXELS,
    GL_PACK_SWAP_BYTES,
    GL_CURRENT_PROGRAM,
    GL_VERTEX_ARRAY_BINDING,
    GL_DRAW_FRAMEBUFFER_BINDING,
    GL_READ_FRAMEBUFFER_BINDING,
    GL_SCISSOR_TEST,
    GL_DEPTH_TEST,
    GL_CULL_FACE,
    GL_RASTERIZER_DISCARD,
    GL_STENCIL_TEST,
};
enum { STATES = sizeof state_names / sizeof *state_names };

static void read_state(GLint out[STATES + 8]) {
    PFNGLGETINTEGERVPROC get = api->GetIntegerv;
    for (int i = 0; i < STATES; ++i) {
        get(state_names[i], &out[i]);
    }
    get(GL_VIEWPORT, out + STATES);
    get(GL_COLOR_WRITEMASK, out + STATES + 4);
}

static void set_state(int odd, GLuint texture, GLuint array, GLuint buffer) {
    PFNGLPIXELSTOREIPROC store = api->PixelStorei;
    static const GLenum skips[] = {GL_UNPACK_ROW_LENGTH,  GL_UNPACK_SKIP_ROWS,    GL_UNPACK_SKIP_PIXELS,
                                   GL_UNPACK_SKIP_IMAGES, GL_UNPACK_IMAGE_HEIGHT, GL_PACK_ROW_LENGTH,
                                   GL_PACK_SKIP_ROWS,     GL_PACK_SKIP_PIXELS};
    for (size_t i = 0; i < sizeof skips / sizeof *skips; ++i) {
        store(skips[i], odd ? 3 + (GLint)i : 0);
    }
    store(GL_UNPACK_SWAP_BYTES, odd);
    store(GL_PACK_SWAP_BYTES, odd);
    store(GL_UNPACK_ALIGNMENT, odd ? 8 : 4);
    api->ActiveTexture(odd ? GL_TEXTURE5 : GL_TEXTURE0);
    api->BindTexture(GL_TEXTURE_2D, texture);
    api->BindTexture(GL_TEXTURE_2D_ARRAY, array);
    api->BindBuffer(GL_PIXEL_UNPACK_BUFFER, buffer);
    api->BindBuffer(GL_PIXEL_PACK_BUFFER, buffer);
    static const GLenum tests[] = {GL_SCISSOR_TEST, GL_DEPTH_TEST, GL_CULL_FACE, GL_RASTERIZER_DISCARD,
                                   GL_STENCIL_TEST};
    for (size_t i = 0; i < sizeof tests / sizeof *tests; ++i) {
        (odd ? api->Enable : api->Disable)(tests[i]);
    }
    api->ColorMask(GL_TRUE, !odd, GL_TRUE, !odd);
    api->Viewport(odd, odd, 40 + odd, 30);
}

TEST(state_is_restored) {
    GLuint textures[2], buffer, sampler;
    api->GenSamplers(1, &sampler); /* filters as no integer texture can be */
    api->GenTextures(2, textures);
    api->GenBuffers(1, &buffer);
    for (int odd = 1; odd >= 0; --odd) {
        GLint before[STATES + 8] = {0}, after[STATES + 8] = {0};
        set_state(odd, odd ? textures[0] : 0, odd ? textures[1] : 0, odd ? buffer : 0);
        api->BindSampler(odd ? 5 : 0, odd ? sampler : 0);
        read_state(before);
        btf_gl_options options = gpu_gl_options(device, NULL);
        btf_gl *gl;
        uint32_t failures;
        assert_int_equal(btf_gl_upload(paper, &options, &log_keep, &gl), BTF_OK);
        read_state(after);
        assert_memory_equal(before, after, sizeof before);
        assert_int_equal(btf_gl_self_test(&options, &log_keep, &failures), BTF_OK);
        assert_int_equal(failures, 0);
        read_state(after);
        assert_memory_equal(before, after, sizeof before);
        btf_gl_destroy(&gl);
        assert_int_equal(api->GetError(), GL_NO_ERROR);
    }
    api->DeleteTextures(2, textures);
    api->DeleteBuffers(1, &buffer);
    api->DeleteSamplers(1, &sampler);
}

/* Texels are uploaded correctly under any unpacking state. */
TEST(unpacking_state_does_not_matter) {
    set_state(1, 0, 0, 0);
    btf_gl_options options = gpu_gl_options(device, NULL);
    btf_gl *gl;
    assert_int_equal(btf_gl_upload(tight, &options, &log_keep, &gl), BTF_OK);
    set_state(0, 0, 0, 0);
    btf_texture t = btf_material_texture(tight, BTF_TEXTURE_GAIN);
    uint8_t *back = malloc(t.size);
    assert_non_null(back);
    api->BindTexture(GL_TEXTURE_2D_ARRAY, btf_gl_texture(gl, BTF_TEXTURE_GAIN));
    api->PixelStorei(GL_PACK_ALIGNMENT, 1);
    api->GetTexImage(GL_TEXTURE_2D_ARRAY, 0, GL_RED_INTEGER, GL_UNSIGNED_BYTE, back);
    api->PixelStorei(GL_PACK_ALIGNMENT, 4);
    assert_memory_equal(back, t.data, t.size);
    free(back);
    api->BindTexture(GL_TEXTURE_2D_ARRAY, 0);
    btf_gl_destroy(&gl);
}

/* Two decoders with different prefixes in one program, two sets of textures bound at once: even pixels show one
 * material, odd ones the other, both with the reference's bits. */
TEST(two_materials_share_a_program) {
    enum { COUNT = 4096 };
    static const char body[] =
        "uvec4 check(uvec4 a, uvec4 b) {\n"
        "    vec2 uv = uintBitsToFloat(a.xy);\n"
        "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x)), v = uintBitsToFloat(b.yzw);\n"
        "    vec3 r = (uint(gl_FragCoord.x) & 1u) == 0u ? btf_evaluate(uv, l, v) : the_wall2_evaluate(uv, "
        "l, v);\n"
        "    return uvec4(floatBitsToUint(r), 0u);\n"
        "}\n";
    btf_shader_options second = {
        .struct_size = sizeof second, .filter = BTF_FILTER_BILINEAR, .prefix = "the_wall2"};
    char *texts[2];
    assert_int_equal(btf_shader_source(tight, NULL, &log_keep, &texts[0]), BTF_OK);
    assert_int_equal(btf_shader_source(paper, &second, &log_keep, &texts[1]), BTF_OK);
    assert_null(strstr(texts[1], "btf_"));
    char *both = malloc(strlen(texts[0]) + strlen(texts[1]) + 1);
    assert_non_null(both);
    strcpy(both, texts[0]);
    strcat(both, texts[1]);
    unsigned program = gpu_program(device, "#define BTF_HAVE_PRECISE 0\n", both, body, &log_keep);
    if (!program) {
        fail_msg("%s", last_message);
    }
    free(both);
    btf_free(texts[0]);
    btf_free(texts[1]);
    btf_gl_options options = gpu_gl_options(device, NULL);
    btf_gl *gl[2];
    uint32_t units;
    assert_int_equal(btf_gl_upload(tight, &options, &log_keep, &gl[0]), BTF_OK);
    assert_int_equal(btf_gl_upload(paper, &options, &log_keep, &gl[1]), BTF_OK);
    assert_int_equal(btf_gl_bind(gl[0], program, GPU_FIRST_UNIT, NULL, &log_keep, &units), BTF_OK);
    assert_int_equal(units, 10);
    assert_int_equal(btf_gl_bind(gl[1], program, GPU_FIRST_UNIT + units, "the_wall2", &log_keep, &units),
                     BTF_OK);
    assert_int_equal(units, 4);

    btf_ref_material reference[2];
    reference_view(tight, 0, &reference[0]);
    reference_view(paper, 0, &reference[1]);
    btf_ref_options how[2] = {variant_reference_options(&(btf_shader_options){0}),
                              variant_reference_options(&second)};
    uint32_t *inputs = calloc(COUNT, GPU_INPUTS * sizeof *inputs),
             *outputs = calloc(COUNT, GPU_OUTPUTS * sizeof *outputs);
    assert_non_null(inputs);
    assert_non_null(outputs);
    random_state r = {77};
    for (size_t i = 0; i < COUNT; ++i) {
        case_make(&r, i & 1 ? paper : tight, inputs + GPU_INPUTS * i);
    }
    assert_int_equal(gpu_run(device, program, COUNT, inputs, outputs, &log_keep), BTF_OK);
    for (size_t i = 0; i < COUNT; ++i) {
        float f[8], rgb[3];
        memcpy(f, inputs + GPU_INPUTS * i, sizeof f);
        btf_ref_evaluate(&reference[i & 1], &how[i & 1], f[0], f[1], f + 2, f + 5, rgb);
        assert_memory_equal(rgb, outputs + GPU_OUTPUTS * i, sizeof rgb);
    }
    free(inputs);
    free(outputs);
    gpu_delete_program(device, program);
    btf_gl_destroy(&gl[0]);
    btf_gl_destroy(&gl[1]);
}

/* The library's random numbers are those of the reference, with which conformance compares the shader's. */
TEST(random_numbers_of_a_counter) {
    random_state r = {3};
    for (int i = 0; i < 1000; ++i) {
        const uint32_t counter[3] = {(uint32_t)random_bits(&r), (uint32_t)random_bits(&r), (uint32_t)i};
        uint32_t of_library[3], of_reference[3];
        btf_random(counter, of_library);
        btf_ref_random(counter, of_reference);
        assert_memory_equal(of_library, of_reference, sizeof of_library);
    }
}

TEST(options_are_checked) {
    static const char *const wrong[] = {"",
                                        "Upper",
                                        "two__underscores",
                                        "ends_",
                                        "1digit",
                                        "gl",
                                        "gl_x",
                                        "a b",
                                        "_under",
                                        "x234567890123456789012345678901234"};
    char *text;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        btf_shader_options o = {.struct_size = sizeof o, .prefix = wrong[i]};
        assert_int_equal(btf_shader_source(tight, &o, &log_keep, &text), BTF_ERROR_USAGE);
        assert_null(text);
        assert_non_null(strstr(last_message, wrong[i]));
    }
    btf_shader_options o = {.struct_size = sizeof o, .filter = (btf_filter)7};
    assert_int_equal(btf_shader_source(tight, &o, &log_keep, &text), BTF_ERROR_USAGE);
    assert_non_null(strstr(last_message, "filter 7"));
    o = (btf_shader_options){.struct_size = sizeof o, .picks = (btf_picks)4};
    assert_int_equal(btf_shader_source(tight, &o, &log_keep, &text), BTF_ERROR_USAGE);
    assert_non_null(strstr(last_message, "picks 4"));
    o = (btf_shader_options){.struct_size = sizeof o, .picks = BTF_PICK_ALL, .prefix = "cloth"};
    assert_int_equal(btf_shader_source(tight, &o, &log_keep, &text), BTF_OK);
    assert_non_null(strstr(text, "#define CLOTH_STOCHASTIC 3\n"));
    assert_non_null(strstr(text, "vec3 cloth_evaluate_stochastic("));
    btf_free(text);
    /* options of an older, shorter struct: members that it lacks have their defaults */
    btf_shader_options old = {.struct_size = offsetof(btf_shader_options, filter), .filter = (btf_filter)7};
    assert_int_equal(btf_shader_source(tight, &old, &log_keep, &text), BTF_OK);
    assert_non_null(strstr(text, "#define BTF_BILINEAR 0\n"));
    btf_free(text);
    btf_shader_options bindings = {.struct_size = sizeof bindings,
                                   .bindings = BTF_BINDINGS_VULKAN,
                                   .first_binding = 20,
                                   .descriptor_set = 3};
    assert_int_equal(btf_shader_source(tight, &bindings, &log_keep, &text), BTF_OK);
    assert_non_null(strstr(text, "#define BTF_BINDING_RESIDUAL_TEXELS 26\n"));
    assert_non_null(strstr(text, "layout(set = 3, binding = n) uniform\n"));
    btf_free(text);
    o = (btf_shader_options){.struct_size = sizeof o, .language = (btf_language)2};
    assert_int_equal(btf_shader_source(tight, &o, &log_keep, &text), BTF_ERROR_USAGE);
    assert_non_null(strstr(last_message, "language 2"));
    /* WGSL has bindings whatever `bindings` says, and the zero whatever `have_precise` says. */
    o = (btf_shader_options){.struct_size = sizeof o,
                             .language = BTF_LANGUAGE_WGSL,
                             .prefix = "cloth",
                             .have_precise = 1,
                             .first_binding = 20,
                             .descriptor_set = 3};
    assert_int_equal(btf_shader_source(tight, &o, &log_keep, &text), BTF_OK);
    assert_non_null(strstr(text, "fn cloth_evaluate(uv: vec2f, l: vec3f, v: vec3f) -> vec3f {\n"));
    assert_non_null(strstr(text, "@group(3) @binding(29) var cloth_view_table: texture_2d<u32>;\n"));
    assert_non_null(strstr(text, "@group(3) @binding(43) var<uniform> cloth_zero: u32;\n"));
    btf_free(text);
}

static int setup(void **state) {
    (void)state;
    device = gpu_create_or_skip(&context_devices[0]);
    api = gpu_api(device);
    /* clang-format off */
    synthetic_spec a = {
        .seed = 21, .width = 24, .height = 17, .n_views = 7, .n_lights = 13, .layout = BTF_LAYOUT_TIGHT,
        .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_RGB, .lobes = 2, .half_float = 1,
        .effects = BTF_EFFECT_VERSION_1, .components = 6, .centres = 100, .directions = SYNTHETIC_RANDOM,
    };
    /* clang-format on */
    synthetic_spec b = {.seed = 22,
                        .width = 16,
                        .height = 16,
                        .n_views = 19,
                        .n_lights = 19,
                        .layout = BTF_LAYOUT_PAPER,
                        .colour = BTF_COLOUR_MONO,
                        .lobes = 3,
                        .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN,
                        .centres = 100};
    return synthetic_create(&a, &log_keep, &tight) != BTF_OK ||
           synthetic_create(&b, &log_keep, &paper) != BTF_OK;
}

static int teardown(void **state) {
    (void)state;
    btf_material_close(&tight);
    btf_material_close(&paper);
    gpu_destroy(&device);
    return 0;
}

RUN_TESTS(setup, teardown)
