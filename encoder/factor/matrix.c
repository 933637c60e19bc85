/* Products of the split samples with factors. See matrix.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "matrix.h"

#include "encoder/base/stage.h"
#include "encoder/math/clones.h"
#include "rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    BLOCK = 256,  /* texels whose product with u is added at a time */
    DEPTH = 1024, /* columns that a product with w adds at a time: a panel of them stays in the cache */
    SPAN = 4 * ENC_GEMM_N, /* columns of a block that a thread takes at a time */
};

enc_factor_matrix enc_factor_matrix_of(const enc_context *context, const enc_data *data) {
    return (enc_factor_matrix){.context = context,
                               .data = data,
                               .texels = enc_data_texel_count(data),
                               .columns = (size_t)data->n_views * (size_t)data->n_lights,
                               .most = 0x1p24f,
                               .tile = enc_gemm_select()};
}

/* A bin of a float of at least 1: its exponent and six bits of its mantissa. */
enum { ONE = 0x3F800000, BIN = 1 << 17, BINS = (0x7F800000 - ONE) / BIN, DRAWN_TEXELS = 512 };

static void count_highlights(const float *samples, size_t count, uint64_t bins[BINS]) {
    for (size_t i = 0; i < count; i++) {
        const float size = fabsf(samples[i]);
        if (size >= 1) {
            uint32_t bits;
            memcpy(&bits, &size, sizeof bits);
            bins[bits < 0x7F800000 ? (bits - ONE) / BIN : BINS - 1]++;
        }
    }
}

/* The upper edge of the bin below which all but `above` of the counted values lie; at least 1. */
static float percentile(const uint64_t bins[BINS], uint64_t above) {
    int bin = BINS;
    for (uint64_t sum = 0; bin > 0 && sum + bins[bin - 1] <= above; bin--) {
        sum += bins[bin - 1];
    }
    const uint32_t bits = ONE + (uint32_t)bin * BIN;
    float edge;
    memcpy(&edge, &bits, sizeof edge);
    return edge;
}

btf_result enc_factor_clip(enc_factor_matrix *m) {
    const size_t stride = enc_data_texel_stride(m->data), all = enc_data_texel_count(m->data);
    const size_t texels = all < DRAWN_TEXELS ? all : DRAWN_TEXELS;
    uint64_t *bins = calloc(BINS, sizeof *bins);
    float *buffer = malloc(stride * sizeof *buffer);
    btf_result result = bins && buffer ? BTF_OK : enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory");
    for (size_t i = 0; result == BTF_OK && i < texels; i++) {
        const float *samples;
        result = enc_data_texels(m->context, m->data, i * all / texels, 1, buffer, &samples);
        if (result == BTF_OK) {
            count_highlights(samples, stride, bins);
        }
    }
    if (result == BTF_OK) {
        const float most = ENC_FACTOR_HIGHLIGHTS * percentile(bins, texels * stride / 1000);
        m->most = most < 0x1p24f ? most : 0x1p24f;
    }
    free(buffer);
    free(bins);
    return result;
}

/* The root of a value, of its sign: fitted values at the nodes (nodes/apply.h) may be negative. */
static inline float signed_root(float x, float most) {
    const float size = fabsf(x);
    return copysignf(sqrtf(size < most ? size : most), x);
}

ENC_CLONES static void split_profile(size_t n, float most, const float *restrict rgb, float *restrict y,
                                     float *restrict c1, float *restrict c2) {
    const float third = 0.57735027f, half = 0.70710678f, sixth = 0.40824829f;
    for (size_t i = 0; i < n; i++) {
        const float r = signed_root(rgb[i], most), g = signed_root(rgb[n + i], most),
                    b = signed_root(rgb[2 * n + i], most);
        y[i] = third * ((r + g) + b);
        c1[i] = half * (r - b);
        c2[i] = sixth * ((r - g) + (b - g));
    }
}

/* Adds `gain` times the roots of n samples, split into channels. */
ENC_CLONES static void add_profile(size_t n, float most, float gain, const float *restrict rgb,
                                   float *restrict y, float *restrict c1, float *restrict c2) {
    const float third = gain * 0.57735027f, half = gain * 0.70710678f, sixth = gain * 0.40824829f;
    for (size_t i = 0; i < n; i++) {
        const float r = signed_root(rgb[i], most), g = signed_root(rgb[n + i], most),
                    b = signed_root(rgb[2 * n + i], most);
        y[i] += third * ((r + g) + b);
        c1[i] += half * (r - b);
        c2[i] += sixth * ((r - g) + (b - g));
    }
}

void enc_factor_split_profile(const enc_factor_matrix *m, size_t texel, size_t view, float *const out[3]) {
    const size_t lights = (size_t)m->data->n_lights;
    const float *rgb = m->data->samples + texel * enc_data_texel_stride(m->data) + view * 3 * lights;
    split_profile(lights, m->most, rgb, out[0], out[1], out[2]);
}

/* The views that are loaded; the columns of others stay as they are. */
typedef struct view_range {
    size_t first, end;
} view_range;

/* Makes the row of a source: the sum of the samples of the texels that refer to it, times their gains. */
static void gather_row(const enc_factor_matrix *m, size_t source, view_range views, float *const out[3]) {
    const enc_match *match = m->match;
    const size_t lights = (size_t)m->data->n_lights, stride = enc_data_texel_stride(m->data);
    for (int c = 0; c < 3; c++) {
        memset(out[c] + views.first * lights, 0, (views.end - views.first) * lights * sizeof(float));
    }
    for (size_t v = views.first; v < views.end; v++) {
        const size_t i = source * match->views + v, at = v * lights;
        for (uint32_t k = match->first[i]; k < match->first[i + 1]; k++) {
            const size_t texel = match->user[k];
            add_profile(lights, m->most, enc_match_gain(match, v, texel),
                        m->data->samples + texel * stride + 3 * at, out[0] + at, out[1] + at, out[2] + at);
        }
    }
}

static void split(const enc_factor_matrix *m, size_t count, const float *samples, view_range views,
                  float *const out[3]) {
    const size_t lights = (size_t)m->data->n_lights;
    for (size_t i = 0; i < count; i++) {
        for (size_t v = views.first; v < views.end; v++) {
            const size_t at = (i * (size_t)m->data->n_views + v) * lights;
            split_profile(lights, m->most, samples + 3 * at, out[0] + at, out[1] + at, out[2] + at);
        }
    }
}

/* Reads texels of the data and splits them in some views. buffer: room for their samples where the data are not in
 * memory. */
static btf_result load_run(const enc_factor_matrix *m, size_t first, size_t count, view_range views,
                           float *buffer, float *const out[3]) {
    const float *samples;
    if (m->match) {
        for (size_t i = 0; i < count; i++) {
            gather_row(m, first + i, views,
                       (float *const[3]){out[0] + i * m->columns, out[1] + i * m->columns, out[2] + i * m->columns});
        }
        return enc_cancelled(m->context) ? BTF_ERROR_INTERRUPTED : BTF_OK;
    }
    const btf_result result = enc_cancelled(m->context)
                                  ? BTF_ERROR_INTERRUPTED
                                  : enc_data_texels(m->context, m->data, first, count, buffer, &samples);
    if (result == BTF_OK) {
        split(m, count, samples, views, out);
    }
    return result;
}

/* load_run for rows of the matrix, which may be a list of texels. */
static btf_result load(const enc_factor_matrix *m, size_t first, size_t count, view_range views,
                       float *buffer, float *const out[3]) {
    btf_result result = BTF_OK;
    if (!m->list) {
        return load_run(m, first, count, views, buffer, out);
    }
    for (size_t i = 0; i < count && result == BTF_OK; i++) {
        const size_t at = i * m->columns;
        result = load_run(m, m->list[first + i], 1, views, buffer,
                          (float *const[3]){out[0] + at, out[1] + at, out[2] + at});
    }
    return result;
}

static view_range all_views(const enc_factor_matrix *m) {
    return (view_range){0, (size_t)m->data->n_views};
}

static size_t buffer_floats(const enc_factor_matrix *m, size_t texels) {
    return m->data->samples ? 0 : texels * enc_data_texel_stride(m->data);
}

static size_t padded(size_t rank) {
    return enc_gemm_panels(rank, ENC_GEMM_M) * ENC_GEMM_M;
}

static size_t padded_ranks(const enc_factor_set *f) {
    return padded(f->rank[0]) + padded(f->rank[1]) + padded(f->rank[2]);
}

static btf_result no_memory(const enc_factor_matrix *m, const enc_factor_set *f) {
    return enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory for %zu components",
                    f->rank[0] + f->rank[1] + f->rank[2]);
}

/* Packs w as [channel][chunk of DEPTH columns][panel]. */
static void pack_w(const enc_factor_matrix *m, const enc_factor_set *w, float *packed) {
    const size_t chunks = (m->columns + DEPTH - 1) / DEPTH;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        const size_t rows = padded(w->rank[c]);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads)
        for (size_t chunk = 0; chunk < chunks; chunk++) {
            const size_t at = chunk * DEPTH, depth = m->columns - at < DEPTH ? m->columns - at : DEPTH;
            enc_gemm_pack_rows(w->rank[c], depth, w->factor[c] + at, m->columns, ENC_GEMM_M,
                               packed + at * rows);
        }
        packed += rows * m->columns;
    }
}

/* Completes a product with factors, [rank][count], of which each rank has some columns. */
static btf_result complete(const enc_factor_matrix *m, btf_result result, const enc_factor_set *factors,
                           size_t count, size_t unit, const enc_factor_set *out) {
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        result = enc_rows_complete(m->context, result, factors->rank[c], count, unit, sizeof(float),
                                   out->factor[c]);
    }
    return result;
}

/* Multiplies a panel of texels with w; `split` is as load gives it. */
static void multiply_texels(const enc_factor_matrix *m, const enc_factor_set *w, const float *packed,
                            size_t first, size_t count, float *const split[3], float *panel,
                            const enc_factor_set *out) {
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        const size_t rows = padded(w->rank[c]);
        for (size_t at = 0; at < m->columns && rows > 0; at += DEPTH) {
            const size_t depth = m->columns - at < DEPTH ? m->columns - at : DEPTH;
            enc_gemm_pack_rows(count, depth, split[c] + at, m->columns, ENC_GEMM_N, panel);
            enc_gemm_multiply(m->tile, w->rank[c], count, depth, packed + at * rows, panel,
                              out->factor[c] + first, m->texels, at > 0);
        }
        packed += rows * m->columns;
    }
}

btf_result enc_factor_times_w(const enc_factor_matrix *m, const enc_factor_set *w,
                              const enc_factor_set *out) {
    const size_t samples = buffer_floats(m, ENC_GEMM_N), one = (size_t)ENC_GEMM_N * m->columns;
    const size_t each = (samples + 3 * one + DEPTH * ENC_GEMM_N + 15) / 16 * 16;
    float *packed = enc_gemm_alloc(padded_ranks(w) * m->columns);
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    size_t begin, end;
    btf_result result = packed && work ? BTF_OK : no_memory(m, w);
    enc_rows_range(m->context, m->texels, ENC_GEMM_N, &begin, &end);
    if (result == BTF_OK) {
        pack_w(m, w, packed);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads)
        for (size_t first = begin; first < end; first += ENC_GEMM_N) {
            const size_t count = end - first < ENC_GEMM_N ? end - first : ENC_GEMM_N;
            float *panel = work + enc_thread_index() * each, *split = panel + DEPTH * ENC_GEMM_N;
            float *const channels[3] = {split, split + one, split + 2 * one};
            const btf_result mine = load(m, first, count, all_views(m), split + 3 * one, channels);
            if (mine == BTF_OK) {
                multiply_texels(m, w, packed, first, count, channels, panel, out);
            } else {
                enc_keep_worse(&result, mine);
            }
            enc_stage_step(m->context, count);
        }
    }
    free(packed);
    free(work);
    return complete(m, result, w, m->texels, ENC_GEMM_N, out);
}

/* Adds the contribution of a block of texels to the columns at .. at + span - 1 of the product. */
static void multiply_columns(const enc_factor_matrix *m, const enc_factor_set *u, const float *packed,
                             size_t count, size_t at, size_t span, float *const split[3], float *panel,
                             const enc_factor_set *out) {
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        if (u->rank[c] > 0) {
            enc_gemm_pack_columns(span, count, split[c] + at, m->columns, ENC_GEMM_N, panel);
            enc_gemm_multiply(m->tile, u->rank[c], span, count, packed, panel, out->factor[c] + at,
                              m->columns, 1);
        }
        packed += padded(u->rank[c]) * BLOCK;
    }
}

/* Adds a block of texels to the columns of this rank, for which the rank reads every texel; where samples
 * lie in memory, only the views that its columns belong to. */
static btf_result add_block(const enc_factor_matrix *m, const enc_factor_set *u, size_t first, size_t count,
                            float *const split[3], float *buffer, float *packed, float *panels,
                            const enc_factor_set *out) {
    const size_t stride = enc_data_texel_stride(m->data), lights = (size_t)m->data->n_lights;
    size_t begin, end;
    enc_rows_range(m->context, m->columns, SPAN, &begin, &end);
    const view_range views = {begin / lights, (end + lights - 1) / lights};
    if (begin == end) {
        return BTF_OK;
    }
    btf_result result = BTF_OK;
#pragma omp parallel for schedule(dynamic, 8) num_threads(m->context->threads)
    for (size_t i = 0; i < count; i++) {
        float *const row[3] = {split[0] + i * m->columns, split[1] + i * m->columns,
                               split[2] + i * m->columns};
        const btf_result mine =
            load(m, first + i, 1, views, m->data->samples ? buffer : buffer + i * stride, row);
        enc_keep_worse(&result, mine);
    }
    if (result != BTF_OK) {
        return result;
    }
    float *to = packed;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        enc_gemm_pack_rows(u->rank[c], count, u->factor[c] + first, m->texels, ENC_GEMM_M, to);
        to += padded(u->rank[c]) * BLOCK;
    }
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads)
    for (size_t at = begin; at < end; at += SPAN) {
        multiply_columns(m, u, packed, count, at, end - at < SPAN ? end - at : SPAN, split,
                         panels + enc_thread_index() * SPAN * BLOCK, out);
    }
    return BTF_OK;
}

btf_result enc_factor_times_u(const enc_factor_matrix *m, const enc_factor_set *u,
                              const enc_factor_set *out) {
    const size_t one = (size_t)BLOCK * m->columns;
    float *split = enc_gemm_alloc(3 * one), *buffer = enc_gemm_alloc(buffer_floats(m, BLOCK));
    float *packed = enc_gemm_alloc(padded_ranks(u) * BLOCK);
    float *panels = enc_gemm_alloc((size_t)m->context->threads * SPAN * BLOCK);
    float *const channels[3] = {split, split + one, split + 2 * one};
    btf_result result = split && buffer && packed && panels ? BTF_OK : no_memory(m, u);
    for (int c = 0; c < ENC_FACTOR_CHANNELS && result == BTF_OK; c++) {
        if (u->rank[c] > 0) {
            memset(out->factor[c], 0, u->rank[c] * m->columns * sizeof(float));
        }
    }
    for (size_t first = 0; first < m->texels && result == BTF_OK; first += BLOCK) {
        const size_t count = m->texels - first < BLOCK ? m->texels - first : BLOCK;
        result = add_block(m, u, first, count, channels, buffer, packed, panels, out);
        enc_stage_step(m->context, count);
    }
    free(split);
    free(buffer);
    free(packed);
    free(panels);
    return complete(m, result, u, m->columns, SPAN, out);
}

/* Adds to sums [channel] the squared residual of a panel of rows; work: u, samples, their channels and the
 * product. */
static btf_result add_residual(const enc_factor_matrix *m, const enc_factor_set *u,
                               float *const packed_w[3], const uint8_t *of_columns, size_t first,
                               size_t most, float *work, double *sums) {
    const size_t one = ENC_GEMM_M * m->columns;
    const size_t count = m->texels - first < ENC_GEMM_M ? m->texels - first : ENC_GEMM_M;
    float *left = work, *split = left + ENC_GEMM_M * most, *product = split + 3 * one;
    float *const channels[3] = {split, split + one, split + 2 * one};
    const btf_result result = load(m, first, count, all_views(m), product + one, channels);
    for (int c = 0; c < ENC_FACTOR_CHANNELS && result == BTF_OK; c++) {
        memset(product, 0, one * sizeof *product);
        if (u->rank[c] > 0) {
            enc_gemm_pack_columns(count, u->rank[c], u->factor[c] + first, m->texels, ENC_GEMM_M, left);
            enc_gemm_multiply(m->tile, count, m->columns, u->rank[c], left, packed_w[c], product,
                              m->columns, 0);
        }
        for (size_t i = 0; i < count * m->columns; i++) {
            const double x = (double)channels[c][i] - product[i];
            sums[c] += of_columns[i % m->columns] ? x * x : 0.0;
        }
    }
    return result;
}

btf_result enc_factor_residual(const enc_factor_matrix *m, const enc_factor_set *u, const enc_factor_set *w,
                               const uint8_t *of_columns, double out_sums[3]) {
    const size_t panels = enc_gemm_panels(m->texels, ENC_GEMM_M);
    float *packed[3] = {0};
    double(*sums)[3] = calloc(panels, sizeof *sums);
    size_t begin, end; /* panels of this rank */
    enc_ranks_range(m->context, panels, &begin, &end);
    size_t most = 0;
    bool room = sums;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        most = u->rank[c] > most ? u->rank[c] : most;
        packed[c] = enc_gemm_alloc((m->columns + ENC_GEMM_N) * w->rank[c]);
        room = room && packed[c];
        if (packed[c] && w->rank[c] > 0) {
            enc_gemm_pack_columns(m->columns, w->rank[c], w->factor[c], m->columns, ENC_GEMM_N, packed[c]);
        }
        out_sums[c] = 0;
    }
    const size_t each =
        (ENC_GEMM_M * (most + 4 * m->columns) + buffer_floats(m, ENC_GEMM_M) + 15) / 16 * 16;
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    btf_result result = room && work ? BTF_OK : no_memory(m, w);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads) if (room && work)
    for (size_t p = begin; p < (room && work ? end : begin); p++) {
        const btf_result mine = add_residual(m, u, packed, of_columns, p * ENC_GEMM_M, most,
                                             work + enc_thread_index() * each, sums[p]);
        enc_keep_worse(&result, mine);
        enc_stage_step(m->context, ENC_GEMM_M);
    }
    result = enc_ranks_agree(m->context, result);
    if (result == BTF_OK) {
        result = enc_ranks_gather(m->context, result, sums, sizeof *sums, panels);
    }
    for (size_t p = 0; p < panels && result == BTF_OK; p++) {
        for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
            out_sums[c] += sums[p][c];
        }
    }
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        free(packed[c]);
    }
    free(sums);
    free(work);
    return result;
}

uint64_t enc_factor_product_memory(size_t columns, size_t rank, int threads) {
    const uint64_t rows = rank + 3 * ENC_GEMM_M, t = (uint64_t)threads;
    const uint64_t by_w = rows * columns + t * (6 * (uint64_t)ENC_GEMM_N * columns + DEPTH * ENC_GEMM_N);
    const uint64_t by_u = 6 * (uint64_t)BLOCK * columns + rows * BLOCK + t * SPAN * BLOCK;
    return sizeof(float) * (by_w > by_u ? by_w : by_u);
}
