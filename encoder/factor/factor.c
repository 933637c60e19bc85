/* Factorise, allocate, round, pack. See factor.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factor.h"

#include "encoder/base/stage.h"
#include "pack.h"
#include "round.h"

#include <stdlib.h>
#include <string.h>

enum {
    POWER_STEPS = 1,
    CHROMA_SHARE = 8, /* luma has so many times the components of a chroma channel, to begin with */
    SPARE = 24,       /* components beyond what the budget is thought to hold */
};

/* Bits of a code of which a budget thinks: measured materials take 3.3. */
#define MEAN_BITS 3.2

/* Components of luma and chroma that are looked for first. */
static void first_ranks(size_t texels, size_t columns, uint64_t budget, size_t out[ENC_FACTOR_CHANNELS]) {
    const size_t side = texels < columns ? texels : columns;
    const double fits = (double)budget * 8 / MEAN_BITS / (double)(texels + columns);
    const size_t luma = fits < (double)side ? (size_t)fits + SPARE : side;
    out[0] = luma < side ? luma : side;
    out[1] = out[2] = luma / CHROMA_SHARE + SPARE < side ? luma / CHROMA_SHARE + SPARE : side;
}

static enc_factor_energies energies_of(const enc_components components[ENC_FACTOR_CHANNELS]) {
    enc_factor_energies e;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        e.rank[c] = components[c].rank;
        e.energy[c] = components[c].energy;
    }
    return e;
}

/* How many components a channel should have had: 0, enough; it was found short where all that were found
 * are kept, up to a word, and there are more. */
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

/* The plan for components: without a tolerance one that fills the budget, else one that leaves out what is
 * noise and stops where more bytes do not pay. asked: channels that were found anew. */
static btf_result make_plan(const enc_factor_matrix *m, const enc_factor_options *options,
                            const enc_components components[ENC_FACTOR_CHANNELS],
                            const bool asked[ENC_FACTOR_CHANNELS], enc_signal *io_signal,
                            enc_factor_plan *plan, enc_unspent *unspent) {
    const size_t views = (size_t)m->data->n_views, lights = (size_t)m->data->n_lights;
    const enc_factor_energies energies = energies_of(components);
    const bool stops = options->tolerance > 0;
    const btf_result result = stops ? enc_signal_find(m, components, asked, io_signal) : BTF_OK;
    if (result != BTF_OK) {
        return result;
    }
    const bool planned =
        stops ? enc_stop_allocate(&energies, io_signal, m->texels, views, lights, options->budget,
                                  options->tolerance, plan, unspent)
              : enc_factor_allocate(&energies, m->texels, views, lights, options->budget, plan);
    return planned ? BTF_OK : enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory");
}

/* Components and the plan for them; channels that turn out short are found again, with twice as many,
 * unless what was found ends in noise. */
static btf_result factorise(const enc_factor_matrix *m, const enc_factor_options *options,
                            enc_components components[ENC_FACTOR_CHANNELS], enc_factor_plan *plan,
                            enc_unspent *unspent) {
    size_t ranks[ENC_FACTOR_CHANNELS];
    enc_signal signal = {0};
    btf_result result = BTF_OK;
    first_ranks(m->texels, m->columns, options->budget, ranks);
    for (bool again = true; again && result == BTF_OK;) {
        bool asked[ENC_FACTOR_CHANNELS];
        for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
            asked[c] = ranks[c] > 0;
        }
        enc_stage_begin(m->context, "factorise", 2 * (POWER_STEPS + 1) * m->texels);
        result = enc_components_find(m, ranks, POWER_STEPS, components);
        enc_stage_end(m->context);
        result =
            result == BTF_OK ? make_plan(m, options, components, asked, &signal, plan, unspent) : result;
        again = false;
        for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
            const bool noise = unspent->budget > 0 && signal.rank[c] < components[c].rank;
            ranks[c] = noise ? 0 : missing(m, &components[c], plan, c);
            again = again || ranks[c] > 0;
        }
    }
    enc_signal_clear(&signal);
    return result;
}

/* An empty result of a plan's shape. */
static enc_factors *factors_create(const enc_data *data, const enc_factor_plan *plan) {
    enc_factors *f = calloc(1, sizeof *f);
    if (!f) {
        return NULL;
    }
    const size_t texels = enc_data_texel_count(data),
                 columns = (size_t)data->n_views * (size_t)data->n_lights;
    f->width = data->width;
    f->height = data->height;
    f->n_views = data->n_views;
    f->n_lights = data->n_lights;
    f->n_units = (int)enc_factor_all_units(plan);
    f->n_u_texels = (int)enc_factor_u_texels(plan);
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        f->classes[k][0] = enc_factor_units(plan, k);
        f->classes[k][1] = plan->words[k][1];
        f->classes[k][2] = plan->words[k][2];
    }
    f->bytes = enc_factor_bytes(plan, texels, (size_t)data->n_views, (size_t)data->n_lights);
    f->texels = calloc((size_t)f->n_u_texels * texels * 4, sizeof *f->texels);
    f->directions = calloc((size_t)f->n_units * columns * 4, sizeof *f->directions);
    f->scales = calloc((size_t)f->n_units * 4, sizeof *f->scales);
    if (!f->texels || !f->directions || !f->scales) {
        enc_factors_destroy(&f);
    }
    return f;
}

void enc_factors_destroy(enc_factors **factors) {
    if (factors && *factors) {
        free((*factors)->texels);
        free((*factors)->directions);
        free((*factors)->scales);
        free((*factors)->views);
        free(*factors);
        *factors = NULL;
    }
}

/* Rounded codes to the result, which takes the views' factors. */
static btf_result deliver(const enc_factor_matrix *m, enc_factor_codes *codes, enc_factor_error error,
                          enc_factors **out) {
    enc_factors *f = factors_create(m->data, &codes->plan);
    if (!f) {
        return enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory");
    }
    enc_factor_pack(m->context, codes, f->texels, f->directions, f->scales);
    f->views = codes->view;
    codes->view = NULL;
    f->error = error;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        f->components[c] = codes->channel[c].rank;
    }
    *out = f;
    return BTF_OK;
}

static btf_result encode(const enc_factor_matrix *m, const enc_factor_options *options,
                         enc_components components[ENC_FACTOR_CHANNELS], enc_factors **out) {
    enc_factor_plan plan;
    enc_factor_codes codes = {0};
    enc_factor_error error = {0};
    enc_unspent unspent = {0};
    btf_result result = factorise(m, options, components, &plan, &unspent);
    result = result == BTF_OK ? enc_factor_codes_create(m, &plan, components, &codes) : result;
    if (result == BTF_OK) {
        enc_stage_begin(m->context, "round factors",
                        (size_t)enc_factor_round_passes(options->sweeps) * m->texels);
        result = enc_factor_round(m, components, options->sweeps, &codes);
        enc_stage_end(m->context);
    }
    if (result == BTF_OK && options->measure) {
        enc_stage_begin(m->context, "measure factors", m->texels);
        result = enc_factor_measure(m, &codes, &error);
        enc_stage_end(m->context);
    }
    result = result == BTF_OK ? deliver(m, &codes, error, out) : result;
    if (result == BTF_OK) {
        (*out)->unspent = unspent;
    }
    enc_factor_codes_clear(&codes);
    return result;
}

btf_result enc_factor_encode(const enc_context *context, const enc_data *data,
                             const enc_factor_options *options, enc_factors **out_factors) {
    const enc_factor_matrix m = enc_factor_matrix_of(context, data);
    const uint64_t least =
        enc_factor_least_budget(data->width, data->height, data->n_views, data->n_lights);
    enc_components components[ENC_FACTOR_CHANNELS] = {{0}};
    *out_factors = NULL;
    if (options->budget < least) {
        return enc_fail(context, BTF_ERROR_USAGE,
                        "factors: a budget of %llu bytes holds no unit, which takes %llu",
                        (unsigned long long)options->budget, (unsigned long long)least);
    }
    const btf_result result = encode(&m, options, components, out_factors);
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        enc_components_clear(&components[c]);
    }
    return result;
}

uint64_t enc_factor_least_budget(int width, int height, int n_views, int n_lights) {
    const enc_factor_plan one = {{{ENC_FACTOR_UNIT_WORDS, 0, 0}}};
    return enc_factor_bytes(&one, (size_t)width * (size_t)height, (size_t)n_views, (size_t)n_lights);
}

uint64_t enc_factor_memory(int width, int height, int n_views, int n_lights, uint64_t budget, int threads) {
    const size_t texels = (size_t)width * (size_t)height, columns = (size_t)n_views * (size_t)n_lights;
    size_t ranks[ENC_FACTOR_CHANNELS];
    first_ranks(texels, columns, budget, ranks);
    const uint64_t rank = ranks[0] + ranks[1] + ranks[2], longest = texels > columns ? texels : columns;
    const uint64_t factors = sizeof(float) * rank * (texels + columns);
    const uint64_t square = (uint64_t)ranks[0] * ranks[0];
    /* the range finder turns one copy of the factors into another; then components, codes and a product */
    return 2 * factors + sizeof(float) * rank * longest + 24 * square + budget +
           enc_factor_product_memory(columns, rank, threads);
}
