/* The light profiles of one view as rows of a matrix.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PROFILES_H
#define OPENBTF_ENCODER_PROFILES_H

#include "data.h"

/* Lights rounded up to whole vectors of 16 lanes. */
static inline size_t enc_profile_lanes(int n_lights) {
    return ((size_t)n_lights + 15) / 16 * 16;
}
/* Floats of a profile: three channels of enc_profile_lanes. */
static inline size_t enc_profile_stride(int n_lights) {
    return 3 * enc_profile_lanes(n_lights);
}

/* An array of `rows` profiles, zeroed and aligned to 64 bytes; free() releases it. NULL when out of memory. */
float *enc_profiles_create(size_t rows, int n_lights);

/* Gathers one view: out[texel][channel][lane], lane = light, lanes from n_lights on are left as they are;
 * values as in data->samples. Uses context->threads. Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result enc_profiles_of_view(const enc_context *context, const enc_data *data, int view, float *out);

/* Gathers only the `count` texels of the list, in its order: out[i] is the profile of texels[i]. */
btf_result enc_profiles_of_texels(const enc_context *context, const enc_data *data, int view, size_t count,
                                  const size_t *texels, float *out);

#endif
