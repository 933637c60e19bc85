/* A run of the joint method from data to codes (see joint.h, joint_run.h).
 *
 * An SBRDF alone comes first, if a sample of texels promises that it is enough. The plain factorisation is
 * next: it is the start of all other shapes, and their rival where nothing moves. The candidates are tried
 * for a few rounds from there; the best of them is fitted to the end, and kept unless the plain one is
 * better.
 *
 * SPDX-License-Identifier: MIT
 */
#include "run.h"
#include "steps.h"

#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/progress.h"
#include "encoder/base/stage.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* dB in the fitted domain that 8-bit codes reach but hardly pass: better is not sought. */
static const double enough_psnr = 55.0;

/* The plain factorisation is finished, too, where its error is at most so many times the best one's. */
static const double plain_chance = 1.03;

static const joint_preset_values presets[] = {
    [ENC_JOINT_FAST] = {3, 1, 1, 5, 2, 2e-3},
    [ENC_JOINT_MEDIUM] = {4, 3, 2, 18, 4, 5e-4},
    [ENC_JOINT_THOROUGH] = {5, 6, 4, 60, 10, 1e-4},
    [ENC_JOINT_EXHAUSTIVE] = {8, 20, 6, ENC_JOINT_MAX_ROUNDS, 100, 1e-6},
};

enc_joint_options enc_joint_options_default(void) {
    return (enc_joint_options){.preset = ENC_JOINT_MEDIUM,
                               .effects = BTF_EFFECT_ALL,
                               .choose = true,
                               .effect_tolerance = 0.05,
                               .front_tolerance = 0.1};
}

size_t joint_run_components(const joint_run *r, const joint_shape *shape) {
    joint_shape with = *shape;
    with.effects |= BTF_EFFECT_RESIDUAL;
    const size_t limit =
        r->options->components > 0 ? (size_t)r->options->components : ENC_JOINT_MOST_COMPONENTS;
    return joint_components_for(r->rows.data, &with, r->budget, limit);
}

void joint_run_note(joint_run *r, const joint_shape *shape, double error, const char *verdict) {
    enc_joint_stats *stats = r->stats;
    const double now = progress_core_clock();
    const enc_trial trial = {.effects = shape->effects,
                             .lobes = shape->lobes,
                             .rgb = shape->rgb,
                             .components = (int)shape->components,
                             .centres = (int)shape->centres,
                             .gpu_bytes = joint_bytes(r->rows.data, shape),
                             .psnr = joint_psnr(&r->rows, error),
                             .core_seconds = now - r->noted,
                             .verdict = verdict};
    if (stats->trials_count < ENC_MAX_TRIALS)
        stats->trials[stats->trials_count++] = trial;
    char text[64];
    r->noted = now;
    enc_log(r->rows.context, BTF_LOG_INFO,
            "joint: %s, %d lobe%s%s, %zu components, %llu bytes: %.2f dB, %s",
            cli_effects_text(shape->effects, text), shape->lobes, shape->lobes == 1 ? "" : "s",
            shape->rgb ? " in RGB" : "", shape->components, (unsigned long long)trial.gpu_bytes, trial.psnr,
            verdict);
}

/* What a checkpoint holds beside a fit: the rounds it went through, and whether it is done. */
typedef struct round_note {
    int rounds, over;
    double history[ENC_JOINT_MAX_ROUNDS];
} round_note;

static btf_result keep_rounds(const char *step, const joint_fit *fit, int rounds, bool over,
                              const double *history) {
    round_note note = {.rounds = rounds, .over = over};
    if (!step || !fit->rows->context->checkpoint)
        return BTF_OK;
    memcpy(note.history, history, (size_t)rounds * sizeof *history);
    return joint_step_keep(step, fit, &note, sizeof note);
}

static bool are_finite(const double *values, size_t count) {
    bool good = true;
    for (size_t i = 0; good && i < count; i++)
        good = isfinite(values[i]);
    return good;
}

bool joint_run_take(const joint_run *r, const char *step, joint_fit *fit, double *history, int *out_rounds,
                    bool *out_over) {
    round_note note;
    joint_fit kept;
    *out_over = false;
    if (!joint_step_take(&r->rows, step, &kept, &note, sizeof note))
        return false;
    if (note.rounds < 0 || note.rounds > ENC_JOINT_MAX_ROUNDS ||
        !are_finite(note.history, (size_t)note.rounds)) {
        joint_fit_clear(&kept);
        return false;
    }
    joint_fit_clear(fit);
    *fit = kept;
    memcpy(history, note.history, (size_t)note.rounds * sizeof *history);
    *out_rounds = note.rounds;
    *out_over = note.over;
    return true;
}

btf_result joint_run_rounds(joint_run *r, joint_fit *fit, int count, const char *step, double *history,
                            int *io_rounds, bool *io_over) {
    btf_result result = BTF_OK;
    while (result == BTF_OK && !*io_over && *io_rounds < count && fit->error > r->enough) {
        const double before = fit->error;
        result = joint_fit_round(fit);
        if (result != BTF_OK)
            break;
        history[(*io_rounds)++] = fit->error;
        *io_over = before - fit->error < r->preset.tolerance * before;
        result = keep_rounds(step, fit, *io_rounds, *io_over, history);
    }
    return result;
}

btf_result joint_run_finish(joint_run *r, joint_fit *fit, enc_solution *out_solution,
                            joint_error *out_error) {
    btf_result result = joint_fit_round_off(fit);
    joint_fit_rest(fit);
    if (result == BTF_OK)
        result = joint_fit_solution(fit, out_solution);
    if (result == BTF_OK)
        result = joint_measure(&r->rows, out_solution, out_error);
    const joint_extent extent = joint_extent_of(r->rows.data);
    const joint_shape shape = joint_solution_shape(out_solution);
    enc_stage_step(r->rows.context, joint_cost_steps(joint_cost_measure(&extent, &shape)));
    return result;
}

btf_result joint_run_finish_part(joint_run *r, const joint_fit *from, size_t k, enc_solution *out_solution,
                                 joint_error *out_error) {
    joint_fit fit = {0};
    double history[JOINT_REDUCE_ROUNDS];
    int done = 0;
    bool over = false;
    btf_result result = joint_fit_start(from, k, from->effects, &fit);
    if (result == BTF_OK && k < from->model.k) {
        if (from->effects == BTF_EFFECT_RESIDUAL && !from->model.front)
            result = joint_fit_refine_plain(&fit, 1, NULL);
        else
            result = joint_run_rounds(r, &fit, JOINT_REDUCE_ROUNDS, NULL, history, &done, &over);
    }
    if (result == BTF_OK)
        result = joint_run_finish(r, &fit, out_solution, out_error);
    joint_fit_clear(&fit);
    return result;
}

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
    joint_fit_rest(&r->plain);
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
        r->plain.model.k == k && r->plain.effects == BTF_EFFECT_RESIDUAL && are_finite(r->energy, k))
        return BTF_OK;
    joint_fit_clear(&r->plain);
    const btf_result result = joint_fit_plain(&r->rows, k, r->preset.start, &r->plain, r->energy);
    return result == BTF_OK ? joint_step_keep("joint-plain", &r->plain, r->energy, k * sizeof *r->energy)
                            : result;
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
    result = joint_try_candidates(r);
    if (result == BTF_OK && r->best.rows) {
        joint_run_stage(r, JOINT_STAGE_CENTRES, r->costs.centres);
        result = joint_try_centres(r);
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
        result = joint_reach_quality(r, out_solution, out_error);
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

joint_run joint_run_prepare(const enc_context *context, const enc_data *data,
                            const enc_joint_options *options) {
    joint_run r = {.options = options,
                   .preset = presets[options->preset],
                   .budget = options->budget ? options->budget : joint_default_budget(data),
                   .rows = {.context = context, .data = data, .texels = enc_data_texel_count(data)}};
    if (options->tolerance > 0.0)
        r.preset.tolerance = options->tolerance;
    return r;
}

void joint_run_stage(const joint_run *r, const char *name, double cost) {
    enc_stage_begin(r->rows.context, name, joint_cost_steps(cost));
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
