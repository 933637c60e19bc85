/* OpenBTF shaders: log2, exp2, pow and reciprocal from additions, multiplications and bits (FORMAT.md
 * section 8).
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_FAST_MATH

float btf_log2(float x) {
    return log2(x);
}
float btf_exp2(float x) {
    return exp2(x);
}
float btf_reciprocal(float x) {
    return 1.0 / x;
}

#else

#define BTF_HORNER(p, x, bits) btf_add(btf_mul(p, x), uintBitsToFloat(bits))

/* The bits of section 8. A float below the root of 1/2 belongs to the exponent before, so that the f of log2 lies around
 * 0; the polynomials of log2 and exp2 are fitted there. */
#define BTF_BITS_ROOT_OF_HALF 0x3F3504F3
#define BTF_BITS_MANTISSA 0x7FFFFF
#define BTF_LOG2_0 0x3FB8AA39u
#define BTF_LOG2_1 0xBF38AAD4u
#define BTF_LOG2_2 0x3EF63D91u
#define BTF_LOG2_3 0xBEB85F87u
#define BTF_LOG2_4 0x3E92CDF0u
#define BTF_LOG2_5 0xBE7FEC0Fu
#define BTF_LOG2_6 0x3E726D64u
#define BTF_LOG2_7 0xBE157E27u
#define BTF_EXP2_0 0x3F317218u
#define BTF_EXP2_1 0x3E75FDF0u
#define BTF_EXP2_2 0x3D63576Eu
#define BTF_EXP2_3 0x3C1D94D9u
#define BTF_EXP2_4 0x3AAFA1B1u
#define BTF_EXP2_5 0x392245AAu
#define BTF_RECIPROCAL_START 0x7EF311C7u /* less the bits of x: 1 / x within 5.1 % */

/* x normal and positive. */
float btf_log2(float x) {
    int i = floatBitsToInt(x) - BTF_BITS_ROOT_OF_HALF;
    float f = btf_add(intBitsToFloat((i & BTF_BITS_MANTISSA) + BTF_BITS_ROOT_OF_HALF), -1.0);
    float p = uintBitsToFloat(BTF_LOG2_7);
    p = BTF_HORNER(p, f, BTF_LOG2_6);
    p = BTF_HORNER(p, f, BTF_LOG2_5);
    p = BTF_HORNER(p, f, BTF_LOG2_4);
    p = BTF_HORNER(p, f, BTF_LOG2_3);
    p = BTF_HORNER(p, f, BTF_LOG2_2);
    p = BTF_HORNER(p, f, BTF_LOG2_1);
    p = BTF_HORNER(p, f, BTF_LOG2_0);
    return btf_add(float(i >> 23), btf_mul(f, p));
}

/* -60 <= x <= 40. */
float btf_exp2(float x) {
    float i = floor(btf_add(x, 0.5));
    float f = btf_add(x, -i);
    float p = uintBitsToFloat(BTF_EXP2_5);
    p = BTF_HORNER(p, f, BTF_EXP2_4);
    p = BTF_HORNER(p, f, BTF_EXP2_3);
    p = BTF_HORNER(p, f, BTF_EXP2_2);
    p = BTF_HORNER(p, f, BTF_EXP2_1);
    p = BTF_HORNER(p, f, BTF_EXP2_0);
    float r = btf_add(btf_mul(f, p), 1.0);
    return uintBitsToFloat(floatBitsToUint(r) + (uint(int(i)) << 23u));
}

/* 0.5 <= x <= 4. */
float btf_reciprocal(float x) {
    float r = uintBitsToFloat(BTF_RECIPROCAL_START - floatBitsToUint(x));
    for (int i = 0; i < 4; ++i)
        r = btf_mul(r, btf_add(2.0, -btf_mul(x, r)));
    return r;
}

#endif

/* base^exponent; 0 for a base below 2^-24 and for a result below 2^-60, 2^40 at most. Where the result is 0, what
 * precedes has no meaning and does no harm: integers wrap. */
float btf_pow(float base, float exponent) {
    float t = btf_mul(exponent, btf_log2(base));
    float y = btf_exp2(min(t, 40.0));
    return base < uintBitsToFloat(BTF_BITS_2_TO_MINUS_24) || t < -60.0 ? 0.0 : y;
}
