/* Whether hidden points pay (see joint_run.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "hidden.h"
#include "run.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

/* Centres that the budget holds beside r->best with k components. */
static size_t room(const joint_run *r, size_t k) {
    joint_shape shape = joint_fit_shape(&r->best);
    shape.components = k;
    shape.effects |= BTF_EFFECT_HIDDEN;
    const uint64_t bytes = joint_bytes(r->rows.data, &shape);
    const uint64_t each = 4 * (uint64_t)r->rows.data->n_lights;
    const uint64_t most = bytes < r->budget ? (r->budget - bytes) / each : 0;
    /* one block of FORMAT.md section 3: nothing is rounded up */
    return (size_t)(most < JOINT_MOST_CENTRES ? most : JOINT_MOST_CENTRES);
}

/* r->best without its last four components, in the principal basis that it is in. */
static btf_result shorten(joint_run *r) {
    joint_fit shorter = {0};
    joint_fit_rest(&r->best);
    const btf_result result =
        joint_fit_start(&r->best, r->best.model.k - JOINT_LAYER, r->best.effects, &shorter);
    if (result == BTF_OK) {
        joint_fit_clear(&r->best);
        r->best = shorter;
    } else {
        joint_fit_clear(&shorter);
    }
    return result;
}

/* What the last four components explain; brings r->best into its principal basis. */
static btf_result last_energy(joint_run *r, double *out_energy) {
    const size_t k = r->best.model.k;
    double *energy = malloc((k + 1) * sizeof *energy);
    if (!energy)
        return enc_fail(r->rows.context, BTF_ERROR_MEMORY, "joint: out of memory for %zu components", k);
    const btf_result result = joint_principal_basis(&r->rows, &r->best.model, energy);
    *out_energy = 0.0;
    for (size_t j = k - JOINT_LAYER; j < k && result == BTF_OK; j++)
        *out_energy += energy[j];
    joint_fit_rest(&r->best);
    free(energy);
    return result;
}

/* Notes what centres would do; whether they are worth it. */
static bool worth_it(joint_run *r, const joint_centres *centres, size_t k, double error) {
    joint_shape shape = joint_fit_shape(&r->best);
    shape.components = k;
    shape.effects |= BTF_EFFECT_HIDDEN;
    shape.centres = centres->count;
    const double gain = 10.0 * log10(r->best.error / fmax(error, 1e-30));
    const bool worth = centres->count > 0 && (!r->options->choose || gain >= r->options->effect_tolerance);
    joint_run_note(r, &shape, error, worth ? "best so far" : "left out");
    return worth;
}

btf_result joint_try_centres(joint_run *r) {
    const uint32_t needed = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN;
    const size_t k = r->best.model.k, beside = room(r, k),
                 more = k > JOINT_LAYER ? room(r, k - JOINT_LAYER) : 0;
    joint_centres few = {0}, many = {0};
    double lost = 0.0;
    btf_result result = BTF_OK;
    if (!(r->options->effects & BTF_EFFECT_HIDDEN) || (r->best.effects & needed) != needed ||
        r->best.error <= r->enough)
        return BTF_OK;
    if (beside > 0)
        result = joint_centres_find(&r->best, beside, &few);
    if (result == BTF_OK && more > beside)
        result = joint_centres_find(&r->best, more, &many);
    if (result == BTF_OK && more > beside)
        result = last_energy(r, &lost);
    const bool forced = !r->options->choose && few.count == 0 && many.count > 0;
    if (result == BTF_OK && (many.saved - lost > few.saved || forced)) {
        if (worth_it(r, &many, k - JOINT_LAYER, r->best.error + lost - many.saved)) {
            result = joint_centres_apply(&r->best, &many);
            if (result == BTF_OK)
                result = shorten(r);
        }
    } else if (result == BTF_OK && few.count > 0) {
        if (worth_it(r, &few, k, r->best.error - few.saved))
            result = joint_centres_apply(&r->best, &few);
    }
    joint_centres_clear(&few);
    joint_centres_clear(&many);
    if (result == BTF_OK && (r->best.effects & BTF_EFFECT_HIDDEN))
        result = joint_fit_round(&r->best);
    joint_fit_rest(&r->best);
    return result;
}
