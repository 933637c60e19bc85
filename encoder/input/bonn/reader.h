/* Reading one of Bonn's binary .btf files into a BTF.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_BONN_READER_H
#define OPENBTF_ENCODER_BONN_READER_H

#include "encoder/data/data.h"
#include "encoder/input/read_options.h"

/* Predicted core seconds to make a sample from a factorisation of so many components, on one core of an
 * AMD EPYC (Zen 4). */
static inline double enc_bonn_sample_seconds(size_t components) {
    return 2.2e-9 + 0.13e-9 * (double)components;
}

/* Does the work of enc_read() for a file of Bonn's (enc_bonn_is). The matrices stay in the mapped file;
 * samples are made when asked for, or once, where all of them fit half of context->memory. The directions'
 * side takes memory besides: n_views * n_lights numbers for each component and channel. Errors as
 * enc_read(). */
btf_result enc_read_bonn(const enc_context *context, const char *input, const enc_read_options *options,
                         enc_data **out_data);

#endif
