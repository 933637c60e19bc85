/* Unpacking: from the textures of a material back to a solution. The inverse of pack.h, so that what is
 * measured is what the file holds.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_UNPACK_H
#define OPENBTF_ENCODER_MODEL_UNPACK_H

#include "solution.h"

/* Fills a zeroed solution; half-float parameters come back as floats. Errors: BTF_ERROR_MEMORY. */
btf_result enc_unpack(const enc_context *context, const btf_material *material, enc_solution *out_solution);

/* Unpacks a further level of detail, whose shared arrays point into `base`, which enc_unpack filled.
 * enc_level_clear frees it. */
btf_result enc_unpack_level(const enc_context *context, const btf_material *material, uint32_t level,
                            const enc_solution *base, enc_solution *out_solution);

/* Unpacks all further levels of a material whose level 0 was unpacked to `base`. Errors:
 * BTF_ERROR_MEMORY. */
btf_result enc_levels_unpack(const enc_context *context, const btf_material *material,
                             const enc_solution *base, enc_levels *out_levels);

#endif
