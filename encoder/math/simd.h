/* Sixteen float lanes: log2, exp2 and the lobe's power as FORMAT.md section 8 writes them, and the choice
 * of the instruction set at run time.
 *
 * Every operation is lane-wise IEEE add, subtract, multiply or integer work in one written order, so that
 * the SSE2, AVX2 and AVX-512 copies of a loop give the same bits (the files that include this are compiled
 * with -ffp-contract=off). Vectors are handed over by address: passing them by value would tie the calling
 * convention to the instruction set.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MATH_SIMD_H
#define OPENBTF_ENCODER_MATH_SIMD_H

#include <stdint.h>

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

enum { ENC_LANES = 16 };

typedef float enc_v16 __attribute__((vector_size(64), may_alias));
typedef int32_t enc_i16 __attribute__((vector_size(64), may_alias));
/* An enc_v16 without an alignment, for loads from and stores to anywhere. */
typedef float enc_v16u __attribute__((vector_size(64), aligned(4), may_alias));

#define ENC_INLINE static inline __attribute__((always_inline))

#if defined(__x86_64__) && defined(__GNUC__)
#define ENC_HAVE_X86_DISPATCH 1
#define ENC_TARGET_AVX2 __attribute__((target("avx2")))
#define ENC_TARGET_AVX512 __attribute__((target("avx512f")))
#endif

/* Instruction sets that the vector loops are compiled for, in rising order. */
typedef enum enc_isa { ENC_ISA_BASE = 0, ENC_ISA_AVX2 = 1, ENC_ISA_AVX512 = 2 } enc_isa;

/* The best set that this machine has, or the forced one if it is lower. Thread-safe. */
enc_isa enc_isa_current(void);
/* Uses at most `limit` from here on: for tests and measurements, since results do not depend on it.
 * Not to be called while other threads compute. */
void enc_isa_limit(enc_isa limit);

/* mask ? a : b, lane by lane; mask lanes are 0 or -1. */
ENC_INLINE void enc_v16_select(const enc_i16 *mask, const enc_v16 *a, const enc_v16 *b, enc_v16 *out) {
    *out = (enc_v16)((*mask & (enc_i16)*a) | (~*mask & (enc_i16)*b));
}

/* -1 in the lanes where x < limit, else 0, by the sign of x - limit, which gradual underflow keeps right:
 * GCC 12 compiles a comparison of 64-byte vectors to one of single lanes. */
ENC_INLINE void enc_v16_below(const enc_v16 *x, float limit, enc_i16 *out) {
    *out = (enc_i16)(*x - limit) >> 31;
}

/* log2(x), x normal and positive. */
ENC_INLINE void enc_v16_log2(const enc_v16 *x, enc_v16 *out) {
    const enc_i16 i = (enc_i16)*x - 0x3F3504F3;
    const enc_i16 e = i >> 23;
    const enc_v16 f = (enc_v16)((i & 0x7FFFFF) + 0x3F3504F3) - 1.0f;
    enc_v16 p = f * -0x1.2afc4ep-3f + 0x1.e4dac8p-3f;
    p = p * f + -0x1.ffd81ep-3f;
    p = p * f + 0x1.259bep-2f;
    p = p * f + -0x1.70bf0ep-2f;
    p = p * f + 0x1.ec7b22p-2f;
    p = p * f + -0x1.7155a8p-1f;
    p = p * f + 0x1.715472p+0f;
    *out = __builtin_convertvector(e, enc_v16) + f * p;
}

/* exp2(x), -60 <= x <= 40. */
ENC_INLINE void enc_v16_exp2(const enc_v16 *x, enc_v16 *out) {
    const enc_v16 t = *x + 0.5f;
    enc_i16 i = __builtin_convertvector(t, enc_i16);
    i += (enc_i16)(t - __builtin_convertvector(i, enc_v16)) >> 31; /* floor */
    const enc_v16 f = *x - __builtin_convertvector(i, enc_v16);
    enc_v16 p = f * 0x1.448b54p-13f + 0x1.5f4362p-10f;
    p = p * f + 0x1.3b29b2p-7f;
    p = p * f + 0x1.c6aedcp-5f;
    p = p * f + 0x1.ebfbep-3f;
    p = p * f + 0x1.62e43p-1f;
    const enc_v16 r = f * p + 1.0f;
    *out = (enc_v16)((enc_i16)r + (i << 23));
}

/* exp2(x) with x taken as 40 above 40, and 0 below x = -60. */
ENC_INLINE void enc_v16_exp2_clamped(const enc_v16 *x, enc_v16 *out) {
    const enc_v16 zero = {0}, high = zero + 40.0f;
    enc_i16 above, below;
    enc_v16 t, r;
    const enc_v16 room = high - *x;
    enc_v16_below(&room, 0.0f, &above);
    enc_v16_below(x, -60.0f, &below);
    enc_v16_select(&above, &high, x, &t);
    enc_v16_select(&below, &zero, &t, &t);
    enc_v16_exp2(&t, &r);
    *out = (enc_v16)(~below & (enc_i16)r);
}

/* pow(b, n) of FORMAT.md: 0 below b = 2^-24 and below 2^-60, at most 2^40; n is the same in all lanes. */
ENC_INLINE void enc_v16_pow(const enc_v16 *b, float n, enc_v16 *out) {
    const enc_v16 zero = {0}, one = zero + 1.0f;
    enc_i16 off;
    enc_v16 safe, t, r;
    enc_v16_below(b, 0x1p-24f, &off);
    enc_v16_select(&off, &one, b, &safe);
    enc_v16_log2(&safe, &t);
    t = n * t;
    enc_v16_exp2_clamped(&t, &r);
    *out = (enc_v16)(~off & (enc_i16)r);
}

#endif
