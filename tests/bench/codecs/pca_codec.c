/* Rounded factors as codecs, whole and cluster by cluster. See pca.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "pca.h"

#include "encoder/math/gemm.h"
#include "encoder/math/linear.h"
#include "encoder/model/pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    CLUSTER_STEPS = 8,  /* rounds in which texels choose their cluster anew */
    CLUSTER_SPACE = 64, /* global components that span the space in which they choose */
};

size_t pca_bytes(const enc_data *data, pca_number number, size_t clusters, size_t rank) {
    const size_t texels = enc_data_texel_count(data), columns = clusters * enc_data_texel_stride(data);
    const size_t numbers = rank * (texels + columns);
    const size_t scales = number == PCA_BYTE ? 4 * rank * (1 + clusters) : 0;
    return numbers * (number == PCA_HALF ? 2 : 1) + scales + (clusters > 1 ? texels : 0);
}

size_t pca_rank_for(const enc_data *data, pca_number number, size_t clusters, size_t budget) {
    size_t rank = 0;
    while (pca_bytes(data, number, clusters, rank + 1) <= budget) {
        rank++;
    }
    return rank;
}

static float half_value(uint16_t half) {
    const int exponent = half >> 10 & 31;
    const float mantissa = (float)(half & 1023);
    const float value = exponent ? ldexpf(1024.0f + mantissa, exponent - 25) : ldexpf(mantissa, -24);
    return half >> 15 ? -value : value;
}

/* Rounds `count` numbers, `pitch` apart, which share a scale. */
static void round_numbers(pca_number number, size_t count, size_t pitch, float *x) {
    float range = 0;
    for (size_t i = 0; i < count; i++) {
        range = fmaxf(range, fabsf(x[i * pitch]));
    }
    const float step = range / 127;
    for (size_t i = 0; i < count; i++) {
        float *value = x + i * pitch;
        if (number == PCA_HALF) {
            *value = half_value(enc_half_from_float(*value));
        } else {
            *value = step > 0 ? rintf(*value / step) * step : 0.0f;
        }
    }
}

static void round_codec(const enc_context *context, pca_number number, pca_codec *codec) {
    const size_t texels = enc_data_texel_count(codec->data), rows = codec->clusters * codec->rank;
    for (size_t j = 0; j < codec->rank; j++) {
        round_numbers(number, texels, codec->rank, codec->u + j);
    }
#pragma omp parallel for num_threads(context->threads)
    for (size_t j = 0; j < rows; j++) {
        round_numbers(number, codec->columns, 1, codec->v + j * codec->columns);
    }
}

static btf_result codec_init(const enc_context *context, const pca_factors *factors, pca_number number,
                             size_t clusters, size_t rank, pca_codec *out_codec) {
    *out_codec = (pca_codec){.data = factors->data,
                             .coding = factors->coding,
                             .columns = factors->columns,
                             .rank = rank,
                             .clusters = clusters,
                             .order = calloc(factors->texels, sizeof(uint32_t)),
                             .first = calloc(clusters + 1, sizeof(size_t)),
                             .u = calloc(factors->texels * rank + 1, sizeof(float)),
                             .v = calloc(clusters * rank * factors->columns + 1, sizeof(float)),
                             .bytes = pca_bytes(factors->data, number, clusters, rank)};
    if (out_codec->order && out_codec->first && out_codec->u && out_codec->v) {
        return BTF_OK;
    }
    pca_codec_clear(out_codec);
    return enc_fail(context, BTF_ERROR_MEMORY, "pca: out of memory for %zu components", rank);
}

void pca_codec_clear(pca_codec *codec) {
    free(codec->order);
    free(codec->first);
    free(codec->u);
    free(codec->v);
    *codec = (pca_codec){0};
}

btf_result pca_encode(const enc_context *context, const pca_factors *factors, pca_number number,
                      size_t rank, pca_codec *out_codec) {
    rank = rank < factors->rank ? rank : factors->rank;
    const btf_result result = codec_init(context, factors, number, 1, rank, out_codec);
    if (result != BTF_OK) {
        return result;
    }
    out_codec->first[1] = factors->texels;
    for (size_t i = 0; i < factors->texels; i++) {
        out_codec->order[i] = (uint32_t)i;
        memcpy(out_codec->u + i * rank, factors->u + i * factors->rank, rank * sizeof(float));
    }
    memcpy(out_codec->v, factors->v, rank * factors->columns * sizeof(float));
    round_codec(context, number, out_codec);
    return BTF_OK;
}

/* --- clusters of texels in the space of the leading components --- */

typedef struct grouping {
    const pca_factors *factors;
    size_t space, clusters, rank; /* rank of a cluster's basis in that space */
    uint8_t *cluster;             /* [texel] */
    float *basis;                 /* [cluster][rank][space] */
    double *work;                 /* [thread][2 space^2 + space] */
    double *distance;             /* [texel] */
} grouping;

/* Start values: texels that are far apart, each the farthest from those before (T. Gonzalez, 1985); every other texel
 * joins the nearest. */
static void far_starts(const grouping *g) {
    const pca_factors *f = g->factors;
    size_t centre = 0;
    for (size_t i = 0; i < f->texels; i++) {
        g->distance[i] = HUGE_VAL;
    }
    for (size_t c = 0; c < g->clusters; c++) {
        size_t next = 0;
        for (size_t i = 0; i < f->texels; i++) {
            double sum = 0;
            for (size_t p = 0; p < g->space; p++) {
                const double d = (double)f->u[i * f->rank + p] - f->u[centre * f->rank + p];
                sum += d * d;
            }
            if (sum < g->distance[i]) {
                g->distance[i] = sum;
                g->cluster[i] = (uint8_t)c;
            }
            if (g->distance[i] > g->distance[next]) {
                next = i;
            }
        }
        centre = next;
    }
}

static void find_basis(const grouping *g, size_t c) {
    const pca_factors *f = g->factors;
    const size_t n = g->space;
    double *a = g->work + enc_thread_index() * (2 * n * n + n), *vectors = a + n * n,
           *values = vectors + n * n;
    memset(a, 0, n * n * sizeof *a);
    for (size_t i = 0; i < f->texels; i++) {
        const float *u = f->u + i * f->rank;
        for (size_t p = 0; p < n && g->cluster[i] == c; p++) {
            for (size_t q = 0; q < n; q++) {
                a[p * n + q] += (double)u[p] * u[q];
            }
        }
    }
    enc_eigen(n, a, values, vectors);
    for (size_t i = 0; i < g->rank * n; i++) {
        g->basis[c * g->rank * n + i] = (float)vectors[i];
    }
}

/* The cluster whose basis holds most of a texel's energy. */
static size_t best_cluster(const grouping *g, size_t texel) {
    const float *u = g->factors->u + texel * g->factors->rank;
    double most = -1;
    size_t best = 0;
    for (size_t c = 0; c < g->clusters; c++) {
        double energy = 0;
        for (size_t j = 0; j < g->rank; j++) {
            const float *row = g->basis + (c * g->rank + j) * g->space;
            double dot = 0;
            for (size_t p = 0; p < g->space; p++) {
                dot += (double)row[p] * u[p];
            }
            energy += dot * dot;
        }
        if (energy > most) {
            most = energy;
            best = c;
        }
    }
    return best;
}

static void find_clusters(const enc_context *context, const grouping *g) {
    far_starts(g);
    for (int step = 0; step < CLUSTER_STEPS; step++) {
#pragma omp parallel for schedule(dynamic) num_threads(context->threads)
        for (size_t c = 0; c < g->clusters; c++) {
            find_basis(g, c);
        }
#pragma omp parallel for num_threads(context->threads)
        for (size_t i = 0; i < g->factors->texels; i++) {
            g->cluster[i] = (uint8_t)best_cluster(g, i);
        }
    }
}

/* Factorises the texels of one cluster in full into the codec. */
static btf_result factorise_cluster(const enc_context *context, size_t c, pca_codec *codec) {
    const size_t first = codec->first[c], count = codec->first[c + 1] - first;
    pca_factors f;
    if (count == 0) {
        return BTF_OK;
    }
    const btf_result result = pca_factorise_texels(context, codec->data, codec->order + first, count,
                                                   codec->coding, codec->rank, &f);
    if (result != BTF_OK) {
        return result;
    }
    for (size_t i = 0; i < count; i++) {
        memcpy(codec->u + (first + i) * codec->rank, f.u + i * f.rank, f.rank * sizeof(float));
    }
    memcpy(codec->v + c * codec->rank * codec->columns, f.v, f.rank * codec->columns * sizeof(float));
    pca_factors_clear(&f);
    return BTF_OK;
}

btf_result pca_encode_clusters(const enc_context *context, const pca_factors *factors, pca_number number,
                               size_t clusters, size_t rank, pca_codec *out_codec) {
    const size_t n = factors->rank < CLUSTER_SPACE ? factors->rank : CLUSTER_SPACE,
                 texels = factors->texels;
    if (clusters < 1 || clusters > 256) {
        return enc_fail(context, BTF_ERROR_USAGE, "pca: %zu clusters, expected 1 to 256", clusters);
    }
    btf_result result = codec_init(context, factors, number, clusters, rank, out_codec);
    if (result != BTF_OK) {
        return result;
    }
    grouping g = {.factors = factors, .space = n, .clusters = clusters, .rank = rank < n ? rank : n};
    g.cluster = calloc(texels, 1);
    g.basis = malloc((clusters * g.rank * n + 1) * sizeof *g.basis);
    g.work = malloc((2 * n * n + n + 1) * (size_t)context->threads * sizeof *g.work);
    g.distance = malloc(texels * sizeof *g.distance);
    if (g.cluster && g.basis && g.work && g.distance) {
        find_clusters(context, &g);
        size_t next = 0;
        for (size_t c = 0; c < clusters; c++) {
            for (size_t i = 0; i < texels; i++) {
                if (g.cluster[i] == c) {
                    out_codec->order[next++] = (uint32_t)i;
                }
            }
            out_codec->first[c + 1] = next;
        }
    } else {
        result = enc_fail(context, BTF_ERROR_MEMORY, "pca: out of memory for %zu clusters", clusters);
    }
    for (size_t c = 0; c < clusters && result == BTF_OK; c++) {
        result = factorise_cluster(context, c, out_codec);
    }
    free(g.cluster);
    free(g.basis);
    free(g.work);
    free(g.distance);
    if (result == BTF_OK) {
        round_codec(context, number, out_codec);
    } else {
        pca_codec_clear(out_codec);
    }
    return result;
}

/* --- decoding --- */

static float decode_value(pca_coding coding, float y) {
    if (!(y > 0)) {
        return 0;
    }
    if (coding == PCA_LINEAR) {
        return y;
    }
    if (coding == PCA_SQRT) {
        return y * y;
    }
    return y <= 0.04045f ? y / 12.92f : powf((y + 0.055f) / 1.055f, 2.4f);
}

static btf_result decode_view(const void *user, int view, float *out) {
    const pca_codec *codec = user;
    const size_t lights = (size_t)codec->data->n_lights, texels = enc_data_texel_count(codec->data);
    const size_t n = 3 * lights, panels = enc_gemm_panels(n, ENC_GEMM_N);
    const enc_gemm_tile tile = enc_gemm_select();
    float *left = enc_gemm_alloc(ENC_GEMM_M * (codec->rank + 1)), *rows = enc_gemm_alloc(ENC_GEMM_M * n);
    float *right = enc_gemm_alloc(panels * ENC_GEMM_N * (codec->rank + 1));
    const bool room = left && rows && right;
    for (size_t c = 0; room && c < codec->clusters; c++) {
        enc_gemm_pack_columns(n, codec->rank,
                              codec->v + c * codec->rank * codec->columns + (size_t)view * n,
                              codec->columns, ENC_GEMM_N, right);
        for (size_t i = codec->first[c]; i < codec->first[c + 1]; i += ENC_GEMM_M) {
            const size_t left_over = codec->first[c + 1] - i,
                         count = left_over < ENC_GEMM_M ? left_over : ENC_GEMM_M;
            enc_gemm_pack_rows(count, codec->rank, codec->u + i * codec->rank, codec->rank, ENC_GEMM_M,
                               left);
            enc_gemm_multiply(tile, count, n, codec->rank, left, right, rows, n, 0);
            for (size_t k = 0; k < count; k++) {
                for (size_t p = 0; p < n; p++) {
                    const size_t light = p % lights, channel = p / lights;
                    out[(light * texels + codec->order[i + k]) * 3 + channel] =
                        decode_value(codec->coding, rows[k * n + p]);
                }
            }
        }
    }
    free(left);
    free(rows);
    free(right);
    return room ? BTF_OK : BTF_ERROR_MEMORY;
}

enc_image_source pca_images(const pca_codec *codec) {
    return (enc_image_source){decode_view, codec};
}
