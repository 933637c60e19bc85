/* Surfaces judged by views left out. See judge.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "judge.h"

#include "encoder/base/stage.h"
#include "encoder/data/level_filter.h"
#include "encoder/math/area.h"
#include "encoder/math/srgb.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    MOST_LIGHTS = 12,
    MOST_BYTES = 64 << 20,
    DRAWN_TEXELS = 4096,
};

static int lights_of(int width, int height, int n_views, int n_lights) {
    const uint64_t each = 3 * (uint64_t)width * (uint64_t)height * (uint64_t)n_views;
    const uint64_t room = MOST_BYTES / each, most = room < 2 ? 2 : room < MOST_LIGHTS ? room : MOST_LIGHTS;
    return n_lights < (int)most ? n_lights : (int)most;
}

uint64_t enc_judged_bytes(int width, int height, int n_views) {
    const uint64_t lights = (uint64_t)lights_of(width, height, n_views, MOST_LIGHTS);
    return 3 * lights * (uint64_t)width * (uint64_t)height * (uint64_t)n_views;
}

/* Adds the samples of a texel of the data, weighted, to sums [view][light][3]. */
static void add_texel(const enc_data *data, const float *samples, double weight, const enc_judged *j,
                      double *sums) {
    const size_t all = (size_t)data->n_lights, lights = (size_t)j->lights;
    for (size_t v = 0; v < (size_t)j->n_views; v++) {
        for (size_t i = 0; i < lights; i++) {
            for (size_t c = 0; c < 3; c++) {
                const float x = samples[(v * 3 + c) * all + (2 * i + 1) * all / (2 * lights)];
                sums[(v * lights + i) * 3 + c] += weight * (double)x;
            }
        }
    }
}

/* Stores roots of the means over the texels that a texel of the level covers, summed in the order of rows. */
static btf_result keep_texel(const enc_context *context, const enc_data *data, size_t texel, float *buffer,
                             double *sums, const enc_judged *j) {
    const size_t n = 3 * (size_t)j->lights, texels = (size_t)j->width * (size_t)j->height,
                 views = (size_t)j->n_views;
    const double area = (double)data->width * (double)data->height;
    const int column = (int)(texel % (size_t)j->width), row = (int)(texel / (size_t)j->width);
    int x0, x1, y0, y1;
    enc_area_span(data->width, j->width, column, &x0, &x1);
    enc_area_span(data->height, j->height, row, &y0, &y1);
    memset(sums, 0, views * n * sizeof *sums);
    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) {
            const float *samples;
            const size_t from = (size_t)y * (size_t)data->width + (size_t)x;
            const btf_result result = enc_data_texels(context, data, from, 1, buffer, &samples);
            if (result != BTF_OK) {
                return result;
            }
            add_texel(data, samples,
                      (double)enc_area_overlap(data->width, j->width, column, x) *
                          (double)enc_area_overlap(data->height, j->height, row, y),
                      j, sums);
        }
    }
    for (size_t i = 0; i < views * n; i++) {
        const float mean = (float)(sums[i] / area);
        const float root = sqrtf(mean > 0 ? mean < 1 ? mean : 1.0f : 0.0f);
        j->roots[(i / n * texels + texel) * n + i % n] = (uint8_t)(root * 255 + 0.5f);
    }
    return BTF_OK;
}

btf_result enc_judged_create(const enc_context *context, const enc_data *data, int level, enc_judged *out) {
    const int width = enc_level_side(data->width, level), height = enc_level_side(data->height, level);
    const size_t texels = (size_t)width * (size_t)height;
    btf_result result = BTF_OK;
    *out = (enc_judged){.width = width,
                        .height = height,
                        .n_views = data->n_views,
                        .lights = lights_of(width, height, data->n_views, data->n_lights)};
    const size_t all = 3 * (size_t)data->n_views * (size_t)out->lights;
    out->roots = malloc(all * texels);
    if (!out->roots) {
        return BTF_ERROR_MEMORY;
    }
#pragma omp parallel num_threads(context->threads)
    {
        float *buffer = malloc(enc_data_texel_stride(data) * sizeof *buffer);
        double *sums = malloc(all * sizeof *sums);
#pragma omp for schedule(dynamic, 8)
        for (size_t t = 0; t < texels; t++) {
            const btf_result mine = !buffer || !sums ? BTF_ERROR_MEMORY
                                    : enc_cancelled(context)
                                        ? BTF_ERROR_INTERRUPTED
                                        : keep_texel(context, data, t, buffer, sums, out);
            enc_keep_worse(&result, mine);
            enc_stage_step(context, 1);
        }
        free(buffer);
        free(sums);
    }
    if (result != BTF_OK) {
        enc_judged_clear(out);
    }
    return result;
}

void enc_judged_clear(enc_judged *judged) {
    free(judged->roots);
    *judged = (enc_judged){0};
}

double enc_judged_gain(enc_judged_error a, enc_judged_error b) {
    return 5 * log10(fmax(a.linear, 1e-10) / fmax(b.linear, 1e-10)) +
           5 * log10(fmax(a.srgb, 1e-10) / fmax(b.srgb, 1e-10));
}

/* Adds the squared errors of one texel of a view. */
static void judge_texel(const enc_judged *j, const enc_seen_view *s, const enc_warp *w, size_t texel,
                        enc_judged_error *sum) {
    const size_t n = 3 * (size_t)j->lights, texels = (size_t)j->width * (size_t)j->height;
    float got[3 * MOST_LIGHTS] = {0};
    enc_seen_point point;
    int32_t at[2];
    enc_warp_middle(w, texel, at);
    enc_seen_find(w, s, at, SIZE_MAX, 0, &point);
    for (int a = 0; a < s->count; a++) {
        const size_t there = enc_warp_texel(w, point.at[a][0], point.at[a][1]);
        const float weight = (float)point.weight[a] * (0x1p-12f / 255);
        const uint8_t *from = j->roots + ((size_t)s->near[a] * texels + there) * n;
        for (size_t i = 0; i < n; i++) {
            got[i] += weight * (float)from[i];
        }
    }
    const uint8_t *truth = j->roots + ((size_t)s->view * texels + texel) * n;
    for (size_t i = 0; i < n; i++) {
        const float root = (float)truth[i] / 255, t = root * root, g = got[i] * got[i];
        const double linear = (double)(g - t), srgb = (double)(enc_srgb_encode(g) - enc_srgb_encode(t));
        sum->linear += linear * linear;
        sum->srgb += srgb * srgb;
    }
}

void enc_judge_surface(const enc_context *context, const enc_judged *j, const enc_seen *seen,
                       const enc_warp *w, enc_judged_error *out) {
    const size_t texels = (size_t)j->width * (size_t)j->height,
                 drawn = texels < DRAWN_TEXELS ? texels : DRAWN_TEXELS;
    const double count = (double)drawn * 3 * j->lights;
#pragma omp parallel for schedule(dynamic) num_threads(context->threads)
    for (int i = 0; i < seen->count; i++) {
        enc_judged_error sum = {0, 0};
        for (size_t t = 0; t < drawn; t++) {
            judge_texel(j, &seen->of[i], w, (2 * t + 1) * texels / (2 * drawn), &sum);
        }
        out[i] = (enc_judged_error){sum.linear / count, sum.srgb / count};
    }
}
