/* Tests of the reference decoder: comparison of floats by their bits.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TEST_REFERENCE_ASSERT_H
#define OPENBTF_TEST_REFERENCE_ASSERT_H

#include "tests/support/reference_material.h"
#include "tests/support/test.h"

static inline void assert_bits(float actual, float expected) {
    if (bits_of(actual) != bits_of(expected)) {
        fail_msg("%.9g (%08X), expected %.9g (%08X)", (double)actual, bits_of(actual), (double)expected,
                 bits_of(expected));
    }
}

static inline void assert_rgb(const float rgb[3], float r, float g, float b) {
    assert_bits(rgb[0], r);
    assert_bits(rgb[1], g);
    assert_bits(rgb[2], b);
}

#endif
