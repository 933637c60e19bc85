/* Tables in text files. See csv.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "csv.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

btf_result enc_csv_open(const enc_context *context, const char *path, enc_csv *out_csv) {
    *out_csv = (enc_csv){.context = context, .path = path};
    return text_read(path, ENC_CSV_MAX_BYTES, context ? &context->log : NULL, &out_csv->text);
}

void enc_csv_close(enc_csv *csv) {
    text_free(&csv->text);
}

bool enc_csv_has_decimal_commas(const enc_csv *csv) {
    return csv->delimiter != ' '; /* where commas separate fields, a comma within a field stood in quotes */
}

btf_result enc_csv_fail(const enc_csv *csv, const char *format, ...) {
    char message[600];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return enc_fail(csv->context, BTF_ERROR_BAD_FILE, "%s: line %zu: %s", csv->path, csv->text.number,
                    message);
}

static bool is_blank(char c) {
    return c == ' ' || c == '\t';
}

/* The separator between the fields of a line, outside of quotes. */
static char find_delimiter(const char *line) {
    static const char candidates[] = "\t;,";
    bool quoted = false, seen[3] = {false};
    for (; *line; line++) {
        const char *found = strchr(candidates, *line);
        quoted = quoted != (*line == '"');
        if (found && !quoted) {
            seen[found - candidates] = true;
        }
    }
    for (int i = 0; i < 3; i++) {
        if (seen[i]) {
            return candidates[i];
        }
    }
    return ' ';
}

/* Takes the quotes off a field at `p`, which begins with one. Returns what follows the last, NULL where
 * there is none. */
static char *unquote(char *p) {
    char *to = p;
    for (char *from = p + 1; *from; from++) {
        if (*from == '"' && from[1] != '"') {
            *to = '\0';
            return from + 1;
        }
        from += *from == '"';
        *to++ = *from;
    }
    return NULL;
}

/* Cuts the line into fields. */
static btf_result split(enc_csv *csv, char *line) {
    const char delimiter = csv->delimiter;
    csv->count = 0;
    for (char *p = line;;) {
        while (*p == ' ' || (*p == '\t' && delimiter != '\t')) {
            p++;
        }
        if (!*p && (delimiter == ' ' || csv->count == 0)) {
            return BTF_OK;
        }
        if (csv->count == ENC_CSV_MAX_FIELDS) {
            return enc_csv_fail(csv, "more than %d fields", ENC_CSV_MAX_FIELDS);
        }
        char *field = p, *end;
        if (*p == '"') {
            if (!(p = unquote(p))) {
                return enc_csv_fail(csv, "a quote is not closed");
            }
            while (*p == ' ') {
                p++;
            }
            if (*p && *p != delimiter && !(delimiter == ' ' && p[-1] == ' ')) {
                return enc_csv_fail(csv, "'%.40s' follows a quoted field", p);
            }
            end = NULL;
        } else {
            end = p += delimiter == ' ' ? strcspn(p, " \t") : strcspn(p, (char[]){delimiter, '\0'});
        }
        csv->fields[csv->count++] = field;
        const bool last = !*p;
        const bool at_next = delimiter == ' ' && !end; /* the blanks after the field were skipped already */
        p += last || at_next ? 0 : 1;
        while (end && end > field && is_blank(end[-1])) {
            end--;
        }
        if (end) {
            *end = '\0';
        }
        if (last) {
            return BTF_OK;
        }
    }
}

btf_result enc_csv_next(enc_csv *csv, bool *out_more) {
    *out_more = false;
    for (char *line; (line = text_line(&csv->text));) {
        line += strspn(line, " ");
        csv->is_comment = *line == '#';
        line += csv->is_comment ? strspn(line, "# ") : 0;
        if (!csv->delimiter && !csv->is_comment && strncasecmp(line, "sep=", 4) == 0 && line[4] &&
            !line[5] && strchr("\t;,", line[4])) {
            csv->delimiter = line[4];
            continue;
        }
        const char before = csv->delimiter;
        if (!line[strspn(line, " \t")] || (csv->is_comment && strchr(line, '"'))) {
            continue;
        }
        if (!csv->delimiter) {
            csv->delimiter = find_delimiter(line);
        }
        const btf_result result = split(csv, line);
        if (csv->is_comment) {
            csv->delimiter = before;
        }
        if (result != BTF_OK) {
            return result;
        }
        while (csv->count > 0 && !csv->fields[csv->count - 1][0]) {
            csv->count--;
        }
        if (csv->count == 0) {
            continue;
        }
        *out_more = true;
        return BTF_OK;
    }
    return BTF_OK;
}
