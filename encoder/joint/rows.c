/* Rows of a joint fit: clipping, the square root, and passes over all data (see rows.h).
 *
 * Highlights: least squares on radiance that reaches 10 or 100 would spend everything on a few samples
 * (prototype: an unclipped set costs PCA 1.6 dB). Where some exceed 1, the scale is the 99.9th percentile
 * of the samples, at least 1 and at most 2^24; larger samples are clipped to it. Else it is the power of
 * two above the largest sample, at least 2^-24, so that dim data are no worse than bright ones; 1 where all
 * are black.
 *
 * SPDX-License-Identifier: MIT
 */
#include "rows.h"
#include "encoder/base/ranks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    HISTOGRAM = 4096, /* bins of the percentile: 64 a factor of two, from 1 to 2^64 */
    DIMMEST = 24      /* 2^-24 is the least scale of a file */
};

/* One block of data: samples of texel i and view first_view + j are at samples + i * pitch + j * row. */
typedef struct data_block {
    size_t count, pitch;
    const float *samples;
} data_block;

/* Reads `n_views` views from first_view on of the block of texels that begins at `first`. */
static btf_result load_block(const joint_rows *rows, size_t first, size_t first_view, size_t n_views,
                             float *buffer, data_block *out) {
    out->count = rows->texels - first < JOINT_BLOCK ? rows->texels - first : JOINT_BLOCK;
    return enc_data_texel_views(rows->context, rows->data, first, out->count, first_view, n_views, buffer,
                                &out->samples, &out->pitch);
}

/* The buffer of load_block; *out is NULL where it needs none. False when out of memory. */
static bool block_buffer(const joint_rows *rows, size_t n_views, float **out) {
    *out = rows->data->samples ? NULL : enc_gemm_alloc(JOINT_BLOCK * n_views * rows->row);
    return *out || rows->data->samples;
}

void joint_rows_views(const joint_rows *rows, size_t *out_first, size_t *out_end) {
    enc_ranks_range(rows->context, rows->views, out_first, out_end);
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

static btf_result no_memory(const joint_rows *rows) {
    return enc_fail(rows->context, BTF_ERROR_MEMORY, "joint: out of memory for a block of %d texels",
                    JOINT_BLOCK);
}

btf_result joint_rows_pass(const joint_rows *rows, joint_pass_fn fn, void *user) {
    const int threads = rows->context->threads;
    size_t begin, end;
    float *buffer;
    joint_rows_views(rows, &begin, &end);
    float *block = enc_gemm_alloc((size_t)threads * JOINT_BLOCK * rows->row);
    btf_result result = block_buffer(rows, end - begin, &buffer) && block ? BTF_OK : no_memory(rows);
    for (size_t first = 0; first < rows->texels && begin < end && result == BTF_OK; first += JOINT_BLOCK) {
        data_block data;
        result = enc_cancelled(rows->context) ? BTF_ERROR_INTERRUPTED
                                              : load_block(rows, first, begin, end - begin, buffer, &data);
        if (result != BTF_OK)
            break;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (size_t view = begin; view < end; view++) {
            float *mine = block + (size_t)enc_thread_index() * JOINT_BLOCK * rows->row;
            for (size_t i = 0; i < data.count; i++)
                transform(rows, data.samples + i * data.pitch + (view - begin) * rows->row,
                          mine + i * rows->row);
            fn(user, view, first, data.count, mine);
        }
    }
    free(block);
    free(buffer);
    return result;
}

/* The arguments of joint_rows_pick. */
typedef struct picker {
    const joint_rows *rows;
    joint_want_fn want;
    joint_row_fn fn;
    void *user;
} picker;

/* The wanted rows of one view and block. Where `whole` is NULL, each is read alone, to `one`. */
static btf_result pick_block(const picker *p, size_t view, size_t first, size_t count,
                             const data_block *whole, float *one, float *row) {
    const joint_rows *rows = p->rows;
    btf_result result = BTF_OK;
    for (size_t x = first; x < first + count && result == BTF_OK; x++) {
        const float *samples;
        size_t pitch;
        if (!p->want(p->user, view, x))
            continue;
        if (whole)
            samples = whole->samples + (x - first) * whole->pitch + view * rows->row;
        else
            result = enc_data_texel_views(rows->context, rows->data, x, 1, view, 1, one, &samples, &pitch);
        if (result != BTF_OK)
            break;
        transform(rows, samples, row);
        p->fn(p->user, view, x, row);
    }
    return result;
}

btf_result joint_rows_pick(const joint_rows *rows, joint_want_fn want, joint_row_fn fn, void *user) {
    const picker p = {rows, want, fn, user};
    const int threads = rows->context->threads;
    /* a rank wants few rows of a block: it does not read the rest of it */
    const bool whole = rows->data->samples || enc_ranks_count(rows->context) == 1;
    float *buffer = NULL, *scratch = enc_gemm_alloc((size_t)threads * 2 * rows->row);
    btf_result result =
        scratch && (!whole || block_buffer(rows, rows->views, &buffer)) ? BTF_OK : no_memory(rows);
    for (size_t first = 0; first < rows->texels && result == BTF_OK; first += JOINT_BLOCK) {
        const size_t count = rows->texels - first < JOINT_BLOCK ? rows->texels - first : JOINT_BLOCK;
        data_block data;
        if (enc_cancelled(rows->context))
            result = BTF_ERROR_INTERRUPTED;
        else if (whole)
            result = load_block(rows, first, 0, rows->views, buffer, &data);
        if (result != BTF_OK)
            break;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (size_t view = 0; view < rows->views; view++) {
            float *one = scratch + enc_thread_index() * 2 * rows->row;
            const btf_result mine =
                pick_block(&p, view, first, count, whole ? &data : NULL, one, one + rows->row);
            if (mine != BTF_OK) {
#pragma omp atomic write
                result = mine;
            }
        }
    }
    free(scratch);
    free(buffer);
    return result;
}

/* Index of the bin of a sample above 1. */
static size_t bin_of(float sample) {
    const double position = log2((double)sample) * 64.0;
    return position < HISTOGRAM - 1 ? (size_t)position : HISTOGRAM - 1;
}

/* The exponent of the power of two above a sample of at most 1, negated: 0 .. DIMMEST. */
static int dimness(float sample) {
    int exponent;
    frexpf(sample, &exponent);
    return exponent >= 0 ? 0 : exponent < -DIMMEST ? DIMMEST : -exponent;
}

/* The 99.9th percentile of all samples where it is above 1, the upper edge of its bin; else the power of
 * two above the largest. */
static btf_result find_scale(joint_rows *rows) {
    uint64_t histogram[HISTOGRAM + DIMMEST + 1] = {0}, *const dim = histogram + HISTOGRAM;
    size_t begin, end;
    float *buffer, largest = 0;
    joint_rows_views(rows, &begin, &end);
    btf_result result = block_buffer(rows, end - begin, &buffer) ? BTF_OK : no_memory(rows);
    for (size_t first = 0; first < rows->texels && begin < end && result == BTF_OK; first += JOINT_BLOCK) {
        data_block data;
        result = load_block(rows, first, begin, end - begin, buffer, &data);
        for (size_t i = 0; result == BTF_OK && i < data.count; i++)
            for (size_t p = 0; p < (end - begin) * rows->row; p++) {
                const float sample = data.samples[i * data.pitch + p];
                largest = fmaxf(largest, sample);
                if (sample > 1.0f)
                    histogram[bin_of(sample)]++;
            }
    }
    free(buffer);
    if (largest > 0)
        dim[dimness(largest)]++; /* one a process */
    result = enc_ranks_sum(rows->context, result, histogram, HISTOGRAM + DIMMEST + 1);
    const uint64_t kept = rows->texels * rows->views * rows->row / 1000;
    uint64_t above = 0;
    size_t bin = HISTOGRAM;
    for (; bin > 0 && above + histogram[bin - 1] <= kept; bin--)
        above += histogram[bin - 1];
    int low = 0;
    while (low <= DIMMEST && dim[low] == 0)
        low++;
    const double scale = exp2(fmin((double)bin / 64.0, 24.0)); /* what radianceScale may be */
    rows->scale = (float)(low <= DIMMEST ? ldexp(scale, -low) : scale);
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
    btf_result result = joint_rows_pass(rows, add_energy, rows);
    result = joint_rows_gather(rows, result, rows->energy, rows->texels * sizeof *rows->energy);
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
    const btf_result result = allocate(context, data, root, out_rows);
    out_rows->scale = scale;
    return result == BTF_OK ? find_energies(out_rows) : result;
}

btf_result joint_rows_gather(const joint_rows *rows, btf_result result, void *array, size_t view_bytes) {
    return enc_ranks_gather(rows->context, result, array, view_bytes, rows->views);
}

void joint_rows_clear(joint_rows *rows) {
    free(rows->energy);
    free(rows->multiplier);
    *rows = (joint_rows){0};
}
