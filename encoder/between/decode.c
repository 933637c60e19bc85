/* Images of a material at any directions. See decode.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode.h"

#include "decoder/toolkit/filter.h"

#include <stdlib.h>

/* Decodes a texel at all pairs: out[pair][texel][3]. */
static void decode_texel(enc_evaluated_texel *texel, const btf_ref_options *options, const enc_pair *pairs,
                         const enc_evaluated_neighbours *around, size_t count, size_t texels, float *out) {
    for (size_t p = 0; p < count; p++) {
        const enc_evaluated_at at = {&around[p].lights, &around[p].views, pairs[p].light.xyz,
                                     pairs[p].view.xyz, true, false};
        enc_evaluate(texel, options, &at, &options->components, 1, (float(*)[3])(out + 3 * p * texels));
    }
}

/* Decodes a row of texels at their centres, by a filter between texels, under one pair; uv has room for 2
 * numbers a texel. */
static void filter_row(const enc_evaluator *evaluator, const btf_ref_options *options, const enc_pair *pair,
                       uint32_t row, float *uv, float *out) {
    const btf_ref_material *m = enc_evaluator_reference(evaluator);
    for (uint32_t column = 0; column < m->width; column++) {
        uv[2 * column] = filter_centre(column, m->width);
        uv[2 * column + 1] = filter_centre(m->height - 1 - row, m->height);
    }
    const btf_evaluations evaluations = {.struct_size = sizeof evaluations,
                                         .count = m->width,
                                         .uv = uv,
                                         .lights = pair->light.xyz,
                                         .views = pair->view.xyz,
                                         .fixed = BTF_FIXED_LIGHT | BTF_FIXED_VIEW,
                                         .rgb = out + 3 * (size_t)row * m->width};
    enc_evaluator_many(evaluator, options, &evaluations);
}

static btf_result filter_pairs(const enc_context *context, const enc_evaluator *evaluator,
                               const btf_ref_options *options, const enc_pair *pairs, size_t count,
                               float *out) {
    const btf_ref_material *m = enc_evaluator_reference(evaluator);
    const size_t texels = (size_t)m->width * m->height, rows = count * m->height;
    btf_result result = BTF_OK;
#pragma omp parallel num_threads(context->threads)
    {
        float *uv = malloc(2 * (size_t)m->width * sizeof *uv);
#pragma omp for schedule(dynamic, 8)
        for (size_t i = 0; i < rows; i++) {
            const bool cancelled = enc_cancelled(context);
            if (cancelled || !uv) {
                enc_keep_worse(&result, cancelled ? BTF_ERROR_INTERRUPTED : BTF_ERROR_MEMORY);
                continue;
            }
            const size_t p = i / m->height;
            filter_row(evaluator, options, &pairs[p], (uint32_t)(i % m->height), uv, out + 3 * p * texels);
        }
        free(uv);
    }
    return result;
}

btf_result enc_decode_pairs(const enc_context *context, const enc_evaluator *evaluator,
                            const btf_ref_options *options, const enc_pair *pairs, size_t count,
                            float *out) {
    const btf_ref_material *m = enc_evaluator_reference(evaluator);
    const size_t texels = (size_t)m->width * m->height;
    if (options->filter != BTF_REF_TEXEL) {
        return filter_pairs(context, evaluator, options, pairs, count, out);
    }
    enc_evaluated_neighbours *around = malloc(count * sizeof *around);
    btf_result result = around ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t p = 0; around && p < count; p++) {
        around[p] = enc_evaluated_look_up(evaluator, pairs[p].light.xyz, pairs[p].view.xyz);
    }
    const bool begun = result == BTF_OK; /* read before threads may write `result` */
#pragma omp parallel num_threads(context->threads)
    {
        enc_evaluated_texel *texel = begun ? enc_evaluated_texel_create(evaluator, 0) : NULL;
#pragma omp for schedule(dynamic, 8)
        for (size_t t = 0; t < texels; t++) {
            const bool cancelled = enc_cancelled(context);
            if (cancelled || !texel) {
                enc_keep_worse(&result, cancelled ? BTF_ERROR_INTERRUPTED : BTF_ERROR_MEMORY);
                continue;
            }
            enc_evaluated_texel_move(texel, t);
            decode_texel(texel, options, pairs, around, count, texels, out + 3 * t);
        }
        enc_evaluated_texel_destroy(&texel);
    }
    free(around);
    return result;
}
