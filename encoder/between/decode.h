/* Images of a material at any directions, by the reference decoder.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_DECODE_H
#define OPENBTF_ENCODER_DECODE_H

#include <openbtf/reference.h>
#include "pairs.h"

/* Level 0 of a material at `count` pairs: out[pair][texel][3], exact (FORMAT.md, 9). Errors:
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_decode_pairs(const enc_context *context, const btf_ref_material *material,
                            const btf_ref_options *options, const enc_pair *pairs, size_t count,
                            float *out);

#endif
