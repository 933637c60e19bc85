/* Decoding at the samples, block by block. See measure.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "measure.h"

#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/math/clones.h"
#include "encoder/math/srgb.h"

#include <stdlib.h>
#include <string.h>

enum { BLOCK = 4 * ENC_GEMM_M }; /* texels that a thread decodes at a time */

/* Turns the channels of `n` samples into linear red, green and blue, clipped. */
ENC_CLONES static void compose(size_t n, const float *restrict y, const float *restrict c1,
                                      const float *restrict c2, float *restrict rgb) {
    const float third = 0.57735027f, half = 0.70710678f, sixth = 0.40824829f;
    for (size_t i = 0; i < n; i++) {
        const float a = third * y[i], b = half * c1[i], c = sixth * c2[i];
        const float root[3] = {(a + b) + c, a - (c + c), (a - b) + c};
        for (size_t channel = 0; channel < 3; channel++) {
            const float x = root[channel] > 0 ? root[channel] : 0.0f;
            rgb[channel * n + i] = x < 1 ? x * x : 1.0f;
        }
    }
}

static void add_errors(size_t n, const float *samples, const float *rgb, enc_factor_error *sum) {
    for (size_t i = 0; i < n; i++) {
        const double a = samples[i] < 1 ? samples[i] : 1.0f, e = a - rgb[i];
        const double s = enc_srgb_encode(samples[i]) - enc_srgb_encode(rgb[i]);
        sum->linear += e * e;
        sum->srgb += s * s;
    }
}

typedef struct decoder {
    const enc_factor_matrix *matrix;
    const enc_factor_codes *codes;
    const float *packed_w[ENC_FACTOR_CHANNELS]; /* of all columns; with a match, view by view */
} decoder;

/* The number of panels that w is packed in. */
static size_t panels_of_w(const decoder *d) {
    return d->matrix->match ? d->codes->views * enc_gemm_panels(d->codes->lights, ENC_GEMM_N)
                            : enc_gemm_panels(d->matrix->columns, ENC_GEMM_N);
}

static void pack_w(const decoder *d, int c, float *packed) {
    const enc_factor_channel *channel = &d->codes->channel[c];
    const size_t columns = d->matrix->columns, lights = d->codes->lights, rank = channel->rank;
    const size_t run = d->matrix->match ? lights : columns;
    for (size_t at = 0; at < columns; at += run) {
        enc_gemm_pack_columns(run, rank, channel->w + at, columns, ENC_GEMM_N, packed);
        packed += enc_gemm_panels(run, ENC_GEMM_N) * ENC_GEMM_N * rank;
    }
}

/* Gathers u of the sources of texels in one view, times their gains, in panels. */
static void gather_u(const decoder *d, int c, size_t view, size_t first, size_t count, float *left) {
    const enc_match *match = d->matrix->match;
    const enc_factor_channel *channel = &d->codes->channel[c];
    memset(left, 0, enc_gemm_panels(count, ENC_GEMM_M) * ENC_GEMM_M * channel->rank * sizeof *left);
    for (size_t i = 0; i < count; i++) {
        const size_t source = match->source[view * match->texels + first + i];
        const float gain = enc_match_gain(match, view, first + i), *u = channel->u + source;
        float *to = left + i / ENC_GEMM_M * ENC_GEMM_M * channel->rank + i % ENC_GEMM_M;
        for (size_t j = 0; j < channel->rank; j++) {
            to[j * ENC_GEMM_M] = gain * u[j * match->texels];
        }
    }
}

/* Decodes one channel of `count` texels: out [count][columns]. */
static void decode_channel(const decoder *d, int c, size_t first, size_t count, float *left, float *out) {
    const enc_factor_matrix *m = d->matrix;
    const size_t rank = d->codes->channel[c].rank, lights = d->codes->lights;
    if (!m->match) {
        enc_gemm_pack_columns(count, rank, d->codes->channel[c].u + first, m->texels, ENC_GEMM_M, left);
        enc_gemm_multiply(m->tile, count, m->columns, rank, left, d->packed_w[c], out, m->columns, 0);
        return;
    }
    const size_t panels = enc_gemm_panels(lights, ENC_GEMM_N);
    for (size_t v = 0; v < d->codes->views; v++) {
        gather_u(d, c, v, first, count, left);
        enc_gemm_multiply(m->tile, count, lights, rank, left, d->packed_w[c] + v * panels * ENC_GEMM_N * rank,
                          out + v * lights, m->columns, 0);
    }
}

static const enc_data *truth_of(const enc_factor_matrix *m) {
    return m->data->original ? m->data->original : m->data;
}

/* Adds the squared errors of a block of texels. work: left panels [BLOCK][most rank], three blocks, one
 * profile, samples. */
static btf_result measure_block(const decoder *d, size_t first, size_t count, size_t most, float *work,
                                enc_factor_error *sum) {
    const enc_factor_matrix *m = d->matrix;
    const size_t lights = d->codes->lights, one = BLOCK * m->columns;
    float *left = work, *blocks = work + BLOCK * most, *rgb = blocks + 3 * one;
    const enc_data *truth = truth_of(m);
    const float *samples;
    const btf_result result = enc_cancelled(m->context) ? BTF_ERROR_INTERRUPTED
                                                        : enc_data_texels(m->context, truth, first, count,
                                                                          rgb + 3 * lights, &samples);
    for (int c = 0; c < ENC_FACTOR_CHANNELS && result == BTF_OK; c++) {
        decode_channel(d, c, first, count, left, blocks + (size_t)c * one);
    }
    for (size_t i = 0; i < count * d->codes->views && result == BTF_OK; i++) {
        const float *y = blocks + i * lights;
        compose(lights, y, y + one, y + 2 * one, rgb);
        add_errors(3 * lights, samples + i * 3 * lights, rgb, sum);
    }
    return result;
}

static btf_result measure_all(const decoder *d, size_t most, size_t each, float *work,
                              enc_factor_error *sums) {
    const enc_factor_matrix *m = d->matrix;
    const size_t blocks = (m->texels + BLOCK - 1) / BLOCK;
    size_t begin, end; /* blocks of this rank */
    btf_result result = BTF_OK;
    enc_ranks_range(m->context, blocks, &begin, &end);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads)
    for (size_t b = begin; b < end; b++) {
        const size_t first = b * BLOCK, count = m->texels - first < BLOCK ? m->texels - first : BLOCK;
        const btf_result mine =
            measure_block(d, first, count, most, work + enc_thread_index() * each, &sums[b]);
        enc_keep_worse(&result, mine);
        enc_stage_step(m->context, count);
    }
    return result;
}

btf_result enc_factor_measure(const enc_factor_matrix *m, const enc_factor_codes *codes,
                              enc_factor_error *out_error) {
    decoder d = {.matrix = m, .codes = codes};
    float *packed[ENC_FACTOR_CHANNELS];
    bool room = true;
    size_t most = 1;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        const size_t rank = codes->channel[c].rank;
        most = rank > most ? rank : most;
        d.packed_w[c] = packed[c] = enc_gemm_alloc(panels_of_w(&d) * ENC_GEMM_N * rank);
        room = room && packed[c];
        if (packed[c]) {
            pack_w(&d, c, packed[c]);
        }
    }
    const size_t buffer = truth_of(m)->samples ? 0 : BLOCK * enc_data_texel_stride(m->data);
    const size_t each = (BLOCK * (most + 3 * m->columns) + 3 * codes->lights + buffer + 15) / 16 * 16;
    const size_t blocks = (m->texels + BLOCK - 1) / BLOCK;
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    /* by block, and added up in the order of blocks, whatever thread or rank measured which */
    enc_factor_error *sums = calloc(blocks, sizeof *sums);
    btf_result result = BTF_ERROR_MEMORY;
    *out_error = (enc_factor_error){0};
    if (room && work && sums) {
        result = measure_all(&d, most, each, work, sums);
    } else {
        enc_fail(m->context, result, "factors: out of memory");
    }
    result = enc_ranks_agree(m->context, result);
    if (result == BTF_OK) {
        result = enc_ranks_gather(m->context, result, sums, sizeof *sums, blocks);
    }
    for (size_t b = 0; b < blocks && result == BTF_OK; b++) {
        out_error->linear += sums[b].linear / (3.0 * (double)m->texels * (double)m->columns);
        out_error->srgb += sums[b].srgb / (3.0 * (double)m->texels * (double)m->columns);
    }
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        free(packed[c]);
    }
    free(work);
    free(sums);
    return result;
}
