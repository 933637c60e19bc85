/* Accuracy of one BTF against another. See metrics.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "metrics.h"

#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/data/coincident.h"
#include "encoder/data/level_filter.h"
#include "encoder/math/srgb.h"
#include "encoder/model/decode_samples.h"
#include "ssim.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double psnr(double sum, double count) {
    return sum > 0 ? 10 * log10(count / sum) : 100.0;
}

double enc_psnr_linear(const enc_error_sum *sum) {
    return psnr(sum->linear, sum->count);
}

double enc_psnr_srgb(const enc_error_sum *sum) {
    return psnr(sum->srgb, sum->count);
}

int enc_rings(const enc_direction *directions, int count, double *out_theta, int *out_ring_of) {
    int rings = 0;
    for (int i = 0; i < count; i++) {
        int ring = 0;
        while (ring < rings && fabs(out_theta[ring] - directions[i].theta) > 1e-3) {
            ring++;
        }
        if (ring == rings) {
            out_theta[rings++] = directions[i].theta;
        }
        out_ring_of[i] = ring;
    }
    return rings; /* directions are in paper order, so thetas came ascending */
}

static float clip(float x) {
    return x > 0 ? (x < 1 ? x : 1.0f) : 0.0f;
}

/* Finds the errors of one image; writes both, sRGB-coded, to `coded` (2 * n floats), of which SSIM is
 * taken. */
static enc_error_sum image_error(size_t n, const float *a, const float *b, float *coded) {
    enc_error_sum sum = {.count = (double)n};
    for (size_t i = 0; i < n; i++) {
        const double linear = (double)clip(a[i]) - clip(b[i]);
        coded[i] = enc_srgb_encode(a[i]);
        coded[n + i] = enc_srgb_encode(b[i]);
        const double srgb = (double)coded[i] - coded[n + i];
        sum.linear += linear * linear;
        sum.srgb += srgb * srgb;
    }
    return sum;
}

static void add(enc_error_sum *to, const enc_error_sum *from) {
    to->linear += from->linear;
    to->srgb += from->srgb;
    to->count += from->count;
}

/* Compares all images of one view: error[light], and the sum of their SSIM. */
static btf_result compare_view(const enc_data *shape, enc_image_source original, enc_image_source other,
                               int view, bool with_ssim, enc_error_sum *error, double *out_ssim) {
    const size_t texels = enc_data_texel_count(shape), image = texels * 3, lights = (size_t)shape->n_lights;
    float *a = malloc(lights * image * sizeof *a), *b = malloc(lights * image * sizeof *b);
    float *coded = malloc(2 * image * sizeof *coded);
    enc_ssim *ssim = with_ssim ? enc_ssim_create(shape->width, shape->height) : NULL;
    btf_result result = a && b && coded && (ssim || !with_ssim) ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = original.view(original.user, view, a);
    }
    if (result == BTF_OK) {
        result = other.view(other.user, view, b);
    }
    *out_ssim = 0;
    for (size_t l = 0; result == BTF_OK && l < lights; l++) {
        error[l] = image_error(image, a + l * image, b + l * image, coded);
        if (with_ssim) {
            *out_ssim += enc_ssim_images(ssim, coded, coded + image);
        }
    }
    enc_ssim_destroy(&ssim);
    free(coded);
    free(b);
    free(a);
    return result;
}

btf_result enc_metrics_compare(const enc_context *context, const enc_data *shape, enc_image_source original,
                               enc_image_source other, bool with_ssim, enc_metrics *out) {
    const int views = shape->n_views, lights = shape->n_lights;
    /* kept image by image, and added up at the end in one order, whatever thread or rank compared which */
    enc_error_sum *error = calloc((size_t)views * (size_t)lights, sizeof *error);
    double *ssim = calloc((size_t)views, sizeof *ssim);
    int view_ring_of[BTF_MAX_DIRECTIONS], light_ring_of[BTF_MAX_DIRECTIONS];
    btf_result result = error && ssim ? BTF_OK : BTF_ERROR_MEMORY;
    const int threads = enc_memory_threads(context, 2 * enc_data_texel_count(shape) *
                                                        (uint64_t)shape->n_lights * 3 * sizeof(float));
    size_t first, end;
    enc_ranks_range(context, (size_t)views, &first, &end);
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (int v = (int)first; v < (int)end; v++) {
        btf_result mine;
#pragma omp atomic read
        mine = result;
        if (mine != BTF_OK) {
            continue;
        }
        mine = enc_cancelled(context) ? BTF_ERROR_INTERRUPTED
                                      : compare_view(shape, original, other, v, with_ssim,
                                                     error + (size_t)v * (size_t)lights, &ssim[v]);
        enc_keep_worse(&result, mine);
        enc_stage_step(context, 1);
    }
    const size_t count = (size_t)views;
    result = enc_ranks_gather(context, result, error, (size_t)lights * sizeof *error, count);
    result = enc_ranks_gather(context, result, ssim, sizeof *ssim, count);
    if (result != BTF_OK) {
        free(ssim);
        free(error);
        return result == BTF_ERROR_INTERRUPTED
                   ? result
                   : enc_fail(context, result, "comparing images: %s", btf_result_text(result));
    }
    memset(out, 0, sizeof *out);
    out->n_view_rings = enc_rings(shape->views, views, out->view_ring_theta, view_ring_of);
    out->n_light_rings = enc_rings(shape->lights, lights, out->light_ring_theta, light_ring_of);
    for (int v = 0; v < views; v++) {
        const int coincident = enc_coincident_light(shape, v);
        if (coincident >= 0) {
            add(&out->coincident, &error[(size_t)v * (size_t)lights + (size_t)coincident]);
        }
        for (int l = 0; l < lights; l++) {
            const enc_error_sum *e = &error[(size_t)v * (size_t)lights + (size_t)l];
            add(&out->total, e);
            add(&out->view_ring[view_ring_of[v]], e);
            add(&out->light_ring[light_ring_of[l]], e);
        }
        out->ssim += ssim[v] / ((double)views * lights);
    }
    free(ssim);
    free(error);
    return BTF_OK;
}

/* The comparison of levels with the filtered data. */
typedef struct measure_pass {
    enc_context quiet;
    const enc_context *context;
    const enc_levels *levels;
    enc_metrics *metrics;
} measure_pass;

static btf_result measure_level(void *user, int level, const enc_data *data) {
    measure_pass *pass = user;
    enc_sample_decoder *decoder = NULL;
    btf_result result =
        enc_sample_decoder_create(&pass->quiet, data, &pass->levels->level[level - 1], &decoder);
    if (result == BTF_OK) {
        const enc_decoded_samples decoded = {.decoder = decoder, .effects = BTF_EFFECT_ALL};
        result = enc_metrics_compare(&pass->quiet, data, enc_data_images(data),
                                     enc_decoded_images(&decoded), false, &pass->metrics[level - 1]);
    }
    enc_sample_decoder_destroy(&decoder);
    enc_stage_step(pass->context, enc_data_texel_count(data));
    return result;
}

btf_result enc_levels_measure(const enc_context *context, const enc_data *data, const enc_levels *levels,
                              enc_metrics *out_metrics) {
    measure_pass pass = {.quiet = *context, .context = context, .levels = levels, .metrics = out_metrics};
    pass.quiet.progress = NULL;
    enc_stage_begin(context, "measure levels",
                    enc_level_further_texels(data->width, data->height, levels->count));
    const btf_result result = enc_level_each(context, data, levels->count, measure_level, &pass);
    enc_stage_end(context);
    return result;
}

void enc_metrics_json(json *j, const char *key, const enc_metrics *m, bool with_ssim) {
    json_object(j, key);
    json_number(j, "linear", enc_psnr_linear(&m->total));
    json_number(j, "srgb", enc_psnr_srgb(&m->total));
    json_number(j, "ssim", with_ssim ? m->ssim : NAN);
    if (m->coincident.count > 0) {
        json_object(j, "coincident");
        json_number(j, "linear", enc_psnr_linear(&m->coincident));
        json_number(j, "srgb", enc_psnr_srgb(&m->coincident));
        json_end(j);
    }
    json_object(j, "rings");
    for (int side = 0; side < 2; side++) {
        const int rings = side == 0 ? m->n_view_rings : m->n_light_rings;
        json_array(j, side == 0 ? "view" : "light");
        for (int r = 0; r < rings; r++) {
            const enc_error_sum *sum = side == 0 ? &m->view_ring[r] : &m->light_ring[r];
            json_object(j, NULL);
            json_number(j, "theta", side == 0 ? m->view_ring_theta[r] : m->light_ring_theta[r]);
            json_number(j, "linear", enc_psnr_linear(sum));
            json_number(j, "srgb", enc_psnr_srgb(sum));
            json_end(j);
        }
        json_end(j);
    }
    json_end(j);
    json_end(j);
}
