/* A plan's material decoded against the whole one, by the reference, for tests.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_PLAN_DECODE_H
#define OPENBTF_TESTS_PLAN_DECODE_H

#include "random_material.h"

#include <openbtf/plan.h>

/* The direction at polar angles in degrees. */
void plan_angles(double theta, double phi, float out[3]);

/* Some direction of a legal range over this list of samples: borders and samples in it come often. */
void plan_direction(random_state *r, const btf_range *range, const btf_directions *list, float out[3]);

/* Decodes `count` random places of both, in the plan's ranges and by its options: how many differ in a bit.
 * *out_lit: how many are not black. */
int plan_differences(random_state *r, const btf_material *whole, const btf_material *small,
                     const btf_plan *plan, int count, int *out_lit);

#endif
