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

/* x normal and positive. */
float btf_log2(float x) {
    int i = floatBitsToInt(x) - 0x3F3504F3;
    float f = btf_add(intBitsToFloat((i & 0x7FFFFF) + 0x3F3504F3), -1.0);
    float p = uintBitsToFloat(0xBE157E27u);
    p = BTF_HORNER(p, f, 0x3E726D64u);
    p = BTF_HORNER(p, f, 0xBE7FEC0Fu);
    p = BTF_HORNER(p, f, 0x3E92CDF0u);
    p = BTF_HORNER(p, f, 0xBEB85F87u);
    p = BTF_HORNER(p, f, 0x3EF63D91u);
    p = BTF_HORNER(p, f, 0xBF38AAD4u);
    p = BTF_HORNER(p, f, 0x3FB8AA39u);
    return btf_add(float(i >> 23), btf_mul(f, p));
}

/* -60 <= x <= 40. */
float btf_exp2(float x) {
    float i = floor(btf_add(x, 0.5));
    float f = btf_add(x, -i);
    float p = uintBitsToFloat(0x392245AAu);
    p = BTF_HORNER(p, f, 0x3AAFA1B1u);
    p = BTF_HORNER(p, f, 0x3C1D94D9u);
    p = BTF_HORNER(p, f, 0x3D63576Eu);
    p = BTF_HORNER(p, f, 0x3E75FDF0u);
    p = BTF_HORNER(p, f, 0x3F317218u);
    float r = btf_add(btf_mul(f, p), 1.0);
    return uintBitsToFloat(floatBitsToUint(r) + (uint(int(i)) << 23u));
}

/* 0.5 <= x <= 4. */
float btf_reciprocal(float x) {
    float r = uintBitsToFloat(0x7EF311C7u - floatBitsToUint(x));
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
    return base < uintBitsToFloat(0x33800000u) || t < -60.0 ? 0.0 : y;
}
