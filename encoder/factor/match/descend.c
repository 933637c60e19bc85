/* Weighted coordinate descent. See descend.h.
 *
 * A source z has the weight h(z, v) in view v, the sum of the squares of its users' gains. So all columns
 * of w in a view have one Gram matrix, U^T diag(h_v) U. For u each texel has its own, the sum over v of
 * h(z, v) W_v W_v^T: for a few texels at a time it is a product of their weights with the matrices W_v
 * W_v^T of all views, a row each.
 *
 * SPDX-License-Identifier: MIT
 */
#include "descend.h"

#include "encoder/factor/rows.h"
#include "encoder/math/clones.h"

#include <stdlib.h>
#include <string.h>

enum {
    LANES = ENC_GEMM_N, /* columns or texels that are refined together */
    DEPTH = 512,        /* texels that a view's Gram matrix adds at a time */
    BLOCK = 8,          /* components whose parts of Gram matrices are read together */
};

static btf_result no_memory(const enc_factor_matrix *m) {
    return enc_fail(m->context, BTF_ERROR_MEMORY, "match: out of memory for factors");
}

/* Descent in lanes.
 * ------------------------------------------------------------------------------------------------ */

/* The sums that the lanes' components are fitted to. */
typedef struct lanes {
    const enc_factor_channel *channel;
    bool round, is_w;
    const float *steps; /* [rank] */
    const float *gram; /* shared by the lanes: [rank][rank]; of each lane its own: [j (j + 1) / 2 + k, k <=
                          j][LANES] */
    float *x, *product;            /* [rank][LANES] */
    float *seen;                   /* [rank][LANES], where the lanes have Gram matrices of their own */
    float views[ENC_FACTOR_TIERS]; /* factors of the view, 1 for u */
} lanes;

/* seen = G x: sum over k of gram[k] * x[k], with one Gram matrix for all lanes. */
ENC_CLONES static void see_shared(size_t rank, const float *restrict gram, const float *restrict x,
                                         float *restrict seen) {
    float sum[LANES] = {0};
    for (size_t k = 0; k < rank; k++) {
        for (size_t i = 0; i < LANES; i++) {
            sum[i] += gram[k] * x[k * LANES + i];
        }
    }
    memcpy(seen, sum, sizeof sum);
}

/* Adds to seen [BLOCK][LANES], for the components first .. first + n - 1, the part of G x that comes from
 * the components after these, every lane having a Gram matrix of its own. */
ENC_CLONES static void see_behind(size_t rank, size_t first, size_t n, const float *restrict gram,
                                  const float *restrict x, float *restrict seen) {
    for (size_t k = first + n; k < rank; k++) {
        const float *g = gram + (k * (k + 1) / 2 + first) * LANES, *value = x + k * LANES;
        for (size_t j = 0; j < n; j++) {
            for (size_t i = 0; i < LANES; i++) {
                seen[j * LANES + i] += g[j * LANES + i] * value[i];
            }
        }
    }
}

/* Adds to seen [rank][LANES], for all components after first + n - 1, the part of G x that comes from the
 * components first .. first + n - 1. */
ENC_CLONES static void tell_behind(size_t rank, size_t first, size_t n, const float *restrict gram,
                                   const float *restrict x, float *restrict seen) {
    for (size_t k = first + n; k < rank; k++) {
        const float *g = gram + (k * (k + 1) / 2 + first) * LANES, *value = x + first * LANES;
        float sum[LANES] = {0};
        for (size_t j = 0; j < n; j++) {
            for (size_t i = 0; i < LANES; i++) {
                sum[i] += g[j * LANES + i] * value[j * LANES + i];
            }
        }
        for (size_t i = 0; i < LANES; i++) {
            seen[k * LANES + i] += sum[i];
        }
    }
}

/* Adds to seen [LANES], for component j, the part of G x that comes from the components first .. first + n
 * - 1, of which it is one. */
ENC_CLONES static void see_beside(size_t j, size_t first, size_t n, const float *restrict gram,
                                  const float *restrict x, float *restrict seen) {
    for (size_t k = first; k < first + n; k++) {
        const float *g = gram + (k < j ? j * (j + 1) / 2 + k : k * (k + 1) / 2 + j) * LANES;
        for (size_t i = 0; i < LANES; i++) {
            seen[i] += g[i] * x[k * LANES + i];
        }
    }
}

/* Sets a component to its best value in all lanes. */
ENC_CLONES static void settle(bool round, enc_factor_levels levels, float step,
                                     const float *restrict diagonal, const float *restrict product,
                                     const float *restrict seen, float *restrict x) {
    const float per_step = step > 0 ? 1 / step : 0.0f;
    for (size_t i = 0; i < LANES; i++) {
        const float inverse = diagonal[i] > 0 ? 1 / diagonal[i] : 0.0f;
        const float best = x[i] + (product[i] - seen[i]) * inverse;
        x[i] = round ? step * enc_factor_level(levels, best * per_step) : best;
    }
}

static void settle_component(const lanes *l, size_t j, const float *diagonal, const float *seen) {
    const int class = l->channel->place[j].class;
    const enc_factor_class *k = &enc_factor_classes[class];
    settle(l->round, enc_factor_levels_of(class, l->is_w ? k->top_w : k->top_u),
           l->steps[j] * l->views[k->tier], diagonal, l->product + j * LANES, seen, l->x + j * LANES);
}

static void sweep_shared(const lanes *l) {
    const size_t rank = l->channel->rank;
    _Alignas(64) float seen[LANES], diagonal[LANES];
    for (size_t j = 0; j < rank; j++) {
        see_shared(rank, l->gram + j * rank, l->x, seen);
        for (size_t i = 0; i < LANES; i++) {
            diagonal[i] = l->gram[j * rank + j];
        }
        settle_component(l, j, diagonal, seen);
    }
}

/* A sweep where each lane has a Gram matrix of its own. Together they are too large for the first-level
 * cache, so components are taken by blocks, whose part of the matrices is used again while it is still in
 * the cache. */
static void sweep_own(const lanes *l) {
    const size_t rank = l->channel->rank;
    memset(l->seen, 0, rank * LANES * sizeof *l->seen);
    for (size_t first = 0; first < rank; first += BLOCK) {
        const size_t n = rank - first < BLOCK ? rank - first : BLOCK;
        see_behind(rank, first, n, l->gram, l->x, l->seen + first * LANES);
        for (size_t j = first; j < first + n; j++) {
            see_beside(j, first, n, l->gram, l->x, l->seen + j * LANES);
            settle_component(l, j, l->gram + (j * (j + 1) / 2 + j) * LANES, l->seen + j * LANES);
        }
        tell_behind(rank, first, n, l->gram, l->x, l->seen);
    }
}

/* Refines lanes first .. first + n - 1 of values and products [rank][count]. */
static void refine_lanes(const lanes *l, int sweeps, size_t first, size_t n, size_t count,
                         const float *product, float *values) {
    const size_t rank = l->channel->rank;
    memset(l->x, 0, rank * LANES * sizeof(float));
    memset(l->product, 0, rank * LANES * sizeof(float));
    for (size_t j = 0; j < rank; j++) {
        memcpy(l->x + j * LANES, values + j * count + first, n * sizeof(float));
        memcpy(l->product + j * LANES, product + j * count + first, n * sizeof(float));
    }
    for (int s = 0; s < sweeps; s++) {
        if (l->is_w) {
            sweep_shared(l);
        } else {
            sweep_own(l);
        }
    }
    for (size_t j = 0; j < rank; j++) {
        memcpy(values + j * count + first, l->x + j * LANES, n * sizeof(float));
    }
}

/* Gram matrices.
 * ------------------------------------------------------------------------------------------------ */

/* Adds the part on and below the diagonal of the product of rows with one another; left and right hold the
 * same rows, packed. */
static void add_lower(enc_gemm_tile tile, size_t rank, size_t depth, const float *left, const float *right,
                      float *gram) {
    for (size_t first = 0; first < rank; first += ENC_GEMM_N, right += ENC_GEMM_N * depth) {
        const size_t n = rank - first < ENC_GEMM_N ? rank - first : ENC_GEMM_N;
        const size_t panel = first / ENC_GEMM_M, row = panel * ENC_GEMM_M;
        enc_gemm_multiply(tile, rank - row, n, depth, left + row * depth, right, gram + row * rank + first,
                          rank, 1);
    }
}

static void mirror(size_t rank, float *gram) {
    for (size_t j = 0; j < rank; j++) {
        for (size_t k = j + 1; k < rank; k++) {
            gram[j * rank + k] = gram[k * rank + j];
        }
    }
}

/* Floats that a texel's components take, in whole panels of either width. */
static size_t turned_rank(size_t rank) {
    const size_t by_m = enc_gemm_panels(rank, ENC_GEMM_M) * ENC_GEMM_M;
    const size_t by_n = enc_gemm_panels(rank, ENC_GEMM_N) * ENC_GEMM_N;
    return by_m > by_n ? by_m : by_n;
}

/* Transposes u to [texel][turned_rank], since the Gram matrix of each view reads some texels of it. NULL:
 * out of memory. */
static float *turn_u(const enc_factor_matrix *m, const enc_factor_channel *channel) {
    const size_t rank = channel->rank, pitch = turned_rank(rank);
    float *turned = enc_gemm_alloc(m->texels * pitch);
#pragma omp parallel for schedule(static) num_threads(m->context->threads) if (turned)
    for (size_t first = 0; first < (turned ? m->texels : 0); first += LANES) {
        const size_t n = m->texels - first < LANES ? m->texels - first : LANES;
        memset(turned + first * pitch, 0, n * pitch * sizeof *turned);
        for (size_t j = 0; j < rank; j++) {
            for (size_t i = 0; i < n; i++) {
                turned[(first + i) * pitch + j] = channel->u[j * m->texels + first + i];
            }
        }
    }
    return turned;
}

/* Packs panels of the u of texels that have a weight in a view, and of u times weight. */
static void pack_users(const float *turned, size_t rank, size_t n, const uint32_t *source,
                       const float *weight, float *left, float *right) {
    const size_t pitch = turned_rank(rank);
    const size_t by_m = enc_gemm_panels(rank, ENC_GEMM_M), by_n = enc_gemm_panels(rank, ENC_GEMM_N);
    for (size_t i = 0; i < n; i++) {
        const float *u = turned + source[i] * pitch;
        for (size_t p = 0; p < by_m; p++) {
            memcpy(left + (p * n + i) * ENC_GEMM_M, u + p * ENC_GEMM_M, ENC_GEMM_M * sizeof *left);
        }
        for (size_t p = 0; p < by_n; p++) {
            float *to = right + (p * n + i) * ENC_GEMM_N;
            for (size_t j = 0; j < ENC_GEMM_N; j++) {
                to[j] = u[p * ENC_GEMM_N + j] * weight[i];
            }
        }
    }
}

/* Finds gram = U^T diag(h_v) U. turned: what turn_u returned; work: two packed blocks. */
static void gram_of_view(const enc_factor_matrix *m, size_t rank, const float *turned, size_t view,
                         float *work, float *gram) {
    const size_t views = m->match->views;
    float *left = work, *right = work + (rank + ENC_GEMM_N) * DEPTH, weight[DEPTH];
    uint32_t source[DEPTH];
    size_t n = 0;
    memset(gram, 0, rank * rank * sizeof *gram);
    for (size_t z = 0; z < m->texels; z++) {
        if (m->match->weight[z * views + view] > 0) {
            source[n] = (uint32_t)z;
            weight[n++] = m->match->weight[z * views + view];
        }
        if (n == DEPTH || (z + 1 == m->texels && n > 0)) {
            pack_users(turned, rank, n, source, weight, left, right);
            add_lower(m->tile, rank, n, left, right, gram);
            n = 0;
        }
    }
    mirror(rank, gram);
}

/* w.
 * ------------------------------------------------------------------------------------------------ */

static void refine_view(const enc_factor_matrix *m, const enc_factor_codes *codes, int c, size_t view,
                        const float *turned, const float *product, bool round, int sweeps, float *work) {
    const enc_factor_channel *channel = &codes->channel[c];
    const size_t rank = channel->rank, block = (rank + ENC_GEMM_N) * DEPTH;
    float *gram = work + 2 * block;
    lanes l = {.channel = channel, .round = round, .is_w = true, .steps = channel->step_w, .gram = gram};
    l.x = gram + (rank * rank + 15) / 16 * 16;
    l.product = l.x + rank * LANES;
    for (size_t t = 0; t < ENC_FACTOR_TIERS; t++) {
        l.views[t] = enc_factor_view(codes, view, t, c);
    }
    gram_of_view(m, rank, turned, view, work, gram);
    for (size_t i = 0; i < codes->lights; i += LANES) {
        const size_t n = codes->lights - i < LANES ? codes->lights - i : LANES;
        refine_lanes(&l, sweeps, view * codes->lights + i, n, codes->columns, product, channel->w);
    }
}

/* Refines w of channel c. Ranks share the views. */
static btf_result refine_w(const enc_factor_matrix *m, const enc_factor_codes *codes, int c, const float *product,
                     bool round, int sweeps) {
    const size_t rank = codes->channel[c].rank;
    const size_t each = 2 * (rank + ENC_GEMM_N) * DEPTH + (rank * rank + 15) / 16 * 16 + 2 * rank * LANES;
    float *turned = turn_u(m, &codes->channel[c]);
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    const bool room = turned && work;
    size_t begin, end;
    enc_ranks_range(m->context, codes->views, &begin, &end);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads) if (room)
    for (size_t view = begin; view < (room ? end : begin); view++) {
        refine_view(m, codes, c, view, turned, product, round, sweeps, work + enc_thread_index() * each);
    }
    free(turned);
    free(work);
    return enc_rows_complete(m->context, room ? BTF_OK : no_memory(m), rank, codes->columns, codes->lights,
                             sizeof(float), codes->channel[c].w);
}

/* u.
 * ------------------------------------------------------------------------------------------------ */

/* Floats that packed rows take, in whole cache lines. */
static size_t packed_rows(size_t rank, size_t depth) {
    return ((rank + ENC_GEMM_N) * depth + 15) / 16 * 16;
}

/* Packs the inner products of w in every view, a row for each pair of components:
 * [panel][view][ENC_GEMM_M]. */
static void pack_view_gram(const enc_factor_matrix *m, const enc_factor_codes *codes,
                           const enc_factor_channel *channel, size_t view, float *work, float *packed) {
    const size_t rank = channel->rank, lights = codes->lights;
    const size_t block = packed_rows(rank, lights);
    float *left = work, *right = work + block, *gram = work + 2 * block;
    const float *w = channel->w + view * lights;
    enc_gemm_pack_rows(rank, lights, w, codes->columns, ENC_GEMM_M, left);
    enc_gemm_pack_rows(rank, lights, w, codes->columns, ENC_GEMM_N, right);
    memset(gram, 0, rank * rank * sizeof *gram);
    add_lower(m->tile, rank, lights, left, right, gram);
    for (size_t j = 0, pair = 0; j < rank; j++) {
        for (size_t k = 0; k <= j; k++, pair++) {
            packed[(pair / ENC_GEMM_M * codes->views + view) * ENC_GEMM_M + pair % ENC_GEMM_M] =
                gram[j * rank + k];
        }
    }
}

static bool pack_view_grams(const enc_factor_matrix *m, const enc_factor_codes *codes, int c,
                            float *packed) {
    const enc_factor_channel *channel = &codes->channel[c];
    const size_t rank = channel->rank;
    const size_t each = 2 * packed_rows(rank, codes->lights) + (rank * rank + 15) / 16 * 16;
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads) if (work)
    for (size_t view = 0; view < (work ? codes->views : 0); view++) {
        pack_view_gram(m, codes, channel, view, work + enc_thread_index() * each, packed);
    }
    free(work);
    return work != NULL;
}

static void refine_texels(const enc_factor_matrix *m, const enc_factor_codes *codes, int c,
                          const float *packed, size_t first, const float *product, bool round, int sweeps,
                          float *work) {
    const enc_factor_channel *channel = &codes->channel[c];
    const size_t rank = channel->rank, panels = enc_gemm_panels(rank * (rank + 1) / 2, ENC_GEMM_M);
    const size_t n = m->texels - first < LANES ? m->texels - first : LANES, views = codes->views;
    float *gram = work, *weight = gram + panels * ENC_GEMM_M * LANES;
    lanes l = {
        .channel = channel, .round = round, .steps = channel->step_u, .gram = gram, .views = {1, 1, 1}};
    l.x = weight + views * LANES;
    l.product = l.x + rank * LANES;
    l.seen = l.product + rank * LANES;
    enc_gemm_pack_rows(n, views, m->match->weight + first * views, views, LANES, weight);
    for (size_t p = 0; p < panels; p++) {
        m->tile(views, packed + p * views * ENC_GEMM_M, weight, gram + p * ENC_GEMM_M * LANES);
    }
    refine_lanes(&l, sweeps, first, n, m->texels, product, channel->u);
}

/* Refines u of channel c. Ranks share the texels. */
static btf_result refine_u(const enc_factor_matrix *m, const enc_factor_codes *codes, int c, const float *product,
                     bool round, int sweeps) {
    const size_t rank = codes->channel[c].rank, panels = enc_gemm_panels(rank * (rank + 1) / 2, ENC_GEMM_M);
    const size_t each = (panels * ENC_GEMM_M + codes->views + 3 * rank) * LANES;
    float *packed = enc_gemm_alloc(panels * ENC_GEMM_M * codes->views);
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    bool room = packed && work;
    if (room) {
        memset(packed, 0, panels * ENC_GEMM_M * codes->views * sizeof *packed);
        room = pack_view_grams(m, codes, c, packed);
    }
    size_t begin, end;
    enc_rows_range(m->context, m->texels, LANES, &begin, &end);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads) if (room)
    for (size_t first = begin; first < (room ? end : begin); first += LANES) {
        refine_texels(m, codes, c, packed, first, product, round, sweeps, work + enc_thread_index() * each);
    }
    free(packed);
    free(work);
    return enc_rows_complete(m->context, room ? BTF_OK : no_memory(m), rank, m->texels, LANES,
                             sizeof(float), codes->channel[c].u);
}

static btf_result descend(const enc_factor_matrix *m, enc_factor_codes *codes, bool of_w, bool round,
                          int sweeps, const enc_factor_set *product) {
    enc_factor_set held = {0};
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        held.rank[c] = codes->channel[c].rank;
        held.factor[c] = of_w ? codes->channel[c].u : codes->channel[c].w;
    }
    btf_result result =
        of_w ? enc_factor_times_u(m, &held, product) : enc_factor_times_w(m, &held, product);
    for (int c = 0; c < ENC_FACTOR_CHANNELS && result == BTF_OK; c++) {
        if (codes->channel[c].rank > 0) {
            result = of_w ? refine_w(m, codes, c, product->factor[c], round, sweeps)
                          : refine_u(m, codes, c, product->factor[c], round, sweeps);
        }
    }
    return result;
}

btf_result enc_match_descend(const enc_factor_matrix *m, enc_factor_codes *codes, bool round, int sweeps) {
    const size_t longest = m->texels > m->columns ? m->texels : m->columns;
    enc_factor_set product = {0};
    btf_result result = BTF_OK;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        product.rank[c] = codes->channel[c].rank;
        product.factor[c] = enc_gemm_alloc(product.rank[c] * longest);
        result = product.factor[c] ? result : no_memory(m);
    }
    if (result == BTF_OK) {
        result = descend(m, codes, true, round, sweeps, &product);
    }
    if (result == BTF_OK) {
        result = descend(m, codes, false, round, sweeps, &product);
    }
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        free(product.factor[c]);
    }
    return result;
}
