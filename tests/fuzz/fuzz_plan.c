/* Fuzz target: plans and restrictions of a small material, all read from the input: any range, any bits of its numbers,
 * any tolerance, any table of effect errors, and plans that no planner made. * A scene must be refused exactly when it
 * breaks a rule of openbtf/plan.h; a plan's error must be within the tolerance; and a restriction must decode to the
 * same bits as the whole material.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include "tests/support/factor_material.h"
#include "tests/support/plan_decode.h"

#include <math.h>
#include <string.h>

enum { SAMPLES = 6, MOST_ERRORS = 160 };

/* Reads the input as numbers; after its end it gives zeros. */
typedef struct input {
    const uint8_t *data;
    size_t size;
} input;

static void take(input *in, void *out, size_t size) {
    const size_t have = size < in->size ? size : in->size;
    memset(out, 0, size);
    if (have) {
        memcpy(out, in->data, have);
    }
    in->data += have;
    in->size -= have;
}

static uint32_t byte(input *in) {
    uint8_t value;
    take(in, &value, 1);
    return value;
}

static uint32_t below(input *in, uint32_t n) {
    return byte(in) % n;
}

/* Any bits, or a number within low..high. */
static float number(input *in, float low, float high) {
    float value;
    if (below(in, 4) == 0) {
        take(in, &value, sizeof value);
        return value;
    }
    return low + (high - low) * (float)byte(in) / 255;
}

static btf_range range_of(input *in) {
    btf_range range = {0};
    switch (below(in, 4)) {
    case 0:
        break;
    case 1:
        range.fixed = 1;
        if (below(in, 4) == 0) {
            take(in, range.direction, sizeof range.direction);
        } else {
            plan_angles((double)number(in, 0, 89.9f), (double)number(in, -360, 360), range.direction);
        }
        break;
    default:
        range.theta[0] = number(in, 0, 90);
        range.theta[1] = number(in, range.theta[0], 90);
        range.phi[0] = number(in, -360, 360);
        range.phi[1] = number(in, -360, 360);
    }
    return range;
}

/* Makes a table by FORMAT.md section 7: rising limits, and rows that begin with effects and components of the material.
 * Now and then a number breaks a rule. */
static size_t errors_of(input *in, const btf_material_info *info, float *out) {
    const uint32_t views = 1 + below(in, 3), lights = 1 + below(in, 2), rows = below(in, 8);
    size_t n = 2;
    out[0] = (float)views;
    out[1] = (float)lights;
    for (uint32_t i = 0; i <= views; i++) {
        out[n++] = number(in, (float)i * 30, (float)i * 30 + 20);
    }
    for (uint32_t i = 0; i <= lights; i++) {
        out[n++] = number(in, (float)i * 40, (float)i * 40 + 30);
    }
    for (uint32_t r = 0; r < rows; r++) {
        const uint32_t effects = r == 0 ? info->effects : byte(in) & info->effects;
        const bool residual = effects & BTF_EFFECT_RESIDUAL;
        out[n++] = (float)effects;
        out[n++] = !residual ? 0
                   : r == 0  ? (float)info->components
                             : (float)(1 + below(in, info->components));
        out[n++] = r == 0 ? 0 : (float)below(in, 5);
        out[n++] = (float)below(in, info->levels);
        out[n++] = number(in, 0, 1e6f);
        for (uint32_t i = 0; i < 2 * views * lights; i++) {
            out[n++] = number(in, 0, 1);
        }
    }
    FUZZ_CHECK(n <= MOST_ERRORS);
    return rows ? n : 0;
}

static btf_material *material_of(input *in, random_state *r) {
    static const uint32_t counts[] = {1, 2, 3, 5, 7, 13, 20, 37};
    const btf_layout layout = below(in, 2) ? BTF_LAYOUT_PAPER : BTF_LAYOUT_TIGHT;
    const uint32_t effects = below(in, 32), width = 1 + below(in, 5), height = 1 + below(in, 4);
    const uint32_t views = counts[below(in, 8)], lights = counts[below(in, 8)];
    const uint32_t between = layout == BTF_LAYOUT_TIGHT ? BTF_EFFECT_RELIEF * random_below(r, 4) : 0;
    btf_material_desc desc = random_material_desc(width, height, views, lights, layout, effects | between);
    desc.info.domain = below(in, 2) ? BTF_DOMAIN_SQRT : BTF_DOMAIN_LINEAR;
    desc.info.levels = layout == BTF_LAYOUT_TIGHT ? 1 + below(in, width > 3 || height > 3 ? 3 : 1) : 1;
    desc.info.gain_scale = below(in, 2) ? BTF_GAIN_SCALE : 0x1.8p-6f;
    desc.info.colour = (btf_colour)below(in, 2);
    desc.info.components = effects & BTF_EFFECT_RESIDUAL ? 1 + below(in, 9) : 0;
    if ((effects & BTF_EFFECT_RESIDUAL) && below(in, 3) == 0) {
        desc.info.colour = BTF_COLOUR_NONE;
        desc.info.lobes = 0;
    }
    if (random_below(r, 2)) {
        factor_material_choose(r, &desc);
    }
    if (below(in, 2)) {
        random_directions(r, views, 89, (float *)(uintptr_t)desc.views);
        random_directions(r, lights, 80, (float *)(uintptr_t)desc.lights);
    }
    random_material_relief(r, &desc);
    float errors[MOST_ERRORS];
    desc.effect_error_count = errors_of(in, &desc.info, errors);
    desc.effect_errors = desc.effect_error_count ? errors : NULL;
    factor_material_fill(r, &desc);
    btf_material *material = NULL;
    if (btf_material_create(&desc, NULL, &material) != BTF_OK) { /* the table is refused: try without */
        desc.effect_error_count = 0;
        desc.effect_errors = NULL;
        FUZZ_CHECK(btf_material_create(&desc, NULL, &material) == BTF_OK);
    }
    random_material_free(&desc);
    return material;
}

/* Whether a range is legal, written anew from openbtf/plan.h. */
static bool is_range(const btf_range *r) {
    const double x = r->direction[0], y = r->direction[1], z = r->direction[2];
    return r->fixed ? fabs(sqrt(x * x + y * y + z * z) - 1) <= 1e-3 && z >= 0x1p-24
                    : 0 <= r->theta[0] && r->theta[0] <= r->theta[1] && r->theta[1] <= 90 &&
                          fabsf(r->phi[0]) <= 360 && fabsf(r->phi[1]) <= 360;
}

static bool is_number(float x) {
    return x >= 0 && x <= 1e6f;
}

static void check_plan(const btf_plan *plan, const btf_material_info *info, float tolerance) {
    FUZZ_CHECK(!(plan->effects & ~info->effects) && plan->level < info->levels);
    FUZZ_CHECK(plan->components <= info->components);
    FUZZ_CHECK(plan->views >= 1 && plan->views <= info->n_views);
    FUZZ_CHECK(plan->lights >= 1 && plan->lights <= info->n_lights);
    FUZZ_CHECK(isfinite(plan->cost) && plan->cost > 0 && isfinite(plan->full_cost) && plan->full_cost > 0);
    FUZZ_CHECK(plan->gpu_bytes > 0 || info->effects == 0);
    FUZZ_CHECK(isfinite(plan->psnr_linear) && isfinite(plan->psnr_srgb));
    const float rounding = 1e-4f; /* these materials have no errors between the samples, which allow more */
    FUZZ_CHECK(plan->psnr_linear >= plan->full_psnr_linear - tolerance - rounding);
    FUZZ_CHECK(plan->psnr_srgb >= plan->full_psnr_srgb - tolerance - rounding);
    FUZZ_CHECK(isfinite(plan->folded_cost) && plan->folded_cost > 0 && plan->fold_pixels >= 0);
    FUZZ_CHECK((plan->fold == BTF_FOLD_NONE) == (plan->fold_bytes == 0));
}

/* Saves a restriction and opens it again: it must decode to the same bits. */
static void check_saved(random_state *r, const btf_material *whole, const btf_material *small,
                        const btf_plan *plan) {
    int lit;
    void *data;
    size_t size;
    btf_material *back = NULL;
    FUZZ_CHECK(btf_material_save_memory(small, NULL, &data, &size) == BTF_OK);
    FUZZ_CHECK(btf_material_open_memory(data, size, NULL, &back) == BTF_OK);
    FUZZ_CHECK(plan_differences(r, whole, back, plan, SAMPLES, &lit) == 0);
    btf_free(data);
    btf_material_close(&back);
}

/* Compares the restriction to a plan with the whole material. */
static void check_restriction(random_state *r, const btf_material *whole, const btf_plan *plan, bool save) {
    btf_material *small = NULL;
    int lit;
    FUZZ_CHECK(btf_material_restrict(whole, plan, NULL, &small) == BTF_OK && small);
    FUZZ_CHECK(plan_differences(r, whole, small, plan, SAMPLES, &lit) == 0);
    char *shader = NULL;
    FUZZ_CHECK(btf_shader_source(small, &plan->shader, NULL, &shader) == BTF_OK);
    btf_free(shader);
    if (save) {
        check_saved(r, whole, small, plan);
    }
    btf_material_close(&small);
}

/* A plan that a caller wrote: arbitrary numbers, or the planner's plan with another set of effects. */
static void check_made_plan(input *in, random_state *r, const btf_material *whole,
                            const btf_material_info *info, btf_plan plan) {
    const bool raw = below(in, 2);
    if (raw) {
        take(in, &plan.effects, sizeof plan.effects);
        take(in, &plan.components, sizeof plan.components);
        take(in, &plan.level, sizeof plan.level);
        plan.scene.view = range_of(in);
        plan.scene.light = range_of(in);
        btf_material *small = NULL;
        const btf_result result = btf_material_restrict(whole, &plan, NULL, &small);
        const bool good =
            is_range(&plan.scene.view) && is_range(&plan.scene.light) && plan.level < info->levels;
        FUZZ_CHECK(result == (good ? BTF_OK : BTF_ERROR_USAGE) && (small != NULL) == good);
        btf_material_close(&small);
        return;
    }
    plan.effects = info->effects & byte(in);
    plan.components = plan.effects & BTF_EFFECT_RESIDUAL ? 1 + below(in, info->components) : 0;
    plan.shader.leave_out = info->effects & ~plan.effects;
    plan.shader.components = plan.components;
    plan.shader.interpolation = (btf_interpolation)below(in, 2);
    plan.shader.filter = (btf_filter)below(in, 3);
    check_restriction(r, whole, &plan, false);
}

/* Converted to layout `tight`, the material decodes to the same bits. The shadow of a material without an SBRDF, which
 * layout `paper` can hold, is dropped. */
static void check_tight(random_state *r, const btf_material *paper, const btf_material_info *info) {
    const btf_plan everything = {.struct_size = sizeof everything};
    btf_material_info less = {.struct_size = sizeof less};
    btf_material *tight = NULL;
    int lit;
    FUZZ_CHECK(btf_material_to_tight(paper, NULL, &tight) == BTF_OK);
    FUZZ_CHECK(btf_material_get_info(tight, &less) == BTF_OK && less.layout == BTF_LAYOUT_TIGHT);
    const uint32_t shadowless = info->colour == BTF_COLOUR_NONE ? (uint32_t)BTF_EFFECT_SHADOW : 0;
    FUZZ_CHECK(less.effects == (info->effects & ~shadowless) && less.n_views == info->n_views &&
               less.n_lights == info->n_lights);
    FUZZ_CHECK(plan_differences(r, paper, tight, &everything, SAMPLES, &lit) == 0);
    btf_material_close(&tight);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    input in = {data, size};
    random_state r = {byte(&in)};
    btf_material *whole = material_of(&in, &r);
    btf_material_info info = {.struct_size = sizeof info};
    FUZZ_CHECK(btf_material_get_info(whole, &info) == BTF_OK);
    for (int i = 0; i == 0 || (i < 4 && in.size > 0); i++) {
        btf_scene scene = {.struct_size = sizeof scene, .view = range_of(&in), .light = range_of(&in)};
        const float tolerance = number(&in, 0, 3);
        scene.pixels = number(&in, 0, 3);
        if (below(&in, 2)) {
            take(&in, &scene.lights, sizeof scene.lights);
        }
        scene.interpolate = (int)below(&in, 2);
        const bool good = is_range(&scene.view) && is_range(&scene.light) && is_number(tolerance) &&
                          is_number(scene.pixels);
        btf_plan plan = {0};
        FUZZ_CHECK(btf_plan_effects(whole, &scene, tolerance, &plan) == (good ? BTF_OK : BTF_ERROR_USAGE));
        if (!good) {
            continue;
        }
        check_plan(&plan, &info, tolerance);
        check_restriction(&r, whole, &plan, i == 0);
        check_made_plan(&in, &r, whole, &info, plan);
    }
    if (info.layout == BTF_LAYOUT_PAPER) {
        check_tight(&r, whole, &info);
    }
    btf_material_close(&whole);
    return 0;
}
