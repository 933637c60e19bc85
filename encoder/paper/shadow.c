/* The self-shadowing part of the analysis: how much darker the data are than the fitted model.
 *
 * SPDX-License-Identifier: MIT
 */
#include "shadow.h"
#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include <math.h>
#include <stdlib.h>

/* Texels handed to a thread at once. */
enum { CHUNK = 64 };

enc_shadow_options enc_shadow_options_default(void) {
    return (enc_shadow_options){.t_error = 0.3f, .t_btf = 0.3f};
}

void enc_shadow_profile(const enc_data *data, const enc_sbrdf *sbrdf, const enc_shadow_options *options,
                        size_t texel, int view, const float *samples, float *buffer, float *out_ratio) {
    const size_t n = (size_t)data->n_lights;
    float *light[3] = {buffer, buffer + n, buffer + 2 * n};
    float *model = buffer + 3 * n;
    for (size_t l = 0; l < n; l++) {
        for (int k = 0; k < 3; k++) {
            light[k][l] = enc_data_light(data, (size_t)view, l)->xyz[k];
        }
    }
    enc_sbrdf_evaluate(sbrdf, texel, data->views[view].xyz, data->n_lights, light[0], light[1], light[2],
                       model);
    for (size_t l = 0; l < n; l++) {
        const float cosine = fmaxf(light[2][l], 0);
        float value[3];
        for (size_t c = 0; c < 3; c++) {
            const float m = model[c * n + l] * (options->square_root ? sqrtf(cosine) : cosine);
            value[c] = options->square_root ? m * m : m;
        }
        const float ratio = enc_shadow_ratio(enc_luminance(value[0], value[1], value[2]),
                                             enc_luminance(samples[l], samples[n + l], samples[2 * n + l]),
                                             options->t_error, options->t_btf);
        out_ratio[l] = options->square_root ? sqrtf(ratio) : ratio;
    }
}

/* Finds the codes of `count` texels from `first`. samples and profile are this thread's scratch memory. */
static btf_result shadow_chunk(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                               const enc_shadow_options *options, size_t first, size_t count,
                               float *samples, float *profile, uint8_t *out) {
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights;
    const float *found;
    const btf_result result = enc_data_texels(context, data, first, count, samples, &found);
    if (result != BTF_OK) {
        return result;
    }
    for (size_t i = 0; i < count; i++) {
        const float *at = found + i * enc_data_texel_stride(data) + (size_t)data->top_view * 3 * lights;
        enc_shadow_profile(data, sbrdf, options, first + i, data->top_view, at, profile,
                           profile + 6 * lights);
        for (size_t l = 0; l < lights; l++) {
            out[l * texels + first + i] = enc_shadow_code(profile[6 * lights + l]);
        }
    }
    return BTF_OK;
}

/* Hands the codes that each rank found for its texels, here first .. end - 1, to all ranks. */
static btf_result share(const enc_context *context, btf_result result, size_t texels, size_t lights,
                        size_t first, size_t end, uint8_t *codes) {
    if (enc_ranks_count(context) == 1) {
        return result;
    }
    uint8_t *turned = malloc(texels * lights); /* [texel][light] */
    if (!turned) {
        result = enc_fail(context, BTF_ERROR_MEMORY, "shadow: out of memory");
    }
    for (size_t t = first; t < end && turned; t++) {
        for (size_t l = 0; l < lights; l++) {
            turned[t * lights + l] = codes[l * texels + t];
        }
    }
    result = enc_ranks_gather(context, result, turned, lights, texels);
    for (size_t i = 0; i < texels * lights && result == BTF_OK; i++) {
        codes[i] = turned[i % texels * lights + i / texels];
    }
    free(turned);
    return result;
}

btf_result enc_top_view_shadow(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                               const enc_shadow_options *options, uint8_t *out) {
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights;
    if (!(options->t_error >= 0) || !(options->t_btf >= 0)) {
        return enc_fail(context, BTF_ERROR_USAGE, "shadow: thresholds %g and %g, expected at least 0",
                        (double)options->t_error, (double)options->t_btf);
    }
    if (sbrdf->n_texels != texels) {
        return enc_fail(context, BTF_ERROR_USAGE, "shadow: %zu texels in the SBRDF, %zu in the data",
                        sbrdf->n_texels, texels);
    }
    btf_result result = BTF_OK;
    size_t begin, end;
    enc_ranks_range(context, texels, &begin, &end);
    enc_stage_begin(context, "shadow", end - begin);
#pragma omp parallel num_threads(context->threads)
    {
        float *samples =
            data->samples ? NULL : malloc(CHUNK * enc_data_texel_stride(data) * sizeof(float));
        float *profile = malloc(7 * lights * sizeof *profile);
        btf_result mine = BTF_OK;
        if (!profile || (!samples && !data->samples)) {
            mine = enc_fail(context, BTF_ERROR_MEMORY, "shadow: out of memory");
        }
#pragma omp for schedule(static)
        for (size_t first = begin; first < end; first += CHUNK) {
            const size_t count = first + CHUNK < end ? CHUNK : end - first;
            if (mine == BTF_OK) {
                mine = enc_cancelled(context) ? BTF_ERROR_INTERRUPTED
                                              : shadow_chunk(context, data, sbrdf, options, first, count,
                                                             samples, profile, out);
            }
            enc_stage_step(context, count);
        }
        free(samples);
        free(profile);
        enc_keep_worse(&result, mine);
    }
    result = share(context, result, texels, lights, begin, end, out);
    enc_stage_end(context);
    return result;
}
