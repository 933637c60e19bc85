/* The arithmetic of FORMAT.md section 8 for the evaluator: free of branches, so that loops over it become
 * vectors.
 *
 * Compiled with -ffp-contract=off: one rounding an operation, in the written order.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EVALUATE_EXACT_H
#define OPENBTF_EVALUATE_EXACT_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

#define BTFI_INLINE static inline __attribute__((always_inline))

BTFI_INLINE uint32_t btfi_bits(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

BTFI_INLINE float btfi_float(uint32_t bits) {
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* The greatest integer <= x; -2^31 <= x < 2^31. */
BTFI_INLINE int32_t btfi_floor(float x) {
    const int32_t truncated = (int32_t)x;
    return truncated - ((float)truncated > x);
}

/* log2 of section 8; x normal and positive. */
BTFI_INLINE float btfi_log2(float x) {
    const int32_t i = (int32_t)(btfi_bits(x) - 0x3F3504F3u);
    const float f = btfi_float(((uint32_t)i & 0x7FFFFFu) + 0x3F3504F3u) - 1.0f;
    float p = btfi_float(0xBE157E27u);
    p = p * f + btfi_float(0x3E726D64u);
    p = p * f + btfi_float(0xBE7FEC0Fu);
    p = p * f + btfi_float(0x3E92CDF0u);
    p = p * f + btfi_float(0xBEB85F87u);
    p = p * f + btfi_float(0x3EF63D91u);
    p = p * f + btfi_float(0xBF38AAD4u);
    p = p * f + btfi_float(0x3FB8AA39u);
    return (float)(i >> 23) + f * p;
}

/* exp2 of section 8; -60 <= x <= 40. */
BTFI_INLINE float btfi_exp2(float x) {
    const int32_t i = btfi_floor(x + 0.5f);
    const float f = x - (float)i;
    float p = btfi_float(0x392245AAu);
    p = p * f + btfi_float(0x3AAFA1B1u);
    p = p * f + btfi_float(0x3C1D94D9u);
    p = p * f + btfi_float(0x3D63576Eu);
    p = p * f + btfi_float(0x3E75FDF0u);
    p = p * f + btfi_float(0x3F317218u);
    return btfi_float(btfi_bits(f * p + 1.0f) + ((uint32_t)i << 23));
}

/* 0 for a base below 2^-24 or NaN and for a result below 2^-60; at most 2^40. */
BTFI_INLINE float btfi_pow(float base, float exponent) {
    const bool some = base >= 0x1p-24f;
    const float t = exponent * btfi_log2(some ? base : 1.0f);
    const bool low = t < -60.0f;
    const float most = t > 40.0f ? 40.0f : t;
    const float r = btfi_exp2(low ? 0.0f : most);
    return some && !low ? r : 0.0f;
}

/* 1 / x by section 8's Newton steps; 0.5 <= x <= 4. */
BTFI_INLINE float btfi_reciprocal(float x) {
    float r = btfi_float(0x7EF311C7u - btfi_bits(x));
    for (int step = 0; step < 4; step++) {
        r = r * (2.0f - x * r);
    }
    return r;
}

/* Half to float: every half that section 2 accepts, and the rest too. */
BTFI_INLINE float btfi_half(uint16_t half) {
    const uint32_t sign = (uint32_t)(half & 0x8000u) << 16, magnitude = half & 0x7FFFu;
    if (magnitude < 0x400u) { /* zero, denormal */
        return btfi_float(sign | btfi_bits((float)magnitude * 0x1p-24f));
    }
    return btfi_float(sign | ((magnitude << 13) + (magnitude < 0x7C00u ? 112u << 23 : 224u << 23)));
}

/* The value, or 0 below 2^-30; at most 2^32. */
BTFI_INLINE float btfi_keep_within(float value) {
    return !(value >= 0x1p-30f) ? 0.0f : value > 0x1p32f ? 0x1p32f : value;
}

#endif
