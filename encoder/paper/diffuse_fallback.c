/* The diffuse fit in place of a worse model (see diffuse_fallback.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "diffuse_fallback.h"

#include "choose_effects.h"
#include "decoder/toolkit/progress.h"
#include "encoder/base/ranks.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

/* Errors that differ by less than `tie` of one, and `nothing` of the mean square of the samples, are equal
 * but for rounding. */
static const double tie = 1e-6, nothing = 1e-9;

static const double stray = 1e-3; /* share of the samples that may exceed the peak */
enum { OCTAVES = 24 };            /* peaks 1, 2, 4, .. 2^24 */

/* Sums over the samples. */
enum { FOUND, DIFFUSE, ENERGY, SUMS };

/* Brings a positive number into the range that a file may hold. */
static float storable(double value) {
    return value >= 0x1p-24 ? (float)fmin(value, 0x1p24) : 0.0f;
}

/* Finds the best model without lobes: the first numbers of a texel in the layout of sbrdf.h, four with one
 * colour and three with RGB lobes. */
static void fit_diffuse(const enc_data *data, bool rgb, const float *samples, float out[4]) {
    const size_t lights = (size_t)data->n_lights;
    double aa = 0.0, at[3] = {0};
    for (size_t view = 0; view < (size_t)data->n_views; view++) {
        const float *profile = samples + view * 3 * lights;
        for (size_t l = 0; l < lights; l++) {
            const double cosine = fmax((double)enc_data_light(data, view, l)->xyz[2], 0.0);
            aa += cosine * cosine;
            for (size_t c = 0; c < 3; c++) {
                at[c] += cosine * fmax((double)profile[c * lights + l], 0.0);
            }
        }
    }
    const double largest = fmax(at[0], fmax(at[1], at[2]));
    const bool lit = aa > 0.0 && largest > 0.0;
    for (size_t c = 0; c < 3; c++) {
        out[c] = !lit ? 0.0f : storable(at[c] / (rgb ? aa : largest));
    }
    out[3] = !lit ? 0.0f : storable(largest / aa);
}

typedef struct comparison {
    const enc_data *data;
    const enc_solution *solution;
    const enc_occlusion *occlusion;
    double peak;
} comparison;

/* Counts the samples above each peak. */
static void count_texel(const void *user, size_t texel, const float *samples, float *scratch, double *out) {
    const comparison *c = user;
    (void)texel, (void)scratch;
    for (size_t i = 0; i < enc_data_texel_stride(c->data); i++) {
        for (int k = 0; k < OCTAVES && samples[i] > ldexpf(1.0f, k); k++) {
            out[k] += 1.0;
        }
    }
}

static btf_result find_peak(const enc_context *context, comparison *c) {
    double share[OCTAVES];
    const btf_result result = enc_paper_sample(context, c->data, count_texel, c, OCTAVES, share);
    int k = 0;
    while (k < OCTAVES && share[k] > stray) {
        k++;
    }
    c->peak = ldexp(1.0, k);
    return result;
}

static void compare_texel(const void *user, size_t texel, const float *samples, float *scratch,
                          double *out) {
    const comparison *c = user;
    const size_t lights = (size_t)c->data->n_lights;
    const bool rgb = c->solution->sbrdf->rgb;
    float diffuse[4];
    fit_diffuse(c->data, rgb, samples, diffuse);
    out[FOUND] = enc_paper_texel_error(c->data, c->solution, c->occlusion, c->solution->effects, c->peak,
                                       texel, samples, scratch);
    for (size_t i = 0; i < enc_data_texel_stride(c->data); i++) {
        const size_t channel = i / lights % 3;
        const double albedo = (double)diffuse[channel] * (rgb ? 1.0 : (double)diffuse[3]);
        const double value = albedo * (double)c->data->lights[i % lights].xyz[2];
        const double truth = fmin((double)samples[i], c->peak), error = fmin(value, c->peak) - truth;
        out[DIFFUSE] += error * error;
        out[ENERGY] += truth * truth;
    }
}

/* Makes the diffuse fit of every texel. */
static btf_result fit_all(const enc_context *context, const enc_data *data, enc_sbrdf *sbrdf) {
    const size_t stride = enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb);
    size_t begin, end;
    btf_result result = BTF_OK;
    enc_ranks_range(context, sbrdf->n_texels, &begin, &end);
#pragma omp parallel num_threads(context->threads)
    {
        float *buffer = data->samples ? NULL : malloc(enc_data_texel_stride(data) * sizeof *buffer);
        btf_result mine = buffer || data->samples ? BTF_OK : BTF_ERROR_MEMORY;
        if (mine != BTF_OK) {
            enc_fail(context, mine, "diffuse fit: out of memory");
        }
#pragma omp for schedule(dynamic, 16)
        for (size_t texel = begin; texel < end; texel++) {
            const float *samples;
            float diffuse[4];
            if (mine == BTF_OK) {
                mine = enc_cancelled(context) ? BTF_ERROR_INTERRUPTED
                                              : enc_data_texels(context, data, texel, 1, buffer, &samples);
            }
            if (mine == BTF_OK) {
                fit_diffuse(data, sbrdf->rgb, samples, diffuse);
                memset(sbrdf->values + texel * stride, 0, stride * sizeof *sbrdf->values);
                memcpy(sbrdf->values + texel * stride, diffuse, (sbrdf->rgb ? 3 : 4) * sizeof *diffuse);
            }
        }
        free(buffer);
        enc_keep_worse(&result, mine);
    }
    return enc_ranks_gather(context, result, sbrdf->values, stride * sizeof *sbrdf->values,
                            sbrdf->n_texels);
}

/* Makes the maps change nothing: white shadows, no shift, no point hidden. */
static void blank(enc_solution *s, enc_occlusion *occlusion) {
    if (s->shadow) {
        memset(s->shadow, 255, (size_t)s->n_lights * enc_solution_texels(s));
    }
    if (occlusion) {
        const size_t points = (size_t)occlusion->n_views * occlusion->n_texels;
        memset(occlusion->shift, 0, 2 * points * sizeof *occlusion->shift);
        memset(occlusion->hidden, 0, points * sizeof *occlusion->hidden);
        memset(occlusion->centre, 0, points * sizeof *occlusion->centre);
    }
}

btf_result enc_paper_fallback(const enc_context *context, const enc_data *data,
                              const enc_paper_options *options, enc_solution *solution,
                              enc_occlusion *occlusion, enc_paper_stats *stats) {
    comparison c = {data, solution, occlusion, 1.0};
    const double start = progress_core_clock();
    double sums[SUMS];
    btf_result result = find_peak(context, &c);
    if (result == BTF_OK) {
        result = enc_paper_sample(context, data, compare_texel, &c, SUMS, sums);
    }
    if (result != BTF_OK || !(sums[FOUND] > sums[DIFFUSE] * (1.0 + tie) + sums[ENERGY] * nothing)) {
        return result;
    }
    result = fit_all(context, data, solution->sbrdf);
    if (result != BTF_OK) {
        return result;
    }
    enc_log(context, BTF_LOG_WARNING,
            "paper: the model found has %.4g times the squared error of the diffuse fit alone, so the "
            "diffuse fit is taken",
            sums[FOUND] / fmax(sums[DIFFUSE], 1e-30));
    blank(solution, occlusion);
    if (options->choose) {
        solution->effects = 0;
    }
    stats->diffuse = true;
    double error;
    result = enc_paper_error(context, data, solution, occlusion, solution->effects, &error);
    if (result == BTF_OK) {
        enc_paper_note(context, data, solution, solution->effects, error, start, "diffuse fit: taken",
                       stats);
    }
    return result;
}
