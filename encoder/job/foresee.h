/* The error that factors of a budget will have, before they are found.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FORESEE_H
#define OPENBTF_ENCODER_FORESEE_H

#include "encoder/factor/method.h"
#include "encoder/nodes/choose.h"

enum { ENC_FORESEE_TEXELS = 1024, ENC_FORESEE_RANK = 256 }; /* texels drawn, components found: at most */

/* Squared error, linear and sRGB-coded, that the encode of `data` by these settings is expected to leave at
 * the samples: within 1.5 dB, sRGB-coded, on the materials of nodes/FIT.md. Leading components of evenly
 * drawn texels are found; energies of the others are taken to fall by a power, of which their sum is known;
 * allocation plans the bytes. Bytes that a tolerance leaves unspent and the gain of match are not foreseen.
 * Every rank gets the same number, the same bits for any number of threads. Stage "foresee error", of a
 * fixed number of texels. Errors: those of enc_components_find. */
btf_result enc_foresee_error(const enc_context *context, const enc_data *data,
                             const enc_factors_settings *settings, enc_fit_error *out_error);

#endif
