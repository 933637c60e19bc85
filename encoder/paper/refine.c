/* Refinement of the hidden map (paper 2.3.2): an exact nearest-source search, pruned.
 *
 * A sum of Euclidean norms is no matrix product, but it has a cheap lower bound: by the triangle inequality
 * the norms of 16 sums over groups of neighbouring lights add up to no more than the distance. One vector
 * operation bounds a candidate; only those that might win are computed in full.
 *
 * SPDX-License-Identifier: MIT
 */
#include "refine.h"

#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/data/profiles.h"
#include "norms.h"

#include <assert.h>
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

enum {
    GROUPS = ENC_NORM_LANES,
    BOUND_FLOATS = 3 * GROUPS,
    WHOLE_WINDOW = 256, /* up to 64x64 texels the default window holds them all */
    WHOLE_TEXELS = 4096,
    BOUNDED_WINDOW = 64, /* of larger textures, around the shift that was voted */
    MOST_SHIFT = 127,
};
/* More than float rounding can move a bound above its distance, relative to the distance and to the sums. */
static const float rounding = 1e-4f, sum_rounding = 1e-5f;

/* Everything that the views share. */
typedef struct refine_stage {
    const enc_context *context;
    const enc_data *data;
    const enc_sbrdf *sbrdf;
    const uint8_t *shadow;
    float shadow_scale;
    enc_occlusion *occlusion;
    size_t n_texels, lanes, stride;
    int columns, rows;                    /* window */
    int first_column, first_row;          /* its least shift; with `around` relative to the point's own */
    bool around;                          /* the window lies around the point's own shift */
    float *light;                         /* [4][n_lights]: x, y, z, max(z, 0) */
    float *measured, *modelled;           /* [texel][channel][lane]: BTF and STVS of the present view */
    float *measured_sums, *modelled_sums; /* [texel][channel][group] */
    enc_norms norms;
} refine_stage;

/* Sums a profile over GROUPS runs of consecutive lights, which are neighbours on a ring, so that little
 * cancels. */
static void group_sums(const refine_stage *s, const float *profile, float *out) {
    const int n = s->data->n_lights;
    for (size_t c = 0; c < 3; c++) {
        for (int g = 0; g < GROUPS; g++) {
            float sum = 0;
            for (int l = g * n / GROUPS; l < (g + 1) * n / GROUPS; l++) {
                sum += profile[c * s->lanes + (size_t)l];
            }
            out[c * GROUPS + (size_t)g] = sum;
        }
    }
}

/* Fills `modelled` with STVS under one view, and both arrays of sums. */
static void model_view(const refine_stage *s, int view) {
    const int n_lanes = (int)s->lanes;
#pragma omp parallel for num_threads(s->context->threads) schedule(static)
    for (size_t t = 0; t < s->n_texels; t++) {
        float *row = s->modelled + t * s->stride;
        /* lights beyond the last are zero vectors, whose multiplier is 0 */
        enc_sbrdf_evaluate(s->sbrdf, t, s->data->views[view].xyz, n_lanes, s->light, s->light + s->lanes,
                           s->light + 2 * s->lanes, row);
        for (int l = 0; l < n_lanes; l++) {
            const float cosine = s->light[3 * s->lanes + (size_t)l];
            const float shadow =
                l < s->data->n_lights ? (float)s->shadow[(size_t)l * s->n_texels + t] * s->shadow_scale : 0;
            for (size_t c = 0; c < 3; c++) {
                row[c * s->lanes + (size_t)l] *= cosine * shadow;
            }
        }
        group_sums(s, row, s->modelled_sums + t * BOUND_FLOATS);
        group_sums(s, s->measured + t * s->stride, s->measured_sums + t * BOUND_FLOATS);
    }
}

/* The mean distance of the points that are not hidden, with the shifts that they have; 0 if all are hidden.
 * `distances` has room for one a texel. */
static float mean_distance(const refine_stage *s, int view, float *distances) {
    const size_t first = (size_t)view * s->n_texels;
#pragma omp parallel for num_threads(s->context->threads) schedule(static)
    for (size_t t = 0; t < s->n_texels; t++) {
        const int8_t *shift = s->occlusion->shift + 2 * (first + t);
        const size_t source = enc_occlusion_source(s->data->width, s->data->height, t, shift[0], shift[1]);
        distances[t] = s->occlusion->hidden[first + t]
                           ? 0
                           : s->norms.distance(s->measured + t * s->stride,
                                               s->modelled + source * s->stride, s->lanes);
    }
    double sum = 0;
    size_t n = 0;
    for (size_t t = 0; t < s->n_texels; t++) {
        sum += distances[t];
        n += s->occlusion->hidden[first + t] == 0;
    }
    return n == 0 ? 0 : (float)(sum / (double)n);
}

/* The window's least shift along one axis, for a point of the given shift. */
static int window_first(const refine_stage *s, int shift, int first, int extent) {
    const int from = first + (s->around ? shift : 0);
    return from < -MOST_SHIFT - 1           ? -MOST_SHIFT - 1
           : from + extent - 1 > MOST_SHIFT ? MOST_SHIFT + 1 - extent
                                            : from;
}

/* Finds the best source of one point in its window: returns its distance and sets out_shift, which holds
 * the point's present shift on entry. `bounds` has room for the window. */
static float search_point(const refine_stage *s, size_t texel, float *bounds, int8_t out_shift[2]) {
    const int width = s->data->width, height = s->data->height;
    const int column = (int)(texel % (size_t)width), row = (int)(texel / (size_t)width);
    const int first_column = window_first(s, out_shift[0], s->first_column, s->columns);
    const int first_row = window_first(s, out_shift[1], s->first_row, s->rows);
    const int start = enc_occlusion_modulo(column + first_column, width);
    const int before_wrap = s->columns < width - start ? s->columns : width - start;
    const float *query = s->measured + texel * s->stride;
    const float *query_sums = s->measured_sums + texel * BOUND_FLOATS;

    float magnitude = 0;
    for (size_t k = 0; k < BOUND_FLOATS; k++) {
        magnitude += fabsf(query_sums[k]);
    }
    size_t likely = 0; /* window position of the least bound */
    for (int i = 0; i < s->rows; i++) {
        const size_t line = (size_t)enc_occlusion_modulo(row + first_row + i, height) * (size_t)width;
        float *to = bounds + (size_t)i * (size_t)s->columns;
        s->norms.bounds(query_sums, s->modelled_sums + (line + (size_t)start) * BOUND_FLOATS,
                        (size_t)before_wrap, to);
        s->norms.bounds(query_sums, s->modelled_sums + line * BOUND_FLOATS,
                        (size_t)(s->columns - before_wrap), to + before_wrap);
        for (size_t j = 0; j < (size_t)s->columns; j++) {
            if (to[j] < bounds[likely]) {
                likely = (size_t)i * (size_t)s->columns + j;
            }
        }
    }
    float best = INFINITY, limit = INFINITY;
    const size_t window = (size_t)s->rows * (size_t)s->columns;
    for (size_t k = 0; k <= window; k++) { /* the likely one first, then all in order */
        const size_t position = k == 0 ? likely : k - 1;
        if (bounds[position] > limit || (k > 0 && position == likely)) {
            continue;
        }
        const int8_t shift[2] = {(int8_t)(first_column + (int)(position % (size_t)s->columns)),
                                 (int8_t)(first_row + (int)(position / (size_t)s->columns))};
        const size_t source = enc_occlusion_source(width, height, texel, shift[0], shift[1]);
        const float distance = s->norms.distance(query, s->modelled + source * s->stride, s->lanes);
        if (distance < best || (distance == best && enc_occlusion_compare_shift(shift, out_shift) < 0)) {
            best = distance;
            limit = distance * (1 + rounding) + sum_rounding * magnitude;
            memcpy(out_shift, shift, 2);
        }
    }
    return best;
}

/* Searches for every hidden point of one view. `bounds` holds a window for each thread. */
static void refine_view(const refine_stage *s, int view, float threshold, float *bounds) {
    const size_t window = (size_t)s->rows * (size_t)s->columns;
#pragma omp parallel for num_threads(s->context->threads) schedule(dynamic, 16)
    for (size_t t = 0; t < s->n_texels; t++) {
        const size_t i = (size_t)view * s->n_texels + t;
        if (!s->occlusion->hidden[i]) {
            continue;
        }
        const float distance =
            search_point(s, t, bounds + (size_t)omp_get_thread_num() * window, s->occlusion->shift + 2 * i);
        s->occlusion->hidden[i] = !(distance < threshold);
    }
}

/* The extent of a window of `wanted` texels over a tile of `size`, and its least shift, within
 * -128..127. */
static int window_extent(int wanted, int size, int *out_first) {
    int extent = wanted < size ? wanted : size;
    if (extent > 256) {
        extent = 256;
    }
    const int first = -((extent - 1) / 2);
    *out_first = first + extent - 1 > 127 ? 128 - extent : first;
    return extent;
}

static btf_result refine_views(refine_stage *s, float *out_thresholds) {
    float *distances = malloc(s->n_texels * sizeof *distances);
    float *bounds =
        malloc((size_t)s->context->threads * (size_t)s->rows * (size_t)s->columns * sizeof *bounds);
    btf_result result = distances && bounds ? BTF_OK : BTF_ERROR_MEMORY;
    const size_t views = (size_t)s->data->n_views;
    size_t begin, end;
    enc_ranks_range(s->context, views, &begin, &end);
    for (int view = (int)begin; result == BTF_OK && view < (int)end; view++) {
        if (enc_cancelled(s->context)) {
            result = BTF_ERROR_INTERRUPTED;
            break;
        }
        if (enc_occlusion_hidden_count(s->occlusion, view) > 0 || out_thresholds) {
            result = enc_profiles_of_view(s->context, s->data, view, s->measured);
            if (result != BTF_OK) {
                break;
            }
            model_view(s, view);
            const float threshold = mean_distance(s, view, distances);
            refine_view(s, view, threshold, bounds);
            if (out_thresholds) {
                out_thresholds[view] = threshold;
            }
        }
        enc_stage_step(s->context, 1);
    }
    free(distances);
    free(bounds);
    result = enc_ranks_gather(s->context, result, s->occlusion->shift, 2 * s->n_texels, views);
    result = enc_ranks_gather(s->context, result, s->occlusion->hidden, s->n_texels, views);
    if (out_thresholds) {
        result = enc_ranks_gather(s->context, result, out_thresholds, sizeof *out_thresholds, views);
    }
    return result;
}

btf_result enc_refine(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                      const uint8_t *shadow, float shadow_scale, const enc_refine_options *options,
                      enc_occlusion *occlusion, float *out_thresholds) {
    assert(context && data && sbrdf && shadow && occlusion);
    assert(sbrdf->n_texels == enc_data_texel_count(data) && occlusion->n_texels == sbrdf->n_texels);
    assert(occlusion->n_views == data->n_views);
    const bool bounded = enc_data_texel_count(data) > WHOLE_TEXELS;
    const int standard = bounded ? BOUNDED_WINDOW : WHOLE_WINDOW;
    const int columns = options && options->columns != 0 ? options->columns : standard;
    const int rows = options && options->rows != 0 ? options->rows : standard;
    if (columns < 1 || rows < 1) {
        return enc_fail(context, BTF_ERROR_USAGE,
                        "hidden: search window of %dx%d texels, expected at least 1x1", columns, rows);
    }
    refine_stage s = {.context = context,
                      .data = data,
                      .sbrdf = sbrdf,
                      .shadow = shadow,
                      .shadow_scale = shadow_scale,
                      .occlusion = occlusion,
                      .n_texels = enc_data_texel_count(data),
                      .lanes = enc_profile_lanes(data->n_lights),
                      .stride = enc_profile_stride(data->n_lights)};
    /* a window that was asked for lies around the point itself, as the paper's does */
    s.around = bounded && (!options || (options->columns == 0 && options->rows == 0));
    s.columns = window_extent(columns, data->width, &s.first_column);
    s.rows = window_extent(rows, data->height, &s.first_row);
    s.norms = enc_norms_choose();
    s.light = calloc(4 * s.lanes, sizeof *s.light);
    s.measured = enc_profiles_create(s.n_texels, data->n_lights);
    s.modelled = enc_profiles_create(s.n_texels, data->n_lights);
    s.measured_sums = malloc(s.n_texels * BOUND_FLOATS * sizeof *s.measured_sums);
    s.modelled_sums = malloc(s.n_texels * BOUND_FLOATS * sizeof *s.modelled_sums);
    btf_result result = BTF_ERROR_MEMORY;
    if (s.light && s.measured && s.modelled && s.measured_sums && s.modelled_sums) {
        for (size_t l = 0; l < (size_t)data->n_lights; l++) {
            for (size_t k = 0; k < 3; k++) {
                s.light[k * s.lanes + l] = data->lights[l].xyz[k];
            }
            s.light[3 * s.lanes + l] = data->lights[l].xyz[2] > 0 ? data->lights[l].xyz[2] : 0;
        }
        size_t begin, end;
        enc_ranks_range(context, (size_t)data->n_views, &begin, &end);
        enc_stage_begin(context, "hidden", end - begin);
        result = refine_views(&s, out_thresholds);
        enc_stage_end(context);
    }
    free(s.light);
    free(s.measured);
    free(s.modelled);
    free(s.measured_sums);
    free(s.modelled_sums);
    if (result != BTF_OK && result != BTF_ERROR_INTERRUPTED) {
        return enc_fail(context, result, "hidden: search over %dx%d texels: %s", data->width, data->height,
                        btf_result_text(result));
    }
    return result;
}
