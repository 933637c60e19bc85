/* The sRGB curve from a table. See srgb.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "srgb.h"

#include <math.h>

enum { SRGB_STEPS = 1 << 14 };

/* sRGB coding sampled at (i / SRGB_STEPS)^2: the squared spacing puts the samples where the curve bends,
 * and linear interpolation stays within 3e-7 of it. */
static float srgb_table[SRGB_STEPS + 2];

static void __attribute__((constructor)) srgb_table_init(void) {
    for (int i = 0; i < SRGB_STEPS + 2; i++) {
        const double root = (double)i / SRGB_STEPS, x = root * root;
        srgb_table[i] = (float)(x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055);
    }
}

float enc_srgb_encode(float linear) {
    const float clipped = linear > 0 ? (linear < 1 ? linear : 1.0f) : 0.0f;
    const float at = sqrtf(clipped) * SRGB_STEPS;
    const int i = (int)at;
    return srgb_table[i] + (at - (float)i) * (srgb_table[i + 1] - srgb_table[i]);
}
