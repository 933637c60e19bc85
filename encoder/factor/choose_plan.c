/* Trials of plans. See choose_plan.h.
 *
 * The allocation assumes that the rounding error of each component stays. Descent makes up for part of it,
 * so that strong components in 4 bits lose far less: of UBO_IMPALLA64 in one unit, all in 4 bits, the
 * allocation expects 22 dB, and 30 come out. With many units the difference is small and alike for all
 * plans. With few, the allocation may pass over the best plan, so plans are made for several shares of the
 * rounding error, rounded and compared.
 *
 * SPDX-License-Identifier: MIT
 */
#include "choose_plan.h"

#include "round.h"
#include "rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_SWEEPS = 1, THOUGHTS = 7 };

/* Shares of the rounding errors of 4 bits, and of 2 bits, that the allocation is told to count; one trial
 * for each pair. */
static const double thoughts[THOUGHTS][2] = {{1, 2},      {0.5, 0.5},  {0.25, 0.5}, {0.1, 0.25},
                                             {0.03, 0.1}, {0.1, 0.03}, {0.03, 0.03}};

static btf_result no_memory(const enc_factor_matrix *m) {
    return enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory while plans are tried");
}

/* *io_sum += sum over i and j of (a_i b_j) (c_i d_j), for a [n_a][texels], b [n_b][texels], and c and d
 * likewise of columns. */
static bool add_products(const enc_factor_matrix *m, size_t n_a, const float *a, const float *c, size_t n_b,
                         const float *b, const float *d, double factor, double *io_sum) {
    float *of_u = enc_gemm_alloc(n_a * n_b), *of_w = enc_gemm_alloc(n_a * n_b);
    const int threads = m->context->threads;
    const bool done = of_u && of_w && enc_rows_dot(threads, n_a, a, n_b, b, m->texels, of_u) &&
                      enc_rows_dot(threads, n_a, c, n_b, d, m->columns, of_w);
    for (size_t i = 0; i < n_a * n_b && done; i++) {
        *io_sum += factor * of_u[i] * of_w[i];
    }
    free(of_u);
    free(of_w);
    return done;
}

/* Rounds the components to a plan and finds the squared error that the codes leave of them. */
static btf_result error_of(const enc_factor_matrix *m, const enc_components components[ENC_FACTOR_CHANNELS],
                           const enc_factor_plan *plan, int sweeps, double *out_error) {
    enc_factor_codes codes;
    btf_result result = enc_factor_codes_create(m, plan, components, &codes);
    if (result == BTF_OK) {
        result = enc_factor_round(m, components, sweeps, &codes);
    }
    *out_error = 0;
    for (int c = 0; c < ENC_FACTOR_CHANNELS && result == BTF_OK; c++) {
        const enc_components *from = &components[c];
        const enc_factor_channel *to = &codes.channel[c];
        bool room = true;
        for (size_t j = 0; j < from->rank; j++) {
            *out_error += from->energy[j];
        }
        if (to->rank > 0) {
            room = add_products(m, to->rank, to->u, to->w, to->rank, to->u, to->w, 1, out_error) &&
                   add_products(m, to->rank, to->u, to->w, from->rank, from->u, from->w, -2, out_error);
        }
        result = room ? BTF_OK : no_memory(m);
    }
    enc_factor_codes_clear(&codes);
    return result;
}

/* Makes the plan that the allocation finds with a pair of shares; false where none fits, or an earlier pair
 * gave the same. */
static bool think(const enc_factor_matrix *m, const enc_components components[ENC_FACTOR_CHANNELS],
                  const double thought[2], uint64_t budget, const enc_factor_plan *known, int n_known,
                  enc_factor_plan *out) {
    double rounding[ENC_FACTOR_CLASSES];
    enc_factor_energies energies = enc_components_energies(components);
    energies.rounding = rounding;
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        const size_t tier = enc_factor_classes[k].tier;
        rounding[k] = enc_factor_classes[k].error * (tier > 0 ? thought[tier - 1] : 1);
    }
    bool found = enc_factor_allocate(&energies, m->texels, (size_t)m->data->n_views,
                                     (size_t)m->data->n_lights, budget, out);
    for (int i = 0; i < n_known && found; i++) {
        found = memcmp(&known[i], out, sizeof *out) != 0;
    }
    return found;
}

btf_result enc_choose_plan(const enc_factor_matrix *m, const enc_components components[ENC_FACTOR_CHANNELS],
                           uint64_t budget, int sweeps, enc_factor_plan *io_plan) {
    enc_factor_plan plans[1 + THOUGHTS];
    double least = INFINITY;
    int count = 1, best = 0;
    plans[0] = *io_plan;
    if (enc_factor_all_units(io_plan) > ENC_CHOOSE_MOST_UNITS) {
        return BTF_OK;
    }
    for (int i = 0; i < THOUGHTS; i++) {
        count += think(m, components, thoughts[i], budget, plans, count, &plans[count]);
    }
    for (int i = 0; i < count && count > 1; i++) {
        double error;
        const btf_result result =
            error_of(m, components, &plans[i], sweeps < MOST_SWEEPS ? sweeps : MOST_SWEEPS, &error);
        if (result != BTF_OK) {
            return result;
        }
        best = error < least ? i : best;
        least = fmin(error, least);
    }
    *io_plan = plans[best];
    return BTF_OK;
}
