/* The picture of a material for programs that show OpenEXR files (FORMAT.md section 2).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_PREVIEW_H
#define OPENBTF_ENCODER_MODEL_PREVIEW_H

#include "solution.h"

/* Draws the solution from the view nearest to the pole, under the light nearest to 45 degrees (the first of
 * equals): *out_preview is for btf_material_desc.preview, and the caller frees it. Errors:
 * BTF_ERROR_MEMORY. */
btf_result enc_preview(const enc_context *context, const enc_data *data, const enc_solution *solution,
                       uint16_t **out_preview);

#endif
