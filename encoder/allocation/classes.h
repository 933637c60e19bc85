/* Numbers of the classes of the factors of format 2 (FORMAT.md), whose table is the model's, and rounding to
 * their levels, lane by lane.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_CLASSES_H
#define OPENBTF_ENCODER_CLASSES_H

#include "encoder/model/factor_store.h"

enum {
    ENC_FACTOR_CLASSES = 5,
    ENC_FACTOR_TIERS = 3,
    ENC_FACTOR_CHANNELS = 3, /* Y, C1, C2 */
    ENC_FACTOR_MOST_UNITS = 256,
    ENC_FACTOR_MOST_WORD = 16, /* components a word, at most */
    ENC_FACTOR_UNIT_WORDS = 4,
};

/* Levels of one factor: -top .. top in steps of 1 with a zero, or in steps of 2 without one. */
typedef struct enc_factor_levels {
    float top, half, offset; /* level = rint(x * half - offset) / half + offset / half */
} enc_factor_levels;

static inline enc_factor_levels enc_factor_levels_of(int class, int top) {
    return class == 0 ? (enc_factor_levels){(float)top, 1.0f, 0.0f}
                      : (enc_factor_levels){(float)top, 0.5f, 0.5f};
}

/* The level next to x, x in levels; of two that are equally near, the even one. Adding and taking off 1.5 *
 * 2^23 rounds to an integer, in any vector width. */
static inline __attribute__((always_inline)) float enc_factor_level(enc_factor_levels l, float x) {
    x = x > l.top ? l.top : x;
    x = x < -l.top ? -l.top : x;
    const float rounded = (x * l.half - l.offset + 0x1.8p23f) - 0x1.8p23f;
    return (rounded + l.offset) * (1.0f / l.half);
}

#endif
