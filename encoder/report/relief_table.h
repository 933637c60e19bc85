/* Relief and gloss as tables: the candidates, the choice, and the reason for it.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_REPORT_RELIEF_TABLE_H
#define OPENBTF_ENCODER_REPORT_RELIEF_TABLE_H

#include "decoder/toolkit/json.h"
#include "encoder/relief/relief.h"

#include <stdio.h>

enum { ENC_RELIEF_TEXT = 96 };

/* "relief-chosen=none gloss-chosen=0": for provenance and logs. Of a surface its kind, its scale and its
 * least and greatest height in texels. */
const char *enc_relief_text(const enc_relief_choice *choice, char text[ENC_RELIEF_TEXT]);

void enc_relief_print(const enc_relief_choice *choice, FILE *out);
/* A member `key`: null without a choice. */
void enc_relief_json(json *j, const char *key, const enc_relief_choice *choice);

#endif
