/* `--method joint` from data to codes, and its cost. See joint.h.
 *
 * An SBRDF alone comes first, if a sample of texels promises that it is enough. The plain factorisation is
 * next: it is the start of all other shapes, and their rival where nothing moves. The shapes are tried for
 * a few rounds from there; the best of them is fitted to the end, and kept unless the plain one is better.
 *
 * SPDX-License-Identifier: MIT
 */
#include "joint.h"

#include "hidden.h"
#include "run.h"
#include "steps.h"
#include "trials.h"

#include "decoder/toolkit/progress.h"
#include "encoder/base/stage.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>

enum { QUALITY_TRIALS = 5 }; /* of the search of the fewest components, as its cost counts them */

/* dB in the fitted domain that 8-bit codes reach but hardly pass: better is not sought. */
static const double enough_psnr = 55.0;

/* The plain factorisation is finished, too, where its error is at most so many times the best one's. */
static const double plain_chance = 1.03;

/* The smallest plain shape whose error is small enough, or 0. */
static size_t enough_components(const joint_run *r) {
    double error = r->rows.total;
    for (size_t j = 0; j < r->plain.model.k; j++) {
        error -= r->energy[j];
        if (error <= r->enough)
            return (j + 4) / 4 * 4 < r->plain.model.k ? (j + 4) / 4 * 4 : r->plain.model.k;
    }
    return 0;
}

/* Finishes the best candidate. */
static btf_result finish_best(joint_run *r, enc_solution *out_solution, joint_error *out_error) {
    btf_result result = BTF_OK;
    if (r->best.model.k == 0)
        return joint_run_finish(r, &r->best, out_solution, out_error);
    result = joint_principal_basis(&r->rows, &r->best.model, NULL);
    if (result == BTF_OK)
        result = joint_run_finish_part(r, &r->best, r->best.model.k, out_solution, out_error);
    return result;
}

/* The better of the best candidate and the plain factorisation, as codes. */
static btf_result finish_better(joint_run *r, enc_solution *out_solution, joint_error *out_error) {
    btf_result result = BTF_OK;
    joint_error plain_error;
    enc_solution plain = {0};
    const bool have = r->best.rows;
    if (have)
        result = finish_best(r, out_solution, out_error);
    const bool may_be_plain = r->options->choose || !have;
    if (result != BTF_OK || !may_be_plain || (have && r->plain.error > plain_chance * out_error->fitted))
        return result;
    result = joint_fit_refine_plain(&r->plain, r->preset.start, NULL);
    joint_fit_release(&r->plain);
    if (result == BTF_OK)
        result = joint_run_finish_part(r, &r->plain, r->plain.model.k, &plain, &plain_error);
    const bool better =
        result == BTF_OK &&
        (!have || plain_error.fitted < exp10(0.1 * r->options->effect_tolerance) * out_error->fitted);
    if (result == BTF_OK) {
        const joint_shape shape = joint_fit_shape(&r->plain);
        joint_run_note(r, &shape, plain_error.fitted, better ? "best" : "left out");
    }
    if (better) {
        enc_solution_clear(out_solution);
        *out_solution = plain;
        plain = (enc_solution){0};
        *out_error = plain_error;
        r->stats->rounds = 0;
    }
    enc_solution_clear(&plain);
    return result;
}

/* The plain factorisation with as many components as the budget allows. */
static btf_result start(joint_run *r) {
    const joint_shape shape = {.effects = BTF_EFFECT_RESIDUAL};
    const size_t k = joint_run_components(r, &shape);
    if (k == 0)
        return enc_fail(r->rows.context, BTF_ERROR_USAGE,
                        "joint: a budget of %llu bytes holds no component", (unsigned long long)r->budget);
    r->energy = malloc(k * sizeof *r->energy);
    if (!r->energy)
        return enc_fail(r->rows.context, BTF_ERROR_MEMORY, "joint: out of memory for %zu components", k);
    if (joint_step_take(&r->rows, "joint-plain", &r->plain, r->energy, k * sizeof *r->energy) &&
        r->plain.model.k == k && r->plain.effects == BTF_EFFECT_RESIDUAL && joint_step_finite(r->energy, k))
        return BTF_OK;
    joint_fit_clear(&r->plain);
    const btf_result result = joint_fit_plain(&r->rows, k, r->preset.start, &r->plain, r->energy);
    return result == BTF_OK ? joint_step_keep("joint-plain", &r->plain, r->energy, k * sizeof *r->energy)
                            : result;
}

static uint64_t bytes_with(const joint_run *r, const joint_fit *from, size_t components) {
    joint_shape shape = joint_fit_shape(from);
    shape.components = components;
    return joint_bytes(r->rows.data, &shape);
}

/* Replaces *solution and *error by those of the fewest components of `from` that reach the quality, if that
 * takes fewer bytes than *io_bytes. */
static btf_result reduce(joint_run *r, const joint_fit *from, uint64_t *io_bytes, enc_solution *solution,
                         joint_error *error) {
    size_t low = 0, high = from->model.k / 4 + 1; /* in fours: low fails, high is not known to fail */
    btf_result result = BTF_OK;
    while (high > 1 && bytes_with(r, from, 4 * (high - 1)) >= *io_bytes)
        high--;
    while (low + 1 < high && result == BTF_OK) {
        const size_t middle = (low + high) / 2;
        enc_solution trial = {0};
        joint_error trial_error;
        result = joint_run_finish_part(r, from, 4 * middle, &trial, &trial_error);
        if (result == BTF_OK && joint_psnr(&r->rows, trial_error.srgb) >= r->options->quality) {
            enc_solution_clear(solution);
            *solution = trial;
            *error = trial_error;
            *io_bytes = bytes_with(r, from, 4 * middle);
            high = middle;
        } else {
            enc_solution_clear(&trial);
            low = middle;
        }
    }
    return result;
}

/* options->quality: replaces *solution by the fewest bytes that reach it, of the best fit and of the plain
 * one. */
static btf_result reach_quality(joint_run *r, enc_solution *solution, joint_error *error) {
    btf_result result = BTF_OK;
    if (joint_psnr(&r->rows, error->srgb) < r->options->quality) {
        enc_log(r->rows.context, BTF_LOG_WARNING, "joint: %.2f dB of %.2f within %llu bytes",
                joint_psnr(&r->rows, error->srgb), r->options->quality, (unsigned long long)r->budget);
        return BTF_OK;
    }
    const joint_shape shape = joint_solution_shape(solution);
    uint64_t bytes = joint_bytes(r->rows.data, &shape);
    if (r->best.rows && r->best.model.k > 0)
        result = reduce(r, &r->best, &bytes, solution, error);
    if (result == BTF_OK && r->plain.rows && r->options->choose)
        result = reduce(r, &r->plain, &bytes, solution, error);
    return result;
}

/* From data to codes. */
static btf_result solve(joint_run *r, enc_solution *out_solution, joint_error *out_error) {
    const bool residual = r->options->effects & BTF_EFFECT_RESIDUAL, quality = r->options->quality > 0.0;
    bool done = false;
    btf_result result = BTF_OK;
    if (r->options->choose)
        result = joint_try_plain_sbrdf(r, out_solution, out_error, &done);
    if (result != BTF_OK || done)
        return result;
    if (residual) {
        joint_run_stage(r, JOINT_STAGE_START, r->costs.start);
        result = start(r);
    }
    if (result != BTF_OK)
        return result;
    const size_t plenty = residual && !quality && r->options->choose ? enough_components(r) : 0;
    if (plenty > 0) {
        joint_run_stage(r, JOINT_STAGE_CODES, r->costs.codes);
        return joint_run_finish_part(r, &r->plain, plenty, out_solution, out_error);
    }
    result = joint_try_shapes(r);
    if (result == BTF_OK && r->best.rows) {
        joint_run_stage(r, JOINT_STAGE_CENTRES, r->costs.centres);
        result = joint_try_hidden(r);
    }
    if (result == BTF_OK && !residual && !r->best.rows)
        result =
            enc_fail(r->rows.context, BTF_ERROR_USAGE, "joint: a budget of %llu bytes holds no such model",
                     (unsigned long long)r->budget);
    joint_run_stage(r, JOINT_STAGE_CODES, r->costs.codes);
    if (result == BTF_OK)
        result =
            residual ? finish_better(r, out_solution, out_error) : finish_best(r, out_solution, out_error);
    if (result == BTF_OK && quality)
        result = reach_quality(r, out_solution, out_error);
    return result;
}

static void fill_stats(joint_run *r, const enc_solution *solution, const joint_error *error) {
    const joint_shape shape = joint_solution_shape(solution);
    enc_joint_stats *stats = r->stats;
    stats->error = error->fitted;
    stats->psnr_fitted = joint_psnr(&r->rows, error->fitted);
    stats->psnr_linear = joint_psnr(&r->rows, error->linear);
    stats->psnr_srgb = joint_psnr(&r->rows, error->srgb);
    stats->gpu_bytes = joint_bytes(r->rows.data, &shape);
    for (size_t i = 0; i < r->rows.texels * r->rows.views && solution->shift; i++)
        stats->moved += solution->shift[2 * i] != 0 || solution->shift[2 * i + 1] != 0;
}

btf_result enc_joint(const enc_context *context, const enc_data *data, const enc_joint_options *options,
                     enc_solution *out_solution, enc_joint_stats *out_stats) {
    joint_run r = joint_run_prepare(context, data, options);
    joint_error error = {0};
    btf_result result = BTF_OK;
    *out_solution = (enc_solution){0};
    r.stats = calloc(1, sizeof *r.stats);
    if (!r.stats)
        return enc_fail(context, BTF_ERROR_MEMORY, "joint: out of memory");
    r.noted = progress_core_clock();
    const joint_extent extent = joint_extent_of(data);
    r.costs = joint_cost_run(data, &extent, options);
    joint_run_stage(&r, JOINT_STAGE_SURVEY, r.costs.survey);
    result = joint_rows_init(context, data, options->metric != ENC_JOINT_LINEAR, &r.rows);
    r.enough =
        exp10(-0.1 * enough_psnr) * (double)r.rows.texels * (double)r.rows.views * (double)r.rows.row;
    enc_stage_step(context, joint_cost_steps(r.costs.survey));
    if (result == BTF_OK)
        result = solve(&r, out_solution, &error);
    enc_stage_end(context);
    if (result == BTF_OK) {
        fill_stats(&r, out_solution, &error);
        if (out_stats)
            *out_stats = *r.stats;
    }
    if (result != BTF_OK)
        enc_solution_clear(out_solution);
    joint_fit_clear(&r.plain);
    joint_fit_clear(&r.best);
    joint_rows_clear(&r.rows);
    free(r.energy);
    free(r.stats);
    return result;
}

/* The `number`th round. */
static double one_round(const joint_extent *e, const joint_shape *s, int number) {
    double cost = joint_cost_search(e, s) + joint_cost_residual(e, s);
    if (s->lobes > 0 && (s->components == 0 || number % JOINT_FRONT_PERIOD == 0))
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
                (s->components > 0 ? JOINT_FRONT_STEPS * joint_cost_residual(e, s) : 0);
    return cost;
}

static double centres(const joint_extent *e, const joint_shape *s) {
    const uint32_t needed = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN;
    const double lights = e->row / 3, most = (e->texels + e->row * e->views) / lights;
    const double count = fmin(most, JOINT_MOST_CENTRES);
    if ((s->effects & needed) != needed)
        return 0;
    return joint_cost_cluster(e, count) + joint_cost_basis(e, s) + 2 * joint_cost_refresh(e, s) +
           one_round(e, s, 1);
}

joint_costs joint_cost_run(const enc_data *data, const joint_extent *e, const enc_joint_options *options) {
    const joint_run r = joint_run_prepare(NULL, data, options);
    joint_shape list[JOINT_MOST_TRIALS], plain = {.effects = BTF_EFFECT_RESIDUAL};
    joint_costs c = {.survey = joint_cost_survey(e)};
    const int count = joint_list_trials(&r, list);
    if (options->effects & BTF_EFFECT_RESIDUAL) {
        plain.components = joint_run_components(&r, &plain);
        c.start = (r.preset.start + 1) * joint_cost_residual(e, &plain);
    }
    const joint_shape *best = count > 0 ? &list[0] : &plain;
    const int rounds = joint_best_rounds(&r, best), trial = joint_trial_rounds(&r, count, rounds);
    for (int i = 0; i < count; i++)
        c.trials += trial_start(e, &list[i]) + many_rounds(e, &list[i], 0, trial);
    /* the first two, one of them with a front, are about as likely */
    for (int i = 0; i < count && i < 2; i++)
        c.rounds += many_rounds(e, &list[i], trial, rounds) / (count < 2 ? 1 : 2);
    if (count == 1) {
        c.rounds += c.trials;
        c.trials = 0;
    }
    if (options->effects & BTF_EFFECT_HIDDEN)
        c.centres = centres(e, best);
    c.codes = joint_cost_basis(e, best) + joint_cost_refresh(e, best) + joint_cost_quantise(e, best) +
              joint_cost_measure(e, best);
    if (options->quality > 0)
        c.codes =
            c.codes * (1 + QUALITY_TRIALS) + QUALITY_TRIALS * many_rounds(e, best, 0, JOINT_REDUCE_ROUNDS);
    return c;
}
