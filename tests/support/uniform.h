/* Repeatable random numbers for data whose other properties a test plans itself.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_UNIFORM_H
#define OPENBTF_TESTS_UNIFORM_H

#include <stdint.h>

/* 0 <= x < 1, from the upper bits of a linear congruential generator (Knuth's and Lewis's constants, Numerical Recipes). */
static inline float uniform(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) * 0x1p-24f;
}

#endif
