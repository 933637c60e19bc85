/* OpenBTF: checks of what a header says (FORMAT.md sections 2 to 5, 7).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CHECKS_INFO_H
#define OPENBTF_CHECKS_INFO_H

#include "decoder/result.h"
#include <openbtf/material.h>

#pragma GCC visibility push(hidden)

/* Checks everything that info says by itself, the strings aside. */
btf_result btfi_check_info(const btfi_check *check, const btf_material_info *info);

#pragma GCC visibility pop

#endif
