/* The table of classes. See classes.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "classes.h"

/* The errors are those that rounding u and w leaves with steps of least error, measured on factors of several
 * materials; the best allocation hardly changes within a factor of two of them. */
const enc_factor_class enc_factor_classes[ENC_FACTOR_CLASSES] = {
    {8, 8, 4, 1, 0, 127, 127, 6e-5 + 6e-5},
    {4, 8, 8, 2, 1, 15, 255, 0.0135 + 6e-5},
    {4, 4, 8, 1, 1, 15, 15, 0.0135 + 0.016},
    {2, 4, 16, 2, 2, 3, 15, 0.13 + 0.016},
    {2, 2, 16, 1, 2, 3, 3, 0.13 + 0.13},
};
