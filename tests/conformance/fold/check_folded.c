/* A folded material on the device against the reference without a fold.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/conformance/cases.h"
#include "tests/conformance/check_internal.h"
#include "decoder/toolkit/reference_view.h"
#include "tests/conformance/variant.h"

#include <math.h>
#include <stdlib.h>
#include <openbtf/fold.h>

enum { LIGHTS = 2, SUMMED = 3, FOLD_UNIT = 30, EVALUATIONS = 64 };

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

/* The level that the decoder must take for the one that element i asks for. */
static uint32_t level_of(size_t i, uint32_t levels) {
    const uint32_t asked = (uint32_t)(i % GPU_SIDE / 2 % (levels + 2));
    return asked == 0 ? 0 : asked > levels ? levels - 1 : asked - 1;
}

btf_fold check_fold_kind(const btf_material_info *info, uint64_t seed, uint64_t count) {
    const uint64_t views = (uint64_t)info->n_views * info->width * info->height * LIGHTS;
    const bool light = info->colour == BTF_COLOUR_NONE && views <= EVALUATIONS * count;
    const uint64_t kind = seed / 3 % 3;
    if (kind == 0 && light) {
        return seed / 9 % 2 == 1 ? BTF_FOLD_SUM : BTF_FOLD_LIGHT;
    }
    return kind == 1 ? BTF_FOLD_BOTH : BTF_FOLD_NEIGHBOURS;
}

uint32_t check_fold_left_out(btf_fold kind) {
    return kind == BTF_FOLD_SUM     ? BTF_EFFECT_GLOSS | BTF_EFFECT_RELIEF
           : kind == BTF_FOLD_LIGHT ? BTF_EFFECT_GLOSS
           : kind == BTF_FOLD_BOTH  ? BTF_EFFECT_RELIEF
                                    : 0;
}

/* The directions that are folded. The second of BTF_FOLD_BOTH is a sum of several lights where sums is not NULL; that of
 * BTF_FOLD_SUM always is, and the first of one light. */
typedef struct folding {
    float directions[LIGHTS][2][3]; /* light, view */
    float lights[SUMMED][3], weights[SUMMED][3];
    float *sums[BTF_MAX_LEVELS]; /* of the reference, [row][column][4] */
    uint32_t *texels[LIGHTS];    /* of BTF_FOLD_SUM, by the library on the CPU: all levels */
    btf_ref_material levels[BTF_MAX_LEVELS];
    btf_ref_options options;
    bool view_is_fixed;
} folding;

/* The reference's sum of lights, of each level. */
static btf_result add_lights(folding *of, uint32_t levels) {
    for (uint32_t level = 0; level < levels; ++level) {
        const btf_ref_material *m = &of->levels[level];
        const size_t texels = (size_t)m->width * m->height;
        float *one = malloc(4 * texels * sizeof *one);
        of->sums[level] = calloc(4 * texels, sizeof *one);
        for (int i = 0; i < SUMMED && one && of->sums[level]; ++i) {
            btf_ref_fold_both(m, &of->options, of->lights[i], of->directions[1][1], 0, m->height, one);
            btf_ref_fold_add(texels, one, of->weights[i], of->sums[level]);
        }
        free(one);
        if (!one || !of->sums[level]) {
            return BTF_ERROR_MEMORY;
        }
    }
    return BTF_OK;
}

/* Draws arguments of folds, and what the reference expects of a sum. */
static btf_result choose_folding(random_state *r, const check_subject *s, const btf_material_info *info,
                                 bool sum, btf_shader_options *shader, uint64_t seed, folding *of) {
    const btf_directions views = btf_material_views(s->material), lights = btf_material_lights(s->material);
    *of = (folding){.options = variant_reference_options(shader)};
    for (uint32_t level = 0; level < info->levels; ++level) {
        reference_view(s->material, level, &of->levels[level]);
    }
    for (int i = 0; i < LIGHTS; ++i) {
        case_direction(r, &lights, of->directions[i][0]);
        case_direction(r, &views, of->directions[i][1]);
    }
    const float *view = of->directions[0][1];
    const float length = view[0] * view[0] + view[1] * view[1] + view[2] * view[2];
    const bool fixed =
        shader->fold == BTF_FOLD_SUM ? !(seed & 1) : shader->fold == BTF_FOLD_NEIGHBOURS && seed & 1;
    if (fixed && fabsf(length - 1) < 1e-5f && view[2] > 0.01f) {
        shader->fixed |= BTF_FIXED_VIEW; /* of both lights */
        of->view_is_fixed = true;
        memcpy(shader->fixed_view, view, sizeof shader->fixed_view);
        memcpy(of->directions[1][1], view, sizeof shader->fixed_view);
    }
    for (int i = 0; i < SUMMED && sum; ++i) {
        case_direction(r, &lights, of->lights[i]);
        for (int c = 0; c < 3; ++c) {
            of->weights[i][c] = (float)random_between(r, 0, 2);
        }
    }
    static const float whole[3] = {1, 1, 1};
    if (shader->fold == BTF_FOLD_SUM) {
        const btf_result one = btf_material_fold_sum(s->material, shader, 1, of->directions[0][0], whole,
                                                     s->log, &of->texels[0]);
        return one ? one
                   : btf_material_fold_sum(s->material, shader, SUMMED, of->lights[0], of->weights[0],
                                           s->log, &of->texels[1]);
    }
    return sum ? add_lights(of, info->levels) : BTF_OK;
}

/* Uploads the textures that the fold's pass reads, and folds the lights, for the programs of the fold and the
 * session. */
static btf_result make_fold(const check_session *session, const btf_shader_options *shader,
                            const folding *of, btf_gl_fold **out_fold) {
    const check_subject *s = session->subject;
    btf_gl_options options = gpu_gl_options(s->gpu, NULL);
    btf_gl *textures = NULL;
    btf_result result = btf_gl_upload(s->material, &options, s->log, &textures);
    options.shader = shader;
    options.get_proc_address = s->find ? s->find : options.get_proc_address;
    if (result == BTF_OK) {
        result = btf_gl_fold_create(s->material, &options, LIGHTS, s->log, out_fold);
    }
    for (uint32_t i = 0; i < LIGHTS && result == BTF_OK; ++i) {
        result = i == 1 && (of->sums[0] || of->texels[0])
                     ? btf_gl_fold_run_lights(*out_fold, textures, GPU_FIRST_UNIT, i, SUMMED, of->lights[0],
                                              of->weights[0], of->directions[i][1], s->log)
                     : btf_gl_fold_run(*out_fold, textures, GPU_FIRST_UNIT, i, of->directions[i][0],
                                       of->directions[i][1], s->log);
    }
    btf_gl_destroy(&textures);
    return result;
}

/* Writes the arguments of evaluation i, and what is expected. */
static void choose_case(random_state *r, check_session *session, const folding *of, btf_fold kind,
                        uint32_t levels, size_t i) {
    static const float normal[3] = {0, 0, 1};
    const btf_directions views = btf_material_views(session->subject->material);
    float f[CASE_WORDS], rgb[3];
    const uint32_t at = level_of(i, levels);
    const btf_ref_material *level = &of->levels[at];
    f[0] = case_coordinate(r, level->width);
    f[1] = case_coordinate(r, level->height);
    memcpy(f + 2, of->directions[i & 1][0], sizeof of->directions[0][0]);
    if ((kind != BTF_FOLD_LIGHT && kind != BTF_FOLD_SUM) || of->view_is_fixed) {
        memcpy(f + 5, of->directions[i & 1][1], sizeof of->directions[0][1]);
    } else {
        case_direction(r, &views, f + 5);
    }
    memcpy(session->inputs + GPU_INPUTS * i, f, sizeof f);
    const btf_ref_folded sum = {BTF_REF_FOLD_BOTH, of->sums[at]};
    if (kind == BTF_FOLD_SUM) {
        size_t texels = 0;
        for (uint32_t finer = 0; finer < at; ++finer) {
            texels += (size_t)of->levels[finer].width * of->levels[finer].height;
        }
        const size_t layers = (size_t)level->n_views * (level->blend == BTF_REF_BLEND_ROOTS ? 4 : 1);
        const btf_ref_folded lights = {BTF_REF_FOLD_SUM,
                                       (const float *)of->texels[i & 1] + 4 * layers * texels};
        btf_ref_evaluate_folded(level, &of->options, &lights, f[0], f[1], i & 1 ? normal : f + 2, f + 5,
                                rgb);
    } else if (i & 1 && sum.values) {
        btf_ref_evaluate_folded(level, &of->options, &sum, f[0], f[1], normal, f + 5, rgb);
    } else {
        btf_ref_evaluate(level, &of->options, f[0], f[1], f + 2, f + 5, rgb);
    }
    memcpy(session->expected + GPU_OUTPUTS * i, rgb, sizeof rgb);
    session->expected[GPU_OUTPUTS * i + 3] = 0;
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
    folding of;
    btf_gl_fold *fold = NULL;
    const bool sum =
        shader.fold == BTF_FOLD_SUM || (shader.fold == BTF_FOLD_BOTH &&
                                        (uint64_t)info.width * info.height * SUMMED <= EVALUATIONS * count);
    btf_result result = choose_folding(&r, subject, &info, sum, &shader, seed, &of);
    const bool begun = result == BTF_OK && (result = check_begin(&altered, body, &session)) == BTF_OK;
    if (begun) {
        result = make_fold(&session, &shader, &of, &fold);
    }
    if (result == BTF_OK) {
        btf_gl_bind(session.gl, session.program, GPU_FIRST_UNIT, NULL, subject->log, NULL);
        btf_gl_fold_bind(fold, session.program, FOLD_UNIT, NULL);
    }
    const uint64_t batch = (uint64_t)GPU_SIDE * GPU_SIDE;
    for (uint64_t first = 0; first < count && result == BTF_OK; first += batch) {
        const size_t n = (size_t)(count - first < batch ? count - first : batch);
        for (size_t i = 0; i < n; ++i) {
            choose_case(&r, &session, &of, shader.fold, info.levels, i);
        }
        result = check_batch(&session, "folded", first, n, 3, outcome);
    }
    btf_gl_fold_destroy(&fold);
    if (begun) {
        check_end(&session);
    }
    for (int level = 0; level < BTF_MAX_LEVELS; ++level) {
        free(of.sums[level]);
    }
    btf_free(of.texels[0]);
    btf_free(of.texels[1]);
    return result;
}
