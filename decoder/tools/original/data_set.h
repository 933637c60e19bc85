/* The encoder's reader of data sets as the renderer takes it: decoder/tools/render and decoder/tools/view
 * know nothing of the encoder, their programs hand them this.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ORIGINAL_DATA_SET_H
#define OPENBTF_ORIGINAL_DATA_SET_H

#include "decoder/tools/render/original.h"

/* An original_reader of all that btf-encode reads with default options. Errors: those of enc_read
 * (encoder/input/reader.h). */
btf_result data_set_read(const char *input, int threads, void *p, const btf_log *log,
                         original_data *out_data);

#endif
