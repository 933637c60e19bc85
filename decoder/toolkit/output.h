/* Writing a file so that it is either whole or absent: to a temporary name beside it, then a rename.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_OUTPUT_H
#define OPENBTF_TOOLS_OUTPUT_H

#include <openbtf/result.h>
#include <stdbool.h>
#include <stdio.h>

/* A file being written. Used by one thread at a time; several may be open at once. */
typedef struct output output;

/* For a library within somebody else's program: from here on output_open installs no handlers of signals or of
 * exit, so that a temporary file stays behind where a signal ends the program. */
void output_leave_signals(void);

/* Creates `.NAME.PID-N.tmp` beside `path`, first removing such files that a dead process left there. A
 * symbolic link is followed; a target that exists and is no regular file (a pipe, /dev/null) is written
 * directly. Temporary files still open when the process exits, or dies of SIGINT, SIGTERM or SIGHUP, are
 * removed. From the first call on, SIGBUS (a mapped input that became shorter) ends the process as
 * BTF_ERROR_IO does. Errors: BTF_ERROR_IO (named on log), BTF_ERROR_MEMORY. */
btf_result output_open(const char *path, btf_log log, output **out_output);

/* The stream to write to, owned by the output; or the path, for writers that open files themselves. */
FILE *output_stream(output *file);
const char *output_temporary_path(const output *file);

/* Flushes, closes and renames; nulls *file. On failure the temporary file is removed and the target
 * untouched. Errors: BTF_ERROR_IO (named on log). */
btf_result output_commit(output **file);

/* Closes and removes the temporary file; nulls *file. Does nothing where *file is NULL. */
void output_abort(output **file);

/* Whether writing to `path` would replace `other`, or the other way round: both name one regular file, or
 * one that is not there yet. */
bool output_is_same(const char *path, const char *other);

/* Makes a folder, unless it is there; *out_made (may be NULL) says whether it was made. Errors:
 * BTF_ERROR_IO (named on log). */
btf_result output_make_folder(const char *path, btf_log log, bool *out_made);

/* Removes the temporary files of every open output. Async-signal-safe: meant for signal handlers that end
 * the process. */
void output_remove_all(void);

#endif
