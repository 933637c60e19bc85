/* Images of a material at any directions. See decode.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode.h"

#include "decoder/toolkit/filter.h"

#include <stdlib.h>

/* A texel at all pairs: out[pair][texel][3]. */
static void decode_texel(enc_evaluated_texel *texel, const btf_ref_options *options, const enc_pair *pairs,
                         const enc_evaluated_neighbours *around, size_t count, size_t texels, float *out) {
    for (size_t p = 0; p < count; p++) {
        const enc_evaluated_at at = {&around[p].lights, &around[p].views, pairs[p].light.xyz,
                                     pairs[p].view.xyz, true, false};
        enc_evaluate(texel, options, &at, &options->components, 1, (float(*)[3])(out + 3 * p * texels));
    }
}

/* The same at its centre by a filter between texels, which the evaluator does not have. */
static void filter_texel(const btf_ref_material *m, const btf_ref_options *options, const enc_pair *pairs,
                         size_t texel, size_t count, float *out) {
    const uint32_t column = (uint32_t)(texel % m->width),
                   below = m->height - 1 - (uint32_t)(texel / m->width);
    const size_t texels = (size_t)m->width * m->height;
    for (size_t p = 0; p < count; p++) {
        btf_ref_evaluate(m, options, filter_centre(column, m->width), filter_centre(below, m->height),
                         pairs[p].light.xyz, pairs[p].view.xyz, out + 3 * p * texels);
    }
}

btf_result enc_decode_pairs(const enc_context *context, const enc_evaluator *evaluator,
                            const btf_ref_options *options, const enc_pair *pairs, size_t count,
                            float *out) {
    const btf_ref_material *m = enc_evaluator_reference(evaluator);
    const size_t texels = (size_t)m->width * m->height;
    enc_evaluated_neighbours *around = malloc(count * sizeof *around);
    btf_result result = around ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t p = 0; around && p < count; p++)
        around[p] = enc_evaluated_look_up(evaluator, pairs[p].light.xyz, pairs[p].view.xyz);
#pragma omp parallel num_threads(context->threads)
    {
        enc_evaluated_texel *texel = result == BTF_OK ? enc_evaluated_texel_create(evaluator, 0) : NULL;
#pragma omp for schedule(dynamic, 8)
        for (size_t t = 0; t < texels; t++) {
            const bool cancelled = enc_cancelled(context);
            if (cancelled || !texel) {
#pragma omp atomic write
                result = cancelled ? BTF_ERROR_INTERRUPTED : BTF_ERROR_MEMORY;
                continue;
            }
            if (options->filter != BTF_REF_TEXEL) {
                filter_texel(m, options, pairs, t, count, out + 3 * t);
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
