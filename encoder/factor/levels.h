/* Rounding to the levels of a class, lane by lane.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_LEVELS_H
#define OPENBTF_ENCODER_FACTOR_LEVELS_H

#include <stddef.h>

/* Levels of one factor: -top .. top in steps of 1 with a zero, or in steps of 2 without one. */
typedef struct enc_factor_levels {
    float top, half, offset; /* level = rint(x * half - offset) / half + offset / half */
} enc_factor_levels;

static inline enc_factor_levels enc_factor_levels_of(int class, int top) {
    return class == 0 ? (enc_factor_levels){(float)top, 1.0f, 0.0f}
                      : (enc_factor_levels){(float)top, 0.5f, 0.5f};
}

/* The level next to x, x in levels; to the even one of two as near. Adding and taking off 1.5 * 2^23 rounds
 * to an integer, in any vector width. */
static inline __attribute__((always_inline)) float enc_factor_level(enc_factor_levels l, float x) {
    x = x > l.top ? l.top : x;
    x = x < -l.top ? -l.top : x;
    const float rounded = (x * l.half - l.offset + 0x1.8p23f) - 0x1.8p23f;
    return (rounded + l.offset) * (1.0f / l.half);
}

#endif
