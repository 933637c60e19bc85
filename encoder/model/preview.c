/* A material's picture. See preview.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "preview.h"

#include "decode_samples.h"

#include <math.h>
#include <stdlib.h>

static const double light_theta = 45;

static size_t choose_light(const enc_data *data) {
    int best = 0;
    for (int l = 1; l < data->n_lights; l++) {
        if (fabs(data->lights[l].theta - light_theta) < fabs(data->lights[best].theta - light_theta)) {
            best = l;
        }
    }
    return (size_t)best;
}

btf_result enc_preview(const enc_context *context, const enc_data *data, const enc_solution *solution,
                       uint16_t **out_preview) {
    const size_t texels = enc_data_texel_count(data), light = choose_light(data);
    enc_sample_decoder *decoder = NULL;
    uint16_t *preview = calloc(texels, 4 * sizeof *preview);
    float *images = malloc((size_t)data->n_lights * texels * 3 * sizeof *images);
    btf_result result = preview && images ? enc_sample_decoder_create(context, data, solution, &decoder)
                                          : enc_fail(context, BTF_ERROR_MEMORY, "preview: out of memory");
    if (result == BTF_OK) {
        const enc_decoded_samples decoded = {.decoder = decoder, .effects = BTF_EFFECT_ALL};
        const enc_image_source source = enc_decoded_images(&decoded);
        result = source.view(source.user, data->top_view, images);
    }
    for (size_t t = 0; result == BTF_OK && t < texels; t++) {
        for (size_t c = 0; c < 3; c++) {
            preview[4 * t + c] = enc_half_from_float(images[(light * texels + t) * 3 + c]);
        }
    }
    enc_sample_decoder_destroy(&decoder);
    free(images);
    if (result != BTF_OK) {
        free(preview);
        preview = NULL;
    }
    *out_preview = preview;
    return result;
}
