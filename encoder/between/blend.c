/* Images of a data set at directions between its samples. See blend.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "blend.h"

#include <math.h>
#include <stdlib.h>

struct enc_blend {
    const enc_data *data;
    bool roots; /* square roots of radiance are blended, not radiance */
    enc_interpolator *views, *lights;
};

typedef struct pair_weights {
    enc_weights view, light;
} pair_weights;

btf_result enc_blend_create(const enc_context *context, const enc_data *data, enc_interpolation kind,
                            enc_blend **out_blend) {
    enc_blend *blend = calloc(1, sizeof *blend);
    btf_result result = blend ? BTF_OK : BTF_ERROR_MEMORY;
    *out_blend = NULL;
    if (result == BTF_OK) {
        blend->data = data;
        blend->roots = kind == ENC_INTERPOLATE_SPLINE;
        result = enc_interpolator_create(context, "views", data->views, data->n_views, kind, &blend->views);
    }
    if (result == BTF_OK) {
        result =
            enc_interpolator_create(context, "lights", data->lights, data->n_lights, kind, &blend->lights);
    }
    if (result != BTF_OK) {
        enc_blend_destroy(&blend);
    }
    *out_blend = blend;
    return result;
}

void enc_blend_destroy(enc_blend **blend) {
    if (!blend || !*blend) {
        return;
    }
    enc_interpolator_destroy(&(*blend)->views);
    enc_interpolator_destroy(&(*blend)->lights);
    free(*blend);
    *blend = NULL;
}

/* The weighted sum of a profile, the samples of a texel, a view and a channel under every light. all: the
 * indices are 0, 1, ...; then four partial sums, always added in the same order, leave the compiler free to
 * use vectors. */
static float weigh(const float *profile, const enc_weights *w, bool all) {
    float lane[4] = {0};
    int i = 0;
    if (all) {
        for (; i + 4 <= w->count; i += 4) {
            for (int k = 0; k < 4; k++) {
                lane[k] += w->weight[i + k] * profile[i + k];
            }
        }
    }
    for (; i < w->count; i++) {
        lane[0] += w->weight[i] * profile[w->index[i]];
    }
    return (lane[0] + lane[1]) + (lane[2] + lane[3]);
}

/* Blends the samples of a texel, [view][channel][light], for one pair of view and light. */
static void blend_texel(const enc_blend *b, const pair_weights *w, const float *samples, float out[3]) {
    const size_t lights = (size_t)b->data->n_lights;
    const bool all = w->light.count == b->data->n_lights; /* then the indices are 0, 1, ... */
    for (size_t c = 0; c < 3; c++) {
        float sum = 0;
        for (int a = 0; a < w->view.count; a++) {
            sum += w->view.weight[a] *
                   weigh(samples + (w->view.index[a] * 3 + c) * lights, &w->light, all && b->roots);
        }
        out[c] = !b->roots ? sum : sum > 0 ? sum * sum : 0.0f;
    }
}

/* Fills in one texel of the images of all pairs: out[pair][texel][3]. */
static btf_result blend_all(const enc_context *context, const enc_blend *b, const pair_weights *weights,
                            size_t count, size_t texel, float *buffer, float *roots, float *out) {
    const size_t texels = enc_data_texel_count(b->data), stride = enc_data_texel_stride(b->data);
    const float *samples;
    const btf_result result = enc_data_texels(context, b->data, texel, 1, buffer, &samples);
    if (result != BTF_OK) {
        return result;
    }
    if (b->roots) {
        for (size_t i = 0; i < stride; i++) {
            roots[i] = sqrtf(samples[i]);
        }
        samples = roots;
    }
    for (size_t p = 0; p < count; p++) {
        blend_texel(b, &weights[p], samples, out + 3 * (p * texels + texel));
    }
    return BTF_OK;
}

btf_result enc_blend_images(const enc_context *context, const enc_blend *blend, const enc_pair *pairs,
                            size_t count, float *out) {
    const size_t texels = enc_data_texel_count(blend->data), stride = enc_data_texel_stride(blend->data);
    pair_weights *weights = malloc(count * sizeof *weights);
    btf_result result = weights ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t p = 0; result == BTF_OK && p < count; p++) {
        enc_interpolator_weights(blend->views, pairs[p].view.xyz, &weights[p].view);
        enc_interpolator_weights(blend->lights, pairs[p].light.xyz, &weights[p].light);
    }
#pragma omp parallel num_threads(context->threads) if (result == BTF_OK)
    {
        float *buffer = malloc(stride * sizeof *buffer), *roots = malloc(stride * sizeof *roots);
        btf_result mine = buffer && roots ? result : BTF_ERROR_MEMORY;
#pragma omp for schedule(dynamic, 16)
        for (size_t t = 0; t < texels; t++) {
            if (mine == BTF_OK && enc_cancelled(context)) {
                mine = BTF_ERROR_INTERRUPTED;
            }
            if (mine == BTF_OK) {
                mine = blend_all(context, blend, weights, count, t, buffer, roots, out);
            }
        }
        free(roots);
        free(buffer);
        enc_keep_worse(&result, mine);
    }
    free(weights);
    return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "images between the samples: out of memory") : result;
}
