/* Images of the truth between the samples. See truth.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "truth.h"

#include "encoder/base/stage.h"
#include "tests/sample/pairs.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static btf_result truth_init(const enc_context *context, size_t count, int width, int height,
                             bench_truth *truth) {
    *truth = (bench_truth){.count = count,
                           .width = width,
                           .height = height,
                           .pair = calloc(count, sizeof *truth->pair),
                           .images = malloc(3 * sizeof(float) * count * (size_t)width * (size_t)height)};
    if (truth->pair && truth->images) {
        return BTF_OK;
    }
    bench_truth_clear(truth);
    return enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory for %zu images between the samples",
                    count);
}

void bench_truth_clear(bench_truth *truth) {
    free(truth->pair);
    free(truth->images);
    *truth = (bench_truth){0};
}

static btf_result raycast_all(const enc_context *context, const sample_scene *scene, bench_truth *truth) {
    const size_t image = 3 * (size_t)truth->width * (size_t)truth->height;
    btf_result result = BTF_OK;
    enc_stage_begin(context, "truth between the samples", truth->count);
#pragma omp parallel for schedule(dynamic) num_threads(context->threads)
    for (size_t p = 0; p < truth->count; p++) {
        const btf_result mine = enc_cancelled(context)
                                    ? BTF_ERROR_INTERRUPTED
                                    : sample_scene_pair(scene, &truth->pair[p].view, &truth->pair[p].light,
                                                        truth->images + p * image);
        enc_keep_worse(&result, mine);
        enc_stage_step(context, 1);
    }
    enc_stage_end(context);
    return result;
}

btf_result bench_truth_raycast(const sample_options *options, bench_truth *out_truth) {
    const enc_context *context = options->context;
    sample_scene *scene = NULL;
    sample_pair *pairs = NULL;
    *out_truth = (bench_truth){0};
    btf_result result = sample_scene_create(options, &scene);
    if (result == BTF_OK) {
        const sample_options *full = sample_scene_options(scene);
        result = truth_init(context, BENCH_RAYCAST_PAIRS, full->width, full->height, out_truth);
    }
    if (result == BTF_OK) {
        result = pairs_random(context, BENCH_RAYCAST_PAIRS, 0, &pairs);
    }
    for (size_t p = 0; p < out_truth->count && result == BTF_OK; p++) {
        out_truth->pair[p] = (enc_pair){.view = pairs[p].view, .light = pairs[p].light};
    }
    if (result == BTF_OK) {
        result = raycast_all(context, scene, out_truth);
    }
    snprintf(out_truth->source, sizeof out_truth->source, "%d random pairs of view and light, ray-cast",
             BENCH_RAYCAST_PAIRS);
    free(pairs);
    sample_scene_destroy(&scene);
    if (result != BTF_OK) {
        bench_truth_clear(out_truth);
    }
    return result;
}

static btf_result read_all(const enc_context *context, const enc_pairs *pairs, bench_truth *truth) {
    const size_t row = 3 * (size_t)truth->width, rows = (size_t)truth->height;
    float *image = malloc(3 * sizeof *image * (size_t)pairs->width * (size_t)pairs->height);
    btf_result result = image ? BTF_OK : enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory");
    for (size_t p = 0; p < truth->count && result == BTF_OK; p++) {
        result = enc_cancelled(context) ? BTF_ERROR_INTERRUPTED : enc_pairs_read(context, pairs, p, image);
        for (size_t y = 0; y < rows && result == BTF_OK; y++) {
            memcpy(truth->images + (p * rows + y) * row, image + y * 3 * (size_t)pairs->width,
                   row * sizeof *image);
        }
        truth->pair[p] = (enc_pair){.view = pairs->pair[p].view, .light = pairs->pair[p].light};
    }
    free(image);
    return result;
}

btf_result bench_truth_read(const enc_context *context, const char *path, const enc_read_options *options,
                            int side, bench_truth *out_truth) {
    enc_pairs *pairs = NULL;
    *out_truth = (bench_truth){0};
    btf_result result = enc_pairs_open(context, path, options, &pairs);
    if (result == BTF_OK) {
        const int width = side > 0 && side < pairs->width ? side : pairs->width,
                  height = side > 0 && side < pairs->height ? side : pairs->height;
        result = truth_init(context, pairs->count, width, height, out_truth);
    }
    if (result == BTF_OK) {
        result = read_all(context, pairs, out_truth);
        const char *slash = strrchr(path, '/');
        snprintf(out_truth->source, sizeof out_truth->source, "%zu images of %.100s", out_truth->count,
                 slash && slash[1] ? slash + 1 : path);
    }
    enc_pairs_close(&pairs);
    if (result != BTF_OK) {
        bench_truth_clear(out_truth);
    }
    return result;
}
