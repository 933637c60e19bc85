/* Which shapes are tried, and what decides between them. See trials.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "trials.h"

#include "front_fit.h"
#include "search_set.h"

#include <assert.h>
#include <math.h>
#include <openbtf/material.h>
#include <stdio.h>
#include <string.h>

enum {
    STARTS = 2,          /* of the SBRDF of a front */
    SMALL = 1024,        /* texels up to which every candidate is tried by every preset */
    FEW_COMPONENTS = 16, /* below which sources without a residual are tried, too */
};

/* A plain SBRDF whose first probe leaves so many times what is enough (25 dB above it) is not pursued. */
static const double hopeless = 316.0;

/* dB that a candidate may be behind after a round and still be tried to the end. */
static const double catch_up = 0.3;

/* Fronts from the fewest bytes to the most; half floats. */
static const joint_front_kind fronts[] = {
    {.lobes = 1, .half = true},
    {.lobes = 2, .half = true},
    {.lobes = 1, .rgb = true, .half = true},
    {.lobes = 3, .half = true},
    {.lobes = 2, .rgb = true, .half = true},
    {.lobes = 3, .rgb = true, .half = true},
};
enum { FRONTS = sizeof fronts / sizeof *fronts };

static void set_front(joint_shape *shape, const joint_front_kind *kind) {
    shape->lobes = kind ? kind->lobes : 0;
    shape->rgb = kind && kind->rgb;
    shape->half = kind && kind->half;
}

static joint_front_kind front_of(const joint_shape *shape) {
    return (joint_front_kind){.lobes = shape->lobes,
                              .rgb = shape->rgb,
                              .shadow = shape->effects & BTF_EFFECT_SHADOW,
                              .half = shape->half};
}

/* Gives the shape the richest front that leaves as many components as the smallest does; false when not
 * even that one fits. */
static bool add_front(const joint_run *r, joint_shape *shape) {
    joint_shape fitting = *shape;
    bool found = false;
    for (int i = 0; i < FRONTS; i++) {
        set_front(shape, &fronts[i]);
        const size_t k = shape->effects & BTF_EFFECT_RESIDUAL ? joint_run_components(r, shape) : 0;
        if (joint_bytes(r->rows.data, shape) > r->budget)
            break;
        if ((shape->effects & BTF_EFFECT_RESIDUAL) && (k == 0 || (found && k < fitting.components)))
            break;
        shape->components = k;
        fitting = *shape;
        found = true;
    }
    *shape = fitting;
    return found;
}

/* Adds a shape with these effects, and a front if asked for, where the budget holds one. */
static void propose(const joint_run *r, uint32_t effects, bool front, joint_shape *list, int *count) {
    joint_shape shape = {.effects = effects};
    assert(*count < JOINT_MOST_TRIALS);
    if (!front)
        shape.components = joint_run_components(r, &shape);
    if (front ? add_front(r, &shape) : shape.components > 0)
        list[(*count)++] = shape;
}

/* With options->choose every set of the effects may be proposed, else only the given one. */
int joint_list_trials(const joint_run *r, joint_shape list[JOINT_MOST_TRIALS]) {
    const uint32_t allowed = r->options->effects & ~(uint32_t)BTF_EFFECT_HIDDEN;
    const uint32_t maps = allowed & (BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN);
    const uint32_t shadow = allowed & BTF_EFFECT_SHADOW, residual = allowed & BTF_EFFECT_RESIDUAL;
    const bool choose = r->options->choose;
    int count = 0;
    if (residual && (choose || !shadow)) {
        propose(r, maps | residual, false, list, &count);
        propose(r, maps | residual, true, list, &count);
    }
    if (residual && choose)
        for (uint32_t left_out = BTF_EFFECT_GAIN; left_out >= BTF_EFFECT_SHIFT; left_out /= 2)
            if ((maps & left_out) && maps != left_out)
                propose(r, (maps & ~left_out) | residual, false, list, &count);
    if (residual && shadow)
        propose(r, maps | residual | shadow, true, list, &count);
    if (residual && choose && maps && shadow)
        propose(r, residual | shadow, true, list, &count);
    if (residual && choose && maps)
        propose(r, residual, true, list, &count);
    if (!residual || (choose && (count == 0 || list[0].components < FEW_COMPONENTS)))
        propose(r, maps | shadow, true, list, &count);
    if (choose && !residual && shadow && maps)
        propose(r, maps, true, list, &count);
    return r->rows.texels > SMALL && count > r->preset.trials ? r->preset.trials : count;
}

int joint_best_rounds(const joint_run *r, const joint_shape *first) {
    return r->options->rounds > 0  ? r->options->rounds
           : first->components > 0 ? r->preset.rounds
                                   : r->preset.front;
}

int joint_trial_rounds(const joint_run *r, int count, int rounds) {
    return count > 1 && r->preset.trial_rounds < rounds ? r->preset.trial_rounds : rounds;
}

/* dB that candidate b is better than a. */
static double gain(double a, double b) {
    return a > 0.0 ? (b > 0.0 ? 10.0 * log10(a / b) : HUGE_VAL) : b > 0.0 ? -HUGE_VAL : 0.0;
}

/* The gain of a byte spent on components, in dB, by the last of the plain factorisation's. 0 where the
 * budget bounds the components: there all candidates take about the same bytes. */
static double worth_of_byte(const joint_run *r) {
    const size_t k = r->plain.model.k;
    double last = 0.0;
    if (r->rows.texels <= JOINT_EXACT || r->options->components > 0 || k <= JOINT_LAYER)
        return 0.0;
    const joint_shape all = {.effects = BTF_EFFECT_RESIDUAL, .components = k};
    const joint_shape fewer = {.effects = BTF_EFFECT_RESIDUAL, .components = k - JOINT_LAYER};
    for (size_t j = k - JOINT_LAYER; j < k; j++)
        last += r->energy[j];
    const uint64_t bytes = joint_bytes(r->rows.data, &all) - joint_bytes(r->rows.data, &fewer);
    return gain(r->plain.error + last, r->plain.error) / (double)bytes;
}

/* dB that b has to gain over a to take its place. A front is worth front_tolerance: with it a file shows
 * something without the residual, too. Where it takes bytes of its own, it has to bring what components
 * would in them. Of others that differ by less than the effect tolerance, the one with fewer effects is
 * taken. */
static double needed_gain(const joint_run *r, const joint_fit *a, const joint_fit *b) {
    const joint_shape old = joint_fit_shape(a), new = joint_fit_shape(b);
    const double bytes = (double)joint_bytes(r->rows.data, &new) - (double)joint_bytes(r->rows.data, &old);
    double needed = r->options->effect_tolerance_bytes * bytes * 1e-6;
    if (!old.lobes != !new.lobes)
        needed += (old.lobes ? r->options->front_tolerance : -r->options->front_tolerance) +
                  worth_of_byte(r) * bytes;
    const int difference = __builtin_popcount(new.effects) - __builtin_popcount(old.effects);
    if (new.effects != old.effects && difference != 0)
        needed += difference > 0 ? r->options->effect_tolerance : -r->options->effect_tolerance;
    return needed;
}

/* Starts a candidate. */
static btf_result start_one(joint_run *r, const joint_shape *shape, joint_fit *out_fit) {
    const joint_front_kind kind = front_of(shape);
    if (shape->components == 0)
        return joint_fit_front_alone(&r->rows, shape->effects, &kind, STARTS, out_fit);
    const size_t k = shape->components < r->plain.model.k ? shape->components : r->plain.model.k;
    const btf_result result = joint_fit_start(&r->plain, k, shape->effects, out_fit);
    return result == BTF_OK && shape->lobes > 0
               ? joint_fit_add_front(out_fit, &kind, STARTS, JOINT_FRONT_STEPS)
               : result;
}

/* Whether a candidate is too far behind where the best was after as many rounds. */
static bool is_behind(const joint_run *r, const joint_fit *fit, int done) {
    return r->best.rows && done > 0 && done <= r->stats->rounds &&
           gain(r->stats->history[done - 1], fit->error) < needed_gain(r, &r->best, fit) - catch_up;
}

/* Starts a candidate, or takes it from a checkpoint, and lets it go through `rounds`, or fewer where it is
 * behind. */
static btf_result try_one(joint_run *r, const joint_shape *shape, int number, int rounds, double *history,
                          int *out_done, joint_fit *out_fit) {
    char step[32];
    bool over = false;
    btf_result result = BTF_OK;
    *out_done = 0;
    snprintf(step, sizeof step, "joint-trial-%d", number);
    if (!joint_run_take(r, step, out_fit, history, out_done, &over))
        result = start_one(r, shape, out_fit);
    while (result == BTF_OK && !over && *out_done < rounds && !is_behind(r, out_fit, *out_done)) {
        const int before = *out_done;
        result = joint_run_rounds(r, out_fit, before + 1, step, history, out_done, &over);
        over = over || *out_done == before; /* it is enough */
    }
    return result;
}

btf_result joint_try_shapes(joint_run *r) {
    joint_shape list[JOINT_MOST_TRIALS];
    const int count = joint_list_trials(r, list);
    const int rounds = count > 0 ? joint_best_rounds(r, &list[0]) : 0;
    const int trial = joint_trial_rounds(r, count, rounds);
    double history[ENC_JOINT_MAX_ROUNDS];
    btf_result result = BTF_OK;
    joint_fit_release(&r->plain);
    if (count > 1)
        joint_run_stage(r, JOINT_STAGE_TRIALS, r->costs.trials);
    else
        joint_run_stage(r, JOINT_STAGE_ROUNDS, r->costs.rounds);
    for (int i = 0; i < count && result == BTF_OK; i++) {
        joint_fit fit = {0};
        int done = 0;
        joint_fit_release(&r->best);
        result = try_one(r, &list[i], i, trial, history, &done, &fit);
        const bool better = result == BTF_OK && (!r->best.rows || gain(r->best.error, fit.error) >
                                                                      needed_gain(r, &r->best, &fit));
        if (result == BTF_OK)
            joint_run_note(r, &list[i], fit.error, better ? "best so far" : "left out");
        if (better) {
            joint_fit_clear(&r->best);
            r->best = fit;
            fit = (joint_fit){0};
            r->stats->rounds = done;
            memcpy(r->stats->history, history, (size_t)done * sizeof *history);
        }
        joint_fit_clear(&fit);
    }
    bool over = false;
    if (result == BTF_OK && count > 1)
        joint_run_stage(r, JOINT_STAGE_ROUNDS, r->costs.rounds);
    if (result == BTF_OK && count > 0)
        joint_run_take(r, "joint-best", &r->best, r->stats->history, &r->stats->rounds, &over);
    if (result == BTF_OK && count > 0)
        result = joint_run_rounds(r, &r->best, rounds, "joint-best", r->stats->history, &r->stats->rounds,
                                  &over);
    joint_fit_release(&r->best);
    return result;
}

btf_result joint_try_plain_sbrdf(joint_run *r, enc_solution *out_solution, joint_error *out_error,
                                 bool *out_done) {
    static const joint_front_kind exact[] = {{.lobes = 3}, {.lobes = 3, .rgb = true}};
    const joint_front_kind *kinds[FRONTS + 2];
    const double samples = (double)r->rows.texels * (double)r->rows.views * (double)r->rows.row;
    btf_result result = BTF_OK;
    *out_done = false;
    for (int i = 0; i < FRONTS + 2; i++)
        kinds[i] = i < FRONTS ? &fronts[i] : &exact[i - FRONTS];
    for (int i = 0; i < FRONTS + 2 && result == BTF_OK && !*out_done; i++) {
        joint_shape shape = {0};
        joint_fit fit = {0};
        double probe;
        set_front(&shape, kinds[i]);
        if (joint_bytes(r->rows.data, &shape) > r->budget)
            continue;
        result = joint_front_probe(&r->rows, kinds[i], STARTS, JOINT_PROBED, &probe);
        if (result == BTF_OK && i == 0)
            joint_run_note(r, &shape, probe * samples, "probe");
        if (result != BTF_OK || probe * samples > hopeless * r->enough)
            break;
        if (probe * samples > r->enough)
            continue;
        result = joint_fit_front_alone(&r->rows, 0, kinds[i], STARTS, &fit);
        if (result == BTF_OK && fit.error <= r->enough) {
            joint_run_note(r, &shape, fit.error, "enough");
            r->stats->history[0] = fit.error;
            r->stats->rounds = 1;
            result = joint_run_finish(r, &fit, out_solution, out_error);
            *out_done = result == BTF_OK;
        }
        joint_fit_clear(&fit);
    }
    return result;
}
