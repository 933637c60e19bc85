/* Many encodes, one after the other: a text file that lists inputs.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_BATCH_H
#define OPENBTF_ENCODER_BATCH_H

#include "settings.h"
#include <stdio.h>

/* A list is a file NAME.txt or NAME.list with an input on each line, relative to the list's folder; blank
 * lines and lines that begin with # are skipped. The materials are named after the inputs: "maps/WOOL.zip"
 * becomes WOOL.btf.exr. */
typedef struct enc_batch {
    size_t count;
    char **inputs; /* as paths from here */
    char **names;  /* distinct, without folder and extension */
} enc_batch;

/* Whether a path has to be read as a list. */
bool enc_batch_is(const char *path);

/* Errors, naming file and line: BTF_ERROR_IO, BTF_ERROR_BAD_FILE (no input; two of one name; an input that
 * gives no name, such as ".."; not a text), BTF_ERROR_UNSUPPORTED (UTF-16 and the like),
 * BTF_ERROR_MEMORY. */
btf_result enc_batch_read(const enc_context *context, const char *path, enc_batch *out_batch);
void enc_batch_clear(enc_batch *batch);

/* Runs the job for input number `item` (from 1), or for all of them (0). job->output is a folder, made when
 * missing, and so are report and pictures, where given: DIR/NAME.btf.exr, REPORT/NAME.json, PICTURES/NAME,
 * CHECKPOINT/NAME. An input that fails does not stop the rest; only an interruption does. At the end a line
 * for each input goes to `summary` (may be NULL). Returns the result of the first that failed. Errors
 * beside: BTF_ERROR_USAGE (item), BTF_ERROR_IO (folders). */
btf_result enc_batch_run(const enc_context *context, const enc_job *job, const enc_batch *batch,
                         size_t item, FILE *summary);

#endif
