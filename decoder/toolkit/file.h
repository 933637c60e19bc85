/* Reading a whole file, and messages with values.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLKIT_FILE_H
#define OPENBTF_TOOLKIT_FILE_H

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>

/* Sends an error message to log (may be NULL). */
void file_say(const btf_log *log, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Sends a warning: the call goes on. */
void file_warn(const btf_log *log, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The last message of a log that file_log_keep() made, cut where it is longer; "" where there was none. */
typedef struct file_kept {
    char text[400];
} file_kept;

/* A log that keeps messages instead of showing them; *kept must outlive it. */
btf_log file_log_keep(file_kept *kept);

/* Whether a path is a regular file that begins as OpenEXR files do, whatever its ending. */
bool file_is_exr(const char *path);

/* Whether a name ends in `ending` (".png"), in any case, behind at least one character. */
bool file_ends_in(const char *path, const char *ending);

/* Reads a whole file: *out_data[*out_size] is malloc'ed, and a zero byte follows. Errors, named on log:
 * BTF_ERROR_IO, BTF_ERROR_UNSUPPORTED (above `most` bytes), BTF_ERROR_MEMORY. */
btf_result file_read(const char *path, size_t most, const btf_log *log, char **out_data, size_t *out_size);

#endif
