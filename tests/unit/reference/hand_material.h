/* A material whose numbers a test of the reference decoder sets by hand, and evaluations of one view and light.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TEST_HAND_MATERIAL_H
#define OPENBTF_TEST_HAND_MATERIAL_H

#include "tests/support/reference_material.h"

/* 7 x 5 texels, 9 views, 5 lights; all numbers zero but scales of 1. */
typedef struct hand_fixture {
    made_storage s;
    btf_ref_material m;
    btf_ref_options o;
} hand_fixture;

/* Returns the one material that all tests of a program share; each call resets it. */
hand_fixture *hand_material(int layout_tight, uint32_t effects);

/* The four numbers of a layer of the SBRDF at a texel. */
float *hand_parameter(hand_fixture *f, uint32_t layer, uint32_t column, uint32_t row);
void hand_set_shadow(hand_fixture *f, uint32_t column, uint32_t row, uint32_t light, uint8_t code);
/* The gain's code and the two bytes of the shift, or of a centre's index. */
void hand_set_view(hand_fixture *f, uint32_t column, uint32_t row, uint32_t view, uint8_t gain, int b0, int b1);
void hand_set_centre(hand_fixture *f, uint32_t centre, uint32_t light, uint8_t r, uint8_t g, uint8_t b);

/* The albedo of texel (column, row): 1 / (1 + column + 8 row), which differs between all texels. */
float hand_albedo(uint32_t column, uint32_t row);
/* Makes all texels Lambertian, with an albedo of hand_albedo times 1, 1/2 and 1/4 in R, G and B. */
void hand_set_lambertian(hand_fixture *f);

/* A direction that projects exactly to vertex 0 of views and lights. */
extern const float hand_pole[3];

/* Evaluates texel (column, row) with all the weight on view `view_index` and light `light_index`. */
void hand_evaluate(const hand_fixture *f, uint32_t column, uint32_t row, uint32_t light_index,
                   uint32_t view_index, const float light[3], const float view[3], float out_rgb[3]);

#endif
