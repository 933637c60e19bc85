/* The counts of a decode (openbtf/cost.h) against the shader itself: a copy of its text counts its fetches, their bytes,
 * look-ups, moves and points while it runs.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/conformance/gpu.h"
#include "tests/conformance/random.h"
#include "tests/conformance/sabotage/tamper.h"
#include "tests/conformance/synthetic.h"
#include "tests/support/test.h"

#include <openbtf/cost.h>
#include <openbtf/fold.h>

enum { ELEMENTS = 256, UNIT_FOLDED = 31 };

/* Fetches and their bytes; heights; look-ups; moves and points. */
static const char preamble[] =
    "uvec2 seen_fetches = uvec2(0u);\n"
    "uint seen_heights = 0u, seen_look_ups = 0u, seen_moves = 0u, seen_points = 0u;\n"
    "#define FETCH(size, s, at, level) (seen_fetches += uvec2(1u, size), texelFetch(s, at, level))\n"
    "#define HEIGHT(s, at, level) (++seen_heights, texelFetch(s, at, level))\n";

static const char body[] = "uvec4 check(uvec4 a, uvec4 b) {\n"
                           "    vec2 uv = uintBitsToFloat(a.xy);\n"
                           "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x));\n"
                           "    btf_evaluate(uv, l, uintBitsToFloat(b.yzw));\n"
                           "    return uvec4(seen_fetches, seen_heights + 1024u * seen_look_ups,\n"
                           "                 seen_moves + 1024u * seen_points);\n"
                           "}\n";

static const struct {
    const char *from, *to;
} hooks[] = {
    {"texelFetch(btf_sbrdf,", "FETCH(16u, btf_sbrdf,"},
    {"texelFetch(btf_maps,", "FETCH(4u, btf_maps,"},
    {"texelFetch(btf_shadow,", "FETCH(1u, btf_shadow,"},
    {"texelFetch(btf_shift,", "FETCH(2u, btf_shift,"},
    {"texelFetch(btf_gain,", "FETCH(1u, btf_gain,"},
    {"texelFetch(btf_points,", "FETCH(2u, btf_points,"},
    {"texelFetch(btf_point_lists,", "FETCH(2u, btf_point_lists,"},
    {"texelFetch(btf_point_indices,", "FETCH(1u, btf_point_indices,"},
    {"texelFetch(btf_residual_texels,", "FETCH(4u, btf_residual_texels,"},
    {"texelFetch(btf_residual_directions,", "FETCH(4u, btf_residual_directions,"},
    {"texelFetch(btf_residual_scales,", "FETCH(16u, btf_residual_scales,"},
    {"texelFetch(btf_factor_", "FETCH(16u, btf_factor_"},
    {"texelFetch(btf_view_vectors,", "FETCH(16u, btf_view_vectors,"},
    {"texelFetch(btf_folded,", "FETCH(16u, btf_folded,"},
    {"texelFetch(btf_heights,", "HEIGHT(btf_heights,"},
    {"btf_neighbours r = btf_neighbours(uvec3(0u), uvec3(4096u, 0u, 0u));",
     "btf_neighbours r = btf_neighbours(uvec3(0u), uvec3(4096u, 0u, 0u)); ++seen_look_ups;"},
    {"ivec2 point = x + btf_move(", "++seen_moves; ivec2 point = x + btf_move("},
    {"ivec2 at = btf_inside(point - btf_move(", "++seen_moves; ivec2 at = btf_inside(point - btf_move("},
    {"btf_setting s) {\n#if BTF_FOLDED\n",
     "btf_setting s) {\n    seen_points += uint(BTF_TEXELS);\n#if BTF_FOLDED\n"},
};

/* The text with all hooks in; a hook that no longer finds its place fails. */
static char *counting_text(const btf_material *material, const btf_shader_options *options) {
    char *text = NULL;
    assert_int_equal(btf_shader_source(material, options, NULL, &text), BTF_OK);
    char *now = strdup(text);
    btf_free(text);
    for (size_t i = 0; i < sizeof hooks / sizeof *hooks; i++) {
        char *next = tamper_text(now, 0, SIZE_MAX, hooks[i].from, hooks[i].to);
        if (!next) {
            fail_msg("the shader has no \"%s\"", hooks[i].from);
        }
        free(now);
        now = next;
    }
    return now;
}

/* The most of each count over all pixels, since the shader passes over a neighbour whose weight is 0. */
static btf_decode_counts run(const btf_material *material, const btf_shader_options *options,
                             double *out_heights) {
    btf_gl_options all = gpu_gl_options(gpu_of_group, options);
    btf_gl *textures = NULL;
    btf_gl_fold *fold = NULL;
    btf_decode_counts most = {.pixels = 1};
    char *text = counting_text(material, options);
    const unsigned program = gpu_program(gpu_of_group, preamble, text, body, NULL);
    free(text);
    assert_true(program != 0);
    assert_int_equal(btf_gl_upload(material, &all, NULL, &textures), BTF_OK);
    assert_int_equal(btf_gl_bind(textures, program, GPU_FIRST_UNIT, NULL, NULL, NULL), BTF_OK);
    if (options->fold !=
        BTF_FOLD_NONE) { /* an empty fold texture: how much is read does not depend on its values */
        assert_int_equal(btf_gl_fold_create(material, &all, 1, NULL, &fold), BTF_OK);
        btf_gl_fold_bind(fold, program, UNIT_FOLDED, NULL);
    }
    static uint32_t inputs[ELEMENTS][GPU_INPUTS], outputs[ELEMENTS][GPU_OUTPUTS];
    random_state r = {9};
    for (int i = 0; i < ELEMENTS; i++) {
        float f[8] = {(float)random_between(&r, 0, 1), (float)random_between(&r, 0, 1)};
        for (int d = 2; d < 8; d += 3) {
            const double z = random_between(&r, 0.4, 0.99), phi = random_between(&r, 0, 6),
                         s = sqrt(1 - z * z);
            f[d] = (float)(s * cos(phi));
            f[d + 1] = (float)(s * sin(phi));
            f[d + 2] = (float)z;
        }
        if (options->fixed & BTF_FIXED_LIGHT) {
            memcpy(f + 2, options->fixed_light, sizeof options->fixed_light);
        }
        if (options->fixed & BTF_FIXED_VIEW) {
            memcpy(f + 5, options->fixed_view, sizeof options->fixed_view);
        }
        memcpy(inputs[i], f, sizeof f);
    }
    assert_int_equal(gpu_run(gpu_of_group, program, ELEMENTS, inputs[0], outputs[0], NULL), BTF_OK);
    *out_heights = 0;
    for (int i = 0; i < ELEMENTS; i++) {
        const uint32_t *o = outputs[i];
        most.fetches = fmax(most.fetches, o[0]);
        most.bytes = fmax(most.bytes, o[1]);
        most.look_ups = fmax(most.look_ups, o[2] / 1024);
        most.moves = fmax(most.moves, o[3] % 1024);
        most.points = fmax(most.points, o[3] / 1024);
        *out_heights = fmax(*out_heights, o[2] % 1024);
    }
    gpu_delete_program(gpu_of_group, program);
    btf_gl_fold_destroy(&fold);
    btf_gl_destroy(&textures);
    return most;
}

/* Compares all counts but operations, which cannot be told from a text. */
static void expect_counts(const char *name, const btf_material *material,
                          const btf_shader_options *options) {
    btf_material_info info = {.struct_size = sizeof info};
    double heights;
    btf_material_get_info(material, &info);
    const btf_decode_counts said = btf_count_decode(&info, options),
                            seen = run(material, options, &heights);
    const bool by_points = options->fold != BTF_FOLD_BOTH; /* that fold shows no view */
    if (said.fetches != seen.fetches || said.bytes != seen.bytes || said.look_ups != seen.look_ups ||
        said.moves != seen.moves || (by_points && said.points != seen.points)) {
        fail_msg("%s: fetches %g (seen %g), bytes %g (%g), look-ups %g (%g), moves %g (%g), points %g (%g)",
                 name, said.fetches, seen.fetches, said.bytes, seen.bytes, said.look_ups, seen.look_ups,
                 said.moves, seen.moves, said.points, seen.points);
    }
    if (heights > said.steps || (heights == 0) != (said.steps == 0)) {
        fail_msg("%s: %g steps at most, %g seen", name, said.steps, heights);
    }
}

#define OF_ALL                                                                                             \
    .seed = 3, .width = 8, .height = 8, .n_views = 19, .n_lights = 19, .values = SYNTHETIC_PLAUSIBLE,      \
    .directions = SYNTHETIC_RINGS
#define OF_FACTORS                                                                                         \
    OF_ALL, .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_NONE, .domain = BTF_DOMAIN_SQRT,              \
            .blend = BTF_BLEND_ROOTS, .components = 7,                                                     \
            .classes = {{1, 1, 1}, {1, 0, 0}, {2, 3, 1}, {1, 0, 0}, {2, 0, 0}}

static const struct {
    const char *name;
    synthetic_spec spec;
} materials[] = {
    {"lists",
     {OF_FACTORS, .packed = 1, .entries = 4, .relief = SYNTHETIC_GENTLE, .gloss_share = 1,
      .effects =
          BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS}},
    {"packed",
     {OF_FACTORS, .packed = 1, .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL}},
    {"apart",
     {OF_FACTORS, .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL | BTF_EFFECT_GLOSS,
      .gloss_share = 2}},
    {"flat relief",
     {OF_FACTORS, .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF, .relief = SYNTHETIC_FLAT}},
    {"components",
     {OF_ALL, .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_RGB, .lobes = 2, .components = 10,
      .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL}},
    {"paper",
     {OF_ALL, .layout = BTF_LAYOUT_PAPER, .colour = BTF_COLOUR_MONO, .lobes = 3,
      .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT}},
};

/* The first material is decoded with all options, the others with all effects. */
TEST(counts_are_the_shader_s) {
    static const struct {
        const char *name;
        btf_shader_options shader;
    } ways[] = {
        {"whole", {0}},
        {"nearest", {.interpolation = BTF_INTERPOLATION_NEAREST}},
        {"steep", {.filter = BTF_FILTER_STEEP}},
        {"some components", {.components = 3}},
        {"without relief", {.leave_out = BTF_EFFECT_RELIEF}},
        {"without gloss", {.leave_out = BTF_EFFECT_GLOSS}},
        {"without shift", {.leave_out = BTF_EFFECT_SHIFT}},
        {"without codes", {.leave_out = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN}},
        {"one view", {.fixed = BTF_FIXED_VIEW, .fixed_view = {0, 0, 1}}},
        {"one light", {.fixed = BTF_FIXED_LIGHT, .fixed_light = {0, 0, 1}}},
        {"light folded",
         {.fixed = BTF_FIXED_LIGHT,
          .fixed_light = {0, 0, 1},
          .leave_out = BTF_EFFECT_GLOSS,
          .fold = BTF_FOLD_LIGHT}},
        {"both folded",
         {.fixed = BTF_FIXED_LIGHT,
          .fixed_light = {0, 0, 1},
          .leave_out = BTF_EFFECT_RELIEF,
          .fold = BTF_FOLD_BOTH}},
        {"neighbours folded",
         {.fixed = BTF_FIXED_LIGHT, .fixed_light = {0, 0, 1}, .fold = BTF_FOLD_NEIGHBOURS}},
    };
    int compared = 0;
    for (size_t m = 0; m < sizeof materials / sizeof *materials; m++) {
        btf_material *material = NULL;
        btf_material_info info = {.struct_size = sizeof info};
        assert_int_equal(synthetic_create(&materials[m].spec, NULL, &material), BTF_OK);
        btf_material_get_info(material, &info);
        for (size_t w = 0; w < sizeof ways / sizeof *ways; w++) {
            btf_shader_options o = ways[w].shader;
            char name[80];
            o.struct_size = sizeof o;
            if (btf_fold_check(&info, &o, NULL) != BTF_OK ||
                (w > 0 && o.leave_out && !(o.leave_out & info.effects))) {
                continue;
            }
            if (m > 0 && w > 0) {
                continue; /* the difference of the other materials shows with any options */
            }
            snprintf(name, sizeof name, "%s, %s", materials[m].name, ways[w].name);
            expect_counts(name, material, &o);
            compared++;
        }
        btf_material_close(&material);
    }
    print_message("%d variants\n", compared);
    assert_true(compared == 18);
}

RUN_TESTS(gpu_group_setup, gpu_group_teardown)
