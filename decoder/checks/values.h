/* OpenBTF: checks of every value that a material holds (FORMAT.md sections 2 to 5).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VALUES_H
#define OPENBTF_VALUES_H

#include "decoder/result.h"
#include <openbtf/material.h>

#pragma GCC visibility push(hidden)

/* Checks every value of every texture of every level against FORMAT.md sections 2 to 5, and turns -0 into
 * +0. */
btf_result btfi_check_values(const btfi_check *check, const btf_material_info *info,
                             void *texture[BTF_MAX_LEVELS][BTF_TEXTURE_COUNT]);
/* `known`: effects of the file's version. */
btf_result btfi_check_errors(const btfi_check *check, uint32_t known, const btf_material_error *errors,
                             size_t count);
btf_result btfi_check_level_errors(const btfi_check *check, uint32_t levels, const btf_level_error *errors,
                                   size_t count);

#pragma GCC visibility pop

#endif
