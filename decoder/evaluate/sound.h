/* Whether floats are rounded as FORMAT.md section 8 says.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EVALUATE_SOUND_H
#define OPENBTF_EVALUATE_SOUND_H

#include <stdbool.h>

#pragma GCC visibility push(hidden)

/* Whether this build of the library rounds once an operation in this thread, to nearest even, in the
 * written order. */
bool btfi_build_is_sound(void);

#pragma GCC visibility pop

#endif
