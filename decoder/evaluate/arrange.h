/* The residual in the order in which evaluation reads it: all codes of a texel side by side, and all of a
 * pair of view and light.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EVALUATE_ARRANGE_H
#define OPENBTF_EVALUATE_ARRANGE_H

#include "prepared.h"

#pragma GCC visibility push(hidden)

/* Fills in the members of the evaluator and its levels that describe the residual. Errors:
 * BTF_ERROR_MEMORY; what was made before stays. */
btf_result btfi_arrange_residual(const btf_material *material, btf_evaluator *evaluator);

#pragma GCC visibility pop

#endif
