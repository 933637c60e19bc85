/* The errors of every variant of decoding a material, by bands of view and light elevation: all subsets
 * of its effects, some numbers of residual components, nearest and interpolated directions (FORMAT.md
 * section 7, openbtf.effectErrors).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_EFFECT_ERRORS_H
#define OPENBTF_ENCODER_EFFECT_ERRORS_H

#include "encoder/data/data.h"
#include <openbtf/material.h>

/* Decodes the packed material by the reference at directions spread over each pair of bands and compares
 * with the data, interpolated in radiance between the same three views and three lights. At most 2048
 * samples a pair of bands, of at most 512 texels; in all at most 3,000,000 evaluations or half as many as
 * the data have samples (but 200,000 and 16 a variant and pair of bands); in coarser levels half as many.
 * The variants that decode everything are measured at up to 300,000 more a level, and the errors of all
 * others are changed as theirs are. Which samples depends on sizes alone. *out_values (the caller frees)
 * holds *out_count numbers as btf_material_desc.effect_errors takes them. Stage "effect errors". Errors:
 * BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED. */
btf_result enc_effect_errors(const enc_context *context, const enc_data *data, const btf_material *material,
                             float **out_values, size_t *out_count);

#endif
