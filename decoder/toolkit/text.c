/* Text files as people's programs write them. See text.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "text.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool begins(const char *data, size_t size, const char *mark, size_t length) {
    return size >= length && memcmp(data, mark, length) == 0;
}

const char *text_encoding(const char *data, size_t size, size_t *out_skip) {
    *out_skip = begins(data, size, "\xef\xbb\xbf", 3) ? 3 : 0;
    if (begins(data, size, "\xff\xfe\0\0", 4) || begins(data, size, "\0\0\xfe\xff", 4)) {
        return "UTF-32";
    }
    if (begins(data, size, "\xff\xfe", 2) || begins(data, size, "\xfe\xff", 2)) {
        return "UTF-16";
    }
    if (size >= 4 &&
        ((data[0] && !data[1] && data[2] && !data[3]) || (!data[0] && data[1] && !data[2] && data[3]))) {
        return "UTF-16";
    }
    return NULL;
}

static btf_result refuse(const btf_log *log, btf_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static btf_result refuse(const btf_log *log, btf_result result, const char *format, ...) {
    char message[1200];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (log && log->callback) {
        log->callback(log->user, BTF_LOG_ERROR, message);
    }
    return result;
}

/* All bytes of a file, and a NUL behind them. */
static btf_result read_all(const char *path, FILE *file, size_t most, const btf_log *log, text_file *text) {
    size_t room = 1 << 14;
    do {
        room *= 2;
        char *grown = realloc(text->data, room);
        if (!grown) {
            return refuse(log, BTF_ERROR_MEMORY, "%s: out of memory for %zu bytes", path, room);
        }
        text->data = grown;
        text->size += fread(grown + text->size, 1, room - 1 - text->size, file);
        if (text->size > most) {
            return refuse(log, BTF_ERROR_UNSUPPORTED,
                          "%s: the file is larger than %zu bytes, the most that is read", path, most);
        }
    } while (text->size == room - 1);
    if (ferror(file)) {
        return refuse(log, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    text->data[text->size] = '\0';
    return BTF_OK;
}

btf_result text_read(const char *path, size_t most, const btf_log *log, text_file *out_text) {
    *out_text = (text_file){.data = NULL};
    FILE *file = fopen(path, "r");
    if (!file) {
        return refuse(log, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    btf_result result = read_all(path, file, most, log, out_text);
    fclose(file);
    if (result == BTF_OK) {
        const char *encoding = text_encoding(out_text->data, out_text->size, &out_text->at);
        if (encoding) {
            result =
                refuse(log, BTF_ERROR_UNSUPPORTED, "%s: the text is %s: save it as UTF-8", path, encoding);
        } else if (memchr(out_text->data, '\0', out_text->size)) {
            result =
                refuse(log, BTF_ERROR_BAD_FILE, "%s: not a text file: it holds bytes of value 0", path);
        }
    }
    if (result != BTF_OK) {
        text_free(out_text);
    }
    return result;
}

char *text_line(text_file *text) {
    if (text->at >= text->size) {
        return NULL;
    }
    char *line = text->data + text->at, *end = line + strcspn(line, "\r\n");
    text->number++;
    text->at = (size_t)(end - text->data) + (end[0] == '\r' && end[1] == '\n' ? 2 : 1);
    *end = '\0';
    return line;
}

void text_free(text_file *text) {
    free(text->data);
    *text = (text_file){.data = NULL};
}
