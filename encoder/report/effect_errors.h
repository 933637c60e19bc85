/* The errors of every variant of decoding a material, by bands of view and light elevation: all subsets
 * of its effects, some numbers of residual components, nearest and interpolated directions (FORMAT.md
 * section 7, openbtf.effectErrors), and how far they are from decoding everything (openbtf.effectDifferences).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_EFFECT_ERRORS_H
#define OPENBTF_ENCODER_EFFECT_ERRORS_H

#include "encoder/data/data.h"
#include <openbtf/material.h>

/* The tables of measured errors, as btf_material_desc takes them. */
typedef struct enc_effect_tables {
    float *errors; /* effect_errors */
    size_t error_count;
    float *differences; /* effect_differences; NULL where the material has effects that do nothing */
    size_t difference_count;
} enc_effect_tables;
void enc_effect_tables_clear(enc_effect_tables *tables);

/* The most evaluations of a level, without those of the variants that decode everything. */
#define ENC_EFFECT_EVALUATIONS(level) ((level) == 0 ? 3000000 : 1500000)

/* Decodes the packed material by the reference at directions spread over each pair of bands and compares with the
 * data, interpolated in radiance between the same three views and three lights. At most 2048 samples a pair of
 * bands, of at most 512 texels; in all at most 3,000,000 evaluations or half as many as the data have samples (but
 * 200,000 and 16 a variant and pair of bands); in each coarser level at most 1,500,000. Levels for whose rows the
 * table has no room are left out. The variants that decode everything are measured at up to 300,000 more a level, and
 * the step by which this changes their error is added to the errors of all others, of which a quarter stays at least.
 * Differences are measured at the first samples. The choice of samples depends on sizes alone. *out is cleared by
 * enc_effect_tables_clear. Stage "effect errors". Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED; *out
 * is all zeros then. */
btf_result enc_effect_errors(const enc_context *context, const enc_data *data, const btf_material *material,
                             enc_effect_tables *out);

#endif
