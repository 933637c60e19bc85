/* The light profiles of one view as rows of a matrix (see profiles.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "profiles.h"

#include <stdlib.h>
#include <string.h>

float *enc_profiles_create(size_t rows, int n_lights) {
    const size_t row_bytes = enc_profile_stride(n_lights) * sizeof(float);
    if (rows == 0)
        rows = 1;
    if (rows > SIZE_MAX / 2 / row_bytes)
        return NULL;
    float *profiles = aligned_alloc(64, rows * row_bytes);
    if (profiles != NULL)
        memset(profiles, 0, rows * row_bytes);
    return profiles;
}

btf_result enc_profiles_of_view(const enc_context *context, const enc_data *data, int view, float *out) {
    const size_t n_texels = enc_data_texel_count(data), n_lights = (size_t)data->n_lights;
    const size_t lanes = enc_profile_lanes(data->n_lights), stride = 3 * lanes;
    if (data->samples != NULL) {
        const size_t texel_stride = enc_data_texel_stride(data);
        const float *first = data->samples + (size_t)view * 3 * n_lights;
#pragma omp parallel for num_threads(context->threads) schedule(static)
        for (size_t t = 0; t < n_texels; t++)
            for (size_t c = 0; c < 3; c++)
                memcpy(out + t * stride + c * lanes, first + t * texel_stride + c * n_lights,
                       n_lights * sizeof(float));
        return BTF_OK;
    }
    float *images = malloc(n_lights * n_texels * 3 * sizeof *images);
    if (images == NULL)
        return enc_fail(context, BTF_ERROR_MEMORY, "view %d: no memory for its %zu images", view, n_lights);
    const btf_result result = enc_data_view(context, data, view, images);
    if (result == BTF_OK) {
#pragma omp parallel for num_threads(context->threads) schedule(static)
        for (size_t t = 0; t < n_texels; t++)
            for (size_t c = 0; c < 3; c++)
                for (size_t l = 0; l < n_lights; l++)
                    out[t * stride + c * lanes + l] = images[(l * n_texels + t) * 3 + c];
    }
    free(images);
    return result;
}
