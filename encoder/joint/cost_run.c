/* What a run of the joint method costs, by stage. See joint_cost.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cost.h"
#include "run.h"

#include <math.h>
#include <openbtf/material.h>

enum { QUALITY_TRIALS = 5 }; /* of the search of the fewest components */

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
    joint_shape list[JOINT_MOST_CANDIDATES], plain = {.effects = BTF_EFFECT_RESIDUAL};
    joint_costs c = {.survey = joint_cost_survey(e)};
    const int count = joint_list_candidates(&r, list);
    if (options->effects & BTF_EFFECT_RESIDUAL) {
        plain.components = joint_run_components(&r, &plain);
        c.start = (r.preset.start + 1) * joint_cost_residual(e, &plain);
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
    c.codes = joint_cost_basis(e, best) + joint_cost_refresh(e, best) + joint_cost_quantise(e, best) +
              joint_cost_measure(e, best);
    if (options->quality > 0)
        c.codes =
            c.codes * (1 + QUALITY_TRIALS) + QUALITY_TRIALS * many_rounds(e, best, 0, JOINT_REDUCE_ROUNDS);
    return c;
}
