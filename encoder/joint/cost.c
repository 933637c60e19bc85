/* The costs of the steps of the joint method. See cost.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cost.h"

#include "front_fit.h"
#include "projection.h"
#include "search.h"
#include "search_set.h"

#include <math.h>
#include <openbtf/material.h>

/* Sources of the tiles around a point beyond 64x64 texels, beside the grid. */
enum { NEAR = (2 * JOINT_WINDOW + 1) * (2 * JOINT_WINDOW + 1) * JOINT_CHUNK };

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
    const double k = (double)s->components, more = s->lobes == 0 ? 0
                                                   : k > 0       ? JOINT_FRONT_DIMS
                                                                 : JOINT_FRONT_ALONE_DIMS;
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
           e->views * e->row * JOINT_FRONT_SAMPLES * more * per_front_basis;
}

static double choose(const joint_extent *e, const joint_shape *s, bool search) {
    const double dims = dims_of(e, s);
    const double sources = e->texels <= JOINT_EXACT ? e->texels : JOINT_GRID_SOURCES + NEAR;
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

double joint_cost_basis(const joint_extent *e, const joint_shape *s) {
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
    return s->components > 0 ? solve_u(e, s) + choose(e, s, false) + joint_cost_basis(e, s) + solve_v(e, s)
                             : 0;
}

double joint_cost_residual(const joint_extent *e, const joint_shape *s) {
    return joint_cost_solve(e, s) + joint_cost_refresh(e, s);
}

double joint_cost_quantise(const joint_extent *e, const joint_shape *s) {
    const double k = (double)s->components;
    return k > 0 ? 2 * joint_cost_residual(e, s) + joint_cost_search(e, s) +
                       e->views * e->row * k * k * per_rounding
                 : 0;
}

double joint_cost_survey(const joint_extent *e) {
    return 2 * samples(e) * (per_survey + e->fetch) +
           JOINT_PROBED * e->views * e->row * (8 * per_fit + e->fetch);
}

double joint_cost_cluster(const joint_extent *e, double count) {
    return count * count * e->row * per_centre + (e->fetch > 0 ? 2 * pass(e) : 0);
}
