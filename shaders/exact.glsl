/* OpenBTF shaders: addition and multiplication with one rounding each (FORMAT.md section 8).
 *
 * Every float sum and product of the decoder is made here, so that this is the one place that keeps a
 * compiler from contracting, factoring or reassociating them: with `precise` where the language has it;
 * elsewhere each result passes through a bit cast, XORed with a zero that is known at run time only.
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_FAST_MATH
#define BTF_PRECISE
#define BTF_ROUND(x) (x)
#else
#if BTF_HAVE_PRECISE
#define BTF_PRECISE precise
#define BTF_ROUND(x) (x)
#else
#define BTF_PRECISE
#define BTF_ROUND(x) uintBitsToFloat(floatBitsToUint(x) ^ BTF_ZERO)
#endif
#endif

/* Floats as their bits, which every compiler takes for the same number, and for comparisons that no NaN passes and no
 * compiler removes. */
#define BTF_BITS_MAGNITUDE 0x7FFFFFFFu    /* all bits but the sign */
#define BTF_BITS_INFINITY 0x7F800000
#define BTF_BITS_LEAST_NORMAL 0x00800000u /* 2^-126; below it lie denormals and 0 */
#define BTF_BITS_2_TO_MINUS_30 0x30800000u
#define BTF_BITS_2_TO_MINUS_24 0x33800000u
#define BTF_BITS_2_TO_MINUS_20 0x35800000u
#define BTF_BITS_2_TO_MINUS_16 0x37800000u
#define BTF_BITS_2_TO_MINUS_13 0x39000000u
#define BTF_BITS_2_TO_MINUS_12 0x39800000u
#define BTF_BITS_2_TO_MINUS_11 0x3A000000u
#define BTF_BITS_2_TO_MINUS_8 0x3B800000u
#define BTF_BITS_2_TO_MINUS_7 0x3C000000u
#define BTF_BITS_BEFORE_1 0x3F7FFFFFu /* 1 - 2^-24, the last float below 1 */
#define BTF_BITS_2 0x40000000u
#define BTF_BITS_4096 0x45800000u

float btf_mul(float a, float b) {
    BTF_PRECISE float r = BTF_ROUND(a * b);
    return r;
}
vec3 btf_mul(vec3 a, vec3 b) {
    BTF_PRECISE vec3 r = BTF_ROUND(a * b);
    return r;
}
vec3 btf_mul(vec3 a, float b) {
    BTF_PRECISE vec3 r = BTF_ROUND(a * b);
    return r;
}
vec4 btf_mul(vec4 a, vec4 b) {
    BTF_PRECISE vec4 r = BTF_ROUND(a * b);
    return r;
}
vec4 btf_mul(vec4 a, float b) {
    BTF_PRECISE vec4 r = BTF_ROUND(a * b);
    return r;
}
float btf_add(float a, float b) {
    BTF_PRECISE float r = BTF_ROUND(a + b);
    return r;
}
vec3 btf_add(vec3 a, vec3 b) {
    BTF_PRECISE vec3 r = BTF_ROUND(a + b);
    return r;
}

/* n / d of integers, 0 <= n < 2^31, d > 0, n / d <= 4096. The float quotient is off by one at most, however
 * the device divides; the remainder tells. Faster than most devices' integer division. */
uint btf_divide(uint n, uint d) {
    uint q = uint(float(n) / float(d));
    int r = int(n) - int(q * d);
    return r < 0 ? q - 1u : (r >= int(d) ? q + 1u : q);
}
