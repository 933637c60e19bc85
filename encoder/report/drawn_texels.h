/* Sums over texels that are drawn from a data set, the same whatever thread or rank adds them up.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_DRAWN_TEXELS_H
#define OPENBTF_ENCODER_DRAWN_TEXELS_H

#include "encoder/data/data.h"

#include <stdint.h>

/* Mixes the bits of a number, so that consecutive ones give numbers as if drawn at random (SplitMix64;
 * Steele, Lea and Flood 2014). */
static inline uint64_t enc_mix(uint64_t x) {
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

/* Adds the contribution of draw number `index` to the sums. samples: all samples of the texel (enc_data_texels).
 * Called from several threads at once. */
typedef btf_result enc_measure_texel(const void *user, size_t index, size_t texel, const float *samples,
                                     double *sums);

/* Draws `draws` texels, one from each of as many equal parts of the data, and adds the `length` sums of
 * each to total[length], in the order of the draws. Shared by the ranks; all have the totals after it.
 * draws: 1 .. number of texels. Errors: BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED, those of enc_data_texels
 * and of `measure`. */
btf_result enc_drawn_texels_sum(const enc_context *context, const enc_data *data, size_t draws,
                                size_t length, enc_measure_texel *measure, const void *user, double *total);

#endif
