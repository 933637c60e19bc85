/* Chooses the copy of the vector loops that runs.
 *
 * SPDX-License-Identifier: MIT
 */
#include "simd.h"

static enc_isa isa_limit = ENC_ISA_AVX512;

enc_isa enc_isa_current(void) {
    enc_isa best = ENC_ISA_BASE;
#ifdef ENC_HAVE_X86_DISPATCH
    if (__builtin_cpu_supports("avx512f")) {
        best = ENC_ISA_AVX512;
    } else if (__builtin_cpu_supports("avx2")) {
        best = ENC_ISA_AVX2;
    }
#endif
    return best < isa_limit ? best : isa_limit;
}

void enc_isa_limit(enc_isa limit) {
    isa_limit = limit;
}
