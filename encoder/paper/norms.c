/* Sums of Euclidean norms over light profiles (see norms.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "norms.h"

#include "encoder/math/simd.h"

#ifdef ENC_HAVE_X86_DISPATCH
#include <immintrin.h>
#else
#include <math.h>
#endif

/* The correctly rounded square root of each lane, the same bits from each instruction set. */
ENC_INLINE void root_base(const enc_v16 *x, enc_v16 *out) {
#ifdef ENC_HAVE_X86_DISPATCH
    for (int i = 0; i < 4; i++) {
        _mm_storeu_ps((float *)out + 4 * i, _mm_sqrt_ps(_mm_loadu_ps((const float *)x + 4 * i)));
    }
#else
    for (int i = 0; i < ENC_LANES; i++) {
        (*out)[i] = sqrtf((*x)[i]);
    }
#endif
}

/* The body of every kernel below: sums of norms of a - b over `blocks` vectors of lights, a and b planar
 * with channels `lanes` apart. Lanes are added in pairs, in one order. */
#define NORM_SUM(a, b, blocks, lanes, ROOT, result)                                                        \
    do {                                                                                                   \
        enc_v16 sum_ = {0};                                                                                \
        for (size_t i_ = 0; i_ < (blocks); i_++) {                                                         \
            const size_t at_ = i_ * ENC_LANES;                                                             \
            const enc_v16 r_ = *(const enc_v16u *)((a) + at_) - *(const enc_v16u *)((b) + at_);            \
            const enc_v16 g_ =                                                                             \
                *(const enc_v16u *)((a) + (lanes) + at_) - *(const enc_v16u *)((b) + (lanes) + at_);       \
            const enc_v16 b_ = *(const enc_v16u *)((a) + 2 * (lanes) + at_) -                              \
                               *(const enc_v16u *)((b) + 2 * (lanes) + at_);                               \
            const enc_v16 square_ = r_ * r_ + g_ * g_ + b_ * b_;                                           \
            enc_v16 norm_;                                                                                 \
            ROOT(&square_, &norm_);                                                                        \
            sum_ = sum_ + norm_;                                                                           \
        }                                                                                                  \
        float half_[8];                                                                                    \
        for (int k_ = 0; k_ < 8; k_++)                                                                     \
            half_[k_] = sum_[k_] + sum_[k_ + 8];                                                           \
        for (int k_ = 0; k_ < 4; k_++)                                                                     \
            half_[k_] += half_[k_ + 4];                                                                    \
        (result) = (half_[0] + half_[2]) + (half_[1] + half_[3]);                                          \
    } while (0)

/* Defines both functions of enc_norms for one instruction set. */
#define DEFINE_KERNELS(name, TARGET, ROOT)                                                                 \
    TARGET static void bounds_##name(const float *query, const float *candidates, size_t count,            \
                                     float *bounds) {                                                      \
        for (size_t i = 0; i < count; i++)                                                                 \
            NORM_SUM(query, candidates + i * 3 * ENC_NORM_LANES, 1, ENC_NORM_LANES, ROOT, bounds[i]);      \
    }                                                                                                      \
    TARGET static float distance_##name(const float *a, const float *b, size_t lanes) {                    \
        float result;                                                                                      \
        NORM_SUM(a, b, lanes / ENC_LANES, lanes, ROOT, result);                                            \
        return result;                                                                                     \
    }

#define NO_TARGET
DEFINE_KERNELS(base, NO_TARGET, root_base)
#ifdef ENC_HAVE_X86_DISPATCH
ENC_TARGET_AVX2 static inline void root_avx2(const enc_v16 *x, enc_v16 *out) {
    for (int i = 0; i < 2; i++) {
        _mm256_storeu_ps((float *)out + 8 * i, _mm256_sqrt_ps(_mm256_loadu_ps((const float *)x + 8 * i)));
    }
}
ENC_TARGET_AVX512 static inline void root_avx512(const enc_v16 *x, enc_v16 *out) {
    _mm512_storeu_ps((float *)out, _mm512_sqrt_ps(_mm512_loadu_ps((const float *)x)));
}
DEFINE_KERNELS(avx2, ENC_TARGET_AVX2, root_avx2)
DEFINE_KERNELS(avx512, ENC_TARGET_AVX512, root_avx512)
#endif

enc_norms enc_norms_choose(void) {
#ifdef ENC_HAVE_X86_DISPATCH
    const enc_isa isa = enc_isa_current();
    if (isa == ENC_ISA_AVX512) {
        return (enc_norms){.distance = distance_avx512, .bounds = bounds_avx512};
    }
    if (isa == ENC_ISA_AVX2) {
        return (enc_norms){.distance = distance_avx2, .bounds = bounds_avx2};
    }
#endif
    return (enc_norms){.distance = distance_base, .bounds = bounds_base};
}
