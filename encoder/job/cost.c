/* The costs of the stages of an encode. See cost.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cost.h"

#include "encoder/base/scratch.h"
#include "encoder/data/level_filter.h"
#include "encoder/factor/factor.h"
#include "encoder/factor/level.h"
#include "encoder/factor/match/fit.h"
#include "encoder/factor/round.h"
#include "encoder/factor/signal.h"
#include "encoder/input/bonn/reader.h"
#include "encoder/model/pack.h"
#include "encoder/nodes/choose.h"
#include "encoder/nodes/rows.h"
#include "encoder/paper/choose_effects.h"
#include "encoder/relief/relief.h"
#include "encoder/report/effect_errors.h"
#include "encoder/report/leave_one_out.h"
#include "foresee.h"
#include "memory.h"
#include "reflectance.h"

#include <math.h>
#include <openbtf/material.h>
#include <string.h>

enum { REPORTED_EFFECTS = 5 };

/* Core seconds of one inner step on the machine that predict.c describes, where encodes of 32x32 and 64x64
 * texels by both methods took what the model says within a fifth; which data each constant was fitted to is
 * not recorded, unless it is said here. Reading and making samples: */
static const double per_file = 60e-6, per_pixel = 25e-9, per_jpeg_pixel = 12e-9, per_read_sample = 1.5e-9;
/* The paper's method: */
static const double per_fit = 110e-9, per_shadow = 20e-9, per_flow = 1.2e-6, per_flow_label = 3e-9,
                    per_refine = 0.05e-9, per_cluster = 0.1e-9, hidden_share = 0.25;
/* Factors: a sample that a pass splits into channels; a multiplication of a pass, of a Gram matrix, of the
 * descent. */
static const double per_split = 1.2e-9, per_product = 0.025e-9, per_square = 0.06e-9,
                    per_level_square = 0.25e-9;
/* A round of match: a sample that is added to its source's row, a multiplication of the Gram matrices of
 * views and texels, one of the descent on u, a point and a source that are compared, and two views of a
 * list. Fitted to btf-sample bricks of 64x64 and 128x128 texels, 81 directions, and BRICKS64. */
enum { ALL_IN_REACH = 4096, SOURCES_OF_TILE = 2401, PAIRS_OF_TEXEL = 40 };
static const double per_added = 3e-9, per_gram = 0.019e-9, per_own_square = 0.1e-9, per_compared = 0.95e-9,
                    per_view_pair = 18e-9;
/* The fit of nodes: */
static const double per_judged = 0.15e-9, per_table = 0.3e-6, per_turned = 0.03e-9, per_fitted = 2.5e-9;
/* Relief and gloss: a sample reduced to numbers, a height of the sweep in a view, a sweep of the descent at
 * a texel of a view, a surface judged there, a sample baked along it, a direction in the triangulation of a
 * list without one of them, shares of gloss judged at a texel of a pair. */
static const double per_number = 24e-9, per_swept = 95e-9, per_descent = 12.6e-6, per_surface = 0.8e-6,
                    per_baked = 15e-9, per_triangle = 60e-6, per_share = 2e-6;
/* What comes after the analysis: */
static const double per_measured = 8e-9, per_measured_component = 0.17e-9, per_measured_lobe = 6e-9,
                    per_ssim = 8e-9, per_evaluation = 0.25e-6, per_left_out = 0.4e-6, per_packed = 30e-9,
                    per_saved = 800e-9, per_filtered = 2e-9, per_factor_evaluation = 0.1e-6,
                    per_factor_left_out = 0.25e-6, per_factor_saved = 200e-9;

/* The list of stages while it is made. */
typedef struct list {
    estimate_part *parts;
    size_t count;
} list;

static void add(list *l, const char *stage, double cost) {
    l->parts[l->count++] = (estimate_part){stage, cost};
}

/* The numbers that costs are proportional to. */
typedef struct counts {
    double texels, points, samples; /* samples: three a texel, view and light */
    double views, lights;
} counts;

static counts count(const enc_extent *e) {
    counts c = {.texels = (double)e->width * e->height, .views = e->n_views, .lights = e->n_lights};
    c.points = c.texels * c.views;
    c.samples = 3 * c.points * c.lights;
    return c;
}

/* Whether samples are made again each time they are asked for. */
static bool made_again(const enc_context *context, const enc_extent *e) {
    return !enc_data_fits(context, e->width, e->height, e->n_views, e->n_lights);
}

static double fetch_cost(const enc_context *context, const enc_extent *e) {
    if (!made_again(context, e)) {
        return 0;
    }
    return e->origin == ENC_ORIGIN_BONN ? enc_bonn_sample_seconds(e->components) : ENC_SCRATCH_SECONDS;
}

static void add_reading(list *l, const enc_context *context, const enc_extent *e, const counts *c) {
    if (e->origin != ENC_ORIGIN_BONN) {
        add(l, "read",
            c->views * c->lights * per_file + c->samples * per_read_sample +
                (double)e->pixels * (e->origin == ENC_ORIGIN_JPEG ? per_jpeg_pixel : per_pixel));
    } else if (!made_again(context, e)) {
        add(l, "decode", c->samples * enc_bonn_sample_seconds(e->components));
    }
}

/* Cost of "foresee error": components of some texels, by a product with u, one with w and one for the
 * residual. */
static double foresee_cost(const counts *c, double fetch) {
    const double texels = fmin(c->texels, ENC_FORESEE_TEXELS), columns = c->views * c->lights;
    const double luma = ENC_FORESEE_RANK, all = 1.5 * luma; /* with spare ones */
    return 3 * texels * columns * (3 * (per_split + fetch) + all * per_product) +
           4 * 1.125 * luma * luma * (texels + columns) * per_square;
}

/* Adds relief. Heights are found on images of a bounded size, and judged at a bounded number of texels. */
static void add_relief(list *l, const enc_context *context, const enc_job *job, const enc_extent *e, const counts *c,
                       int levels, double fetch) {
    const bool held = enc_data_fits(context, e->width, e->height, e->n_views, e->n_lights);
    if (!enc_settings_try_relief(job)) {
        return;
    }
    const double pairs = fmin(c->views, 20) * fmin(c->lights, 16);
    double cost = 2 * c->views * c->views * per_triangle + 16 * c->lights * per_triangle +
                  fmin(c->texels, 192) * pairs * per_share;
    if (job->relief.relief && held) {
        const enc_relief_work work = enc_relief_work_of(e->width, e->height);
        cost += c->samples * (per_number + 2 * fetch) + work.texels * c->views * work.heights * per_swept * 0.7 +
                work.texels * c->views * work.sweeps * per_descent * 0.7 +
                work.judged * c->views * ENC_RELIEF_CANDIDATES * per_surface;
        cost += levels > 1 ? c->samples * per_filtered / 8 + work.judged / 4 * c->views * 2 * per_surface : 0;
    }
    add(l, "relief", cost);
}

/* Adds the fit of nodes. Candidates are judged at a fixed number of texels, by directions left out; then
 * every sample is replaced. */
static void add_fit(list *l, const enc_job *job, const counts *c, double fetch) {
    const double judged = fmin(c->texels, ENC_FIT_TEXELS) * ENC_STRENGTHS * 36 * 3 * c->views * c->lights;
    const double tables = ENC_ROWS_MOST * (c->views * c->views + c->lights * c->lights);
    if (job->fit != ENC_FIT_BETWEEN && job->method == ENC_METHOD_PAPER) {
        return;
    }
    if (job->method != ENC_METHOD_PAPER) {
        add(l, "foresee error", foresee_cost(c, fetch));
    }
    add(l, "choose fit", judged * per_judged + tables * per_table);
    if (job->fit != ENC_FIT_BETWEEN) {
        return;
    }
    const double baked = enc_settings_try_relief(job) && job->relief.relief ? per_baked : 0;
    add(l, "fit nodes", c->samples * ((c->views + c->lights) * per_turned + per_fitted + baked + 2 * fetch));
}

/* The model that the analysis is likely to find: measuring it costs by its size. */
typedef struct outcome {
    double components, lobes, effects;
    bool factors; /* the model is factors: these are decoded faster, and `components` is the number of
                     components of the other store that would take as long */
} outcome;

static double flow(const counts *c, double side, double lights) {
    const double labels = fmin(side + 2, ENC_FLOW_LABELS);
    return c->points * (lights * per_flow + labels * ENC_FLOW_PRIOR_LIGHTS * per_flow_label);
}

static outcome add_paper(list *l, const enc_extent *e, const counts *c, double fetch,
                         const enc_paper_options *o) {
    const double side = fmax(e->width, e->height), hidden = hidden_share * c->points;
    const double lights = o->flow.lights > 0 ? o->flow.lights : c->lights;
    const double across = o->refine.columns > 0 ? o->refine.columns : c->texels <= 4096 ? 256 : 64;
    const double window =
        fmin(across, e->width) * fmin(o->refine.rows > 0 ? o->refine.rows : across, e->height);
    uint32_t room = 0;
    const enc_context quiet = {.threads = 1};
    add(l, "fit", c->samples / 3 * (per_fit * o->fit.lobes * (1 + o->fit.rounds) / 4 * 3 + 3 * fetch));
    if (o->effects & BTF_EFFECT_SHADOW) {
        add(l, "shadow", c->texels * c->lights * (per_shadow + 3 * fetch));
    }
    if (o->choose && (o->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN))) {
        add(l, "probe", flow(c, side, fmin(ENC_PAPER_PROBE_LIGHTS, c->lights)) + c->samples * fetch);
    }
    if (o->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN)) {
        add(l, "flow", flow(c, side, lights) + c->samples * fetch);
    }
    if (o->effects & BTF_EFFECT_HIDDEN) {
        const bool has_room =
            enc_pack_centre_room(&quiet, e->width, e->height, e->n_views, e->n_lights, &room) == BTF_OK;
        const double centres = o->centres > 0 ? o->centres : has_room ? room : 0;
        add(l, "hidden", hidden * window * 3 * c->lights * per_refine + c->samples * fetch);
        add(l, "cluster",
            hidden * fmin(centres, hidden) * 3 * c->lights * per_cluster + c->samples * fetch);
    }
    return (outcome){.lobes = o->fit.lobes, .effects = __builtin_popcount(o->effects)};
}

/* Core seconds of a round of match: a search, lists, and a descent on w and u. */
static double match_round(const counts *c, const enc_factors_settings *settings) {
    const double columns = c->views * c->lights, side = fmin(c->texels, columns);
    const double lists = (double)enc_match_bytes((size_t)c->texels, (size_t)c->views);
    const double bytes = fmax((double)settings->budget - lists, 16 * (c->texels + columns));
    const double all = fmin(bytes * 8 / 3.2 / (c->texels + columns), side), luma = 0.84 * all;
    const double descent = c->texels * luma * luma * (c->views * per_gram + 3 * per_own_square) +
                           2 * (c->samples * per_added + c->texels * columns * all * per_product);
    const double sources = c->texels > ALL_IN_REACH ? SOURCES_OF_TILE : c->texels;
    const double search = c->points * (all * ENC_MATCH_LEADING * per_product + sources * per_compared);
    return descent + search + c->points * fmin(c->views, PAIRS_OF_TEXEL) * per_view_pair;
}

/* Adds the stages of --method joint, with as many components as a budget is expected to hold (factorise.c). held:
 * the samples lie in memory, without which no match is tried. */
static outcome add_factors(list *l, const counts *c, const enc_factors_settings *settings, double fetch,
                           bool held) {
    const double columns = c->views * c->lights, side = fmin(c->texels, columns);
    const double luma = fmin((double)settings->budget * 8 / 3.2 / (c->texels + columns) + 24, side);
    const double all = luma + 2 * fmin(luma / 8 + 24, side);
    const double pass = c->samples * (per_split + fetch) + c->texels * columns * all * per_product;
    const double square = (c->texels + columns) * luma * luma;
    const double sweeps = 1 + settings->sweeps, passes = enc_factor_round_passes(settings->sweeps);
    const double times = settings->quality > 0 ? 1 + ENC_FACTORS_TRIALS / 2.0 : 1;
    add(l, "factorise", 4 * pass + 6 * square * per_square); /* once, also where a quality tries several
                                                                budgets */
    if (settings->quality == 0 && settings->tolerance > 0 &&
        c->texels * columns >= ENC_SIGNAL_LEAST_SAMPLES) { /* passes over parts of texels and directions */
        add(l, "cross-validate",
            fmin(1, ENC_SIGNAL_MOST_TEXELS / c->texels) * (2.25 * pass + 3 * square * per_square));
    }
    const bool match = held && (settings->choose || settings->effects & BTF_EFFECT_SHIFT);
    const double round = match ? match_round(c, settings) : 0;
    add(l, "round factors",
        times * (passes * pass + (2 * sweeps + passes) * square * per_square +
                 fmax(1, settings->sweeps * ENC_MATCH_CODE_ROUNDS / ENC_FACTOR_SWEEPS) * round));
    if (match) {
        add(l, "match", times * ENC_MATCH_ROUNDS * round);
    }
    if (settings->quality > 0 || (settings->choose && held)) {
        add(l, "measure factors", times * (pass + c->samples * per_measured));
    }
    return (outcome){.components = all / 5, .factors = true};
}

/* Core seconds of the further levels of detail: one pass, Gram matrices, and descents texel by texel. */
static double factor_levels(const counts *c, double further_share, const enc_factors_settings *settings) {
    const double columns = c->views * c->lights, side = fmin(c->texels, columns);
    const double luma = fmin((double)settings->budget * 8 / 3.2 / (c->texels + columns), side);
    return further_share * (c->samples * per_split + c->texels * columns * 1.25 * luma * per_product +
                            (ENC_FACTORS_LEVEL_SWEEPS + ENC_FACTORS_FIT_SWEEPS) * c->texels * luma * luma *
                                per_level_square) +
           luma * luma * columns * per_square;
}

/* The texels of all further levels, as a share of those of level 0: a third, where there are many. */
static double further(int levels) {
    return levels > 1 ? (1 - pow(0.25, levels - 1)) / 3 : 0;
}

/* The texels of all levels that are drawn where samples are left out. */
static double left_out_texels(double texels, int levels) {
    double sum = 0;
    for (int level = 0; level < levels; level++) {
        sum += fmin(texels * pow(0.25, level), ENC_LEFT_OUT_OF_LEVEL(level));
    }
    return sum;
}

/* Evaluations of all levels for the table of effect errors: a coarser one has as many as level 0, up to its
 * own limit. One of fewer than four texels has fewer, since a texel is shown by at most 16 pairs of
 * directions in a pair of bands. */
static double effect_evaluations(const counts *c, int levels) {
    double sum = 0;
    for (int level = 0; level < levels; level++) {
        const double texels = fmax(c->texels * pow(0.25, level), 1);
        sum += fmin(c->samples / 6, ENC_EFFECT_EVALUATIONS(level)) * fmin(texels / 4, 1);
    }
    return sum;
}

static int levels_of(const enc_job *job, const enc_extent *e) {
    const int most = enc_level_count(e->width, e->height);
    return job->levels > 0 && job->levels < most ? job->levels : most;
}

size_t enc_cost_parts(const enc_context *context, const enc_job *job, const enc_extent *e,
                      estimate_part out_parts[ESTIMATE_PARTS]) {
    const counts c = count(e);
    const bool paper = job->method == ENC_METHOD_PAPER;
    const double fetch = fetch_cost(context, e);
    const int levels = levels_of(job, e);
    list l = {out_parts, 0};
    add_reading(&l, context, e, &c);
    add_relief(&l, context, job, e, &c, levels, fetch);
    add_fit(&l, job, &c, fetch);
    const size_t first = l.count;
    const enc_factors_settings settings =
        enc_settings_of_factors(job, e->width, e->height, e->n_views, e->n_lights);
    const outcome found = paper ? add_paper(&l, e, &c, fetch, &job->paper)
                                : add_factors(&l, &c, &settings, fetch,
                                              enc_data_fits(context, e->width, e->height, e->n_views, e->n_lights));
    if (!paper && job->joint.choose) { /* the survey, of one lobe; that its model is taken is not foreseen */
        add(&l, "reflectance", fmin(c.texels, ENC_REFLECTANCE_TEXELS) * c.views * c.lights * (3 * per_fit / 4 + 3 * fetch));
    }
    const double analysis = enc_cost_total(out_parts + first, l.count - first);
    if (levels > 1) {
        add(&l, "levels",
            further(levels) * (c.samples * (per_filtered + fetch)) +
                (paper ? further(levels) * analysis : factor_levels(&c, further(levels), &settings)));
    }
    const double sample =
        per_measured + per_measured_component * found.components + per_measured_lobe * found.lobes + fetch;
    const double steps = (paper ? 3 : 1) + found.effects;
    add(&l, ENC_STAGE_PACK, c.points * per_packed);
    add(&l, "measure", c.samples * (steps * sample + per_ssim));
    add(&l, "effect errors",
        effect_evaluations(&c, levels) *
                (found.factors ? per_factor_evaluation : per_evaluation * (1 + 0.02 * found.components)) +
            further(levels) * c.samples * (per_filtered + fetch));
    const int levels_left_out = paper ? 1 : levels; /* only files of version 2 have these, which the paper's
                                                       method does not write */
    add(&l, "leave one out",
        left_out_texels(c.texels, levels_left_out) *
                (3 * ENC_LEFT_OUT_PAIRS *
                     (found.factors ? per_factor_left_out : per_left_out * (1 + 0.02 * found.components)) +
                 3 * c.views * c.lights * fetch) +
            further(levels_left_out) * c.samples * (per_filtered + fetch));
    if (levels > 1) {
        add(&l, "measure levels", further(levels) * c.samples * (sample + per_filtered + fetch));
    }
    if (job->pictures) {
        add(&l, "pictures", c.points * (REPORTED_EFFECTS * sample + 1e-6));
    }
    add(&l, ENC_STAGE_SAVE, c.points * (found.factors ? per_factor_saved : per_saved));
    return l.count;
}

double enc_cost_total(const estimate_part *parts, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += parts[i].cost;
    }
    return sum;
}
