/* Steps of the factor encoder in a checkpoint. See steps.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "steps.h"

#include "encoder/base/ranks.h"
#include "encoder/data/checkpoint.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A magnitude that no factor, scale or gain of an encode reaches. */
static const float most = 0x1p24f;

enum { NAME = 40 };

static void name_of(char out[NAME], const char *step, int number) {
    snprintf(out, NAME, "%s-%d", step, number);
}

static bool is_positive(double x) {
    return x >= 0 && x <= DBL_MAX;
}

/* Components.
 * ------------------------------------------------------------------------------------------------ */

static bool is_falling(const double *energy, size_t rank) {
    for (size_t i = 0; i < rank; i++) {
        if (!is_positive(energy[i]) || (i > 0 && energy[i] > energy[i - 1])) {
            return false;
        }
    }
    return true;
}

/* Takes one channel; false where no encode gives it, or memory is short. */
static bool take_channel(const enc_factor_matrix *m, enc_blob *blob, enc_components *out) {
    const size_t side = m->texels < m->columns ? m->texels : m->columns;
    uint64_t sizes[2];
    enc_blob_take(blob, sizes, sizeof sizes);
    if (blob->failed || sizes[0] > side || sizes[1] > side) {
        return false;
    }
    const size_t rank = (size_t)sizes[0];
    *out = (enc_components){.rank = rank,
                            .u = enc_gemm_alloc(rank * m->texels + 1),
                            .w = enc_gemm_alloc(rank * m->columns + 1),
                            .energy = malloc((rank + 1) * sizeof *out->energy),
                            .sought = (size_t)sizes[1]};
    if (!out->u || !out->w || !out->energy) {
        return false;
    }
    enc_blob_take(blob, out->energy, rank * sizeof *out->energy);
    enc_blob_take_floats(blob, out->u, rank * m->texels, -most, most);
    enc_blob_take_floats(blob, out->w, rank * m->columns, -most, most);
    return !blob->failed && is_falling(out->energy, rank);
}

/* Whether a plan keeps to the format's limits, and holds no more components than there are. */
static bool is_plan(const enc_factor_plan *plan, const enc_components components[ENC_FACTOR_CHANNELS]) {
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        uint32_t words = 0;
        for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
            if (plan->words[k][c] > ENC_FACTOR_MOST_UNITS * ENC_FACTOR_UNIT_WORDS) {
                return false;
            }
            words += plan->words[k][c];
        }
        if (words % ENC_FACTOR_UNIT_WORDS != 0) {
            return false;
        }
    }
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        size_t held = 0;
        for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
            held += enc_factor_held(plan, k, c, components[c].rank);
        }
        if (held > components[c].rank) {
            return false;
        }
    }
    const uint32_t units = enc_factor_all_units(plan);
    return units >= 1 && units <= ENC_FACTOR_MOST_UNITS && enc_factor_u_texels(plan) <= ENC_FACTOR_MOST_UNITS;
}

/* enc_unspent in numbers of which every bit pattern is a value. */
typedef struct kept_unspent {
    uint64_t budget, bytes, signal[ENC_FACTOR_CHANNELS], ends[ENC_FACTOR_CHANNELS];
    double more, tolerance, gain;
} kept_unspent;

static void put_unspent(enc_blob *blob, const enc_unspent *u) {
    kept_unspent kept = {
        .budget = u->budget, .bytes = u->bytes, .more = u->more, .tolerance = u->tolerance, .gain = u->gain};
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        kept.signal[c] = u->signal[c];
        kept.ends[c] = u->ends[c];
    }
    enc_blob_put(blob, &kept, sizeof kept);
}

static bool take_unspent(enc_blob *blob, enc_unspent *out) {
    kept_unspent kept;
    enc_blob_take(blob, &kept, sizeof kept);
    *out = (enc_unspent){.budget = kept.budget,
                         .bytes = kept.bytes,
                         .more = kept.more,
                         .tolerance = kept.tolerance,
                         .gain = kept.gain};
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        out->signal[c] = kept.signal[c];
        out->ends[c] = kept.ends[c] != 0;
    }
    return is_positive(kept.more) && is_positive(kept.tolerance) && kept.gain >= -DBL_MAX &&
           kept.gain <= DBL_MAX;
}

static void put_planned(const enc_factor_matrix *m, const enc_components components[ENC_FACTOR_CHANNELS],
                        const enc_factor_plan *plan, enc_blob *blob) {
    enc_blob_put(blob, plan, sizeof *plan);
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        const enc_components *k = &components[c];
        const uint64_t sizes[2] = {k->rank, k->sought};
        enc_blob_put(blob, sizes, sizeof sizes);
        enc_blob_put(blob, k->energy, k->rank * sizeof *k->energy);
        enc_blob_put(blob, k->u, k->rank * m->texels * sizeof *k->u);
        enc_blob_put(blob, k->w, k->rank * m->columns * sizeof *k->w);
    }
}

/* Takes components and the plan for them; false where no encode gives them, or memory is short. */
static bool take_planned(const enc_factor_matrix *m, enc_blob *blob, enc_components out[ENC_FACTOR_CHANNELS],
                         enc_factor_plan *out_plan) {
    bool good = true;
    enc_blob_take(blob, out_plan, sizeof *out_plan);
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        good = good && take_channel(m, blob, &out[c]);
    }
    return good && is_plan(out_plan, out);
}

static void clear_components(enc_components components[ENC_FACTOR_CHANNELS]) {
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        enc_components_clear(&components[c]);
    }
}

bool enc_factor_take_components(const enc_factor_matrix *m, int number,
                                enc_components out[ENC_FACTOR_CHANNELS], enc_factor_plan *out_plan,
                                enc_unspent *out_unspent) {
    char name[NAME];
    enc_blob blob;
    name_of(name, "components", number);
    if (!enc_checkpoint_get(m->context, name, &blob)) {
        return false;
    }
    bool good = take_unspent(&blob, out_unspent);
    good = take_planned(m, &blob, out, out_plan) && good;
    good = enc_blob_taken(&blob) && good;
    good = enc_ranks_all(m->context, good);
    if (!good) {
        clear_components(out);
        *out_plan = (enc_factor_plan){{{0}}};
        *out_unspent = (enc_unspent){0};
    }
    return good;
}

btf_result enc_factor_keep_components(const enc_factor_matrix *m, int number,
                                      const enc_components components[ENC_FACTOR_CHANNELS],
                                      const enc_factor_plan *plan, const enc_unspent *unspent) {
    char name[NAME];
    enc_blob blob = {0};
    if (!m->context->checkpoint || !enc_ranks_leads(m->context)) {
        return BTF_OK;
    }
    name_of(name, "components", number);
    put_unspent(&blob, unspent);
    put_planned(m, components, plan, &blob);
    return enc_checkpoint_put(m->context, name, &blob);
}

/* Match.
 * ------------------------------------------------------------------------------------------------ */

static void put_points(const enc_match *match, enc_blob *blob) {
    const size_t points = match->texels * match->views;
    const int32_t count = match->gains.count;
    enc_blob_put(blob, &count, sizeof count);
    enc_blob_put(blob, &match->gains.base, sizeof match->gains.base);
    enc_blob_put(blob, &match->gains.step, sizeof match->gains.step);
    enc_blob_put(blob, match->source, points * sizeof *match->source);
    enc_blob_put(blob, match->gain, points);
}

/* Whether two places on a circle are within the reach of a shift, the shorter way round. */
static bool within_reach(int from, int to, int size) {
    const int by = (to - from + size) % size, shift = 2 * by >= size ? by - size : by;
    return shift >= -ENC_MATCH_REACH && shift < ENC_MATCH_REACH;
}

static bool is_source(const enc_match *match, size_t point) {
    const size_t texel = point % match->texels, source = match->source[point];
    const size_t width = (size_t)match->width;
    return source < match->texels &&
           within_reach((int)(texel % width), (int)(source % width), match->width) &&
           within_reach((int)(texel / width), (int)(source / width), match->height);
}

/* Takes points into a match that has room for them, and has the gains of a first search if it may have
 * any. */
static void take_points(enc_blob *blob, enc_match *out) {
    const size_t points = out->texels * out->views;
    const bool gains = out->gains.count > 1;
    int32_t count;
    enc_blob_take(blob, &count, sizeof count);
    enc_blob_take_floats(blob, &out->gains.base, 1, -most, most);
    enc_blob_take_floats(blob, &out->gains.step, 1, 0, most);
    enc_blob_take(blob, out->source, points * sizeof *out->source);
    enc_blob_take_bytes(blob, out->gain, points, 0, ENC_MATCH_GAINS - 1);
    blob->failed = blob->failed || count != (gains ? ENC_MATCH_GAINS : 1);
    for (size_t i = 0; i < points && !blob->failed; i++) {
        blob->failed = !is_source(out, i) || out->gain[i] >= count;
    }
    out->gains.count = count;
}

/* Makes another match of the same shape, without users. */
static bool create_like(const enc_match *match, enc_match *out) {
    const size_t points = match->texels * match->views;
    *out = *match;
    out->source = malloc(points * sizeof *out->source);
    out->gain = malloc(points);
    return out->source && out->gain;
}

static void clear_like(enc_match *match) {
    free(match->source);
    free(match->gain);
}

/* Moves the points that were taken to the match that they belong to. */
static void replace_points(const enc_context *context, enc_match *taken, enc_match *io_match) {
    const size_t points = taken->texels * taken->views;
    io_match->gains = taken->gains;
    memcpy(io_match->source, taken->source, points * sizeof *taken->source);
    memcpy(io_match->gain, taken->gain, points);
    enc_match_count_users(context, io_match);
}

bool enc_factor_take_match(const enc_factor_matrix *m, int number, enc_match *io_match,
                           enc_components io_components[ENC_FACTOR_CHANNELS], enc_factor_plan *io_plan,
                           double *out_share) {
    enc_components taken[ENC_FACTOR_CHANNELS] = {{0}};
    enc_factor_plan plan;
    enc_match match;
    enc_blob blob;
    double share;
    char name[NAME];
    name_of(name, "match", number);
    if (!enc_checkpoint_get(m->context, name, &blob)) {
        return false;
    }
    bool good = create_like(io_match, &match);
    enc_blob_take(&blob, &share, sizeof share);
    if (good) {
        take_points(&blob, &match);
    }
    good = good && !blob.failed && take_planned(m, &blob, taken, &plan);
    good = enc_blob_taken(&blob) && good && is_positive(share);
    good = enc_ranks_all(m->context, good);
    if (good) {
        replace_points(m->context, &match, io_match);
        clear_components(io_components);
        memcpy(io_components, taken, sizeof taken);
        *io_plan = plan;
        *out_share = share;
    } else {
        clear_components(taken);
    }
    clear_like(&match);
    return good;
}

btf_result enc_factor_keep_match(const enc_factor_matrix *m, int number, const enc_match *match,
                                 const enc_components components[ENC_FACTOR_CHANNELS],
                                 const enc_factor_plan *plan, double share) {
    char name[NAME];
    enc_blob blob = {0};
    if (!m->context->checkpoint || !enc_ranks_leads(m->context)) {
        return BTF_OK;
    }
    name_of(name, "match", number);
    enc_blob_put(&blob, &share, sizeof share);
    put_points(match, &blob);
    put_planned(m, components, plan, &blob);
    return enc_checkpoint_put(m->context, name, &blob);
}

/* Candidates.
 * ------------------------------------------------------------------------------------------------ */

/* The numbers of a candidate beside its arrays, of which every bit pattern is a value. */
typedef struct head {
    uint64_t match, omitted, bytes, match_bytes, components[ENC_FACTOR_CHANNELS];
    double core_seconds, linear, srgb;
    uint32_t classes[ENC_FACTOR_CLASSES][ENC_FACTOR_CHANNELS];
    uint32_t entries, n_units;
    float gain_base, gain_step;
} head;

/* How many elements the arrays of a candidate have. */
typedef struct sizes {
    size_t texels, directions, scales, views, points;
} sizes;

static sizes sizes_of(const enc_factor_matrix *m, const head *h) {
    const size_t units = enc_store_units((const uint32_t(*)[3])h->classes), views = (size_t)m->data->n_views;
    return (sizes){.texels = enc_store_layers((const uint32_t(*)[3])h->classes) * m->texels * 4,
                   .directions = units * m->columns * 4,
                   .scales = units * 4,
                   .views = views * ENC_FACTOR_TIERS * ENC_FACTOR_CHANNELS,
                   .points = h->match ? m->texels * views : 0};
}

/* Whether the numbers may come from an encode. */
static bool is_head(const head *h) {
    bool good = is_positive(h->core_seconds) && is_positive(h->linear) && is_positive(h->srgb) &&
                h->omitted < ENC_FACTOR_OMISSIONS;
    if (h->omitted) {
        return good;
    }
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        const uint32_t *of = h->classes[k];
        good = good && of[0] <= ENC_FACTOR_MOST_UNITS && of[1] <= ENC_FACTOR_UNIT_WORDS * of[0] &&
               of[2] <= ENC_FACTOR_UNIT_WORDS * of[0] - of[1];
    }
    if (!good) {
        return false;
    }
    const uint32_t units = enc_store_units((const uint32_t(*)[3])h->classes);
    return units >= 1 && units <= ENC_FACTOR_MOST_UNITS && units == h->n_units &&
           enc_store_layers((const uint32_t(*)[3])h->classes) <= ENC_FACTOR_MOST_UNITS &&
           h->entries <= ENC_MATCH_ENTRIES && h->gain_base >= -most && h->gain_base <= most &&
           h->gain_step >= -most && h->gain_step <= most;
}

static head head_of(const enc_factor_trial *trial, const enc_factors *f) {
    head h;
    memset(&h, 0, sizeof h); /* padding too, since it goes to a file */
    h.match = trial->match;
    h.omitted = trial->omitted;
    h.bytes = trial->bytes;
    h.core_seconds = trial->core_seconds;
    h.linear = trial->error.linear;
    h.srgb = trial->error.srgb;
    h.n_units = (uint32_t)trial->n_units;
    if (f) {
        h.match_bytes = f->match_bytes;
        h.entries = (uint32_t)f->point_entries;
        h.gain_base = f->gain_base;
        h.gain_step = f->gain_step;
        memcpy(h.classes, f->classes, sizeof h.classes);
        for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
            h.components[c] = f->components[c];
        }
    }
    return h;
}

static enc_factors factors_of(const enc_factor_matrix *m, const head *h) {
    enc_factors f = {.width = m->data->width,
                     .height = m->data->height,
                     .n_views = m->data->n_views,
                     .n_lights = m->data->n_lights,
                     .n_units = (int)h->n_units,
                     .n_u_texels = (int)enc_store_layers((const uint32_t(*)[3])h->classes),
                     .gain_base = h->gain_base,
                     .gain_step = h->gain_step,
                     .point_entries = (int)h->entries,
                     .match_bytes = h->match_bytes,
                     .bytes = h->bytes,
                     .error = {h->linear, h->srgb}};
    memcpy(f.classes, h->classes, sizeof f.classes);
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        f.components[c] = (size_t)h->components[c];
    }
    return f;
}

static const char *step_of(const enc_factor_trial *trial) {
    return trial->match ? "matched" : "factors";
}

/* Takes the arrays of a candidate; NULL where no encode gives such arrays, or memory is short. */
static enc_factors *take_arrays(const enc_factor_matrix *m, const head *h, enc_blob *blob) {
    const sizes n = sizes_of(m, h);
    enc_factors *f = malloc(sizeof *f);
    if (!f) {
        return NULL;
    }
    *f = factors_of(m, h);
    f->texels = malloc(n.texels * sizeof *f->texels);
    f->directions = malloc(n.directions * sizeof *f->directions);
    f->scales = malloc(n.scales * sizeof *f->scales);
    f->views = malloc(n.views * sizeof *f->views);
    f->shift = n.points > 0 ? malloc(2 * n.points) : NULL;
    f->gain = n.points > 0 ? malloc(n.points) : NULL;
    if (!f->texels || !f->directions || !f->scales || !f->views || (n.points > 0 && (!f->shift || !f->gain))) {
        enc_factors_destroy(&f);
        return NULL;
    }
    enc_blob_take(blob, f->texels, n.texels * sizeof *f->texels);
    enc_blob_take(blob, f->directions, n.directions * sizeof *f->directions);
    enc_blob_take_floats(blob, f->scales, n.scales, -most, most);
    enc_blob_take_floats(blob, f->views, n.views, -most, most);
    if (n.points > 0) {
        enc_blob_take(blob, f->shift, 2 * n.points);
        enc_blob_take_bytes(blob, f->gain, n.points, 0, ENC_MATCH_GAINS - 1);
        for (size_t i = 0; i < 2 * n.points; i++) {
            blob->failed = blob->failed || f->shift[i] < -ENC_MATCH_REACH || f->shift[i] >= ENC_MATCH_REACH;
        }
    }
    return f;
}

bool enc_factor_take_candidate(const enc_factor_matrix *m, int number, enc_factor_trial *io_trial,
                               enc_factors **out_factors) {
    char name[NAME];
    enc_blob blob;
    head h;
    *out_factors = NULL;
    name_of(name, step_of(io_trial), number);
    if (!enc_checkpoint_get(m->context, name, &blob)) {
        return false;
    }
    enc_blob_take(&blob, &h, sizeof h);
    bool good = !blob.failed && is_head(&h) && (h.match != 0) == io_trial->match;
    if (good && !h.omitted) {
        *out_factors = take_arrays(m, &h, &blob);
        good = *out_factors;
    }
    good = enc_blob_taken(&blob) && good;
    good = enc_ranks_all(m->context, good);
    if (good) {
        *io_trial = (enc_factor_trial){.match = io_trial->match,
                                       .omitted = (enc_factor_omission)h.omitted,
                                       .n_units = (int)h.n_units,
                                       .bytes = h.bytes,
                                       .error = {h.linear, h.srgb},
                                       .core_seconds = h.core_seconds};
    } else {
        enc_factors_destroy(out_factors);
    }
    return good;
}

btf_result enc_factor_keep_candidate(const enc_factor_matrix *m, int number, const enc_factor_trial *trial,
                                     const enc_factors *f) {
    char name[NAME];
    enc_blob blob = {0};
    if (!m->context->checkpoint || !enc_ranks_leads(m->context)) {
        return BTF_OK;
    }
    const head h = head_of(trial, f);
    name_of(name, step_of(trial), number);
    enc_blob_put(&blob, &h, sizeof h);
    if (f) {
        const sizes n = sizes_of(m, &h);
        enc_blob_put(&blob, f->texels, n.texels * sizeof *f->texels);
        enc_blob_put(&blob, f->directions, n.directions * sizeof *f->directions);
        enc_blob_put(&blob, f->scales, n.scales * sizeof *f->scales);
        enc_blob_put(&blob, f->views, n.views * sizeof *f->views);
        if (n.points > 0) {
            enc_blob_put(&blob, f->shift, 2 * n.points);
            enc_blob_put(&blob, f->gain, n.points);
        }
    }
    return enc_checkpoint_put(m->context, name, &blob);
}
