/* Measuring and leaving out effects (see choose_effects.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "choose_effects.h"

#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/progress.h"
#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>

/* Where fewer of the points than this share are hidden, clusters are not tried; chosen by hand, not
 * fitted. */
static const double hidden_share = 0.01;

static double clipped(double value, double peak) {
    return value < peak ? value : peak;
}

double enc_paper_texel_error(const enc_data *data, const enc_solution *s, const enc_occlusion *occlusion,
                             uint32_t effects, double peak, size_t texel, const float *samples,
                             float *model) {
    const size_t texels = enc_data_texel_count(data), n = (size_t)data->n_lights;
    float x[ENC_MAX_DIRECTIONS], y[ENC_MAX_DIRECTIONS], z[ENC_MAX_DIRECTIONS];
    double sum = 0.0;
    for (size_t l = 0; l < n; l++) {
        x[l] = data->lights[l].xyz[0];
        y[l] = data->lights[l].xyz[1];
        z[l] = data->lights[l].xyz[2];
    }
    for (size_t view = 0; view < (size_t)data->n_views; view++) {
        const size_t point = view * texels + texel;
        const float *truth = samples + view * 3 * n;
        const bool hidden = (effects & BTF_EFFECT_HIDDEN) && occlusion->hidden[point];
        const bool moved = (effects & BTF_EFFECT_SHIFT) && !hidden;
        const size_t source =
            moved ? enc_occlusion_source(data->width, data->height, texel, occlusion->shift[2 * point],
                                         occlusion->shift[2 * point + 1])
                  : texel;
        if (!hidden) {
            enc_sbrdf_evaluate(s->sbrdf, source, data->views[view].xyz, (int)n, x, y, z, model);
        }
        for (size_t p = 0; p < 3 * n; p++) {
            const size_t l = p % n;
            double value;
            if (hidden) {
                const uint8_t *centre = s->centre_codes + 3 * ((size_t)occlusion->centre[point] * n + l);
                const double root = centre[p / n] * (double)s->centre_scale;
                value = root * root;
            } else {
                value = (double)model[p] * z[l];
                if (effects & BTF_EFFECT_SHADOW) {
                    value *= s->shadow[l * texels + source] * (double)s->shadow_scale;
                }
            }
            const double difference = clipped(value, peak) - clipped((double)truth[p], peak);
            sum += difference * difference;
        }
    }
    return sum;
}

btf_result enc_paper_sample(const enc_context *context, const enc_data *data, enc_paper_texel_fn fn,
                            const void *user, size_t numbers, double *out) {
    const size_t texels = enc_data_texel_count(data), stride = enc_data_texel_stride(data);
    const size_t count = texels < ENC_PAPER_SAMPLE ? texels : ENC_PAPER_SAMPLE;
    size_t begin, end;
    enc_ranks_range(context, count, &begin, &end);
    double *found = calloc(count * numbers, sizeof *found);
    btf_result result = found ? BTF_OK : enc_fail(context, BTF_ERROR_MEMORY, "effects: out of memory");
#pragma omp parallel num_threads(context->threads)
    {
        float *buffer = malloc((stride + 3 * (size_t)data->n_lights) * sizeof *buffer);
        btf_result mine = result;
        if (mine == BTF_OK && !buffer) {
            mine = enc_fail(context, BTF_ERROR_MEMORY, "effects: out of memory");
        }
#pragma omp for schedule(dynamic)
        for (size_t i = begin; i < end; i++) {
            const float *samples;
            const size_t texel = i * texels / count;
            if (mine == BTF_OK) {
                mine = enc_data_texels(context, data, texel, 1, buffer, &samples);
            }
            if (mine == BTF_OK) {
                fn(user, texel, samples, buffer + stride, found + i * numbers);
            }
        }
        free(buffer);
        enc_keep_worse(&result, mine);
    }
    result = enc_ranks_gather(context, result, found, numbers * sizeof *found, count);
    for (size_t k = 0; k < numbers; k++) {
        out[k] = 0.0;
        for (size_t i = 0; i < count && result == BTF_OK; i++) {
            out[k] += found[i * numbers + k] / ((double)count * (double)stride);
        }
    }
    free(found);
    return result;
}

typedef struct measured {
    const enc_data *data;
    const enc_solution *solution;
    const enc_occlusion *occlusion;
    uint32_t effects;
} measured;

static void measure_texel(const void *user, size_t texel, const float *samples, float *scratch,
                          double *out) {
    const measured *m = user;
    *out =
        enc_paper_texel_error(m->data, m->solution, m->occlusion, m->effects, 1.0, texel, samples, scratch);
}

btf_result enc_paper_error(const enc_context *context, const enc_data *data, const enc_solution *solution,
                           const enc_occlusion *occlusion, uint32_t effects, double *out_error) {
    const measured m = {data, solution, occlusion, effects};
    return enc_paper_sample(context, data, measure_texel, &m, 1, out_error);
}

/* Bytes that the maps of these effects take in layout `tight`, even for layout `paper`, since rounding up
 * to an atlas would hide what an effect costs. */
static uint64_t map_bytes(const enc_data *data, const enc_solution *s, uint32_t effects) {
    const uint64_t texels = enc_data_texel_count(data), views = (uint64_t)data->n_views;
    const uint64_t lights = (uint64_t)data->n_lights;
    return (effects & BTF_EFFECT_SHADOW ? texels * lights : 0) +
           (effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN) ? 2 * texels * views : 0) +
           (effects & BTF_EFFECT_HIDDEN ? texels * views + 4 * (uint64_t)s->n_centres * lights : 0);
}

void enc_paper_note(const enc_context *context, const enc_data *data, const enc_solution *s,
                    uint32_t effects, double error, double since, const char *verdict,
                    enc_paper_stats *stats) {
    char text[64];
    const enc_trial trial = {.effects = effects,
                             .lobes = s->sbrdf->lobes,
                             .rgb = s->sbrdf->rgb,
                             .centres = effects & BTF_EFFECT_HIDDEN ? (int)s->n_centres : 0,
                             .gpu_bytes = map_bytes(data, s, effects),
                             .psnr = error > 1e-10 ? -10.0 * log10(error) : 100.0,
                             .core_seconds = progress_core_clock() - since,
                             .verdict = verdict};
    if (stats->trials_count < ENC_MAX_TRIALS) {
        stats->trials[stats->trials_count++] = trial;
    }
    enc_log(context, BTF_LOG_INFO, "paper: effects %s on %d texels: %.2f dB, %s",
            cli_effects_text(effects, text), ENC_PAPER_SAMPLE, trial.psnr, verdict);
}

/* dB by which the error `without` an effect exceeds that `with` it, less the dB that its bytes have to
 * gain. */
static double worth(const enc_paper_options *options, double with, double without, uint64_t bytes) {
    const double floor = 1e-10; /* 100 dB */
    return 10.0 * log10(fmax(without, floor) / fmax(with, floor)) -
           options->effect_tolerance_bytes * (double)bytes * 1e-6;
}

btf_result enc_paper_probe(const enc_context *context, const enc_data *data,
                           const enc_paper_options *options, const enc_solution *solution,
                           enc_paper_stats *stats, bool *out_promising) {
    const double start = progress_core_clock();
    enc_context quiet = *context; /* the stage "flow" belongs to the flow of all lights */
    const uint32_t without = solution->effects & BTF_EFFECT_SHADOW, with = without | BTF_EFFECT_SHIFT;
    enc_flow_options flow = options->flow;
    enc_occlusion *occlusion = NULL;
    double still, moved = 0.0;
    quiet.progress = NULL;
    enc_stage_begin(context, "probe", 1);
    flow.lights = ENC_PAPER_PROBE_LIGHTS < data->n_lights ? ENC_PAPER_PROBE_LIGHTS : data->n_lights;
    btf_result result = enc_paper_error(context, data, solution, NULL, without, &still);
    if (result == BTF_OK) {
        result = enc_flow_vote(&quiet, data, &flow, &occlusion);
    }
    if (result == BTF_OK) {
        result = enc_paper_error(context, data, solution, occlusion, with, &moved);
    }
    if (result == BTF_OK) {
        const double points = (double)enc_data_texel_count(data) * data->n_views;
        const double share = (double)enc_occlusion_hidden_count(occlusion, -1) / points;
        *out_promising = worth(options, moved, still, map_bytes(data, solution, with & ~without)) >=
                             options->effect_tolerance ||
                         share >= hidden_share;
        enc_paper_note(context, data, solution, without, still, start, *out_promising ? "probe" : "enough",
                       stats);
        enc_paper_note(context, data, solution, with, moved, start,
                       *out_promising ? "probe: worth trying" : "probe: left out", stats);
    }
    enc_occlusion_destroy(&occlusion);
    enc_stage_end(context);
    return result;
}

btf_result enc_paper_choose(const enc_context *context, const enc_data *data,
                            const enc_paper_options *options, enc_solution *solution,
                            const enc_occlusion *occlusion, enc_paper_stats *stats) {
    static const uint32_t single[] = {BTF_EFFECT_SHADOW, BTF_EFFECT_SHIFT, BTF_EFFECT_HIDDEN};
    double start = progress_core_clock(), present;
    btf_result result = enc_paper_error(context, data, solution, occlusion, solution->effects, &present);
    if (result == BTF_OK) {
        enc_paper_note(context, data, solution, solution->effects, present, start, "all effects found",
                       stats);
    }
    for (bool again = true; again && result == BTF_OK;) {
        double least = HUGE_VAL, error_without = 0.0;
        uint32_t candidate = 0;
        again = false;
        for (int i = 0; i < 3 && result == BTF_OK; i++) {
            const uint32_t without = solution->effects & ~single[i];
            double error;
            if (without == solution->effects) {
                continue;
            }
            start = progress_core_clock();
            result = enc_paper_error(context, data, solution, occlusion, without, &error);
            if (result != BTF_OK) {
                break;
            }
            const uint64_t bytes =
                map_bytes(data, solution, solution->effects) - map_bytes(data, solution, without);
            const double loss = worth(options, present, error, bytes);
            enc_paper_note(context, data, solution, without, error, start, "tried", stats);
            if (loss < least) {
                least = loss;
                candidate = without;
                error_without = error;
            }
        }
        if (result == BTF_OK && least < options->effect_tolerance) {
            solution->effects = candidate;
            present = error_without;
            enc_paper_note(context, data, solution, candidate, present, progress_core_clock(),
                           "best so far", stats);
            again = true;
        }
    }
    return result;
}
