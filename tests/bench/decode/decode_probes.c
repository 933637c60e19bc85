/* Samples as inputs of decoders. See decode_probes.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_probes.h"

#include "encoder/math/srgb.h"
#include "encoder/report/metrics.h"
#include "tests/conformance/random.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void decode_probes_clear(decode_probes *p) {
    free(p->inputs);
    free(p->truth);
    *p = (decode_probes){0};
}

/* The centre of texel t, moved by a little, because u * 2^18 is rounded down. */
static void probe_input(int width, int height, size_t t, const enc_direction *light,
                        const enc_direction *view, uint32_t *out) {
    const float u = ((float)(t % (size_t)width) + 0.5f) / (float)width + 0x1p-18f;
    const float v = 1 - ((float)(t / (size_t)width) + 0.5f) / (float)height + 0x1p-18f;
    const float *l = light->xyz, *w = view->xyz;
    const float f[GPU_INPUTS] = {u, v, l[0], l[1], l[2], w[0], w[1], w[2]};
    memcpy(out, f, sizeof f);
}

btf_result decode_probes_create(const enc_context *context, const enc_data *data, decode_probes *p) {
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights;
    random_state random = {1};
    float *buffer = malloc(enc_data_texel_stride(data) * sizeof *buffer);
    *p = (decode_probes){calloc(DECODE_PROBES, GPU_INPUTS * sizeof *p->inputs),
                         calloc(DECODE_PROBES, 3 * sizeof *p->truth)};
    btf_result result = buffer && p->inputs && p->truth
                            ? BTF_OK
                            : enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory for samples");
    for (size_t i = 0; i < DECODE_PROBES && result == BTF_OK; i++) {
        /* spread evenly over texels, so that none is read twice */
        const size_t t = i * texels / DECODE_PROBES, view = random_bits(&random) % (uint64_t)data->n_views,
                     light = random_bits(&random) % lights;
        const float *samples;
        result = enc_data_texels(context, data, t, 1, buffer, &samples);
        probe_input(data->width, data->height, t, &data->lights[light], &data->views[view],
                    p->inputs + GPU_INPUTS * i);
        for (size_t c = 0; c < 3 && result == BTF_OK; c++) {
            p->truth[3 * i + c] = samples[(view * 3 + c) * lights + light];
        }
    }
    free(buffer);
    if (result != BTF_OK) {
        decode_probes_clear(p);
    }
    return result;
}

btf_result decode_probes_between(const enc_context *context, const bench_truth *truth, decode_probes *p) {
    const size_t texels = (size_t)truth->width * (size_t)truth->height;
    random_state random = {2};
    *p = (decode_probes){calloc(DECODE_PROBES, GPU_INPUTS * sizeof *p->inputs),
                         calloc(DECODE_PROBES, 3 * sizeof *p->truth)};
    if (!p->inputs || !p->truth) {
        decode_probes_clear(p);
        return enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory for samples");
    }
    for (size_t i = 0; i < DECODE_PROBES; i++) {
        const size_t t = i * texels / DECODE_PROBES, at = (size_t)(random_bits(&random) % truth->count);
        const enc_pair *pair = &truth->pair[at];
        probe_input(truth->width, truth->height, t, &pair->light, &pair->view, p->inputs + GPU_INPUTS * i);
        memcpy(p->truth + 3 * i, truth->images + 3 * (at * texels + t), 3 * sizeof *p->truth);
    }
    return BTF_OK;
}

void decode_probes_compare(const decode_probes *p, const float *decoded, size_t pitch, double *out_linear,
                           double *out_srgb) {
    enc_error_sum sum = {.count = 3.0 * DECODE_PROBES};
    for (size_t i = 0; i < DECODE_PROBES; i++) {
        for (size_t c = 0; c < 3; c++) {
            const float a = fminf(fmaxf(decoded[i * pitch + c], 0), 1),
                        b = fminf(fmaxf(p->truth[3 * i + c], 0), 1);
            const double linear = (double)a - b, srgb = (double)enc_srgb_encode(a) - enc_srgb_encode(b);
            sum.linear += linear * linear;
            sum.srgb += srgb * srgb;
        }
    }
    *out_linear = enc_psnr_linear(&sum);
    *out_srgb = enc_psnr_srgb(&sum);
}
