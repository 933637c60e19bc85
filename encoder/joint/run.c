/* The steps of a run of the joint method. See run.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "run.h"

#include "steps.h"

#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/progress.h"
#include "encoder/base/stage.h"

#include <openbtf/material.h>
#include <string.h>

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

/* The record beside a fit in a checkpoint: the rounds it went through, and whether it is done. */
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

bool joint_run_take(const joint_run *r, const char *step, joint_fit *fit, double *history, int *out_rounds,
                    bool *out_over) {
    round_note note;
    joint_fit kept;
    *out_over = false;
    if (!joint_step_take(&r->rows, step, &kept, &note, sizeof note))
        return false;
    if (note.rounds < 0 || note.rounds > ENC_JOINT_MAX_ROUNDS ||
        !joint_step_finite(note.history, (size_t)note.rounds)) {
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
    btf_result result = joint_fit_quantise(fit);
    joint_fit_release(fit);
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

joint_run joint_run_prepare(const enc_context *context, const enc_data *data,
                            const enc_joint_options *options) {
    return (joint_run){.options = options,
                       .preset = joint_preset_of(options),
                       .budget = options->budget ? options->budget : joint_default_budget(data),
                       .rows = {.context = context, .data = data, .texels = enc_data_texel_count(data)}};
}

void joint_run_stage(const joint_run *r, const char *name, double cost) {
    enc_stage_begin(r->rows.context, name, joint_cost_steps(cost));
}
