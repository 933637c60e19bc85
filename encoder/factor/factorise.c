/* Components and the plan for them. See factorise.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factorise.h"

#include "choose_plan.h"
#include "encoder/base/stage.h"
#include "stop.h"

enum {
    POWER_STEPS = 1,
    CHROMA_SHARE = 8, /* luma is first searched for so many times the components of a chroma channel */
    SPARE = 24,       /* components beyond what the budget is thought to hold */
};

/* Bits of a factor, by which the number of components that a budget holds is estimated. Measured materials
 * take 3.3. */
#define MEAN_BITS 3.2

double enc_factorise_expected(uint64_t budget) {
    return (double)budget * 8 / MEAN_BITS;
}

void enc_factorise_first_ranks(size_t texels, size_t columns, uint64_t budget,
                               size_t out[ENC_FACTOR_CHANNELS]) {
    const size_t side = texels < columns ? texels : columns;
    const double fits = enc_factorise_expected(budget) / (double)(texels + columns);
    const size_t luma = fits < (double)side ? (size_t)fits + SPARE : side;
    out[0] = luma < side ? luma : side;
    out[1] = out[2] = luma / CHROMA_SHARE + SPARE < side ? luma / CHROMA_SHARE + SPARE : side;
}

/* The number of components to search for again; 0 where enough were found. Too few were found where the plan keeps
 * all of them, up to a word, and the matrix has more. */
static size_t missing(const enc_factor_matrix *m, const enc_components *components,
                      const enc_factor_plan *plan, int channel) {
    const size_t side = m->texels < m->columns ? m->texels : m->columns;
    size_t kept = 0;
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        kept += enc_factor_held(plan, k, channel, components->rank);
    }
    const bool all = kept + ENC_FACTOR_MOST_WORD > components->rank;
    const bool more = components->rank == components->sought && components->sought < side;
    return all && more ? 2 * components->sought : 0;
}

/* Makes the plan for components: without a tolerance one that fills the budget, else one that leaves out
 * what is noise and stops where more bytes do not pay. asked: channels whose components are new. */
static btf_result make_plan(const enc_factor_matrix *m, uint64_t budget, double tolerance,
                            const enc_components components[ENC_FACTOR_CHANNELS],
                            const bool asked[ENC_FACTOR_CHANNELS], enc_signal *io_signal,
                            enc_factor_plan *plan, enc_unspent *unspent) {
    const size_t views = (size_t)m->data->n_views, lights = (size_t)m->data->n_lights;
    const enc_factor_energies energies = enc_components_energies(components);
    const bool stops = tolerance > 0;
    const btf_result result = stops ? enc_signal_find(m, components, asked, io_signal) : BTF_OK;
    if (result != BTF_OK) {
        return result;
    }
    const bool planned = stops ? enc_stop_allocate(&energies, io_signal, m->texels, views, lights, budget,
                                                   tolerance, plan, unspent)
                               : enc_factor_allocate(&energies, m->texels, views, lights, budget, plan);
    return planned ? BTF_OK : enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory");
}

uint64_t enc_factorise_equal_bytes(const enc_factor_matrix *m, uint64_t budget,
                                   const enc_unspent *unspent) {
    const uint64_t unit = 16 * (uint64_t)(m->texels + m->columns);
    return unspent->budget > 0 && unspent->bytes + unit <= budget ? unspent->bytes : budget;
}

btf_result enc_factorise(const enc_factor_matrix *m, uint64_t budget, double tolerance, int sweeps,
                         enc_components components[ENC_FACTOR_CHANNELS], enc_factor_plan *plan,
                         enc_unspent *unspent) {
    size_t ranks[ENC_FACTOR_CHANNELS];
    enc_signal signal = {0};
    btf_result result = BTF_OK;
    enc_factorise_first_ranks(m->texels, m->columns, budget, ranks);
    for (bool again = true; again && result == BTF_OK;) {
        bool asked[ENC_FACTOR_CHANNELS];
        for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
            asked[c] = ranks[c] > 0;
        }
        enc_stage_begin(m->context, "factorise", 2 * (POWER_STEPS + 1) * m->texels);
        result = enc_components_find(m, ranks, POWER_STEPS, components);
        enc_stage_end(m->context);
        if (result == BTF_OK) {
            result = make_plan(m, budget, tolerance, components, asked, &signal, plan, unspent);
        }
        again = false;
        for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
            const bool noise = unspent->budget > 0 && signal.rank[c] < components[c].rank;
            ranks[c] = noise ? 0 : missing(m, &components[c], plan, c);
            again = again || ranks[c] > 0;
        }
    }
    enc_signal_clear(&signal);
    return result == BTF_OK
               ? enc_choose_plan(m, components, enc_factorise_equal_bytes(m, budget, unspent), sweeps, plan)
               : result;
}
