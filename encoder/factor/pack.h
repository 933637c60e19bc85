/* Codes in the layout of format 2 (FORMAT.md).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_PACK_H
#define OPENBTF_ENCODER_FACTOR_PACK_H

#include "codes.h"

/* texels [u texel][texel][4] and directions [unit][column][4], zeroed by the caller; scales [unit][4] of
 * the values in red, green and blue, by the axis of the word's channel. */
void enc_factor_pack(const enc_context *context, const enc_factor_codes *codes, uint32_t *texels,
                     uint32_t *directions, float *scales);

#endif
