/* Relief and gloss as tables: the candidates, the choice, and the reason for it.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_REPORT_RELIEF_TABLE_H
#define OPENBTF_ENCODER_REPORT_RELIEF_TABLE_H

#include "decoder/toolkit/json.h"
#include "encoder/relief/relief.h"

#include <stdio.h>

enum { ENC_RELIEF_TEXT = 120 };

/* The choice as text for provenance and logs, such as "relief-chosen=none gloss-chosen=0". Of a surface it
 * gives the kind, the scale, and the least and greatest height in texels; with several levels of detail
 * also the first without relief. */
const char *enc_relief_text(const enc_relief_choice *choice, char text[ENC_RELIEF_TEXT]);

void enc_relief_print(const enc_relief_choice *choice, FILE *out);
/* Writes the member `key`: null without a choice. */
void enc_relief_json(json *j, const char *key, const enc_relief_choice *choice);

#endif
