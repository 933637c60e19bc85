/* The words of a text in GLSL.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tokens.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

void btfi_tokens_add(btfi_tokens *t, btfi_token token) {
    if (t->failed) {
        return;
    }
    if (t->count == t->capacity) {
        size_t capacity = 2 * t->capacity + 32;
        btfi_token *grown = realloc(t->list, capacity * sizeof *grown);
        if (!grown) {
            t->failed = 1;
            return;
        }
        t->list = grown;
        t->capacity = capacity;
    }
    t->list[t->count++] = token;
}

void btfi_tokens_free(btfi_tokens *t) {
    free(t->list);
    memset(t, 0, sizeof *t);
}

int btfi_token_is(const btfi_token *token, const char *text) {
    return strlen(text) == token->length && memcmp(token->text, text, token->length) == 0;
}

int btfi_tokens_equal(const btfi_token *a, const btfi_token *b) {
    return a->length == b->length && memcmp(a->text, b->text, a->length) == 0;
}

static int is_letter(char c) {
    return isalpha((unsigned char)c) || c == '_';
}

static int is_digit(char c) {
    return isdigit((unsigned char)c) != 0;
}

/* The end of a number, and its kind. */
static const char *number_end(const char *p, btfi_token_kind *kind) {
    *kind = BTFI_TOKEN_INT;
    if (p[0] == '0' && (p[1] == 'x' || p[1] == 'X')) {
        p += 2;
        while (isxdigit((unsigned char)*p)) {
            ++p;
        }
    } else {
        while (is_digit(*p) || *p == '.') {
            *kind = *p == '.' ? BTFI_TOKEN_FLOAT : *kind;
            ++p;
        }
        if (*p == 'e' || *p == 'E') {
            *kind = BTFI_TOKEN_FLOAT;
            p += p[1] == '+' || p[1] == '-' ? 2 : 1;
            while (is_digit(*p)) {
                ++p;
            }
        }
    }
    if (*kind == BTFI_TOKEN_INT && (*p == 'u' || *p == 'U')) {
        *kind = BTFI_TOKEN_UINT;
        ++p;
    }
    return p;
}

static uint32_t mark_length(const char *p) {
    static const char *const marks[] = {"<<=", ">>=", "++", "--", "<<", ">>", "<=", ">=", "==", "!=",
                                        "&&",  "||",  "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^="};
    for (size_t i = 0; i < sizeof marks / sizeof *marks; ++i) {
        if (strncmp(p, marks[i], strlen(marks[i])) == 0) {
            return (uint32_t)strlen(marks[i]);
        }
    }
    return 1;
}

btfi_token btfi_read_token(btfi_reader *r, int within_line) {
    btfi_token t = {0};
    for (;;) {
        const char *p = r->at;
        if (*p == '\n') {
            if (within_line) {
                t.text = p;
                return t;
            }
            r->begins_line = 1;
            ++r->at;
        } else if (*p == '\\' && p[1] == '\n') {
            r->at += 2;
        } else if (*p == '\\' && p[1] == '\r' && p[2] == '\n') {
            r->at += 3;
        } else if (*p == ' ' || *p == '\t' || *p == '\r') {
            ++r->at;
        } else if (p[0] == '/' && p[1] == '/') {
            r->at += strcspn(p, "\n");
        } else if (p[0] == '/' && p[1] == '*') {
            const char *end = strstr(p + 2, "*/");
            r->at = end ? end + 2 : p + strlen(p);
            t.comment = p;
            t.comment_length = (uint32_t)(r->at - p);
        } else {
            break;
        }
    }
    t.text = r->at;
    if (*r->at == 0) {
        return t;
    }
    if (is_letter(*r->at)) {
        t.kind = BTFI_TOKEN_NAME;
        while (is_letter(*r->at) || is_digit(*r->at)) {
            ++r->at;
        }
    } else if (is_digit(*r->at) || (*r->at == '.' && is_digit(r->at[1]))) {
        r->at = number_end(r->at, &t.kind);
    } else if (*r->at == '#' && r->begins_line) {
        t.kind = BTFI_TOKEN_DIRECTIVE;
        ++r->at;
    } else {
        t.kind = BTFI_TOKEN_MARK;
        r->at += mark_length(r->at);
    }
    r->begins_line = 0;
    t.length = (uint32_t)(r->at - t.text);
    return t;
}
