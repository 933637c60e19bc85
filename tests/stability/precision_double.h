/* Stages of the encoder in double precision: the same sources with every float a double (in_double.h).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_STABILITY_PRECISION_DOUBLE_H
#define OPENBTF_TESTS_STABILITY_PRECISION_DOUBLE_H

#include "encoder/data/data.h"
#include "encoder/model/occlusion.h"

/* enc_fit with its default starts, rounds, tolerance and evaluations, on one thread:
 * out[texel][enc_sbrdf_stride]. The sums over samples are plain loops with libm's pow. Returns false on
 * failure. */
bool precision_fit_in_double(const enc_data *data, int lobes, bool rgb, bool square_root, double *out);

/* enc_flow_vote with its defaults, on one thread, or without a first estimate; OpenCV's DIS, of which there
 * is no double version, in between. NULL on failure. */
enc_occlusion *precision_flow_in_double(const enc_data *data, bool plain);

#endif
