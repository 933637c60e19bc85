/* Core seconds by stage, read from a report that an encode has written.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_STAGE_TIMES_H
#define OPENBTF_ENCODER_STAGE_TIMES_H

#include "decoder/toolkit/estimate.h"
#include "encoder/base/context.h"

enum { ENC_STAGE_NAME = 64, ENC_STAGE_TIMES = 2 * ESTIMATE_PARTS };

typedef struct enc_stage_times {
    struct {
        char stage[ENC_STAGE_NAME];
        double seconds; /* at least 0 */
    } of[ENC_STAGE_TIMES];
    size_t count; /* at least 1 */
} enc_stage_times;

typedef struct enc_report_times {
    char method[ENC_STAGE_NAME]; /* "joint", "paper" */
    enc_stage_times measured;    /* the member core_seconds, with "total" among the stages */
    enc_stage_times predicted;   /* the member predicted_core_seconds */
} enc_report_times;

/* Errors, naming the file, and the line that is not JSON or the member that is missing or of another type:
 * BTF_ERROR_IO, BTF_ERROR_BAD_FILE, BTF_ERROR_MEMORY. *out_times is not to be used then. */
btf_result enc_report_times_read(const enc_context *context, const char *path, enc_report_times *out_times);

/* The seconds of a stage; NaN where it is not listed. */
double enc_stage_time(const enc_stage_times *times, const char *stage);

#endif
