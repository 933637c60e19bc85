/* A seeded generator of random numbers (splitmix64, G. Steele et al. 2014): the same numbers on every machine.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_RANDOM_H
#define OPENBTF_CONFORMANCE_RANDOM_H

#include <stdint.h>
#include <string.h>

typedef struct random_state {
    uint64_t state;
} random_state;

static inline uint64_t random_bits(random_state *r) {
    uint64_t z = r->state += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

/* 0 .. bound - 1 */
static inline uint32_t random_below(random_state *r, uint32_t bound) {
    return (uint32_t)((random_bits(r) >> 32) * bound >> 32);
}

/* from <= x < to */
static inline double random_between(random_state *r, double from, double to) {
    return from + (to - from) * ((double)(random_bits(r) >> 11) * 0x1p-53);
}

static inline float float_of_bits(uint32_t bits) {
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

static inline uint32_t bits_of_float(float f) {
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    return bits;
}

#endif
