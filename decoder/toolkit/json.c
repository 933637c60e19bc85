/* A small JSON writer.
 *
 * SPDX-License-Identifier: MIT
 */
#include "json.h"
#include <assert.h>
#include <inttypes.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void append(json *j, const char *text, size_t length) {
    if (j->failed) {
        return;
    }
    if (j->length + length + 1 > j->capacity) {
        size_t capacity = 2 * j->capacity + length + 256;
        char *grown = realloc(j->text, capacity);
        if (!grown) {
            j->failed = true;
            return;
        }
        j->text = grown;
        j->capacity = capacity;
    }
    memcpy(j->text + j->length, text, length);
    j->length += length;
    j->text[j->length] = 0;
}

static void append_text(json *j, const char *text) {
    append(j, text, strlen(text));
}

static void indent(json *j) {
    append_text(j, "\n");
    for (int i = 0; i < j->depth; i++) {
        append_text(j, "  ");
    }
}

/* Length of the UTF-8 sequence at s, 0 when it is none (overlong forms and surrogates included). */
static size_t utf8_length(const unsigned char *s) {
    if (s[0] < 0x80) {
        return 1;
    }
    size_t n = s[0] >= 0xC2 && s[0] <= 0xDF   ? 2
               : s[0] >= 0xE0 && s[0] <= 0xEF ? 3
               : s[0] >= 0xF0 && s[0] <= 0xF4 ? 4
                                              : 0;
    for (size_t i = 1; i < n; i++) {
        if ((s[i] & 0xC0) != 0x80) {
            return 0;
        }
    }
    if ((s[0] == 0xE0 && s[1] < 0xA0) || (s[0] == 0xED && s[1] > 0x9F) || (s[0] == 0xF0 && s[1] < 0x90) ||
        (s[0] == 0xF4 && s[1] > 0x8F)) {
        return 0;
    }
    return n;
}

static void append_quoted(json *j, const char *value) {
    append_text(j, "\"");
    for (const unsigned char *s = (const unsigned char *)value; *s;) {
        char escaped[8];
        size_t n = utf8_length(s);
        if (*s == '"' || *s == '\\') {
            escaped[0] = '\\';
            escaped[1] = (char)*s;
            append(j, escaped, 2);
        } else if (*s == '\n') {
            append_text(j, "\\n");
        } else if (*s == '\t') {
            append_text(j, "\\t");
        } else if (*s < 0x20 || *s == 0x7F) {
            snprintf(escaped, sizeof escaped, "\\u%04x", *s);
            append_text(j, escaped);
        } else if (n == 0) {
            append_text(j, "\xEF\xBF\xBD");
        } else {
            append(j, (const char *)s, n);
        }
        s += n ? n : 1;
    }
    append_text(j, "\"");
}

/* Writes the text before a value: comma, line, name. */
static void begin_value(json *j, const char *key) {
    if (j->depth > 0) {
        const int top = j->depth - 1;
        assert((j->kind[top] == '{') == (key != NULL));
        if (j->filled[top]) {
            append_text(j, ",");
        }
        j->filled[top] = true;
        indent(j);
    } else {
        assert(key == NULL && j->length == 0);
    }
    if (key) {
        append_quoted(j, key);
        append_text(j, ": ");
    }
}

static void open_value(json *j, const char *key, char kind) {
    assert(j->depth < JSON_MAX_DEPTH);
    begin_value(j, key);
    append(j, &kind, 1);
    j->kind[j->depth] = kind;
    j->filled[j->depth++] = false;
}

void json_object(json *j, const char *key) {
    open_value(j, key, '{');
}

void json_array(json *j, const char *key) {
    open_value(j, key, '[');
}

void json_end(json *j) {
    assert(j->depth > 0);
    j->depth--;
    if (j->filled[j->depth]) {
        indent(j);
    }
    append_text(j, j->kind[j->depth] == '{' ? "}" : "]");
}

void json_string(json *j, const char *key, const char *value) {
    begin_value(j, key);
    if (value) {
        append_quoted(j, value);
    } else {
        append_text(j, "null");
    }
}

/* Writes the shortest of the texts with `low` to `high` digits that reads back as the value. */
static void append_shortest(json *j, double value, int low, int high, bool single) {
    char text[40];
    for (int digits = low; digits <= high; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (single ? strtof(text, NULL) == (float)value : strtod(text, NULL) == value) {
            break;
        }
    }
    const char *point = localeconv()->decimal_point;
    char *at = strcmp(point, ".") ? strstr(text, point) : NULL;
    if (at) {
        *at = '.';
        memmove(at + 1, at + strlen(point), strlen(at + strlen(point)) + 1);
    }
    append_text(j, text);
}

void json_number(json *j, const char *key, double value) {
    begin_value(j, key);
    if (isfinite(value)) {
        append_shortest(j, value, 6, 17, false);
    } else {
        append_text(j, "null");
    }
}

void json_float(json *j, const char *key, float value) {
    begin_value(j, key);
    if (isfinite(value)) {
        append_shortest(j, (double)value, 6, 9, true);
    } else {
        append_text(j, "null");
    }
}

void json_integer(json *j, const char *key, int64_t value) {
    char text[24];
    begin_value(j, key);
    snprintf(text, sizeof text, "%" PRId64, value);
    append_text(j, text);
}

void json_bool(json *j, const char *key, bool value) {
    begin_value(j, key);
    append_text(j, value ? "true" : "false");
}

void json_null(json *j, const char *key) {
    begin_value(j, key);
    append_text(j, "null");
}

const char *json_text(json *j) {
    assert(j->depth == 0);
    if (j->length && j->text[j->length - 1] != '\n') {
        append_text(j, "\n");
    }
    return j->failed ? NULL : j->text;
}

void json_free(json *j) {
    free(j->text);
    *j = (json){0};
}
