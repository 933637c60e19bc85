/* A folded material on the device against the reference that folds nothing.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/conformance/cases.h"
#include "tests/conformance/check_internal.h"
#include "decoder/toolkit/reference_view.h"
#include "tests/conformance/variant.h"

#include <math.h>
#include <openbtf/fold.h>

enum { LIGHTS = 2, FOLD_UNIT = 30, EVALUATIONS = 64 };

/* Odd elements ask for the second light by its number; every pair of elements for a level. */
static const char body[] = "uvec4 check(uvec4 a, uvec4 b) {\n"
                           "    vec2 uv = uintBitsToFloat(a.xy);\n"
                           "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x)), c;\n"
                           "    vec3 v = uintBitsToFloat(b.yzw);\n"
                           "    int at = int(gl_FragCoord.x), level = at / 2 % (int(BTF_LEVELS) + 2) - 1;\n"
                           "    if ((at & 1) == 1)\n"
                           "        c = btf_evaluate_folded(uv, v, 1, level);\n"
                           "    else\n"
                           "        c = btf_evaluate_level(uv, l, v, level);\n"
                           "    return uvec4(floatBitsToUint(c), 0u);\n"
                           "}\n";

/* The level, of those there are, that stands for what element i asks for. */
static uint32_t level_of(size_t i, uint32_t levels) {
    const uint32_t asked = (uint32_t)(i % GPU_SIDE / 2 % (levels + 2));
    return asked == 0 ? 0 : asked > levels ? levels - 1 : asked - 1;
}

btf_fold check_fold_kind(const btf_material_info *info, uint64_t seed, uint64_t count) {
    const uint64_t views = (uint64_t)info->n_views * info->width * info->height * LIGHTS;
    const bool light = info->colour == BTF_COLOUR_NONE && views <= EVALUATIONS * count;
    const uint64_t kind = seed / 3 % 3;
    if (kind == 0 && light)
        return BTF_FOLD_LIGHT;
    return kind == 1 ? BTF_FOLD_BOTH : BTF_FOLD_NEIGHBOURS;
}

uint32_t check_fold_left_out(btf_fold kind) {
    return kind == BTF_FOLD_LIGHT ? BTF_EFFECT_GLOSS : kind == BTF_FOLD_BOTH ? BTF_EFFECT_RELIEF : 0;
}

/* Uploads all that the pass reads and folds the lights, for the fold's own programs and the session's. */
static btf_result make_fold(const check_session *session, const btf_shader_options *shader,
                            float directions[LIGHTS][2][3], btf_gl_fold **out_fold) {
    const check_subject *s = session->subject;
    btf_gl_options options = gpu_gl_options(s->gpu, NULL);
    btf_gl *textures = NULL;
    btf_result result = btf_gl_upload(s->material, &options, s->log, &textures);
    options.shader = shader;
    options.get_proc_address = s->find ? s->find : options.get_proc_address;
    if (result == BTF_OK)
        result = btf_gl_fold_create(s->material, &options, LIGHTS, s->log, out_fold);
    for (uint32_t i = 0; i < LIGHTS && result == BTF_OK; ++i)
        result = btf_gl_fold_run(*out_fold, textures, GPU_FIRST_UNIT, i, directions[i][0], directions[i][1],
                                 s->log);
    btf_gl_destroy(&textures);
    return result;
}

btf_result check_folded(const check_subject *subject, uint64_t seed, uint64_t count,
                        check_outcome *outcome) {
    random_state r = {seed};
    check_session session;
    check_subject altered = *subject;
    btf_shader_options shader = *subject->shader;
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(subject->material, &info);
    shader.fold = check_fold_kind(&info, seed, count);
    shader.leave_out |= check_fold_left_out(shader.fold);
    altered.shader = &shader;
    const btf_directions views = btf_material_views(subject->material),
                         lights = btf_material_lights(subject->material);
    float directions[LIGHTS][2][3]; /* light, view */
    for (int i = 0; i < LIGHTS; ++i) {
        case_direction(&r, &lights, directions[i][0]);
        case_direction(&r, &views, directions[i][1]);
    }
    const float *view = directions[0][1];
    const float length = view[0] * view[0] + view[1] * view[1] + view[2] * view[2];
    if (shader.fold == BTF_FOLD_NEIGHBOURS && seed & 1 && fabsf(length - 1) < 1e-5f && view[2] > 0.01f) {
        shader.fixed |= BTF_FIXED_VIEW; /* of both lights */
        memcpy(shader.fixed_view, view, sizeof shader.fixed_view);
        memcpy(directions[1][1], view, sizeof shader.fixed_view);
    }
    btf_gl_fold *fold = NULL;
    btf_result result = check_begin(&altered, body, &session);
    if (result != BTF_OK)
        return result;
    result = make_fold(&session, &shader, directions, &fold);
    if (result == BTF_OK) {
        btf_gl_bind(session.gl, session.program, GPU_FIRST_UNIT, NULL, subject->log, NULL);
        btf_gl_fold_bind(fold, session.program, FOLD_UNIT, NULL);
    }
    btf_ref_material levels[BTF_MAX_LEVELS];
    for (uint32_t level = 0; level < info.levels; ++level)
        reference_view(subject->material, level, &levels[level]);
    const btf_ref_options options = variant_reference_options(&shader);
    const uint64_t batch = (uint64_t)GPU_SIDE * GPU_SIDE;
    for (uint64_t first = 0; first < count && result == BTF_OK; first += batch) {
        const size_t n = (size_t)(count - first < batch ? count - first : batch);
        for (size_t i = 0; i < n; ++i) {
            float f[CASE_WORDS], rgb[3];
            const btf_ref_material *level = &levels[level_of(i, info.levels)];
            f[0] = case_coordinate(&r, level->width);
            f[1] = case_coordinate(&r, level->height);
            memcpy(f + 2, directions[i & 1][0], sizeof directions[0][0]);
            if (shader.fold != BTF_FOLD_LIGHT)
                memcpy(f + 5, directions[i & 1][1], sizeof directions[0][1]);
            else
                case_direction(&r, &views, f + 5);
            memcpy(session.inputs + GPU_INPUTS * i, f, sizeof f);
            btf_ref_evaluate(level, &options, f[0], f[1], f + 2, f + 5, rgb);
            memcpy(session.expected + GPU_OUTPUTS * i, rgb, sizeof rgb);
            session.expected[GPU_OUTPUTS * i + 3] = 0;
        }
        result = check_batch(&session, "folded", first, n, 3, outcome);
    }
    btf_gl_fold_destroy(&fold);
    check_end(&session);
    return result;
}
