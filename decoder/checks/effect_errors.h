/* OpenBTF: the error tables of an encoder's measurements (attributes openbtf.effectErrors,
 * openbtf.effectDifferences, openbtf.betweenErrors).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EFFECT_ERRORS_H
#define OPENBTF_EFFECT_ERRORS_H

#include "decoder/result.h"
#include <openbtf/material.h>

#pragma GCC visibility push(hidden)

enum { BTFI_MOST_EFFECT_ROWS = 4096 };

/* Checks the numbers of the attribute openbtf.effectErrors against a (checked) info. */
btf_result btfi_check_effect_errors(const btfi_check *check, const btf_material_info *info,
                                    const float *values, size_t count);
/* The table in numbers that btfi_check_effect_errors checked; one without rows for NULL. */
btf_effect_errors btfi_effect_errors_of(const float *values, size_t count);

/* Checks the numbers of the attribute openbtf.effectDifferences, which are laid out as those of effectErrors, likewise. */
btf_result btfi_check_effect_differences(const btfi_check *check, const btf_material_info *info,
                                         const float *values, size_t count);

/* Checks the numbers of the attribute openbtf.betweenErrors likewise. */
btf_result btfi_check_between_errors(const btfi_check *check, const btf_material_info *info,
                                     const float *values, size_t count);
btf_between_errors btfi_between_errors_of(const float *values, size_t count);

#pragma GCC visibility pop

#endif
