/* Chooses how strongly a material's node values are fitted: the candidate of the greatest value (expect.h).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NODES_CHOOSE_H
#define OPENBTF_ENCODER_NODES_CHOOSE_H

#include "apply.h"
#include "expect.h"

enum { ENC_FIT_TEXELS = 256 }; /* drawn at most */

/* Judges every candidate for `data`. least_psnr: dB of sRGB-coded PSNR that a fit must leave at the
 * samples, or 0. coder: the error that the factors are expected to add, at the samples; NULL: not
 * known, and taken to be that of the blend between them. With a fit chosen *out_tables holds it, else its
 * tables are NULL; enc_node_tables_clear frees them. Every rank does all of it, a fixed number of texels;
 * the same bits for any number of threads. Stage "choose fit". Errors: those of the data, BTF_ERROR_MEMORY,
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_fit_choose(const enc_context *context, const enc_data *data, bool roots, double least_psnr,
                          const enc_fit_error *coder, enc_fit_choice *out_choice,
                          enc_node_tables *out_tables);
void enc_node_tables_clear(enc_node_tables *tables);

#endif
