/* Decoding a solution at its own sampled directions: FORMAT.md section 9 where every weight is 4096, a
 * light profile at a time. Encodes are measured and pictured with it. Results agree with the reference
 * decoder up to float rounding (tested), and are not normative.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_DECODE_SAMPLES_H
#define OPENBTF_ENCODER_MODEL_DECODE_SAMPLES_H

#include "encoder/data/images.h"
#include "solution.h"

typedef struct enc_sample_decoder enc_sample_decoder;

/* Keeps pointers to `data` (directions only) and `solution`. */
btf_result enc_sample_decoder_create(const enc_context *context, const enc_data *data,
                                     const enc_solution *solution, enc_sample_decoder **out_decoder);
void enc_sample_decoder_destroy(enc_sample_decoder **decoder);

/* Decodes with the effects that both `effects` and the solution have. */
typedef struct enc_decoded_samples {
    const enc_sample_decoder *decoder;
    uint32_t effects;
} enc_decoded_samples;

/* An image source of the decoded BTF; `decoded` must outlive it. */
enc_image_source enc_decoded_images(const enc_decoded_samples *decoded);

#endif
