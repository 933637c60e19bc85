/* Arguments at which tests evaluate a material: random ones, and those at which decoders are likely to fail.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_CASES_H
#define OPENBTF_CONFORMANCE_CASES_H

#include "random.h"
#include <openbtf/plan.h>

/* u, v, light xyz, view xyz, as bits, as gpu_run takes them. */
enum { CASE_WORDS = 8 };

/* One case in eight has an extreme coordinate, one in four an extreme direction: the pole, 89.9 degrees,
 * exactly a sampled direction, on an edge of the triangulation, at and below the horizon, not of unit
 * length, not a number. */
void case_make(random_state *r, const btf_material *material, uint32_t out[CASE_WORDS]);

/* A texture coordinate, and a direction, of the same kinds. */
float case_coordinate(random_state *r, uint32_t size);
void case_direction(random_state *r, const btf_directions *list, float out[3]);

/* A direction of a range: its borders, samples of the list, anything between. */
void case_in_range(random_state *r, const btf_range *range, const btf_directions *list, float out[3]);

#endif
