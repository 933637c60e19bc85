/* Images of a material at any directions: FORMAT.md section 9 to the bit.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_DECODE_H
#define OPENBTF_ENCODER_DECODE_H

#include "encoder/model/evaluator.h"
#include "pairs.h"

/* Decodes the evaluator's level of a material at `count` pairs, at the centres of its texels by
 * options.filter: out[pair][texel][3]. Errors: BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_decode_pairs(const enc_context *context, const enc_evaluator *evaluator,
                            const btf_ref_options *options, const enc_pair *pairs, size_t count,
                            float *out);

#endif
