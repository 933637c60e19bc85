/* OpenBTF reference decoder: exact arithmetic (FORMAT.md, section 8).
 *
 * Additions, multiplications and integer steps alone, one rounding an operation, in the written order, so
 * that the same bits come from every machine. Errors against the true values: see openbtf/reference.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "btf_reference_private.h"

/** Bits of sqrt(1/2), rounded: a mantissa is taken from [sqrt(1/2), sqrt(2)). */
#define SQRT_HALF 0x3F3504F3u

/** FORMAT.md, L0 to L7: log2(1 + f) / f as a polynomial of f. */
static const uint32_t log2_bits[8] = {
    0x3FB8AA39u, 0xBF38AAD4u, 0x3EF63D91u, 0xBEB85F87u, 0x3E92CDF0u, 0xBE7FEC0Fu, 0x3E726D64u, 0xBE157E27u,
};

/** FORMAT.md, E0 to E5: (2^f - 1) / f as a polynomial of f. */
static const uint32_t exp2_bits[6] = {
    0x3F317218u, 0x3E75FDF0u, 0x3D63576Eu, 0x3C1D94D9u, 0x3AAFA1B1u, 0x392245AAu,
};

float btf_ref_log2(float x) {
    uint32_t i = btf_ref_bits(x) - SQRT_HALF;
    /* floor of the signed i / 2^23, for which C has no portable shift: i + 2^31 is not negative */
    int32_t exponent = (int32_t)((i + 0x80000000u) >> 23) - 256;
    float f = btf_ref_float((i & 0x7FFFFFu) + SQRT_HALF) - 1.0f;

    float p = btf_ref_float(log2_bits[7]);
    for (int j = 6; j >= 0; --j) {
        p = p * f;
        p = p + btf_ref_float(log2_bits[j]);
    }
    p = f * p;
    return (float)exponent + p;
}

float btf_ref_exp2(float x) {
    int32_t i = btf_ref_floor(x + 0.5f);
    float f = x - (float)i;

    float p = btf_ref_float(exp2_bits[5]);
    for (int j = 4; j >= 0; --j) {
        p = p * f;
        p = p + btf_ref_float(exp2_bits[j]);
    }
    float r = f * p;
    r = r + 1.0f;
    return btf_ref_float(btf_ref_bits(r) + ((uint32_t)i << 23));
}

float btf_ref_pow(float base, float exponent) {
    if (!(base >= 0x1p-24f)) {
        return 0.0f;
    }
    float t = exponent * btf_ref_log2(base);
    if (t < -60.0f) {
        return 0.0f;
    }
    return btf_ref_exp2(t > 40.0f ? 40.0f : t);
}

float btf_ref_reciprocal(float x) {
    float r = btf_ref_float(0x7EF311C7u - btf_ref_bits(x));
    for (int step = 0; step < 4; ++step) {
        float error = x * r;
        error = 2.0f - error;
        r = r * error;
    }
    return r;
}

float btf_ref_half(uint16_t bits) {
    uint32_t sign = (uint32_t)(bits & 0x8000u) << 16;
    uint32_t exponent = (bits >> 10) & 31u;
    uint32_t mantissa = bits & 0x3FFu;

    if (exponent == 31) { /* infinity, or a NaN that keeps its payload */
        return btf_ref_float(sign | 0x7F800000u | mantissa << 13);
    }
    if (exponent != 0) {
        return btf_ref_float(sign | (exponent + 112u) << 23 | mantissa << 13);
    }
    if (mantissa == 0) {
        return btf_ref_float(sign);
    }
    /* a denormal half, mantissa * 2^-24, is a normal float */
    float magnitude = (float)mantissa * 0x1p-24f;
    return btf_ref_float(sign | btf_ref_bits(magnitude));
}

bool btf_ref_probe_arithmetic(void) {
    return btf_ref_probe();
}
