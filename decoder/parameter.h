/* OpenBTF: the magnitudes that a parameter may have (FORMAT.md section 2).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_PARAMETER_H
#define OPENBTF_PARAMETER_H

#include <stdbool.h>

#pragma GCC visibility push(hidden)

/* The smallest and largest magnitude of a parameter that is not 0 (FORMAT.md section 2). */
#define BTFI_PARAMETER_MIN 0x1p-24f
#define BTFI_PARAMETER_MAX 0x1p24f

/* True when x is 0 or of a magnitude that FORMAT.md section 2 allows. */
static inline bool btfi_is_parameter(float x) {
    float magnitude = x < 0 ? -x : x;
    return x == 0 || (magnitude >= BTFI_PARAMETER_MIN && magnitude <= BTFI_PARAMETER_MAX);
}

#pragma GCC visibility pop

#endif
