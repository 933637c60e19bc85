/* Compares decoded images with the data, at directions that were encoded and at others. See results.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/bench/results.h"

#include "decoder/toolkit/reference_view.h"
#include "encoder/report/metrics.h"
#include "encoder/model/decode_samples.h"
#include "encoder/data/images.h"

#include <stdlib.h>

static btf_result compare(const enc_context *context, const enc_data *truth, enc_image_source images,
                          bool ssim, double *out_linear, double *out_srgb, double *out_ssim) {
    enc_metrics m;
    const btf_result result = enc_metrics_compare(context, truth, enc_data_images(truth), images, ssim, &m);
    if (result == BTF_OK) {
        *out_linear = enc_psnr_linear(&m.total);
        *out_srgb = enc_psnr_srgb(&m.total);
        if (out_ssim) {
            *out_ssim = m.ssim;
        }
    }
    return result;
}

btf_result bench_accuracy(const enc_context *context, const bench_held *held, const bench_between *between,
                          const bench_encoded *encoded, uint32_t effects, bench_row *row) {
    const btf_ref_options options = {.effects = effects,
                                     .components = UINT32_MAX,
                                     .interpolation = BTF_REF_LINEAR,
                                     .filter = BTF_REF_TEXEL};
    enc_sample_decoder *decoder = NULL;
    btf_ref_material material;
    btf_result result = enc_sample_decoder_create(context, held->train, &encoded->solution, &decoder);
    const enc_decoded_samples played = {.decoder = decoder, .effects = effects};
    if (result == BTF_OK) {
        result = compare(context, held->train, enc_decoded_images(&played), true, &row->linear, &row->srgb,
                         &row->ssim);
    }
    enc_sample_decoder_destroy(&decoder);
    reference_view(encoded->material, 0, &material);
    if (result == BTF_OK) {
        result = bench_between_material(context, between, &material, &options, row->between);
    }
    for (int i = 0; i < BENCH_HELD_SETS && held->sets[i] && result == BTF_OK; i++) {
        const enc_reference_images decoded = {
            .shape = held->sets[i], .material = material, .options = options};
        result = compare(context, held->sets[i], enc_reference_image_source(&decoded), false,
                         &row->held[i][0], &row->held[i][1], NULL);
    }
    return result;
}

btf_result bench_decode_all(const enc_context *context, const enc_data *shape, enc_image_source images,
                            enc_data **out_data) {
    const size_t texels = enc_data_texel_count(shape), lights = (size_t)shape->n_lights;
    const size_t row = 3 * lights, stride = enc_data_texel_stride(shape);
    btf_result result = enc_data_create(context, shape->width, shape->height, shape->n_views, shape->views,
                                        shape->n_lights, shape->lights, out_data);
    if (result != BTF_OK) {
        return result;
    }
    if (!(*out_data)->samples) {
        enc_data_destroy(out_data);
        return enc_fail(context, BTF_ERROR_MEMORY, "bench: decoded peers need all samples in memory");
    }
#pragma omp parallel for schedule(dynamic) num_threads(context->threads)
    for (int view = 0; view < shape->n_views; view++) {
        float *view_images = malloc(texels * row * sizeof *view_images);
        btf_result mine = view_images ? images.view(images.user, view, view_images) : BTF_ERROR_MEMORY;
        for (size_t i = 0; i < texels * row && mine == BTF_OK; i++) {
            const size_t light = i / (3 * texels), texel = i / 3 % texels, channel = i % 3;
            (*out_data)->samples[texel * stride + (size_t)view * row + channel * lights + light] =
                view_images[i];
        }
        free(view_images);
        enc_keep_worse(&result, mine);
    }
    if (result != BTF_OK) {
        enc_data_destroy(out_data);
    }
    return result;
}

btf_result bench_accuracy_images(const enc_context *context, const bench_held *held,
                                 const bench_between *between, const btf_ref_material *tables,
                                 enc_image_source images, bench_row *row) {
    enc_data *decoded = NULL;
    btf_result result = bench_decode_all(context, held->train, images, &decoded);
    if (result == BTF_OK) {
        result = compare(context, held->train, enc_data_images(decoded), true, &row->linear, &row->srgb,
                         &row->ssim);
    }
    if (result == BTF_OK) {
        result = bench_between_images(context, between, decoded, ENC_INTERPOLATE_LINEAR, row->between);
    }
    for (int i = 0; i < BENCH_HELD_SETS && held->sets[i] && tables && result == BTF_OK; i++) {
        const bench_blend blend = {decoded, held->sets[i], tables, false};
        result = compare(context, held->sets[i], bench_blended_images(&blend), false, &row->held[i][0],
                         &row->held[i][1], NULL);
    }
    enc_data_destroy(&decoded);
    return result;
}
