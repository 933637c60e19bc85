/* OpenBTF: the parts of a material that a plan keeps.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RESTRICT_H
#define OPENBTF_RESTRICT_H

#include <openbtf/material.h>

#pragma GCC visibility push(hidden)

/* The info of a restriction to so many views and lights; centres are those of the whole. */
btf_material_info btfi_restricted_info(const btf_material_info *info, uint32_t effects, uint32_t components,
                                       uint32_t level, uint32_t views, uint32_t lights);

#pragma GCC visibility pop

#endif
