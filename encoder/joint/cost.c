/* The bytes and seconds of a model of the joint method. See cost.h.
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

joint_shape joint_solution_shape(const enc_solution *s) {
    return (joint_shape){.effects = s->effects,
                         .components = s->n_components,
                         .centres = s->n_centres,
                         .lobes = s->sbrdf ? s->sbrdf->lobes : 0,
                         .rgb = s->sbrdf && s->sbrdf->rgb,
                         .half = s->half_parameters};
}

uint64_t joint_bytes(const enc_data *data, const joint_shape *shape) {
    const uint64_t texels = enc_data_texel_count(data), views = (uint64_t)data->n_views;
    const uint64_t lights = (uint64_t)data->n_lights, layers = (shape->components + 3) / 4;
    uint64_t bytes = 0;
    if (shape->lobes > 0) {
        const uint64_t lobes = (uint64_t)shape->lobes;
        bytes +=
            (shape->half ? 8 : 16) * texels * (shape->rgb ? (3 + 3 * lobes + 3) / 4 + lobes : 1 + lobes);
    }
    if (shape->effects & BTF_EFFECT_SHADOW)
        bytes += texels * lights;
    if (shape->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN))
        bytes += 2 * texels * views;
    if (shape->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN))
        bytes += texels * views;
    if (shape->effects & BTF_EFFECT_HIDDEN) {
        const uint64_t blocks = (shape->centres + 4095) / 4096;
        bytes += blocks ? 4 * lights * blocks * ((shape->centres + blocks - 1) / blocks) : 0;
    }
    if (shape->effects & BTF_EFFECT_RESIDUAL)
        bytes += 4 * layers * (texels + 3 * views * lights);
    return bytes;
}

size_t joint_components_for(const enc_data *data, const joint_shape *shape, uint64_t budget, size_t limit) {
    joint_shape trial = *shape;
    if (enc_data_texel_count(data) > JOINT_EXACT && limit > JOINT_MOST_BEYOND) {
        enc_data exact = *data; /* its samples are not looked at */
        exact.width = exact.height = 64;
        const size_t there = joint_components_for(&exact, shape, joint_default_budget(&exact), limit);
        limit = there > JOINT_MOST_BEYOND ? there : JOINT_MOST_BEYOND;
    }
    for (trial.components = limit / 4 * 4; trial.components > 0; trial.components -= 4)
        if (joint_bytes(data, &trial) <= budget)
            break;
    /* the data of a few texels or images have no higher rank */
    const size_t texels = enc_data_texel_count(data);
    const size_t columns = (size_t)data->n_views * (size_t)data->n_lights * 3;
    const size_t rank = texels < columns ? texels : columns;
    return trial.components < rank ? trial.components : rank;
}

uint64_t joint_default_budget(const enc_data *data) {
    const uint64_t texels = enc_data_texel_count(data);
    const int tiles = data->n_views > data->n_lights ? data->n_views : data->n_lights;
    uint32_t width, height, room;
    const btf_material_info info = {.struct_size = sizeof info,
                                    .width = (uint32_t)data->width,
                                    .height = (uint32_t)data->height,
                                    .n_views = (uint32_t)data->n_views,
                                    .n_lights = (uint32_t)data->n_lights,
                                    .layout = BTF_LAYOUT_PAPER,
                                    .lobes = 3,
                                    .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN};
    /* materials of a few texels: enough for the least residual all the same */
    const joint_shape least = {.effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL,
                               .components = 4};
    const uint64_t needed = joint_bytes(data, &least);
    const bool has_atlas = btf_material_atlas(&info, &width, &height, &room) == BTF_OK;
    const uint64_t paper =
        64 * texels + (has_atlas ? 4 * (uint64_t)width * height : 32 * texels * (uint64_t)tiles / 5);
    return paper > needed ? paper : needed;
}

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
