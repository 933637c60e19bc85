/* Rows of a joint fit: clipping, the square root, and passes over all data (see joint_rows.h).
 *
 * Highlights: least squares on radiance that reaches 10 or 100 would spend everything on a few samples
 * (prototype: an unclipped set costs PCA 1.6 dB). The scale is 1 where nothing exceeds it; else the
 * 99.9th percentile of the samples, at least 1 and at most 2^24. Larger samples are clipped to it.
 *
 * SPDX-License-Identifier: MIT
 */
#include "joint_rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HISTOGRAM = 4096 }; /* bins of the percentile: 64 a factor of two, from 1 to 2^64 */

/* One block of data, shared by the calls of a pass. */
static btf_result load_block(const joint_rows *rows, size_t first, size_t *out_count, float *buffer,
                             const float **out_samples) {
    *out_count = rows->texels - first < JOINT_BLOCK ? rows->texels - first : JOINT_BLOCK;
    return enc_data_texels(rows->context, rows->data, first, *out_count, buffer, out_samples);
}

static float *block_buffer(const joint_rows *rows) {
    if (rows->data->samples)
        return NULL;
    return enc_gemm_alloc(JOINT_BLOCK * enc_data_texel_stride(rows->data));
}

static void transform(const joint_rows *rows, const float *restrict from, float *restrict to) {
    const float scale = rows->scale, factor = 1.0f / scale;
    for (size_t i = 0; i < rows->row; i++)
        to[i] = (from[i] < scale ? from[i] : scale) * factor;
    if (rows->root)
        for (size_t i = 0; i < rows->row; i++)
            to[i] = sqrtf(to[i]);
}

btf_result joint_rows_one(const joint_rows *rows, size_t texel, size_t view, float *texel_buffer,
                          float *out) {
    const float *samples;
    const btf_result result = enc_data_texels(rows->context, rows->data, texel, 1, texel_buffer, &samples);
    if (result == BTF_OK)
        transform(rows, samples + view * rows->row, out);
    return result;
}

btf_result joint_rows_pass(const joint_rows *rows, joint_pass_fn fn, void *user) {
    const size_t stride = enc_data_texel_stride(rows->data);
    const int threads = rows->context->threads;
    float *buffer = block_buffer(rows);
    float *block = enc_gemm_alloc((size_t)threads * JOINT_BLOCK * rows->row);
    btf_result result = BTF_OK;
    if (!block || (!buffer && !rows->data->samples)) {
        result = enc_fail(rows->context, BTF_ERROR_MEMORY, "joint: out of memory for a block of %d texels",
                          JOINT_BLOCK);
        goto fail;
    }
    for (size_t first = 0; first < rows->texels; first += JOINT_BLOCK) {
        const float *samples;
        size_t count;
        if (enc_cancelled(rows->context)) {
            result = BTF_ERROR_INTERRUPTED;
            goto fail;
        }
        result = load_block(rows, first, &count, buffer, &samples);
        if (result != BTF_OK)
            goto fail;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (size_t view = 0; view < rows->views; view++) {
            float *mine = block + (size_t)enc_thread_index() * JOINT_BLOCK * rows->row;
            for (size_t i = 0; i < count; i++)
                transform(rows, samples + i * stride + view * rows->row, mine + i * rows->row);
            fn(user, view, first, count, mine);
        }
    }
fail:
    free(block);
    free(buffer);
    return result;
}

/* Index of the bin of a sample above 1. */
static size_t bin_of(float sample) {
    const double position = log2((double)sample) * 64.0;
    return position < HISTOGRAM - 1 ? (size_t)position : HISTOGRAM - 1;
}

/* The 99.9th percentile of all samples, at least 1: the upper edge of its bin. */
static btf_result find_scale(joint_rows *rows) {
    uint64_t histogram[HISTOGRAM] = {0};
    const size_t stride = enc_data_texel_stride(rows->data);
    float *buffer = block_buffer(rows);
    btf_result result = BTF_OK;
    uint64_t above = 0;
    if (!buffer && !rows->data->samples)
        return enc_fail(rows->context, BTF_ERROR_MEMORY, "joint: out of memory for a block of %d texels",
                        JOINT_BLOCK);
    for (size_t first = 0; first < rows->texels && result == BTF_OK; first += JOINT_BLOCK) {
        const float *samples;
        size_t count;
        result = load_block(rows, first, &count, buffer, &samples);
        for (size_t i = 0; result == BTF_OK && i < count * stride; i++)
            if (samples[i] > 1.0f) {
                histogram[bin_of(samples[i])]++;
                above++;
            }
    }
    free(buffer);
    const uint64_t kept = rows->texels * stride / 1000;
    size_t bin = HISTOGRAM;
    for (above = 0; bin > 0 && above + histogram[bin - 1] <= kept; bin--)
        above += histogram[bin - 1];
    rows->scale = (float)exp2(fmin((double)bin / 64.0, 24.0)); /* what radianceScale may be */
    return result;
}

static void add_energy(void *user, size_t view, size_t first, size_t count, const float *block) {
    const joint_rows *rows = user;
    for (size_t i = 0; i < count; i++) {
        double sum = 0.0;
        for (size_t p = 0; p < rows->row; p++)
            sum += (double)block[i * rows->row + p] * block[i * rows->row + p];
        rows->energy[view * rows->texels + first + i] = (float)sum;
    }
}

static btf_result allocate(const enc_context *context, const enc_data *data, bool root,
                           joint_rows *out_rows) {
    *out_rows = (joint_rows){.context = context,
                             .data = data,
                             .texels = enc_data_texel_count(data),
                             .views = (size_t)data->n_views,
                             .row = 3 * (size_t)data->n_lights,
                             .root = root,
                             .scale = 1.0f,
                             .tile = enc_gemm_select()};
    out_rows->energy = malloc(out_rows->texels * out_rows->views * sizeof *out_rows->energy);
    out_rows->multiplier = malloc(out_rows->row * sizeof *out_rows->multiplier);
    if (!out_rows->energy || !out_rows->multiplier)
        return enc_fail(context, BTF_ERROR_MEMORY, "joint: out of memory for %zu points",
                        out_rows->texels * out_rows->views);
    for (size_t p = 0; p < out_rows->row; p++) {
        const float z = data->lights[p % (size_t)data->n_lights].xyz[2];
        out_rows->multiplier[p] = root ? sqrtf(z) : z;
    }
    return BTF_OK;
}

static btf_result find_energies(joint_rows *rows) {
    const btf_result result = joint_rows_pass(rows, add_energy, rows);
    for (size_t i = 0; result == BTF_OK && i < rows->texels * rows->views; i++)
        rows->total += rows->energy[i];
    return result;
}

btf_result joint_rows_init(const enc_context *context, const enc_data *data, bool root,
                           joint_rows *out_rows) {
    btf_result result = allocate(context, data, root, out_rows);
    if (result == BTF_OK)
        result = find_scale(out_rows);
    return result == BTF_OK ? find_energies(out_rows) : result;
}

btf_result joint_rows_init_scaled(const enc_context *context, const enc_data *data, bool root, float scale,
                                  joint_rows *out_rows) {
    btf_result result = allocate(context, data, root, out_rows);
    out_rows->scale = scale;
    return result == BTF_OK ? find_energies(out_rows) : result;
}

void joint_rows_clear(joint_rows *rows) {
    free(rows->energy);
    free(rows->multiplier);
    *rows = (joint_rows){0};
}
