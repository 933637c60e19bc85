/* Text files as people's programs write them: with a byte-order mark or without, with lines that end in LF,
 * CR LF or CR.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_TEXT_H
#define OPENBTF_TOOLS_TEXT_H

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>

/* Looks at the beginning of a text. Returns NULL for one that can be read byte by byte, UTF-8 among them,
 * and sets *out_skip to the length of its byte-order mark, 0 or 3. Returns the name of the encoding
 * ("UTF-16") of one that cannot; UTF-16 without a mark is known by the zero bytes among its first. */
const char *text_encoding(const char *data, size_t size, size_t *out_skip);

typedef struct text_file {
    char *data; /* malloc'ed; the lines lie in it */
    size_t size, at;
    size_t number; /* of the line last handed out, from 1 */
} text_file;

/* Reads a whole file of at most `most` bytes. Errors, on the log with the path: BTF_ERROR_IO,
 * BTF_ERROR_UNSUPPORTED (an encoding other than UTF-8; larger), BTF_ERROR_BAD_FILE (zero bytes),
 * BTF_ERROR_MEMORY. */
btf_result text_read(const char *path, size_t most, const btf_log *log, text_file *out_text);

/* The next line without its end, NUL-terminated and writable; NULL behind the last. */
char *text_line(text_file *text);
void text_free(text_file *text);

#endif
