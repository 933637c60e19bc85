/* Images of a material at any directions. See decode.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode.h"

static btf_ref_neighbours look_up(const uint16_t *table, uint32_t grid, const float direction[3]) {
    int32_t q[2];
    btf_ref_project(direction, q);
    return btf_ref_lookup(table, grid, q);
}

static void decode_row(const btf_ref_material *m, const btf_ref_options *options, const enc_pair *pair,
                       uint32_t row, float *out) {
    const btf_ref_neighbours views = look_up(m->view_table, m->view_grid, pair->view.xyz);
    const btf_ref_neighbours lights = look_up(m->light_table, m->light_grid, pair->light.xyz);
    for (uint32_t column = 0; column < m->width; column++, out += 3)
        btf_ref_evaluate_neighbours(m, options, column, row, &lights, &views, pair->light.xyz,
                                    pair->view.xyz, out);
}

btf_result enc_decode_pairs(const enc_context *context, const btf_ref_material *material,
                            const btf_ref_options *options, const enc_pair *pairs, size_t count,
                            float *out) {
    const size_t rows = count * material->height;
    btf_result result = BTF_OK;
#pragma omp parallel for schedule(dynamic, 8) num_threads(context->threads)
    for (size_t i = 0; i < rows; i++) {
        if (enc_cancelled(context)) {
#pragma omp atomic write
            result = BTF_ERROR_INTERRUPTED;
            continue;
        }
        decode_row(material, options, &pairs[i / material->height], (uint32_t)(i % material->height),
                   out + i * material->width * 3);
    }
    return result;
}
