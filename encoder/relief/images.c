/* Profiles reduced to principal components. See images.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "images.h"

#include "encoder/base/stage.h"
#include "encoder/data/level_filter.h"
#include "encoder/math/clones.h"
#include "encoder/math/symmetric.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    K = ENC_RELIEF_NUMBERS,
    DRAWN_PROFILES = 20000, /* at most, from which means and components are found */
};

/* Added to variances, so that noise in dark images counts little: the square of about a code of 255. */
#define LEAST_VARIANCE 1e-5

/* Roots of radiance, clipped to 1 as for the error. */
static void to_roots(size_t n, const float *samples, float *out) {
    for (size_t i = 0; i < n; i++) {
        const float low = samples[i] > 0 ? samples[i] : 0.0f;
        out[i] = sqrtf(low < 1 ? low : 1.0f);
    }
}

/* out [K] = basis [n][K] applied to a profile. */
ENC_CLONES static void project(size_t n, const float *basis, const float *profile, float *out) {
    float sum[K] = {0};
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < K; k++) {
            sum[k] += profile[i] * basis[i * K + k];
        }
    }
    memcpy(out, sum, sizeof sum);
}

/* What turns roots into the numbers of a kind: (root - mean) * scale, times the basis. */
typedef struct maker {
    float *basis;        /* [n][K], n lights and channels */
    float *mean, *scale; /* [view][n] */
} maker;

/* Shifts and scales the roots of a texel in all views as the kind asks. */
static void to_kind(size_t stride, const maker *m, const float *roots, float *out) {
    for (size_t i = 0; i < stride; i++) {
        out[i] = (roots[i] - m->mean[i]) * m->scale[i];
    }
}

/* Draws texels evenly and fills `rows` with their roots: a row for each channel and light, a column for
 * each view and texel. */
static btf_result draw_profiles(const enc_context *context, const enc_data *data, size_t texels,
                                float *rows) {
    const size_t stride = enc_data_texel_stride(data), all = enc_data_texel_count(data);
    const size_t n = 3 * (size_t)data->n_lights, views = (size_t)data->n_views, columns = texels * views;
    btf_result result = BTF_OK;
#pragma omp parallel for schedule(dynamic) num_threads(context->threads)
    for (size_t t = 0; t < texels; t++) {
        float *buffer = malloc(2 * stride * sizeof *buffer);
        const float *samples = NULL;
        const btf_result mine =
            buffer ? enc_data_texels(context, data, (2 * t + 1) * all / (2 * texels), 1, buffer, &samples)
                   : BTF_ERROR_MEMORY;
        if (mine == BTF_OK) {
            float *roots = buffer + stride;
            to_roots(stride, samples, roots);
            for (size_t v = 0; v < views; v++) {
                for (size_t i = 0; i < n; i++) {
                    rows[i * columns + v * texels + t] = roots[v * n + i];
                }
            }
        } else {
            enc_keep_worse(&result, mine);
        }
        free(buffer);
    }
    return result;
}

/* Finds mean and scale of `count` values, and applies both to them. */
static void standardise(size_t count, float *values, bool scaled, float *out_mean, float *out_scale) {
    double sum = 0, square = 0;
    for (size_t i = 0; i < count; i++) {
        sum += (double)values[i];
    }
    const float mean = (float)(sum / (double)count);
    for (size_t i = 0; i < count; i++) {
        values[i] -= mean;
        square += (double)values[i] * (double)values[i];
    }
    const float scale = scaled ? (float)(1 / sqrt(square / (double)count + LEAST_VARIANCE)) : 1;
    for (size_t i = 0; i < count; i++) {
        values[i] *= scale;
    }
    *out_mean = mean;
    *out_scale = scale;
}

/* Finds the leading components of the profiles drawn, zeros beyond n; the rows are overwritten. */
static btf_result make(const enc_context *context, const enc_data *data, enc_relief_kind kind,
                       size_t texels, float *rows, double *gram, maker *out) {
    const size_t n = 3 * (size_t)data->n_lights, views = (size_t)data->n_views, count = texels * views;
    for (size_t i = 0; i < n; i++) {
        for (size_t v = 0; v < views; v++) {
            float *row = rows + i * count, *values = kind == ENC_RELIEF_STANDARD ? row + v * texels : row;
            float *mean = &out->mean[v * n + i], *scale = &out->scale[v * n + i];
            /* Roots have one mean over all views, which keeps the differences between views. */
            if (kind == ENC_RELIEF_STANDARD || v == 0) {
                standardise(kind == ENC_RELIEF_STANDARD ? texels : count, values,
                            kind == ENC_RELIEF_STANDARD, mean, scale);
            } else {
                *mean = out->mean[i];
                *scale = out->scale[i];
            }
        }
    }
    enc_gram_rows(context->threads, n, count, rows, gram);
    if (!enc_eigen_symmetric(n, gram, gram + n * n)) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < K; k++) {
            out->basis[i * K + k] = k < n ? (float)gram[k * n + i] : 0;
        }
    }
    return BTF_OK;
}

static btf_result make_all(const enc_context *context, const enc_data *data,
                           maker makers[ENC_RELIEF_KINDS]) {
    const size_t n = 3 * (size_t)data->n_lights, views = (size_t)data->n_views,
                 all = enc_data_texel_count(data);
    const size_t wanted = DRAWN_PROFILES / views + 1, texels = wanted < all ? wanted : all,
                 count = texels * views;
    float *rows = malloc(n * count * sizeof *rows);
    double *gram = malloc((n + 1) * n * sizeof *gram);
    btf_result result = rows && gram ? draw_profiles(context, data, texels, rows) : BTF_ERROR_MEMORY;
    for (int kind = 0; kind < ENC_RELIEF_KINDS && result == BTF_OK; kind++) {
        result = makers[kind].basis && makers[kind].mean && makers[kind].scale
                     ? make(context, data, (enc_relief_kind)kind, texels, rows, gram, &makers[kind])
                     : BTF_ERROR_MEMORY;
    }
    free(rows);
    free(gram);
    return result;
}

uint64_t enc_relief_images_bytes(int width, int height, int n_views) {
    return (uint64_t)width * (uint64_t)height * (uint64_t)n_views * K * sizeof(float);
}

static btf_result allocate(int width, int height, int n_views, enc_relief_images *out) {
    *out = (enc_relief_images){.width = width, .height = height, .n_views = n_views};
    out->of = malloc(enc_relief_images_bytes(width, height, n_views));
    return out->of ? BTF_OK : BTF_ERROR_MEMORY;
}

/* Fills in texel `t` with the mean of the side x side texels of the data that it covers. */
static btf_result fill_texel(const enc_context *context, const enc_data *data, int side,
                             const maker *makers, size_t t, float *work, const enc_relief_images *out) {
    const size_t stride = enc_data_texel_stride(data), n = 3 * (size_t)data->n_lights;
    const size_t views = (size_t)data->n_views, width = (size_t)out->width, size = (size_t)side;
    const size_t texels = width * (size_t)out->height;
    const float share = 1.0f / (float)(side * side);
    float *roots = work + stride, *values = roots + stride, *sums = values + stride;
    memset(sums, 0, ENC_RELIEF_KINDS * views * K * sizeof *sums);
    for (size_t i = 0; i < size * size; i++) {
        const size_t row = t / width * size + i / size, column = t % width * size + i % size;
        const float *samples;
        const btf_result result =
            enc_data_texels(context, data, row * (size_t)data->width + column, 1, work, &samples);
        if (result != BTF_OK) {
            return result;
        }
        to_roots(stride, samples, roots);
        for (size_t j = 0; j < ENC_RELIEF_KINDS * views; j++) {
            float numbers[K];
            if (j % views == 0) {
                to_kind(stride, &makers[j / views], roots, values);
            }
            project(n, makers[j / views].basis, values + j % views * n, numbers);
            for (size_t k = 0; k < K; k++) {
                sums[j * K + k] += numbers[k] * share;
            }
        }
    }
    for (size_t j = 0; j < ENC_RELIEF_KINDS * views; j++) {
        memcpy(out[j / views].of + (j % views * texels + t) * K, sums + j * K, K * sizeof *sums);
    }
    enc_stage_step(context, size * size);
    return BTF_OK;
}

static btf_result fill(const enc_context *context, const enc_data *data, int side, const maker *makers,
                       const enc_relief_images *out) {
    const size_t texels = (size_t)out->width * (size_t)out->height;
    const size_t each = 3 * enc_data_texel_stride(data) + ENC_RELIEF_KINDS * (size_t)data->n_views * K;
    btf_result result = BTF_OK;
#pragma omp parallel num_threads(context->threads)
    {
        float *work = malloc(each * sizeof *work);
#pragma omp for schedule(dynamic, 8)
        for (size_t t = 0; t < texels; t++) {
            const btf_result mine = !work ? BTF_ERROR_MEMORY
                                    : enc_cancelled(context)
                                        ? BTF_ERROR_INTERRUPTED
                                        : fill_texel(context, data, side, makers, t, work, out);
            enc_keep_worse(&result, mine);
        }
        free(work);
    }
    return result;
}

btf_result enc_relief_images_create(const enc_context *context, const enc_data *data, int shift,
                                    enc_relief_images out[ENC_RELIEF_KINDS]) {
    const size_t n = 3 * (size_t)data->n_lights, views = (size_t)data->n_views;
    maker makers[ENC_RELIEF_KINDS];
    btf_result result = BTF_OK;
    for (int kind = 0; kind < ENC_RELIEF_KINDS; kind++) {
        const btf_result mine =
            allocate(data->width >> shift, data->height >> shift, data->n_views, &out[kind]);
        result = mine == BTF_OK ? result : mine;
        makers[kind] = (maker){.basis = malloc(n * K * sizeof(float)),
                               .mean = malloc(views * n * sizeof(float)),
                               .scale = malloc(views * n * sizeof(float))};
    }
    if (result == BTF_OK) {
        result = make_all(context, data, makers);
    }
    if (result == BTF_OK) {
        result = fill(context, data, 1 << shift, makers, out);
    }
    for (int kind = 0; kind < ENC_RELIEF_KINDS; kind++) {
        free(makers[kind].basis);
        free(makers[kind].mean);
        free(makers[kind].scale);
        if (result != BTF_OK) {
            enc_relief_images_clear(&out[kind]);
        }
    }
    return result;
}

btf_result enc_relief_images_halve(const enc_relief_images *from, enc_relief_images *out) {
    const size_t wide = (size_t)from->width, all = wide * (size_t)from->height;
    const btf_result result = allocate(from->width / 2, from->height / 2, from->n_views, out);
    const size_t width = (size_t)out->width, height = (size_t)out->height;
    for (size_t v = 0; v < (size_t)from->n_views && result == BTF_OK; v++) {
        for (size_t t = 0; t < width * height; t++) {
            const float *a = from->of + (v * all + 2 * (t / width) * wide + 2 * (t % width)) * K,
                        *b = a + wide * K;
            float *to = out->of + (v * width * height + t) * K;
            for (size_t k = 0; k < K; k++) {
                to[k] = ((a[k] + a[K + k]) + (b[k] + b[K + k])) * 0.25f;
            }
        }
    }
    return result;
}

void enc_relief_images_clear(enc_relief_images *images) {
    free(images->of);
    *images = (enc_relief_images){0};
}
