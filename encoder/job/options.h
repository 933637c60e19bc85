/* The command line of btf-encode.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_OPTIONS_H
#define OPENBTF_ENCODER_OPTIONS_H

#include "decoder/toolkit/cli.h"
#include "settings.h"

typedef struct enc_options {
    enc_job job;
    const char *predict; /* print the time and memory of the job, scaled by this report or "self"; NULL: encode */
    int item;            /* only this input of a list, from 1; 0: all */
    int threads;
    uint64_t memory; /* bytes that a process may take */
} enc_options;

extern const cli_program enc_program;

/* Reads options and input; `threads` and `memory` are the defaults. False: the process ends with
 * *out_exit_code, as after --help, or after an error, which was printed. *out_options belongs to the
 * process: one command line is read. */
bool enc_options_parse(int argc, char **argv, int threads, uint64_t memory, const enc_options **out_options,
                       int *out_exit_code);

#endif
