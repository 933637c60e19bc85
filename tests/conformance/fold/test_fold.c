/* Folds: the reference's against what is not folded, which there are, what a folded shader reads, and
 * deliberately wrong shaders, each of which must be noticed.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/conformance/cases.h"
#include "tests/conformance/check.h"
#include "tests/conformance/sabotage/tamper.h"
#include "tests/conformance/synthetic.h"
#include "tests/conformance/variant.h"
#include "decoder/toolkit/reference_view.h"

#include <openbtf/fold.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static gpu *device;

static char said[400];
static void hear(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    snprintf(said, sizeof said, "%s", message);
}
static const btf_log hearing = {hear, NULL};

/* Folds of one light, or of light and view, of a level. */
static float *fold_reference(const btf_ref_material *m, const btf_ref_options *o, int fold,
                             const float light[3], const float view[3]) {
    const size_t layer = (size_t)4 * m->width * m->height;
    const uint32_t layers = fold == BTF_REF_FOLD_LIGHT ? m->n_views : fold == BTF_REF_FOLD_NEIGHBOURS ? 3 : 1;
    float *values = malloc(layer * layers * sizeof *values);
    assert_non_null(values);
    if (fold == BTF_REF_FOLD_BOTH) {
        const uint32_t half = m->height / 2; /* in two pieces, as threads do */
        btf_ref_fold_both(m, o, light, view, half, m->height - half, values + (size_t)4 * m->width * half);
        btf_ref_fold_both(m, o, light, view, 0, half, values);
        return values;
    }
    for (uint32_t i = 0; i < layers; ++i)
        if (fold == BTF_REF_FOLD_LIGHT)
            btf_ref_fold_light(m, o, light, i, 0, m->height, values + i * layer);
        else
            btf_ref_fold_neighbour(m, o, light, view, i, 0, m->height, values + i * layer);
    return values;
}

/* Evaluations that differ between a fold and none. */
static uint64_t compare(const btf_material *material, const btf_ref_options *options, int fold,
                        uint64_t seed, uint64_t *evaluated) {
    enum { COUNT = 60 };
    random_state r = {seed};
    const btf_directions views = btf_material_views(material), lights = btf_material_lights(material);
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    uint64_t different = 0;
    for (uint32_t level = 0; level < info.levels; ++level) {
        btf_ref_material m;
        float light[3], view[3];
        reference_view(material, level, &m);
        case_direction(&r, &lights, light);
        case_direction(&r, &views, view);
        float *values = fold_reference(&m, options, fold, light, view);
        const btf_ref_folded folded = {fold, values};
        for (int i = 0; i < COUNT; ++i) {
            const float u = case_coordinate(&r, m.width), v = case_coordinate(&r, m.height);
            float rgb[3], kept[3];
            if (fold == BTF_REF_FOLD_LIGHT)
                case_direction(&r, &views, view);
            btf_ref_evaluate(&m, options, u, v, light, view, rgb);
            btf_ref_evaluate_folded(&m, options, &folded, u, v, light, view, kept);
            different += memcmp(rgb, kept, sizeof rgb) != 0;
        }
        *evaluated += COUNT;
        free(values);
    }
    return different;
}

static void folded_reference_has_the_same_bits(void **state) {
    (void)state;
    static variant list[VARIANT_MAX];
    uint64_t evaluated[4] = {0};
    const size_t count = variant_pairwise(3, list);
    for (size_t i = 0; i < count; ++i) {
        const synthetic_spec *s = &list[i].spec;
        btf_material *material = NULL;
        if ((uint64_t)s->n_views * s->width * s->height > 40000)
            continue;
        assert_int_equal(synthetic_create(s, &hearing, &material), BTF_OK);
        for (int fold = BTF_REF_FOLD_LIGHT; fold <= BTF_REF_FOLD_NEIGHBOURS; ++fold) {
            btf_ref_options options = variant_reference_options(&list[i].shader);
            btf_ref_material m;
            reference_view(material, 0, &m);
            options.effects &= ~check_fold_left_out((btf_fold)fold);
            if (!btf_ref_can_fold(&m, &options, fold))
                continue;
            const uint64_t different = compare(material, &options, fold, s->seed, &evaluated[fold]);
            if (different)
                fprintf(stderr, "%s, fold %d: %llu differ\n", list[i].name, fold,
                        (unsigned long long)different);
            assert_int_equal(different, 0);
        }
        btf_material_close(&material);
    }
    printf("%llu evaluations of folded lights, %llu of both, %llu of neighbours\n", (unsigned long long)evaluated[1],
           (unsigned long long)evaluated[2], (unsigned long long)evaluated[3]);
    assert_true(evaluated[1] > 1000 && evaluated[2] > 5000 && evaluated[3] > 5000);
}

/* Library and reference agree on which folds there are, and the library says why there is none. */
static void undefined_folds_are_refused(void **state) {
    (void)state;
    static const struct {
        btf_colour colour;
        uint32_t effects;
        btf_fold fold;
        const char *reason; /* NULL: it is defined */
    } cases[] = {
        {BTF_COLOUR_NONE, BTF_EFFECT_RESIDUAL, BTF_FOLD_LIGHT, NULL},
        {BTF_COLOUR_NONE, BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF, BTF_FOLD_LIGHT, NULL},
        {BTF_COLOUR_NONE, BTF_EFFECT_RESIDUAL | BTF_EFFECT_GLOSS, BTF_FOLD_LIGHT, "gloss"},
        {BTF_COLOUR_RGB, BTF_EFFECT_RESIDUAL, BTF_FOLD_LIGHT, "SBRDF"},
        {BTF_COLOUR_RGB, BTF_EFFECT_RESIDUAL | BTF_EFFECT_GLOSS, BTF_FOLD_BOTH, NULL},
        {BTF_COLOUR_NONE, BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF, BTF_FOLD_BOTH, "relief"},
        {BTF_COLOUR_RGB, BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS, BTF_FOLD_NEIGHBOURS, NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const synthetic_spec spec = {.seed = i,
                                     .width = 4,
                                     .height = 3,
                                     .n_views = 7,
                                     .n_lights = 5,
                                     .layout = BTF_LAYOUT_TIGHT,
                                     .domain = BTF_DOMAIN_SQRT,
                                     .colour = cases[i].colour,
                                     .lobes = cases[i].colour == BTF_COLOUR_NONE ? 0 : 1,
                                     .effects = cases[i].effects,
                                     .components = 2,
                                     .relief = SYNTHETIC_GENTLE,
                                     .gloss_share = 1};
        const btf_shader_options shader = {.struct_size = sizeof shader, .fold = cases[i].fold};
        const btf_ref_options options = variant_reference_options(&shader);
        const btf_result expected = cases[i].reason ? BTF_ERROR_UNSUPPORTED : BTF_OK;
        btf_material *material = NULL;
        btf_ref_material m;
        char *text = NULL;
        assert_int_equal(synthetic_create(&spec, &hearing, &material), BTF_OK);
        reference_view(material, 0, &m);
        said[0] = 0;
        assert_int_equal(btf_shader_source(material, &shader, &hearing, &text), expected);
        assert_int_equal(btf_ref_can_fold(&m, &options, (int)cases[i].fold), expected == BTF_OK);
        if (cases[i].reason && !strstr(said, cases[i].reason))
            fail_msg("\"%s\" does not say %s", said, cases[i].reason);
        btf_free(text);
        btf_material_close(&material);
    }
}

static const synthetic_spec roots = {.seed = 31,
                                     .width = 13,
                                     .height = 7,
                                     .n_views = 9,
                                     .n_lights = 11,
                                     .layout = BTF_LAYOUT_TIGHT,
                                     .domain = BTF_DOMAIN_SQRT,
                                     .colour = BTF_COLOUR_NONE,
                                     .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS,
                                     .components = 2,
                                     .directions = SYNTHETIC_RANDOM,
                                     .levels = 3,
                                     .classes = {{0}, {0}, {2, 1, 0}},
                                     .blend = BTF_BLEND_ROOTS,
                                     .horizon_scale = 4,
                                     .relief = SYNTHETIC_GENTLE,
                                     .gloss_share = 1};

static btf_material *make(const synthetic_spec *spec) {
    btf_material *material = NULL;
    assert_int_equal(synthetic_create(spec, &hearing, &material), BTF_OK);
    return material;
}

/* A folded shader reads where, not what; the fold is as large as it says; and it costs less. */
static void a_folded_shader_reads_less(void **state) {
    (void)state;
    btf_material *material = make(&roots);
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    btf_shader_options shader = {
        .struct_size = sizeof shader, .leave_out = BTF_EFFECT_GLOSS, .fold = BTF_FOLD_LIGHT};
    assert_int_equal(btf_shader_textures(&info, &shader), 1u << BTF_TEXTURE_VIEW_TABLE |
                                                              1u << BTF_TEXTURE_HEIGHTS |
                                                              1u << BTF_TEXTURE_VIEW_VECTORS);
    assert_int_equal(btf_fold_layers(&info, BTF_FOLD_LIGHT, 2), 18);
    assert_int_equal(btf_fold_bytes(&info, BTF_FOLD_LIGHT, 2), 18 * 16 * (13 * 7 + 6 * 3 + 3 * 1));
    const btf_fold_costs light = btf_fold_cost(material, &shader, NULL);
    assert_true(light.folded < light.unfolded && light.pass > 0);
    assert_true(light.pixels > 0 && light.pixels < 2 * 13 * 7 * 9);
    shader.leave_out |= BTF_EFFECT_RELIEF;
    shader.fold = BTF_FOLD_BOTH;
    assert_int_equal(btf_shader_textures(&info, &shader), 0);
    assert_int_equal(btf_fold_layers(&info, BTF_FOLD_BOTH, 2), 2);
    const btf_fold_costs both = btf_fold_cost(material, &shader, NULL);
    assert_true(both.folded < light.folded && both.pixels < light.pixels);
    shader.leave_out = 0;
    shader.fold = BTF_FOLD_NEIGHBOURS;
    assert_int_equal(btf_shader_textures(&info, &shader), 1u << BTF_TEXTURE_VIEW_TABLE |
                                                              1u << BTF_TEXTURE_HEIGHTS |
                                                              1u << BTF_TEXTURE_VIEW_VECTORS);
    shader.fixed = BTF_FIXED_VIEW;
    shader.fixed_view[2] = 1;
    assert_int_equal(btf_shader_textures(&info, &shader), 1u << BTF_TEXTURE_HEIGHTS | 1u << BTF_TEXTURE_VIEW_VECTORS);
    assert_int_equal(btf_fold_layers(&info, BTF_FOLD_NEIGHBOURS, 2), 6);
    const btf_fold_costs neighbours = btf_fold_cost(material, &shader, NULL);
    assert_true(neighbours.folded < neighbours.unfolded && neighbours.pixels < light.pixels);
    btf_material_close(&material);
}

/* A plan says what of its scene can be folded, and what that takes of the restricted material. */
static void plans_fold(void **state) {
    (void)state;
    const btf_range still = {.fixed = 1, .direction = {0.6f, 0, 0.8f}}, top = {.theta = {0, 20}};
    synthetic_spec spec = roots;
    btf_plan plan;
    btf_scene scene = {.struct_size = sizeof scene, .light = still};
    btf_material *glossy = make(&spec);
    spec.effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF;
    btf_material *raised = make(&spec);
    spec.effects = BTF_EFFECT_RESIDUAL;
    spec.n_views = 81;
    spec.directions = SYNTHETIC_RINGS;
    btf_material *flat = make(&spec);
    assert_int_equal(btf_plan_effects(glossy, &scene, 0, &plan), BTF_OK);
    assert_int_equal(plan.fold, BTF_FOLD_NONE);
    assert_true(plan.fold_bytes == 0 && plan.folded_cost == plan.cost);
    assert_int_equal(btf_plan_effects(raised, &scene, 0, &plan), BTF_OK);
    assert_int_equal(plan.fold, BTF_FOLD_LIGHT);
    assert_int_equal(plan.fold_bytes, 9 * 16 * (13 * 7 + 6 * 3 + 3 * 1));
    assert_true(plan.folded_cost < plan.cost && plan.fold_pixels > 0);
    const float with_relief = plan.folded_cost;
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK);
    assert_int_equal(plan.fold, BTF_FOLD_LIGHT);
    assert_true(plan.folded_cost < with_relief && plan.views == 81);
    const double pixels = plan.fold_pixels;
    scene.view = top; /* fewer views are folded sooner */
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK);
    assert_true(plan.views < 40 && plan.fold_bytes == (size_t)plan.views * 16 * (13 * 7 + 6 * 3 + 3 * 1));
    assert_true(fabs(plan.fold_pixels - pixels * plan.views / 81) < 0.01 * pixels);
    const float light_alone = plan.folded_cost;
    scene.view = still;
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK);
    assert_int_equal(plan.fold, BTF_FOLD_BOTH);
    assert_true(plan.folded_cost < light_alone && plan.fold_bytes == 16 * (13 * 7 + 6 * 3 + 3 * 1));
    for (int i = 0; i < 2; ++i) { /* with relief, and gloss too, neighbouring views */
        assert_int_equal(btf_plan_effects(i ? glossy : raised, &scene, 0, &plan), BTF_OK);
        assert_int_equal(plan.fold, BTF_FOLD_NEIGHBOURS);
        assert_true(plan.fold_bytes == 3 * 16 * (13 * 7 + 6 * 3 + 3 * 1) && plan.folded_cost < plan.cost);
    }
    scene.light = (btf_range){0};
    assert_int_equal(btf_plan_effects(flat, &scene, 0, &plan), BTF_OK); /* a still view alone is no fold */
    assert_int_equal(plan.fold, BTF_FOLD_NONE);
    btf_material_close(&glossy);
    btf_material_close(&raised);
    btf_material_close(&flat);
}

static void wrong_calls_are_refused(void **state) {
    (void)state;
    btf_material *material = make(&roots);
    btf_shader_options shader = {.struct_size = sizeof shader,
                                 .leave_out = BTF_EFFECT_ALL & ~BTF_EFFECT_RESIDUAL};
    btf_gl_options options = gpu_gl_options(device, &shader);
    const float top[3] = {0, 0, 1};
    btf_gl_fold *fold = NULL;
    btf_gl *all = NULL, *few = NULL;
    assert_int_equal(btf_gl_fold_create(material, &options, 1, &hearing, &fold),
                     BTF_ERROR_USAGE); /* no fold */
    shader.fold = BTF_FOLD_BOTH;
    assert_int_equal(btf_gl_fold_create(material, &options, 0, &hearing, &fold), BTF_ERROR_USAGE);
    assert_int_equal(btf_gl_fold_create(material, &options, 1000000, &hearing, &fold),
                     BTF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(said, "1000000"));
    shader.leave_out = 0; /* relief */
    assert_int_equal(btf_gl_fold_create(material, &options, 1, &hearing, &fold), BTF_ERROR_UNSUPPORTED);
    assert_null(fold);
    shader.leave_out = BTF_EFFECT_ALL & ~BTF_EFFECT_RESIDUAL;
    assert_int_equal(btf_gl_upload(material, &options, &hearing, &few),
                     BTF_OK); /* what the folded shader reads: nothing */
    options.shader = NULL;
    assert_int_equal(btf_gl_upload(material, &options, &hearing, &all), BTF_OK);
    options.shader = &shader;
    assert_int_equal(btf_gl_fold_create(material, &options, 2, &hearing, &fold), BTF_OK);
    assert_int_equal(btf_gl_fold_run(fold, all, 0, 2, top, top, &hearing), BTF_ERROR_USAGE);
    assert_int_equal(btf_gl_fold_run(fold, all, 0, 1, top, NULL, &hearing), BTF_ERROR_USAGE);
    assert_int_equal(btf_gl_fold_run(fold, few, 0, 1, top, top, &hearing), BTF_ERROR_USAGE);
    assert_int_equal(btf_gl_fold_run(fold, all, 0, 1, top, top, &hearing), BTF_OK);
    assert_int_not_equal(btf_gl_fold_texture(fold), 0);
    assert_int_equal(btf_gl_fold_bytes(fold), 2 * 16 * (13 * 7 + 6 * 3 + 3 * 1));
    btf_gl_fold_destroy(&fold);
    assert_null(fold);
    btf_gl_fold_destroy(&fold);
    btf_gl_destroy(&all);
    btf_gl_destroy(&few);
    btf_material_close(&material);
}

/* The state of an application changes nothing of a fold, and is as it was: a scissor, masks, another
 * framebuffer and program; the layers are what the reference keeps. */
static void state_is_left_alone(void **state) {
    (void)state;
    static const GLenum names[] = {
        GL_VIEWPORT,       GL_CURRENT_PROGRAM,          GL_DRAW_FRAMEBUFFER_BINDING,
        GL_SCISSOR_TEST,   GL_COLOR_WRITEMASK,          GL_VERTEX_ARRAY_BINDING,
        GL_ACTIVE_TEXTURE, GL_READ_FRAMEBUFFER_BINDING, GL_DEPTH_TEST};
    enum { NAMES = sizeof names / sizeof *names, MOST = 13 * 7 * 9 };
    static uint32_t kept[MOST][4];
    const gl_api *api = gpu_api(device);
    const float light[3] = {0.6f, 0, 0.8f};
    btf_material *material = make(&roots);
    btf_shader_options shader = {
        .struct_size = sizeof shader, .leave_out = BTF_EFFECT_GLOSS, .fold = BTF_FOLD_LIGHT};
    btf_gl_options options = gpu_gl_options(device, NULL);
    btf_gl_fold *fold = NULL;
    btf_gl *textures = NULL;
    GLint before[NAMES][4] = {{0}}, after[NAMES][4] = {{0}};
    assert_int_equal(btf_gl_upload(material, &options, &hearing, &textures), BTF_OK);
    options.shader = &shader;
    assert_int_equal(btf_gl_fold_create(material, &options, 2, &hearing, &fold), BTF_OK);
    api->Enable(GL_SCISSOR_TEST);
    api->Enable(GL_DEPTH_TEST);
    api->Scissor(1, 1, 1, 1);
    api->ColorMask(1, 0, 0, 1);
    api->Viewport(3, 4, 5, 6);
    for (int i = 0; i < NAMES; ++i)
        api->GetIntegerv(names[i], before[i]);
    assert_int_equal(btf_gl_fold_run(fold, textures, GPU_FIRST_UNIT, 1, light, NULL, &hearing), BTF_OK);
    for (int i = 0; i < NAMES; ++i)
        api->GetIntegerv(names[i], after[i]);
    assert_memory_equal(before, after, sizeof before);
    api->Disable(GL_SCISSOR_TEST);
    api->Disable(GL_DEPTH_TEST);
    api->ColorMask(1, 1, 1, 1);
    const btf_ref_options of = variant_reference_options(&shader);
    for (uint32_t level = 0; level < 3; ++level) {
        btf_ref_material m;
        reference_view(material, level, &m);
        const size_t words = (size_t)4 * m.width * m.height * m.n_views;
        float *values = fold_reference(&m, &of, BTF_REF_FOLD_LIGHT, light, NULL);
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

/* A wrong shader: words of the decoder, or of what folds, and other ones in their place. */
typedef struct sabotage {
    const char *name, *from, *to;
    int of_pass; /* in what folds; else in what reads */
    int subject; /* of the list below */
} sabotage;

enum { LIGHT_OF_ROOTS, LIGHT_OF_RADIANCE, BOTH_OF_SBRDF, NEIGHBOURS_OF_ROOTS, NEIGHBOURS_OF_SBRDF, NEIGHBOURS_OF_A_FIXED_VIEW };
static const struct {
    synthetic_spec spec;
    btf_shader_options shader;
    uint64_t seed; /* check_fold_kind */
} subjects[] = {
    [LIGHT_OF_ROOTS] = {{.seed = 31,
                         .width = 13,
                         .height = 7,
                         .n_views = 9,
                         .n_lights = 11,
                         .layout = BTF_LAYOUT_TIGHT,
                         .domain = BTF_DOMAIN_SQRT,
                         .colour = BTF_COLOUR_NONE,
                         .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF,
                         .components = 1,
                         .directions = SYNTHETIC_RANDOM,
                         .levels = 3,
                         .classes = {{0}, {0}, {1, 1, 0}},
                         .blend = BTF_BLEND_ROOTS,
                         .horizon_scale = 4,
                         .relief = SYNTHETIC_GENTLE},
                        {.filter = BTF_FILTER_BILINEAR},
                        1},
    [LIGHT_OF_RADIANCE] = {{.seed = 32,
                            .width = 11,
                            .height = 5,
                            .n_views = 9,
                            .n_lights = 11,
                            .layout = BTF_LAYOUT_PAPER,
                            .domain = BTF_DOMAIN_SQRT,
                            .colour = BTF_COLOUR_NONE,
                            .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN |
                                       BTF_EFFECT_RESIDUAL,
                            .components = 4,
                            .centres = 40,
                            .directions = SYNTHETIC_RANDOM},
                           {0},
                           1},
    [BOTH_OF_SBRDF] = {{.seed = 33,
                        .width = 11,
                        .height = 5,
                        .n_views = 9,
                        .n_lights = 11,
                        .layout = BTF_LAYOUT_TIGHT,
                        .colour = BTF_COLOUR_RGB,
                        .lobes = 1,
                        .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_GLOSS,
                        .directions = SYNTHETIC_RANDOM,
                        .gloss_share = 1},
                       {.filter = BTF_FILTER_STEEP},
                       4},
    [NEIGHBOURS_OF_ROOTS] = {{.seed = 34,
                              .width = 13,
                              .height = 7,
                              .n_views = 9,
                              .n_lights = 11,
                              .layout = BTF_LAYOUT_TIGHT,
                              .domain = BTF_DOMAIN_SQRT,
                              .colour = BTF_COLOUR_NONE,
                              .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS,
                              .components = 1,
                              .directions = SYNTHETIC_RANDOM,
                              .levels = 3,
                              .classes = {{0}, {0}, {1, 1, 0}},
                              .blend = BTF_BLEND_ROOTS,
                              .horizon_scale = 4,
                              .relief = SYNTHETIC_GENTLE,
                              .gloss_share = 1},
                             {.filter = BTF_FILTER_BILINEAR},
                             8},
    [NEIGHBOURS_OF_SBRDF] = {{.seed = 35,
                              .width = 11,
                              .height = 5,
                              .n_views = 9,
                              .n_lights = 11,
                              .layout = BTF_LAYOUT_TIGHT,
                              .colour = BTF_COLOUR_RGB,
                              .lobes = 1,
                              .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_GLOSS,
                              .directions = SYNTHETIC_RANDOM,
                              .gloss_share = 2},
                             {.interpolation = BTF_INTERPOLATION_LINEAR},
                             8},
    [NEIGHBOURS_OF_A_FIXED_VIEW] = {{.seed = 36,
                                     .width = 11,
                                     .height = 5,
                                     .n_views = 9,
                                     .n_lights = 11,
                                     .layout = BTF_LAYOUT_TIGHT,
                                     .colour = BTF_COLOUR_RGB,
                                     .lobes = 1,
                                     .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS,
                                     .components = 4,
                                     .directions = SYNTHETIC_RANDOM,
                                     .relief = SYNTHETIC_GENTLE,
                                     .gloss_share = 2},
                                    {.interpolation = BTF_INTERPOLATION_LINEAR},
                                    7},
};
enum { SUBJECTS = sizeof subjects / sizeof *subjects };

static const sabotage list[] = {
    {"layers of another view", "s.layer + int(view)", "s.layer + int(view ^ 1u)", 0, LIGHT_OF_ROOTS},
    {"one layer for all views", "s.layer + int(view)", "s.layer", 0, LIGHT_OF_RADIANCE},
    {"what is folded read from level 0", "layer), level).xyz", "layer), 0).xyz", 0, LIGHT_OF_ROOTS},
    {"the first light for every light", "s.layer = light * int(BTF_N_VIEWS);", "", 0, LIGHT_OF_ROOTS},
    {"the first light for every light, and view", "s.layer = light;", "", 0, BOTH_OF_SBRDF},
    {"layers of a light too many", "light * int(BTF_N_VIEWS)", "light * int(BTF_N_VIEWS + 1u)", 0,
     LIGHT_OF_ROOTS},
    {"rows for columns", "ivec3(ivec2(x), layer), level).xyz", "ivec3(ivec2(x.y, x.x), layer), level).xyz",
     0, BOTH_OF_SBRDF},
    {"red for blue", "layer), level).xyz", "layer), level).zyx", 0, BOTH_OF_SBRDF},
    {"views below the horizon", "    if (!btf_is_above(v))\n        return vec3(0.0);", "", 0,
     LIGHT_OF_ROOTS},
    {"levels of a numbered light not clamped",
     "btf_prepare(vec3(0.0, 0.0, 1.0), v, BTF_NEAREST != 0, clamp(level, 0, ",
     "btf_prepare(vec3(0.0, 0.0, 1.0), v, BTF_NEAREST != 0, clamp(level - 1, 0, ", 0, LIGHT_OF_ROOTS},
    {"the light folded from above",
     "btf_prepare(l, vec3(0.0, 0.0, 1.0), BTF_NEAREST != 0, level));",
     "btf_prepare(vec3(0.0, 0.0, 1.0), l, BTF_NEAREST != 0, level));", 1, LIGHT_OF_ROOTS},
    {"level 0 folded for all", "btf_factor_scene(texels, s.level,", "btf_factor_scene(texels, 0,", 1,
     LIGHT_OF_ROOTS},
    {"factors of the first view folded for all", "(texels, s.level, uvec3(view)", "(texels, s.level, uvec3(0u)",
     1, LIGHT_OF_ROOTS},
    {"shift and gain of the first view folded for all", "btf_show_view(value, texels, view, s);",
     "btf_show_view(value, texels, 0u, s);", 1, LIGHT_OF_RADIANCE},
    {"nearest lights folded for all", "vec3(0.0, 0.0, 1.0), BTF_NEAREST != 0, level)",
     "vec3(0.0, 0.0, 1.0), true, level)", 1, LIGHT_OF_ROOTS},
    {"neighbours of a light too few", "s.layer = light * 3;", "s.layer = light;", 0, NEIGHBOURS_OF_ROOTS},
    {"neighbours read by the number of their view", "s.views.index = uvec3(0u, 1u, 2u);", "", 0, NEIGHBOURS_OF_ROOTS},
    {"neighbours read in another order", "s.views.index = uvec3(0u, 1u, 2u);",
     "s.views.index = uvec3(0u, 2u, 1u);", 0, NEIGHBOURS_OF_SBRDF},
    {"neighbours of a fixed view read in another order", "s.views.index = BTF_FIXED_VIEW_LAYER;",
     "s.views.index = BTF_FIXED_VIEW_LAYER.yxz;", 0, NEIGHBOURS_OF_A_FIXED_VIEW},
    {"the first neighbour folded for all", "uint view = a == 0 ?", "uint view = a < 3 ?", 1, NEIGHBOURS_OF_ROOTS},
    {"the lights of the first neighbour folded for all", "s.lights = btf_lights_of(s, a);\n    return btf_fold_value",
     "return btf_fold_value", 1, NEIGHBOURS_OF_ROOTS},
    {"the lights of the first neighbour in every SBRDF", "s.lights = btf_lights_of(s, a);\n    return btf_fold_value",
     "return btf_fold_value", 1, NEIGHBOURS_OF_SBRDF},
    {"factors under the lights of the first neighbour", "lights[0] = lights[1] = lights[2] = s.lights;",
     "lights = s.lights_of;", 1, NEIGHBOURS_OF_ROOTS},
    {"level 0 of neighbours for all", "btf_setting s = btf_prepare(l, v, BTF_NEAREST != 0, level);\n    uint view",
     "btf_setting s = btf_prepare(l, v, BTF_NEAREST != 0, 0);\n    uint view", 1, NEIGHBOURS_OF_ROOTS},
    {"light and view swapped", "btf_texels(sum, texels, btf_prepare(l, v, ",
     "btf_texels(sum, texels, btf_prepare(v, l, ", 1, BOTH_OF_SBRDF},
    {"radiance folded without its scale", "sum[i] = btf_mul(sum[i], BTF_RADIANCE_SCALE);", "", 1,
     BOTH_OF_SBRDF},
    {"radiance of the neighbouring texel", "vec3 btf_fold_both(uvec2 x, vec3 l, vec3 v, int level) {",
     "vec3 btf_fold_both(uvec2 x, vec3 l, vec3 v, int level) {\n    x.x ^= 1u;", 1, BOTH_OF_SBRDF},
};

static const sabotage *active;
static int found;
static char *tampered;

static const char *put_in(const char *text) {
    char *made = active ? tamper_text(text, 0, 1, active->from, active->to) : NULL;
    if (!made)
        return text;
    free(tampered);
    tampered = made;
    found = 1;
    return tampered;
}

static const char *tamper_reader(char *library) {
    return active && !active->of_pass ? put_in(library) : library;
}

/* What the library compiles goes through here. */
static void APIENTRY tamper_pass(GLuint shader, GLsizei count, const GLchar *const *text,
                                 const GLint *length) {
    const GLchar *parts[8];
    (void)length;
    for (GLsizei i = 0; i < count; ++i)
        parts[i] = active && active->of_pass && !found ? put_in(text[i]) : text[i];
    gpu_api(device)->ShaderSource(shader, count, parts, NULL);
}

static btf_gl_function find(void *user, const char *name) {
    return strcmp(name, "glShaderSource") == 0 ? (btf_gl_function)tamper_pass
                                               : context_get_proc_address(user, name);
}

static uint64_t differences(int subject) {
    enum { COUNT = 2000 };
    btf_material *material = make(&subjects[subject].spec);
    btf_shader_options shader = subjects[subject].shader;
    shader.struct_size = sizeof shader;
    const check_subject s = {.gpu = device,
                             .material = material,
                             .shader = &shader,
                             .tamper = tamper_reader,
                             .find = find,
                             .log = &hearing};
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    check_outcome outcome = {0};
    const btf_fold kind = check_fold_kind(&info, subjects[subject].seed, COUNT);
    assert_int_equal(kind, subject >= NEIGHBOURS_OF_ROOTS ? BTF_FOLD_NEIGHBOURS
                           : subject == BOTH_OF_SBRDF    ? BTF_FOLD_BOTH
                                                         : BTF_FOLD_LIGHT);
    const btf_result result = check_folded(&s, subjects[subject].seed, COUNT, &outcome);
    btf_material_close(&material);
    if (result != BTF_OK)
        fail_msg("%s: %s", active ? active->name : "untouched", said);
    assert_int_equal(outcome.evaluated, COUNT);
    return outcome.different;
}

static void untouched_passes(void **state) {
    (void)state;
    active = NULL;
    for (int i = 0; i < SUBJECTS; ++i)
        assert_int_equal(differences(i), 0);
}

static void each_sabotage_is_caught(void **state) {
    (void)state;
    int missed = 0;
    for (size_t i = 0; i < sizeof list / sizeof *list; ++i) {
        active = &list[i];
        found = 0;
        const uint64_t different = differences(active->subject);
        if (!found)
            fprintf(stderr, "sabotage \"%s\": its text is not in the decoder\n", active->name);
        else if (different == 0)
            fprintf(stderr, "sabotage \"%s\" is not caught\n", active->name);
        missed += !found || different == 0;
    }
    active = NULL;
    free(tampered);
    tampered = NULL;
    assert_int_equal(missed, 0);
}

static int setup(void **state) {
    (void)state;
    device = gpu_create_or_skip(&context_devices[0]);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    gpu_destroy(&device);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(folded_reference_has_the_same_bits),
        cmocka_unit_test(undefined_folds_are_refused),
        cmocka_unit_test(a_folded_shader_reads_less),
        cmocka_unit_test(plans_fold),
        cmocka_unit_test(wrong_calls_are_refused),
        cmocka_unit_test(state_is_left_alone),
        cmocka_unit_test(untouched_passes),
        cmocka_unit_test(each_sabotage_is_caught),
    };
    return cmocka_run_group_tests_name("fold", tests, setup, teardown);
}
