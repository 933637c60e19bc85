/* OpenBTF: random numbers of a counter, as the shader has them: PCG3D (source in openbtf/shader.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/shader.h>

static void mix(uint32_t r[3]) {
    r[0] += r[1] * r[2];
    r[1] += r[2] * r[0];
    r[2] += r[0] * r[1];
}

void btf_random(const uint32_t counter[3], uint32_t out_random[3]) {
    for (int i = 0; i < 3; ++i) {
        out_random[i] = counter[i] * 1664525u + 1013904223u;
    }
    mix(out_random);
    for (int i = 0; i < 3; ++i) {
        out_random[i] ^= out_random[i] >> 16;
    }
    mix(out_random);
}
