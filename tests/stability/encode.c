/* A whole encode in memory, see encode.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encode.h"

#include "decoder/toolkit/reference_view.h"
#include "encoder/model/pack.h"
#include "encoder/model/decode_samples.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const encode_names[ENCODE_METHODS + 1] = {"paper", "paper, RGB lobes", "joint",
                                                     "paper, fit and shadow alone"};

enc_paper_options encode_paper_options(encode_method method, float brighter) {
    enc_paper_options options = enc_paper_options_default();
    options.fit.rgb = method == ENCODE_PAPER_RGB;
    options.fit.starts = 2;
    options.fit.t_btf *= brighter;
    if (method == ENCODE_PAPER_SHADOW) {
        options.effects = BTF_EFFECT_SHADOW;
    }
    return options;
}

enc_factors_settings encode_joint_settings(const enc_data *data, enc_preset preset) {
    enc_job job = {.joint = enc_joint_options_default()};
    job.joint.preset = preset;
    return enc_settings_of_factors(&job, data->width, data->height, data->n_views, data->n_lights);
}

static btf_result analyse(const enc_context *context, const enc_data *data, encode_method method,
                          enc_preset preset, float brighter, bool fallback, enc_solution *solution) {
    if (method != ENCODE_JOINT) {
        enc_paper_options options = encode_paper_options(method, brighter);
        options.fallback = fallback;
        enc_paper_stats stats;
        return enc_paper(context, data, &options, solution, NULL, &stats);
    }
    const enc_factors_settings settings = encode_joint_settings(data, preset);
    enc_factors_stats stats;
    return enc_factors_solve(context, data, &settings, solution, &stats);
}

/* Fills e->decoded by the reference decoder. */
static void decode(const enc_data *data, const btf_material *material, encoded *e) {
    btf_ref_material reference;
    const btf_ref_options options = {UINT32_MAX, UINT32_MAX, BTF_REF_NEAREST, BTF_REF_TEXEL};
    const size_t lights = (size_t)data->n_lights;
    reference_view(material, 0, &reference);
    for (size_t t = 0; t < enc_data_texel_count(data); t++) {
        const uint32_t column = (uint32_t)(t % (size_t)data->width),
                       row = (uint32_t)(t / (size_t)data->width);
        for (size_t v = 0; v < (size_t)data->n_views; v++) {
            for (size_t l = 0; l < lights; l++) {
                float rgb[3];
                btf_ref_evaluate_texel(&reference, &options, column, row, data->lights[l].xyz,
                                       data->views[v].xyz, rgb);
                for (size_t c = 0; c < 3; c++) {
                    e->decoded[((t * (size_t)data->n_views + v) * 3 + c) * lights + l] = rgb[c];
                    e->finite = e->finite && isfinite(rgb[c]) && rgb[c] >= 0;
                }
            }
        }
    }
}

/* Compares with what enc_sample_decoder gives, and sets e->played. */
static btf_result play(const enc_context *context, const enc_data *data, const enc_solution *solution,
                       encoded *e) {
    enc_sample_decoder *decoder = NULL;
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights;
    float *images = malloc(lights * texels * 3 * sizeof *images);
    btf_result result =
        images == NULL ? BTF_ERROR_MEMORY : enc_sample_decoder_create(context, data, solution, &decoder);
    const enc_decoded_samples played = {.decoder = decoder, .effects = BTF_EFFECT_ALL};
    const enc_image_source source = enc_decoded_images(&played);
    float most = 0;
    for (size_t i = 0; i < texels * enc_data_texel_stride(data); i++) {
        most = fmaxf(most, e->decoded[i]);
    }
    const double least = fmax(1e-3, 1e-5 * (double)most); /* the least value to which differences are relative */
    for (size_t v = 0; result == BTF_OK && v < (size_t)data->n_views; v++) {
        result = source.view(source.user, (int)v, images);
        for (size_t i = 0; result == BTF_OK && i < lights * texels * 3; i++) {
            const size_t l = i / (3 * texels), t = i / 3 % texels, c = i % 3;
            const double a = (double)images[i];
            const double b = (double)e->decoded[((t * (size_t)data->n_views + v) * 3 + c) * lights + l];
            const double difference = fabs(a - b) / fmax(b, least);
            e->played = difference > e->played || isnan(difference) ? difference : e->played;
        }
    }
    enc_sample_decoder_destroy(&decoder);
    free(images);
    return result;
}

encoded encode(const enc_data *data, encode_method method, int threads, float brighter) {
    const enc_context context = {.threads = threads};
    encoded e = {.finite = true};
    enc_solution solution = {0};
    btf_material *material = NULL;
    const enc_pack_options pack = {.layout = BTF_LAYOUT_TIGHT, .method = "test"};
    e.decoded = malloc(enc_data_texel_count(data) * enc_data_texel_stride(data) * sizeof *e.decoded);
    e.result = e.decoded == NULL
                   ? BTF_ERROR_MEMORY
                   : analyse(&context, data, method, ENC_PRESET_FAST, brighter, true, &solution);
    if (e.result == BTF_OK) {
        e.result = enc_pack(&context, data, &solution, &pack, &material);
    }
    if (e.result == BTF_OK) {
        e.result = btf_material_save_memory(material, NULL, &e.file, &e.size);
    }
    btf_material_close(&material);
    if (e.result == BTF_OK) {
        e.result = btf_material_open_memory(e.file, e.size, NULL, &material);
    }
    if (e.result == BTF_OK) {
        decode(data, material, &e);
        e.result = play(&context, data, &solution, &e);
    }
    btf_material_close(&material);
    enc_solution_clear(&solution);
    return e;
}

void encode_clear(encoded *e) {
    btf_free(e->file);
    free(e->decoded);
    *e = (encoded){0};
}

double encode_played_psnr(const enc_data *data, const enc_data *truth, encode_method method, float brighter,
                          float peak) {
    const enc_context context = {.threads = 1};
    const size_t texels = enc_data_texel_count(data), stride = enc_data_texel_stride(data);
    enc_solution solution = {0};
    const btf_result result =
        analyse(&context, data, method, ENC_PRESET_MEDIUM, brighter, false, &solution);
    enc_sample_decoder *decoder = NULL;
    float *decoded = malloc(texels * stride * sizeof *decoded);
    float *images = malloc((size_t)data->n_lights * texels * 3 * sizeof *images);
    if (result != BTF_OK || decoded == NULL || images == NULL ||
        enc_sample_decoder_create(&context, data, &solution, &decoder) != BTF_OK) {
        fprintf(stderr, "encode: %s failed\n", encode_names[method]);
        exit(1);
    }
    const enc_decoded_samples played = {.decoder = decoder, .effects = BTF_EFFECT_ALL};
    const enc_image_source source = enc_decoded_images(&played);
    for (size_t v = 0; v < (size_t)data->n_views; v++) {
        if (source.view(source.user, (int)v, images) != BTF_OK) {
            exit(1);
        }
        for (size_t i = 0; i < (size_t)data->n_lights * texels * 3; i++) {
            const size_t l = i / (3 * texels), t = i / 3 % texels, c = i % 3;
            decoded[t * stride + (v * 3 + c) * (size_t)data->n_lights + l] = images[i];
        }
    }
    const double psnr = encode_psnr(truth, decoded, peak);
    enc_sample_decoder_destroy(&decoder);
    enc_solution_clear(&solution);
    free(images);
    free(decoded);
    return psnr;
}

static double clipped(float x, float peak) {
    return (double)(x > 0 ? x < peak ? x : peak : 0);
}

double encode_psnr(const enc_data *data, const float *decoded, float peak) {
    const size_t n = enc_data_texel_count(data) * enc_data_texel_stride(data);
    double squares = 0;
    for (size_t i = 0; i < n; i++) {
        const double r = clipped(decoded[i], peak) - clipped(data->samples[i], peak);
        squares += r * r;
    }
    return hard_psnr(squares, (double)n, (double)peak);
}

double encode_psnr_of_diffuse(const enc_data *data, encode_method method, float peak) {
    const bool root = method == ENCODE_JOINT;
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights;
    double squares = 0;
    for (size_t t = 0; t < texels; t++) {
        for (int c = 0; c < 3; c++) {
            double aa = 0, ab = 0;
            for (size_t i = 0; i < (size_t)data->n_views * lights; i++) {
                const double sample =
                    (double)*hard_sample(data, t, (int)(i / lights), c, (int)(i % lights));
                const double b = root ? fmin(sample, 0x1p24) : sample;
                const double cosine = fmax((double)data->lights[i % lights].xyz[2], 0);
                aa += cosine * (root ? 1 : cosine);
                ab += root ? sqrt(b * cosine) : b * cosine;
            }
            const double factor = root ? 0x1p-12 : 1; /* the least scale of radiance is 2^-24 */
            const double fitted = ab / aa < 0x1p-24 * factor ? 0 : fmin(ab / aa, 0x1p24);
            const double albedo = root ? fitted * fitted : fitted;
            for (size_t i = 0; i < (size_t)data->n_views * lights; i++) {
                const float b = *hard_sample(data, t, (int)(i / lights), c, (int)(i % lights));
                const float cosine = fmaxf(data->lights[i % lights].xyz[2], 0);
                const double r = clipped((float)albedo * cosine, peak) - clipped(b, peak);
                squares += r * r;
            }
        }
    }
    return hard_psnr(squares, (double)(texels * enc_data_texel_stride(data)), (double)peak);
}

bool encode_keeps_promise(encode_method method, double psnr, double psnr_of_diffuse) {
    return method == ENCODE_JOINT
               ? psnr >= fmin(psnr_of_diffuse, 47) - 0.1
               : psnr >= fmin(psnr_of_diffuse, 80) - 0.01;
}

const char encode_promise[] =
    "no worse than the diffuse fit (paper: or 80 dB, less 0.01; joint: or 47 dB, less 0.1)";

double encode_psnr_of_mean(const enc_data *data, float peak) {
    const size_t texels = enc_data_texel_count(data), stride = enc_data_texel_stride(data);
    double squares = 0;
    for (size_t i = 0; i < stride; i++) {
        double mean = 0;
        for (size_t t = 0; t < texels; t++) {
            mean += sqrt(clipped(data->samples[t * stride + i], peak)) / (double)texels;
        }
        for (size_t t = 0; t < texels; t++) {
            const double r = mean * mean - clipped(data->samples[t * stride + i], peak);
            squares += r * r;
        }
    }
    return hard_psnr(squares, (double)(texels * stride), (double)peak);
}
