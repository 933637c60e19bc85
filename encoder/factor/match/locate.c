/* Coordinates of profiles in the leading directions of their view. See locate.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "locate.h"

#include "encoder/base/ranks.h"
#include "encoder/math/linear.h"
#include "encoder/math/symmetric.h"

#include <stdlib.h>
#include <string.h>

enum {
    SAMPLE = 512, /* texels whose profiles the leading directions are found from, at most */
    POWER_STEPS = 2,
};

static btf_result no_memory(const enc_factor_matrix *m) {
    return enc_fail(m->context, BTF_ERROR_MEMORY, "match: out of memory for a search");
}

/* Leading directions.
 * ------------------------------------------------------------------------------------------------ */

/* Copies profiles of texels spread over the texture: [SAMPLE at most][length]. Returns their number. */
static size_t sample_profiles(const enc_factor_matrix *m, size_t view, float *out) {
    const size_t lights = (size_t)m->data->n_lights, step = m->texels > SAMPLE ? m->texels / SAMPLE : 1;
    size_t count = 0;
    for (size_t at = 0; at < m->texels && count < SAMPLE; at += step, count++) {
        float *row = out + count * 3 * lights;
        const size_t texel = (at + count * 7 % step) % m->texels;
        enc_factor_split_profile(m, texel, view, (float *const[3]){row, row + lights, row + 2 * lights});
    }
    return count;
}

/* A step of power iteration: out [k][length] += sum over rows of (q row) row, with q [k][length]. */
static void power_step(size_t k, size_t length, size_t count, const float *rows, const float *q,
                       float *out) {
    memset(out, 0, k * length * sizeof *out);
    for (size_t i = 0; i < count; i++) {
        const float *row = rows + i * length;
        for (size_t j = 0; j < k; j++) {
            float dot = 0, *to = out + j * length;
            dot = (float)enc_dot(length, q + j * length, row);
            for (size_t p = 0; p < length; p++) {
                to[p] += dot * row[p];
            }
        }
    }
}

/* Turns the basis so that coordinates of the rows come by falling energy. */
static bool order_basis(size_t k, size_t length, size_t count, const float *rows, const float *from,
                        float *basis) {
    double *gram = calloc(k * k, sizeof *gram), *at = malloc(2 * k * sizeof *at);
    bool done = gram && at;
    for (size_t i = 0; i < count && done; i++) {
        for (size_t j = 0; j < k; j++) {
            at[j] = enc_dot(length, from + j * length, rows + i * length);
            for (size_t p = 0; p <= j; p++) {
                gram[j * k + p] = gram[p * k + j] += at[j] * at[p];
            }
        }
    }
    done = done && enc_eigen_symmetric(k, gram, at + k);
    for (size_t j = 0; j < k && done; j++) {
        memset(basis + j * length, 0, length * sizeof *basis);
        for (size_t p = 0; p < k; p++) {
            for (size_t i = 0; i < length; i++) {
                basis[j * length + i] += (float)gram[j * k + p] * from[p * length + i];
            }
        }
    }
    free(gram);
    free(at);
    return done;
}

/* Finds the basis of one view. work: room for the profiles, and for the basis twice. */
static bool find_basis(const enc_factor_matrix *m, size_t view, size_t k, size_t length, float *work,
                       float *basis) {
    float *rows = work, *q = work + SAMPLE * length, *lower = q + k * length;
    const size_t count = sample_profiles(m, view, rows);
    uint64_t state = view + 1;
    bool room = true;
    for (size_t i = 0; i < k * length; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        q[i] = (float)(int32_t)(state >> 32) * 0x1p-31f;
    }
    for (int step = 0; step < POWER_STEPS && room; step++) {
        power_step(k, length, count, rows, q, basis);
        memcpy(q, basis, k * length * sizeof *q);
        room = enc_orthonormal_rows(k, length, q, basis, lower);
        memcpy(q, basis, k * length * sizeof *q);
    }
    return room && order_basis(k, length, count, rows, q, basis);
}

btf_result enc_match_find_bases(const enc_factor_matrix *m, enc_match_bases *out) {
    const size_t length = 3 * (size_t)m->data->n_lights, views = (size_t)m->data->n_views;
    const size_t k = length < ENC_MATCH_LEADING ? length : ENC_MATCH_LEADING;
    const size_t each = (SAMPLE + k) * length + k * k;
    bool room = true;
    *out = (enc_match_bases){.leading = k, .length = length, .basis = enc_gemm_alloc(views * k * length)};
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    if (!out->basis || !work) {
        free(work);
        enc_match_bases_clear(out);
        return enc_ranks_agree(m->context, no_memory(m));
    }
    size_t begin, end;
    enc_ranks_range(m->context, views, &begin, &end);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads)
    for (size_t v = begin; v < end; v++) {
        if (!find_basis(m, v, k, length, work + enc_thread_index() * each, out->basis + v * k * length)) {
#pragma omp atomic write
            room = false;
        }
    }
    free(work);
    return enc_ranks_gather(m->context, room ? BTF_OK : no_memory(m), out->basis,
                            k * length * sizeof(float), views);
}

btf_result enc_match_outcome(const enc_factor_matrix *m, bool room) {
    return !room ? no_memory(m) : enc_cancelled(m->context) ? BTF_ERROR_INTERRUPTED : BTF_OK;
}

void enc_match_bases_clear(enc_match_bases *bases) {
    free(bases->basis);
    *bases = (enc_match_bases){0};
}

/* Coordinates.
 * ------------------------------------------------------------------------------------------------ */

/* One view of a block while its profiles are projected. */
typedef struct projector {
    const enc_factor_matrix *m;
    const enc_factor_codes *codes;
    const enc_match *match;
    const enc_match_coordinates *at;
    const float *packed_u; /* [panel of ENC_GEMM_M sources][channel, component][ENC_GEMM_M] */
    size_t components, view, length;
    const float *basis;
} projector;

/* Computes out [count][k] = rows [count][length] basis^T, with count at most ENC_GEMM_M. */
static void project(const projector *p, size_t count, const float *rows, const float *packed_basis,
                    float *left, float *out) {
    enc_gemm_pack_rows(count, p->length, rows, p->length, ENC_GEMM_M, left);
    enc_gemm_multiply(p->m->tile, count, p->at->k, p->length, left, packed_basis, out, p->at->k, 0);
}

/* Finds the coordinates of the profiles of the block's texels. */
static void find_queries(const projector *p, float *work) {
    const size_t length = p->length, lights = length / 3, texels = enc_match_area_texels(&p->at->block);
    float *basis = enc_gemm_aligned(work), *left = enc_gemm_aligned(basis + 2 * ENC_GEMM_N * length),
          *rows = left + ENC_GEMM_M * length, *out = p->at->query + p->view * texels * p->at->k;
    enc_gemm_pack_rows(p->at->k, length, p->basis, length, ENC_GEMM_N, basis);
    for (size_t first = 0; first < texels; first += ENC_GEMM_M) {
        const size_t n = texels - first < ENC_GEMM_M ? texels - first : ENC_GEMM_M;
        for (size_t i = 0; i < n; i++) {
            float *row = rows + i * length;
            enc_factor_split_profile(p->m, enc_match_texel(p->match, &p->at->block, first + i), p->view,
                                     (float *const[3]){row, row + lights, row + 2 * lights});
        }
        project(p, n, rows, basis, left, out + first * p->at->k);
    }
}

/* Finds the coordinates of the sources' profiles as their factors give them: u times the view's w in the
 * basis. */
static void find_sources(const projector *p, float *work) {
    const size_t lights = p->length / 3, k = p->at->k, panels = enc_gemm_panels(k, ENC_GEMM_N);
    const size_t sources = enc_match_area_texels(&p->at->sources);
    float *turned = enc_gemm_aligned(work); /* [panel][component][ENC_GEMM_N] */
    float *out = p->at->source + p->view * sources * k, *norm = p->at->norm + p->view * sources;
    memset(turned, 0, panels * ENC_GEMM_N * p->components * sizeof *turned);
    for (size_t c = 0, row = 0; c < ENC_FACTOR_CHANNELS; c++) {
        for (size_t j = 0; j < p->codes->channel[c].rank; j++, row++) {
            const float *w = p->codes->channel[c].w + j * p->codes->columns + p->view * lights;
            for (size_t d = 0; d < k; d++) {
                turned[(d / ENC_GEMM_N * p->components + row) * ENC_GEMM_N + d % ENC_GEMM_N] =
                    (float)enc_dot(lights, w, p->basis + d * p->length + c * lights);
            }
        }
    }
    enc_gemm_multiply(p->m->tile, sources, k, p->components, p->packed_u, turned, out, k, 0);
    for (size_t z = 0; z < sources; z++) {
        norm[z] = (float)enc_dot(k, out + z * k, out + z * k);
    }
}

/* Packs u of all channels, with the sources in panels. */
static void pack_u(const enc_factor_matrix *m, const enc_factor_codes *codes, const enc_match *match,
                   const enc_match_area *area, size_t components, float *out) {
    const size_t sources = enc_match_area_texels(area);
#pragma omp parallel for schedule(static) num_threads(m->context->threads)
    for (size_t first = 0; first < sources; first += ENC_GEMM_M) {
        float *to = out + first * components;
        memset(to, 0, ENC_GEMM_M * components * sizeof *to);
        for (size_t i = 0; i < ENC_GEMM_M && first + i < sources; i++) {
            const size_t texel = enc_match_texel(match, area, first + i);
            for (size_t c = 0, row = 0; c < ENC_FACTOR_CHANNELS; c++) {
                for (size_t j = 0; j < codes->channel[c].rank; j++, row++) {
                    to[row * ENC_GEMM_M + i] = codes->channel[c].u[j * m->texels + texel];
                }
            }
        }
    }
}

static const float *basis_of(const enc_match_bases *bases, size_t view) {
    return bases->basis + view * bases->leading * bases->length;
}

btf_result enc_match_locate_points(const enc_factor_matrix *m, const enc_match_bases *bases,
                                   const enc_match *match, enc_match_coordinates *at) {
    const size_t each = ((2 * ENC_GEMM_N + 2 * ENC_GEMM_M) * bases->length + 64) / 16 * 16;
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    size_t begin, end;
    enc_ranks_range(m->context, match->views, &begin, &end);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads) if (work)
    for (size_t v = begin; v < (work ? end : begin); v++) {
        const projector p = {.m = m,
                             .match = match,
                             .at = at,
                             .view = v,
                             .length = bases->length,
                             .basis = basis_of(bases, v)};
        if (!enc_cancelled(m->context)) {
            find_queries(&p, work + enc_thread_index() * each);
        }
    }
    const btf_result result = enc_match_outcome(m, work);
    free(work);
    return enc_ranks_gather(m->context, result, at->query,
                            enc_match_area_texels(&at->block) * at->k * sizeof *at->query, match->views);
}

btf_result enc_match_locate_sources(const enc_factor_matrix *m, const enc_factor_codes *codes,
                                    const enc_match_bases *bases, const enc_match *match,
                                    enc_match_coordinates *at) {
    const size_t components = codes->channel[0].rank + codes->channel[1].rank + codes->channel[2].rank;
    const size_t sources = enc_match_area_texels(&at->sources);
    const size_t each = ((bases->leading + ENC_GEMM_N) * components + 64) / 16 * 16;
    float *packed = enc_gemm_alloc((sources + ENC_GEMM_M) * components);
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    const bool room = packed && work;
    size_t begin, end;
    enc_ranks_range(m->context, match->views, &begin, &end);
    if (room) {
        pack_u(m, codes, match, &at->sources, components, packed);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads)
        for (size_t v = begin; v < end; v++) {
            const projector p = {.m = m,
                                 .codes = codes,
                                 .match = match,
                                 .at = at,
                                 .packed_u = packed,
                                 .components = components,
                                 .view = v,
                                 .length = bases->length,
                                 .basis = basis_of(bases, v)};
            if (!enc_cancelled(m->context)) {
                find_sources(&p, work + enc_thread_index() * each);
            }
        }
    }
    free(packed);
    free(work);
    const btf_result result = enc_ranks_gather(m->context, enc_match_outcome(m, room), at->source,
                                               sources * at->k * sizeof *at->source, match->views);
    return enc_ranks_gather(m->context, result, at->norm, sources * sizeof *at->norm, match->views);
}
