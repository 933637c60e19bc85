/* What the steps of the joint method cost. See joint_cost.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "joint_cost.h"
#include "joint_reach.h"
#include "joint_run.h"

#include <math.h>
#include <openbtf/material.h>

enum {
    FRONT_DIMS = 12, /* basis vectors for fronts beside a residual ... */
    LONE_DIMS = 48,  /* ... and without one */
    FRONT_SAMPLES = 128,
    FRONT_STEPS = 2,  /* least squares of the residual when it gets a front */
    FRONT_PERIOD = 8, /* rounds from one refit of a front to the next */
    NEAR = 2304,      /* sources around a point beyond 64x64 texels, beside the grid */
    MOST_CENTRES = 512,
    QUALITY_TRIALS = 5,
    QUALITY_ROUNDS = 3,
    PROBED = 64, /* texels of the probe of SBRDFs */
};

/* Core seconds of one inner step of each loop, measured by the CPU time of each call. */
static const double per_pair = 0.25e-9, per_pair_dim = 0.0225e-9, per_search = 150e-9, /* search */
    per_gain_dim = 2.5e-9,                                                             /* gains alone */
    per_pass = 1.2e-9, per_project_dim = 0.05e-9, per_v_dim = 0.036e-9,                /* passes */
    per_basis = 1.7e-9, per_orthogonal = 0.3e-9,                   /* [view][row][k][k] */
    per_gram = 0.02e-9, per_gather = 3.5e-9, per_solve = 0.045e-9, /* sources */
    per_front = 8.5e-9, per_front_row = 2.5e-9, per_front_basis = 1.2e-9, per_fit = 20e-9,
                    per_refit = 15e-9, /* SBRDFs */
    per_measure = 8.5e-9, per_centre = 19e-9, per_rounding = 8e-9, per_survey = 2e-9;

joint_extent joint_extent_of(const enc_data *data) {
    return (joint_extent){.texels = (double)enc_data_texel_count(data),
                          .views = data->n_views,
                          .row = 3.0 * data->n_lights,
                          .fetch = enc_data_fetch_cost(data)};
}

static double points(const joint_extent *e) {
    return e->texels * e->views;
}

static double samples(const joint_extent *e) {
    return points(e) * e->row;
}

/* Coordinates of a projection. */
static double dims_of(const joint_extent *e, const joint_shape *s) {
    const double k = (double)s->components, more = s->lobes == 0 ? 0 : k > 0 ? FRONT_DIMS : LONE_DIMS;
    return k + fmin(more, fmax(e->row - k, 0)) + (s->lobes > 0);
}

/* How much more a lobe costs than in one channel. */
static double lobes_of(const joint_shape *s) {
    return s->lobes * (s->rgb ? 1.3 : 1);
}

static double pass(const joint_extent *e) {
    return samples(e) * (per_pass + e->fetch);
}

static double project(const joint_extent *e, const joint_shape *s) {
    const double k = (double)s->components, dims = dims_of(e, s), more = dims - k;
    return pass(e) + samples(e) * per_project_dim * dims + e->views * e->row * k * k * per_orthogonal +
           e->views * e->row * FRONT_SAMPLES * more * per_front_basis;
}

static double choose(const joint_extent *e, const joint_shape *s, bool search) {
    const double dims = dims_of(e, s);
    const double sources = e->texels <= JOINT_EXACT ? e->texels : JOINT_REACH + NEAR;
    double cost = points(e) * per_gain_dim * dims;
    if (search && (s->effects & BTF_EFFECT_SHIFT))
        cost += points(e) * (per_search + sources * (per_pair + per_pair_dim * dims));
    if (s->lobes > 0)
        cost += samples(e) * (per_front + e->fetch);
    return cost;
}

static double solve_u(const joint_extent *e, const joint_shape *s) {
    const double k = (double)s->components;
    const double solves = e->views * (k * k * per_gram + k * per_gather) + k * k * k * per_solve;
    return k > 0 ? e->texels * solves + (s->lobes > 0 ? samples(e) * per_front_row : 0) : 0;
}

static double solve_v(const joint_extent *e, const joint_shape *s) {
    const double k = (double)s->components;
    if (k == 0)
        return 0;
    return pass(e) + samples(e) * (per_v_dim * k + (s->lobes > 0 ? per_front_row / 2 : 0)) +
           e->views * e->row * k * k * per_orthogonal;
}

double joint_cost_front_fit(const joint_extent *e, const joint_shape *s) {
    return s->lobes > 0 ? samples(e) * (per_fit * lobes_of(s) + 2 * e->fetch) : 0;
}

double joint_cost_front_refit(const joint_extent *e, const joint_shape *s) {
    return s->lobes > 0 ? samples(e) * (per_refit + per_fit / 2 * lobes_of(s) + 2 * e->fetch) : 0;
}

static double basis(const joint_extent *e, const joint_shape *s) {
    const double k = (double)s->components;
    return e->views * e->row * k * k * per_basis;
}

double joint_cost_measure(const joint_extent *e, const joint_shape *s) {
    return samples(e) * (per_measure + per_v_dim * (double)s->components + e->fetch);
}

double joint_cost_search(const joint_extent *e, const joint_shape *s) {
    return choose(e, s, true);
}

double joint_cost_refresh(const joint_extent *e, const joint_shape *s) {
    return project(e, s) + choose(e, s, false);
}

double joint_cost_solve(const joint_extent *e, const joint_shape *s) {
    return s->components > 0 ? solve_u(e, s) + choose(e, s, false) + basis(e, s) + solve_v(e, s) : 0;
}

/* The residual for everything else as it is. */
static double solve_all(const joint_extent *e, const joint_shape *s) {
    return joint_cost_solve(e, s) + joint_cost_refresh(e, s);
}

double joint_cost_quantise(const joint_extent *e, const joint_shape *s) {
    const double k = (double)s->components;
    return k > 0 ? 2 * solve_all(e, s) + joint_cost_search(e, s) + e->views * e->row * k * k * per_rounding
                 : 0;
}

/* The `number`th round. */
static double one_round(const joint_extent *e, const joint_shape *s, int number) {
    double cost = joint_cost_search(e, s) + solve_all(e, s);
    if (s->lobes > 0 && (s->components == 0 || number % FRONT_PERIOD == 0))
        cost += joint_cost_front_refit(e, s);
    return cost;
}

static double many_rounds(const joint_extent *e, const joint_shape *s, int from, int to) {
    double cost = 0;
    for (int i = from; i < to; i++)
        cost += one_round(e, s, i);
    return cost;
}

static double trial_start(const joint_extent *e, const joint_shape *s) {
    double cost = s->components > 0 ? joint_cost_refresh(e, s) : 0;
    if (s->lobes > 0)
        cost += joint_cost_front_fit(e, s) + joint_cost_refresh(e, s) +
                (s->components > 0 ? FRONT_STEPS * solve_all(e, s) : 0);
    return cost;
}

static double centres(const joint_extent *e, const joint_shape *s) {
    const uint32_t needed = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN;
    const double lights = e->row / 3, most = (e->texels + e->row * e->views) / lights;
    const double count = fmin(most, MOST_CENTRES);
    if ((s->effects & needed) != needed)
        return 0;
    return count * count * e->row * per_centre + 2 * choose(e, s, false) + basis(e, s) +
           joint_cost_refresh(e, s) + one_round(e, s, 1) + (e->fetch > 0 ? 2 * pass(e) : 0);
}

joint_costs joint_cost_run(const enc_data *data, const joint_extent *e, const enc_joint_options *options) {
    const joint_run r = joint_run_prepare(NULL, data, options);
    joint_shape list[JOINT_MOST_CANDIDATES], plain = {.effects = BTF_EFFECT_RESIDUAL};
    joint_costs c = {.survey = 2 * samples(e) * (per_survey + e->fetch) +
                               PROBED * e->views * e->row * (8 * per_fit + e->fetch)};
    const int count = joint_list_candidates(&r, list);
    if (options->effects & BTF_EFFECT_RESIDUAL) {
        plain.components = joint_run_components(&r, &plain);
        c.start = (r.preset.start + 1) * solve_all(e, &plain);
    }
    const joint_shape *best = count > 0 ? &list[0] : &plain;
    const int rounds = joint_run_round_count(&r, best), trial = joint_run_trial_count(&r, count, rounds);
    for (int i = 0; i < count; i++)
        c.candidates += trial_start(e, &list[i]) + many_rounds(e, &list[i], 0, trial);
    /* the first two, one of them with a front, are about as likely */
    for (int i = 0; i < count && i < 2; i++)
        c.rounds += many_rounds(e, &list[i], trial, rounds) / (count < 2 ? 1 : 2);
    if (count == 1) {
        c.rounds += c.candidates;
        c.candidates = 0;
    }
    if (options->effects & BTF_EFFECT_HIDDEN)
        c.centres = centres(e, best);
    c.codes = basis(e, best) + joint_cost_refresh(e, best) + joint_cost_quantise(e, best) +
              joint_cost_measure(e, best);
    if (options->quality > 0)
        c.codes *= 1 + QUALITY_TRIALS;
    if (options->quality > 0)
        c.codes += QUALITY_TRIALS * many_rounds(e, best, 0, QUALITY_ROUNDS);
    return c;
}
