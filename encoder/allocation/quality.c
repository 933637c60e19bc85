/* Budgets for a quality. See quality.h.
 *
 * The allocation expects too large an error of each budget, as descent on the codes takes part of it back,
 * and counts roots where a quality counts sRGB codes: an encode reaches some dB more, by an amount
 * that changes little from budget to budget. Between two that were tried it is taken to change evenly with
 * the logarithm of bytes.
 *
 * SPDX-License-Identifier: MIT
 */
#include "quality.h"

#include <math.h>

/* The most bytes of a budget that whole units, of one and of two texels of u, fill. */
static uint64_t whole_units(size_t texels, size_t n_views, size_t n_lights, uint64_t budget) {
    const enc_factor_plan none = {{{0}}}, one = {{{ENC_FACTOR_UNIT_WORDS}}};
    const uint64_t unit = enc_factor_bytes(&one, texels, n_views, n_lights) -
                          enc_factor_bytes(&none, texels, n_views, n_lights);
    uint64_t most = 0;
    for (uint32_t twos = 0; 2 * twos <= ENC_FACTOR_MOST_UNITS; twos++) {
        const enc_factor_plan plan = {{{0}, {ENC_FACTOR_UNIT_WORDS * twos}}};
        const uint64_t least = enc_factor_bytes(&plan, texels, n_views, n_lights);
        if (least > budget) {
            break;
        }
        const uint64_t room = (budget - least) / unit, left = ENC_FACTOR_MOST_UNITS - 2 * twos;
        const uint64_t bytes = least + unit * (room < left ? room : left);
        most = bytes > most ? bytes : most;
    }
    return most;
}

bool enc_quality_begin(const enc_factor_energies *energies, size_t texels, size_t n_views, size_t n_lights,
                       uint64_t most, uint64_t least, double quality, double decibels,
                       enc_quality_search *out) {
    *out = (enc_quality_search){.quality = quality};
    for (uint64_t at = most; at >= least && out->count < ENC_QUALITY_BUDGETS;) {
        enc_factor_plan plan;
        if (!enc_factor_allocate(energies, texels, n_views, n_lights, at, &plan)) {
            return false;
        }
        const double error = enc_factor_plan_error(energies, &plan, 0);
        out->budget[out->count] = at;
        out->expected[out->count++] = -10 * log10(fmax(error, 1e-30));
        at = whole_units(texels, n_views, n_lights, at - at / 100 - 1);
    }
    out->fails = out->count;
    enc_quality_note(out, 0, decibels);
    return true;
}

/* dB by which the quality of a budget exceeds the expected one, measured or interpolated. */
static double above_at(const enc_quality_search *s, size_t index) {
    if (s->fails == s->count) {
        return s->above[0];
    }
    const double high = log((double)s->budget[s->reaches]), low = log((double)s->budget[s->fails]);
    const double share = (high - log((double)s->budget[index])) / (high - low);
    return s->above[0] + share * (s->above[1] - s->above[0]);
}

size_t enc_quality_next(const enc_quality_search *s) {
    if (s->reaches + 1 >= s->fails) {
        return s->count;
    }
    size_t index = s->fails - 1;
    while (index > s->reaches + 1 && s->expected[index] + above_at(s, index) < s->quality) {
        index--;
    }
    return index;
}

void enc_quality_note(enc_quality_search *s, size_t index, double decibels) {
    const double above = decibels - s->expected[index];
    if (decibels >= s->quality) {
        s->reaches = index;
        s->above[0] = above;
    } else {
        s->fails = index;
        s->above[1] = above;
    }
}
