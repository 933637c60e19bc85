/* OpenBTF: the error tables of an encoder's measurements (attributes openbtf.effectErrors,
 * openbtf.effectDifferences, openbtf.betweenErrors, openbtf.levelBetweenErrors).
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
/* How many numbers of a checked table stand in front of its rows. */
size_t btfi_table_head(const float *values);
/* The table that the numbers hold, which btfi_check_effect_errors has checked; one without rows where they are NULL. */
btf_effect_errors btfi_effect_errors_of(const float *values, size_t count);

/* Likewise checks the numbers of the attribute openbtf.effectDifferences, which are laid out as those of
 * effectErrors. */
btf_result btfi_check_effect_differences(const btfi_check *check, const btf_material_info *info,
                                         const float *values, size_t count);

/* Where a table of errors between the samples stands: a material in memory keeps rows of all levels in one; a file
 * keeps those of level 0 in openbtf.betweenErrors, and those of coarser levels in openbtf.levelBetweenErrors, which
 * readers from before it pass over. */
typedef enum btfi_between_table {
    BTFI_BETWEEN_IN_MEMORY,
    BTFI_BETWEEN_OF_LEVEL_0,
    BTFI_BETWEEN_OF_COARSER_LEVELS
} btfi_between_table;

/* Likewise checks the numbers of such a table, whose rows must be of levels that it may hold. */
btf_result btfi_check_between_errors(const btfi_check *check, const btf_material_info *info,
                                     btfi_between_table where, const float *values, size_t count);
btf_between_errors btfi_between_errors_of(const float *values, size_t count);

#pragma GCC visibility pop

#endif
