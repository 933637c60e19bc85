/* The error that factors of a budget will have, before they are found.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FORESEE_H
#define OPENBTF_ENCODER_FORESEE_H

#include "encoder/factor/method.h"
#include "encoder/nodes/choose.h"

enum { ENC_FORESEE_TEXELS = 1024, ENC_FORESEE_RANK = 256 }; /* at most: texels drawn, components found */

/* Predicts the squared error, linear and sRGB-coded, that the encode of `data` by these settings leaves at
 * the samples. On the materials of nodes/FIT.md it is within 1.5 dB, sRGB-coded. Leading components of
 * evenly drawn texels are found; energies of the others are taken to fall by a power, of which their sum is
 * known; allocation plans the bytes. It foresees neither bytes that a tolerance leaves unspent nor the gain
 * of match. Every rank gets the same number, the same bits for any number of threads. Stage "foresee
 * error", of a fixed number of texels. Errors: those of enc_components_find. */
btf_result enc_foresee_error(const enc_context *context, const enc_data *data,
                             const enc_factors_settings *settings, enc_fit_error *out_error);

#endif
