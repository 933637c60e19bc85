/* OpenBTF: counts of a decode by the neighbours that it goes through. See openbtf/cost.h.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_COUNTS_H
#define OPENBTF_COUNTS_H

#include <openbtf/cost.h>

#pragma GCC visibility push(hidden)

/* Neighbouring directions that a shader goes through; of the views `skipped` have weight 0, so that compilers that
 * branch pass over what is done for each view. */
typedef struct btfi_around {
    uint32_t views, skipped, lights;
} btfi_around;

/* As btf_count_decode. */
btf_decode_counts btfi_count_decode(const btf_material_info *info, const btf_shader_options *options,
                                    const btfi_around *around);

#pragma GCC visibility pop

#endif
