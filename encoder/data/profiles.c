/* The light profiles of one view as rows of a matrix (see profiles.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "profiles.h"

#include <stdlib.h>
#include <string.h>

float *enc_profiles_create(size_t rows, int n_lights) {
    const size_t row_bytes = enc_profile_stride(n_lights) * sizeof(float);
    if (rows == 0) {
        rows = 1;
    }
    if (rows > SIZE_MAX / 2 / row_bytes) {
        return NULL;
    }
    float *profiles = aligned_alloc(64, rows * row_bytes);
    if (profiles) {
        memset(profiles, 0, rows * row_bytes);
    }
    return profiles;
}

/* texels: NULL means all of them. */
static btf_result gather(const enc_context *context, const enc_data *data, int view, size_t count,
                         const size_t *texels, float *out) {
    const size_t n_texels = enc_data_texel_count(data), n_lights = (size_t)data->n_lights;
    const size_t lanes = enc_profile_lanes(data->n_lights), stride = 3 * lanes;
    if (data->samples) {
        const size_t texel_stride = enc_data_texel_stride(data);
        const float *first = data->samples + (size_t)view * 3 * n_lights;
#pragma omp parallel for num_threads(context->threads) schedule(static)
        for (size_t i = 0; i < count; i++) {
            const float *profile = first + (texels ? texels[i] : i) * texel_stride;
            for (size_t c = 0; c < 3; c++) {
                memcpy(out + i * stride + c * lanes, profile + c * n_lights, n_lights * sizeof(float));
            }
        }
        return BTF_OK;
    }
    float *images = malloc(n_lights * n_texels * 3 * sizeof *images);
    if (!images) {
        return BTF_ERROR_MEMORY;
    }
    const btf_result result = enc_data_view(context, data, view, images);
    if (result == BTF_OK) {
#pragma omp parallel for num_threads(context->threads) schedule(static)
        for (size_t i = 0; i < count; i++) {
            const float *pixel = images + (texels ? texels[i] : i) * 3;
            for (size_t c = 0; c < 3; c++) {
                for (size_t l = 0; l < n_lights; l++) {
                    out[i * stride + c * lanes + l] = pixel[l * n_texels * 3 + c];
                }
            }
        }
    }
    free(images);
    return result;
}

btf_result enc_profiles_of_view(const enc_context *context, const enc_data *data, int view, float *out) {
    return gather(context, data, view, enc_data_texel_count(data), NULL, out);
}

btf_result enc_profiles_of_texels(const enc_context *context, const enc_data *data, int view, size_t count,
                                  const size_t *texels, float *out) {
    return gather(context, data, view, count, texels, out);
}
