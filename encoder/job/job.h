/* One encode from end to end: read, analyse, pack, measure, save, report, picture.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOB_H
#define OPENBTF_ENCODER_JOB_H

#include "settings.h"

/* Runs the job. First it checks that the outputs can be made; it saves the material after the pictures, and
 * writes the report last. Errors: those of the stages, with a message on the log, except for
 * BTF_ERROR_INTERRUPTED. On error or interruption there is no new material, unless only the report could
 * not be written; pictures may be there. */
btf_result enc_job_run(const enc_context *context, const enc_job *job);

#endif
