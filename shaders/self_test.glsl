/* OpenBTF shaders: does this device add, multiply and convert as FORMAT.md section 8 demands?
 *
 * Each check is small and has a name (BTF_SELF_TEST_... in openbtf/shader.h), so that a device which is not
 * supported can say why. Inputs are XORed with a zero that is known at run time only: nothing can be folded
 * beforehand. Denormals are not asked for.
 *
 * SPDX-License-Identifier: MIT
 */
#define BTF_COLOUR 2
#define BTF_LAYOUT_TIGHT 1
#define BTF_NO_INTERFACE
#include "options.glsl"
#include "interface.glsl"
#include "exact.glsl"
#include "elementary.glsl"

bool btf_is(float x, uint bits) {
    return floatBitsToUint(x) == bits;
}

uint btf_check_contraction(uint zero) {
    float one = uintBitsToFloat(0x3F800000u ^ zero);
    float a = uintBitsToFloat(0x3F800800u ^ zero);     /* 1 + 2^-12 */
    float b = uintBitsToFloat(0x3F7FF001u ^ zero);     /* 1 - 2^-12 + 2^-24 */
    float third = uintBitsToFloat(0x3EAAAAABu ^ zero); /* 1/3 */
    float three = uintBitsToFloat(0x40400000u ^ zero);
    /* Each product is inexact, so that a fused sum leaves another remainder. */
    vec3 sum = btf_add(btf_mul(vec3(a, third, a), vec3(b, three, a)), vec3(-one));
    bool ok = btf_is(sum.x, 0u) && btf_is(sum.y, 0u) && btf_is(sum.z, 0x3A000000u);
    ok = ok && btf_is(btf_add(btf_mul(a, b), -one), 0u) && btf_is(btf_add(-one, btf_mul(third, three)), 0u);
    return ok ? 0u : 1u;
}

uint btf_check_reassociation(uint zero) {
    float big = uintBitsToFloat(0x4B800000u ^ zero); /* 2^24 */
    float one = uintBitsToFloat(0x3F800000u ^ zero);
    bool ok = btf_is(btf_add(btf_add(big, one), one), 0x4B800000u);
    ok = ok && btf_is(btf_add(big, btf_add(one, one)), 0x4B800001u);
    ok = ok && btf_is(btf_add(btf_add(big, one), -big), 0u);
    /* a b + a c against a (b + c), and constants that could be multiplied beforehand. */
    float a = uintBitsToFloat(0x3F8CCCC3u ^ zero); /* about 1.1 */
    float b = uintBitsToFloat(0x3EAAAAABu ^ zero); /* 1/3 */
    float c = uintBitsToFloat(0x3DCCCCCDu ^ zero); /* 0.1 */
    ok = ok && btf_is(btf_add(btf_mul(a, b), btf_mul(a, c)), 0x3EF40D97u);
    ok = ok && btf_is(btf_mul(btf_mul(a, uintBitsToFloat(0x3DCCCCCDu)), uintBitsToFloat(0x3EAAAAABu)),
                      0x3D162FC0u);
    ok = ok && btf_is(btf_add(btf_add(c, 16777216.0), -16777216.0), 0u);
    return ok ? 0u : 2u;
}

uint btf_check_rounding(uint zero) {
    float one = uintBitsToFloat(0x3F800000u ^ zero);
    float next = uintBitsToFloat(0x3F800001u ^ zero);
    float half_ulp = uintBitsToFloat(0x33800000u ^ zero); /* 2^-24 */
    float more_than_half = uintBitsToFloat(0x33800001u ^ zero);
    bool ok = btf_is(btf_add(one, half_ulp), 0x3F800000u) && btf_is(btf_add(next, half_ulp), 0x3F800002u) &&
              btf_is(btf_add(one, more_than_half), 0x3F800001u) &&
              btf_is(btf_add(-one, -more_than_half), 0xBF800001u);
    /* (1 + 3 2^-12)(1 + 2^-12) = 1 + 2^-10 + 3 2^-24: a tie, to even. */
    float p = uintBitsToFloat(0x3F801800u ^ zero), q = uintBitsToFloat(0x3F800800u ^ zero);
    ok = ok && btf_is(btf_mul(p, q), 0x3F802002u) && btf_is(btf_mul(-p, q), 0xBF802002u);
    return ok ? 0u : 4u;
}

uint btf_check_flush(uint zero) {
    float least = uintBitsToFloat(0x00800000u ^ zero); /* 2^-126 */
    float one = uintBitsToFloat(0x3F800000u ^ zero);
    float root = uintBitsToFloat(0x20000000u ^ zero); /* 2^-63 */
    bool ok = btf_is(btf_mul(least, one), 0x00800000u) && btf_is(btf_mul(root, root), 0x00800000u) &&
              btf_is(btf_add(least, least), 0x01000000u);
    return ok ? 0u : 8u;
}

uint btf_check_conversion(uint zero) {
    bool ok = btf_is(float(16777215u ^ zero), 0x4B7FFFFFu) &&
              btf_is(float(int(520191u ^ zero)), 0x48FDFFE0u) &&
              btf_is(float(-int(520191u ^ zero)), 0xC8FDFFE0u);
    float x = uintBitsToFloat(0xC0200000u ^ zero); /* -2.5 */
    ok = ok && int(floor(x)) == -3 && int(x) == -2 && btf_is(floor(x), 0xC0400000u);
    float y = uintBitsToFloat(0x4E7FFFFFu ^ zero); /* 2^30 - 64 */
    ok = ok && int(y) == 0x3FFFFFC0 && btf_is(floor(y), 0x4E7FFFFFu);
    ok = ok && floatBitsToUint(uintBitsToFloat(0x3F123456u ^ zero)) == 0x3F123456u;
    return ok ? 0u : 16u;
}

uint btf_check_integer(uint zero) {
    uint a = 0x9E3779B9u ^ zero;
    int b = int(0xFFFFFF81u ^ zero); /* -127 */
    bool ok = a * a == 0xE35E67B1u && a + a == 0x3C6EF372u && (a >> 18u) == 10125u;
    ok = ok && (b >> 3) == -16 && b * b == 16129;
    ok = ok && btf_divide(0x7FFFF000u ^ zero, 0x7FFFFu) == 4096u &&
         btf_divide(0x7FFFEFFFu ^ zero, 0x7FFFFu) == 4095u;
    ok = ok && btf_divide(zero, 3u) == 0u && btf_divide(2000000001u ^ zero, 488282u ^ zero) == 4095u;
    return ok ? 0u : 32u;
}

uint btf_check_elementary(uint zero) {
    uint hash = 2166136261u;
    uint state = 12345u ^ zero;
    for (uint i = 0u; i < 64u; ++i) {
        state = state * 1664525u + 1013904223u;
        float b = uintBitsToFloat(0x3D000000u + (state >> 5u) % 0x03800000u); /* 2^-5 .. 4 */
        float n = uintBitsToFloat(0x3F000000u + (state >> 3u) % 0x03000000u); /* 0.5 .. 32 */
        float d = uintBitsToFloat(0x3F000000u + (state >> 7u) % 0x01800000u); /* 0.5 .. 4 */
        hash = (hash ^ floatBitsToUint(btf_log2(b))) * 16777619u;
        hash = (hash ^ floatBitsToUint(btf_pow(b, n))) * 16777619u;
        hash = (hash ^ floatBitsToUint(btf_reciprocal(d))) * 16777619u;
    }
    return hash == 0x1140115Au ? 0u : 64u;
}

/* Steps of the decoder of factors: products of packed fields modulo 2^32, of which a borrow is undone before an arithmetic
 * shift; sums of integers to 5e8, shifted below 2^24, where they convert exactly. */
uint btf_check_factors(uint zero) {
    uint hash = 2166136261u;
    uint state = 98765u ^ zero;
    for (uint i = 0u; i < 32u; ++i) {
        state = state * 1664525u + 1013904223u;
        uvec4 w = state * uvec4(1u, 3u, 5u, 7u), u = (state ^ (state >> 15u)) * uvec4(9u, 11u, 13u, 15u);
        uvec4 t = uvec4(0u);
        for (uint s = 0u; s < 16u; s += 4u)
            t += ((w >> s) & 0x000F000Fu) * (((u >> s) & 0x000F000Fu) * 2u - 0x000F000Fu);
        ivec4 e = (ivec4(t + 0x8000u) >> 16) * int(4095u ^ zero);
        e += ((ivec4(w) << 8) >> 24) * ((ivec4(u) << 8) >> 24);
        uvec4 sum = floatBitsToUint(vec4(e >> 1));
        for (int k = 0; k < 4; ++k)
            hash = (hash ^ sum[k]) * 16777619u;
    }
    int most = int(501350399u ^ zero);
    bool ok = hash == 0xB337006Du && btf_is(float(most >> 5), 0x4B6F0FFFu) && btf_is(float(-most >> 5), 0xCB6F1000u);
    ok = ok && btf_is(float(-int(16777215u ^ zero)), 0xCB7FFFFFu);
    return ok ? 0u : 256u;
}

/* The sum of the bits of the rules that fail, 0 where exact decoding works. zero is 0, which the compiler must not
 * know. */
uint btf_self_test(uint zero) {
    return btf_check_contraction(zero) | btf_check_reassociation(zero) | btf_check_rounding(zero) |
           btf_check_flush(zero) | btf_check_conversion(zero) | btf_check_integer(zero) |
           btf_check_elementary(zero) | btf_check_factors(zero);
}
