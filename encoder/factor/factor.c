/* Encodes with and without match, and keeps the better. See factor.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factor.h"

#include "choose_plan.h"
#include "decoder/toolkit/progress.h"
#include "empty_places.h"
#include "encoder/base/stage.h"
#include "encoder/factor/match/fit.h"
#include "factorise.h"
#include "round.h"
#include "steps.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Match is tried to the end where a survey expects it to leave at most MAY_PAY of the squared error that
 * the same bytes leave without it, and at most MAY_LEAVE of that which its own factors leave without
 * sources; it is kept where it gains at least MUST_GAIN dB, the mean of those of linear and of sRGB-coded
 * values. A survey overstates the error, as it follows the first of four to seven rounds. Both figures and
 * the gains, of 64x64 texels and 81 directions at 2.36 MB: bricks of btf-sample 0.91, 0.71, 0.80 dB;
 * BRICKS64 0.99, 0.78, 0.45 dB; bumps 1.07, 0.81, 0.52 dB; UBO_IMPALLA64 1.10, 0.95, -0.36 dB. Of 32x32
 * texels: weave 0.70, 0.57, 1.81 dB; bricks 0.79, 0.68, 1.34 dB; bumps 0.85, 0.72, 0.52 dB; flat 0.99,
 * 0.99, -0.76 dB. */
#define MAY_PAY 1.12
#define MAY_LEAVE 0.88
#define MUST_GAIN 0.05

/* Makes an empty result of a plan's shape. */
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

/* Packs rounded codes into the result, and moves the views' factors there. */
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

/* One candidate: its components, and the codes that they are rounded to. */
typedef struct found {
    enc_components components[ENC_FACTOR_CHANNELS];
    bool borrowed; /* the components belong to options->basis */
    enc_factor_plan plan;
    enc_match match; /* sources and gains, of a candidate with match */
    enc_match_bases bases;
    enc_factor_codes codes;
    enc_unspent unspent;
    enc_factor_trial trial;
    enc_factors *packed; /* NULL: given up */
} found;

static void clear(found *f) {
    for (int c = 0; c < ENC_FACTOR_CHANNELS && !f->borrowed; c++) {
        enc_components_clear(&f->components[c]);
    }
    enc_match_clear(&f->match);
    enc_match_bases_clear(&f->bases);
    enc_factor_codes_clear(&f->codes);
    enc_factors_destroy(&f->packed);
}

/* Bytes of the lists of a match. */
static uint64_t match_bytes(const enc_factor_matrix *m) {
    return enc_match_bytes(m->texels, (size_t)m->data->n_views);
}

/* Bytes of the components that are kept for further encodes; match works on a copy of them. */
static uint64_t basis_bytes(const enc_factor_matrix *m, const enc_factor_options *options) {
    uint64_t components = 0;
    for (int c = 0; c < ENC_FACTOR_CHANNELS && options->basis; c++) {
        components += options->basis[c].sought;
    }
    return sizeof(float) * components * (m->texels + m->columns);
}

/* Whether match may be tried: the samples have to lie in memory, with room for the match beside them, and
 * more room if `whole` holds the coordinates of the whole texture. */
static bool has_room(const enc_factor_matrix *m, const enc_factor_options *options, bool whole) {
    const enc_data *d = m->data;
    const uint64_t budget = options->budget;
    const uint64_t samples = 4 * (uint64_t)enc_data_texel_count(d) * enc_data_texel_stride(d);
    const uint64_t all =
        samples + basis_bytes(m, options) +
        enc_factor_match_memory(d->width, d->height, d->n_views, budget, whole) +
        enc_factor_memory(d->width, d->height, d->n_views, d->n_lights, budget, m->context->threads);
    return d->samples && (m->context->memory == 0 || all <= m->context->memory);
}

/* Measures the error of a candidate, where candidates are compared or the caller asks for it. */
static btf_result measure(const enc_factor_matrix *m, const enc_factor_options *options, found *f) {
    btf_result result = BTF_OK;
    if (options->measure || (options->match == ENC_FACTOR_CHOOSE_MATCH && has_room(m, options, false))) {
        enc_stage_begin(m->context, "measure factors", m->texels);
        result = enc_factor_measure(m, &f->codes, &f->trial.error);
        enc_stage_end(m->context);
    }
    return result;
}

static void end_trial(const enc_factor_matrix *m, double begin, found *f) {
    enc_factor_trial *trial = &f->trial;
    trial->core_seconds = progress_core_clock() - begin;
    if (!trial->omitted) {
        trial->n_units = (int)enc_factor_all_units(&f->codes.plan);
        trial->bytes = enc_factor_bytes(&f->codes.plan, m->texels, f->codes.views, f->codes.lights) +
                       (trial->match ? match_bytes(m) : 0);
    }
}

/* Moves shifts and gains to the result, and counts the bytes of their lists. */
static btf_result deliver_match(const enc_factor_matrix *m, const enc_match *match, enc_factors *out) {
    const size_t points = match->texels * match->views;
    out->shift = malloc(2 * points);
    out->gain = malloc(points);
    out->gain_base = match->gains.base;
    out->gain_step = match->gains.step;
    out->point_entries = (int)enc_match_entries(match->views);
    out->match_bytes = match_bytes(m);
    out->bytes += out->match_bytes;
    if (!out->shift || !out->gain) {
        return enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory");
    }
    enc_match_store(match, out->shift, out->gain);
    return BTF_OK;
}

/* Packs a candidate, hands it to the checkpoint, and frees its codes. */
static btf_result finish(const enc_factor_matrix *m, const enc_factor_options *options, double begin,
                         found *f) {
    btf_result result = BTF_OK;
    end_trial(m, begin, f);
    if (!f->trial.omitted) {
        result = deliver(m, &f->codes, f->trial.error, &f->packed);
        if (result == BTF_OK && f->trial.match) {
            result = deliver_match(m, &f->match, f->packed);
        }
        enc_factor_codes_clear(&f->codes);
    }
    return result == BTF_OK ? enc_factor_keep_candidate(m, options->number, &f->trial, f->packed) : result;
}

/* Encodes without match, from components and plan. */
static btf_result encode_plain(const enc_factor_matrix *m, const enc_factor_options *options, double begin,
                               found *f) {
    if (enc_factor_take_candidate(m, options->number, &f->trial, &f->packed)) {
        const bool compared = options->match == ENC_FACTOR_CHOOSE_MATCH && has_room(m, options, false);
        if (!compared || f->trial.error.linear > 0) {
            return BTF_OK;
        }
        enc_factors_destroy(&f->packed); /* it comes from a run without room for match, which measured
                                            nothing */
        f->trial = (enc_factor_trial){0};
    }
    btf_result result = enc_factor_codes_create(m, &f->plan, f->components, &f->codes);
    if (result == BTF_OK) {
        enc_stage_begin(m->context, "round factors",
                        (size_t)enc_factor_round_passes(options->sweeps) * m->texels);
        result = enc_factor_round(m, f->components, options->sweeps, &f->codes);
        enc_stage_end(m->context);
    }
    if (result == BTF_OK) {
        result = enc_factor_fill_places(m, f->components, &f->codes);
    }
    if (result == BTF_OK) {
        result = measure(m, options, f);
    }
    return result == BTF_OK ? finish(m, options, begin, f) : result;
}

/* Finds sources, and components that fit them in the place of those given; sets trial.omitted where these
 * leave more than `most` of the squared error. */
static btf_result find_match(const enc_factor_matrix *m, const enc_factor_options *options, uint64_t budget,
                             double most, found *f) {
    double share = 1;
    enc_stage_begin(m->context, "match", 2 * ENC_MATCH_ROUNDS * m->texels);
    btf_result result = enc_match_create(m->context, m->data->width, m->data->height,
                                         (size_t)m->data->n_views, options->gain, &f->match);
    f->match.whole = has_room(m, options, true);
    if (result == BTF_OK) {
        result = enc_match_find_bases(m, &f->bases);
    }
    if (result == BTF_OK &&
        !enc_factor_take_match(m, options->number, &f->match, f->components, &f->plan, &share)) {
        result = enc_match_fit(m, budget, &f->bases, most, &f->match, f->components, &f->plan, &share);
        if (result == BTF_OK) {
            result = enc_factor_keep_match(m, options->number, &f->match, f->components, &f->plan, share);
        }
    }
    enc_stage_end(m->context);
    f->trial.omitted = share <= most ? ENC_FACTOR_ENCODED : ENC_FACTOR_SURVEYED;
    if (result == BTF_OK && most < HUGE_VAL) {
        enc_log(
            m->context, BTF_LOG_INFO,
            "match: a first search leaves %.3f of the squared error; it pays where at most %.3f is left%s",
            share, most, f->trial.omitted ? ": given up" : "");
    }
    return result;
}

/* Encodes with match, from components and a plan for `budget`, the bytes that the lists leave. */
static btf_result encode_matched(const enc_factor_matrix *plain, const enc_factor_options *options,
                                 uint64_t budget, double most, double begin, found *f) {
    enc_factor_matrix m = *plain;
    /* in proportion to the preset's sweeps; a preset without sweeps comes here only if the user asked for
     * match */
    const int some = options->sweeps * ENC_MATCH_CODE_ROUNDS / ENC_FACTOR_SWEEPS;
    const int rounds = some > 1 ? some : 1;
    m.match = &f->match;
    btf_result result = find_match(plain, options, budget, most, f);
    if (result == BTF_OK && !f->trial.omitted) {
        result = enc_factor_codes_create(plain, &f->plan, f->components, &f->codes);
        if (result == BTF_OK) {
            enc_stage_begin(m.context, "round factors", 2 * (size_t)rounds * m.texels);
            result = enc_factor_round(plain, f->components, 0, &f->codes);
            if (result == BTF_OK) {
                result = enc_match_round(&m, &f->bases, rounds, &f->match, &f->codes);
            }
            enc_stage_end(m.context);
        }
        if (result == BTF_OK) {
            result = measure(&m, options, f);
        }
    }
    return result == BTF_OK ? finish(plain, options, begin, f) : result;
}

/* dB that b gains over a, the mean of linear and sRGB-coded values. */
static double gained(enc_factor_error a, enc_factor_error b) {
    return 5 * log10(fmax(a.linear, 1e-10) / fmax(b.linear, 1e-10)) +
           5 * log10(fmax(a.srgb, 1e-10) / fmax(b.srgb, 1e-10));
}

/* Gives the components of one candidate to the other, with a plan for `budget`, which is part of `bytes`.
 * *out_most: the share of the squared error of that plan's components that match may leave if it is to pay,
 * by the errors that the allocation expects of both plans. Those of a plan that was chosen by trial it
 * overstates. */
static btf_result hand_over(const enc_factor_matrix *m, uint64_t bytes, uint64_t budget, found *plain,
                            found *matched, double *out_most) {
    const enc_factor_energies energies = enc_components_energies(plain->components);
    const size_t views = (size_t)m->data->n_views, lights = (size_t)m->data->n_lights;
    enc_factor_plan all;
    if (!enc_factor_allocate(&energies, m->texels, views, lights, bytes, &all) ||
        !enc_factor_allocate(&energies, m->texels, views, lights, budget, &matched->plan)) {
        return enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory");
    }
    const double whole = fmin(enc_factor_plan_error(&energies, &plain->plan, 0),
                              enc_factor_plan_error(&energies, &all, 0));
    const double rest = enc_factor_plan_error(&energies, &matched->plan, 0);
    *out_most = rest > 0 ? fmin(MAY_PAY * whole / rest, MAY_LEAVE) : 0;
    if (plain->borrowed) {
        return enc_components_copy(m, plain->components, matched->components);
    }
    memcpy(matched->components, plain->components, sizeof plain->components);
    memset(plain->components, 0, sizeof plain->components);
    return BTF_OK;
}

/* Encodes with match at the same bytes as `plain`. Where the user asked for match, it gets at least the bytes of one
 * unit of factors. */
static btf_result try_match(const enc_factor_matrix *m, const enc_factor_options *options, found *plain,
                            found *matched) {
    const double begin = progress_core_clock();
    const uint64_t lists = match_bytes(m), bytes = enc_factorise_equal_bytes(m, options->budget, &plain->unspent);
    const uint64_t least = enc_factor_least_budget(m->data->width, m->data->height, m->data->n_views,
                                                   m->data->n_lights);
    const bool choose = options->match == ENC_FACTOR_CHOOSE_MATCH;
    double most = 0;
    matched->trial.match = true;
    if (enc_factor_take_candidate(m, options->number, &matched->trial, &matched->packed)) {
        return BTF_OK;
    }
    if (choose) {
        matched->trial.omitted = !has_room(m, options, false) ? ENC_FACTOR_NO_MEMORY
                                 : bytes < lists + least      ? ENC_FACTOR_NO_BYTES
                                                              : ENC_FACTOR_ENCODED;
    }
    if (matched->trial.omitted) {
        return BTF_OK;
    }
    const uint64_t rest = bytes < lists + least ? least : bytes - lists;
    const btf_result result = hand_over(m, bytes, rest, plain, matched, &most);
    return result == BTF_OK
               ? encode_matched(m, options, rest, choose ? most : HUGE_VAL, begin, matched)
               : result;
}

/* Whether match pays, of two candidates that were both measured. */
static bool pays(const enc_factor_matrix *m, const found *plain, const found *matched) {
    if (matched->trial.omitted) {
        return false;
    }
    const double gain = gained(plain->trial.error, matched->trial.error);
    enc_log(m->context, BTF_LOG_INFO, "match: gains %.2f dB at the same bytes: %s", gain,
            gain >= MUST_GAIN ? "kept" : "left out");
    return gain >= MUST_GAIN;
}

/* Takes the components of options->basis, and plans the budget with them. */
static btf_result borrow_components(const enc_factor_matrix *m, const enc_factor_options *options,
                                    found *f) {
    const enc_factor_energies energies = enc_components_energies(options->basis);
    memcpy(f->components, options->basis, sizeof f->components);
    f->borrowed = true;
    return enc_factor_allocate(&energies, m->texels, (size_t)m->data->n_views, (size_t)m->data->n_lights,
                               options->budget, &f->plan)
               ? enc_choose_plan(m, f->components, options->budget, options->sweeps, &f->plan)
               : enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory");
}

/* The components and the plan of the first candidate: borrowed, out of a checkpoint, or found. */
static btf_result find_components(const enc_factor_matrix *m, const enc_factor_options *options, found *f) {
    btf_result result = BTF_OK;
    if (options->basis && options->basis[0].sought > 0) {
        return borrow_components(m, options, f);
    }
    if (!enc_factor_take_components(m, options->number, f->components, &f->plan, &f->unspent)) {
        result = enc_factorise(m, options->budget, options->tolerance, options->sweeps, f->components, &f->plan,
                               &f->unspent);
        if (result == BTF_OK) {
            result = enc_factor_keep_components(m, options->number, f->components, &f->plan, &f->unspent);
        }
    }
    if (options->basis && result == BTF_OK) {
        memcpy(options->basis, f->components, sizeof f->components);
        f->borrowed = true;
    }
    return result;
}

/* Encodes the candidates that the options call for, and marks the one that is kept. */
static btf_result encode(const enc_factor_matrix *m, const enc_factor_options *options, found *plain,
                         found *matched) {
    const double begin = progress_core_clock();
    btf_result result = find_components(m, options, plain);
    if (result == BTF_OK && options->match != ENC_FACTOR_MATCH) {
        result = encode_plain(m, options, begin, plain);
    }
    if (result == BTF_OK && options->match != ENC_FACTOR_NO_MATCH) {
        result = try_match(m, options, plain, matched);
        matched->trial.kept = options->match == ENC_FACTOR_MATCH ||
                              (result == BTF_OK && pays(m, plain, matched));
    }
    plain->trial.kept = !matched->trial.kept;
    return result;
}

/* Returns the candidate that was kept, with the records of both. */
static enc_factors *hand_out(const enc_factor_options *options, found f[2]) {
    found *kept = &f[f[1].trial.kept];
    enc_factors *out = kept->packed;
    kept->packed = NULL;
    out->unspent = f[0].unspent;
    if (options->match != ENC_FACTOR_MATCH) {
        out->trials[out->n_trials++] = f[0].trial;
    }
    if (options->match != ENC_FACTOR_NO_MATCH) {
        out->trials[out->n_trials++] = f[1].trial;
    }
    return out;
}

/* Refuses a budget that holds no unit, and names what would fit: a larger budget, fewer texels where the
 * directions alone leave room for any, or the only smaller kind of material, a reflectance of 16 bytes a
 * texel (FORMAT.md, section 4). */
static btf_result refuse_budget(const enc_factor_matrix *m, uint64_t budget, bool match, uint64_t least) {
    enum { PAPER_TEXEL = 16 };
    const uint64_t a_texel = 16 + (match ? enc_match_bytes(1, (size_t)m->data->n_views) : 0);
    const uint64_t directions = least - a_texel * m->texels;
    const bool plain = budget >= enc_factor_least_budget(m->data->width, m->data->height, m->data->n_views,
                                                         m->data->n_lights);
    char size[80] = "", paper[100] = "";
    if (budget >= directions + a_texel) {
        snprintf(size, sizeof size, "; it holds one unit of %llu texels at most (--size)",
                 (unsigned long long)((budget - directions) / a_texel));
    }
    if (budget >= PAPER_TEXEL * m->texels) {
        snprintf(paper, sizeof paper, "; --method paper --effects none --lobes 1 --half takes %llu bytes",
                 (unsigned long long)(PAPER_TEXEL * m->texels));
    }
    return enc_fail(m->context, BTF_ERROR_USAGE,
                    "factors: a budget of %llu bytes is too small: one unit of factors%s takes %llu; give "
                    "--budget %lluk or more%s%s%s",
                    (unsigned long long)budget, match ? " and the lists of the effects shift and gain" : "",
                    (unsigned long long)least, (unsigned long long)((least + 999) / 1000),
                    plain ? ", or --effects residual" : "", size, paper);
}

btf_result enc_factor_encode(const enc_context *context, const enc_data *data,
                             const enc_factor_options *options, enc_factors **out_factors) {
    enc_factor_matrix m = enc_factor_matrix_of(context, data);
    const bool match = options->match == ENC_FACTOR_MATCH;
    const uint64_t least =
        enc_factor_least_budget(data->width, data->height, data->n_views, data->n_lights) +
        (match ? match_bytes(&m) : 0);
    found f[2] = {{.trial = {0}}};
    *out_factors = NULL;
    if (options->budget < least) {
        return refuse_budget(&m, options->budget, match, least);
    }
    if (match && !data->samples) {
        return enc_fail(context, BTF_ERROR_UNSUPPORTED,
                        "factors: the effects shift and gain need all samples in memory, which --memory "
                        "does not allow");
    }
    btf_result result = enc_factor_clip(&m);
    if (result == BTF_OK) {
        result = encode(&m, options, &f[0], &f[1]);
    }
    if (result == BTF_OK) {
        *out_factors = hand_out(options, f);
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
    enc_factorise_first_ranks(texels, columns, budget, ranks);
    const uint64_t rank = ranks[0] + ranks[1] + ranks[2], longest = texels > columns ? texels : columns;
    const uint64_t factors = sizeof(float) * rank * (texels + columns);
    const uint64_t square = (uint64_t)ranks[0] * ranks[0];
    /* the range finder turns one copy of the factors into another; later there are components, codes and a
     * product */
    return 2 * factors + sizeof(float) * rank * longest + 24 * square + budget +
           enc_factor_product_memory(columns, rank, threads);
}

uint64_t enc_factor_match_memory(int width, int height, int n_views, uint64_t budget, bool whole) {
    const uint64_t points = (uint64_t)width * (uint64_t)height * (uint64_t)n_views;
    const uint64_t turned = (uint64_t)enc_factorise_expected(budget) * sizeof(float);
    /* sources, gains, users and weights of points; u once more, texel by texel; then what the search of a
     * block holds */
    return points * (4 + 1 + 4 + 4 + 4) + turned +
           enc_match_block_memory(width, height, (size_t)n_views, ENC_MATCH_LEADING, whole);
}
