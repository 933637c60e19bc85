/* A reflectance model alone. See reflectance.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reflectance.h"

#include "decoder/toolkit/progress.h"
#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/factor/stop.h"
#include "encoder/model/decode_samples.h"
#include "encoder/model/pack.h"
#include "encoder/model/unpack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A survey goes on where it leaves at most this share of the energy of its samples. It leaves 3e-7 of btf-sample flat, 1.6e-4
 * of it with noise of 0.003, 0.11 of bricks and axes, 0.20 of bumps, 0.22 of weave (32x32 texels), 0.26 of BRICKS64, 0.14 of
 * UBO_IMPALLA64. */
static const double may_stand = 1e-3;

/* Errors are measured up to 1. Samples this far above it are no noise on white: a measure that does not see them cannot judge
 * the model. */
static const float most_measured = 1.05f;

static const double best_psnr = 100;

enc_paper_options enc_reflectance_options(void) {
    enc_paper_options options = enc_paper_options_default();
    options.fit.lobes = 1;
    options.fit.rounds = 0; /* nothing lies in shadow */
    options.effects = 0;
    options.choose = options.fallback = false;
    return options;
}

bool enc_reflectance_pays(const enc_reflectance_weights *w, const enc_error_sum *model, const enc_error_sum *factors) {
    const double linear = fmin(enc_psnr_linear(factors), best_psnr) - fmin(enc_psnr_linear(model), best_psnr);
    const double srgb = fmin(enc_psnr_srgb(factors), best_psnr) - fmin(enc_psnr_srgb(model), best_psnr);
    if (w->model_bytes > w->factor_bytes) {
        return false;
    }
    if (w->quality > 0 && enc_psnr_srgb(model) >= w->quality) {
        return true;
    }
    if (w->quality > 0 && enc_psnr_srgb(factors) >= w->quality) {
        return false;
    }
    const double tenths = log((double)w->factor_bytes / (double)w->model_bytes) / log(ENC_STOP_MORE);
    return (linear + srgb) / 2 <= (w->quality > 0 ? 0 : w->tolerance * tenths);
}

/* Fits the model to all texels of the data. */
static btf_result fit(const enc_context *context, const enc_data *data, enc_solution *out) {
    const enc_paper_options options = enc_reflectance_options();
    enc_paper_stats *stats = malloc(sizeof *stats);
    btf_result result = stats ? enc_paper(context, data, &options, out, NULL, stats)
                              : enc_fail(context, BTF_ERROR_MEMORY, "reflectance: out of memory");
    out->half_parameters = result == BTF_OK;
    free(stats);
    return result;
}

/* The error of a solution at all samples of the data. */
static btf_result measure(const enc_context *context, const enc_data *data, const enc_solution *solution,
                          enc_error_sum *out) {
    enc_sample_decoder *decoder = NULL;
    enc_metrics *metrics = malloc(sizeof *metrics);
    btf_result result = metrics ? enc_sample_decoder_create(context, data, solution, &decoder)
                                : enc_fail(context, BTF_ERROR_MEMORY, "reflectance: out of memory");
    const enc_decoded_samples decoded = {.decoder = decoder, .effects = solution->effects};
    if (result == BTF_OK) {
        result = enc_metrics_compare(context, data, enc_data_images(data), enc_decoded_images(&decoded), false, metrics);
    }
    if (result == BTF_OK) {
        *out = metrics->total;
    }
    enc_sample_decoder_destroy(&decoder);
    free(metrics);
    return result;
}

/* The error of a model as a file holds it. */
static btf_result measure_stored(const enc_context *context, const enc_data *data, const enc_solution *model,
                                 enc_error_sum *out) {
    const enc_pack_options options = {.layout = BTF_LAYOUT_TIGHT, .method = "joint"};
    enc_solution stored = {0};
    btf_material *material = NULL;
    btf_result result = enc_pack(context, data, model, &options, &material);
    if (result == BTF_OK) {
        result = enc_unpack(context, material, &stored);
    }
    if (result == BTF_OK) {
        result = measure(context, data, &stored, out);
    }
    enc_solution_clear(&stored);
    btf_material_close(&material);
    return result;
}

/* Makes data of a few texels. Sets *out_energy to the sum of squares of their samples, and *out_bright to whether one of
 * these is well above 1, where no error is measured. */
static btf_result draw(const enc_context *alone, const enc_data *data, enc_data **out, double *out_energy,
                       bool *out_bright) {
    const size_t all = enc_data_texel_count(data), stride = enc_data_texel_stride(data);
    const size_t count = all < ENC_REFLECTANCE_TEXELS ? all : ENC_REFLECTANCE_TEXELS;
    btf_result result = enc_data_create(alone, (int)count, 1, data->n_views, data->views, data->n_lights, data->lights, out);
    if (result == BTF_OK && enc_data_copy_lights(data, *out) != BTF_OK) {
        result = enc_fail(alone, BTF_ERROR_MEMORY, "reflectance: out of memory");
    }
    *out_energy = 0;
    *out_bright = false;
    for (size_t i = 0; result == BTF_OK && i < count; i++) {
        const size_t run = all / count; /* at another place of each run, so that rows and columns both vary */
        float *to = (*out)->samples + i * stride;
        const float *samples;
        result = enc_data_texels(alone, data, i * all / count + i * 7 % run, 1, to, &samples);
        if (result == BTF_OK && samples != to) {
            memcpy(to, samples, stride * sizeof *to);
        }
        for (size_t j = 0; result == BTF_OK && j < stride; j++) {
            *out_energy += (double)to[j] * (double)to[j];
            *out_bright = *out_bright || to[j] > most_measured;
        }
    }
    return result;
}

/* Whether a model of a few texels stands for them. Values above 1, in which the measure of error sees no difference, speak
 * against it: most of a bright relief is above 1. Every rank finds out by itself. */
static btf_result survey(const enc_context *context, const enc_data *data, bool *out_stands) {
    enc_context alone = *context;
    enc_data *drawn = NULL;
    enc_solution model = {0};
    enc_error_sum error = {0};
    double energy = 0;
    bool bright = false;
    alone.ranks = NULL;
    alone.memory = 0;
    alone.least_memory = NULL;
    btf_result result = draw(&alone, data, &drawn, &energy, &bright);
    if (result == BTF_OK && !bright) {
        result = fit(&alone, drawn, &model);
    }
    if (result == BTF_OK && !bright) {
        result = measure_stored(&alone, drawn, &model, &error);
    }
    *out_stands = result == BTF_OK && !bright && error.linear <= may_stand * energy;
    enc_solution_clear(&model);
    enc_data_destroy(&drawn);
    return enc_ranks_agree(context, result);
}

/* Fits a model to all texels and weighs it; says what was found in *trial. */
static btf_result weigh(const enc_context *context, const enc_job *job, const enc_data *data, const enc_solution *factors,
                        uint64_t factor_bytes, enc_solution *out, enc_trial *trial, bool *out_pays) {
    const enc_reflectance_weights weights = {.model_bytes = ENC_REFLECTANCE_BYTES * enc_data_texel_count(data),
                                             .factor_bytes = factor_bytes,
                                             .tolerance = job->joint.tolerance,
                                             .quality = job->joint.quality};
    enc_error_sum of_model, of_factors;
    btf_result result = fit(context, data, out);
    if (result == BTF_OK) {
        result = measure_stored(context, data, out, &of_model);
    }
    if (result == BTF_OK) {
        result = measure(context, data, factors, &of_factors);
    }
    result = enc_ranks_agree(context, result);
    if (result != BTF_OK) {
        return result;
    }
    *out_pays = enc_reflectance_pays(&weights, &of_model, &of_factors);
    *trial = (enc_trial){.lobes = 1,
                         .gpu_bytes = weights.model_bytes,
                         .psnr = enc_psnr_srgb(&of_model),
                         .verdict = *out_pays ? "best" : "left out"};
    enc_log(context, BTF_LOG_INFO,
            "reflectance: a model alone has %.2f / %.2f dB at the samples in %llu bytes, factors %.2f / %.2f in %llu: %s",
            enc_psnr_linear(&of_model), enc_psnr_srgb(&of_model), (unsigned long long)weights.model_bytes,
            enc_psnr_linear(&of_factors), enc_psnr_srgb(&of_factors), (unsigned long long)factor_bytes,
            *out_pays ? "taken, without factors, fit, relief and gloss" : "left out");
    return BTF_OK;
}

/* The trial of the factors that were kept. */
static enc_trial *kept_trial(enc_factors_stats *stats) {
    int at = 0;
    while (at + 1 < stats->trials_count && strcmp(stats->trials[at].verdict, "best") != 0) {
        at++;
    }
    return &stats->trials[at];
}

btf_result enc_reflectance_try(const enc_context *context, const enc_job *job, const enc_data *data,
                               enc_solution *io_solution, enc_factors_stats *stats, bool *out_taken) {
    const double begin = progress_core_clock();
    enc_trial *kept = kept_trial(stats);
    enc_trial trial = {.lobes = 1, .psnr = NAN, .verdict = "given up after a survey, which left too much error or met values above 1"};
    enc_solution model = {0};
    enc_context quiet = *context; /* without stages and steps of the paper's method */
    bool stands = false;
    quiet.progress = NULL;
    quiet.checkpoint = NULL;
    *out_taken = false;
    if (!job->joint.choose || job->relief.gloss > 0 ||
        ENC_REFLECTANCE_BYTES * enc_data_texel_count(data) > kept->gpu_bytes) {
        return BTF_OK;
    }
    enc_stage_begin(context, "reflectance", 1);
    btf_result result = survey(&quiet, data, &stands);
    if (result == BTF_OK && stands) {
        result = weigh(&quiet, job, data, io_solution, kept->gpu_bytes, &model, &trial, out_taken);
    }
    enc_stage_end(context);
    if (result == BTF_OK) {
        trial.core_seconds = progress_core_clock() - begin;
        stats->trials[stats->trials_count++] = trial;
    }
    if (*out_taken) {
        kept->verdict = "left out";
        enc_solution_clear(io_solution);
        *io_solution = model;
    } else {
        enc_solution_clear(&model);
    }
    return result;
}
