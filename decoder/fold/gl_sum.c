/* Adds up lights in textures of the current GL context. See openbtf/fold.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "gl_fold.h"
#include "decoder/evaluate/partners.h"
#include "decoder/result.h"

#include <stdbool.h>

/* How both passes begin: `sum` is that of the lights before, which lies in a layer of another texture, or 0. */
#define SUM_BEFORE \
    "void main() {\n" \
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n" \
    "    vec3 sum = vec3(0.0);\n" \
    "    if (btf_pass_from >= 0)\n" \
    "        sum = uintBitsToFloat(texelFetch(btf_pass_sum, ivec3(at, btf_pass_from), btf_pass_level).xyz);\n"

/* The pass that adds one light to the sum of those before. */
static const char sum_text[] =
    "uniform highp vec3 btf_pass_light, btf_pass_viewer, btf_pass_weight;\n"
    "uniform highp int btf_pass_level, btf_pass_from;\n"
    "uniform highp usampler2DArray btf_pass_sum;\n"
    "out highp uvec4 btf_pass_value;\n"
    SUM_BEFORE
    "    vec3 value = btf_fold_both(uvec2(at), btf_pass_light, btf_pass_viewer, btf_pass_level);\n"
    "    btf_pass_value = uvec4(floatBitsToUint(btf_fold_add(sum, value, btf_pass_weight)), 0u);\n"
    "}\n";

/* The pass that adds one light to the sum of those before in a layer of a view, or of a view and its partner: what they
 * show lies in layers of a texture of values. */
static const char views_text[] =
    "uniform highp vec3 btf_pass_weight;\n"
    "uniform highp int btf_pass_level, btf_pass_from, btf_pass_view, btf_pass_other, btf_pass_partners;\n"
    "uniform highp usampler2DArray btf_pass_sum, btf_pass_values;\n"
    "out highp uvec4 btf_pass_value;\n"
    "vec3 btf_pass_fetch(int view) {\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    return uintBitsToFloat(texelFetch(btf_pass_values, ivec3(at, view), btf_pass_level).xyz);\n"
    "}\n"
    SUM_BEFORE
    "    if (btf_pass_other >= 0) {\n"
    "        vec3 value = btf_pass_fetch(btf_pass_view);\n"
    "#if BTF_BLEND_ROOTS\n"
    "        value = btf_fold_product(value, btf_pass_fetch(btf_pass_other));\n"
    "#endif\n"
    "        sum = btf_fold_add(sum, value, btf_pass_weight);\n"
    "    }\n"
    "    btf_pass_value = uvec4(floatBitsToUint(sum), uint(btf_pass_partners));\n"
    "}\n";

/* Every light draws what the one before left in the other of two textures; the last draws into the fold's. */
static btf_result draw_sum(const btf_gl_fold *f, uint32_t other, uint32_t unit, uint32_t number,
                           uint32_t count, const float *lights, const float *weights, const btf_log *log) {
    const btfi_gl_functions *api = &f->api;
    const btfi_fold_program *p = &f->sum;
    const uint32_t texture[2] = {f->texture, other}, layer[2] = {number, 0};
    btf_result result = BTF_OK;
    api->Uniform1i(p->sum, (int32_t)unit);
    api->ActiveTexture(GL_TEXTURE0 + unit);
    api->BindSampler(unit, 0);
    for (uint32_t level = 0; level < f->levels; ++level) {
        for (uint32_t i = 0; i < count && result == BTF_OK; ++i) {
            const uint32_t to = (count - 1 - i) % 2;
            api->BindTexture(GL_TEXTURE_2D_ARRAY, texture[1 - to]);
            api->Uniform1i(p->from, i == 0 ? -1 : (int32_t)layer[1 - to]);
            api->Uniform3f(p->weight, weights[3 * (size_t)i], weights[3 * (size_t)i + 1],
                           weights[3 * (size_t)i + 2]);
            result = btfi_fold_draw(f, p, lights + 3 * (size_t)i, texture[to], layer[to], level, log);
        }
    }
    api->BindTexture(GL_TEXTURE_2D_ARRAY, 0);
    return result;
}

/* What is drawn while lights are added up under a view that moves. */
typedef struct view_sum {
    uint32_t values, other; /* textures: what two lights show in each view; a layer of sums */
    uint32_t unit, number;  /* that of sums, while values are in the next one; which sum of the fold */
} view_sum;

/* Draws what a light shows in all views, as the first or second of two. */
static btf_result draw_values(const btf_gl_fold *f, const view_sum *s, const float *light, uint32_t second,
                              uint32_t level, const btf_log *log) {
    btf_result result = BTF_OK;
    f->api.UseProgram(f->one.name);
    for (uint32_t i = 0; i < f->sampled && result == BTF_OK; ++i) {
        f->api.Uniform1i(f->one.view, (int32_t)i);
        result = btfi_fold_draw(f, &f->one, light, s->values, second * f->sampled + i, level, log);
    }
    return result;
}

/* Adds one of the two lights to a layer of the fold: from its sum into the other texture, or from there back. A light
 * without one before it begins the sum. */
static btf_result add_to_layer(const btf_gl_fold *f, const view_sum *s, uint32_t layer, bool begins,
                               bool back, uint32_t second, uint32_t level, const btf_log *log) {
    const btfi_gl_functions *api = &f->api;
    const btfi_fold_program *p = &f->sum;
    const uint32_t of_view = f->partners ? 1 + BTFI_PARTNERS : 1, view = layer / of_view,
                   place = layer % of_view, in_fold = s->number * f->views + layer;
    const uint32_t other = place == 0 ? view : btfi_partner(f->partners[view], place - 1);
    const int32_t first = (int32_t)(second * f->sampled);
    api->BindTexture(GL_TEXTURE_2D_ARRAY, back ? s->other : f->texture);
    api->Uniform1i(p->from, begins ? -1 : back ? 0 : (int32_t)in_fold);
    api->Uniform1i(p->view, first + (int32_t)view);
    api->Uniform1i(p->other, other == BTFI_NO_PARTNER && place > 0 ? -1 : first + (int32_t)other);
    api->Uniform1i(p->partners, f->partners && place == 0 ? (int32_t)f->partners[view] : 0);
    return btfi_fold_draw(f, p, NULL, back ? f->texture : s->other, back ? in_fold : 0, level, log);
}

/* Adds one light, or two, to all layers of the fold. */
static btf_result add_lights(const btf_gl_fold *f, const view_sum *s, const float *weights, uint32_t lights,
                             bool begins, uint32_t level, const btf_log *log) {
    const btfi_gl_functions *api = &f->api;
    btf_result result = BTF_OK;
    api->UseProgram(f->sum.name);
    for (uint32_t layer = 0; layer < f->views; ++layer) {
        for (uint32_t i = 0; i < lights && result == BTF_OK; ++i) {
            const float *w = weights + 3 * (size_t)i;
            api->Uniform3f(f->sum.weight, w[0], w[1], w[2]);
            result = add_to_layer(f, s, layer, begins && i == 0, i + 1 == lights, i, level, log);
        }
    }
    return result;
}

/* Two lights at a time, so that the sum of a layer comes back to where it was; of an odd number the first alone, which
 * begins the sum. */
static btf_result draw_views(const btf_gl_fold *f, const view_sum *s, uint32_t count, const float *lights,
                             const float *weights, const btf_log *log) {
    const btfi_gl_functions *api = &f->api;
    btf_result result = BTF_OK;
    api->UseProgram(f->sum.name);
    api->Uniform1i(f->sum.sum, (int32_t)s->unit);
    api->Uniform1i(f->sum.values, (int32_t)s->unit + 1);
    api->ActiveTexture(GL_TEXTURE0 + s->unit + 1);
    api->BindSampler(s->unit + 1, 0);
    api->BindTexture(GL_TEXTURE_2D_ARRAY, s->values);
    api->ActiveTexture(GL_TEXTURE0 + s->unit);
    api->BindSampler(s->unit, 0);
    for (uint32_t level = 0; level < f->levels; ++level) {
        for (uint32_t i = 0; i < count && result == BTF_OK;) {
            const uint32_t some = i == 0 && count % 2 == 1 ? 1 : 2;
            for (uint32_t k = 0; k < some && result == BTF_OK; ++k) {
                api->BindTexture(GL_TEXTURE_2D_ARRAY, 0);
                result = draw_values(f, s, lights + 3 * (size_t)(i + k), k, level, log);
            }
            if (result == BTF_OK) {
                result = add_lights(f, s, weights + 3 * (size_t)i, some, i == 0, level, log);
            }
            i += some;
        }
    }
    api->BindTexture(GL_TEXTURE_2D_ARRAY, 0);
    api->ActiveTexture(GL_TEXTURE0 + s->unit + 1);
    api->BindTexture(GL_TEXTURE_2D_ARRAY, 0);
    return result;
}

static btf_result check_lights(const btf_gl_fold *fold, uint32_t number, uint32_t count,
                               const float *lights, const float *weights, const float *view,
                               const btf_log *log) {
    const btf_result result = btfi_fold_check_call(fold, number, lights, view, log);
    if (result == BTF_OK &&
        ((fold->kind != BTF_FOLD_BOTH && fold->kind != BTF_FOLD_SUM) || count < 1 || !weights)) {
        return btfi_fail(
            log, BTF_ERROR_USAGE,
            "fold: lights are added up where light and view are folded to radiance, or their sum is, with "
            "weights; fold %d, %u lights",
            (int)fold->kind, (unsigned)count);
    }
    return result;
}

btf_result btf_gl_fold_run_lights(btf_gl_fold *fold, btf_gl *textures, uint32_t first_unit, uint32_t number,
                                  uint32_t count, const float *lights, const float *weights,
                                  const float view[3], const btf_log *log) {
    btfi_fold_stage stage;
    uint32_t units = 0;
    view_sum s = {.number = number};
    const bool of_views = fold->kind == BTF_FOLD_SUM;
    btf_result result = check_lights(fold, number, count, lights, weights, view, log);
    if (result != BTF_OK) {
        return result;
    }
    btfi_gl_errors(&fold->api);
    if (!fold->sum.name) {
        result = btfi_fold_program_make(&fold->api, fold->library, of_views ? views_text : sum_text, log,
                                        &fold->sum);
    }
    if (result == BTF_OK) {
        result = btfi_fold_texture(fold, 1, &s.other, log);
    }
    if (result == BTF_OK && of_views) {
        result = btfi_fold_texture(fold, 2 * fold->sampled, &s.values, log);
    }
    if (result == BTF_OK && of_views) {
        result = btf_gl_bind(textures, fold->sum.name, first_unit, NULL, log, NULL);
    }
    if (result == BTF_OK) {
        result = btf_gl_bind(textures, of_views ? fold->one.name : fold->sum.name, first_unit, NULL, log,
                             &units);
    }
    if (result == BTF_OK) {
        s.unit = first_unit + units;
        btfi_fold_begin(fold, of_views ? &fold->one : &fold->sum, view, &stage);
        result = of_views ? draw_views(fold, &s, count, lights, weights, log)
                          : draw_sum(fold, s.other, s.unit, number, count, lights, weights, log);
        fold->api.ActiveTexture(GL_TEXTURE0 + (uint32_t)stage.saved.unit);
        result = btfi_fold_end(fold, &stage, result, log);
    }
    if (s.values) {
        fold->api.DeleteTextures(1, &s.values);
    }
    if (s.other) {
        fold->api.DeleteTextures(1, &s.other);
    }
    return result;
}
