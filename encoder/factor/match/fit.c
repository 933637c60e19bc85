/* Search and descent in turn. See fit.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fit.h"

#include "descend.h"
#include "encoder/base/ranks.h"
#include "encoder/factor/rows.h"
#include "encoder/math/linear.h"
#include "encoder/math/symmetric.h"
#include "search.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SWEEPS = 3 };

/* Where the first search leaves more of the squared error than this, no round follows it: a descent and
 * another search gain two to three times as much again, which is too little then (MAY_LEAVE, factor.c).
 * Measured, left by the first and by the second search: UBO_IMPALLA64 0.983, 0.947; BRICKS64 0.920, 0.781;
 * bumps 64x64 0.942, 0.81; of btf-sample bricks 64x64 0.882, 0.714; 128x128 0.868, 0.684; of 32x32 texels
 * bumps 0.862, 0.724; weave 0.740, 0.570. */
#define FIRST_MAY_LEAVE 0.97

static btf_result no_memory(const enc_factor_matrix *m) {
    return enc_fail(m->context, BTF_ERROR_MEMORY, "match: out of memory");
}

/* Components of a product.
 * ------------------------------------------------------------------------------------------------ */

/* Computes out = r a r^T of upper triangular r and symmetric a, all [n][n], as scratch is. */
static void congruence(int threads, size_t n, const double *r, const double *a, double *scratch,
                       double *out) {
#pragma omp parallel for schedule(dynamic, 8) num_threads(threads)
    for (size_t i = 0; i < n; i++) {
        double *row = scratch + i * n;
        memset(row, 0, n * sizeof *row);
        for (size_t p = i; p < n; p++) {
            for (size_t j = 0; j < n; j++) {
                row[j] += r[i * n + p] * a[p * n + j];
            }
        }
    }
#pragma omp parallel for schedule(dynamic, 8) num_threads(threads)
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < n; j++) {
            double sum = 0;
            for (size_t p = j; p < n; p++) {
                sum += scratch[i * n + p] * r[j * n + p];
            }
            out[i * n + j] = sum;
        }
    }
}

/* Finds the matrices that turn u and w into components, from the eigenvectors `e` of r G_w r^T, where G_u =
 * r^T r. */
static void find_turns(size_t n, const double *r, const double *e, const double *values, double *solved,
                       float *turn_u, float *turn_w) {
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < n; j++) {
            solved[j * n + i] = e[i * n + j];
        }
    }
    enc_upper_solve(n, r, solved, n); /* columns: r^-1 e_i */
    for (size_t i = 0; i < n; i++) {
        const double root = values[i] > 0 ? sqrt(sqrt(values[i])) : 0;
        for (size_t j = 0; j < n; j++) {
            double sum = 0;
            for (size_t p = 0; p <= j; p++) {
                sum += r[p * n + j] * e[i * n + p];
            }
            turn_u[i * n + j] = (float)(root * solved[j * n + i]);
            turn_w[i * n + j] = root > 0 ? (float)(sum / root) : 0.0f;
        }
    }
}

/* Replaces u and w by the singular components of u^T w. */
static bool orthogonalise(const enc_factor_matrix *m, size_t n, float *u, float *w) {
    double *r = malloc(5 * n * n * sizeof *r), *gram = r ? r + n * n : NULL,
           *scratch = r ? r + 2 * n * n : NULL;
    double *e = r ? r + 3 * n * n : NULL, *values = calloc(n + 1, sizeof *values), trace = 0;
    float *turn = malloc(2 * n * n * sizeof *turn + 1);
    bool done = r && values && turn;
    if (done) {
        enc_gram_rows(m->context->threads, n, m->texels, u, r);
        enc_gram_rows(m->context->threads, n, m->columns, w, gram);
        for (size_t i = 0; i < n; i++) {
            trace += r[i * n + i];
        }
        for (size_t i = 0; i < n; i++) {
            r[i * n + i] += 1e-12 * trace + 1e-30;
        }
        done = enc_cholesky(n, r);
    }
    if (done) {
        congruence(m->context->threads, n, r, gram, scratch, e);
        done = enc_eigen_symmetric(n, e, values);
    }
    if (done) {
        find_turns(n, r, e, values, scratch, turn, turn + n * n);
        done = enc_rows_turn(m->context->threads, n, n, turn, m->texels, u, u) &&
               enc_rows_turn(m->context->threads, n, n, turn + n * n, m->columns, w, w);
    }
    free(r);
    free(values);
    free(turn);
    return done;
}

/* The energy of a component, added up over all points. */
static double weighted_energy(const enc_factor_matrix *m, const float *u, const float *w) {
    const size_t views = m->match->views, lights = m->columns / views;
    double energy = 0;
    for (size_t v = 0; v < views; v++) {
        double weight = 0;
        for (size_t z = 0; z < m->texels; z++) {
            weight += (double)m->match->weight[z * views + v] * u[z] * u[z];
        }
        energy += weight * enc_dot(lights, w + v * lights, w + v * lights);
    }
    return energy;
}

typedef struct order {
    double energy;
    size_t from;
} order;

static int falling(const void *a, const void *b) {
    const order *x = a, *y = b;
    return x->energy != y->energy ? (x->energy < y->energy ? 1 : -1) : x->from < y->from ? -1 : 1;
}

/* Makes components by falling energy of a channel's factors, whose u and w it changes. */
static bool to_components(const enc_factor_matrix *m, enc_factor_channel *channel, enc_components *out) {
    const size_t n = channel->rank;
    order *by = malloc((n + 1) * sizeof *by);
    enc_components_clear(out);
    *out = (enc_components){.rank = n, .sought = n};
    out->u = enc_gemm_alloc(n * m->texels);
    out->w = enc_gemm_alloc(n * m->columns);
    out->energy = calloc(n + 1, sizeof *out->energy);
    const bool room =
        by && out->u && out->w && out->energy && (n == 0 || orthogonalise(m, n, channel->u, channel->w));
    if (room) {
#pragma omp parallel for schedule(static) num_threads(m->context->threads)
        for (size_t j = 0; j < n; j++) {
            by[j] = (order){weighted_energy(m, channel->u + j * m->texels, channel->w + j * m->columns), j};
        }
        qsort(by, n, sizeof *by, falling);
        for (size_t j = 0; j < n; j++) {
            out->energy[j] = by[j].energy;
            memcpy(out->u + j * m->texels, channel->u + by[j].from * m->texels, m->texels * sizeof(float));
            memcpy(out->w + j * m->columns, channel->w + by[j].from * m->columns,
                   m->columns * sizeof(float));
        }
    }
    free(by);
    return room;
}

/* Rounds.
 * ------------------------------------------------------------------------------------------------ */

/* Sums of squares of a search, in the leading directions of the profiles. */
typedef struct search_sums {
    double own, left, energy; /* squared error with each texel as its own source, squared error with the
                                 sources and gains found, energy of the samples */
} search_sums;

/* The squared distance of a block's profiles from those that the factors of their own texels give. */
static double own_error(const enc_match *match, const enc_match_coordinates *at) {
    const size_t texels = enc_match_area_texels(&at->block), sources = enc_match_area_texels(&at->sources);
    double error = 0;
    for (size_t i = 0; i < match->views * texels; i++) {
        const size_t texel = enc_match_texel(match, &at->block, i % texels);
        const size_t own = i / texels * sources + enc_match_place(match, &at->sources, texel);
        const float *query = at->query + i * at->k, *source = at->source + own * at->k;
        error += enc_dot(at->k, query, query) - 2 * enc_dot(at->k, query, source) + at->norm[own];
    }
    return error;
}

/* The steps of a search, one of which may take all blocks before the next begins. */
typedef struct block_steps {
    bool locate_points, locate_sources, search, restrict_points;
} block_steps;

static btf_result search_block(const enc_factor_matrix *m, const enc_match_bases *bases,
                               const enc_factor_codes *codes, block_steps steps, enc_match_coordinates *at,
                               enc_match *match, search_sums *sums) {
    btf_result result = steps.locate_points ? enc_match_locate_points(m, bases, match, at) : BTF_OK;
    if (result == BTF_OK && steps.locate_sources) {
        result = enc_match_locate_sources(m, codes, bases, match, at);
    }
    if (result == BTF_OK && steps.search) {
        result = enc_match_search(m, at, match, &sums->energy);
    }
    if (result == BTF_OK && steps.restrict_points) {
        sums->own += own_error(match, at);
        result = enc_match_restrict(m->context, at, enc_match_entries(match->views), match, &sums->left);
    }
    return result;
}

/* Copies the sources and gains of a block's points to the message [block][view][texel], or back. */
static void copy_block(const enc_match_coordinates *block, enc_match *match, uint32_t *source,
                       uint8_t *gain, bool back) {
    const size_t texels = enc_match_area_texels(&block->block);
    for (size_t i = 0; i < match->views * texels; i++) {
        const size_t point =
            i / texels * match->texels + enc_match_texel(match, &block->block, i % texels);
        if (back) {
            match->source[point] = source[i];
            match->gain[point] = gain[i];
        } else {
            source[i] = match->source[point];
            gain[i] = match->gain[point];
        }
    }
}

/* Hands the points that each rank found, those of some blocks, to all ranks. */
static btf_result share_blocks(const enc_context *context, btf_result result, enc_match *match) {
    const size_t points = match->texels * match->views, ranks = (size_t)enc_ranks_count(context);
    const size_t blocks = (size_t)enc_match_blocks(match);
    uint32_t *source = malloc(points * sizeof *source);
    uint8_t *gain = malloc(points);
    size_t *bounds = calloc(ranks + 1, sizeof *bounds), *starts = calloc(blocks + 1, sizeof *starts);
    if (!source || !gain || !bounds || !starts) {
        result = enc_fail(context, BTF_ERROR_MEMORY, "match: out of memory for what ranks exchange");
    }
    size_t first, end, own, own_end;
    enc_ranks_range(context, blocks, &own, &own_end);
    result = enc_ranks_agree(context, result);
    for (size_t b = 0; b < blocks && result == BTF_OK; b++) {
        const enc_match_coordinates at = enc_match_block(match, 0, (int)b);
        starts[b + 1] = starts[b] + match->views * enc_match_area_texels(&at.block);
        if (b >= own && b < own_end) {
            copy_block(&at, match, source + starts[b], gain + starts[b], false);
        }
    }
    for (size_t r = 0; r < ranks && result == BTF_OK; r++) {
        enc_ranks_range_of(context, (int)r, blocks, &first, &end);
        bounds[r + 1] = starts[end];
    }
    if (result == BTF_OK) {
        result = enc_ranks_gather_bounds(context, result, source, sizeof *source, bounds);
        result = enc_ranks_gather_bounds(context, result, gain, 1, bounds);
    }
    for (size_t b = 0; b < blocks && result == BTF_OK; b++) {
        const enc_match_coordinates at = enc_match_block(match, 0, (int)b);
        copy_block(&at, match, source + starts[b], gain + starts[b], true);
    }
    free(source);
    free(gain);
    free(bounds);
    free(starts);
    return result;
}

/* Searches some blocks, one after the other; sums [block]. */
static btf_result search_some(const enc_factor_matrix *m, const enc_match_bases *bases,
                              const enc_factor_codes *codes, block_steps steps, size_t first, size_t end,
                              enc_match_coordinates *at, enc_match *match, search_sums *sums) {
    btf_result result = BTF_OK;
    for (size_t b = first; b < end && result == BTF_OK; b++) {
        enc_match_coordinates next = enc_match_block(match, bases->leading, (int)b);
        next.query = at->query;
        next.source = at->source;
        next.norm = at->norm;
        result = search_block(m, bases, codes, steps, &next, match, &sums[b]);
    }
    return result;
}

/* Searches all blocks. Ranks share them, or the views where there is only one block. */
static btf_result search_blocks(const enc_factor_matrix *m, const enc_match_bases *bases,
                                const enc_factor_codes *codes, block_steps steps,
                                enc_match_coordinates *at, enc_match *match, search_sums *io_sums) {
    const size_t blocks = (size_t)enc_match_blocks(match);
    enc_context alone = *m->context;
    enc_factor_matrix by_blocks = *m;
    const bool split = blocks > 1 && enc_ranks_count(m->context) > 1;
    search_sums *sums = calloc(blocks, sizeof *sums);
    size_t first, end;
    alone.ranks = NULL;
    by_blocks.context = &alone;
    enc_ranks_range(split ? m->context : &alone, blocks, &first, &end);
    btf_result result = sums ? BTF_OK : no_memory(m);
    if (result == BTF_OK && match->whole && steps.locate_sources) {
        result = enc_match_locate_sources(m, codes, bases, match, at);
        steps.locate_sources = false;
    }
    if (result == BTF_OK) {
        result = search_some(split ? &by_blocks : m, bases, codes, steps, first, end, at, match, sums);
    }
    if (split) {
        result = share_blocks(m->context, result, match);
        if (result == BTF_OK) {
            result = enc_ranks_gather(m->context, result, sums, sizeof *sums, blocks);
        }
    }
    for (size_t b = 0; b < blocks && result == BTF_OK; b++) {
        io_sums->own += sums[b].own;
        io_sums->left += sums[b].left;
        io_sums->energy += sums[b].energy;
    }
    free(sums);
    return result;
}

/* Searches, then restricts each texel to a list. The first search has the scale of gains fitted between the
 * two, for which all blocks must have been searched. */
static btf_result search(const enc_factor_matrix *m, const enc_match_bases *bases, bool first,
                         enc_match *match, const enc_factor_codes *codes, search_sums *out_sums) {
    const bool split = first && match->gains.count > 1;
    const bool points = enc_match_blocks(match) > 1,
               sources = points && !match->whole; /* not kept from block to block */
    enc_match_coordinates at = enc_match_block(match, bases->leading, 0);
    *out_sums = (search_sums){0, 0, 0};
    btf_result result = enc_match_coordinates_create(m->context, match->views, &at);
    if (result == BTF_OK) {
        result =
            search_blocks(m, bases, codes, (block_steps){true, true, true, !split}, &at, match, out_sums);
    }
    if (result == BTF_OK && split) {
        enc_match_fit_gains(m->context, match);
        result = search_blocks(m, bases, codes, (block_steps){points, sources, false, true}, &at, match,
                               out_sums);
    }
    enc_match_coordinates_clear(&at);
    if (result == BTF_OK) {
        enc_match_count_users(m->context, match);
        enc_log(m->context, BTF_LOG_INFO,
                "match: %.4g %% of the energy is left by each texel's own factors, %.4g %% by those of "
                "source texels with a gain",
                100 * out_sums->own / out_sums->energy, 100 * out_sums->left / out_sums->energy);
    }
    return result;
}

/* Makes the rounds on unrounded factors; sets *out_share after the second search. */
static btf_result play_rounds(const enc_factor_matrix *m, const enc_match_bases *bases, double most,
                              enc_match *match, enc_factor_codes *codes, double *out_share) {
    btf_result result = BTF_OK;
    double first_own = 1;
    *out_share = 1;
    for (int i = 0; i < ENC_MATCH_ROUNDS && result == BTF_OK; i++) {
        search_sums sums;
        result = search(m, bases, i == 0, match, codes, &sums);
        first_own = i == 0 ? sums.own : first_own;
        if (result == BTF_OK && i <= 1) {
            const double may_leave = i == 0 ? fmax(most, FIRST_MAY_LEAVE) : most;
            *out_share = first_own > 0 ? sums.left / first_own : 1;
            if (!(*out_share <= may_leave)) {
                return BTF_OK;
            }
        }
        if (result == BTF_OK) {
            result = enc_match_descend(m, codes, false, SWEEPS);
        }
    }
    return result;
}

/* Turns the factors found into components, and makes the plan for them. */
static btf_result plan_anew(const enc_factor_matrix *m, uint64_t budget, enc_factor_codes *codes,
                            enc_components components[3], enc_factor_plan *plan) {
    enc_factor_energies energies = {.rounding = NULL};
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        if (!to_components(m, &codes->channel[c], &components[c])) {
            return no_memory(m);
        }
        energies.rank[c] = components[c].rank;
        energies.energy[c] = components[c].energy;
    }
    const enc_factor_plan before = *plan;
    if (!enc_factor_allocate(&energies, m->texels, codes->views, codes->lights, budget, plan)) {
        return no_memory(m);
    }
    /* The plan before holds all components that there are. A new plan, of whole units, may hold fewer of
     * them and leave bytes of the budget unused; then the one before stays. */
    if (enc_factor_plan_error(&energies, &before, 0) < enc_factor_plan_error(&energies, plan, 0)) {
        *plan = before;
    }
    return BTF_OK;
}

btf_result enc_match_fit(const enc_factor_matrix *matrix, uint64_t budget, const enc_match_bases *bases,
                         double most, enc_match *match, enc_components components[3], enc_factor_plan *plan,
                         double *out_share) {
    enc_factor_matrix m = *matrix;
    enc_factor_codes codes;
    btf_result result = enc_factor_codes_create(&m, plan, components, &codes);
    if (result == BTF_OK) {
        m.match = match;
        result = play_rounds(&m, bases, most, match, &codes, out_share);
    }
    if (result == BTF_OK && *out_share <= most) {
        result = plan_anew(&m, budget, &codes, components, plan);
    }
    enc_factor_codes_clear(&codes);
    return result;
}

btf_result enc_match_round(const enc_factor_matrix *m, const enc_match_bases *bases, int rounds,
                           enc_match *match, enc_factor_codes *codes) {
    btf_result result = BTF_OK;
    for (int i = 0; i < rounds && result == BTF_OK; i++) {
        search_sums sums;
        result = search(m, bases, false, match, codes, &sums);
        if (result == BTF_OK) {
            result = enc_match_descend(m, codes, true, SWEEPS);
        }
    }
    return result;
}
