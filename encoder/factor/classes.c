/* The table of classes. See classes.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "classes.h"

/* Of the errors, those of 8 and 4 bits are what rounding to the nearest leaves with steps of least error. 2
 * bits leave 0.13 then, but coordinate descent takes part of that back: BRICKS64 gains 0.08 dB by counting
 * less. */
const enc_factor_class enc_factor_classes[ENC_FACTOR_CLASSES] = {
    {8, 8, 4, 1, 0, 127, 127, 6e-5 + 6e-5},  {4, 8, 8, 2, 1, 15, 255, 0.0135 + 6e-5},
    {4, 4, 8, 1, 1, 15, 15, 0.0135 + 0.016}, {2, 4, 16, 2, 2, 3, 15, 0.098 + 0.016},
    {2, 2, 16, 1, 2, 3, 3, 0.098 + 0.098},
};
