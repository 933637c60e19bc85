/* Gain and cost of the fit of node values, for people and as JSON.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_REPORT_FIT_TABLE_H
#define OPENBTF_ENCODER_REPORT_FIT_TABLE_H

#include "decoder/toolkit/json.h"
#include "encoder/nodes/choose.h"

#include <stdio.h>

enum { ENC_FIT_TEXT = 48 };

/* The kappas of views and lights that were chosen, as "1,0.3"; else "none". */
const char *enc_fit_text(const enc_fit_choice *choice, char text[ENC_FIT_TEXT]);

/* Prints a table for people: every candidate at the samples and between them. measured: the squared error
 * at the samples of the material that was encoded. Prints nothing where no candidate could be judged. */
void enc_fit_print(const enc_fit_choice *choice, enc_fit_error measured, FILE *out);

/* {"chosen", "best": index, taken and worth most; "coder_linear", "coder_srgb": dB at the samples that were foreseen of
 * the coder; "candidates": [{"kappa_views", "kappa_lights" (null: barycentric), "at_linear", "at_srgb": dB, of the
 * fit alone; "left_out_linear", "left_out_srgb": dB; "gain_linear", "gain_srgb": mean squares; "coded_at_linear",
 * "coded_at_srgb", "coded_between_linear", "coded_between_srgb": dB, expected, but measured at the samples of the one
 * that was taken; "allowed", "value" (expect.h)}...]} under `key`; null without a choice (NULL). */
void enc_fit_json(json *j, const char *key, const enc_fit_choice *choice, enc_fit_error measured);

#endif
