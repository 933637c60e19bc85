/* Predicts the time and memory of an encode, without encoding.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PREDICT_H
#define OPENBTF_ENCODER_PREDICT_H

#include "settings.h"

#include <stdio.h>

/* Prints core time by stage, time on context->threads cores, least and expected memory and bytes of scratch
 * files for job->input. `from` gives the scale of the times: "self" measures this machine for about a
 * second; else it is the report (--report) of an encode with the same options, for example of a smaller
 * part of the data, and each stage is scaled by the ratio of its measured to its predicted time. Errors:
 * those of opening the input; of the report, naming file and member: BTF_ERROR_IO, BTF_ERROR_BAD_FILE (not
 * a report), BTF_ERROR_USAGE (of another method). */
btf_result enc_predict(const enc_context *context, const enc_job *job, const char *from, FILE *out);

#endif
