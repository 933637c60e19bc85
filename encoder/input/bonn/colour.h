/* The colour models of Bonn's binary .btf files.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_BONN_COLOUR_H
#define OPENBTF_ENCODER_BONN_COLOUR_H

#include <stddef.h>
#include <stdint.h>

/* Applies the inverse of a colour model in place: three rows of `count` samples each, `pitch` floats apart. */
void enc_bonn_colour(int32_t model, const float mean[3], const float matrix[9], size_t count, size_t pitch,
                     float *samples);

#endif
