/* A conformance suite that cannot fail is worth nothing: each deliberately wrong decoder below must be
 * caught.
 *
 * SPDX-License-Identifier: MIT
 */
#include "check.h"
#include "synthetic.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The fault's name, where it must show ("" where only radiance can), and the change to the decoder's text.
 */
typedef struct sabotage {
    const char *name, *step, *from, *to;
} sabotage;

static const sabotage list[] = {
    {"one coordinate bit lost", "coordinate", "& 0x3FFFFu) * size", "& 0x3FFFEu) * size"},
    {"truncated, not floored", "coordinate", "floor(btf_mul(usable", "trunc(btf_mul(usable"},
    {"coordinates to 8192", "coordinate", "magnitude <= 0x45800000u", "magnitude <= 0x46000000u"},
    {"bilinear starts a quarter texel earlier", "bilinear", "t - 131072u", "t - 65536u"},
    {"bilinear does not wrap left", "bilinear", "s += size << 18u", "s += 0u"},
    {"bilinear does not wrap right", "bilinear", "c1 == size ? 0u : c1", "c1"},
    {"bilinear weight of 128ths", "bilinear", "(s >> 10u) & 255u", "(s >> 11u) & 255u"},
    {"wrap off by one", "wrap", "p >= int(size) ? int(size) : 0", "p > int(size) ? int(size) : 0"},
    {"wrap of negatives by %", "wrap", "uint(p + int(128u * size)) % size", "uint(abs(p)) % size"},
    {"projection rounds down", "project", "btf_mul(btf_mul(d.x, k), 8192.0), 0.5)",
     "btf_mul(btf_mul(d.x, k), 8192.0), 0.0)"},
    {"projection of the axes swapped", "project", "vec2(x, y)", "vec2(y, x)"},
    {"inner edges of triangles belong to none", "views", "min(e0, min(e1, e2)) >= 0",
     "min(e0, min(e1, e2)) > 0"},
    {"weights of two corners swapped", "views", "uvec3(w0, w1, 4096u - w0 - w1)",
     "uvec3(w1, w0, 4096u - w0 - w1)"},
    {"weights not taken down to 19 bits", "views", "uint(part >> drop) << 12u, uint(whole >> drop)",
     "uint(part) << 12u, uint(whole)"},
    {"quotient not corrected", "views", "r < 0 ? q - 1u : (r >= int(d) ? q + 1u : q)", "q + 1u"},
    {"edges accept the wrong side", "lights", "btf_cross(b - a, q - a) <= 0",
     "btf_cross(b - a, q - a) >= 0"},
    {"corner cones left out", "lights", "t >= n && btf_dot(q - b, c - b) <= 0", "t > n + 1 && t < n"},
    {"cells of the grid transposed", "lights", "at.y * grid + at.x", "at.x * grid + at.y"},
    {"the last of equals is nearest", "views", "n.weight.y > weight", "n.weight.y >= weight"},
    {"tiles off by one column", "tile", "(tile - row * columns) * BTF_WIDTH",
     "(tile - row * columns + 1u) * BTF_WIDTH"},
    {"rows and columns of tiles swapped", "tile", "row * BTF_HEIGHT) + x", "row * BTF_HEIGHT) + x.yx"},
    {"one narrow band too few", "centre", "(BTF_HEIGHT + BTF_N_LIGHTS - 1u) / BTF_N_LIGHTS",
     "(BTF_HEIGHT - 1u) / BTF_N_LIGHTS"},
    {"bands off by one", "centre", "band = narrow + full", "band = narrow + full + 1u"},
    {"narrow bands begin at the left", "centre", "column = left + (centre", "column = (centre"},
    {"a light off by one row", "centre", "top + band * BTF_N_LIGHTS + light",
     "top + band * BTF_N_LIGHTS + light + 1u"},
    {"blocks of centres off by one", "centre", "uvec2(block * BTF_N_LIGHTS + light", "uvec2(block + light"},
    {"bytes of the index swapped", "index", "codes.y + 256u * codes.z", "codes.z + 256u * codes.y"},
    {"index of 255s", "index", "256u * codes.z", "255u * codes.z"},
    {"unsigned shift", "source", "int(b ^ 128u) - 128", "int(b)"},
    {"sign and magnitude shift", "source", "int(b ^ 128u) - 128", "(b < 128u ? int(b) : 128 - int(b))"},
    {"shift bytes swapped", "source", "btf_wrap(x.x, btf_signed_byte(codes.y)",
     "btf_wrap(x.x, btf_signed_byte(codes.z)"},
    {"wrap at the other side's size", "source", "btf_signed_byte(codes.z), size.y",
     "btf_signed_byte(codes.z), size.x"},
    {"wrap at the size of level 0", "source", "uvec2 size = btf_size(level);\n    return",
     "uvec2 size = btf_size(0);\n    return"},
    {"levels rounded up", "source", "max(BTF_WIDTH >> level, 1u)",
     "(BTF_WIDTH + (1u << level) - 1u) >> level"},
    {"levels of no texels", "", "max(BTF_WIDTH >> level, 1u), max(BTF_HEIGHT >> level, 1u)",
     "BTF_WIDTH >> level, BTF_HEIGHT >> level"},
    {"gain of level 0", "codes", "texelFetch(btf_gain, ivec3(x, view), level)",
     "texelFetch(btf_gain, ivec3(x, view), 0)"},
    {"shift of level 0", "codes", "texelFetch(btf_shift, ivec3(x, view), level)",
     "texelFetch(btf_shift, ivec3(x, view), 0)"},
    {"shadow of level 0", "shadow", "texelFetch(btf_shadow, ivec3(x, light), level)",
     "texelFetch(btf_shadow, ivec3(x, light), 0)"},
    {"parameters of level 0", "", "texelFetch(btf_sbrdf, ivec3(x, layer), level)",
     "texelFetch(btf_sbrdf, ivec3(x, layer), 0)"},
    {"residual of level 0", "", "texelFetch(btf_residual_texels, ivec3(x[i], g), level)",
     "texelFetch(btf_residual_texels, ivec3(x[i], g), 0)"},
    {"a level off by one", "", "clamp(level, 0, int(BTF_LEVELS) - 1)",
     "clamp(level + 1, 0, int(BTF_LEVELS) - 1)"},
    {"the last level not reached", "", "clamp(level, 0, int(BTF_LEVELS) - 1)",
     "clamp(level, 0, int(BTF_LEVELS) - 2)"},
    {"levels not clamped", "", "clamp(level, 0, int(BTF_LEVELS) - 1)", "level"},
    {"shift channels of the atlas swapped", "codes", "btf_tile(view, x)), 0).yzw",
     "btf_tile(view, x)), 0).ywz"},
    {"shadow read from the gain", "shadow", "btf_tile(light, x)), 0).x", "btf_tile(light, x)), 0).y"},
    {"a log2 coefficient off by one bit", "arithmetic", "0x3E92CDF0u", "0x3E92CDF1u"},
    {"an exp2 coefficient off by one bit", "arithmetic", "0x3C1D94D9u", "0x3C1D94D8u"},
    {"three Newton steps", "arithmetic", "i < 4; ++i)\n        r = btf_mul",
     "i < 2; ++i)\n        r = btf_mul"},
    {"pow cut at 2^-59", "arithmetic", "t < -60.0 ? 0.0", "t < -59.0 ? 0.0"},
    {"bilinear corners swapped", "", "x[1] = uvec2(cu.y", "x[1] = uvec2(cu.x"},
    {"image upside down", "", "size.y - 1u - (tv >> 18u)", "(tv >> 18u)"},
    {"image upside down, bilinear", "", "size.y - 1u - cv.x", "cv.x"},
    {"lobe summed in another order", "",
     "btf_add(btf_add(btf_mul(c.x, p.x), btf_mul(c.y, p.y)), btf_mul(c.z, p.z))",
     "btf_add(btf_mul(c.x, p.x), btf_add(btf_mul(c.y, p.y), btf_mul(c.z, p.z)))"},
    {"exponent of the first lobe", "", "return btf_pow(b, c.w);", "return btf_pow(b, c.w + 0.0001);"},
    {"RGB weights off by one", "", "BTF_CHANNEL(5 + 3 * j)", "BTF_CHANNEL(4 + 3 * j)"},
    {"shadow of the first light alone", "", "t += lights.weight[b] * btf_shadow_code(x, lights.index[b]",
     "t += lights.weight[b] * btf_shadow_code(x, lights.index[0]"},
    {"parameters of the texel, not of its source", "", "btf_source_radiance(source[i]",
     "btf_source_radiance(x[i]"},
    {"residual of the texel, not of its source", "", "btf_residual(residual, source",
     "btf_residual(residual, x"},
    {"centres not companded", "", "return btf_mul(y, y);\n}\n\n#endif", "return y;\n}\n\n#endif"},
    {"residual channels off by one", "", "btf_direction_components(lights.index[b], view, 3 * g + 1)",
     "btf_direction_components(lights.index[b], view, 3 * g)"},
    {"residual of the last group whole", "", "BTF_COMPONENTS % 4, x, view", "4, x, view"},
    {"residual of views and lights swapped", "", "ivec3(int(light), int(view), layer)",
     "ivec3(int(view), int(light), layer)"},
    {"no cosine", "", "y = btf_mul(y, s.cosine);", ""},
    {"cosine not rooted", "", "s.cosine = btf_pow(l.z, 0.5);", "s.cosine = l.z;"},
    {"gain of hidden code 0 applied", "", "if (gain != 0u)\n", ""},
    {"views blended before the square", "", "y = btf_mul(y, y);\n#endif\n    return y;",
     "#endif\n    return y;"},
    {"negative radiance kept", "", "y >= uintBitsToFloat(0x30800000u) ? min(y, 4294967296.0) : 0.0",
     "min(y, 4294967296.0)"},
    {"no upper bound", "", "min(y, 4294967296.0)", "y"},
    {"view weights of 4095ths", "", "btf_mul(float(s.views.weight[a]), uintBitsToFloat(0x39800000u))",
     "btf_mul(float(s.views.weight[a]), uintBitsToFloat(0x39800801u))"},
    {"light below the horizon", "", "floatBitsToInt(d.z) >= 0x33800000",
     "floatBitsToInt(d.z) >= 0x33000000"},
    {"long vectors accepted", "", "most <= 0x40000000u", "most <= 0x7F000000u"},
};
enum { SABOTAGES = sizeof list / sizeof *list };

/* Materials that between them use every line of the decoder. The first shows most of the faults: shaders
 * of the others are compiled for few. */
static const struct {
    synthetic_spec spec;
    btf_shader_options shader;
} subjects[] = {
    {{.seed = 14,
      .width = 11,
      .height = 5,
      .n_views = 7,
      .n_lights = 9,
      .layout = BTF_LAYOUT_TIGHT,
      .domain = BTF_DOMAIN_SQRT,
      .colour = BTF_COLOUR_MONO,
      .lobes = 1,
      .effects = BTF_EFFECT_ALL,
      .components = 4,
      .centres = 40,
      .directions = SYNTHETIC_RANDOM,
      .levels = 4},
     {0}},
    {{.seed = 11,
      .width = 31,
      .height = 29,
      .n_views = 81,
      .n_lights = 13,
      .layout = BTF_LAYOUT_PAPER,
      .colour = BTF_COLOUR_MONO,
      .lobes = 3,
      .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN,
      .centres = 6000,
      .directions = SYNTHETIC_RANDOM},
     {0}},
    {{.seed = 12,
      .width = 131,
      .height = 9,
      .n_views = 19,
      .n_lights = 37,
      .layout = BTF_LAYOUT_TIGHT,
      .domain = BTF_DOMAIN_SQRT,
      .colour = BTF_COLOUR_RGB,
      .lobes = 2,
      .effects = BTF_EFFECT_ALL,
      .components = 6,
      .centres = 5000,
      .directions = SYNTHETIC_RINGS,
      .values = SYNTHETIC_EXTREME},
     {.filter = BTF_FILTER_BILINEAR, .components = 5}},
    {{.seed = 13,
      .width = 5,
      .height = 3,
      .n_views = 2,
      .n_lights = 81,
      .layout = BTF_LAYOUT_TIGHT,
      .domain = BTF_DOMAIN_SQRT,
      .colour = BTF_COLOUR_MONO,
      .lobes = 1,
      .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN,
      .centres = 5000,
      .directions = SYNTHETIC_COLLINEAR},
     {.interpolation = BTF_INTERPOLATION_NEAREST, .leave_out = BTF_EFFECT_HIDDEN}},
};
enum { SUBJECTS = sizeof subjects / sizeof *subjects, COUNT = 6000 };

static gpu *device;
static btf_material *materials[SUBJECTS];
static const sabotage *active;
static char *tampered;
static int found;

static void say_error(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    fprintf(stderr, "%s\n", message);
}
static const btf_log log_errors = {say_error, NULL};

/* Every place that holds the words is changed. */
static const char *tamper(char *text) {
    if (!active)
        return text;
    size_t from = strlen(active->from), to = strlen(active->to), places = 0;
    for (const char *p = text; (p = strstr(p, active->from)) != NULL; p += from)
        ++places;
    free(tampered);
    tampered = malloc(strlen(text) + places * to + 1);
    assert_non_null(tampered);
    char *out = tampered;
    for (const char *p = text; *p;) {
        if (strncmp(p, active->from, from) == 0) {
            memcpy(out, active->to, to);
            out += to;
            p += from;
            found = 1;
        } else {
            *out++ = *p++;
        }
    }
    *out = 0;
    return tampered;
}

/* Differences of a subject in a step, or in radiance. */
static uint64_t differences(int subject, const char *step) {
    btf_shader_options shader = subjects[subject].shader;
    shader.struct_size = sizeof shader;
    check_subject s = {.gpu = device,
                       .material = materials[subject],
                       .shader = &shader,
                       .tamper = tamper,
                       .log = &log_errors};
    check_outcome outcome = {0};
    btf_result result =
        step ? check_steps(&s, 5, COUNT, step, &outcome) : check_radiance(&s, 6, COUNT, &outcome);
    assert_int_equal(result, BTF_OK);
    return outcome.different;
}

static void untouched_passes(void **state) {
    (void)state;
    active = NULL;
    for (int i = 0; i < SUBJECTS; ++i) {
        assert_int_equal(differences(i, NULL), 0);
        for (int s = 0; check_step_names[s]; ++s)
            assert_int_equal(differences(i, check_step_names[s]), 0);
    }
}

static void each_is_caught(void **state) {
    (void)state;
    int missed = 0;
    for (int i = 0; i < SABOTAGES; ++i) {
        active = &list[i];
        found = 0;
        uint64_t different = 0;
        for (int s = 0; s < SUBJECTS && different == 0; ++s)
            different = differences(s, active->step[0] ? active->step : NULL);
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
    for (int i = 0; i < SUBJECTS; ++i)
        if (synthetic_create(&subjects[i].spec, &log_errors, &materials[i]) != BTF_OK)
            return -1;
    return 0;
}

static int teardown(void **state) {
    (void)state;
    for (int i = 0; i < SUBJECTS; ++i)
        btf_material_close(&materials[i]);
    gpu_destroy(&device);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(untouched_passes),
                                       cmocka_unit_test(each_is_caught)};
    return cmocka_run_group_tests_name("sabotage", tests, setup, teardown);
}
