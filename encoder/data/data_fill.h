/* How the reader fills a BTF: piece by piece, in whatever order the images come.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_DATA_FILL_H
#define OPENBTF_ENCODER_DATA_FILL_H

#include "data.h"

/* Stores `count` floats of one texel, from position `at` of its [view][channel][light] samples on.
 * Concurrent calls must not overlap. Errors: BTF_ERROR_IO. */
btf_result enc_data_store_run(const enc_context *context, enc_data *data, size_t texel, size_t at,
                              size_t count, const float *samples);

#endif
