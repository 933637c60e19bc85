/* Deliberately wrong shaders that fold, or read folds, each of which must be noticed.
 *
 * SPDX-License-Identifier: MIT
 */
#include "folds.h"
#include "tests/conformance/check.h"
#include "tests/conformance/sabotage/tamper.h"
#include "tests/support/test.h"

#include <openbtf/fold.h>

static btf_material *make(const synthetic_spec *spec) {
    btf_material *material = NULL;
    assert_int_equal(synthetic_create(spec, &folds_log, &material), BTF_OK);
    return material;
}

/* A wrong shader: words in the text of the decoder, or of the fold's pass, and their replacement. */
typedef struct sabotage {
    const char *name, *from, *to;
    int of_pass; /* the words are those of the fold's pass; else those of the decoder that reads the fold */
    int subject; /* of the list below */
} sabotage;

enum {
    LIGHT_OF_ROOTS,
    LIGHT_OF_RADIANCE,
    BOTH_OF_SBRDF,
    BOTH_OF_LEVELS,
    NEIGHBOURS_OF_ROOTS,
    NEIGHBOURS_OF_SBRDF,
    NEIGHBOURS_OF_A_FIXED_VIEW,
    SUM_OF_ROOTS,
    SUM_OF_RADIANCE
};
#define ONE_UNIT FOLDS_ROOTS, .components = 1, .classes = {{0}, {0}, {1, 1, 0}}
static const struct {
    synthetic_spec spec;
    btf_shader_options shader;
    uint64_t seed; /* check_fold_kind */
    /* clang-format off */
} subjects[] = {
    [LIGHT_OF_ROOTS] = {{ONE_UNIT, .seed = 31, .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF,
     .relief = SYNTHETIC_GENTLE}, {.filter = BTF_FILTER_BILINEAR}, 1},
    [LIGHT_OF_RADIANCE] = {{.seed = 32, .width = 11, .height = 5, .n_views = 9, .n_lights = 11,
     .layout = BTF_LAYOUT_PAPER, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE,
     .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL,
     .components = 4, .centres = 40, .directions = SYNTHETIC_RANDOM}, {0}, 1},
    [BOTH_OF_SBRDF] = {{.seed = 33, .width = 11, .height = 5, .n_views = 9, .n_lights = 11,
     .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_RGB, .lobes = 1,
     .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_GLOSS, .directions = SYNTHETIC_RANDOM, .gloss_share = 1},
     {.filter = BTF_FILTER_STEEP}, 4},
    [BOTH_OF_LEVELS] = {{ONE_UNIT, .seed = 37, .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_GLOSS,
     .gloss_share = 1}, {.interpolation = BTF_INTERPOLATION_LINEAR}, 4},
    [NEIGHBOURS_OF_ROOTS] = {{ONE_UNIT, .seed = 34,
     .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS, .relief = SYNTHETIC_GENTLE,
     .gloss_share = 1}, {.filter = BTF_FILTER_BILINEAR}, 8},
    [NEIGHBOURS_OF_SBRDF] = {{.seed = 35, .width = 11, .height = 5, .n_views = 9, .n_lights = 11,
     .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_RGB, .lobes = 1,
     .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_GLOSS, .directions = SYNTHETIC_RANDOM, .gloss_share = 2},
     {.interpolation = BTF_INTERPOLATION_LINEAR}, 8},
    [NEIGHBOURS_OF_A_FIXED_VIEW] = {{.seed = 36, .width = 11, .height = 5, .n_views = 9, .n_lights = 11,
     .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_RGB, .lobes = 1,
     .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS, .components = 4,
     .directions = SYNTHETIC_RANDOM, .relief = SYNTHETIC_GENTLE, .gloss_share = 2},
     {.interpolation = BTF_INTERPOLATION_LINEAR}, 7},
    [SUM_OF_ROOTS] = {{ONE_UNIT, .seed = 38, .effects = BTF_EFFECT_RESIDUAL}, {.filter = BTF_FILTER_BILINEAR}, 9},
    [SUM_OF_RADIANCE] = {{.seed = 39, .width = 11, .height = 5, .n_views = 9, .n_lights = 11,
     .layout = BTF_LAYOUT_PAPER, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE,
     .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL,
     .components = 4, .centres = 40, .directions = SYNTHETIC_RANDOM}, {0}, 9},
};
/* clang-format on */
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
    {"the light folded from above", "btf_prepare(l, vec3(0.0, 0.0, 1.0), BTF_NEAREST != 0, level));",
     "btf_prepare(vec3(0.0, 0.0, 1.0), l, BTF_NEAREST != 0, level));", 1, LIGHT_OF_ROOTS},
    {"level 0 folded for all", "btf_factor_scene(texels, s.level,", "btf_factor_scene(texels, 0,", 1,
     LIGHT_OF_ROOTS},
    {"factors of the first view folded for all", "(texels, s.level, uvec3(view)",
     "(texels, s.level, uvec3(0u)", 1, LIGHT_OF_ROOTS},
    {"shift and gain of the first view folded for all", "btf_show_view(value, texels, view, s);",
     "btf_show_view(value, texels, 0u, s);", 1, LIGHT_OF_RADIANCE},
    {"nearest lights folded for all", "vec3(0.0, 0.0, 1.0), BTF_NEAREST != 0, level)",
     "vec3(0.0, 0.0, 1.0), true, level)", 1, LIGHT_OF_ROOTS},
    {"neighbours of a light too few", "s.layer = light * 3;", "s.layer = light;", 0, NEIGHBOURS_OF_ROOTS},
    {"neighbours read by the number of their view", "s.views.index = uvec3(0u, 1u, 2u);", "", 0,
     NEIGHBOURS_OF_ROOTS},
    {"neighbours read in another order", "s.views.index = uvec3(0u, 1u, 2u);",
     "s.views.index = uvec3(0u, 2u, 1u);", 0, NEIGHBOURS_OF_SBRDF},
    {"neighbours of a fixed view read in another order", "s.views.index = BTF_FIXED_VIEW_LAYER;",
     "s.views.index = BTF_FIXED_VIEW_LAYER.yxz;", 0, NEIGHBOURS_OF_A_FIXED_VIEW},
    {"the first neighbour folded for all", "uint view = a == 0 ?", "uint view = a < 3 ?", 1,
     NEIGHBOURS_OF_ROOTS},
    {"the lights of the first neighbour folded for all",
     "s.lights = btf_lights_of(s, a);\n    return btf_fold_value", "return btf_fold_value", 1,
     NEIGHBOURS_OF_ROOTS},
    {"the lights of the first neighbour in every SBRDF",
     "s.lights = btf_lights_of(s, a);\n    return btf_fold_value", "return btf_fold_value", 1,
     NEIGHBOURS_OF_SBRDF},
    {"factors under the lights of the first neighbour", "lights[0] = lights[1] = lights[2] = s.lights;",
     "lights = s.lights_of;", 1, NEIGHBOURS_OF_ROOTS},
    {"level 0 of neighbours for all",
     "btf_setting s = btf_prepare(l, v, BTF_NEAREST != 0, level);\n    uint view",
     "btf_setting s = btf_prepare(l, v, BTF_NEAREST != 0, 0);\n    uint view", 1, NEIGHBOURS_OF_ROOTS},
    {"light and view swapped", "btf_texels(sum, texels, btf_prepare(l, v, ",
     "btf_texels(sum, texels, btf_prepare(v, l, ", 1, BOTH_OF_SBRDF},
    {"radiance folded without its scale", "sum[i] = btf_mul(sum[i], BTF_RADIANCE_SCALE);", "", 1,
     BOTH_OF_SBRDF},
    {"lights added without their weights", "return btf_add(sum, btf_mul(radiance, weight));",
     "return btf_add(sum, radiance);", 1, BOTH_OF_SBRDF},
    {"the last light alone of a sum", "return btf_add(sum, btf_mul(radiance, weight));",
     "return btf_mul(radiance, weight);", 1, BOTH_OF_SBRDF},
    {"the weight of red for all channels", "return btf_add(sum, btf_mul(radiance, weight));",
     "return btf_add(sum, btf_mul(radiance, weight.x));", 1, BOTH_OF_SBRDF},
    {"the sum of level 0 for all", "btf_pass_from), btf_pass_level).xyz", "btf_pass_from), 0).xyz", 1,
     BOTH_OF_LEVELS},
    {"products read without those of the third view", "    if (views.weight.y > 0u && views.weight.z > 0u)",
     "    if (false)", 0, SUM_OF_ROOTS},
    {"products read once", "float(2u * weight.x * weight.y)", "float(weight.x * weight.y)", 0,
     SUM_OF_ROOTS},
    {"squares weighed as values", "float(weight * weight)", "float(weight * 4096u)", 0, SUM_OF_ROOTS},
    {"partners of the first view alone", "        owner = views.y;", "", 0, SUM_OF_ROOTS},
    {"the second partner for the third", "(partners >> 20u) == b ? 3 : 0", "(partners >> 20u) == b ? 2 : 0",
     0, SUM_OF_ROOTS},
    {"partners named by the wrong view", "own[a] = kept.w;", "own[0] = kept.w;", 0, SUM_OF_ROOTS},
    {"sums that may be negative", "return max(sum, vec3(0.0));", "return sum;", 0, SUM_OF_ROOTS},
    {"layers of one sum for all, of products", "s.layer = light * 4 * int(BTF_N_VIEWS);", "", 0,
     SUM_OF_ROOTS},
    {"sums of products without their scale", "s.n_views, s.layer, s.level), BTF_RADIANCE_SCALE);",
     "s.n_views, s.layer, s.level), 1.0);", 0, SUM_OF_ROOTS},
    {"the first sum for every sum of radiance", "#else\n    s.layer = light * int(BTF_N_VIEWS);", "#else\n",
     0, SUM_OF_RADIANCE},
    {"small roots kept in products", "return abs(y) >= uintBitsToFloat(BTF_BITS_2_TO_MINUS_30) ? y : 0.0;",
     "return abs(y);", 1, SUM_OF_ROOTS},
    {"negative roots left as they are", "vec3 low = max(min(a, b), -high);", "vec3 low = min(a, b);", 1,
     SUM_OF_ROOTS},
    {"products that negative roots take all of", "btf_mul(min(low, vec3(0.0)), 0.5)",
     "btf_mul(min(low, vec3(0.0)), 1.0)", 1, SUM_OF_ROOTS},
    {"values of another view multiplied", "btf_pass_fetch(btf_pass_other));",
     "btf_pass_fetch(btf_pass_view));", 1, SUM_OF_ROOTS},
    {"partners of a view not named", "floatBitsToUint(sum), uint(btf_pass_partners)",
     "floatBitsToUint(sum), 0u", 1, SUM_OF_ROOTS},
    {"the sum of radiance begun anew with every light", "if (btf_pass_from >= 0)", "if (btf_pass_from < 0)",
     1, SUM_OF_RADIANCE},
    {"radiance of the neighbouring texel", "vec3 btf_fold_both(uvec2 x, vec3 l, vec3 v, int level) {",
     "vec3 btf_fold_both(uvec2 x, vec3 l, vec3 v, int level) {\n    x.x ^= 1u;", 1, BOTH_OF_SBRDF},
};

static bool in_pass; /* the shader that folds is broken, not the one that reads */

static const char *tamper_reader(char *library) {
    return in_pass ? library : tamper_apply(library, 0);
}

/* The library calls this in place of glShaderSource. */
static void APIENTRY tamper_pass(GLuint shader, GLsizei count, const GLchar *const *text,
                                 const GLint *length) {
    const GLchar *parts[8];
    (void)length;
    for (GLsizei i = 0; i < count; ++i) {
        parts[i] = in_pass ? tamper_apply(text[i], 0) : text[i];
    }
    gpu_api(gpu_of_group)->ShaderSource(shader, count, parts, NULL);
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
    const check_subject s = {.gpu = gpu_of_group,
                             .material = material,
                             .shader = &shader,
                             .tamper = tamper_reader,
                             .find = find,
                             .log = &folds_log};
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    check_outcome outcome = {0};
    const btf_fold kind = check_fold_kind(&info, subjects[subject].seed, COUNT);
    assert_int_equal(kind, subject >= SUM_OF_ROOTS          ? BTF_FOLD_SUM
                           : subject >= NEIGHBOURS_OF_ROOTS ? BTF_FOLD_NEIGHBOURS
                           : subject >= BOTH_OF_SBRDF       ? BTF_FOLD_BOTH
                                                            : BTF_FOLD_LIGHT);
    const btf_result result = check_folded(&s, subjects[subject].seed, COUNT, &outcome);
    btf_material_close(&material);
    if (result != BTF_OK) {
        fail_msg("subject %d: %s", subject, folds_said);
    }
    assert_int_equal(outcome.evaluated, COUNT);
    return outcome.different;
}

TEST(untouched_passes) {
    for (int i = 0; i < SUBJECTS; ++i) {
        assert_int_equal(differences(i), 0);
    }
}

TEST(each_sabotage_is_caught) {
    int missed = 0;
    for (size_t i = 0; i < sizeof list / sizeof *list; ++i) {
        in_pass = list[i].of_pass;
        tamper_begin(list[i].name, list[i].from, list[i].to, 1);
        missed += tamper_end(differences(list[i].subject));
    }
    assert_int_equal(missed, 0);
}

RUN_TESTS(gpu_group_setup, gpu_group_teardown)
