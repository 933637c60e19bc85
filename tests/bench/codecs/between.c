/* Accuracy between the samples. See between.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "between.h"

#include "encoder/base/stage.h"
#include "encoder/nodes/left_out.h"
#include "encoder/math/srgb.h"
#include "encoder/report/metrics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A pair of sampled directions: indices into the lists of those that can be left out. */
typedef struct left_pair {
    int view, light;
} left_pair;

struct bench_between {
    const enc_data *data;
    const bench_truth *truth;
    bench_truth estimate; /* the samples themselves, at pairs that are left out */
    left_pair *left;      /* [estimate.count] */
    enc_left_out views, lights;
};

typedef struct pair_weights {
    enc_weights view, light;
} pair_weights;

void bench_between_unknown(bench_between_figures figures) {
    for (int set = 0; set < BENCH_BETWEEN_SETS; set++) {
        figures[set][0] = figures[set][1] = NAN;
    }
}

/* A well-mixed number of 64 bits (SplitMix64). */
static uint64_t mix(uint64_t x) {
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

/* Fills in the estimate's pairs and their samples: [pair][texel][3]. */
static btf_result fill_estimate(const enc_context *context, bench_between *b) {
    const enc_data *data = b->data;
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights;
    float *buffer = malloc(enc_data_texel_stride(data) * sizeof *buffer);
    btf_result result = buffer ? BTF_OK : enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory");
    for (size_t t = 0; t < texels && result == BTF_OK; t++) {
        const float *samples;
        result = enc_data_texels(context, data, t, 1, buffer, &samples);
        for (size_t p = 0; p < b->estimate.count && result == BTF_OK; p++) {
            const size_t view = (size_t)b->views.index[b->left[p].view],
                         light = (size_t)b->lights.index[b->left[p].light];
            for (size_t c = 0; c < 3; c++) {
                b->estimate.images[3 * (p * texels + t) + c] = samples[(view * 3 + c) * lights + light];
            }
        }
    }
    free(buffer);
    return result;
}

/* Chooses the pairs of the estimate. Pairs whose light stood elsewhere than its direction says are left out, since
 * their images do not show the truth. */
static btf_result make_estimate(const enc_context *context, bench_between *b) {
    const enc_data *data = b->data;
    bench_truth *e = &b->estimate;
    btf_result result = enc_left_out_make(context, data->views, data->n_views, &b->views);
    if (result == BTF_OK) {
        result = enc_left_out_make(context, data->lights, data->n_lights, &b->lights);
    }
    if (result != BTF_OK || b->views.count == 0 || b->lights.count == 0) {
        return result;
    }
    const size_t texels = enc_data_texel_count(data);
    e->width = data->width;
    e->height = data->height;
    e->pair = calloc(BENCH_ESTIMATE_PAIRS, sizeof *e->pair);
    e->images = malloc(BENCH_ESTIMATE_PAIRS * 3 * texels * sizeof *e->images);
    b->left = calloc(BENCH_ESTIMATE_PAIRS, sizeof *b->left);
    if (!e->pair || !e->images || !b->left) {
        return enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory for %d images",
                        BENCH_ESTIMATE_PAIRS);
    }
    for (uint64_t i = 0; e->count < BENCH_ESTIMATE_PAIRS && i < 4 * BENCH_ESTIMATE_PAIRS; i++) {
        const left_pair at = {(int)(mix(2 * i) % (uint64_t)b->views.count),
                              (int)(mix(2 * i + 1) % (uint64_t)b->lights.count)};
        const int view = b->views.index[at.view], light = b->lights.index[at.light];
        if (!data->moved_light || data->moved_light[view].index != light) {
            b->left[e->count] = at;
            e->pair[e->count++] = (enc_pair){.view = data->views[view], .light = data->lights[light]};
        }
    }
    return fill_estimate(context, b);
}

btf_result bench_between_create(const enc_context *context, const enc_data *data, const bench_truth *truth,
                                bench_between **out_between) {
    bench_between *b = calloc(1, sizeof *b);
    *out_between = b;
    if (!b) {
        return enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory");
    }
    b->data = data;
    b->truth = truth;
    const btf_result result = make_estimate(context, b);
    if (result != BTF_OK) {
        bench_between_destroy(out_between);
    }
    return result;
}

void bench_between_destroy(bench_between **between) {
    if (*between) {
        bench_truth_clear(&(*between)->estimate);
        free((*between)->left);
        free(*between);
        *between = NULL;
    }
}

static const bench_truth *truth_of(const bench_between *between, bench_between_set set) {
    return set == BENCH_TRUTH ? between->truth : &between->estimate;
}

bool bench_between_has(const bench_between *between, bench_between_set set) {
    return truth_of(between, set)->count > 0;
}

static float clip(float x) {
    return x > 0 ? (x < 1 ? x : 1.0f) : 0.0f;
}

static void add_error(const float *truth, const float *found, enc_error_sum *sum) {
    for (int c = 0; c < 3; c++) {
        const double linear = (double)clip(truth[c]) - clip(found[c]);
        const double srgb = (double)enc_srgb_encode(truth[c]) - enc_srgb_encode(found[c]);
        sum->linear += linear * linear;
        sum->srgb += srgb * srgb;
    }
    sum->count += 3;
}

static void sum_up(const enc_error_sum *parts, size_t count, double out[2]) {
    enc_error_sum total = {0};
    for (size_t i = 0; i < count; i++) {
        total.linear += parts[i].linear;
        total.srgb += parts[i].srgb;
        total.count += parts[i].count;
    }
    out[0] = enc_psnr_linear(&total);
    out[1] = enc_psnr_srgb(&total);
}

/* --- materials --- */

/* Decodes the image of a pair: at the truth's directions; or, in the estimate, at sampled directions from the other
 * samples. */
static void decode_pair(const bench_between *b, bench_between_set set, const btf_ref_material *material,
                        const btf_ref_options *options, size_t p, float *out) {
    const enc_pair *pair = &truth_of(b, set)->pair[p];
    const float *light = pair->light.xyz, *view = pair->view.xyz;
    const btf_ref_neighbours *lights = NULL, *views = NULL;
    if (set == BENCH_ESTIMATE) {
        lights = &b->lights.near[b->left[p].light];
        views = &b->views.near[b->left[p].view];
    }
    for (uint32_t row = 0; row < material->height; row++) {
        for (uint32_t column = 0; column < material->width; column++, out += 3) {
            if (lights) {
                btf_ref_evaluate_neighbours(material, options, column, row, lights, views, light, view, out);
            } else {
                btf_ref_evaluate_texel(material, options, column, row, light, view, out);
            }
        }
    }
}

static btf_result measure_material(const enc_context *context, const bench_between *b,
                                   bench_between_set set, const btf_ref_material *material,
                                   const btf_ref_options *options, enc_error_sum *sums) {
    const bench_truth *truth = truth_of(b, set);
    const size_t texels = enc_data_texel_count(b->data);
    btf_result result = BTF_OK;
#pragma omp parallel num_threads(context->threads)
    {
        float *image = malloc(3 * texels * sizeof *image);
        btf_result mine = image ? BTF_OK : BTF_ERROR_MEMORY;
#pragma omp for schedule(dynamic)
        for (size_t p = 0; p < truth->count; p++) {
            if (mine == BTF_OK && enc_cancelled(context)) {
                mine = BTF_ERROR_INTERRUPTED;
            }
            if (mine == BTF_OK) {
                decode_pair(b, set, material, options, p, image);
            }
            for (size_t t = 0; t < texels && mine == BTF_OK; t++) {
                add_error(truth->images + 3 * (p * texels + t), image + 3 * t, &sums[p]);
            }
        }
        free(image);
        enc_keep_worse(&result, mine);
    }
    return result;
}

btf_result bench_between_material(const enc_context *context, const bench_between *b,
                                  const btf_ref_material *material, const btf_ref_options *options,
                                  bench_between_figures out_figures) {
    btf_result result = BTF_OK;
    bench_between_unknown(out_figures);
    for (int set = 0; set < BENCH_BETWEEN_SETS && result == BTF_OK; set++) {
        const size_t count = truth_of(b, (bench_between_set)set)->count;
        enc_error_sum *sums = calloc(count + 1, sizeof *sums);
        result = sums ? measure_material(context, b, (bench_between_set)set, material, options, sums)
                      : BTF_ERROR_MEMORY;
        if (result == BTF_OK && count > 0) {
            sum_up(sums, count, out_figures[set]);
        }
        free(sums);
    }
    return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "bench: out of memory") : result;
}

/* --- interpolated images --- */

static btf_result weights_of_truth(const enc_context *context, const bench_between *b,
                                   enc_interpolation kind, pair_weights *weights) {
    const enc_data *data = b->data;
    enc_interpolator *views = NULL, *lights = NULL;
    btf_result result = enc_interpolator_create(context, "views", data->views, data->n_views, kind, &views);
    if (result == BTF_OK) {
        result = enc_interpolator_create(context, "lights", data->lights, data->n_lights, kind, &lights);
    }
    for (size_t p = 0; p < b->truth->count && result == BTF_OK; p++) {
        enc_interpolator_weights(views, b->truth->pair[p].view.xyz, &weights[p].view);
        enc_interpolator_weights(lights, b->truth->pair[p].light.xyz, &weights[p].light);
    }
    enc_interpolator_destroy(&views);
    enc_interpolator_destroy(&lights);
    return result;
}

/* The weights, at one direction, of a spline through all the others. */
static btf_result spline_without(const enc_context *context, const char *name,
                                 const enc_direction *directions, int count, int without,
                                 enc_weights *out) {
    enc_direction others[ENC_MAX_DIRECTIONS];
    enc_interpolator *spline;
    int n = 0;
    for (int i = 0; i < count; i++) {
        if (i != without) {
            others[n++] = directions[i];
        }
    }
    const btf_result result =
        enc_interpolator_create(context, name, others, n, ENC_INTERPOLATE_SPLINE, &spline);
    if (result != BTF_OK) {
        return result;
    }
    enc_interpolator_weights(spline, directions[without].xyz, out);
    for (int i = 0; i < out->count; i++) {
        out->index[i] += out->index[i] >= (uint32_t)without;
    }
    enc_interpolator_destroy(&spline);
    return BTF_OK;
}

static void weights_near(btf_ref_neighbours near, bool nearest, enc_weights *out) {
    if (nearest) {
        near = btf_ref_nearest(near);
    }
    out->count = 0;
    for (int i = 0; i < 3; i++) {
        if (near.weight[i] > 0) {
            out->index[out->count] = near.index[i];
            out->weight[out->count++] = (float)near.weight[i] * 0x1p-12f;
        }
    }
}

/* The weights for each direction that can be left out: [list->count]. */
static btf_result weights_of_list(const enc_context *context, const char *name,
                                  const enc_direction *directions, int count, const enc_left_out *list,
                                  enc_interpolation kind, enc_weights *out) {
    btf_result result = BTF_OK;
    for (int i = 0; i < list->count && result == BTF_OK; i++) {
        if (kind == ENC_INTERPOLATE_SPLINE) {
            result = spline_without(context, name, directions, count, list->index[i], &out[i]);
        } else {
            weights_near(list->near[i], kind == ENC_INTERPOLATE_NEAREST, &out[i]);
        }
    }
    return result;
}

static btf_result weights_of_estimate(const enc_context *context, const bench_between *b,
                                      enc_interpolation kind, pair_weights *weights) {
    const enc_data *data = b->data;
    enc_weights *views = malloc(ENC_MAX_DIRECTIONS * sizeof *views),
                *lights = malloc(ENC_MAX_DIRECTIONS * sizeof *lights);
    btf_result result = views && lights ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = weights_of_list(context, "views", data->views, data->n_views, &b->views, kind, views);
    }
    if (result == BTF_OK) {
        result = weights_of_list(context, "lights", data->lights, data->n_lights, &b->lights, kind, lights);
    }
    for (size_t p = 0; p < b->estimate.count && result == BTF_OK; p++) {
        weights[p] = (pair_weights){views[b->left[p].view], lights[b->left[p].light]};
    }
    free(views);
    free(lights);
    return result;
}

/* Interpolates one texel's samples, [view][channel][light], or their roots, at one pair. */
static void blend(const pair_weights *w, const float *samples, size_t lights, bool roots, float out[3]) {
    for (size_t c = 0; c < 3; c++) {
        float sum = 0;
        for (int a = 0; a < w->view.count; a++) {
            const float *profile = samples + (w->view.index[a] * 3 + c) * lights;
            float part = 0;
            for (int i = 0; i < w->light.count; i++) {
                part += w->light.weight[i] * profile[w->light.index[i]];
            }
            sum += w->view.weight[a] * part;
        }
        out[c] = !roots ? sum : sum > 0 ? sum * sum : 0.0f;
    }
}

/* The errors of one texel at all pairs; buffer and roots: room for a texel's samples. */
static btf_result measure_texel(const enc_context *context, const bench_truth *truth,
                                const enc_data *images, const pair_weights *weights, bool roots,
                                size_t texel, float *buffer, float *rooted, enc_error_sum *sum) {
    const size_t texels = enc_data_texel_count(images), stride = enc_data_texel_stride(images);
    const float *samples;
    const btf_result result = enc_data_texels(context, images, texel, 1, buffer, &samples);
    if (result != BTF_OK) {
        return result;
    }
    if (roots) {
        for (size_t i = 0; i < stride; i++) {
            rooted[i] = sqrtf(fmaxf(samples[i], 0));
        }
        samples = rooted;
    }
    for (size_t p = 0; p < truth->count; p++) {
        float found[3];
        blend(&weights[p], samples, (size_t)images->n_lights, roots, found);
        add_error(truth->images + 3 * (p * texels + texel), found, sum);
    }
    return BTF_OK;
}

static btf_result measure_images(const enc_context *context, const bench_truth *truth,
                                 const enc_data *images, const pair_weights *weights, bool roots,
                                 enc_error_sum *sums) {
    const size_t texels = enc_data_texel_count(images), stride = enc_data_texel_stride(images);
    btf_result result = BTF_OK;
#pragma omp parallel num_threads(context->threads)
    {
        float *buffer = malloc(stride * sizeof *buffer), *rooted = malloc(stride * sizeof *rooted);
        btf_result mine = buffer && rooted ? BTF_OK : BTF_ERROR_MEMORY;
#pragma omp for schedule(dynamic, 16)
        for (size_t t = 0; t < texels; t++) {
            if (mine == BTF_OK && enc_cancelled(context)) {
                mine = BTF_ERROR_INTERRUPTED;
            }
            if (mine == BTF_OK) {
                mine = measure_texel(context, truth, images, weights, roots, t, buffer, rooted, &sums[t]);
            }
        }
        free(buffer);
        free(rooted);
        enc_keep_worse(&result, mine);
    }
    return result;
}

btf_result bench_between_images(const enc_context *context, const bench_between *b, const enc_data *images,
                                enc_interpolation kind, bench_between_figures out_figures) {
    const size_t texels = enc_data_texel_count(images);
    btf_result result = BTF_OK;
    bench_between_unknown(out_figures);
    for (int set = 0; set < BENCH_BETWEEN_SETS && result == BTF_OK; set++) {
        const bench_truth *truth = truth_of(b, (bench_between_set)set);
        if (truth->count == 0) {
            continue;
        }
        pair_weights *weights = malloc(truth->count * sizeof *weights);
        enc_error_sum *sums = calloc(texels, sizeof *sums);
        result = weights && sums ? BTF_OK : BTF_ERROR_MEMORY;
        if (result == BTF_OK) {
            result = set == BENCH_TRUTH ? weights_of_truth(context, b, kind, weights)
                                        : weights_of_estimate(context, b, kind, weights);
        }
        if (result == BTF_OK) {
            result = measure_images(context, truth, images, weights, kind == ENC_INTERPOLATE_SPLINE, sums);
        }
        if (result == BTF_OK) {
            sum_up(sums, texels, out_figures[set]);
        }
        free(weights);
        free(sums);
    }
    return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "bench: out of memory") : result;
}
