/* Data of known lobes for the tests of the fit.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_FIT_DATA_H
#define OPENBTF_TESTS_FIT_DATA_H

#include "encoder/data/data.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { DIRECTIONS = 81, PAIRS = DIRECTIONS * DIRECTIONS };

/* xorshift, 0 <= x < 1; the same numbers everywhere for the same state. */
extern uint32_t fit_random_state;
float fit_random(void);

/* The first rings of the paper's directions: 1, 6, 12, 18, 20, 24. */
void fit_directions(enc_direction out[DIRECTIONS]);

/* The model in double precision with libm's pow, independent of the vector code. Layout of sbrdf.h. */
double fit_model_value(const float *parameters, int lobes, bool rgb, const double product[3], int channel);

/* Fails unless a file may hold the parameters: 0 or 2^-24 to 2^24. */
void fit_assert_storable(const float *parameters, size_t count);

#endif
