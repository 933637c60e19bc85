/* One encode from end to end: read, analyse, pack, measure, save, report, picture.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOB_H
#define OPENBTF_ENCODER_JOB_H

#include "encoder/joint/joint.h"
#include "encoder/paper/paper.h"
#include "encoder/input/reader.h"

typedef enum enc_method { ENC_METHOD_JOINT = 0, ENC_METHOD_PAPER = 1 } enc_method;

typedef struct enc_job enc_job;
struct enc_job {
    const char *input;
    const char *output;
    enc_read_options read;
    enc_method method;
    enc_paper_options paper;
    enc_joint_options joint;
    btf_layout layout;
    int levels; /* of detail, 1 at least; 0: down to one texel */
    bool half_float;
    const char *
        checkpoint; /* folder where stages keep what they found until the material is written; NULL: none */
    bool resume;    /* go on from it */
    const char *report;   /* JSON file; NULL: none */
    const char *pictures; /* folder, made when missing; NULL: none */
    const char *const
        *option_values; /* alternating names and values, NULL at the end: for file and report */
    bool quiet;         /* no tables on stdout */
};

/* Runs the job: that the outputs can be made is checked first, the material is saved after the pictures,
 * the report comes last. Errors: those of the stages; a message was logged, but for BTF_ERROR_INTERRUPTED.
 * On error or interruption there is no new material, unless only the report could not be written; pictures
 * may be there. */
btf_result enc_job_run(const enc_context *context, const enc_job *job);

#endif
