/* The GL state of an application, of compatibility contexts above all: it does not change uploads or the result of the
 * self-test, and the library restores it.
 *
 * SPDX-License-Identifier: MIT
 */
#include "synthetic.h"
#include "tests/support/refusals.h"
#include "tests/support/test.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
#include <GL/glext.h>
#include <openbtf/gl.h>

static unsigned char pixels[16 * 16 * 4];
static OSMesaContext contexts[2]; /* core, compatibility */
static btf_material *material; /* has a texture of each format but RGBA16F and RGBA32UI, which half_floats
                                  and factored have */
static btf_material *half_floats, *factored;

static void use(int compatibility) {
    if (!OSMesaMakeCurrent(contexts[compatibility], pixels, GL_UNSIGNED_BYTE, 16, 16)) {
        fail_msg("OSMesa does not take its context");
    }
}

/* The answers of the faked functions below, and the calls that they count. */
static struct {
    int profile_is_0, has_imaging;
    int transfers_called;                      /* calls of glPixelTransferf */
    int imaging[8];                            /* enabled, as the fake imaging subset has it */
    float transfer[16];                        /* its scales and biases */
    int imaging_in_upload, transfer_in_upload; /* that were not neutral when texels were given */
} fake;

static int imaging_index(GLenum name) {
    static const GLenum names[8] = {GL_COLOR_TABLE,    GL_POST_CONVOLUTION_COLOR_TABLE,
                                    GL_CONVOLUTION_1D, GL_POST_COLOR_MATRIX_COLOR_TABLE,
                                    GL_CONVOLUTION_2D, GL_SEPARABLE_2D,
                                    GL_HISTOGRAM,      GL_MINMAX};
    for (int i = 0; i < 8; ++i) {
        if (names[i] == name) {
            return i;
        }
    }
    return -1;
}

/* 0..7 after the convolution, 8..15 after the colour matrix; in both four scales, then four biases. */
static int transfer_index(GLenum name) {
    if (name >= GL_POST_CONVOLUTION_RED_SCALE && name <= GL_POST_CONVOLUTION_ALPHA_BIAS) {
        return (int)(name - GL_POST_CONVOLUTION_RED_SCALE);
    }
    if (name >= GL_POST_COLOR_MATRIX_RED_SCALE && name <= GL_POST_COLOR_MATRIX_ALPHA_BIAS) {
        return (int)(8 + name - GL_POST_COLOR_MATRIX_RED_SCALE);
    }
    return -1;
}

static void APIENTRY fake_get_integer(GLenum name, GLint *value) {
    glGetIntegerv(name, value);
    if (name == GL_CONTEXT_PROFILE_MASK && fake.profile_is_0) {
        *value = 0;
    }
}

static const GLubyte *APIENTRY fake_get_string(GLenum name) {
    return name == GL_EXTENSIONS && fake.has_imaging ? (const GLubyte *)"GL_ARB_imaging GL_ARB_other"
                                                     : glGetString(name);
}

static GLboolean APIENTRY fake_is_enabled(GLenum name) {
    int i = fake.has_imaging ? imaging_index(name) : -1;
    return i >= 0 ? (GLboolean)fake.imaging[i] : glIsEnabled(name);
}

static void APIENTRY fake_enable(GLenum name) {
    int i = fake.has_imaging ? imaging_index(name) : -1;
    if (i >= 0) {
        fake.imaging[i] = 1;
    } else {
        glEnable(name);
    }
}

static void APIENTRY fake_disable(GLenum name) {
    int i = fake.has_imaging ? imaging_index(name) : -1;
    if (i >= 0) {
        fake.imaging[i] = 0;
    } else {
        glDisable(name);
    }
}

static void APIENTRY fake_get_float(GLenum name, GLfloat *value) {
    int i = transfer_index(name);
    if (i >= 0) {
        *value = fake.transfer[i];
    } else {
        glGetFloatv(name, value);
    }
}

static void APIENTRY fake_pixel_transfer(GLenum name, GLfloat value) {
    int i = transfer_index(name);
    ++fake.transfers_called;
    if (i >= 0) {
        fake.transfer[i] = value;
    } else {
        glPixelTransferf(name, value);
    }
}

static void APIENTRY fake_tex_image(GLenum target, GLint level, GLint internal, GLsizei width,
                                    GLsizei height, GLint border, GLenum format, GLenum type,
                                    const void *data) {
    for (int i = 0; i < 8; ++i) {
        fake.imaging_in_upload += fake.imaging[i];
    }
    for (int i = 0; i < 16; ++i) {
        fake.transfer_in_upload += fake.transfer[i] != (i % 8 < 4 ? 1.0f : 0.0f);
    }
    glTexImage2D(target, level, internal, width, height, border, format, type, data);
}

static btf_gl_function find(void *user, const char *name) {
    static const struct {
        const char *name;
        btf_gl_function function;
    } fakes[] = {
        {"glGetIntegerv", (btf_gl_function)fake_get_integer},
        {"glGetString", (btf_gl_function)fake_get_string},
        {"glIsEnabled", (btf_gl_function)fake_is_enabled},
        {"glEnable", (btf_gl_function)fake_enable},
        {"glDisable", (btf_gl_function)fake_disable},
        {"glGetFloatv", (btf_gl_function)fake_get_float},
        {"glTexImage2D", (btf_gl_function)fake_tex_image},
        {"glPixelTransferf", (btf_gl_function)fake_pixel_transfer},
    };
    (void)user;
    for (size_t i = 0; i < sizeof fakes / sizeof *fakes; ++i) {
        if (strcmp(fakes[i].name, name) == 0) {
            return fakes[i].function;
        }
    }
    return (btf_gl_function)OSMesaGetProcAddress(name);
}
static const btf_gl_options options = {sizeof options, find, NULL, NULL};

static btf_gl *upload(const btf_material *m) {
    btf_gl *gl = NULL;
    if (btf_gl_upload(m, &options, &log_keep, &gl) != BTF_OK) {
        fail_msg("%s", last_message);
    }
    return gl;
}

static void expect_no_error(void) {
    assert_int_equal(glGetError(), GL_NO_ERROR);
}

/* Checks that a texture on the GPU holds the material's texels. Pixel transfer must be neutral, because it changes what
 * is read back as well. */
static void expect_texels(const btf_gl *gl, const btf_material *m, btf_texture_id id, GLenum format,
                          GLenum type) {
    const btf_texture t = btf_material_texture(m, id);
    const GLenum target = t.is_array ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D;
    assert_true(t.size > 0);
    unsigned char *back = calloc(1, t.size);
    assert_non_null(back);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glBindTexture(target, btf_gl_texture(gl, id));
    glGetTexImage(target, 0, format, type, back);
    glBindTexture(target, 0);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    expect_no_error();
    assert_memory_equal(back, t.data, t.size);
    free(back);
}

static void expect_every_texel(const btf_gl *gl) {
    expect_texels(gl, material, BTF_TEXTURE_SBRDF, GL_RGBA, GL_FLOAT);
    expect_texels(gl, material, BTF_TEXTURE_RESIDUAL_SCALES, GL_RGBA, GL_FLOAT);
    expect_texels(gl, material, BTF_TEXTURE_SHADOW, GL_RED_INTEGER, GL_UNSIGNED_BYTE);
    expect_texels(gl, material, BTF_TEXTURE_SHIFT, GL_RG_INTEGER, GL_UNSIGNED_BYTE);
    expect_texels(gl, material, BTF_TEXTURE_CENTRES, GL_RGBA_INTEGER, GL_UNSIGNED_BYTE);
    expect_texels(gl, material, BTF_TEXTURE_RESIDUAL_TEXELS, GL_RGBA_INTEGER, GL_BYTE);
    expect_texels(gl, material, BTF_TEXTURE_VIEW_TABLE, GL_RGBA_INTEGER, GL_UNSIGNED_SHORT);
}

/* glPixelTransfer and its maps. */
static const GLenum scales[] = {GL_RED_SCALE, GL_GREEN_SCALE, GL_BLUE_SCALE, GL_ALPHA_SCALE};
static const GLenum biases[] = {GL_RED_BIAS, GL_GREEN_BIAS, GL_BLUE_BIAS, GL_ALPHA_BIAS};
static void set_transfer(int odd) {
    static const GLfloat map[4] = {0.25f, 1, 0, 0.5f}, straight[2] = {0, 1};
    for (int i = 0; i < 4; ++i) {
        glPixelTransferf(scales[i], odd ? 0.5f + (GLfloat)i : 1);
        glPixelTransferf(biases[i], odd ? 0.125f * (GLfloat)(i + 1) : 0);
        glPixelMapfv((GLenum)(GL_PIXEL_MAP_R_TO_R + i), odd ? 4 : 2, odd ? map : straight);
    }
    glPixelTransferf(GL_MAP_COLOR, (GLfloat)odd);
    glPixelTransferf(GL_INDEX_SHIFT, odd ? 3 : 0);
    glPixelTransferf(GL_INDEX_OFFSET, odd ? 5 : 0);
    expect_no_error();
}

static void read_transfer(GLfloat out[15]) {
    for (int i = 0; i < 4; ++i) {
        glGetFloatv(scales[i], &out[2 * i]);
        glGetFloatv(biases[i], &out[2 * i + 1]);
        glGetFloatv((GLenum)(GL_PIXEL_MAP_R_TO_R_SIZE + i), &out[8 + i]);
    }
    glGetFloatv(GL_MAP_COLOR, &out[12]);
    glGetFloatv(GL_INDEX_SHIFT, &out[13]);
    glGetFloatv(GL_INDEX_OFFSET, &out[14]);
}

TEST(pixel_transfer_does_not_matter) {
    use(1);
    GLfloat before[15], after[15];
    memset(&fake, 0, sizeof fake);
    set_transfer(1);
    read_transfer(before);
    assert_true(before[0] == 0.5f && before[12] == 1 && before[8] == 4); /* the context took the state */
    btf_gl *gl = upload(material), *halves = upload(half_floats), *packed = upload(factored);
    expect_no_error();
    read_transfer(after);
    assert_memory_equal(before, after, sizeof before);
    uint32_t failures = 1;
    assert_int_equal(btf_gl_self_test(&options, &log_keep, &failures), BTF_OK);
    assert_int_equal(failures, 0);
    expect_no_error();
    read_transfer(after);
    assert_memory_equal(before, after, sizeof before);
    set_transfer(0);
    expect_every_texel(gl);
    expect_texels(halves, half_floats, BTF_TEXTURE_SBRDF, GL_RGBA, GL_HALF_FLOAT);
    expect_texels(packed, factored, BTF_TEXTURE_FACTOR_TEXELS, GL_RGBA_INTEGER, GL_UNSIGNED_INT);
    expect_texels(packed, factored, BTF_TEXTURE_FACTOR_DIRECTIONS, GL_RGBA_INTEGER, GL_UNSIGNED_INT);
    expect_texels(packed, factored, BTF_TEXTURE_FACTOR_SCALES, GL_RGBA, GL_FLOAT);
    expect_texels(packed, factored, BTF_TEXTURE_FACTOR_VIEWS, GL_RGBA, GL_FLOAT);
    btf_gl_destroy(&gl);
    btf_gl_destroy(&halves);
    btf_gl_destroy(&packed);
}

/* Shows that the test can fail: under this state a plain upload gives other texels. */
TEST(pixel_transfer_would_matter) {
    use(1);
    static const GLfloat texel[4] = {0.25f, 0.5f, 0.75f, 1};
    GLfloat back[4];
    GLuint texture;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    set_transfer(1);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, 1, 1, 0, GL_RGBA, GL_FLOAT, texel);
    set_transfer(0);
    glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, back);
    glDeleteTextures(1, &texture);
    assert_memory_not_equal(texel, back, sizeof texel);
}

static const GLenum switches[] = {GL_CULL_FACE, GL_DEPTH_TEST, GL_STENCIL_TEST, GL_SCISSOR_TEST, GL_BLEND,
                                  GL_COLOR_LOGIC_OP, GL_RASTERIZER_DISCARD, GL_SAMPLE_ALPHA_TO_COVERAGE,
                                  GL_SAMPLE_COVERAGE, GL_CLIP_DISTANCE0, GL_CLIP_DISTANCE0 + 5,
                                  GL_CLIP_DISTANCE0 + 7,
                                  /* of compatibility contexts */
                                  GL_POLYGON_STIPPLE, GL_ALPHA_TEST, GL_TEXTURE_2D, GL_LIGHTING};
enum { SWITCHES = sizeof switches / sizeof *switches, OF_COMPATIBILITY = 4 };

/* Sets all state that can keep a pixel from being drawn, or change it. */
static void set_drawing(int compatibility, int odd) {
    static const GLubyte nothing[128] = {0};
    static const GLdouble behind[4] = {0, 0, 0, -1};
    for (int i = 0; i < SWITCHES - (compatibility ? 0 : OF_COMPATIBILITY); ++i) {
        odd ? glEnable(switches[i]) : glDisable(switches[i]);
    }
    glLogicOp(odd ? GL_CLEAR : GL_COPY);
    glBlendFunc(odd ? GL_ZERO : GL_ONE, GL_ZERO);
    glScissor(0, 0, odd ? 0 : 16, odd ? 0 : 16);
    if (!compatibility) {
        glPolygonMode(GL_FRONT_AND_BACK, odd ? GL_POINT : GL_FILL);
        expect_no_error();
        return;
    }
    glPolygonMode(GL_FRONT, odd ? GL_POINT : GL_FILL);
    glPolygonMode(GL_BACK, odd ? GL_LINE : GL_FILL);
    if (odd) {
        glPolygonStipple(nothing);
        glClipPlane(GL_CLIP_PLANE0, behind);
    }
    glAlphaFunc(odd ? GL_NEVER : GL_ALWAYS, 0);
    expect_no_error();
}

static void read_drawing(int compatibility, GLint out[SWITCHES + 2]) {
    memset(out, 0, (SWITCHES + 2) * sizeof *out);
    for (int i = 0; i < SWITCHES - (compatibility ? 0 : OF_COMPATIBILITY); ++i) {
        out[i] = glIsEnabled(switches[i]);
    }
    glGetIntegerv(GL_POLYGON_MODE, out + SWITCHES);
}

/* In both profiles, all of it at once. */
TEST(drawing_state_does_not_matter) {
    for (int compatibility = 0; compatibility < 2; ++compatibility) {
        GLint before[SWITCHES + 2], after[SWITCHES + 2];
        uint32_t failures = 1;
        use(compatibility);
        memset(&fake, 0, sizeof fake);
        set_drawing(compatibility, 1);
        read_drawing(compatibility, before);
        btf_gl *gl = upload(material);
        if (btf_gl_self_test(&options, &log_keep, &failures) != BTF_OK) {
            fail_msg("%s", last_message);
        }
        assert_int_equal(failures, 0);
        expect_no_error();
        read_drawing(compatibility, after);
        assert_memory_equal(before, after, sizeof before);
        set_drawing(compatibility, 0);
        expect_every_texel(gl);
        btf_gl_destroy(&gl);
    }
}

TEST(the_imaging_subset_is_put_aside) {
    use(1);
    memset(&fake, 0, sizeof fake);
    fake.has_imaging = 1;
    for (int i = 0; i < 16; ++i) {
        fake.transfer[i] = 2.0f + (float)i;
    }
    for (int i = 0; i < 8; ++i) {
        fake.imaging[i] = i != 3; /* one was off, and stays off */
    }
    btf_gl *gl = upload(material);
    btf_gl_destroy(&gl);
    assert_int_equal(fake.imaging_in_upload, 0);
    assert_int_equal(fake.transfer_in_upload, 0);
    for (int i = 0; i < 16; ++i) {
        assert_true(fake.transfer[i] == 2.0f + (float)i);
    }
    for (int i = 0; i < 8; ++i) {
        assert_int_equal(fake.imaging[i], i != 3);
    }
    expect_no_error();
}

/* A core context has no pixel transfer, and the library does not ask it. A context that does not tell its profile is
 * asked, and the application sees no error of that. */
TEST(core_contexts_get_no_errors) {
    use(0);
    for (int profile_is_0 = 0; profile_is_0 < 2; ++profile_is_0) {
        uint32_t failures = 1;
        memset(&fake, 0, sizeof fake);
        fake.profile_is_0 = profile_is_0;
        btf_gl *gl = upload(material);
        expect_no_error();
        assert_int_equal(btf_gl_self_test(&options, &log_keep, &failures), BTF_OK);
        assert_int_equal(failures, 0);
        expect_no_error();
        assert_int_equal(fake.transfers_called != 0, profile_is_0);
        expect_every_texel(gl);
        btf_gl_destroy(&gl);
    }
}

static OSMesaContext make(int profile) {
    const int attributes[] = {OSMESA_FORMAT,
                              OSMESA_RGBA,
                              OSMESA_PROFILE,
                              profile,
                              OSMESA_CONTEXT_MAJOR_VERSION,
                              3,
                              OSMESA_CONTEXT_MINOR_VERSION,
                              3,
                              0};
    return OSMesaCreateContextAttribs(attributes, NULL);
}

static int setup(void **state) {
    (void)state;
    setenv("GALLIUM_DRIVER", "llvmpipe", 1);
    contexts[0] = make(OSMESA_CORE_PROFILE);
    contexts[1] = make(OSMESA_COMPAT_PROFILE);
    if (!contexts[0] || !contexts[1]) {
        fprintf(stderr, "skipped: OSMesa gives no OpenGL 3.3 in both profiles\n");
        exit(77);
    }
    synthetic_spec spec = {.seed = 23,
                           .width = 24,
                           .height = 17,
                           .n_views = 7,
                           .n_lights = 13,
                           .layout = BTF_LAYOUT_TIGHT,
                           .colour = BTF_COLOUR_RGB,
                           .lobes = 2,
                           .effects = BTF_EFFECT_VERSION_1,
                           .components = 6,
                           .centres = 100};
    if (synthetic_create(&spec, &log_keep, &material) != BTF_OK) {
        return 1;
    }
    spec.half_float = 1;
    if (synthetic_create(&spec, &log_keep, &half_floats) != BTF_OK) {
        return 1;
    }
    spec.components = 3;
    spec.classes[0][0] = spec.classes[2][0] = spec.classes[3][0] = 1;
    return synthetic_create(&spec, &log_keep, &factored) != BTF_OK;
}

static int teardown(void **state) {
    (void)state;
    btf_material_close(&material);
    btf_material_close(&half_floats);
    btf_material_close(&factored);
    OSMesaDestroyContext(contexts[0]);
    OSMesaDestroyContext(contexts[1]);
    return 0;
}

RUN_TESTS(setup, teardown)
