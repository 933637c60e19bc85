/* Texts of PNG files. See png_text.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "png_text.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { MOST = 1 << 18 };

static size_t number_at(const unsigned char *p) {
    return (size_t)p[0] << 24 | (size_t)p[1] << 16 | (size_t)p[2] << 8 | p[3];
}

/* Inflates a text, as far as its data are sound and at most MOST bytes; NULL where that is nothing. */
static unsigned char *inflated(const unsigned char *data, size_t size, size_t *out_size) {
    unsigned char *text = malloc(MOST);
    z_stream z = {0};
    *out_size = 0;
    if (text && inflateInit(&z) == Z_OK) {
        z.next_in = (unsigned char *)(uintptr_t)data;
        z.avail_in = (uInt)size;
        z.next_out = text;
        z.avail_out = MOST;
        inflate(&z, Z_FINISH);
        *out_size = MOST - z.avail_out;
        inflateEnd(&z);
    }
    if (*out_size > 0) {
        return text;
    }
    free(text);
    return NULL;
}

static unsigned char *copied(const unsigned char *data, size_t size, size_t *out_size) {
    *out_size = size < MOST ? size : MOST;
    unsigned char *text = *out_size > 0 ? malloc(*out_size) : NULL;
    if (text) {
        memcpy(text, data, *out_size);
    }
    return text;
}

/* Skips a text with its end; false where it has none. */
static bool skip_string(const unsigned char **at, const unsigned char *end) {
    const unsigned char *zero = memchr(*at, 0, (size_t)(end - *at));
    *at = zero ? zero + 1 : end;
    return zero;
}

/* The text of one chunk, whose keyword ends before `at`. */
static unsigned char *text_of(const unsigned char *type, const unsigned char *at, const unsigned char *end,
                              size_t *out_size) {
    if (memcmp(type, "tEXt", 4) == 0) {
        return copied(at, (size_t)(end - at), out_size);
    }
    if (memcmp(type, "zTXt", 4) == 0) {
        return end - at > 1 ? inflated(at + 1, (size_t)(end - at) - 1, out_size) : NULL;
    }
    if (end - at < 2) {
        return NULL;
    }
    const bool packed = at[0] == 1;
    at += 2;
    if (!skip_string(&at, end) || !skip_string(&at, end)) { /* the language, the keyword in that language */
        return NULL;
    }
    return (packed ? inflated : copied)(at, (size_t)(end - at), out_size);
}

unsigned char *png_text_find(const unsigned char *data, size_t size, const char *keyword,
                             size_t *out_size) {
    const size_t key_size = strlen(keyword) + 1;
    for (size_t at = 8; at < size && size - at >= 12;) {
        const size_t length = number_at(data + at);
        const unsigned char *type = data + at + 4, *body = data + at + 8;
        if (length > size - at - 12) {
            return NULL;
        }
        if ((memcmp(type, "tEXt", 4) == 0 || memcmp(type, "zTXt", 4) == 0 ||
             memcmp(type, "iTXt", 4) == 0) &&
            length >= key_size && memcmp(body, keyword, key_size) == 0) {
            return text_of(type, body + key_size, body + length, out_size);
        }
        at += 12 + length;
    }
    return NULL;
}

static int digit_of(unsigned char c) {
    return c >= '0' && c <= '9' ? c - '0' : isxdigit(c) ? tolower(c) - 'a' + 10 : -1;
}

unsigned char *png_text_raw_profile(const unsigned char *data, size_t size, const char *kind,
                                    size_t *out_size) {
    char keyword[40];
    size_t length = 0, used = 0, at = 0;
    snprintf(keyword, sizeof keyword, "Raw profile type %s", kind);
    unsigned char *text = png_text_find(data, size, keyword, &length);
    /* the text begins with a line end, the kind and a line end, the number of bytes and a line end; then come lines of
     * digits */
    for (int lines = 0; text && at < length && lines < 3; at++) {
        lines += text[at] == '\n';
    }
    for (int high = -1; at < length; at++) {
        const int digit = digit_of(text[at]);
        if (digit < 0) {
            continue;
        }
        if (high >= 0) {
            text[used++] = (unsigned char)(high << 4 | digit);
        }
        high = high >= 0 ? -1 : digit;
    }
    *out_size = used;
    if (used > 0) {
        return text;
    }
    free(text);
    return NULL;
}
