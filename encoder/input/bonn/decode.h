/* Samples of Bonn's binary .btf files, made texel by texel.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_BONN_DECODE_H
#define OPENBTF_ENCODER_BONN_DECODE_H

#include "file.h"

/* The directions' side of a file's matrices in memory, in the order of the output's directions. Immutable once
 * made: shared by threads. */
typedef struct enc_bonn_decoder enc_bonn_decoder;

/* view_order[n_views], light_order[n_lights]: the file's number of each view and light of the output.
 * light_factor[n_lights] (of the output's lights) multiplies every sample; components: at most so many of
 * each factorisation, 0 for all. Bzipped BDI is expanded in memory here. The file must outlive the decoder.
 * Errors, on the log: BTF_ERROR_BAD_FILE (a number that is not finite, damaged chunks), BTF_ERROR_MEMORY. */
btf_result enc_bonn_decoder_create(const enc_context *context, const enc_bonn_file *file,
                                   const int *view_order, const int *light_order, const float *light_factor,
                                   uint32_t components, enc_bonn_decoder **out_decoder);
/* The number of components in use of the factorisation that has most; 0: the file has no factorisation. */
uint32_t enc_bonn_decoder_components(const enc_bonn_decoder *decoder);

void enc_bonn_decoder_destroy(enc_bonn_decoder **decoder);

/* Linear Rec. 709 samples of `count` texels (numbers y * width + x, in any order):
 * out[i][view][channel][light], `pitch` floats from texel to texel. first_view, n_views: these views alone,
 * the first of them at out[i][0]. Negative samples are kept. Missing ABRDFs of a sparse BDI are 0. The same
 * bits for any blocking. Errors: BTF_ERROR_BAD_FILE (a sample that is not finite: named), BTF_ERROR_MEMORY. */
btf_result enc_bonn_decode(const enc_context *context, const enc_bonn_decoder *decoder, size_t count,
                           const size_t *texels, int first_view, int n_views, size_t pitch, float *out);

#endif
