/* Factorise, allocate, round, pack. See factor.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factor.h"

#include "decoder/toolkit/progress.h"
#include "encoder/base/stage.h"
#include "match_fit.h"
#include "pack.h"
#include "round.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    POWER_STEPS = 1,
    CHROMA_SHARE = 8, /* luma has so many times the components of a chroma channel, to begin with */
    SPARE = 24,       /* components beyond what the budget is thought to hold */
};

/* Match is tried to the end where a survey expects at most this much of the squared error that the whole
 * budget leaves without it, and kept where it gains at least so many dB, the mean of those of linear and of
 * sRGB-coded values. What a survey expects, after one round of four to seven, is too much: at 2.36 MB and 64x64
 * texels 0.92 for bricks, which gain 0.83 dB in the end, 1.03 for BRICKS64, 0.45 dB, 1.10 for UBO_IMPALLA64, which
 * loses 0.36. */
#define MAY_PAY 1.07
#define MUST_GAIN 0.05

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

/* Components and the plan for them; channels that turn out short are found again, with twice as many. */
static btf_result factorise(const enc_factor_matrix *m, uint64_t budget,
                            enc_components components[ENC_FACTOR_CHANNELS], enc_factor_plan *plan) {
    const size_t views = (size_t)m->data->n_views, lights = (size_t)m->data->n_lights;
    size_t ranks[ENC_FACTOR_CHANNELS];
    first_ranks(m->texels, m->columns, budget, ranks);
    for (;;) {
        const btf_result result = enc_components_find(m, ranks, POWER_STEPS, components);
        if (result != BTF_OK) {
            return result;
        }
        const enc_factor_energies energies = energies_of(components);
        if (!enc_factor_allocate(&energies, m->texels, views, lights, budget, plan)) {
            return enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory");
        }
        bool again = false;
        for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
            ranks[c] = missing(m, &components[c], plan, c);
            again = again || ranks[c] > 0;
        }
        if (!again) {
            return BTF_OK;
        }
    }
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
        free((*factors)->shift);
        free((*factors)->gain);
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

/* What an encode finds. */
typedef struct found {
    enc_components components[ENC_FACTOR_CHANNELS];
    enc_factor_plan plan;
    enc_match match; /* of ENC_FACTOR_MATCH */
    enc_match_bases bases;
    enc_factor_codes codes;
    enc_factor_trial trial;
} found;

static void clear(found *f) {
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        enc_components_clear(&f->components[c]);
    }
    enc_match_clear(&f->match);
    enc_match_bases_clear(&f->bases);
    enc_factor_codes_clear(&f->codes);
}

/* Bytes of lists of match, where there is one. */
static uint64_t match_bytes(const enc_factor_matrix *m, const enc_factor_options *options) {
    return enc_match_bytes(m->texels, (size_t)m->data->n_views, options->gain);
}

static btf_result find(const enc_factor_matrix *m, uint64_t budget, found *f) {
    enc_stage_begin(m->context, "factorise", 2 * (POWER_STEPS + 1) * m->texels);
    const btf_result result = factorise(m, budget, f->components, &f->plan);
    enc_stage_end(m->context);
    return result;
}

static btf_result measure(const enc_factor_matrix *m, const enc_factor_options *options, found *f) {
    btf_result result = BTF_OK;
    if (options->measure || options->match == ENC_FACTOR_CHOOSE_MATCH) {
        enc_stage_begin(m->context, "measure factors", m->texels);
        result = enc_factor_measure(m, &f->codes, &f->trial.error);
        enc_stage_end(m->context);
    }
    return result;
}

/* Without match, from components and plan. */
static btf_result encode_plain(const enc_factor_matrix *m, const enc_factor_options *options, found *f) {
    btf_result result = enc_factor_codes_create(m, &f->plan, f->components, &f->codes);
    if (result == BTF_OK) {
        enc_stage_begin(m->context, "round factors",
                        (size_t)enc_factor_round_passes(options->sweeps) * m->texels);
        result = enc_factor_round(m, f->components, options->sweeps, &f->codes);
        enc_stage_end(m->context);
    }
    return result == BTF_OK ? measure(m, options, f) : result;
}

/* Sources for the components, and others in their place; trial.given_up where they leave more than `most`.
 */
static btf_result find_match(const enc_factor_matrix *m, const enc_factor_options *options, double most,
                             found *f) {
    double share = 1;
    enc_stage_begin(m->context, "match", 2 * ENC_MATCH_ROUNDS * m->texels);
    btf_result result = enc_match_create(m->context, m->data->width, m->data->height,
                                         (size_t)m->data->n_views, options->gain, &f->match);
    result = result == BTF_OK ? enc_match_find_bases(m, &f->bases) : result;
    result = result == BTF_OK ? enc_match_fit(m, options->budget - match_bytes(m, options), &f->bases, most,
                                              &f->match, f->components, &f->plan, &share)
                              : result;
    enc_stage_end(m->context);
    f->trial.given_up = !(share <= most);
    if (result == BTF_OK && most < HUGE_VAL) {
        enc_log(m->context, BTF_LOG_INFO,
                "match: a survey leaves %.3f of the squared error, of %.3f that would pay%s", share, most,
                f->trial.given_up ? ": given up" : "");
    }
    return result;
}

/* With match, from components and plan for what the lists leave of the budget. */
static btf_result encode_matched(const enc_factor_matrix *plain, const enc_factor_options *options,
                                 double most, found *f) {
    enc_factor_matrix m = *plain;
    m.match = &f->match;
    btf_result result = find_match(plain, options, most, f);
    if (result != BTF_OK || f->trial.given_up) {
        return result;
    }
    result = enc_factor_codes_create(plain, &f->plan, f->components, &f->codes);
    if (result == BTF_OK) {
        enc_stage_begin(m.context, "round factors", 2 * (size_t)ENC_MATCH_CODE_ROUNDS * m.texels);
        result = enc_factor_round(plain, f->components, 0, &f->codes);
        result = result == BTF_OK ? enc_match_round(&m, &f->bases, &f->match, &f->codes) : result;
        enc_stage_end(m.context);
    }
    return result == BTF_OK ? measure(&m, options, f) : result;
}

static void end_trial(const enc_factor_matrix *m, const enc_factor_options *options, double begin,
                      found *f) {
    enc_factor_trial *trial = &f->trial;
    trial->core_seconds = progress_core_clock() - begin;
    if (!trial->given_up) {
        const uint64_t lists = trial->match ? match_bytes(m, options) : 0;
        trial->n_units = (int)enc_factor_all_units(&f->codes.plan);
        trial->bytes = lists + enc_factor_bytes(&f->codes.plan, m->texels, f->codes.views, f->codes.lights);
    }
}

/* The one encode that is wanted. */
static btf_result encode_one(const enc_factor_matrix *m, const enc_factor_options *options, found *f) {
    const double begin = progress_core_clock();
    f->trial.match = options->match == ENC_FACTOR_MATCH;
    btf_result result = find(m, options->budget - (f->trial.match ? match_bytes(m, options) : 0), f);
    if (result == BTF_OK) {
        result = f->trial.match ? encode_matched(m, options, HUGE_VAL, f) : encode_plain(m, options, f);
    }
    if (result == BTF_OK) {
        end_trial(m, options, begin, f);
        f->trial.kept = true;
    }
    return result;
}

/* dB of the mean of linear and sRGB-coded values that b gains over a. */
static double gained(enc_factor_error a, enc_factor_error b) {
    return 5 * log10(fmax(a.linear, 1e-10) / fmax(b.linear, 1e-10)) +
           5 * log10(fmax(a.srgb, 1e-10) / fmax(b.srgb, 1e-10));
}

/* The components of the encode without match go to the one with it, with a plan for what the lists leave.
 * Returns the share of its error that may be left where it is to pay; 0 where it cannot. */
static double hand_over(const enc_factor_matrix *m, const enc_factor_options *options, found *plain,
                        found *matched) {
    const uint64_t lists = match_bytes(m, options);
    const enc_factor_energies energies = energies_of(plain->components);
    if (options->budget <= lists || !m->data->samples ||
        !enc_factor_allocate(&energies, m->texels, plain->codes.views, plain->codes.lights,
                             options->budget - lists, &matched->plan)) {
        return 0;
    }
    const double whole = enc_factor_error_left(&energies, &plain->plan);
    const double rest = enc_factor_error_left(&energies, &matched->plan);
    memcpy(matched->components, plain->components, sizeof plain->components);
    memset(plain->components, 0, sizeof plain->components);
    return rest > 0 ? MAY_PAY * whole / rest : 0;
}

/* Both encodes, at the same bytes. */
static btf_result encode_both(const enc_factor_matrix *m, const enc_factor_options *options, found *plain,
                              found *matched) {
    double begin = progress_core_clock();
    btf_result result = find(m, options->budget, plain);
    result = result == BTF_OK ? encode_plain(m, options, plain) : result;
    if (result != BTF_OK) {
        return result;
    }
    end_trial(m, options, begin, plain);
    begin = progress_core_clock();
    matched->trial.match = true;
    const double most = hand_over(m, options, plain, matched);
    matched->trial.given_up = !(most > 0);
    if (most > 0) {
        result = encode_matched(m, options, most, matched);
        end_trial(m, options, begin, matched);
    }
    matched->trial.kept =
        !matched->trial.given_up && gained(plain->trial.error, matched->trial.error) >= MUST_GAIN;
    plain->trial.kept = !matched->trial.kept;
    return result;
}

/* Shifts and gains to the result, and the bytes of the points. */
static btf_result deliver_match(const enc_factor_matrix *m, const enc_match *match, bool gain,
                                enc_factors *out) {
    const size_t points = match->texels * match->views;
    out->shift = malloc(2 * points);
    out->gain = malloc(points);
    out->gain_scale = match->gains.scale;
    out->match_bytes = enc_match_bytes(match->texels, match->views, gain);
    out->bytes += out->match_bytes;
    if (!out->shift || !out->gain) {
        return enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory");
    }
    enc_match_store(match, out->shift, out->gain);
    return BTF_OK;
}

static btf_result deliver_all(const enc_factor_matrix *m, const enc_factor_options *options, found *f,
                              enc_factors **out) {
    btf_result result = deliver(m, &f->codes, f->trial.error, out);
    if (result == BTF_OK && f->trial.match) {
        result = deliver_match(m, &f->match, options->gain, *out);
    }
    if (result != BTF_OK) {
        enc_factors_destroy(out);
    }
    return result;
}

btf_result enc_factor_encode(const enc_context *context, const enc_data *data,
                             const enc_factor_options *options, enc_factors **out_factors) {
    const enc_factor_matrix m = enc_factor_matrix_of(context, data);
    const bool match = options->match == ENC_FACTOR_MATCH, both = options->match == ENC_FACTOR_CHOOSE_MATCH;
    const uint64_t least =
        enc_factor_least_budget(data->width, data->height, data->n_views, data->n_lights) +
        (match ? match_bytes(&m, options) : 0);
    found f[2] = {{.trial = {0}}};
    *out_factors = NULL;
    if (options->budget < least) {
        return enc_fail(context, BTF_ERROR_USAGE,
                        "factors: a budget of %llu bytes holds no unit, which takes %llu",
                        (unsigned long long)options->budget, (unsigned long long)least);
    }
    if (match && !data->samples) {
        return enc_fail(
            context, BTF_ERROR_UNSUPPORTED,
            "factors: effect shift: the samples do not fit the memory allowed, where match needs them");
    }
    btf_result result = both ? encode_both(&m, options, &f[0], &f[1]) : encode_one(&m, options, &f[0]);
    if (result == BTF_OK) {
        result = deliver_all(&m, options, &f[both && f[1].trial.kept], out_factors);
    }
    for (int i = 0; i <= both && result == BTF_OK; i++) {
        (*out_factors)->trials[(*out_factors)->n_trials++] = f[i].trial;
    }
    clear(&f[0]);
    clear(&f[1]);
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
           enc_factor_product_memory(texels, columns, rank, threads);
}
