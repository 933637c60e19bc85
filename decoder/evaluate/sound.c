/* Rounding, probed. See sound.h.
 *
 * Operands come from volatile memory, so that arithmetic at run time is probed; each value expected differs
 * from that of the form that a compiler, or another mode of rounding, would make of it.
 *
 * SPDX-License-Identifier: MIT
 */
#include "sound.h"

#include <float.h>

bool btfi_build_is_sound(void) {
#if defined __FAST_MATH__ || FLT_RADIX != 2 || FLT_MANT_DIG != 24 ||                                       \
    (defined FLT_EVAL_METHOD && FLT_EVAL_METHOD > 0)
    return false;
#else
    volatile float grown = 0x1.001p0f; /* its square is 1 + 2^-11 + 2^-24, a tie */
    volatile float operands[4] = {1.0f, 0x1.000002p0f, 0x1p-24f, 3.0f};
    const float one = operands[0], next = operands[1], half = operands[2], three = operands[3];
    const volatile float nearest[4] = {one + half, one + three * half, next + half, -one - half};
    const volatile float contracted[2] = {grown * grown - one, half + grown * grown};
    const volatile float regrouped[3] = {(one + half) - one, (next * next) * three, next * (next * three)};
    return nearest[0] == 1.0f && nearest[1] == 0x1.000004p0f && nearest[2] == 0x1.000004p0f &&
           nearest[3] == -1.0f && contracted[0] == 0x1p-11f && contracted[1] == 0x1.002p0f &&
           regrouped[0] == 0.0f && regrouped[1] == 0x1.800006p1f && regrouped[2] == 0x1.800008p1f;
#endif
}
