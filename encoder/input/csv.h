/* Tables in text files: comma-separated values as spreadsheets and scripts write them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_CSV_H
#define OPENBTF_ENCODER_CSV_H

#include "decoder/toolkit/text.h"
#include "encoder/base/context.h"

enum { ENC_CSV_MAX_FIELDS = 64, ENC_CSV_MAX_BYTES = 1 << 28 };

/* Fields stand between tabs, semicolons, commas or blanks: whichever of these, in this order, the first
 * line with fields has outside of quotes, or the one that a first line "sep=;" names. Blanks around a field
 * do not count. A field in double quotes may hold anything; "" in it is a quote. */
typedef struct enc_csv {
    const enc_context *context;
    const char *path;
    text_file text;
    char delimiter;  /* 0: not known yet */
    bool is_comment; /* the line begins with #; its fields are those after that */
    size_t count;
    char *fields[ENC_CSV_MAX_FIELDS]; /* of the line last read; valid until the next */
} enc_csv;

/* Errors, on the log: those of text_read. */
btf_result enc_csv_open(const enc_context *context, const char *path, enc_csv *out_csv);

/* Reads the next line that is not blank; *out_more is false where there is none. Empty fields at the end of
 * a line do not count. Errors, on the log with path and line: BTF_ERROR_BAD_FILE (a quote that is not
 * closed, or closed before the end of its field; too many fields). */
btf_result enc_csv_next(enc_csv *csv, bool *out_more);

/* Whether ',' is the decimal point of this table. */
bool enc_csv_has_decimal_commas(const enc_csv *csv);

/* BTF_ERROR_BAD_FILE with "PATH: line N: ...". */
btf_result enc_csv_fail(const enc_csv *csv, const char *format, ...) __attribute__((format(printf, 2, 3)));

void enc_csv_close(enc_csv *csv);

#endif
