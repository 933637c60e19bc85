/* Quantiser steps and coordinate descent on codes. See round.h.
 *
 * With one factor held, the error of the other's codes x is x^T G x - 2 x^T p + constant for each texel
 * (column), where G is the Gram matrix of the held factor and p the product of the samples with it. A sweep
 * takes the components in panels of twelve: one tile of a matrix product finds G x for the panel from the
 * present x, then the twelve are rounded in turn.
 *
 * SPDX-License-Identifier: MIT
 */
#include "round.h"

#include "encoder/math/clones.h"
#include "rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    LANES = ENC_GEMM_N, /* texels or columns that are refined together */
    PANEL = ENC_GEMM_M, /* components */
    REFIT_SWEEPS = 3,   /* sweeps that fit u to rounded w before u is rounded */
    STEP_TRIALS = 24,
    SAMPLE_SHARE = 2, /* rounds against the components found for each round against the samples */
    TURNS = 3,        /* sweeps over a factor's components for each product */
};
#define STEP_RATIO 0.88f /* of one step that is tried to the one before */

static btf_result no_memory(const enc_factor_matrix *m) {
    return enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory while codes are rounded");
}

/* Steps.
 * ------------------------------------------------------------------------------------------------ */

ENC_CLONES static double rounding_error(size_t n, const float *x, enc_factor_levels levels,
                                               float step) {
    const float inverse = step > 0 ? 1 / step : 0.0f;
    double total = 0;
    for (size_t at = 0; at < n; at += 512) {
        const size_t end = n - at < 512 ? n : at + 512;
        float sum[16] = {0};
        size_t i = at;
        for (; i + 16 <= end; i += 16) {
            for (size_t j = 0; j < 16; j++) {
                const float e = x[i + j] - step * enc_factor_level(levels, x[i + j] * inverse);
                sum[j] += e * e;
            }
        }
        for (size_t j = 0; i + j < end; j++) {
            const float e = x[i + j] - step * enc_factor_level(levels, x[i + j] * inverse);
            sum[j] += e * e;
        }
        for (size_t j = 0; j < 16; j++) {
            total += sum[j];
        }
    }
    return total;
}

/* A factor of a channel: u, or w with the views' factors. */
typedef struct factor {
    const enc_factor_codes *codes;
    int channel;
    bool is_w;
    size_t count;        /* texels or columns */
    size_t runs, length; /* count = runs * length; runs are views */
    float *values, *steps;
} factor;

static factor factor_of(enc_factor_codes *codes, int channel, bool is_w) {
    enc_factor_channel *c = &codes->channel[channel];
    return is_w ? (factor){codes,        channel,       true, codes->columns,
                           codes->views, codes->lights, c->w, c->step_w}
                : (factor){codes, channel, false, codes->texels, 1, codes->texels, c->u, c->step_u};
}

static enc_factor_levels levels_of(const factor *f, size_t component) {
    const int class = f->codes->channel[f->channel].place[component].class;
    const enc_factor_class *k = &enc_factor_classes[class];
    return enc_factor_levels_of(class, f->is_w ? k->top_w : k->top_u);
}

/* The factor of a run, 1 for u. */
static float run_factor(const factor *f, size_t component, size_t run) {
    const int class = f->codes->channel[f->channel].place[component].class;
    return f->is_w ? enc_factor_view(f->codes, run, enc_factor_classes[class].tier, f->channel) : 1.0f;
}

static double group_error(const factor *f, size_t first, size_t end, float step) {
    double error = 0;
    for (size_t j = first; j < end; j++) {
        for (size_t run = 0; run < f->runs; run++) {
            error += rounding_error(f->length, f->values + j * f->count + run * f->length, levels_of(f, j),
                                    step * run_factor(f, j, run));
        }
    }
    return error;
}

/* Finds the step of least error for the components first .. end - 1 of a group: that which puts the largest
 * value at the top level, or a smaller one, which clips. */
static float best_step(const factor *f, size_t first, size_t end) {
    float most = 0;
    for (size_t j = first; j < end; j++) {
        for (size_t i = 0; i < f->count; i++) {
            const float divisor = run_factor(f, j, i / f->length);
            const float x = divisor > 0 ? fabsf(f->values[j * f->count + i]) / divisor : 0.0f;
            most = fmaxf(most, x);
        }
    }
    float step = most / levels_of(f, first).top, best = step;
    double least = HUGE_VAL;
    for (int trial = 0, rises = 0; trial < STEP_TRIALS && rises < 3 && most > 0; trial++) {
        const double error = group_error(f, first, end, step);
        rises = error < least ? 0 : rises + 1;
        best = error < least ? step : best;
        least = error < least ? error : least;
        step *= STEP_RATIO;
    }
    return best;
}

/* Finds the steps of all groups of a channel. */
static void find_steps(const enc_context *context, const factor *f) {
    const enc_factor_channel *channel = &f->codes->channel[f->channel];
#pragma omp parallel for schedule(dynamic) num_threads(context->threads)
    for (size_t first = 0; first < channel->rank; first++) {
        const uint16_t group = channel->place[first].group;
        if (first > 0 && channel->place[first - 1].group == group) {
            continue;
        }
        size_t end = first + 1;
        while (end < channel->rank && channel->place[end].group == group) {
            end++;
        }
        const float step = best_step(f, first, end);
        for (size_t j = first; j < end; j++) {
            f->steps[j] = step;
        }
    }
}

/* Adds the energy of a component in each view, over the mean of the views, to sums [tier][view]. */
static void add_view_energies(const enc_factor_codes *codes, const enc_factor_channel *channel, size_t j,
                              double *energy, double *sums) {
    const size_t tier = enc_factor_classes[channel->place[j].class].tier;
    double all = 0;
    for (size_t v = 0; v < codes->views; v++) {
        energy[v] = 0;
        for (size_t l = 0; l < codes->lights; l++) {
            const double x = channel->w[j * codes->columns + v * codes->lights + l];
            energy[v] += x * x;
        }
        all += energy[v];
    }
    for (size_t v = 0; v < codes->views && all > 0; v++) {
        sums[tier * codes->views + v] += energy[v] * (double)codes->views / all;
    }
}

/* Finds the views' factors, by tier and channel: how much larger w is in a view than over all views, by the
 * mean of the components' energies. */
static bool find_view_factors(enc_factor_codes *codes) {
    const size_t views = codes->views;
    double *sums = malloc((ENC_FACTOR_TIERS + 1) * views * sizeof *sums);
    for (int c = 0; c < ENC_FACTOR_CHANNELS && sums; c++) {
        size_t members[ENC_FACTOR_TIERS] = {0};
        memset(sums, 0, ENC_FACTOR_TIERS * views * sizeof *sums);
        for (size_t j = 0; j < codes->channel[c].rank; j++) {
            add_view_energies(codes, &codes->channel[c], j, sums + ENC_FACTOR_TIERS * views, sums);
            members[enc_factor_classes[codes->channel[c].place[j].class].tier]++;
        }
        for (size_t v = 0; v < views; v++) {
            for (size_t t = 0; t < ENC_FACTOR_TIERS; t++) {
                const double mean = members[t] > 0 ? sums[t * views + v] / (double)members[t] : 1;
                const float f = (float)sqrt(mean);
                codes->view[(v * ENC_FACTOR_TIERS + t) * ENC_FACTOR_CHANNELS + (size_t)c] =
                    f >= 0x1p-24f ? f : 0.0f;
            }
        }
    }
    free(sums);
    return sums != NULL;
}

/* Descent.
 * ------------------------------------------------------------------------------------------------ */

/* The sums that the codes of one factor are fitted to. */
typedef struct problem {
    factor factor;
    size_t rank, panels;
    float *gram;          /* packed: [panel][rank][PANEL] */
    const float *product; /* [rank][count] */
    enc_gemm_tile tile;
    bool round; /* to levels; else the values stay as they come */
    int sweeps;
} problem;

/* Finds f f^T of f [rank][count], packed as the left operand of products. */
static bool find_gram(int threads, size_t rank, size_t count, const float *f, float *packed_out) {
    float *gram = enc_gemm_alloc(rank * rank);
    const bool done = gram && enc_rows_dot(threads, rank, f, rank, f, count, gram);
    if (done) {
        enc_gemm_pack_rows(rank, rank, gram, rank, PANEL, packed_out);
    }
    free(gram);
    return done;
}

/* Sets one component of a panel to its best value in all lanes, and adds the change of G x for the others
 * of the panel to `seen`. */
ENC_CLONES static void settle(const float *gram_row, size_t j, size_t after, bool round,
                                     enc_factor_levels levels, const float *restrict step,
                                     const float *restrict product, float *restrict seen,
                                     float *restrict x) {
    const float inverse = gram_row[0] > 0 ? 1 / gram_row[0] : 0.0f;
    float change[LANES];
    for (size_t i = 0; i < LANES; i++) {
        const float best = x[i] + (product[i] - seen[j * LANES + i]) * inverse;
        const float over = step[i] > 0 ? best / step[i] : 0.0f;
        const float value = round ? step[i] * enc_factor_level(levels, over) : best;
        change[i] = value - x[i];
        x[i] = value;
    }
    for (size_t k = 1; k <= after; k++) {
        for (size_t i = 0; i < LANES; i++) {
            seen[(j + k) * LANES + i] += gram_row[k] * change[i];
        }
    }
}

/* Makes a sweep over x [rank][LANES]; product has the same shape. views: the views' factors of the lanes,
 * [tier][LANES]. */
static void sweep(const problem *p, const float *product, const float *views, float *x) {
    const enc_factor_channel *channel = &p->factor.codes->channel[p->factor.channel];
    _Alignas(64) float seen[PANEL * LANES], step[LANES];
    for (size_t panel = 0; panel < p->panels; panel++) {
        const size_t first = panel * PANEL, n = p->rank - first < PANEL ? p->rank - first : PANEL;
        const float *gram = p->gram + first * p->rank;
        p->tile(p->rank, gram, x, seen);
        for (size_t j = 0; j < n; j++) {
            const size_t component = first + j;
            const size_t tier = enc_factor_classes[channel->place[component].class].tier;
            for (size_t i = 0; i < LANES; i++) {
                step[i] = p->factor.steps[component] * views[tier * LANES + i];
            }
            settle(gram + component * PANEL + j, j, n - 1 - j, p->round, levels_of(&p->factor, component),
                   step, product + component * LANES, seen, x + component * LANES);
        }
    }
}

static void refine_lanes(const problem *p, size_t first, size_t n, float *work) {
    const factor *f = &p->factor;
    float *x = work, *product = work + p->rank * LANES, *views = work + 2 * p->rank * LANES;
    memset(work, 0, 2 * p->rank * LANES * sizeof *work);
    for (size_t j = 0; j < p->rank; j++) {
        memcpy(x + j * LANES, f->values + j * f->count + first, n * sizeof *x);
        memcpy(product + j * LANES, p->product + j * f->count + first, n * sizeof *x);
    }
    for (size_t t = 0; t < ENC_FACTOR_TIERS; t++) {
        for (size_t i = 0; i < LANES; i++) {
            views[t * LANES + i] =
                f->is_w && i < n ? enc_factor_view(f->codes, (first + i) / f->length, t, f->channel) : 1.0f;
        }
    }
    for (int s = 0; s < p->sweeps; s++) {
        sweep(p, product, views, x);
    }
    for (size_t j = 0; j < p->rank; j++) {
        memcpy(f->values + j * f->count + first, x + j * LANES, n * sizeof *x);
    }
}

/* Refines one factor of a channel against the other; ranks share its texels or columns. */
static btf_result refine(const enc_factor_matrix *m, enc_factor_codes *codes, int channel, bool of_w,
                   const float *product, bool round, int sweeps) {
    const factor held = factor_of(codes, channel, !of_w);
    const size_t rank = codes->channel[channel].rank, panels = enc_gemm_panels(rank, PANEL);
    const size_t each = (2 * rank + ENC_FACTOR_TIERS) * LANES;
    problem p = {.factor = factor_of(codes, channel, of_w),
                 .rank = rank,
                 .panels = panels,
                 .gram = enc_gemm_alloc(panels * PANEL * rank),
                 .product = product,
                 .tile = m->tile,
                 .round = round,
                 .sweeps = sweeps};
    float *work = enc_gemm_alloc((size_t)m->context->threads * each);
    const bool room =
        p.gram && work && find_gram(m->context->threads, rank, held.count, held.values, p.gram);
    size_t begin, end;
    enc_rows_range(m->context, p.factor.count, LANES, &begin, &end);
#pragma omp parallel for schedule(dynamic) num_threads(m->context->threads) if (room)
    for (size_t first = begin; first < (room ? end : begin); first += LANES) {
        const size_t n = end - first < LANES ? end - first : LANES;
        refine_lanes(&p, first, n, work + enc_thread_index() * each);
    }
    free(p.gram);
    free(work);
    return enc_rows_complete(m->context, room ? BTF_OK : no_memory(m), rank, p.factor.count, LANES,
                             sizeof(float), p.factor.values);
}

/* Rounds w to the nearest levels. */
static void round_w(const enc_context *context, enc_factor_codes *codes, int channel) {
    const factor f = factor_of(codes, channel, true);
#pragma omp parallel for schedule(static) num_threads(context->threads)
    for (size_t j = 0; j < codes->channel[channel].rank; j++) {
        const enc_factor_levels levels = levels_of(&f, j);
        for (size_t i = 0; i < f.count; i++) {
            const float step = f.steps[j] * run_factor(&f, j, i / f.length);
            float *x = &f.values[j * f.count + i];
            *x = step > 0 ? step * enc_factor_level(levels, *x / step) : 0.0f;
        }
    }
}

/* Finds the products of the held factor with the components that were found, or, where these are NULL, with
 * the samples. Components may stand for the samples since what lies beyond them is small and has little in
 * common with the codes. */
static btf_result find_products(const enc_factor_matrix *m, const enc_factor_codes *codes, bool of_w,
                                const enc_components *components, const enc_factor_set *out) {
    enc_factor_set held = {0};
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        held.rank[c] = codes->channel[c].rank;
        held.factor[c] = of_w ? codes->channel[c].u : codes->channel[c].w;
    }
    if (!components) {
        return of_w ? enc_factor_times_u(m, &held, out) : enc_factor_times_w(m, &held, out);
    }
    const size_t count = of_w ? m->columns : m->texels, depth = of_w ? m->texels : m->columns;
    const int threads = m->context->threads;
    bool room = true;
    for (int c = 0; c < ENC_FACTOR_CHANNELS && room; c++) {
        const enc_components *from = &components[c];
        float *turn = enc_gemm_alloc(held.rank[c] * from->rank);
        room =
            turn && (held.rank[c] == 0 || (enc_rows_dot(threads, held.rank[c], held.factor[c], from->rank,
                                                        of_w ? from->u : from->w, depth, turn) &&
                                           enc_rows_turn(threads, held.rank[c], from->rank, turn, count,
                                                         of_w ? from->w : from->u, out->factor[c])));
        free(turn);
    }
    return room ? BTF_OK : no_memory(m);
}

/* Fits u to rounded w and finds the steps of u. */
static btf_result begin_u(const enc_factor_matrix *m, enc_factor_codes *codes, int c, const float *product) {
    const factor u = factor_of(codes, c, false);
    const btf_result result = refine(m, codes, c, false, product, false, REFIT_SWEEPS);
    find_steps(m->context, &u);
    return result;
}

/* Finds the products, then refines each channel. */
static btf_result descend(const enc_factor_matrix *m, enc_factor_codes *codes, bool of_w, bool begin,
                          const enc_components *components, const enc_factor_set *product) {
    btf_result result = enc_cancelled(m->context) ? BTF_ERROR_INTERRUPTED
                                                  : find_products(m, codes, of_w, components, product);
    for (int c = 0; c < ENC_FACTOR_CHANNELS && result == BTF_OK; c++) {
        if (codes->channel[c].rank > 0) {
            result = begin ? begin_u(m, codes, c, product->factor[c]) : BTF_OK;
            if (result == BTF_OK) {
                result = refine(m, codes, c, of_w, product->factor[c], true, TURNS);
            }
        }
    }
    return result;
}

/* Makes `rounds` rounds of descent on w and u in turn. */
static btf_result alternate(const enc_factor_matrix *m, enc_factor_codes *codes, int rounds,
                            const enc_components *components, const enc_factor_set *product) {
    btf_result result = BTF_OK;
    for (int i = 0; i < 2 * rounds && result == BTF_OK; i++) {
        result = descend(m, codes, i % 2 == 0, false, components, product);
    }
    return result;
}

int enc_factor_round_passes(int sweeps) {
    return 2 * (sweeps / SAMPLE_SHARE);
}

btf_result enc_factor_round(const enc_factor_matrix *m, const enc_components components[3], int sweeps,
                            enc_factor_codes *codes) {
    const size_t longest = m->texels > m->columns ? m->texels : m->columns;
    enc_factor_set product = {0};
    bool room = find_view_factors(codes);
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        const factor w = factor_of(codes, c, true);
        product.rank[c] = codes->channel[c].rank;
        product.factor[c] = enc_gemm_alloc(product.rank[c] * longest);
        room = room && product.factor[c];
        find_steps(m->context, &w);
        round_w(m->context, codes, c);
    }
    btf_result result = room ? descend(m, codes, false, true, components, &product) : no_memory(m);
    if (result == BTF_OK) {
        result = alternate(m, codes, sweeps, components, &product);
    }
    if (result == BTF_OK) {
        result = alternate(m, codes, sweeps / SAMPLE_SHARE, NULL, &product);
    }
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        free(product.factor[c]);
    }
    return result;
}
