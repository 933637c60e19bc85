/* A walk over budgets. See stop.h.
 *
 * A plan takes a millisecond, so that one is made for each budget of a grid. Plans have whole units; where
 * these are few, two plans differ by more than a tenth of the bytes. The walk therefore stops at the
 * maximum of dB - tolerance * log(bytes) / log(1.1): beyond it no step, however wide, gains the tolerance
 * for each tenth more bytes.
 *
 * The error of rounding to 8 bits does not count: of a strong component it may be more than the energy of
 * all weak ones, but the descent lets these make up for it, so that more bytes still pay.
 *
 * SPDX-License-Identifier: MIT
 */
#include "stop.h"

#include <math.h>
#include <stdlib.h>

/* Ratio of one budget of the grid to the one before. */
#define STEP 1.05

typedef struct walk {
    const enc_factor_energies *gains; /* at left-out samples, of the components that are signal */
    size_t texels, n_views, n_lights;
    double floor;
} walk;

static bool plan_at(const walk *w, double budget, enc_factor_plan *plan, double *out_bytes,
                    double *out_error) {
    const bool found =
        enc_factor_allocate(w->gains, w->texels, w->n_views, w->n_lights, (uint64_t)budget, plan);
    if (found) {
        *out_bytes = (double)enc_factor_bytes(plan, w->texels, w->n_views, w->n_lights);
        *out_error = fmax(w->floor + enc_factor_plan_error(w->gains, plan, 1), 1e-30);
    }
    return found;
}

/* Walks from the budget down to one unit, and notes the bytes that pay and what the budget gains over
 * them. */
static bool find_bytes(const walk *w, uint64_t budget, double tolerance, enc_unspent *unspent) {
    const double price = tolerance / log(ENC_STOP_MORE);
    enc_factor_plan plan;
    double bytes = 0, error = 0, best = -INFINITY, best_error = 0;
    const enc_factor_plan least = {{{ENC_FACTOR_UNIT_WORDS, 0, 0}}};
    const double lowest = (double)enc_factor_bytes(&least, w->texels, w->n_views, w->n_lights);
    for (double at = (double)budget; at >= lowest; at = fmin(at / STEP, bytes)) {
        if (!plan_at(w, at, &plan, &bytes, &error)) {
            return false;
        }
        const double value = -10 * log10(error) - price * log(bytes);
        if (at == (double)budget) {
            unspent->gain = -10 * log10(error);
        }
        if (value >= best) {
            best = value;
            best_error = error;
            unspent->bytes = (uint64_t)bytes;
        }
        bytes -= 1;
    }
    unspent->gain += 10 * log10(best_error);
    return true;
}

bool enc_stop_allocate(const enc_factor_energies *energies, const enc_signal *signal, size_t texels,
                       size_t n_views, size_t n_lights, uint64_t budget, double tolerance,
                       enc_factor_plan *out_plan, enc_unspent *out_unspent) {
    enc_factor_energies gains = {.rounding = NULL};
    double *gain[ENC_FACTOR_CHANNELS];
    walk w = {.gains = &gains, .texels = texels, .n_views = n_views, .n_lights = n_lights};
    bool found = true;
    *out_unspent = (enc_unspent){.budget = budget, .more = ENC_STOP_MORE, .tolerance = tolerance};
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        gain[c] = malloc((signal->rank[c] + 1) * sizeof(double));
        found = found && gain[c];
        gains.rank[c] = out_unspent->signal[c] = signal->rank[c];
        gains.energy[c] = gain[c];
        out_unspent->ends[c] = signal->rank[c] < energies->rank[c];
        w.floor += signal->floor[c];
        for (size_t j = 0; j < signal->rank[c] && found; j++) {
            gain[c][j] = energies->energy[c][j] * signal->share[c][j];
        }
    }
    found = found && find_bytes(&w, budget, tolerance, out_unspent) &&
            enc_factor_allocate(energies, texels, n_views, n_lights, out_unspent->bytes, out_plan);
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        free(gain[c]);
    }
    return found;
}
