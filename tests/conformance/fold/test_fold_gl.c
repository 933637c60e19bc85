/* Folds in a GL context: wrong calls, the state of the application, and layers with the bits of the reference's.
 *
 * SPDX-License-Identifier: MIT
 */
#include "folds.h"
#include "tests/conformance/check.h"
#include "tests/conformance/variant.h"
#include "decoder/toolkit/reference_view.h"
#include "tests/support/test.h"

#include <openbtf/fold.h>

static btf_material *make(const synthetic_spec *spec) {
    btf_material *material = NULL;
    assert_int_equal(synthetic_create(spec, &folds_log, &material), BTF_OK);
    return material;
}

TEST(wrong_calls_are_refused) {
    btf_material *material = make(&folds_of_roots);
    btf_shader_options shader = {.struct_size = sizeof shader,
                                 .leave_out = BTF_EFFECT_ALL & ~BTF_EFFECT_RESIDUAL};
    btf_gl_options options = gpu_gl_options(gpu_of_group, &shader);
    const float top[3] = {0, 0, 1};
    btf_gl_fold *fold = NULL;
    btf_gl *all = NULL, *few = NULL;
    assert_int_equal(btf_gl_fold_create(material, &options, 1, &folds_log, &fold),
                     BTF_ERROR_USAGE); /* no fold */
    shader.fold = BTF_FOLD_BOTH;
    assert_int_equal(btf_gl_fold_create(material, &options, 0, &folds_log, &fold), BTF_ERROR_USAGE);
    assert_int_equal(btf_gl_fold_create(material, &options, 1000000, &folds_log, &fold),
                     BTF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(folds_said, "1000000"));
    shader.leave_out = 0; /* relief */
    assert_int_equal(btf_gl_fold_create(material, &options, 1, &folds_log, &fold), BTF_ERROR_UNSUPPORTED);
    assert_null(fold);
    shader.leave_out = BTF_EFFECT_ALL & ~BTF_EFFECT_RESIDUAL;
    assert_int_equal(btf_gl_upload(material, &options, &folds_log, &few),
                     BTF_OK); /* the folded shader reads no texture of the material */
    options.shader = NULL;
    assert_int_equal(btf_gl_upload(material, &options, &folds_log, &all), BTF_OK);
    options.shader = &shader;
    assert_int_equal(btf_gl_fold_create(material, &options, 2, &folds_log, &fold), BTF_OK);
    assert_int_equal(btf_gl_fold_run(fold, all, 0, 2, top, top, &folds_log), BTF_ERROR_USAGE);
    assert_int_equal(btf_gl_fold_run(fold, all, 0, 1, top, NULL, &folds_log), BTF_ERROR_USAGE);
    assert_int_equal(btf_gl_fold_run(fold, few, 0, 1, top, top, &folds_log), BTF_ERROR_USAGE);
    assert_int_equal(btf_gl_fold_run(fold, all, 0, 1, top, top, &folds_log), BTF_OK);
    assert_int_not_equal(btf_gl_fold_texture(fold), 0);
    assert_int_equal(btf_gl_fold_bytes(fold), 2 * 16 * (13 * 7 + 6 * 3 + 3 * 1));
    btf_gl_fold_destroy(&fold);
    assert_null(fold);
    btf_gl_fold_destroy(&fold);
    btf_gl_destroy(&all);
    btf_gl_destroy(&few);
    btf_material_close(&material);
}

/* State of the second draw buffer and viewport, where GL has it: setting that of the first is no reason to change it. */
typedef struct second_state {
    void (*set_mask)(GLuint, GLboolean, GLboolean, GLboolean, GLboolean);
    void (*get_mask)(GLenum, GLuint, GLboolean *);
    void (*set_viewport)(GLuint, GLfloat, GLfloat, GLfloat, GLfloat);
    void (*get_viewport)(GLenum, GLuint, GLfloat *);
    void (*enable)(GLenum, GLuint);
    void (*disable)(GLenum, GLuint);
    GLboolean (*is_enabled)(GLenum, GLuint);
} second_state;

/* Loads the functions for the second draw buffer; false where the context has none. */
static bool load_second_state(const gl_api *api, const btf_gl_options *options, second_state *s) {
    static const char *const names[] = {"glColorMaski",  "glGetBooleani_v", "glViewportIndexedf",
                                        "glGetFloati_v", "glEnablei",       "glDisablei",
                                        "glIsEnabledi"};
    btf_gl_function of[7];
    GLint major = 0, minor = 0;
    api->GetIntegerv(GL_MAJOR_VERSION, &major);
    api->GetIntegerv(GL_MINOR_VERSION, &minor);
    for (int i = 0; i < 7; ++i) {
        of[i] = options->get_proc_address(options->user, names[i]);
        if (!of[i] || 10 * major + minor < 41 ||
            strstr((const char *)api->GetString(GL_VERSION), "OpenGL ES")) {
            return false;
        }
    }
    _Static_assert(sizeof *s == sizeof of, "one function each");
    memcpy(s, of, sizeof of);
    return true;
}

static void check_second_state(const second_state *s, bool set) {
    static const GLfloat viewport[4] = {7, 8, 9, 10};
    static const GLboolean mask[4] = {GL_FALSE, GL_TRUE, GL_TRUE, GL_FALSE};
    GLfloat there[4] = {0};
    GLboolean masked[4] = {0};
    if (set) {
        s->set_viewport(1, viewport[0], viewport[1], viewport[2], viewport[3]);
        s->set_mask(1, mask[0], mask[1], mask[2], mask[3]);
        s->disable(GL_SCISSOR_TEST, 1);
    }
    s->get_viewport(GL_VIEWPORT, 1, there);
    s->get_mask(GL_COLOR_WRITEMASK, 1, masked);
    assert_memory_equal(there, viewport, sizeof viewport);
    assert_memory_equal(masked, mask, sizeof mask);
    assert_false(s->is_enabled(GL_SCISSOR_TEST, 1));
}

/* The application's GL state (a scissor, masks, another framebuffer and program, another draw buffer and viewport) does
 * not change a fold, and is restored; the layers are those of the reference. */
TEST(state_is_left_alone) {
    static const GLenum names[] = {
        GL_VIEWPORT,       GL_CURRENT_PROGRAM,          GL_DRAW_FRAMEBUFFER_BINDING,
        GL_SCISSOR_TEST,   GL_COLOR_WRITEMASK,          GL_VERTEX_ARRAY_BINDING,
        GL_ACTIVE_TEXTURE, GL_READ_FRAMEBUFFER_BINDING, GL_DEPTH_TEST};
    enum { NAMES = sizeof names / sizeof *names, MOST = 13 * 7 * 9 };
    static uint32_t kept[MOST][4];
    const gl_api *api = gpu_api(gpu_of_group);
    const float light[3] = {0.6f, 0, 0.8f};
    btf_material *material = make(&folds_of_roots);
    btf_shader_options shader = {
        .struct_size = sizeof shader, .leave_out = BTF_EFFECT_GLOSS, .fold = BTF_FOLD_LIGHT};
    btf_gl_options options = gpu_gl_options(gpu_of_group, NULL);
    btf_gl_fold *fold = NULL;
    btf_gl *textures = NULL;
    GLint before[NAMES][4] = {{0}}, after[NAMES][4] = {{0}};
    assert_int_equal(btf_gl_upload(material, &options, &folds_log, &textures), BTF_OK);
    options.shader = &shader;
    assert_int_equal(btf_gl_fold_create(material, &options, 2, &folds_log, &fold), BTF_OK);
    api->Enable(GL_SCISSOR_TEST);
    api->Enable(GL_DEPTH_TEST);
    api->Scissor(1, 1, 1, 1);
    api->ColorMask(1, 0, 0, 1);
    api->Viewport(3, 4, 5, 6);
    second_state second;
    const bool has_second = load_second_state(api, &options, &second);
    if (has_second) {
        check_second_state(&second, true);
    }
    for (int i = 0; i < NAMES; ++i) {
        api->GetIntegerv(names[i], before[i]);
    }
    assert_int_equal(btf_gl_fold_run(fold, textures, GPU_FIRST_UNIT, 1, light, NULL, &folds_log), BTF_OK);
    for (int i = 0; i < NAMES; ++i) {
        api->GetIntegerv(names[i], after[i]);
    }
    assert_memory_equal(before, after, sizeof before);
    if (has_second) {
        check_second_state(&second, false);
    }
    print_message("%s\n",
                  has_second ? "a second draw buffer and viewport, too" : "one draw buffer and viewport");
    api->Disable(GL_SCISSOR_TEST);
    api->Disable(GL_DEPTH_TEST);
    api->ColorMask(1, 1, 1, 1);
    const btf_ref_options of = variant_reference_options(&shader);
    for (uint32_t level = 0; level < 3; ++level) {
        btf_ref_material m;
        reference_view(material, level, &m);
        const size_t words = (size_t)4 * m.width * m.height * m.n_views;
        float *values = folds_reference(&m, &of, BTF_REF_FOLD_LIGHT, light, NULL);
        static uint32_t both[2 * MOST][4]; /* lights */
        api->BindTexture(GL_TEXTURE_2D_ARRAY, btf_gl_fold_texture(fold));
        api->GetTexImage(GL_TEXTURE_2D_ARRAY, (GLint)level, GL_RGBA_INTEGER, GL_UNSIGNED_INT, both);
        memcpy(kept, &both[0][0] + words, words * sizeof(uint32_t));
        assert_memory_equal(kept, values, words * sizeof(uint32_t));
        free(values);
    }
    btf_gl_fold_destroy(&fold);
    btf_gl_destroy(&textures);
    btf_material_close(&material);
}

/* The texture that GL fills is the one that the CPU makes, whatever is folded. */
TEST(gl_and_cpu_fold_the_same) {
    enum { LIGHTS = 2, LEVELS = 3, MOST = 4 * 13 * 7 * 9 * LIGHTS };
    static uint32_t drawn[MOST];
    static const float light[LIGHTS][3] = {{0.6f, 0, 0.8f}, {-0.28f, 0, 0.96f}},
                       view[LIGHTS][3] = {{0, 0.6f, 0.8f}, {0, 0, 1}};
    const gl_api *api = gpu_api(gpu_of_group);
    btf_material *material = make(&folds_of_roots);
    btf_gl_options options = gpu_gl_options(gpu_of_group, NULL);
    btf_gl *textures = NULL;
    assert_int_equal(btf_gl_upload(material, &options, &folds_log, &textures), BTF_OK);
    for (int kind = BTF_FOLD_LIGHT; kind <= BTF_FOLD_NEIGHBOURS; ++kind) {
        const btf_shader_options shader = {.struct_size = sizeof shader,
                                           .leave_out = check_fold_left_out((btf_fold)kind),
                                           .fold = (btf_fold)kind};
        btf_gl_fold *fold = NULL;
        uint32_t *texels = NULL;
        options.shader = &shader;
        assert_int_equal(btf_gl_fold_create(material, &options, LIGHTS, &folds_log, &fold), BTF_OK);
        for (uint32_t i = 0; i < LIGHTS; ++i) {
            assert_int_equal(
                btf_gl_fold_run(fold, textures, GPU_FIRST_UNIT, i, light[i], view[i], &folds_log), BTF_OK);
        }
        const uint32_t few = kind == BTF_FOLD_BOTH ? 0 : LIGHTS; /* no lights, or not of radiance */
        assert_int_equal(btf_gl_fold_run_lights(fold, textures, GPU_FIRST_UNIT, 0, few, light[0], light[0],
                                                view[0], &folds_log),
                         BTF_ERROR_USAGE);
        assert_int_equal(btf_gl_fold_run_lights(fold, textures, GPU_FIRST_UNIT, 0, LIGHTS, light[0], NULL,
                                                view[0], &folds_log),
                         BTF_ERROR_USAGE);
        assert_int_equal(
            btf_material_fold(material, &shader, LIGHTS, light[0], view[0], &folds_log, &texels), BTF_OK);
        const uint32_t *at = texels;
        for (uint32_t level = 0; level < LEVELS; ++level) {
            btf_ref_material m;
            reference_view(material, level, &m);
            const size_t words = (size_t)4 * m.width * m.height * folds_layers(&m, kind) * LIGHTS;
            api->BindTexture(GL_TEXTURE_2D_ARRAY, btf_gl_fold_texture(fold));
            api->GetTexImage(GL_TEXTURE_2D_ARRAY, (GLint)level, GL_RGBA_INTEGER, GL_UNSIGNED_INT, drawn);
            assert_memory_equal(drawn, at, words * sizeof *at);
            at += words;
        }
        btf_free(texels);
        btf_gl_fold_destroy(&fold);
    }
    btf_gl_destroy(&textures);
    btf_material_close(&material);
}

/* The same for sums of lights, of odd and even number, since they are drawn into two textures in turn. */
TEST(gl_and_cpu_add_the_same) {
    enum { LIGHTS = 3, SUMS = 2, LEVELS = 3, MOST = 4 * 13 * 7 };
    static uint32_t drawn[SUMS * MOST], sum[MOST];
    static const float light[LIGHTS][3] = {{0.6f, 0, 0.8f}, {-0.28f, 0, 0.96f}, {0, 0, 1}},
                       view[LIGHTS][3] = {{0, 0.6f, 0.8f}, {0, 0.6f, 0.8f}, {0, 0.6f, 0.8f}},
                       weight[LIGHTS][3] = {{0.5f, 1, 2}, {3, 0.25f, 0.125f}, {0.7f, 0, 1.3f}};
    const gl_api *api = gpu_api(gpu_of_group);
    btf_material *material = make(&folds_of_roots);
    const btf_shader_options shader = {.struct_size = sizeof shader,
                                       .leave_out = check_fold_left_out(BTF_FOLD_BOTH),
                                       .fold = BTF_FOLD_BOTH};
    btf_gl_options options = gpu_gl_options(gpu_of_group, NULL);
    btf_gl *textures = NULL;
    btf_gl_fold *fold = NULL;
    uint32_t *texels = NULL;
    assert_int_equal(btf_gl_upload(material, &options, &folds_log, &textures), BTF_OK);
    options.shader = &shader;
    assert_int_equal(btf_gl_fold_create(material, &options, SUMS, &folds_log, &fold), BTF_OK);
    for (uint32_t number = 0; number < SUMS; ++number) {
        assert_int_equal(btf_gl_fold_run_lights(fold, textures, GPU_FIRST_UNIT, number, LIGHTS - number,
                                                light[0], weight[0], view[0], &folds_log),
                         BTF_OK);
    }
    assert_int_equal(btf_material_fold(material, &shader, LIGHTS, light[0], view[0], &folds_log, &texels),
                     BTF_OK);
    const uint32_t *at = texels;
    for (uint32_t level = 0; level < LEVELS; ++level) {
        btf_ref_material m;
        reference_view(material, level, &m);
        const size_t words = (size_t)4 * m.width * m.height;
        api->BindTexture(GL_TEXTURE_2D_ARRAY, btf_gl_fold_texture(fold));
        api->GetTexImage(GL_TEXTURE_2D_ARRAY, (GLint)level, GL_RGBA_INTEGER, GL_UNSIGNED_INT, drawn);
        for (uint32_t number = 0; number < SUMS; ++number) {
            memset(sum, 0, sizeof sum);
            for (uint32_t i = 0; i < LIGHTS - number; ++i) {
                btf_fold_add(words / 4, at + i * words, weight[i], sum);
            }
            assert_memory_equal(drawn + number * words, sum, words * sizeof *sum);
        }
        at += words * LIGHTS;
    }
    btf_free(texels);
    btf_gl_fold_destroy(&fold);
    btf_gl_destroy(&textures);
    btf_material_close(&material);
}

/* So are sums under a view that moves, of roots and of radiance: two lights at a time, and of an odd number one first. */
TEST(gl_and_cpu_add_views_the_same) {
    enum { LIGHTS = 4, SUMS = 2, LEVELS = 3, MOST = 4 * 13 * 7 * 9 * 4 };
    static uint32_t drawn[SUMS * MOST];
    static const float light[LIGHTS][3] = {{0.6f, 0, 0.8f}, {-0.28f, 0, 0.96f}, {0, 0, 1}, {0, 0.6f, 0.8f}},
                       weight[LIGHTS][3] = {
                           {0.5f, 1, 2}, {3, 0.25f, 0.125f}, {0.7f, 0, 1.3f}, {0.1f, 0.2f, 0.3f}};
    static const uint32_t counts[2][SUMS] = {{3, 4}, {2, 1}};
    const gl_api *api = gpu_api(gpu_of_group);
    for (int kind = 0; kind < 4; ++kind) {
        synthetic_spec spec = folds_of_roots;
        spec.blend = kind & 1 ? BTF_BLEND_RADIANCE : BTF_BLEND_ROOTS;
        btf_material *material = make(&spec);
        const btf_shader_options shader = {.struct_size = sizeof shader,
                                           .leave_out = check_fold_left_out(BTF_FOLD_SUM),
                                           .fold = BTF_FOLD_SUM};
        btf_gl_options options = gpu_gl_options(gpu_of_group, NULL);
        btf_gl *textures = NULL;
        btf_gl_fold *fold = NULL;
        uint32_t *texels[SUMS] = {NULL};
        const uint32_t layers = kind & 1 ? 9 : 4 * 9;
        size_t done = 0;
        assert_int_equal(btf_gl_upload(material, &options, &folds_log, &textures), BTF_OK);
        options.shader = &shader;
        assert_int_equal(btf_gl_fold_create(material, &options, SUMS, &folds_log, &fold), BTF_OK);
        for (uint32_t number = 0; number < SUMS; ++number) {
            const uint32_t count = counts[kind / 2][number];
            assert_int_equal(btf_gl_fold_run_lights(fold, textures, GPU_FIRST_UNIT, number, count, light[0],
                                                    weight[0], NULL, &folds_log),
                             BTF_OK);
            assert_int_equal(btf_material_fold_sum(material, &shader, count, light[0], weight[0],
                                                   &folds_log, &texels[number]),
                             BTF_OK);
        }
        for (uint32_t level = 0; level < LEVELS; ++level) {
            btf_ref_material m;
            reference_view(material, level, &m);
            const size_t words = (size_t)4 * m.width * m.height * layers;
            api->BindTexture(GL_TEXTURE_2D_ARRAY, btf_gl_fold_texture(fold));
            api->GetTexImage(GL_TEXTURE_2D_ARRAY, (GLint)level, GL_RGBA_INTEGER, GL_UNSIGNED_INT, drawn);
            for (uint32_t number = 0; number < SUMS; ++number) {
                assert_memory_equal(drawn + number * words, texels[number] + done, words * sizeof *drawn);
            }
            done += words;
        }
        for (uint32_t number = 0; number < SUMS; ++number) {
            btf_free(texels[number]);
        }
        assert_int_equal(btf_gl_fold_run_lights(fold, textures, GPU_FIRST_UNIT, 0, 0, light[0], weight[0],
                                                NULL, &folds_log),
                         BTF_ERROR_USAGE);
        btf_gl_fold_destroy(&fold);
        btf_gl_destroy(&textures);
        btf_material_close(&material);
    }
}

/* Calls of the CPU's folds that are wrong, each in one thing. */
TEST(wrong_rows_are_refused) {
    static const float top[3] = {0, 0, 1};
    btf_material *material = make(&folds_of_roots);
    btf_evaluator *evaluator = NULL;
    btf_shader_options shader = {.struct_size = sizeof shader, .fold = BTF_FOLD_NEIGHBOURS};
    uint32_t row[13][4], *texels = NULL;
    assert_int_equal(btf_evaluator_create(material, &folds_log, &evaluator), BTF_OK);
    assert_int_equal(btf_fold_rows(evaluator, &shader, top, top, 0, 2, 6, 1, row[0]), BTF_OK);
    assert_int_equal(btf_fold_rows(evaluator, &shader, top, NULL, 0, 2, 6, 1, row[0]), BTF_ERROR_USAGE);
    assert_int_equal(btf_fold_rows(evaluator, &shader, top, top, 3, 2, 6, 1, row[0]), BTF_ERROR_USAGE);
    assert_int_equal(btf_fold_rows(evaluator, &shader, top, top, 0, 3, 6, 1, row[0]), BTF_ERROR_USAGE);
    assert_int_equal(btf_fold_rows(evaluator, &shader, top, top, 0, 2, 6, 2, row[0]), BTF_ERROR_USAGE);
    assert_int_equal(btf_fold_rows(evaluator, &shader, top, top, 1, 2, 3, 1, row[0]), BTF_ERROR_USAGE);
    assert_int_equal(btf_material_fold(material, &shader, 1, top, NULL, &folds_log, &texels),
                     BTF_ERROR_USAGE);
    assert_int_equal(btf_material_fold(material, &shader, 0, top, top, &folds_log, &texels),
                     BTF_ERROR_USAGE);
    shader.fold = BTF_FOLD_LIGHT; /* gloss */
    assert_int_equal(btf_fold_rows(evaluator, &shader, top, NULL, 0, 0, 0, 1, row[0]),
                     BTF_ERROR_UNSUPPORTED);
    assert_int_equal(btf_material_fold(material, &shader, 1, top, NULL, &folds_log, &texels),
                     BTF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(folds_said, "gloss"));
    shader.fold = BTF_FOLD_NONE;
    assert_int_equal(btf_fold_rows(evaluator, &shader, top, NULL, 0, 0, 0, 1, row[0]), BTF_ERROR_USAGE);
    assert_int_equal(btf_material_fold(material, &shader, 1, top, top, &folds_log, &texels),
                     BTF_ERROR_USAGE);
    assert_null(texels);
    btf_evaluator_destroy(&evaluator);
    btf_material_close(&material);
}

RUN_TESTS(gpu_group_setup, gpu_group_teardown)
